"""What is timed on one mesh: opening it, step B, geodesic lines, closed and dragged lines, strokes, networks.

Each function returns rows, one a query: {"task", "query", "samples": {contender: Samples as dict}}. Holds no figures.
"""

import itertools
import time
from dataclasses import asdict

import smooth_polylines as sp
from bench.ladder import DRAGGED
from bench.peers import MeshLib, Ours, Potpourri3d, PyGeodesic, PyVista
from bench.timing import alternate

OPENERS = ("ours", "MeshLib", "potpourri3d", "libigl")
# What lines and strokes are made smooth by: the filters by their defaults, and `cubic` as docs/filters.md advises.
SMOOTH_BY = {
    "cubic": {"filter": "cubic"},
    "cubic, threshold 1e-2": {"filter": "cubic", "threshold": 1e-2},
    "fair": {"filter": "fair"},
    "geodesic": {"filter": "geodesic"},
}
NETWORK_PICKS = 5
NETWORK_BY = ("geodesic", "fair")
# A line's cost over its length: goals at these shares of the way to the far end.
LENGTH_SHARES = (0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0)
# Steps of a search, for each triangle, after which ours has chosen landmarks (POPS_BEFORE_LANDMARKS in search.rs, and
# some more).
POPS_OFTEN = 34
# MeshLib's sweeps are told to stop only where nothing moves any more.
TO_CONVERGENCE = 100_000


class Timer:
    """Times the tasks of one mesh; `rounds` turns a query, `budget` seconds at most for one query."""

    def __init__(self, rung, peers, rounds, budget):
        self.rung, self.rounds, self.budget = rung, rounds, budget
        self.openers = [peer for peer in peers if peer.name in OPENERS]
        is_small = len(rung.triangles) <= PyGeodesic.most_triangles
        with_lines = [peer for peer in peers if hasattr(peer, "path") and (is_small or peer is not PyGeodesic)]
        self.opened = {peer.name: peer(rung.positions, rung.triangles) for peer in with_lines}
        self.ours = self.opened[Ours.name]
        self.rows = []

    def run(self):
        """All tasks, in an order that leaves caches alike for everybody."""
        for task in (self.open, self.step_b, self.straighten, self.geodesic, self.pinned, self.closed, self.dragged):
            task()
        self.stroke()
        self.network()
        self.ask_often()
        return self.rows

    def add(self, task, query, contenders, rounds=None):
        samples = alternate(contenders, rounds or self.rounds, self.budget)
        self.rows.append({"task": task, "query": query, "samples": {n: asdict(s) for n, s in samples.items()}})

    def peers(self, *classes):
        return {name: library for name, library in self.opened.items() if isinstance(library, classes)}

    def open(self):
        arrays = self.rung.positions, self.rung.triangles
        self.add("open", 0, {peer.name: lambda peer=peer: peer(*arrays) for peer in self.openers})

    def asks(self, method, libraries, vertices):
        """Contenders that call `method` of each library with the vertices, prepared beforehand."""
        prepared = {name: library.prepare(self.rung, vertices) for name, library in libraries.items()}
        return {name: lambda n=name, lib=lib: getattr(lib, method)(prepared[n]) for name, lib in libraries.items()}

    def fresh(self, *classes):
        """The libraries with a mesh of ours that nothing was asked of: no landmarks yet."""
        return {**self.peers(*classes), Ours.name: Ours(self.rung.positions, self.rung.triangles)}

    def step_b(self):
        libraries = self.peers(Ours, MeshLib)
        for query, pair in enumerate(self.rung.near):
            self.add("step B, near", query, self.asks("step_b", libraries, pair))
        for query, pair in enumerate(self.rung.across):
            self.add("step B, across", query, self.asks("step_b", self.fresh(MeshLib), pair))
        ring = [*self.rung.ring, self.rung.ring[0]]
        self.add("step B, ring", 0, self.asks("step_b", libraries, ring))

    def geodesic(self):
        for query, pair in enumerate(self.rung.near):
            self.add("geodesic, near", query, self.asks("path", self.peers(Ours, MeshLib, Potpourri3d, PyVista), pair))
        for query, pair in enumerate(self.rung.across):
            self.add("geodesic, across", query, self.asks("path", self.fresh(MeshLib, Potpourri3d), pair))
        slow = self.peers(Ours, PyGeodesic, PyVista)
        if len(slow) > 1:
            self.add("geodesic, beside slow ones", 0, self.asks("path", slow, self.rung.across[0]), rounds=3)

    def pinned(self):
        libraries = self.peers(Ours, MeshLib, Potpourri3d)
        self.add("10 picks", 0, self.asks("path", libraries, self.rung.line))
        self.add("30 picks in a ring", 0, self.asks("ring", libraries, self.rung.ring))

    def ask_often(self):
        """The pairs across once more, after so many lines that a large mesh has chosen landmarks."""
        libraries, pops = self.peers(Ours, MeshLib), 0
        picks = [self.ours.prepare(self.rung, pair) for pair in self.rung.across]
        for pair in itertools.cycle(picks):
            pops += self.ours.step_b(pair).report.pops
            if pops > POPS_OFTEN * len(self.rung.triangles):
                break
        for query, pair in enumerate(self.rung.across):
            self.add("step B, across, asked often", query, self.asks("step_b", libraries, pair))
            self.add("geodesic, across, asked often", query, self.asks("path", libraries, pair))

    def straighten(self):
        """Steps C and D alone: ours by its own clock, MeshLib's reducePath to convergence. Both in wall time."""
        theirs = self.opened.get(MeshLib.name)
        if theirs is None:
            return
        for query, pair in enumerate(self.rung.across):
            our_picks, their_picks = self.ours.prepare(self.rung, pair), theirs.prepare(self.rung, pair)
            walls = {Ours.name: [], MeshLib.name: []}
            for _ in range(self.rounds):
                seconds = self.ours.path(our_picks).report.seconds
                walls[Ours.name].append(1e3 * (seconds["relax"] + seconds["vertex_pass"]))
                (path,) = theirs.step_b(their_picks)
                began = time.perf_counter()
                theirs.library.reducePath(theirs.mesh, their_picks[0], path, their_picks[1], TO_CONVERGENCE)
                walls[MeshLib.name].append(1e3 * (time.perf_counter() - began))
            samples = {name: {"cpu": wall, "wall": wall} for name, wall in walls.items()}
            self.rows.append({"task": "steps C and D, across", "query": query, "samples": samples})

    def closed(self):
        picks = self.ours.prepare(self.rung, self.rung.ring)
        self.add("closed, 30 picks", 0, {name: self.closed_line(picks, **o) for name, o in SMOOTH_BY.items()})

    def closed_line(self, picks, **options):
        def run():
            try:
                return self.ours.mesh.polyline(picks, closed=True, **options)
            except sp.CollapsedError:
                return None  # legal: nothing holds it; the time is that of finding out

        return run

    def closed_outcomes(self):
        """How the closed lines ended: stop reason and crossings, or that they collapsed."""
        picks = self.ours.prepare(self.rung, self.rung.ring)
        lines = {name: self.closed_line(picks, **options)() for name, options in SMOOTH_BY.items()}
        return {n: "collapsed" if x is None else [x.report.stop_reason, len(x.points)] for n, x in lines.items()}

    def dragged(self):
        """One pick of ten to and fro between two neighbours, a line from the one before; two segments of MeshLib's."""
        both = [self.ours.prepare(self.rung, line) for line in (self.rung.dragged_line, self.rung.line)]

        def ours(**options):
            turns = itertools.cycle(both)
            line = self.ours.mesh.polyline(both[1], pinned="all", **options)

            def drag():
                nonlocal line
                line = line.with_picks(next(turns))
                return line

            return drag

        contenders = {name: ours(**options) for name, options in SMOOTH_BY.items()}
        theirs = self.opened.get(MeshLib.name)
        if theirs is not None:
            stretch = slice(DRAGGED - 1, DRAGGED + 2)
            lines = [theirs.prepare(self.rung, line[stretch]) for line in (self.rung.dragged_line, self.rung.line)]
            turns = itertools.cycle(lines)
            contenders["MeshLib, geodesic, two segments"] = lambda: theirs.path(next(turns))
        self.add("a dragged pick", 0, contenders)

    def stroke(self):
        drawn, mesh = self.rung.drawn, self.ours.mesh
        ways = {"none": {"filter": "none"}, **SMOOTH_BY}
        del ways["geodesic"]  # keeps nothing of a closed stroke
        runs = {name: lambda options=o: mesh.stroke(drawn, closed=True, **options) for name, o in ways.items()}
        self.add("a stroke of 2000 points", 0, runs)

    def network(self):
        """A line between every two of five picks: all in one call, which uses every core, and one after the other."""
        mesh, picks = self.ours.mesh, self.ours.prepare(self.rung, self.rung.line[:NETWORK_PICKS])
        pairs = list(itertools.combinations(range(len(picks)), 2))
        alone = [[picks[i], picks[j]] for i, j in pairs]
        for name in NETWORK_BY:
            options = SMOOTH_BY[name]
            contenders = {
                "in one call": lambda options=options: mesh.network(picks, pairs, **options),
                "one by one": lambda options=options: [mesh.polyline(pair, **options) for pair in alone],
            }
            self.add(f"network, {name}", 0, contenders)


def time_by_length(timer):
    """Milliseconds of lines of ever more crossings on one mesh: rows with "crossings" and CPU medians a contender."""
    rung, mesh = timer.rung, timer.ours.mesh
    start, goal = rung.across[0]
    way = timer.ours.path(timer.ours.prepare(rung, [start, goal]))
    corners = rung.triangles[way.triangles]
    stops = [int(corners[round(share * (len(corners) - 1))][0]) for share in LENGTH_SHARES[:-1]]
    rows = []
    for stop in dict.fromkeys([*stops, goal]):
        if stop == start:
            continue
        pair = [start, stop]
        contenders = timer.asks("path", timer.peers(MeshLib, Potpourri3d), pair)
        picks = timer.ours.prepare(rung, pair)
        for name in ("none", "geodesic", "linear", "cubic", "fair"):
            contenders[f"ours, {name}"] = lambda name=name, picks=picks: mesh.polyline(picks, filter=name)
        crossings = len(mesh.polyline(picks, filter="geodesic").points)
        samples = alternate(contenders, 3, timer.budget)
        rows.append({"crossings": crossings, "cpu": {n: sorted(s.cpu)[len(s.cpu) // 2] for n, s in samples.items()}})
    return rows
