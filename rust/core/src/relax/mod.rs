//! Step C, *geometrical optimisation*: ways to move all crossings of a strip to where a filter wants them.
//!
//! [`funnel`] straightens a strip exactly. On [`beads`], [`heap`] and [`sweeps`] move one vertex at a time (as [`swing`] tells), in the paper's
//! order and along the line; [`newton`] and [`implicit`] move all at once, with [`banded`] solves.

pub mod banded;
pub mod beads;
pub mod funnel;
pub mod heap;
pub mod implicit;
pub mod newton;
pub mod sweeps;
pub mod swing;
