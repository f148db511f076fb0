//! The filters: what step C moves the line towards, one file each.

pub mod closed_geodesic;
pub mod geodesic;
