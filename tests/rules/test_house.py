"""The rules of the house that a machine can check: sizes, first lines, one version, nothing of any one machine."""

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]

MOST_LINES = 400  # without tests
# Files that may be longer, each with its reason.
LONGER: dict[str, str] = {}

# Registries and indexes, by the words in their host names, put together here so that this file passes too.
HOST = re.compile(
    r"\b(?:[\w-]+\.)*(?:" + "|".join(["py" + "pi", "pythonhosted", "crates", "npmjs"]) + r")\.(?:org|io|com)\b"
)
MACHINE_PATH = re.compile(r"(?<![\w.:/$}-])/(?:work|root|tmp|home|farm|opt)/[\w.]")
# Kept as they came: legal texts, and what tools write.
NOT_OURS = {"LICENSE-MIT", "LICENSE-APACHE", "addon/LICENSE", "Cargo.lock", "rust/fuzz/Cargo.lock"}
TEXT_SUFFIXES = {".rs", ".py", ".pyi", ".toml", ".md", ".txt", ".yml", ".yaml", ".sh", ".json", ""}


def list_files():
    """Tracked files and those about to be, less what is deleted."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=REPOSITORY,
        check=True,
        capture_output=True,
        text=True,
    ).stdout.splitlines()
    return [name for name in listed if (REPOSITORY / name).is_file()]


FILES = list_files()
SOURCES = [name for name in FILES if name.endswith((".rs", ".py", ".pyi"))]
TEXTS = [name for name in FILES if Path(name).suffix in TEXT_SUFFIXES and name not in NOT_OURS]


def read(name):
    return (REPOSITORY / name).read_text(encoding="utf-8")


def count_lines_without_tests(name):
    """Lines of a source; of a Rust file those before its test module."""
    text = read(name)
    if name.endswith(".rs"):
        text = re.split(r"^#\[cfg\(test\)\]\nmod ", text, maxsplit=1, flags=re.MULTILINE)[0]
    return text.count("\n")


def test_there_are_files_to_check():
    assert len(SOURCES) > 20
    assert "addon/session.py" in SOURCES
    assert "rust/core/src/lib.rs" in SOURCES


@pytest.mark.parametrize("name", SOURCES)
def test_file_is_not_too_long(name):
    if "tests/" in name:
        return
    assert count_lines_without_tests(name) <= MOST_LINES or LONGER.get(name)


@pytest.mark.parametrize("name", SOURCES)
def test_file_begins_by_saying_what_it_holds(name):
    lines = [line for line in read(name).splitlines() if line.strip()]
    if not lines:
        assert Path(name).name == "__init__.py"
        return
    if lines[0].startswith("# SPDX"):
        lines = lines[1:]
    beginnings = {".rs": "//! ", ".py": '"""', ".pyi": "# "}
    assert lines[0].startswith(beginnings[Path(name).suffix])
    assert len(lines[0]) > 20


@pytest.mark.parametrize("name", [n for n in SOURCES if n.startswith("addon/")])
def test_addon_file_names_its_licence(name):
    assert read(name).startswith("# SPDX-License-Identifier: GPL-3.0-or-later\n")


def test_no_packages_and_nothing_large():
    found = [name for name in FILES if name.endswith((".whl", ".zip", ".gz", ".so", ".blend"))]
    assert found == []
    assert [name for name in FILES if (REPOSITORY / name).stat().st_size > 1_000_000] == []


def test_nothing_of_one_machine_and_no_registry_host():
    found = [
        f"{name}:{number}: {line.strip()[:100]}"
        for name in TEXTS
        for number, line in enumerate(read(name).splitlines(), start=1)
        if MACHINE_PATH.search(line) or HOST.search(line)
    ]
    assert found == []


def test_the_machine_rule_finds_what_it_is_for():
    assert MACHINE_PATH.search('open("/ro' + 'ot/x")')
    assert MACHINE_PATH.search("see /wo" + "rk/main")
    assert not MACHINE_PATH.search("../shared/work/x and rust/core/tmp/x and ${HOME}/tmp/y")
    assert HOST.search("https://" + "py" + "pi.org/simple")


def test_version_is_the_same_everywhere_it_must_be_repeated():
    version = tomllib.loads(read("Cargo.toml"))["workspace"]["package"]["version"]
    assert tomllib.loads(read("addon/blender_manifest.toml"))["version"] == version
    assert tomllib.loads(read("pyproject.toml"))["project"]["dynamic"] == ["version"]
    headings = re.findall(r"^## \[(.+?)\]", read("CHANGELOG.md"), flags=re.MULTILINE)
    assert headings
    assert version in headings[:2]  # the first may be Unreleased


def test_addon_imports_only_relatively_and_never_its_storeys_above():
    for name in FILES:
        if name.startswith("addon/") and name.endswith(".py"):
            imported = re.findall(r"^\s*(?:from|import) ([\w.]+)", read(name), flags=re.MULTILINE)
            foreign = {i.split(".")[0] for i in imported if i[0] != "."} & {"addon", "tests", "blender_scripts"}
            assert not foreign, name
            assert "smooth_polylines" not in {i.split(".")[0] for i in imported}, (
                name  # only `native` loads it
            )


def test_readme_pictures_are_there_and_small():
    pictures = re.findall(r"!\[.*?\]\((.+?)\)", read("README.md"))
    assert pictures
    for picture in pictures:
        assert (REPOSITORY / picture).stat().st_size < 400_000


def test_makefile_commands_in_the_readme_exist():
    targets = set(re.findall(r"^([a-z-]+):.*## ", read("Makefile"), flags=re.MULTILINE))
    named = set(re.findall(r"(?:^    |`)make ([a-z-]+)", read("README.md"), flags=re.MULTILINE))
    assert {"demo", "test", "extension"} <= named <= targets
