"""For the tests of the batch: bpy is never imported here, only in the processes that runs start."""

import pytest

from batch import jobs


@pytest.fixture(scope="session")
def scenes(tmp_path_factory):
    """A folder with the plane of `make_scenes.py` in every format."""
    folder = tmp_path_factory.mktemp("scenes")
    jobs.run_maker("write", folder)
    return folder


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory):
    """A folder with good and broken inputs, and what one run that nobody disturbed made of them."""
    folder = tmp_path_factory.mktemp("undisturbed")
    jobs.write_inputs(folder / "in", 12)
    errors = jobs.write_broken(folder / "in")
    job = jobs.write_job(folder / "job.json")
    done = jobs.run_batch(job)
    return folder, errors, done
