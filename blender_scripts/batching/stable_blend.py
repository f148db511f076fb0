"""Takes out of a .blend file what differs from run to run: the memory addresses that stand for its pointers.

Blender up to 4.5 writes the addresses its data had in memory, and finds what belongs together by comparing them. Here
every address is replaced by a number, counted in the order of first appearance: a one-to-one renaming, so the file means the same, and
the same data give the same bytes. Knows the file format's own description of itself (block DNA1), and no Blender.
"""

import functools
import math
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

# What stands for an address: high enough to be no small count, a multiple of 16 as real addresses are.
FIRST_NUMBER = 1 << 40
NUMBER_STEP = 16
HEADER_SIZE = 12
BLOCK_HEADER = struct.Struct("<4siQii")


class UnknownLayoutError(Exception):
    """The file is not laid out as expected; it has been left as it was."""


@dataclass(frozen=True)
class Block:
    """One block of the file."""

    code: bytes
    start: int  # of its header
    size: int  # of its data
    address: int
    struct_index: int
    count: int

    @property
    def data(self) -> slice:
        return slice(self.start + BLOCK_HEADER.size, self.start + BLOCK_HEADER.size + self.size)


def stabilise_blend(path: Path, *, is_imported: bool) -> bool:
    """Rename the addresses in the file at `path`; False where there are none (newer formats number by themselves).

    is_imported : the meshes are new, and carry the second of their making as the seed of the face sets' colours: 0 then

    Raises UnknownLayoutError, and has changed nothing then.
    """
    data = np.fromfile(path, dtype=np.uint8)
    if data[:9].tobytes() != b"BLENDER-v":
        if data[:7].tobytes() == b"BLENDER":
            return False
        raise UnknownLayoutError("the file is compressed, or no .blend file")
    blocks = list_blocks(data)
    dna = next((block for block in blocks if block.code == b"DNA1"), None)
    if dna is None:
        raise UnknownLayoutError("the file does not describe its structs")
    layouts = describe_structs(data[dna.data].tobytes())
    rename_addresses(data, blocks, layouts)
    sort_screen_edges(data, blocks, layouts)
    if is_imported:
        for places in find_field(blocks, layouts, "Mesh", "face_sets_color_seed"):
            data[places : places + 4] = 0
    data.tofile(path)
    return True


def list_blocks(data: np.ndarray) -> list[Block]:
    """All blocks up to the end mark."""
    blocks, start, view = [], HEADER_SIZE, memoryview(data)
    while start + BLOCK_HEADER.size <= len(data):
        code, size, address, struct_index, count = BLOCK_HEADER.unpack_from(view, start)
        if size < 0 or start + BLOCK_HEADER.size + size > len(data):
            break
        blocks.append(Block(code, start, size, address, struct_index, count))
        if code == b"ENDB":
            return blocks
        start += BLOCK_HEADER.size + size
    raise UnknownLayoutError("the blocks do not end where the file does")


class StructLayouts:
    """Where the pointers are in each struct that the file describes."""

    def __init__(self, dna: bytes) -> None:
        self._dna = dna
        self._at = 8
        if dna[:8] != b"SDNANAME":
            raise UnknownLayoutError("the description of the structs has another form")
        self.names = self._read_strings()
        self._expect(b"TYPE")
        self.types = self._read_strings()
        self._expect(b"TLEN")
        self.lengths = self._read_shorts(len(self.types))
        self._at += self._at % 4
        self._expect(b"STRC")
        (count,) = struct.unpack_from("<i", dna, self._at)
        self._at += 4
        self.structs = []
        for _ in range(count):
            type_index, field_count = self._read_shorts(2)
            self.structs.append((type_index, self._read_shorts(2 * field_count).reshape(-1, 2)))
        self._struct_of_type = {int(t): k for k, (t, _) in enumerate(self.structs)}
        self._pointers: dict[int, tuple[list[int], list[int]]] = {}

    def _expect(self, word: bytes) -> None:
        self._at = (self._at + 3) & ~3
        if self._dna[self._at : self._at + 4] != word:
            raise UnknownLayoutError(f"the description of the structs lacks {word.decode()}")
        self._at += 4

    def _read_strings(self) -> list[str]:
        (count,) = struct.unpack_from("<i", self._dna, self._at)
        self._at += 4
        strings = []
        for _ in range(count):
            end = self._dna.index(b"\0", self._at)
            strings.append(self._dna[self._at : end].decode("ascii"))
            self._at = end + 1
        return strings

    def _read_shorts(self, count: int) -> np.ndarray:
        values = np.frombuffer(self._dna, dtype="<i2", count=count, offset=self._at).astype(np.int64)
        self._at += 2 * count
        return values

    def name(self, struct_index: int) -> str:
        """Of a struct."""
        return self.types[self.structs[struct_index][0]]

    def offset(self, struct_index: int, field: str) -> int:
        """Where a field begins, by its name as the file has it, with its stars and brackets."""
        offset = 0
        for type_index, name_index in self.structs[struct_index][1]:
            if self.names[name_index] == field:
                return offset
            offset += self._measure(int(type_index), self.names[name_index])
        raise UnknownLayoutError(f"{self.name(struct_index)} has no field {field}")

    def _measure(self, type_index: int, name: str) -> int:
        """Bytes of a field."""
        return (8 if name.startswith(("*", "(")) else int(self.lengths[type_index])) * count_repeats(name)

    def size(self, struct_index: int) -> int:
        """Bytes of one struct."""
        return int(self.lengths[self.structs[struct_index][0]])

    def pointers(self, struct_index: int) -> tuple[list[int], list[int]]:
        """Offsets of all pointers in the struct, nested ones too, and of those that point to arrays of pointers."""
        if struct_index not in self._pointers:
            plain, double, offset = [], [], 0
            for type_index, name_index in self.structs[struct_index][1]:
                name = self.names[name_index]
                repeat = count_repeats(name)
                if name.startswith(("*", "(")):
                    step = 8
                    offsets = [offset + step * k for k in range(repeat)]
                    plain += offsets
                    if name.startswith("**"):
                        double += offsets
                else:
                    step = int(self.lengths[type_index])
                    inner = self._struct_of_type.get(int(type_index))
                    if inner is not None:
                        inner_plain, inner_double = self.pointers(inner)
                        for k in range(repeat):
                            plain += [offset + step * k + at for at in inner_plain]
                            double += [offset + step * k + at for at in inner_double]
                offset += step * repeat
            if offset != self.size(struct_index):
                raise UnknownLayoutError(f"the fields of {self.types[self.structs[struct_index][0]]} do not add up")
            self._pointers[struct_index] = plain, double
        return self._pointers[struct_index]


def count_repeats(name: str) -> int:
    """How many elements a field has: the product of the numbers in brackets."""
    return math.prod(int(part.rstrip("]")) for part in name.split("[")[1:])


@functools.lru_cache(maxsize=4)
def describe_structs(dna: bytes) -> StructLayouts:
    """The layouts that a block DNA1 describes: the same for all files of one Blender."""
    return StructLayouts(dna)


def rename_addresses(data: np.ndarray, blocks: list[Block], layouts: StructLayouts) -> None:
    """Replace every address in `data`, in place."""
    places = [np.array([block.start + 8 for block in blocks], dtype=np.int64)]
    arrays_of_pointers = set()
    for block in blocks:
        if block.code in (b"DNA1", b"ENDB") or block.struct_index == 0:
            continue
        plain, double = layouts.pointers(block.struct_index)
        starts = block.data.start + layouts.size(block.struct_index) * np.arange(block.count, dtype=np.int64)
        if block.count and starts[-1] + layouts.size(block.struct_index) > block.data.stop:
            continue  # a block of another kind than it says, as Blender writes some; checked below
        places.append((starts[:, None] + np.array(plain, dtype=np.int64)).ravel())
        doubles = (starts[:, None] + np.array(double, dtype=np.int64)).ravel()
        arrays_of_pointers |= set(read_addresses(data, doubles).tolist())
    for block in blocks:
        if block.struct_index == 0 and block.address in arrays_of_pointers and block.address != 0:
            places.append(block.data.start + 8 * np.arange(block.size // 8, dtype=np.int64))
    ordered = np.unique(np.concatenate(places))
    addresses = read_addresses(data, ordered)
    refuse_missed_addresses(data, blocks, ordered)
    found, first = np.unique(addresses, return_index=True)
    rank = np.empty(len(found), dtype=np.uint64)
    rank[np.argsort(first)] = np.arange(len(found), dtype=np.uint64)
    numbers = np.where(found == 0, 0, FIRST_NUMBER + NUMBER_STEP * rank).astype("<u8")
    renamed = numbers[np.searchsorted(found, addresses)]
    data[ordered[:, None] + np.arange(8)] = renamed.view(np.uint8).reshape(-1, 8)


def read_addresses(data: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The 8-byte numbers at `places`."""
    return np.ascontiguousarray(data[places[:, None] + np.arange(8)]).view("<u8").ravel()


def refuse_missed_addresses(data: np.ndarray, blocks: list[Block], known: np.ndarray) -> None:
    """UnknownLayoutError where a block's address stands in a place that was not found to hold one."""
    own = np.unique([block.address for block in blocks if block.address != 0]).astype("<u8")
    for block in blocks:
        if block.code == b"DNA1" or block.size < 8:
            continue
        count = block.size // 8
        words = data[block.data.start : block.data.start + 8 * count].view("<u8")
        # Nearly all numbers are no addresses at all: the quick test first.
        suspects = np.flatnonzero((words >= own[0]) & (words <= own[-1]))
        suspects = suspects[np.isin(words[suspects], own)]
        if not np.isin(block.data.start + 8 * suspects, known).all():
            raise UnknownLayoutError(f"a block {block.code.decode('latin-1')} holds an address where none is described")


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
