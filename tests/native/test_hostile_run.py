"""A small, seeded part of `make hostile`: two meshes of each kind and the small shared ones."""

from collections import Counter

import pytest

from hostile import made
from hostile.jobs import Job, jobs_of
from hostile.judge import Judge
from hostile.worker import Task, run_task, shared_names

SMALL_SHARED = 6


def judge(task, shared=()):
    result = run_task(task, shared, every=37)
    broken = [record for record in result["records"] if record["outcome"] == "BROKEN"]
    assert broken == [], f"{result['mesh']}: {broken[0]}"
    return result


@pytest.mark.parametrize("kind", made.KINDS)
def test_lines_on_a_hostile_kind_keep_every_promise_or_are_refused_by_name(kind):
    for seed in (0, made.COUNTS[kind] - 1):
        assert len(judge(Task(kind, seed))["records"]) > 7


def test_lines_on_small_shared_meshes_keep_every_promise():
    shared = shared_names()
    if not shared:
        pytest.skip("needs the folder of shared test meshes")
    for i in range(SMALL_SHARED):
        judge(Task("shared", i), shared)


@pytest.mark.parametrize(
    ("kind", "seed", "every"),
    [
        # A corner was missed where ends of portals lie in one place: lines 1.3 and 0.3 radians bent, and far too long.
        ("coincident vertices", 5, 11),
        ("coincident vertices", 2, 1),
        ("zero area fan", 10, 1),
        # The funnel was blocked by a portal's end in the place of its start: bent by 1.8, 0.3 and 0.2 radians.
        ("coincident vertices", 8, 1),
        ("coincident vertices", 17, 1),
        ("coincident vertices", 26, 1),
        # What vertices are moved apart by was a bend of 1e-8 radians next to short segments.
        ("zero area fan", 24, 1),
        # A run that does not turn round its vertex in one sense: its angles were added up for ever.
        ("zero area fan", 18, 11),
        # Parting two equal points made the next pair equal.
        ("zero area fan", 0, 1),
        ("zero area fan", 5, 1),
    ],
)
def test_geodesics_at_triangles_without_area_are_straight(kind, seed, every):
    positions, triangles = made.make(kind, seed)
    judge = Judge(f"{kind} {seed}", positions, triangles)
    jobs = list(jobs_of(judge.name, triangles, judge.checker.edge_ids, seed, every))
    records = [judge.record(job) for job in jobs if job.way == "geodesic"]
    assert len(records) >= 42 // every
    assert [record for record in records if record["outcome"] == "BROKEN"] == []


def test_there_are_five_hundred_meshes_and_they_are_the_same_each_time():
    assert sum(made.COUNTS.values()) == 500
    for kind in made.KINDS:
        one, other = made.make(kind, 3), made.make(kind, 3)
        assert all(a.tobytes() == b.tobytes() for a, b in zip(one, other, strict=True))
        assert any(len(made.make(kind, 4)[0]) != len(one[0]) or (made.make(kind, 4)[0] != one[0]).any() for _ in [0])


def test_a_broken_promise_would_be_seen():
    """The judge is no rubber stamp: a line that is told to be pinned elsewhere is found out."""
    positions, triangles = made.make("terrain", 2)
    watch = Judge("terrain", positions, triangles)
    line = watch.mesh.polyline([3, 200], filter="geodesic")
    watch.check(Job("terrain", "geodesic", "two", [3, 200], False, "ends"), line)
    with pytest.raises(AssertionError):
        watch.check(Job("terrain", "geodesic", "two", [3, 201], False, "ends"), line)
    bent = watch.mesh.polyline([3, 200], filter="none")
    with pytest.raises(AssertionError, match="bent by"):
        watch.check(Job("terrain", "geodesic", "two", [3, 200], False, "ends"), bent)
    outcomes = Counter(record["outcome"] for record in run_task(Task("terrain", 2), (), every=29)["records"])
    assert outcomes["converged"] + outcomes["converged_at_vertices"] > 3
