//! Triangles in the order of a curve through space, so that neighbours in space are neighbours in memory.
//!
//! Holds barycentres, the order of their Morton (Z-order) codes, and the radix sort for it. Source of the curve: G. Morton
//! 1966, *A Computer Oriented Geodetic Data Base and a New Technique in File Sequencing*.

use glam::DVec3;
use rayon::prelude::*;

/// Cells a side, as bits: 2^10 cells resolve a million triangles, and a code fits into 32 bits.
const BITS: u32 = 10;

/// Triangles that one thread takes at least: about 50 microseconds of work, several times what handing it over costs.
const TRIANGLES_PER_TASK: usize = 8192;

/// Where triangles are, and their order along the curve.
#[derive(Debug)]
pub struct CurveOrder {
    /// One a triangle.
    pub barycentres: Vec<DVec3>,
    /// Triangle ids along the curve, ties by id.
    pub order: Vec<u32>,
}

impl CurveOrder {
    /// Positions of all corners must be finite. Cost: O(triangles), on as many threads as there are.
    pub fn new(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let place = |t| barycentre(positions, t);
        let barycentres: Vec<DVec3> = triangles.par_iter().with_min_len(TRIANGLES_PER_TASK).map(place).collect();
        let order = morton_order(barycentres.len(), |i| barycentres[i]);
        Self { barycentres, order }
    }
}

/// Triangle ids along the curve, ties by id, without keeping barycentres. Cost: O(triangles).
pub fn curve_order(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<u32> {
    morton_order(triangles.len(), |i| barycentre(positions, &triangles[i]))
}

/// Where a triangle is.
#[inline]
pub fn barycentre(positions: &[DVec3], triangle: &[u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|v| positions[v as usize]);
    (a + b + c) / 3.0
}

/// The cube that the curve fills.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    low: DVec3,
    scale: f64,
}

impl Frame {
    /// The cube round the barycentres of all triangles. Cost: O(triangles).
    pub fn of_triangles(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        Self::of_points(triangles.iter().map(|t| barycentre(positions, t)))
    }

    fn of_points(points: impl Iterator<Item = DVec3>) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in points {
            (low, high) = (low.min(p), high.max(p));
        }
        let size = (high - low).max_element();
        let scale = if size > 0.0 { f64::from((1u32 << BITS) - 1) / size } else { 0.0 };
        Self { low, scale }
    }

    /// What points are sorted by: the code of the place, ties by index.
    #[inline]
    pub fn key(&self, point: DVec3, index: u32) -> u64 {
        let cell = (point - self.low) * self.scale;
        let code = spread(cell.x as u32) | spread(cell.y as u32) << 1 | spread(cell.z as u32) << 2;
        u64::from(code) << 32 | u64::from(index)
    }
}

/// Indices of so many points along the curve, ties by index.
fn morton_order(count: usize, point: impl Fn(usize) -> DVec3 + Sync) -> Vec<u32> {
    let frame = Frame::of_points((0..count).map(&point));
    let key = |i: usize| frame.key(point(i), i as u32);
    let keys: Vec<u64> = (0..count).into_par_iter().with_min_len(TRIANGLES_PER_TASK).map(key).collect();
    sort_by_code(keys).into_iter().map(|key| key as u32).collect()
}

/// Sorts keys, whose low halves rise, by their high halves: three stable counting sorts of ten bits each (D. Knuth, *The
/// Art of Computer Programming*, volume 3, section 5.2.5).
fn sort_by_code(mut keys: Vec<u64>) -> Vec<u64> {
    let digit = |key: u64, pass: u32| (key >> (32 + BITS * pass)) as usize & ((1 << BITS) - 1);
    let mut counts = [[0u32; 1 << BITS]; 3];
    for &key in &keys {
        for (pass, count) in counts.iter_mut().enumerate() {
            count[digit(key, pass as u32)] += 1;
        }
    }
    let mut sorted = vec![0u64; keys.len()];
    for (pass, count) in counts.iter_mut().enumerate() {
        let mut start = 0;
        for slot in count.iter_mut() {
            start += std::mem::replace(slot, start);
        }
        for &key in &keys {
            let slot = &mut count[digit(key, pass as u32)];
            sorted[*slot as usize] = key;
            *slot += 1;
        }
        std::mem::swap(&mut keys, &mut sorted);
    }
    keys
}

/// The low ten bits of `x`, two zeroes after each.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_leaves_two_zeroes_after_each_bit() {
        for bit in 0..10 {
            assert_eq!(spread(1 << bit), 1 << (3 * bit));
        }
        assert_eq!(spread(0x3ff), 0o1_111_111_111);
    }

    #[test]
    fn the_radix_sort_is_a_sort() {
        let mut seed = 1u64;
        let keys: Vec<u64> = (0..5000)
            .map(|i| {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                // Few different codes, so that there are ties.
                (seed >> 34 & if i % 2 == 0 { 0x3fff_ffff } else { 0x3000_0003 }) << 32 | i
            })
            .collect();
        let mut expected = keys.clone();
        expected.sort_unstable();
        assert_eq!(sort_by_code(keys), expected);
        assert_eq!(sort_by_code(Vec::new()), Vec::<u64>::new());
    }

    #[test]
    fn points_in_one_place_keep_their_order() {
        assert_eq!(morton_order(5, |_| DVec3::ONE), [0, 1, 2, 3, 4]);
    }
}
