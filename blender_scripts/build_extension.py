"""Builds the Blender extension: the add-on's files and the library's wheels into one zip a platform, then checks it.

    python blender_scripts/build_extension.py --wheels dist/wheels --output dist

Runs in an environment with bpy, whose extension machinery (the same as `blender --command extension`) builds and
validates; needs no Blender program. Changes no file of the repository. Not imported by anything.
"""

import argparse
import re
import shutil
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path

import bpy  # noqa: F401  (the next lies inside it)

from bl_pkg.bl_extension_cli import cli_extension_handler

REPOSITORY = Path(__file__).resolve().parents[1]
ADDON = REPOSITORY / "addon"
MANIFEST = "blender_manifest.toml"
# Not for shipping: caches, and what editors and systems leave.
LEFT_OUT = shutil.ignore_patterns("__pycache__", "*.pyc", ".*", "wheels")
# End of a wheel's platform tag -> Blender's name of the platform.
PLATFORMS = {
    r"linux_x86_64|manylinux.*_x86_64": "linux-x64",
    r"manylinux.*_aarch64": "linux-arm64",
    r"win_amd64": "windows-x64",
    r"win_arm64": "windows-arm64",
    r"macosx_.*_arm64": "macos-arm64",
    r"macosx_.*_x86_64": "macos-x64",
}


class BuildError(Exception):
    """Why there is no extension; shown as it is."""


def read_version() -> str:
    """The one version: Cargo's, which the manifest must repeat."""
    cargo = tomllib.loads((REPOSITORY / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["version"]
    manifest = tomllib.loads((ADDON / MANIFEST).read_text(encoding="utf-8"))["version"]
    if cargo != manifest:
        raise BuildError(f"Cargo.toml has version {cargo}, but addon/{MANIFEST} has {manifest}; make them equal")
    return cargo


def find_wheels(folder: Path, version: str) -> dict[str, Path]:
    """One wheel for each platform; all of this version and good for every Python from 3.11 on."""
    wheels: dict[str, Path] = {}
    for path in sorted(folder.glob("*.whl")):
        name, found_version, python, abi, tag = path.stem.split("-")
        if (name, found_version, python, abi) != ("smooth_polylines", version, "cp311", "abi3"):
            raise BuildError(f"{path.name} is not smooth_polylines {version} for cp311-abi3; build the wheel again")
        platform = next((p for pattern, p in PLATFORMS.items() if re.fullmatch(pattern, tag)), None)
        if platform is None:
            raise BuildError(f"{path.name} is for a platform that Blender does not load wheels for")
        if platform in wheels:
            raise BuildError(f"{path.name} and {wheels[platform].name} are both for {platform}; keep one of them")
        wheels[platform] = path
    if not wheels:
        raise BuildError(f"there is no wheel in {folder}; build it first (make wheel)")
    return wheels


def stage_sources(stage: Path, wheels: dict[str, Path]) -> None:
    """The folder that Blender packs: the add-on, its wheels, and a manifest that names them."""
    shutil.copytree(ADDON, stage, ignore=LEFT_OUT)
    (stage / "wheels").mkdir()
    for wheel in wheels.values():
        shutil.copy2(wheel, stage / "wheels")
    listed = "".join(f'    "./wheels/{wheel.name}",\n' for wheel in wheels.values())
    platforms = ", ".join(f'"{platform}"' for platform in wheels)
    with (stage / MANIFEST).open("a", encoding="utf-8") as manifest:
        manifest.write(f"\nplatforms = [{platforms}]\nwheels = [\n{listed}]\n")


def run_blender_command(*arguments: str) -> None:
    """One command of Blender's extension tool; BuildError when it refuses."""
    if cli_extension_handler(list(arguments)) != 0:
        raise BuildError(f"Blender's extension tool refused: extension {' '.join(arguments)} (its message is above)")


def check_zip(path: Path, stage: Path, wheel: Path) -> None:
    """The zip holds every file of the add-on, byte for byte, its own wheel with the library in it, and nothing else."""
    expected = {p.relative_to(stage).as_posix(): p for p in stage.rglob("*") if p.is_file() and p.suffix != ".whl"}
    expected[f"wheels/{wheel.name}"] = wheel
    with zipfile.ZipFile(path) as archive:
        found = {name for name in archive.namelist() if not name.endswith("/")}
        if found != set(expected):
            raise BuildError(f"{path.name}: missing {set(expected) - found}, unexpected {found - set(expected)}")
        for name, source in expected.items():
            # The tool writes a manifest of its own: each platform's names its own wheel only.
            if name != MANIFEST and archive.read(name) != source.read_bytes():
                raise BuildError(f"{path.name}: {name} is not what it should be")
        manifest = tomllib.loads(archive.read(MANIFEST).decode("utf-8"))
    listed = manifest.get("build", {}).get("generated", manifest)["wheels"]
    if [Path(entry).name for entry in listed] != [wheel.name]:
        raise BuildError(f"{path.name}: its manifest names the wheels {listed}, not {wheel.name}")
    with zipfile.ZipFile(wheel) as archive:
        if not any(re.fullmatch(r"smooth_polylines/_native\.(abi3\.so|pyd)", name) for name in archive.namelist()):
            raise BuildError(f"{wheel.name} does not hold the compiled library")


def build_extension(wheel_folder: Path, output: Path) -> list[Path]:
    """Build, validate and open the zips; their paths."""
    version = read_version()
    wheels = find_wheels(wheel_folder, version)
    output.mkdir(parents=True, exist_ok=True)
    zips = []
    with tempfile.TemporaryDirectory() as folder:
        stage = Path(folder) / "smooth_polylines"
        stage_sources(stage, wheels)
        run_blender_command("build", "--source-dir", str(stage), "--output-dir", str(output), "--split-platforms")
        for platform, wheel in wheels.items():
            path = output / f"smooth_polylines-{version}-{platform.replace('-', '_')}.zip"
            if not path.is_file():
                raise BuildError(f"Blender's extension tool made no {path.name}")
            run_blender_command("validate", str(path))
            check_zip(path, stage, wheel)
            zips.append(path)
    return zips


def main() -> int:
    """0 and the paths of the zips, or 1 and the reason."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wheels", type=Path, required=True, help="folder with one wheel for each platform")
    parser.add_argument("--output", type=Path, required=True, help="folder for the zips")
    arguments = parser.parse_args()
    try:
        zips = build_extension(arguments.wheels, arguments.output)
    except BuildError as error:
        print(f"No extension: {error}", file=sys.stderr)
        return 1
    for path in zips:
        print(f"Built and validated {path} ({path.stat().st_size / 1e6:.2f} MB)")
        print("Install it: Blender > Edit > Preferences > Get Extensions > Install from Disk")
    return 0


if __name__ == "__main__":
    sys.exit(main())
