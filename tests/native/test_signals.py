"""Ctrl-C stops a long run soon, other threads run meanwhile, and the mesh is usable afterwards."""

import subprocess
import sys
import textwrap
import threading
import time

import pytest

import smooth_polylines as sp
from native.interrupting import STOP_SECONDS, interrupt
from native.made_meshes import make_sphere


@pytest.fixture(scope="module")
def slow_call():
    """A call that takes long enough to be interrupted: all crossings of long lines, one at a time, to the last bit."""
    mesh = sp.SurfaceMesh(*make_sphere(7))
    picks = list(range(0, 20 * 4**7, 20 * 4**7 // 60)) * 20

    def call():
        mesh.polyline(picks, filter="cubic", threshold=1e-14, pinned="all")

    return mesh, call


def test_an_exception_of_a_signal_handler_stops_the_run(slow_call):
    mesh, call = slow_call
    before = mesh.polyline([0, 5000], filter="none").to_bytes()
    assert 0 <= interrupt(call, after=0.3) + 0.01 < STOP_SECONDS
    assert mesh.polyline([0, 5000], filter="none").to_bytes() == before


SCRIPT = """
    import signal, sys, time, threading, os
    import numpy as np
    sys.path.insert(0, sys.argv[1])
    import smooth_polylines as sp
    from native.made_meshes import make_sphere
    # A process started in the background of a script inherits that Ctrl-C is ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    mesh = sp.SurfaceMesh(*make_sphere(6))
    picks = list(range(0, 20 * 4**6, 1365))
    def interrupt():
        time.sleep(0.3)
        print("sent", flush=True)
        global sent
        sent = time.process_time()
        os.kill(os.getpid(), signal.SIGINT)
    threading.Thread(target=interrupt).start()
    try:
        while True:
            mesh.polyline(picks, filter="cubic", threshold=1e-14, pinned="all")
    except KeyboardInterrupt:
        print(f"KeyboardInterrupt {time.process_time() - sent:.3f}")
"""


def test_ctrl_c_is_a_keyboard_interrupt(request):
    tests = str(request.config.rootpath / "tests")
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(SCRIPT), tests], capture_output=True, text=True, timeout=60, check=True
    )
    assert run.stdout.startswith("sent\nKeyboardInterrupt "), run.stdout + run.stderr
    assert float(run.stdout.split()[-1]) < STOP_SECONDS


def test_other_threads_run_while_rust_works(slow_call):
    mesh, _ = slow_call
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    clock = threading.Thread(target=tick)
    clock.start()
    begun = time.perf_counter()
    while time.perf_counter() - begun < 0.3:
        line = mesh.polyline(list(range(0, 20 * 4**7, 4000)), filter="none")
    done.set()
    clock.join()
    assert len(line.points) > 1000
    # Held through, the interpreter would let the other thread tick a few times at most (its switch interval is 5 ms).
    assert len(ticks) > 30
