//! Several lines on one set of picks, made side by side on as many threads as there are.
//!
//! Each line is what `smooth::polyline` makes of its two picks, to the bit, whatever the number of threads. Holds no
//! geometry.

use rayon::prelude::*;

use crate::error::{Error, OptionError, Result};
use crate::mesh::SurfaceMesh;
use crate::options::Options;
use crate::polyline::Polyline;
use crate::report::Observer;
use crate::smooth::polyline;
use crate::surface_point::Pick;

/// Lines of the first batch; each further one has as many as have been made. Landmarks are chosen between batches alone, so
/// that the report of a line does not tell which thread was first.
const FIRST_BATCH: usize = 16;

/// One result for each of `connections`, which are pairs of positions in `picks`, in their order.
///
/// `observe(i)` gives the observer of line `i`, which works on the thread that makes the line and is returned with it. All
/// of them have to stop once one does: then so does the network. It is also called for the choice of landmarks.
///
/// # Errors
/// Options out of range, or a connection that names no pick; what befalls a single line is in its own result.
/// [`Error::Interrupted`] when an observer says so.
pub fn network<O: Observer + Send>(
    mesh: &SurfaceMesh,
    picks: &[Pick],
    connections: &[[i128; 2]],
    options: &Options,
    observe: impl Fn(usize) -> O + Sync,
) -> Result<Vec<(Result<Polyline>, O)>> {
    options.check()?;
    if options.closed {
        return Err(
            OptionError::new("closed", "the lines of a network are open; connect its picks in a ring instead").into()
        );
    }
    for (row, connection) in connections.iter().enumerate() {
        if let Some(index) = connection.iter().find(|&&i| !(0..picks.len() as i128).contains(&i)) {
            let message = format!("row {row} names pick {index}, but there are {} picks (counted from 0)", picks.len());
            return Err(OptionError::new("connections", message).into());
        }
    }
    let make = |row: usize| {
        let places = connections[row].map(|i| i as usize);
        let mut observer = observe(row);
        let line = polyline(mesh, &places.map(|i| picks[i]), options, &mut observer);
        observer.finish();
        (line.map_err(|error| error.with_picks(places)), observer)
    };
    let mut lines = Vec::with_capacity(connections.len());
    while lines.len() < connections.len() {
        let start = lines.len();
        let end = connections.len().min(start + FIRST_BATCH.max(start));
        let first = connections[start][0] as usize;
        if let Ok(near) = mesh.resolve_pick(first, &picks[first]) {
            mesh.dual_graph().choose_landmarks_if_due(near.triangle, &mut observe(start))?;
        }
        let _held = mesh.dual_graph().hold_landmarks();
        lines.par_extend((start..end).into_par_iter().with_max_len(1).map(&make));
    }
    if lines.iter().any(|(line, _)| *line == Err(Error::Interrupted)) {
        return Err(Error::Interrupted);
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use glam::DVec3;

    use super::*;
    use crate::report::Step;

    /// Counts the steps and the ends of one line.
    struct Count {
        row: usize,
        steps: u32,
        ends: u32,
        stop_row: usize,
    }

    impl Observer for Count {
        fn step(&mut self, _: Step) -> ControlFlow<()> {
            self.steps += 1;
            if self.row == self.stop_row { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }

        fn finish(&mut self) {
            self.ends += 1;
        }
    }

    #[test]
    fn every_line_has_an_observer_of_its_own_and_one_can_stop_them_all() {
        let positions = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let mesh = SurfaceMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]], None).expect("a square");
        let picks = [Pick::Face(0), Pick::Face(1)];
        let rows: Vec<[i128; 2]> = (0..20).map(|i| if i % 2 == 0 { [0, 1] } else { [1, 0] }).collect();
        let with = |stop_row| {
            let observe = |row| Count { row, steps: 0, ends: 0, stop_row };
            network(&mesh, &picks, &rows, &Options::default(), observe)
        };
        for (row, (line, seen)) in with(99).expect("lines").into_iter().enumerate() {
            assert_eq!((seen.row, seen.ends), (row, 1));
            assert!(seen.steps >= 3);
            assert_eq!(line.expect("a line").strip[0].index(), row % 2);
        }
        assert_eq!(with(7).err(), Some(Error::Interrupted));
    }
}
