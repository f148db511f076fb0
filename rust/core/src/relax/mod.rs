//! Step C, *geometrical optimisation*: ways to move all crossings of a strip to where a filter wants them.
//!
//! [`funnel`] straightens a strip exactly; [`heap`] is the paper's, one vertex at a time, on [`beads`].

pub mod beads;
pub mod funnel;
pub mod heap;
