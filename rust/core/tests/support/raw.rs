//! Meshes, picks and options out of raw bytes: what the fuzz targets and the tests of their finds have in common.
//!
//! Any bytes mean something, so that a fuzzer wastes none. Holds no tests; the oracle is `check`, called from `judge`.

use glam::DVec3;
use smooth_polylines_core::check::check_polyline;
use smooth_polylines_core::options::{DEFAULT_SUPPORT, MAX_SUPPORT};
use smooth_polylines_core::smooth::polyline;
use smooth_polylines_core::stroke::{StrokePoints, stroke};
use smooth_polylines_core::{
    Error, Filter, Knots, NoObserver, Options, Pick, Pinned, Polyline, Solver, StopReason, SurfaceMesh,
};

/// Bytes read from the front; past their end there are zeros.
pub struct Raw<'a>(pub &'a [u8]);

impl Raw<'_> {
    pub fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    /// A whole number below `count`, from one byte.
    pub fn below(&mut self, count: usize) -> usize {
        self.byte() as usize % count
    }

    fn double(&mut self) -> f64 {
        f64::from_le_bytes([0; 8].map(|_| self.byte()))
    }

    /// Few values in one mode, so that places coincide; any bits in the last.
    fn coordinate(&mut self, mode: usize) -> f64 {
        match mode {
            0 => self.below(4) as f64,
            1 => f64::from(self.byte() as i8),
            2 => f64::from(i16::from_le_bytes([self.byte(), self.byte()])) / 256.0,
            3 => f64::from(self.byte() as i8) * 10f64.powi(i32::from(self.byte() as i8) / 4),
            _ => self.double(),
        }
    }

    /// Positions and triangles: a soup, a lattice (open, a tube, a torus, or turned over where it closes), or a fan.
    pub fn parts(&mut self) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let (mode, form, flat) = (self.below(5), self.below(6), self.byte());
        let (columns, rows) = (2 + self.below(7), 2 + self.below(7));
        let (count, triangles) = match form {
            0 => {
                let count = 3 + self.below(30);
                // Sometimes one vertex more than there is.
                let names = count + usize::from(flat & 64 != 0);
                let triangles = 1 + self.below(60);
                (count, (0..triangles).map(|_| [0; 3].map(|_| self.below(names) as u32)).collect())
            }
            5 => {
                let valence = 2 + self.below(60);
                let last = |i: usize| 1 + (i % (valence + usize::from(flat & 64 != 0))) as u32;
                (valence + 2, (0..valence).map(|i| [0, last(i), last(i + 1)]).collect())
            }
            wraps => {
                let at = |i: usize, j: usize| {
                    let is_over = wraps == 4 && i >= columns;
                    let j = if is_over { rows - j % rows } else { j };
                    let (i, j) = (if wraps >= 2 { i % columns } else { i }, if wraps >= 3 { j % rows } else { j });
                    (j * (columns + 1) + i) as u32
                };
                let mut triangles = Vec::new();
                for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    match self.byte() {
                        200.. => {}
                        turn if turn % 2 == 0 => triangles.extend([[a, b, c], [a, c, d]]),
                        _ => triangles.extend([[a, b, d], [b, c, d]]),
                    }
                }
                ((columns + 1) * (rows + 1), triangles)
            }
        };
        let squeeze = if flat & 1 == 0 { 1.0 } else { 10f64.powi(-i32::from(flat >> 4)) };
        let positions = (0..count).map(|v| {
            let own = DVec3::from_array([0; 3].map(|_| self.coordinate(mode)));
            let lattice = DVec3::new((v % (columns + 1)) as f64, (v / (columns + 1)) as f64, 0.0);
            // Also a lattice that is merely shaken.
            let place = if flat & 2 == 0 { own } else { lattice + own / 512.0 };
            place * DVec3::new(1.0, squeeze, if flat & 4 == 0 { 1.0 } else { 0.0 })
        });
        (positions.collect(), triangles)
    }

    fn pick(&mut self, triangles: usize) -> Pick {
        let kind = self.byte();
        let triangle = self.below(triangles + usize::from(kind == 255)) as i128;
        let parts = match kind % 6 {
            0..=2 => return Pick::Face(triangle),
            3 => [0; 3].map(|_| 1.0 + f64::from(self.byte())),
            4 => [1.0 + f64::from(self.byte()), f64::from(self.byte()), 0.0],
            _ => [0.0, 1.0, 0.0],
        };
        let sum: f64 = parts.iter().sum();
        Pick::Point { triangle, barycentric: parts.map(|part| part / sum) }
    }

    fn options(&mut self, picks: usize) -> Options {
        let flags = self.byte();
        let filter = [Filter::Linear, Filter::Cubic, Filter::Geodesic, Filter::Fair, Filter::None][self.below(5)];
        let is_paper = matches!(filter, Filter::Linear | Filter::Cubic);
        let pinned = match self.below(3) {
            0 => Pinned::Ends,
            1 => Pinned::All,
            _ => Pinned::Each((0..picks).map(|_| self.byte() % 2 == 0).collect()),
        };
        let detail = self.byte();
        Options {
            closed: flags & 1 != 0,
            filter,
            pinned,
            solver: if flags & 2 != 0 && is_paper { Solver::Heap } else { Solver::Auto },
            threshold: 10f64.powi(-1 - (flags >> 6) as i32),
            max_iterations: (flags & 28 == 28).then(|| 1 + u32::from(self.byte())),
            detail_size: match detail {
                _ if filter != Filter::Fair => None,
                0..=99 => None,
                100..=120 => Some(f64::INFINITY),
                size => Some(f64::from(size - 120) / 32.0),
            },
            knots: [Knots::Uniform, Knots::Centripetal, Knots::Chordal][self.below(3)],
            support: if filter == Filter::Cubic && flags & 32 != 0 {
                DEFAULT_SUPPORT + self.below(MAX_SUPPORT - DEFAULT_SUPPORT + 1)
            } else {
                DEFAULT_SUPPORT
            },
            stages: false,
        }
    }
}

/// A mesh out of bytes and a line on it, by picks or by a stroke: a line that keeps every promise, or a named error.
///
/// # Panics
/// Where a promise is broken: the fuzzer's find.
pub fn judge_line(data: &[u8]) {
    let mut raw = Raw(data);
    let is_stroke = raw.byte() % 4 == 0;
    let count = 1 + raw.below(9);
    let options = raw.options(count);
    let choices: Vec<u8> = (0..32).map(|_| raw.byte()).collect();
    let (positions, triangles) = raw.parts();
    let Ok(mesh) = SurfaceMesh::new(positions, triangles, None) else { return };
    if mesh.triangles().is_empty() {
        return;
    }
    let mut choices = Raw(&choices);
    let picks: Vec<Pick> = (0..count).map(|_| choices.pick(mesh.triangles().len())).collect();
    let made = if is_stroke {
        let near = |pick: &Pick| {
            let point = mesh.resolve_pick(0, pick).ok()?;
            Some(mesh.position_of(&point) + DVec3::new(0.1, -0.1, 0.2))
        };
        let Some(points) = picks.iter().map(near).collect::<Option<Vec<DVec3>>>() else { return };
        stroke(&mesh, &StrokePoints::Space(points), &options, &mut NoObserver)
    } else {
        polyline(&mesh, &picks, &options, &mut NoObserver)
    };
    match made {
        Ok(line) => judge(&mesh, &line, &options),
        Err(Error::Interrupted | Error::Mesh(_)) => panic!("an error that this call cannot have"),
        Err(_) => {}
    }
}

/// What any finished line has to keep, beside what `check` can tell: filters that have a limit reach it.
fn judge(mesh: &SurfaceMesh, line: &Polyline, options: &Options) {
    if let Err(error) = check_polyline(mesh, line) {
        panic!("{error}; {options:?}");
    }
    let has_limit = matches!(options.filter, Filter::Geodesic | Filter::Fair) && options.max_iterations.is_none();
    let reason = line.report.stop_reason;
    let is_there = matches!(reason, StopReason::Converged | StopReason::ConvergedAtVertices);
    assert!(!has_limit || is_there, "{reason:?} after {} rounds; {options:?}", line.report.iterations);
}

/// A line read from raw bytes: refused, or a line with all promises but those of smoothing, that goes through bytes again.
///
/// # Panics
/// Where a promise is broken: the fuzzer's find.
pub fn judge_bytes(data: &[u8]) {
    let mut raw = Raw(data);
    let form = super::shapes::fan(3 + raw.below(5), 0.2);
    let mesh = match raw.below(4) {
        0 => super::shapes::irregular_grid(4, 3).mesh(),
        1 => super::shapes::moebius(6, 2).mesh(),
        2 => super::shapes::book(3, 2).mesh(),
        _ => form.mesh(),
    };
    let Ok(line) = Polyline::from_bytes(&mesh, raw.0) else { return };
    assert!(line.points.iter().all(|p| p.is_finite()), "points that are not finite");
    let again = line.to_bytes(&mesh);
    let read = Polyline::from_bytes(&mesh, &again).expect("what was written can be read");
    assert!(read == line, "another line after writing and reading");
    assert_eq!(read.to_bytes(&mesh), again);
}

/// Any positions and triangles: refused by name, or a mesh whose report and search hold together.
///
/// # Panics
/// Where a promise is broken: the fuzzer's find.
pub fn judge_mesh(data: &[u8]) {
    let mut raw = Raw(data);
    let has_faces = raw.byte() % 3 == 0;
    let (positions, triangles) = raw.parts();
    let faces = has_faces.then(|| triangles.iter().map(|_| u32::from(raw.byte() % 8)).collect());
    let is_legal = |t: &[u32; 3]| {
        let sound = |v: u32| positions.get(v as usize).is_some_and(|p| p.is_finite() && p.abs().max_element() <= 1e150);
        t.iter().all(|&v| sound(v)) && t[0] != t[1] && t[1] != t[2] && t[2] != t[0]
    };
    let expected = triangles.iter().all(is_legal);
    let made = SurfaceMesh::new(positions.clone(), triangles.clone(), faces);
    assert_eq!(made.is_ok(), expected, "{:?}", made.err());
    let Ok(mesh) = made else { return };
    let report = mesh.report();
    assert_eq!((report.vertices, report.triangles), (positions.len(), triangles.len()));
    // Every edge counted by hand.
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for t in &triangles {
        edges.extend([[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|[a, b]| [a.min(b), a.max(b)]));
    }
    edges.sort_unstable();
    let runs: Vec<usize> = edges.chunk_by(|a, b| a == b).map(<[_]>::len).collect();
    let of = |is: fn(&usize) -> bool| runs.iter().filter(|n| is(n)).count();
    assert_eq!(report.edges, runs.len());
    assert_eq!(report.boundary_edges, of(|&n| n == 1));
    assert_eq!(report.wall_edges, of(|&n| n > 2));
    // The nearest point of the surface is no farther than any corner.
    if let Some(&p) =
        positions.first().filter(|p| p.is_finite() && p.abs().max_element() < 1e100 && !triangles.is_empty())
    {
        let found = mesh.closest_points(&[p + 0.25], "points", &mut NoObserver).expect("a finite point")[0];
        let corners = triangles.iter().flatten().map(|&v| positions[v as usize].distance(p + 0.25));
        let nearest = corners.fold(f64::INFINITY, f64::min);
        assert!(found.distance <= nearest * (1.0 + 1e-12), "{} for a corner at {nearest}", found.distance);
    }
}
