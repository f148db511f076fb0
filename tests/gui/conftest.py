"""Real Blender windows for the tests in this folder: an X server in memory, the extension installed, scenarios inside.

Blenders are those in the folders of `.blender` (made by `make test-gui`), or the one that BLENDER names. A scenario is
a script of `scenarios/` that runs in Blender and drives its window by `kit`; what it tells comes back as a dictionary.
"""

import json
import os
import shutil
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
REPOSITORY = HERE.parents[1]
SHOTS = REPOSITORY / "out" / "gui"
SECONDS_A_SCENARIO = 450
SIZE = (1280, 800)


def list_blenders():
    """Name and root folder of each Blender; the root of one that BLENDER names is that of this machine."""
    if "BLENDER" in os.environ:
        return [("own", Path("/"), os.environ["BLENDER"])]
    complete = sorted((REPOSITORY / ".blender").glob("*/.complete"))
    return [(path.parent.name, path.parent, "/usr/bin/blender") for path in complete]


@dataclass
class Window:
    """One Blender with the extension, on a display of its own."""

    name: str
    root: Path
    program: str
    work: Path  # inside the root
    display: str

    def inside(self, path):
        """A path as Blender sees it."""
        return "/" + str(path.relative_to(self.root))

    def command(self, *words):
        prefix = [] if self.root == Path("/") else ["chroot", str(self.root)]
        settings = {
            "PATH": "/usr/bin:/bin",
            "HOME": self.inside(self.work),
            "LANG": "C.UTF-8",
            "DISPLAY": self.display,
            "BLENDER_USER_RESOURCES": self.inside(self.work / "profile"),
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "SCENARIO_FOLDER": self.inside(self.work),
        }
        return [*prefix, "/usr/bin/env", "-i", *[f"{k}={v}" for k, v in settings.items()], *words]

    def leave_to_the_newest(self):
        """Skip in the older of two Blenders what takes long and hardly depends on it; ALL_WINDOWS=1 runs it in both."""
        has_newest = self.name == "trixie" and (self.root.parent / "sid" / ".complete").exists()
        if has_newest and "ALL_WINDOWS" not in os.environ:
            pytest.skip("runs in the newest Blender alone; ALL_WINDOWS=1 runs it here too")

    def run(self, scenario, **arrays):
        """Run `scenarios/{scenario}.py`; what it told, or a failure with the end of its output.

        arrays : of a mesh that the scenario reads by `kit.add_mesh`
        """
        if arrays:
            np.savez(self.work / "mesh.npz", **arrays)
        told = self.work / "told.json"
        told.unlink(missing_ok=True)
        words = [self.program, "--enable-event-simulate", "--window-geometry", "0", "0", *map(str, SIZE)]
        script = self.inside(self.work / "scenarios" / f"{scenario}.py")
        done = subprocess.run(
            self.command(*words, "--python-exit-code", "3", "--python", script),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            timeout=SECONDS_A_SCENARIO,
        )
        SHOTS.mkdir(parents=True, exist_ok=True)
        for shot in self.work.glob("*.png"):
            shutil.move(shot, SHOTS / f"{self.name}-{scenario}-{shot.name}")
        assert done.returncode == 0, f"{scenario} in Blender {self.name}:\n" + done.stdout[-3000:]
        return json.loads(told.read_text())


@pytest.fixture(scope="session", params=list_blenders(), ids=lambda found: found[0])
def window(request):
    name, root, program = request.param
    work = root / "tmp" / f"smooth-polylines-gui-{os.getpid()}"
    work.mkdir(parents=True)
    window = Window(name, root, program, work, "")
    shutil.copytree(HERE / "scenarios", work / "scenarios")
    shutil.copy(HERE / "kit.py", work / "scenarios")
    (zip_file,) = (REPOSITORY / "dist").glob("smooth_polylines-*.zip")
    shutil.copy(zip_file, work / "extension.zip")
    # The server finds a display number that nobody uses, also none of another folder's, and tells it.
    words = ["Xvfb", "-displayfd", "1", "-screen", "0", f"{SIZE[0]}x{SIZE[1]}x24", "-noreset", "-nolisten", "tcp"]
    server = subprocess.Popen(
        window.command(*words, "-fbdir", window.inside(work)),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        window.display = f":{server.stdout.readline().strip()}"
        screen = work / "Xvfb_screen0"
        until = time.monotonic() + 20
        while not screen.exists():
            assert server.poll() is None, f"the X server of {name} ended with {server.returncode}"
            assert time.monotonic() < until, f"the X server of {name} did not come up"
            time.sleep(0.1)
        install = ["--command", "extension", "install-file", "-r", "user_default", "-e"]
        done = subprocess.run(
            window.command(program, *install, window.inside(work / "extension.zip")),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=SECONDS_A_SCENARIO,
        )
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
        yield window
    finally:
        server.terminate()
        try:
            server.wait(10)
        except subprocess.TimeoutExpired:
            server.kill()
        server.stdout.close()
        shutil.rmtree(work, ignore_errors=True)
