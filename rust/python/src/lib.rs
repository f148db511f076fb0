//! The Python face of Smooth Polylines: numpy arrays in, numpy arrays out.
//!
//! Holds the checks of arguments, the mapping of errors and the classes; holds no geometry. Everything that is
//! decided about a line is decided in the core, which runs with the interpreter released (`border`).

use pyo3::prelude::*;

mod border;
mod choices;
mod closest_points;
mod crossings;
mod cut;
mod cut_calls;
mod edge_path;
mod errors;
mod frozen_arrays;
mod input_arrays;
mod limits;
mod line_options;
mod mesh;
mod mesh_lines;
mod mesh_report;
mod network;
mod network_calls;
mod patches;
mod picks;
mod polyline;
mod ray_hits;
mod report;
mod stroke_points;
mod surface_point;
mod threads;
mod with_picks;

/// The compiled part of `smooth_polylines`; import that package instead.
#[pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::closest_points::PyClosestPoints;
    #[pymodule_export]
    use crate::crossings::{PyCrossings, find_crossings};
    #[pymodule_export]
    use crate::cut::PyCut;
    #[pymodule_export]
    use crate::edge_path::PyEdgePath;
    #[pymodule_export]
    use crate::mesh::PySurfaceMesh;
    #[pymodule_export]
    use crate::mesh_report::PyMeshReport;
    #[pymodule_export]
    use crate::network::PyNetwork;
    #[pymodule_export]
    use crate::patches::PyPatches;
    #[pymodule_export]
    use crate::polyline::PyPolyline;
    #[pymodule_export]
    use crate::ray_hits::PyRayHits;
    #[pymodule_export]
    use crate::report::PyReport;
    #[pymodule_export]
    use crate::surface_point::PySurfacePoint;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::errors::add_to(module)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
