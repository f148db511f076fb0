"""What is checked before a release, on copies of this tree with one thing wrong; and the workflow that makes it."""

import importlib.util
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("check_release", REPOSITORY / "blender_scripts" / "check_release.py")
check_release = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(check_release)
WORKFLOW = (REPOSITORY / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8")
VERSION = tomllib.loads((REPOSITORY / "Cargo.toml").read_text())["workspace"]["package"]["version"]
GOOD = (
    f"# Changelog\n\n## [Unreleased]\n\n## [{VERSION}] - 2026-11-25\n\n### Added\n\n- Lines.\n\n"
    "## [0.0.1] - 2026-01-01\n\n- x\n"
)


@pytest.fixture
def tree(tmp_path):
    for name in ("Cargo.toml", "Cargo.lock", "addon/blender_manifest.toml"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(REPOSITORY / name, tmp_path / name)
    (tmp_path / "CHANGELOG.md").write_text(GOOD)
    return tmp_path


def test_this_tree_agrees_with_itself():
    check_release.check_release(REPOSITORY, None)


def test_a_good_tree_can_be_released_and_its_notes_are_the_section(tree):
    assert check_release.check_release(tree, f"v{VERSION}") == "### Added\n\n- Lines."


def replace(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


FAULTS = {
    "manifest": ("addon/blender_manifest.toml", f'version = "{VERSION}"', 'version = "9.9.9"', "the versions differ"),
    "cargo": ("Cargo.toml", f'version = "{VERSION}"', 'version = "9.9.9"', "the versions differ"),
    "no section": ("CHANGELOG.md", f"[{VERSION}]", "[9.9.9]", "has no section"),
    "no date": ("CHANGELOG.md", " - 2026-11-25", "", "has no date"),
    "nothing told": ("CHANGELOG.md", "- Lines.", "", "tells of no change"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_what_is_wrong_is_found(tree, name):
    path, old, new, message = FAULTS[name]
    replace(tree / path, old, new)
    with pytest.raises(check_release.ReleaseError, match=message):
        check_release.check_release(tree, f"v{VERSION}")


def test_a_tag_of_another_version_is_found(tree):
    with pytest.raises(check_release.ReleaseError, match=r"the tag is v9\.9\.9"):
        check_release.check_release(tree, "v9.9.9")


def test_workflow_builds_for_every_platform_and_its_files_are_there():
    platforms = set(re.findall(r"name: ((?:linux|windows|macos)-\w+)", WORKFLOW))
    assert platforms == {"linux-x64", "windows-x64", "macos-x64", "macos-arm64"}
    named = set(re.findall(r"[\w./-]+/[\w-]+\.(?:py|txt)|requirements-\w+\.txt", WORKFLOW))
    assert {"blender_scripts/build_extension.py", "blender_scripts/build_repository.py"} <= named
    for name in named:
        assert (REPOSITORY / name).is_file(), name
    assert "\t" not in WORKFLOW


def test_workflow_is_yaml_whose_jobs_wait_for_each_other():
    yaml = pytest.importorskip("yaml")
    jobs = yaml.safe_load(WORKFLOW)["jobs"]
    assert list(jobs) == ["version", "wheel", "extension", "publish"]
    assert [jobs[name].get("needs") for name in jobs] == [None, "version", "wheel", "extension"]
    assert jobs["publish"]["if"] == "startsWith(github.ref, 'refs/tags/')"
    for job in jobs.values():
        assert all("uses" in step or "run" in step for step in job["steps"])


def list_commands():
    """Every command of the workflow, on one line each."""
    yaml = pytest.importorskip("yaml")
    steps = [step for job in yaml.safe_load(WORKFLOW)["jobs"].values() for step in job["steps"] if "run" in step]
    return [line.strip() for step in steps for line in step["run"].splitlines() if line.strip()]


def test_commands_of_the_workflow_are_those_that_make_runs_here():
    """Under Windows there is no make: the workflow must call what `make repository` calls, option for option."""
    makefile = (REPOSITORY / "Makefile").read_text(encoding="utf-8").replace("\\\n", " ")
    known = {word for line in makefile.splitlines() if line.startswith("\t") for word in line.split()}
    linux = re.search(r"^RELEASE_OPTIONS := .*,(--zig[^)]*)\)", makefile, flags=re.MULTILINE)[1]
    compared = 0
    for command in list_commands():
        tool = re.match(r"(?:python3? )?(maturin|abi3audit|blender_scripts/[\w.]+)", command)
        if tool is None or tool[1].endswith("check_release.py"):  # which the tests above run
            continue
        compared += 1
        assert any(word.endswith(tool[1]) for word in known), command
        lines = [line for line in makefile.splitlines() if line.startswith("\t") and f"{tool[1]} " in line]
        options = [re.findall(r"--[\w-]+", line.split(tool[1])[-1]) for line in lines]
        assert re.findall(r"--[\w-]+", command) in options, command
    assert compared == 4
    assert f'options="{linux}"' in WORKFLOW


def test_what_the_workflow_installs_is_pinned_and_its_shell_lines_are_shell():
    pinned = {
        re.split(r"[=<>! ]", line)[0]
        for name in ("requirements-dev.txt", "requirements-release.txt")
        for line in (REPOSITORY / name).read_text().splitlines()
        if not line.startswith("#")
    }
    installs = [command for command in list_commands() if "pip install" in command and "--no-index" not in command]
    assert len(installs) == 3
    for command in installs:
        assert re.search(r" -[rc] requirements-(dev|release)\.txt", command), command
        words = command.split(".txt", 1)[1].split()
        assert set(words) <= pinned, command
    script = re.sub(r"\$\{\{.*?\}\}", "x", "\n".join(list_commands()))
    done = subprocess.run(["bash", "-n"], input=script, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
