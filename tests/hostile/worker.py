"""A share of the meshes in a process of its own, which writes a line of JSON for each mesh: it may hang or crash.

Begun by __main__.py, which sees from the last line written where it ended. No test.
"""

import faulthandler
import json
import sys
from dataclasses import dataclass

import meshes
from hostile import made
from hostile.jobs import jobs_of
from hostile.judge import Judge

# Of the 420 lines of a mesh every eleventh is asked for: 11 has no factor in common with the numbers of filters, pins
# and kinds of picks, so that over the meshes all come together.
EVERY = 11

# A line that takes longer than this hangs, for all that anybody would wait.
LIMIT_SECONDS = 120


@dataclass(frozen=True)
class Task:
    """One mesh: shared, by its file's name, or made, by its kind and seed."""

    kind: str
    seed: int

    @property
    def is_shared(self):
        return self.kind == "shared"

    def load(self, shared):
        if self.is_shared:
            mesh = meshes.load_shared_mesh(shared[self.seed])
            return shared[self.seed], mesh.positions, mesh.triangles
        return (f"{self.kind} {self.seed}", *made.make(self.kind, self.seed))


def shared_names():
    """File names of the shared meshes, the small ones first; none where there is no folder."""
    folder = meshes.find_mesh_folder()
    if not folder.is_dir():
        return []
    files = [path for path in folder.iterdir() if path.suffix in (".obj", ".off", ".ply", ".stl")]
    return [path.name for path in sorted(files, key=lambda path: (path.stat().st_size, path.name))]


def all_tasks(shared):
    """Every mesh of the run."""
    own = [Task(kind, seed) for kind in made.KINDS for seed in range(made.COUNTS[kind])]
    return [Task("shared", i) for i in range(len(shared))] + own


def run_task(task, shared, every=EVERY):
    """All records of one mesh: a dict with its name and size."""
    name, positions, triangles = task.load(shared)
    judge = Judge(name, positions, triangles)
    records = []
    for job in jobs_of(name, triangles, judge.checker.edge_ids, task.seed, every):
        faulthandler.dump_traceback_later(LIMIT_SECONDS, exit=True)
        records.append(judge.record(job))
    faulthandler.cancel_dump_traceback_later()
    return {"mesh": name, "kind": task.kind, "triangles": len(triangles), "records": records}


def main():
    share, shares, every = map(int, sys.argv[1:])
    shared = shared_names()
    for number, task in enumerate(all_tasks(shared)):
        if number % shares == share:
            print(json.dumps({"begun": [task.kind, task.seed]}), flush=True)
            print(json.dumps(run_task(task, shared, every)), flush=True)


if __name__ == "__main__":
    main()
