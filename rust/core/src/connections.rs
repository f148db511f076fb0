//! Which picks of a net are joined: as told, or by a word for it.
//!
//! Makes no lines; those are made in `network`.

use crate::cells::find_neighbours;
use crate::error::{OptionError, Result};
use crate::mesh::SurfaceMesh;
use crate::report::Observer;
use crate::surface_point::Pick;

/// Which picks are joined.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Connections {
    /// These pairs of positions in the picks.
    Pairs(Vec<[i128; 2]>),
    /// Each with each.
    All,
    /// Each with the next.
    Chain,
    /// Each with the next, the last with the first.
    Loop,
    /// Those that are neighbours on the surface (`cells`).
    Automatic,
}

impl Connections {
    /// The pairs.
    ///
    /// # Errors
    /// Picks out of range, too few of them for the word, [`crate::Error::Interrupted`].
    pub fn pairs(&self, mesh: &SurfaceMesh, picks: &[Pick], observer: &mut dyn Observer) -> Result<Vec<[i128; 2]>> {
        let count = picks.len() as i128;
        let least = if *self == Self::Loop { 3 } else { 2 };
        if !matches!(self, Self::Pairs(_)) && count < least {
            let message = format!("found {count} picks, but these connections need at least {least}");
            return Err(OptionError::new("picks", message).into());
        }
        Ok(match self {
            Self::Pairs(pairs) => pairs.clone(),
            Self::All => (0..count).flat_map(|i| (i + 1..count).map(move |j| [i, j])).collect(),
            Self::Chain => (1..count).map(|i| [i - 1, i]).collect(),
            Self::Loop => (0..count).map(|i| [i, (i + 1) % count]).collect(),
            Self::Automatic => {
                let resolve = |(i, pick)| mesh.resolve_pick(i, pick);
                let points = picks.iter().enumerate().map(resolve).collect::<Result<Vec<_>, _>>()?;
                find_neighbours(mesh, &points, observer)?.into_iter().map(|pair| pair.map(i128::from)).collect()
            }
        })
    }
}
