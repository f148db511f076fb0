"""Makes a repository of extensions out of the zips: a folder for any web server, with the index that Blender reads.

    python blender_scripts/build_repository.py --zips dist --output dist/repository

Runs in an environment with bpy, whose extension machinery writes the index. A user adds the folder's address in Blender
(Preferences > Get Extensions > Repositories > Add Remote Repository) and gets updates from there. Nothing imports it.
"""

import argparse
import hashlib
import json
import shutil
import sys
from pathlib import Path

import build_extension

INDEX = "index.json"


def build_repository(zips: list[Path], output: Path) -> list[dict]:
    """Copy the zips into `output` and index them; the entries of the index, checked against the zips."""
    if not zips:
        raise build_extension.BuildError("there is no zip to put into a repository; build it first (make extension)")
    output.mkdir(parents=True, exist_ok=True)
    for old in [*output.glob("*.zip"), output / INDEX]:
        old.unlink(missing_ok=True)
    for path in zips:
        shutil.copy2(path, output)
    build_extension.run_blender_command("server-generate", "--repo-dir", str(output), "--html")
    entries = json.loads((output / INDEX).read_text(encoding="utf-8"))["data"]
    check_index(entries, zips)
    return entries


def check_index(entries: list[dict], zips: list[Path]) -> None:
    """Every zip is in the index with its own size, checksum, version and platform, and nothing else is."""
    version = build_extension.read_version()
    by_name = {Path(entry["archive_url"]).name: entry for entry in entries}
    if set(by_name) != {path.name for path in zips}:
        raise build_extension.BuildError(f"the index lists {sorted(by_name)}, not {sorted(p.name for p in zips)}")
    for path in zips:
        entry = by_name[path.name]
        platform = path.stem.removeprefix(f"smooth_polylines-{version}-").replace("_", "-")
        expected = {
            "id": "smooth_polylines",
            "version": version,
            "platforms": [platform],
            "archive_size": path.stat().st_size,
            "archive_hash": f"sha256:{hashlib.sha256(path.read_bytes()).hexdigest()}",
        }
        found = {key: entry.get(key) for key in expected}
        if found != expected:
            raise build_extension.BuildError(f"the index says of {path.name} {found}, not {expected}")


def main() -> int:
    """0, or 1 and the reason."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--zips", type=Path, required=True, help="folder with the extension's zips of one version")
    parser.add_argument("--output", type=Path, required=True, help="folder of the repository")
    arguments = parser.parse_args()
    try:
        version = build_extension.read_version()
        zips = sorted(arguments.zips.glob(f"smooth_polylines-{version}-*.zip"))
        entries = build_repository(zips, arguments.output)
    except build_extension.BuildError as error:
        print(f"No repository: {error}", file=sys.stderr)
        return 1
    for entry in entries:
        print(f"{arguments.output / INDEX}: {entry['id']} {entry['version']} for {', '.join(entry['platforms'])}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
