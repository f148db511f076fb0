"""The extension zip: built and validated by Blender's own machinery, and opened; test_installs.py installs it.

Every step is a process of its own, as for a user. The wheel is the one that `make wheel` left in dist/wheels.
"""

import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
WHEELS = REPOSITORY / "dist" / "wheels"
VERSION = tomllib.loads((REPOSITORY / "Cargo.toml").read_text())["workspace"]["package"]["version"]


def run_python(*arguments, **environment):
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, **environment},
    )


def build(wheels, output):
    return run_python(REPOSITORY / "blender_scripts" / "build_extension.py", "--wheels", wheels, "--output", output)


@pytest.fixture(scope="module")
def extension_zip(tmp_path_factory):
    output = tmp_path_factory.mktemp("dist")
    done = build(WHEELS, output)
    assert done.returncode == 0, done.stdout + done.stderr
    (path,) = output.glob("*.zip")
    return path


@pytest.fixture(scope="module")
def manifest(extension_zip):
    with zipfile.ZipFile(extension_zip) as archive:
        return tomllib.loads(archive.read("blender_manifest.toml").decode())


def test_zip_holds_the_addon_its_licence_and_one_abi3_wheel(extension_zip):
    with zipfile.ZipFile(extension_zip) as archive:
        assert archive.testzip() is None
        names = [n for n in archive.namelist() if not n.endswith("/")]
        for name in names:
            if not name.startswith("wheels/") and name != "blender_manifest.toml":
                assert archive.read(name) == (REPOSITORY / "addon" / name).read_bytes()
    sources = {
        p.relative_to(REPOSITORY / "addon").as_posix()
        for p in (REPOSITORY / "addon").rglob("*")
        if p.is_file() and "__pycache__" not in p.parts
    }
    wheels = [n for n in names if n.startswith("wheels/")]
    assert {"LICENSE", "__init__.py", "session.py", "operators/add_polyline.py"} <= sources
    assert set(names) == sources | set(wheels)
    (wheel,) = wheels
    assert Path(wheel).name.startswith(f"smooth_polylines-{VERSION}-cp311-abi3-")


def test_manifest_is_what_we_promise(manifest):
    assert manifest["id"] == "smooth_polylines"
    assert manifest["version"] == VERSION
    assert manifest["blender_version_min"] == "4.2.0"
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    assert "permissions" not in manifest
    assert len(manifest["wheels"]) == 1


def test_blenders_validation_also_checks_the_tags(extension_zip, tmp_path):
    """The check that the build relies on does find a fault: the same zip with a tag that does not exist."""
    broken = tmp_path / "broken.zip"
    with zipfile.ZipFile(extension_zip) as source, zipfile.ZipFile(broken, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "blender_manifest.toml":
                data = data.replace(b'"Add Curve"', b'"No Such Tag"')
            target.writestr(name, data)
    command = (
        "import sys, bpy; from bl_pkg.bl_extension_cli import cli_extension_handler as run; "
        "sys.exit(run(['validate', sys.argv[1]]))"
    )
    done = run_python("-c", command, broken)
    assert done.returncode != 0
    assert "No Such Tag" in done.stdout + done.stderr
    assert run_python("-c", command, extension_zip).returncode == 0


def test_no_wheel_no_extension(tmp_path):
    done = build(tmp_path, tmp_path / "out")
    assert done.returncode == 1
    assert "there is no wheel in" in done.stderr
    assert not list(tmp_path.rglob("*.zip"))


def test_two_wheels_for_one_platform_are_refused(tmp_path):
    (wheel,) = WHEELS.glob("*.whl")
    shutil.copy(wheel, tmp_path)
    other = "linux_x86_64" if "manylinux" in wheel.name else "manylinux_2_28_x86_64"
    shutil.copy(wheel, tmp_path / f"smooth_polylines-{VERSION}-cp311-abi3-{other}.whl")
    done = build(tmp_path, tmp_path / "out")
    assert done.returncode == 1
    assert "are both for" in done.stderr


@pytest.mark.parametrize("name", ["smooth_polylines-0.0.1-cp311-abi3", f"smooth_polylines-{VERSION}-cp311-cp311"])
def test_wheel_of_another_version_or_for_one_python_only_is_refused(tmp_path, name):
    (wheel,) = WHEELS.glob("*.whl")
    shutil.copy(wheel, tmp_path / f"{name}-linux_x86_64.whl")
    done = build(tmp_path, tmp_path / "out")
    assert done.returncode == 1
    assert f"is not smooth_polylines {VERSION} for cp311-abi3" in done.stderr


def test_wheel_without_the_compiled_library_is_found(tmp_path):
    (wheel,) = WHEELS.glob("*.whl")
    with zipfile.ZipFile(wheel) as source, zipfile.ZipFile(tmp_path / wheel.name, "w") as target:
        for name in source.namelist():
            if "_native." not in name or name.endswith(".pyi"):
                target.writestr(name, source.read(name))
    done = build(tmp_path, tmp_path / "out")
    assert done.returncode == 1
    assert "does not hold the compiled library" in done.stderr
