"""Whether this tree can be released: one version everywhere, and the changelog tells of it. Prints the version's notes.

    python blender_scripts/check_release.py [vX.Y.Z] [--notes]

With a tag the version must be the tag's, and have a dated section of its own in the changelog that says something.
Needs Python alone. Not imported by anything but tests.
"""

import argparse
import re
import sys
import tomllib
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
HEADING = re.compile(r"^## \[(?P<version>[^\]]+)\](?: - (?P<date>\d{4}-\d{2}-\d{2}))?\s*$", flags=re.MULTILINE)


class ReleaseError(Exception):
    """Why this is no release; shown as it is."""


def read_versions(root: Path) -> dict[str, str]:
    """The version in each file that repeats it."""

    def load(name: str) -> dict:
        return tomllib.loads((root / name).read_text(encoding="utf-8"))

    locked = {package["name"]: package["version"] for package in load("Cargo.lock")["package"]}
    return {
        "Cargo.toml": load("Cargo.toml")["workspace"]["package"]["version"],
        "addon/blender_manifest.toml": load("addon/blender_manifest.toml")["version"],
        "Cargo.lock": locked["smooth-polylines-core"],
    }


def find_section(changelog: str, version: str) -> tuple[str | None, str]:
    """Date and text of the changelog's section on a version; ReleaseError where there is none."""
    headings = list(HEADING.finditer(changelog))
    for index, heading in enumerate(headings):
        if heading["version"] == version:
            end = headings[index + 1].start() if index + 1 < len(headings) else len(changelog)
            return heading["date"], changelog[heading.end() : end].strip()
    raise ReleaseError(f"CHANGELOG.md has no section ## [{version}]")


def check_release(root: Path, tag: str | None) -> str:
    """The notes of the version; ReleaseError where something does not agree."""
    versions = read_versions(root)
    if len(set(versions.values())) != 1:
        told = ", ".join(f"{name} has {version}" for name, version in versions.items())
        raise ReleaseError(f"the versions differ: {told}; make them equal")
    version = versions["Cargo.toml"]
    changelog = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    date, notes = find_section(changelog, version)
    if tag is None:
        return notes
    if tag != f"v{version}":
        raise ReleaseError(f"the tag is {tag}, but the version is {version}; tag v{version}, or change the version")
    if date is None:
        raise ReleaseError(f"the changelog's section on {version} has no date: ## [{version}] - YYYY-MM-DD")
    if not re.search(r"^- ", notes, flags=re.MULTILINE):
        raise ReleaseError(f"the changelog's section on {version} tells of no change; move what is Unreleased there")
    return notes


def main() -> int:
    """0, or 1 and the reason."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tag", nargs="?", help="the tag that is to be released, as v1.2.3")
    parser.add_argument("--notes", action="store_true", help="print the changelog's section")
    arguments = parser.parse_args()
    try:
        notes = check_release(REPOSITORY, arguments.tag or None)
    except ReleaseError as error:
        print(f"No release: {error}", file=sys.stderr)
        return 1
    print(notes if arguments.notes else f"version {read_versions(REPOSITORY)['Cargo.toml']}: all agree")
    return 0


if __name__ == "__main__":
    sys.exit(main())
