//! Smooth curves that lie exactly on polygon meshes.
//!
//! The method is that of G.-P. Bonneau and S. Hahmann, *Smooth Polylines on Polygon Meshes* (2003), called "the
//! paper" throughout: picks are joined by a strip of triangles (step B, [`search`] and [`strip`]), the vertices of a
//! polyline slide on the strip's inner edges (step C), and where they meet mesh vertices the strip is changed
//! (step D). [`smooth`] drives the steps.
//!
//! This crate knows geometry alone: no Python, no files, no printing, no clock.

#![forbid(unsafe_code)]

pub mod adjacency;
pub mod band;
pub mod cells;
pub mod chain;
pub mod check;
pub mod closest_point;
pub mod cone;
pub mod connections;
pub mod diagonals;
pub mod dual_nodes;
pub mod dual_search;
pub mod edge_path;
pub mod embed;
pub mod error;
pub mod fair_again;
pub mod filter;
pub mod ids;
pub mod join;
pub mod kept;
pub mod landmarks;
pub mod large;
pub mod leg;
pub mod leg_by_leg;
pub mod loops;
pub mod mesh;
pub mod mesh_arrays;
pub mod morton;
pub mod network;
pub mod opened;
pub mod options;
pub mod patches;
pub mod pauses;
pub mod polygons;
pub mod polyline;
pub mod pool;
pub mod queue;
pub mod ray_cast;
pub mod regions;
pub mod relax;
pub mod remake;
pub mod report;
pub mod route;
pub mod samples;
pub mod search;
pub mod section;
pub mod self_crossings;
pub mod shaken;
pub mod sliding_pass;
pub mod sliding_stages;
pub mod sliding_steps;
pub mod smooth;
pub mod smooth_fair;
pub mod smooth_geodesic;
pub mod smooth_sliding;
pub mod span;
pub mod spot;
pub mod strip;
pub mod stroke;
pub mod surface_point;
pub mod trace;
pub mod triangle_tree;
pub mod turn;
pub mod unfold;
pub mod untangle;
pub mod vertex_pass;
pub mod way;
pub mod window;
mod window_promise;
pub mod window_search;

pub use error::{Error, MeshError, OptionError, Result};
pub use kept::{Kept, Made};
pub use mesh::{MeshReport, SurfaceMesh};
pub use options::{Filter, Knots, Options, Pinned, Solver};
pub use polyline::Polyline;
pub use report::{NoObserver, Observer, Report, Step, StopReason};
pub use surface_point::{Pick, SurfacePoint};
