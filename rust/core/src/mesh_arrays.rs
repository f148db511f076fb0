//! What positions and triangles must be to make a mesh, and the first thing that is wrong with them.
//!
//! Judges arrays alone; what is found on a sound mesh (boundaries, walls, parts) is in [`crate::mesh::MeshReport`].

use glam::DVec3;

use crate::error::MeshError;

/// Half-edge ids are `u32` and the last one marks "none".
const MAX_TRIANGLES: usize = (u32::MAX as usize - 1) / 3;

/// Squares of larger ones overflow.
pub const MAX_COORDINATE: f64 = 1e150;

/// Whether the arrays are as long as they should and may be.
pub fn check_sizes(positions: &[DVec3], triangles: &[[u32; 3]], faces: Option<&[u32]>) -> Result<(), MeshError> {
    let too_large = |argument, found, limit| Err(MeshError::TooLarge { argument, found, limit });
    if triangles.len() > MAX_TRIANGLES {
        return too_large("triangles", triangles.len(), MAX_TRIANGLES);
    }
    if positions.len() > u32::MAX as usize {
        return too_large("positions", positions.len(), u32::MAX as usize);
    }
    match faces {
        Some(faces) if faces.len() != triangles.len() => {
            Err(MeshError::FaceCount { found: faces.len(), expected: triangles.len() })
        }
        _ => Ok(()),
    }
}

/// Whether all corners are there, differ, and are finite.
pub fn check_triangles(positions: &[DVec3], triangles: &[[u32; 3]]) -> Result<(), MeshError> {
    // Almost always all positions are sound, and then their triangles need not be asked for them.
    let is_sound = |p: &DVec3| p.abs().max_element() <= MAX_COORDINATE && p.is_finite();
    let are_sound = positions.iter().all(is_sound);
    let count = positions.len();
    for (triangle, &corners) in triangles.iter().enumerate() {
        let [a, b, c] = corners;
        let is_in_range = corners.iter().all(|&v| (v as usize) < count);
        if !is_in_range || a == b || b == c || c == a || !are_sound {
            check_triangle(positions, triangle, corners)?;
        }
    }
    Ok(())
}

fn check_triangle(positions: &[DVec3], triangle: usize, corners: [u32; 3]) -> Result<(), MeshError> {
    for v in corners {
        let Some(p) = positions.get(v as usize) else {
            return Err(MeshError::IndexOutOfRange { triangle, index: v.into(), vertices: positions.len() });
        };
        if !p.is_finite() {
            return Err(MeshError::NotFinite { vertex: v, position: p.to_array(), triangle });
        }
        if p.abs().max_element() > MAX_COORDINATE {
            return Err(MeshError::TooFar { vertex: v, position: p.to_array() });
        }
    }
    let [a, b, c] = corners;
    if a == b || b == c || c == a {
        return Err(MeshError::RepeatedVertex { triangle, corners });
    }
    Ok(())
}
