"""What can be told of an input without opening it: there, readable, not empty, of the kind that its name says."""

from .plan import Item

HEAD_BYTES = 128
# Beginnings of files, by suffix; .obj has none, .stl is told by its size or by a word.
BEGINNINGS = {
    ".blend": (b"BLENDER", b"\x28\xb5\x2f\xfd", b"\x1f\x8b"),
    ".ply": (b"ply",),
    ".fbx": (b"Kaydara FBX Binary", b";", b"FBX"),
    ".glb": (b"glTF",),
    ".gltf": (b"{", b"\xef\xbb\xbf", b" ", b"\n", b"\r", b"\t"),
    ".usda": (b"#usda",),
    ".usdc": (b"PXR-USDC",),
    ".usdz": (b"PK",),
    ".usd": (b"#usda", b"PXR-USDC", b"PK"),
}


def find_fault(item: Item) -> tuple[str, str] | None:
    """Name of the error and message where the file will not do; None when nothing is wrong to be seen."""
    try:
        item.input.encode("utf-8")
    except UnicodeEncodeError:
        return "NameNotUnicodeError", "its name is not UTF-8, and Blender opens only files whose names are"
    try:
        with open(item.input, "rb") as file:
            head = file.read(HEAD_BYTES)
            size = file.seek(0, 2)
    except FileNotFoundError:
        return "MissingFileError", "there is no such file any more"
    except OSError as error:
        return "UnreadableFileError", f"cannot be read: {error.strerror}"
    if size == 0:
        return "EmptyFileError", "has no bytes at all"
    suffix = "." + item.input.rsplit(".", 1)[-1].lower()
    if suffix == ".stl":
        count = int.from_bytes(head[80:84], "little")
        if not head.lstrip().startswith(b"solid") and size < 84 + 50 * count:
            return "ImportFailedError", f"tells of {count} triangles, but ends after {size} bytes"
    elif suffix in BEGINNINGS and not head.startswith(BEGINNINGS[suffix]):
        return "ImportFailedError", f"does not begin like a {suffix} file"
    if b"\0" in head and suffix in (".obj", ".gltf", ".usda"):
        return "ImportFailedError", f"holds zero bytes, which no {suffix} file does"
    return None
