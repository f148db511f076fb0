"""Takes out of a .blend file what differs from run to run, so that the same data give the same bytes.

Blender up to 4.5 writes the addresses its data had in memory, and finds what belongs together by comparing them. Here
every address is replaced by a number, counted in the order of first appearance: a one-to-one renaming, so the file
means the same. What else is left over of a session goes: states of data-blocks, and bytes behind the end of texts and
arrays. Blender 5.0 and newer number by themselves, but for all data-blocks at once, which chance can upset: see
`rename_addresses`.
"""

import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from .blend_layout import (
    ADDRESS_IN_HEADER,
    Block,
    StructLayouts,
    UnknownLayoutError,
    describe_structs,
    is_new,
    list_blocks,
)

# What stands for an address: high enough to be no small count, a multiple of 16 as real addresses are.
FIRST_NUMBER = 1 << 40
NUMBER_STEP = 16
# Below this a number in a file can be anything: addresses are above, but for a few that Blender 5 numbers from 16 on.
LEAST_ADDRESS = 1 << 32
TEXT_PROPERTY = 0  # IDP_STRING
# What of a data-block is still to be evaluated: on opening a file Blender evaluates all of it. Importers tag the window
# manager, and whether a tag is still there depends on what the process did before.
PENDING_UPDATES = ("recalc", "recalc_up_to_undo_push", "recalc_after_undo_push")
# Kinds of mesh attributes with one byte an element: CD_PROP_INT8 and CD_PROP_BOOL.
BYTE_LAYERS = (45, 50)


def stabilise_blend(path: Path, *, is_imported: bool) -> None:
    """Make the bytes of the file at `path` depend on its content alone.

    is_imported : its data are new: what their making took from the clock goes too

    Raises UnknownLayoutError, and has changed nothing then.
    """
    data = np.fromfile(path, dtype=np.uint8)
    blocks = list_blocks(data)
    dna = next((block for block in blocks if block.code == b"DNA1"), None)
    if dna is None:
        raise UnknownLayoutError("the file does not describe its structs")
    layouts = describe_structs(data[dna.data].tobytes())
    if not is_new(data):
        clear_padding(data, blocks, layouts)
    clear_session(data, blocks, layouts)
    rename_addresses(data, blocks, layouts)
    sort_screen_edges(data, blocks, layouts)
    if is_imported:
        for place in find_field(blocks, layouts, "Mesh", "face_sets_color_seed"):
            data[place : place + 4] = 0
        number_nodes(data, blocks, layouts)
    data.tofile(path)


def number_nodes(data: np.ndarray, blocks: list[Block], layouts: StructLayouts) -> None:
    """Nodes of materials get numbers in order instead of random ones, unless something refers to a node by number."""
    if any(layouts.name(block.struct_index) == "bNestedNodeRef" for block in blocks):
        return
    for number, place in enumerate(find_field(blocks, layouts, "bNode", "identifier"), start=1):
        data[place : place + 4] = np.array([number], dtype="<i4").view(np.uint8)


def rename_addresses(data: np.ndarray, blocks: list[Block], layouts: StructLayouts) -> None:
    """Replace every address in `data`, in place.

    Blender looks for what a pointer means among the blocks of the same data-block, then among all data-blocks, so
    numbers are given data-block by data-block: memory that was given back and used again while the file was written has
    the same address in two of them, or not, as chance will have it.
    """
    sections = list_sections(blocks)
    places = [find_pointers(data, section, layouts) for section in sections]
    refuse_missed_addresses(data, blocks, np.unique(np.concatenate(places)))
    numbers = itertools.count(FIRST_NUMBER, NUMBER_STEP)
    own = [number_blocks(section, numbers) for section in sections]
    # Data-blocks, also those within others, can be pointed to from everywhere; some of the windows' data are as well.
    known: dict[int, int] = {}
    for is_data_block in (True, False):
        for section, given in zip(sections, own, strict=True):
            for block in section:
                if (block.code != b"DATA" or layouts.is_data_block(block.struct_index)) == is_data_block:
                    known.setdefault(block.address, given[block.address])
    for ordered, given in zip(places, own, strict=True):
        addresses = read_addresses(data, ordered)
        found, first = np.unique(addresses, return_index=True)
        for k in np.argsort(first).tolist():
            address = int(found[k])
            if address not in given:
                # What is not in the file keeps a number too: whether it is there at all can matter.
                given[address] = known.get(address) or next(numbers)
        renamed = np.array([given[int(address)] for address in found], dtype="<u8")[np.searchsorted(found, addresses)]
        data[ordered[:, None] + np.arange(8)] = renamed.view(np.uint8).reshape(-1, 8)


def list_sections(blocks: list[Block]) -> list[list[Block]]:
    """Each data-block, and whatever else is no mere data, with the data that belong to it."""
    sections: list[list[Block]] = []
    for block in blocks:
        if block.code != b"DATA" or not sections:
            sections.append([])
        sections[-1].append(block)
    return sections


def number_blocks(section: list[Block], numbers: Iterator[int]) -> dict[int, int]:
    """The number of each block's address; no address stays none."""
    given = {0: 0}
    for block in section:
        if block.address not in given:
            given[block.address] = next(numbers)
    return given


def find_pointers(data: np.ndarray, section: list[Block], layouts: StructLayouts) -> np.ndarray:
    """Where addresses are in these blocks, in order."""
    places = [np.array([block.start + ADDRESS_IN_HEADER for block in section], dtype=np.int64)]
    arrays_of_pointers = set()
    for block in section:
        if block.code in (b"DNA1", b"ENDB") or block.struct_index == 0:
            continue
        plain, double = layouts.pointers(block.struct_index)
        starts = block.data.start + layouts.size(block.struct_index) * np.arange(block.count, dtype=np.int64)
        if block.count and starts[-1] + layouts.size(block.struct_index) > block.data.stop:
            continue  # a block of another kind than it says, as Blender writes some; checked later
        places.append((starts[:, None] + np.array(plain, dtype=np.int64)).ravel())
        doubles = (starts[:, None] + np.array(double, dtype=np.int64)).ravel()
        arrays_of_pointers |= set(read_addresses(data, doubles).tolist())
    for block in section:
        if block.struct_index == 0 and block.address in arrays_of_pointers and block.address != 0:
            places.append(block.data.start + 8 * np.arange(block.size // 8, dtype=np.int64))
    return np.unique(np.concatenate(places))


def read_addresses(data: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The 8-byte numbers at `places`."""
    return np.ascontiguousarray(data[places[:, None] + np.arange(8)]).view("<u8").ravel()


def refuse_missed_addresses(data: np.ndarray, blocks: list[Block], known: np.ndarray) -> None:
    """UnknownLayoutError where a block's address stands in a place that was not found to hold one.

    known : places that hold addresses, in order
    """
    own = np.unique([block.address for block in blocks if block.address >= LEAST_ADDRESS]).astype("<u8")
    if len(own) == 0:
        return
    starts = np.array([block.data.start for block in blocks], dtype=np.int64)
    for phase in (0, 4):  # blocks begin at multiples of 4
        words = data[phase : phase + 8 * ((len(data) - phase) // 8)].view("<u8")
        # Nearly all numbers are no addresses at all: the quick test first.
        suspects = np.flatnonzero((words >= own[0]) & (words <= own[-1]))
        suspects = suspects[is_among(words[suspects], own)]
        places = phase + 8 * suspects.astype(np.int64)
        places = places[~is_among(places, known)]
        holders = np.searchsorted(starts, places, side="right") - 1
        for place, holder in zip(places.tolist(), holders.tolist(), strict=True):
            block = blocks[holder]
            if block.code != b"DNA1" and place < block.data.stop and (place - block.data.start) % 8 == 0:
                raise UnknownLayoutError(
                    f"a block {block.code.decode('latin-1')} holds an address that is not described"
                )


def is_among(values: np.ndarray, ordered: np.ndarray) -> np.ndarray:
    """Which values are in the sorted array."""
    return ordered[np.minimum(np.searchsorted(ordered, values), len(ordered) - 1)] == values


def find_field(blocks: list[Block], layouts: StructLayouts, struct_name: str, field: str) -> list[int]:
    """Where a field begins, in all structs of that name that are blocks of their own."""
    places = []
    for block in blocks:
        if block.code == b"DNA1" or layouts.name(block.struct_index) != struct_name:
            continue
        offset = layouts.offset(block.struct_index, field)
        size = layouts.size(block.struct_index)
        places += [block.data.start + size * k + offset for k in range(block.count)]
    return places


def sort_screen_edges(data: np.ndarray, blocks: list[Block], layouts: StructLayouts) -> None:
    """The two ends of an edge of the window's layout, which Blender keeps in the order of their addresses."""
    firsts = find_field(blocks, layouts, "ScrEdge", "*v1")
    seconds = find_field(blocks, layouts, "ScrEdge", "*v2")
    for first, second in zip(firsts, seconds, strict=True):
        ends = data[first : first + 8].copy(), data[second : second + 8].copy()
        if ends[0].view("<u8")[0] > ends[1].view("<u8")[0]:
            data[first : first + 8], data[second : second + 8] = ends[1], ends[0]


def clear_session(data: np.ndarray, blocks: list[Block], layouts: StructLayouts) -> None:
    """What data-blocks and the window manager keep of the session and Blender sets anew on reading."""
    inner = layouts.find("ID")
    counter = layouts.offset(inner, "session_uid" if layouts.has(inner, "session_uid") else "session_uuid")
    cleared = [(counter, 4)]
    cleared += [(layouts.offset(inner, field), 4) for field in PENDING_UPDATES if layouts.has(inner, field)]
    if layouts.has(inner, "runtime"):
        cleared.append((layouts.offset(inner, "runtime"), layouts.size(layouts.find("ID_Runtime"))))
    for block in blocks:
        if block.code != b"DNA1" and layouts.is_data_block(block.struct_index):
            for offset, size in cleared:
                data[block.data.start + offset : block.data.start + offset + size] = 0
    for place in find_field(blocks, layouts, "wmWindowManager", "outliner_sync_select_dirty"):
        data[place : place + 2] = 0
    # Timers, operators and the like, which are not in the file.
    own = np.unique([block.address for block in blocks]).astype("<u8")
    for block in blocks:
        if layouts.name(block.struct_index) == "wmWindowManager":
            places = block.data.start + np.array(layouts.pointers(block.struct_index)[0], dtype=np.int64)
            for place in places[~is_among(read_addresses(data, places), own)].tolist():
                data[place : place + 8] = 0


def clear_padding(data: np.ndarray, blocks: list[Block], layouts: StructLayouts) -> None:
    """Blocks are rounded up to 4 bytes with whatever lay behind in memory: zero, where the true length is known."""
    by_address = {block.address: block for block in blocks if block.struct_index == 0}
    for address in find_texts(data, blocks, layouts):
        block = by_address.get(address)
        if block is not None:
            ends = np.flatnonzero(data[block.data] == 0)
            if len(ends) and ends[0] >= block.size - 4:
                data[block.data.start + int(ends[0]) : block.data.stop] = 0
    for address, count in find_byte_layers(data, blocks, layouts):
        block = by_address.get(address)
        if block is not None and block.size - 4 < count < block.size:
            data[block.data.start + count : block.data.stop] = 0


def find_texts(data: np.ndarray, blocks: list[Block], layouts: StructLayouts) -> list[int]:
    """Addresses of texts: what pointers to characters point to, and properties that are texts."""
    places: list[int] = []
    for block in blocks:
        if block.code == b"DNA1" or block.struct_index == 0:
            continue
        size = layouts.size(block.struct_index)
        for offset in layouts.text_pointers(block.struct_index):
            places += [block.data.start + size * k + offset for k in range(block.count)]
    kinds = find_field(blocks, layouts, "IDProperty", "type")
    values = find_field(blocks, layouts, "IDProperty", "data")
    places += [value for kind, value in zip(kinds, values, strict=True) if data[kind] == TEXT_PROPERTY]
    return read_addresses(data, np.array(places, dtype=np.int64)).tolist()


def find_byte_layers(data: np.ndarray, blocks: list[Block], layouts: StructLayouts) -> list[tuple[int, int]]:
    """Address and number of elements of the meshes' attributes with one byte an element."""
    layers_at = {block.address: block for block in blocks if layouts.name(block.struct_index) == "CustomDataLayer"}
    if not layers_at:
        return []
    layer = layouts.find("CustomDataLayer")
    kind, values = layouts.offset(layer, "type"), layouts.offset(layer, "*data")
    found = []
    for custom_data, total in (("vdata", "totvert"), ("edata", "totedge"), ("pdata", "totpoly"), ("ldata", "totloop")):
        for where, count_at in zip(
            find_field(blocks, layouts, "Mesh", custom_data), find_field(blocks, layouts, "Mesh", total), strict=True
        ):
            count = int(data[count_at : count_at + 4].view("<i4")[0])
            block = layers_at.get(int(data[where : where + 8].view("<u8")[0]))
            for k in range(block.count if block is not None else 0):
                start = block.data.start + layouts.size(layer) * k
                if int(data[start + kind : start + kind + 4].view("<i4")[0]) in BYTE_LAYERS:
                    found.append((int(data[start + values : start + values + 8].view("<u8")[0]), count))
    return found
