//! What the fuzz targets share: the decoder and the oracles that the core's own tests of old finds use too.
//!
//! Outside the workspace, so that nothing of it is in a normal build or in its lock file.
#![allow(dead_code, missing_docs, reason = "the targets use a part of what the tests share")]

#[path = "../../core/tests/support/random.rs"]
pub mod random;
#[path = "../../core/tests/support/raw.rs"]
pub mod raw;
#[path = "../../core/tests/support/shapes.rs"]
pub mod shapes;
