"""What the native tests share: none of them may hang.

A test that runs too long ends the whole run, with a traceback of every thread: a hang inside of compiled code could not
be ended in another way. Holds no meshes (surfaces.py has them).
"""

import faulthandler
import os

import pytest

# The longest test takes some seconds; a machine under load gets ten times that.
LIMIT_SECONDS = 120


@pytest.fixture(scope="session")
def real_stderr(request):
    """A file descriptor of the terminal, behind pytest's capture."""
    with request.config.pluginmanager.getplugin("capturemanager").global_and_fixture_disabled():
        descriptor = os.dup(2)
    yield descriptor
    os.close(descriptor)


@pytest.fixture(autouse=True)
def end_the_run_when_a_test_hangs(real_stderr):
    faulthandler.dump_traceback_later(LIMIT_SECONDS, exit=True, file=real_stderr)
    yield
    faulthandler.cancel_dump_traceback_later()
