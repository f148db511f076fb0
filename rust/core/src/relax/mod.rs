//! Step C, *geometrical optimisation*: ways to move all crossings of a strip to where a filter wants them.
//!
//! [`funnel`] straightens a strip exactly.

pub mod funnel;
