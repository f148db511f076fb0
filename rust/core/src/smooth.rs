//! skeleton
#![allow(missing_docs, clippy::todo)]
use crate::{error::*, mesh::*, options::*, polyline::*, report::*, surface_point::*};
pub fn polyline(_mesh: &SurfaceMesh, _picks: &[Pick], _options: &Options, _observer: &mut dyn Observer) -> Result<Polyline> { todo!() }
/// One result a connection; the outer error is for wrong arguments (a connection out of range).
pub fn network(_mesh: &SurfaceMesh, _picks: &[Pick], _connections: &[[i128; 2]], _options: &Options, _observer: &mut dyn Observer) -> Result<Vec<Result<Polyline>>> { todo!() }
