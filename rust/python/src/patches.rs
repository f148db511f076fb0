//! `Patches`: what the lines of a net part a mesh into.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use smooth_polylines_core::patches::{Patch, Patches, find_patches};

use crate::border::run_detached;
use crate::cut::PyCut;
use crate::frozen_arrays::{freeze_owned, freeze_vector, id_rows};

/// Patches of a mesh that was cut along lines; made by `Network.patches`.
///
/// A patch is what can be reached without stepping over a line; patches are numbered by their lowest triangle. All arrays
/// are read-only and fresh at each access.
#[pyclass(frozen, module = "smooth_polylines", name = "Patches")]
pub struct PyPatches {
    cut: Py<PyCut>,
    found: Patches,
}

impl PyPatches {
    /// Finds the patches of a cut.
    pub fn new(py: Python<'_>, cut: Py<PyCut>) -> PyResult<Self> {
        let (mesh, embedding) = cut.get().parts();
        let found = run_detached(py, || find_patches(mesh, embedding, &embedding.triangles(mesh).triangles))?;
        Ok(Self { cut, found })
    }

    fn column<T: numpy::Element>(&self, py: Python<'_>, value: impl Fn(&Patch) -> T) -> PyResult<Py<PyArray1<T>>> {
        freeze_vector(py, self.found.patches.iter().map(value).collect())
    }

    fn count_of_sides(&self, sides: u32) -> usize {
        self.found.patches.iter().filter(|patch| patch.euler == 1 && patch.sides == sides).count()
    }
}

#[pymethods]
impl PyPatches {
    /// The cut mesh: a Cut.
    #[getter]
    fn cut(&self, py: Python<'_>) -> Py<PyCut> {
        self.cut.clone_ref(py)
    }

    /// The patch of each triangle of the cut: (F',) int32.
    #[getter]
    fn triangle_patches(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        freeze_vector(py, self.found.of_triangles.iter().map(|&patch| patch as i32).collect())
    }

    /// The patch of each polygon of the cut: (P',) int32.
    #[getter]
    fn polygon_patches(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        let (mesh, embedding) = self.cut.get().parts();
        let polygons = run_detached(py, || embedding.polygons(mesh))?;
        let mut patches = vec![-1; polygons.parents.len()];
        for (&polygon, &patch) in polygons.of_triangles.iter().zip(&self.found.of_triangles) {
            patches[polygon as usize] = patch as i32;
        }
        freeze_vector(py, patches)
    }

    /// Triangles in each: (n,) int32.
    #[getter]
    fn triangle_counts(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        self.column(py, |patch| patch.triangles as i32)
    }

    /// Area of each: (n,) float64, in the squared unit of the positions.
    #[getter]
    fn areas(&self, py: Python<'_>) -> PyResult<Py<PyArray1<f64>>> {
        self.column(py, |patch| patch.area)
    }

    /// Sides of each: (n,) int32: stretches of its outline between corners, which are where lines meet or end, or come to
    /// the mesh's boundary. A loop without a corner has one side; a line that ends inside a patch is passed on both sides.
    #[getter]
    fn sides(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        self.column(py, |patch| patch.sides as i32)
    }

    /// Closed loops of each one's outline: (n,) int32.
    #[getter]
    fn loops(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        self.column(py, |patch| patch.loops as i32)
    }

    /// Euler characteristic of each, opened along the lines: (n,) int32; 1 for a disc.
    #[getter]
    fn euler(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i32>>> {
        self.column(py, |patch| patch.euler as i32)
    }

    /// Pairs of patches that meet at a line, lower first, each once: (m, 2) int32. A patch that has a line in its inside
    /// meets itself.
    #[getter]
    fn adjacency(&self, py: Python<'_>) -> PyResult<Py<PyArray2<i32>>> {
        freeze_owned(py, id_rows(self.found.neighbours.clone()))
    }

    /// Discs of three sides: an int.
    #[getter]
    fn three_sided(&self) -> usize {
        self.count_of_sides(3)
    }

    /// Discs of four sides: an int.
    #[getter]
    fn four_sided(&self) -> usize {
        self.count_of_sides(4)
    }

    /// Patches that are no discs, for they have a hole or a handle in them: an int.
    #[getter]
    fn not_discs(&self) -> usize {
        self.found.patches.iter().filter(|patch| patch.euler != 1).count()
    }

    fn __len__(&self) -> usize {
        self.found.patches.len()
    }

    fn __repr__(&self) -> String {
        let count = self.found.patches.len();
        let plural = if count == 1 { "" } else { "es" };
        format!(
            "<Patches: {count} patch{plural}, {} of three sides, {} of four>",
            self.three_sided(),
            self.four_sided()
        )
    }
}
