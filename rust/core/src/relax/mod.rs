//! Step C, *geometrical optimisation*: ways to move all crossings of a strip to where a filter wants them.
//!
//! [`funnel`] straightens a strip exactly. On [`beads`], [`heap`] is the paper's one vertex at a time; [`newton`] and
//! [`implicit`] move all at once, with [`banded`] solves.

pub mod banded;
pub mod beads;
pub mod funnel;
pub mod heap;
pub mod implicit;
pub mod newton;
