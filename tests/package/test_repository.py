"""The repository of extensions: its index says what the zips are, and Blender installs from it as from a web server."""

import json
import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "blender_scripts"))

SCRIPT = Path(__file__).resolve().parents[2] / "blender_scripts" / "build_repository.py"
INSTALL = """
import json, os, sys
import bpy
address = sys.argv[1]
preferences = bpy.context.preferences
preferences.system.use_online_access = True
repository = preferences.extensions.repos.new(name="Ours", module="ours", remote_url=address)
repository.use_sync_on_startup = False
at = list(preferences.extensions.repos).index(repository)
synced = bpy.ops.extensions.repo_sync(repo_index=at)
installed = bpy.ops.extensions.package_install(repo_index=at, pkg_id="smooth_polylines", enable_on_install=True)
import smooth_polylines
told = {
    "synced": sorted(synced), "installed": sorted(installed), "library": smooth_polylines.__file__,
    "enabled": "bl_ext.ours.smooth_polylines" in preferences.addons,
}
print("RESULT", json.dumps(told), flush=True)
os._exit(0)
"""


@pytest.fixture(scope="module")
def repository(shipped_zip, run_without_ours, tmp_path_factory):
    folder = tmp_path_factory.mktemp("repository")
    (folder / "zips").mkdir()
    shutil.copy(shipped_zip, folder / "zips")
    done = run_without_ours(SCRIPT, "--zips", folder / "zips", "--output", folder / "site")
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "site"


def test_index_names_the_zip(repository, shipped_zip):
    index = json.loads((repository / "index.json").read_text(encoding="utf-8"))
    (entry,) = index["data"]
    assert entry["id"] == "smooth_polylines"
    assert entry["archive_size"] == shipped_zip.stat().st_size
    assert entry["blender_version_min"] == "4.2.0"
    assert {path.name for path in repository.iterdir()} == {"index.json", "index.html", shipped_zip.name}


def test_blender_installs_from_it(repository, run_without_ours, tmp_path):
    profile = tmp_path / "profile"
    profile.mkdir()
    script = tmp_path / "install.py"
    script.write_text(INSTALL)
    done = run_without_ours(script, repository.as_uri() + "/index.json", BLENDER_USER_RESOURCES=str(profile))
    assert done.returncode == 0, done.stdout + done.stderr
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("RESULT ")]
    told = json.loads(line.removeprefix("RESULT "))
    assert told["synced"] == told["installed"] == ["FINISHED"]
    assert told["enabled"]
    assert Path(told["library"]).is_relative_to(profile)


def test_no_zip_no_repository_and_a_wrong_index_is_found(run_without_ours, shipped_zip, tmp_path):
    done = run_without_ours(SCRIPT, "--zips", tmp_path, "--output", tmp_path / "site")
    assert done.returncode == 1
    assert "there is no zip" in done.stderr
    check = tmp_path / "check.py"
    check.write_text(
        f"import sys; sys.path.insert(0, {str(SCRIPT.parent)!r})\n"
        "import os, build_repository, build_extension; from pathlib import Path\n"
        f"zip_path = Path({str(shipped_zip)!r})\n"
        "entry = {'id': 'smooth_polylines', 'version': build_extension.read_version(), 'archive_url': zip_path.name,\n"
        "         'platforms': ['linux-x64'], 'archive_size': 1, 'archive_hash': 'sha256:0'}\n"
        "for entries, word in (([entry], 'the index says of'), ([], 'the index lists')):\n"
        "    try:\n"
        "        build_repository.check_index(entries, [zip_path])\n"
        "    except build_extension.BuildError as error:\n"
        "        assert word in str(error), error\n"
        "    else:\n"
        "        raise AssertionError('not found')\n"
        "print('FOUND', flush=True); os._exit(0)\n"
    )
    done = run_without_ours(check)
    assert "FOUND" in done.stdout, done.stderr
