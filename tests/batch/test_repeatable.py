"""The bytes of a result depend on its input and job alone: not on what its process did before, nor on stale memory."""

import os
import shutil

import numpy as np
import pytest

from batch import jobs
from batch.test_inputs import END, START, straight

from batching import blend_layout, stable_blend  # isort: skip


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    """One file of each format, each done in a process that has done nothing before: the folder, and its results."""
    folder = tmp_path_factory.mktemp("fresh")
    jobs.write_inputs(folder / "in", 3)
    job = jobs.write_job(folder / "job.json", limits={"files_a_process": 1})
    done = jobs.run_batch(job)
    assert done.returncode == 0, done.stderr
    return folder, jobs.hash_tree(folder / "out" / "in")


def test_every_kind_of_input_with_seams_and_maps(scenes, tmp_path):
    """In fresh processes, and after broken files in one whose memory is filled."""
    values = {
        "lines": [straight("a", START, END, objects=["[Pp]lane*"])],
        "search_radius": 0.1,
        "make": {"curves": {}, "seams": {"method": "cut"}, "unwrap": {}},
        "import": None,
    }
    made = []
    for name, limits, filling in (("fresh", {"files_a_process": 1}, "0"), ("used", {}, "165")):
        folder = tmp_path / name
        (folder / "in").mkdir(parents=True)
        for path in scenes.iterdir():
            if path.stem in {"plane", "scene"} and path.suffix != ".json":
                shutil.copy(path, folder / "in" / path.name)
        if name == "used":
            jobs.write_broken(folder / "in" / "a")
        outputs = {"folder": "out", "formats": ["json", "blend", "svg"]}
        job = jobs.write_job(folder / "job.json", inputs=["in/**/*"], limits=limits, outputs=outputs, **values)
        done = jobs.run_batch(job, env={**os.environ, "MALLOC_PERTURB_": filling})
        assert done.returncode == (0 if name == "fresh" else 1), done.stdout + done.stderr
        made.append(jobs.hash_tree(folder / "out" / "in"))
    assert sum(name.endswith("result.blend") for name in made[0]) == 10
    assert made[0] == made[1]


# Where the C library can be told to fill memory that is given out or given back: what is written without having been
# set then differs. Elsewhere the name means nothing.
@pytest.mark.parametrize("filling", ["", "165", "90"])
def test_after_other_files_good_and_broken_the_bytes_are_those_of_a_fresh_process(fresh, tmp_path, filling):
    folder, expected = fresh
    shutil.copytree(folder / "in", tmp_path / "in")
    # Files are done in the order of their names: all of these before the others. A .blend file that Blender fails to
    # open once left its mark on every .stl after it.
    errors = jobs.write_broken(tmp_path / "in" / "a")
    jobs.write_stl(tmp_path / "in" / "a" / "good.stl", *jobs.make_bumpy(10, 5))
    jobs.write_obj(tmp_path / "in" / "a" / "good.obj", *jobs.make_bumpy(14, 6))
    job = jobs.write_job(tmp_path / "job.json", inputs=["in/**/*"])
    done = jobs.run_batch(job, env={**os.environ, "MALLOC_PERTURB_": filling or "0"})
    assert done.returncode == 1, done.stderr
    assert done.stderr.count("FAILED") == len(errors)
    made = jobs.hash_tree(tmp_path / "out" / "in")
    assert {name: made[name] for name in expected} == expected


def test_memory_that_two_data_blocks_had_one_after_the_other_changes_nothing(scenes, tmp_path):
    """What Blender needed to write one data-block may be given to the next: then an address is there twice."""
    data = np.fromfile(scenes / "scene.blend", dtype=np.uint8)
    blocks = blend_layout.list_blocks(data)
    (dna,) = (block for block in blocks if block.code == b"DNA1")
    layouts = blend_layout.describe_structs(data[dna.data].tobytes())
    meshes = [s for s in stable_blend.list_sections(blocks) if layouts.name(s[0].struct_index) == "Mesh"]
    first, second = (
        next(b for b in reversed(section) if not layouts.is_data_block(b.struct_index))
        for section in (meshes[0], meshes[-1])
    )
    assert first.address != second.address
    twice = data.copy()
    places = stable_blend.find_pointers(data, meshes[-1], layouts)
    places = places[stable_blend.read_addresses(data, places) == second.address]
    assert len(places) >= 2  # the block's own, and what points to it
    twice[places[:, None] + np.arange(8)] = np.array([first.address], dtype="<u8").view(np.uint8)
    made = []
    for name, content in (("once", data), ("twice", twice)):
        content.tofile(tmp_path / name)
        stable_blend.stabilise_blend(tmp_path / name, is_imported=False)
        made.append((tmp_path / name).read_bytes())
    assert made[0] == made[1]
