"""Bad jobs: exit code 2, one clear line for each fault, nothing written; the schema says what any validator says."""

import copy
import json

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from batch import jobs

from batching import command_line, job_file, schema_check  # isort: skip  (after jobs, which knows where it is)

GOOD = {
    "inputs": ["in/*.ply"],
    "lines": [{"name": "a", "picks": [0, 1]}],
    "outputs": {"folder": "out", "formats": ["json"]},
}


def change(*path, to):
    """GOOD with one place changed; `to` None: taken out."""
    job = copy.deepcopy(GOOD)
    place = job
    for key in path[:-1]:
        place = place[key]
    if to is None:
        del place[path[-1]]
    else:
        place[path[-1]] = to
    return json.dumps(job)


LINE = ("lines", 0)
BAD = {
    "no list of inputs": (change("inputs", to="in/*.ply"), 'inputs: expected a list, found "in/*.ply"'),
    "input of a wrong type": (change("inputs", 0, to=7), "inputs[0]: expected a text, found 7"),
    "no file matches": (change("inputs", 0, to="in/*.obj"), "no file of a kind that Blender imports matches in/*.obj"),
    "missing file": (change("inputs", 0, to="in/gone.ply"), "there is no file in/gone.ply"),
    "file of a kind that is not imported": (change("inputs", 0, to="in/notes.txt"), "notes.txt is none of the files"),
    "unknown key at the top": (change("input", to=[]), 'input: unknown key; did you mean "inputs"?'),
    "unknown key in a line": (change(*LINE, "filtr", to="fair"), 'lines[0].filtr: unknown key; did you mean "filter"?'),
    "unknown word": (change(*LINE, "filter", to="cubix"), 'lines[0].filter: "cubix" is none of'),
    "near match of a word": (change(*LINE, "filter", to="cubix"), 'did you mean "cubic"?'),
    "capitals": (change(*LINE, "filter", to="CUBIC"), 'did you mean "cubic"?'),
    "nothing near": (change(*LINE, "zzz", to=1), "known here: name, objects, picks"),
    "no lines": (change("lines", to=None), 'has neither "lines" nor "nets"'),
    "no outputs": (change("outputs", to=None), '"outputs" is missing'),
    "no formats": (change("outputs", "formats", to=[]), "outputs.formats: expected at least 1 entry, found 0"),
    "no name": (change(*LINE, "name", to=None), 'lines[0]: "name" is missing'),
    "empty name": (change(*LINE, "name", to=""), "lines[0].name: the text is empty"),
    "no picks": (change(*LINE, "picks", to=None), "lines[0]: needs one of the keys picks, along"),
    "negative face": (change(*LINE, "picks", 1, to=-1), "lines[0].picks[1]: -1 is below the least, 0"),
    "half a face": (change(*LINE, "picks", 1, to=0.5), "lines[0].picks[1]: expected a whole number or an object"),
    "pick of no kind": (change(*LINE, "picks", 1, to={"pont": [0, 0, 0]}), 'did you mean "point"?'),
    "pick of two kinds": (change(*LINE, "picks", 1, to={"face": 1, "point": [0, 0, 0]}), "has face and point"),
    "point of two numbers": (change(*LINE, "picks", 1, to={"point": [0, 0]}), "expected 3 entries, found 2"),
    "attribute without value": (change(*LINE, "picks", 1, to={"attribute": "a"}), '"value" is missing'),
    "radius of 0": (change("search_radius", to=0), "search_radius: 0 must be above 0"),
    "threshold too large": (change(*LINE, "threshold", to=2), "lines[0].threshold: 2 is above the most, 1"),
    "true for a number": (change(*LINE, "support", to=True), "lines[0].support: expected a whole number, found true"),
    "detail size of another filter": (change(*LINE, "detail_size", to=1), 'is of the filter "fair", but the filter is'),
    "closed through two": (change(*LINE, "closed", to=True), "a closed line needs 3 picks or more, found 2"),
    "seams on what modifiers make": (
        json.dumps({**GOOD, "source": "evaluated", "make": {"seams": {"method": "cut"}}}),
        "make.seams: lines on what modifiers make cannot be put into the mesh",
    ),
    "unwrap without seams": (change("make", to={"unwrap": {}}), "needs seams to unwrap along"),
    "one axis": (change("import", to={"up": "z"}), "forward and up belong together"),
    "both on one axis": (change("import", to={"up": "z", "forward": "-z"}), "lie on one axis"),
    "net out of range": (
        change("nets", to=[{"name": "n", "picks": [0, 1, 2], "connections": [[0, 3]]}]),
        "nets[0].connections[0]: pick 3 is out of range; the net has 3 picks",
    ),
    "net from a pick to itself": (
        change("nets", to=[{"name": "n", "picks": [0, 1], "connections": [[1, 1]]}]),
        "joins pick 1 to itself",
    ),
    "two of one name": (change("nets", to=[{"name": "a", "picks": [0, 1]}]), 'lines[0] has the name "a" too'),
    "NaN": (change(*LINE, "picks", 1, to={"point": [0, 0, float("nan")]}), "NaN is no JSON number"),
    "infinity": (change("search_radius", to=float("inf")), "Infinity is no JSON number"),
    "too large a number": (change("search_radius", to=1.5).replace("1.5", "1e999"), "the number 1e999 is too large"),
    "an endless integer": (change(*LINE, "picks", 1, to=5).replace("5", "9" * 5000), "a number cannot be read"),
    "a key twice": ('{"inputs": [], "inputs": []}', 'the key "inputs" stands twice'),
    "no JSON": ("{inputs: []}", "line 1, column 2: no JSON here"),
    "nothing": ("", "line 1, column 1: no JSON here"),
    "a list": ("[]", "the job: expected an object, found a list"),
    "10 MB of brackets": ("[" * 10_000_000, "more than 64 levels of brackets"),
    "10 MB of objects": ('{"a":' * 2_000_000, "more than 64 levels of brackets"),
    "10 MB of a string that does not end": ('"' + '\\"' * 5_000_000, "no JSON here"),
    "many faults": (
        json.dumps({**GOOD, "lines": [{"name": "a", "picks": [0, -k]} for k in range(1, 60)]}),
        "and 39 more",
    ),
}  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    jobs.write_ply(tmp_path / "in" / "a.ply", *jobs.make_bumpy(8, 0))
    (tmp_path / "in" / "notes.txt").write_text("notes")
    return tmp_path


@pytest.mark.parametrize("name", BAD)
def test_bad_job_is_refused_in_one_clear_line_for_each_fault(folder, capsys, name):
    text, expected = BAD[name]
    job = folder / "job.json"
    job.write_text(text)
    before = sorted(folder.rglob("*"))
    assert command_line.main([str(job)]) == 2
    told = capsys.readouterr()
    lines = told.err.splitlines()
    assert told.out == ""
    assert any(expected in line for line in lines), lines
    assert all(line.startswith("Bad job: ") and "job.json" in line for line in lines)
    assert max(map(len, lines)) < 400 + len(str(folder))
    assert len(lines) <= 21
    assert sorted(folder.rglob("*")) == before


def test_bytes_that_are_no_text_and_files_that_are_not_there(folder, capsys):
    (folder / "job.json").write_bytes(b'{"inputs": "\xff"}')
    assert command_line.main([str(folder / "job.json")]) == 2
    assert "is not UTF-8 text (byte 12)" in capsys.readouterr().err
    assert command_line.main([str(folder / "none.json")]) == 2
    assert "cannot be read: No such file" in capsys.readouterr().err
    assert command_line.main([str(folder)]) == 2
    assert "cannot be read: Is a directory" in capsys.readouterr().err
    assert command_line.main([]) == 2
    assert "name a job" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments", [["--jobs", "0"], ["--shard", "3/2"], ["--shard", "0/2"], ["--shard", "x"], ["--jbos", "2"]]
)
def test_bad_arguments(folder, capsys, arguments):
    jobs.write_job(folder / "job.json")
    assert command_line.main([str(folder / "job.json"), *arguments]) == 2
    assert arguments[0] in capsys.readouterr().err
    assert not (folder / "out").exists()


def test_output_folder_that_is_a_file(folder, capsys):
    jobs.write_job(folder / "job.json")
    (folder / "out").write_text("mine")
    assert command_line.main([str(folder / "job.json")]) == 2
    assert "is a file" in capsys.readouterr().err
    assert (folder / "out").read_text() == "mine"


def test_no_job_without_inputs_outside_blender(folder, capsys):
    jobs.write_job(folder / "job.json", inputs=None)
    assert command_line.main([str(folder / "job.json")]) == 2
    assert '"inputs" is missing' in capsys.readouterr().err


def test_bom_and_other_line_ends_are_read(folder):
    text = jobs.write_job(folder / "job.json").read_text().replace(",", ",\r\n")
    (folder / "job.json").write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert job_file.load_job(folder / "job.json").inputs == ["in/*"]


def test_example_and_schema_are_printed_and_good(capsys):
    assert command_line.main(["--example"]) == 0
    example = json.loads(capsys.readouterr().out)
    assert command_line.main(["--schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(example, schema)
    assert schema_check.list_faults(example, schema) == []


def test_check_of_names_looks_at_inputs_from_outside_and_makes_nothing(tmp_path, capsys, monkeypatch):
    monkeypatch.delattr("batching.worker_process.WorkerProcess.start")  # opens nothing
    jobs.write_inputs(tmp_path / "in", 3)
    errors = jobs.write_broken(tmp_path / "in")
    jobs.write_job(tmp_path / "job.json")
    assert command_line.main([str(tmp_path / "job.json"), "--check-names"]) == 1
    told = capsys.readouterr().out
    seen_from_outside = ["empty.ply", "words.ply", "cut.stl", "zeros.obj"]
    assert "is a good job: 13 files (4 of them will fail), 2 lines, 0 nets" in told
    for name in seen_from_outside:
        assert f"in/{name}: {errors[name]}: " in told
    assert not (tmp_path / "out").exists()


WORDS = st.sampled_from(
    [
        "name",
        "picks",
        "point",
        "face",
        "value",
        "attribute",
        "along",
        "object",
        "linear",
        "fair",
        "all",
        "",
        "a",
        "json",
    ]
)
VALUES = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-2, 20), st.floats(-2, 20), WORDS),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(WORDS, inner, max_size=4)),
    max_leaves=12,
)
EXAMPLE = json.loads(job_file.EXAMPLE_FILE.read_text())


@st.composite
def changed_jobs(draw):
    """The example with some places exchanged for anything."""
    job = copy.deepcopy(EXAMPLE)
    for _ in range(draw(st.integers(1, 3))):
        place = job
        while True:
            keys = list(place) if isinstance(place, dict) else range(len(place))
            if not keys:
                break
            key = draw(st.sampled_from(list(keys)))
            if isinstance(place[key], (dict, list)) and draw(st.booleans()):
                place = place[key]
                continue
            place[key] = draw(VALUES)
            break
        if isinstance(place, dict) and draw(st.booleans()):
            place[draw(WORDS)] = draw(VALUES)
    return job


@settings(max_examples=400, deadline=None, derandomize=True)
@given(changed_jobs())
def test_verdicts_are_those_of_a_validator_of_others(job):
    schema = job_file.read_schema()
    expected = jsonschema.Draft202012Validator(schema).is_valid(job)
    faults = schema_check.list_faults(job, schema)
    assert (faults == []) == expected, faults
    assert all("\n" not in fault for fault in faults)
