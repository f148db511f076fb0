"""How a .blend file is laid out: its blocks, and the structs that it describes in its block DNA1.

Reads only; knows what no struct is for.
"""

import functools
import math
import struct
from dataclasses import dataclass

import numpy as np

# The beginning of files up to Blender 4.5 and from 5.0 on, its length, and how a block's header is laid out there.
OLD_BEGIN, NEW_BEGIN = b"BLENDER-v", b"BLENDER17-01v"
OLD_HEADER, NEW_HEADER = struct.Struct("<4siQii"), struct.Struct("<4siQqq")
OLD_SIZE, NEW_SIZE = 12, 17
ADDRESS_IN_HEADER = 8


class UnknownLayoutError(Exception):
    """The file is not laid out as expected; it has been left as it was."""


@dataclass(frozen=True)
class Block:
    """One block of the file."""

    code: bytes
    start: int  # of its header
    data_start: int
    size: int  # of its data
    address: int
    struct_index: int
    count: int

    @property
    def data(self) -> slice:
        """Where its data lie in the file."""
        return slice(self.data_start, self.data_start + self.size)


def is_new(data: np.ndarray) -> bool:
    """Whether the file is as Blender 5.0 and newer write it; UnknownLayoutError where it is neither that nor older."""
    begin = data[:NEW_SIZE].tobytes()
    if begin.startswith(NEW_BEGIN):
        return True
    if begin.startswith(OLD_BEGIN):
        return False
    raise UnknownLayoutError("the file is compressed, of a newer kind, or no .blend file")


def list_blocks(data: np.ndarray) -> list[Block]:
    """All blocks up to the end mark."""
    header, start = (NEW_HEADER, NEW_SIZE) if is_new(data) else (OLD_HEADER, OLD_SIZE)
    blocks, view = [], memoryview(data)
    while start + header.size <= len(data):
        code, one, address, two, count = header.unpack_from(view, start)
        size, struct_index = (two, one) if header is NEW_HEADER else (one, two)
        data_start = start + header.size
        if size < 0 or data_start + size > len(data):
            break
        blocks.append(Block(code, start, data_start, size, address, struct_index, count))
        if code == b"ENDB":
            return blocks
        start = data_start + size
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
        self._texts: dict[int, list[int]] = {}

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

    def find(self, name: str) -> int:
        """The struct of that name."""
        for index in range(len(self.structs)):
            if self.name(index) == name:
                return index
        raise UnknownLayoutError(f"the file describes no {name}")

    def has(self, struct_index: int, field: str) -> bool:
        """Whether the struct has a field of that name."""
        return any(self.names[name_index] == field for _, name_index in self.structs[struct_index][1])

    def is_data_block(self, struct_index: int) -> bool:
        """Whether it begins as all data-blocks do, with an ID."""
        fields = self.structs[struct_index][1]
        return len(fields) > 0 and self.types[fields[0][0]] == "ID" and self.names[fields[0][1]] == "id"

    def text_pointers(self, struct_index: int) -> list[int]:
        """Offsets of the struct's own pointers to characters."""
        if struct_index not in self._texts:
            offsets, offset = [], 0
            for type_index, name_index in self.structs[struct_index][1]:
                name = self.names[name_index]
                if self.types[type_index] == "char" and name.startswith("*") and not name.startswith("**"):
                    offsets.append(offset)
                offset += self._measure(int(type_index), name)
            self._texts[struct_index] = offsets
        return self._texts[struct_index]

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
