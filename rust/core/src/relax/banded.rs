//! Solving band systems of a ring or a chain of unknowns, in O(n).
//!
//! Row `i` couples unknowns `i - k` to `i + k`; on a ring indices wrap. The last `k` unknowns are eliminated last (a Schur
//! complement), which makes the rest a plain band matrix also on a ring. Holds linear algebra alone.

use std::convert::Infallible;

use crate::large::LargeVec;

/// A band matrix of half-width `k`; entry `(i, i + j - k)` is `entries[i * (2 k + 1) + j]`, indices wrapping on a ring.
#[derive(Clone, Debug)]
pub struct Banded {
    half_width: usize,
    entries: LargeVec<f64>,
}

impl Banded {
    /// The zero matrix of `count` rows.
    pub fn zero(count: usize, half_width: usize) -> Self {
        Self { half_width, entries: vec![0.0; count * (2 * half_width + 1)].into() }
    }

    fn width(&self) -> usize {
        2 * self.half_width + 1
    }

    fn count(&self) -> usize {
        self.entries.len() / self.width()
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.entries[i * self.width()..(i + 1) * self.width()]
    }

    /// Adds to the entry in row `i` at `offset` (from `-k` to `k`) from the diagonal.
    #[inline]
    pub fn add(&mut self, i: usize, offset: isize, value: f64) {
        let place = i * self.width() + (self.half_width as isize + offset) as usize;
        self.entries[place] += value;
    }

    /// Makes row `i` the identity's.
    pub fn fix(&mut self, i: usize) {
        let (width, diagonal) = (self.width(), self.half_width);
        let row = &mut self.entries[i * width..(i + 1) * width];
        row.fill(0.0);
        row[diagonal] = 1.0;
    }

    /// The matrix once more; `tick` is called now and then, and may end the work with an error.
    ///
    /// # Errors
    /// Those of `tick`.
    pub fn copied<E>(&self, tick: impl FnMut() -> Result<(), E>) -> Result<Self, E> {
        Ok(Self { half_width: self.half_width, entries: LargeVec::copied(&self.entries, tick)? })
    }

    /// Solves for `right`, on a ring or a chain; `None` when a pivot vanishes. Small systems and the border are dense.
    pub fn solve(&self, right: &[f64], is_ring: bool) -> Option<Vec<f64>> {
        self.clone().into_solution(right, is_ring, || Ok::<_, Infallible>(())).unwrap_or_else(|never| match never {})
    }

    /// As [`Banded::solve`], in the matrix's own memory; `tick` is called with every row that is done, and may end the work
    /// with an error.
    ///
    /// # Errors
    /// Those of `tick`.
    pub fn into_solution<E>(
        mut self,
        right: &[f64],
        is_ring: bool,
        mut tick: impl FnMut() -> Result<(), E>,
    ) -> Result<Option<Vec<f64>>, E> {
        let (n, k, width) = (self.count(), self.half_width, self.width());
        if n <= 4 * k + 2 {
            return Ok(solve_dense(self.dense(is_ring), right.to_vec()));
        }
        if !is_ring {
            // No row reaches across the ends: there is no border to put in.
            let mut x = LargeVec::copied(right, &mut tick)?;
            let is_solved = eliminate(&mut self.entries, &mut x, k, 1, &mut tick)?;
            return Ok((is_solved && x.iter().all(|v| v.is_finite())).then(|| x.take()));
        }
        let body = n - k;
        // Columns to solve for: the right side, then the border columns.
        let (band, border_rows) = self.entries.split_at_mut(body * width);
        let mut columns = LargeVec::from(vec![0.0; body * (k + 1)]);
        for i in 0..body {
            tick()?;
            columns[i * (k + 1)] = right[i];
            for j in 0..width {
                let wraps = i + j < k || i + j - k >= n;
                let column = (i + n + j - k) % n;
                if column >= body {
                    columns[i * (k + 1) + 1 + column - body] += band[i * width + j];
                }
                // Across the seam only the border can be reached, as n > 4 k.
                if column >= body || wraps {
                    band[i * width + j] = 0.0;
                }
            }
        }
        if !eliminate(band, &mut columns, k, k + 1, &mut tick)? {
            return Ok(None);
        }
        // The border's own equations, with the body put in.
        let mut dense = vec![vec![0.0; k]; k];
        let mut rest = vec![0.0; k];
        for b in 0..k {
            let i = body + b;
            rest[b] = right[i];
            for (j, &value) in border_rows[b * width..(b + 1) * width].iter().enumerate() {
                let column = (i + n + j - k) % n;
                if column >= body {
                    dense[b][column - body] += value;
                    continue;
                }
                let solved = &columns[column * (k + 1)..(column + 1) * (k + 1)];
                rest[b] -= value * solved[0];
                dense[b].iter_mut().zip(&solved[1..]).for_each(|(entry, c)| *entry -= value * c);
            }
        }
        let Some(border) = solve_dense(dense, rest) else { return Ok(None) };
        let body_value = |c: &[f64]| c[0] - c[1..].iter().zip(&border).map(|(a, b)| a * b).sum::<f64>();
        let mut x = LargeVec::with_capacity(n);
        for solved in columns.chunks(k + 1) {
            tick()?;
            x.push(body_value(solved));
        }
        x.extend(&border);
        Ok(x.iter().all(|v| v.is_finite()).then(|| x.take()))
    }

    fn dense(&self, is_ring: bool) -> Vec<Vec<f64>> {
        let (n, k) = (self.count() as isize, self.half_width as isize);
        let mut dense = vec![vec![0.0; n as usize]; n as usize];
        for (i, dense_row) in dense.iter_mut().enumerate() {
            for (j, value) in self.row(i).iter().enumerate() {
                let column = i as isize + j as isize - k;
                if (0..n).contains(&column) || is_ring {
                    dense_row[column.rem_euclid(n) as usize] += value;
                }
            }
        }
        dense
    }
}

/// Gaussian elimination of a plain band matrix without exchanging rows (the systems here are symmetric and positive, or
/// close to diagonally dominant); the `count` columns become the solutions. False when a pivot vanishes.
fn eliminate<E>(
    band: &mut [f64],
    columns: &mut [f64],
    k: usize,
    count: usize,
    tick: &mut impl FnMut() -> Result<(), E>,
) -> Result<bool, E> {
    // Compiled once more for each of the sizes that are solved often: loops of known length, a third of the time.
    match (k, count) {
        (1, 1) => eliminate_rows(band, columns, 1, 1, tick),
        (5, 1) => eliminate_rows(band, columns, 5, 1, tick),
        (5, 6) => eliminate_rows(band, columns, 5, 6, tick),
        _ => eliminate_rows(band, columns, k, count, tick),
    }
}

#[inline(always)]
fn eliminate_rows<E>(
    band: &mut [f64],
    columns: &mut [f64],
    k: usize,
    count: usize,
    tick: &mut impl FnMut() -> Result<(), E>,
) -> Result<bool, E> {
    let width = 2 * k + 1;
    let n = band.len() / width;
    for i in 0..n {
        tick()?;
        let (done, below) = band.split_at_mut((i + 1) * width);
        let (solved, open) = columns.split_at_mut((i + 1) * count);
        let (row, values) = (&done[i * width + k..][..k + 1], &solved[i * count..][..count]);
        let pivot = row[0];
        if pivot == 0.0 || !pivot.is_finite() {
            return Ok(false);
        }
        let rows = below.chunks_exact_mut(width).zip(open.chunks_exact_mut(count)).take(k);
        for (start, (target, target_values)) in (0..k).rev().zip(rows) {
            let factor = target[start] / pivot;
            if factor == 0.0 {
                continue;
            }
            target[start..][..k + 1].iter_mut().zip(row).for_each(|(entry, v)| *entry -= factor * v);
            target_values.iter_mut().zip(values).for_each(|(entry, v)| *entry -= factor * v);
        }
    }
    for i in (0..n).rev() {
        tick()?;
        let (open, solved) = columns.split_at_mut((i + 1) * count);
        let row = &band[i * width + k..][..k + 1];
        for (c, value) in open[i * count..].iter_mut().enumerate() {
            let known: f64 = row[1..].iter().zip(solved.chunks_exact(count)).map(|(entry, v)| entry * v[c]).sum();
            *value = (*value - known) / row[0];
        }
    }
    Ok(true)
}

fn solve_dense(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Option<Vec<f64>> {
    let n = matrix.len();
    for i in 0..n {
        let pivot = (i..n).max_by(|&a, &b| matrix[a][i].abs().total_cmp(&matrix[b][i].abs()))?;
        matrix.swap(i, pivot);
        right.swap(i, pivot);
        if matrix[i][i] == 0.0 || !matrix[i][i].is_finite() {
            return None;
        }
        for row in i + 1..n {
            let factor = matrix[row][i] / matrix[i][i];
            let (head, tail) = matrix.split_at_mut(row);
            for (target, source) in tail[0][i..].iter_mut().zip(&head[i][i..]) {
                *target -= factor * source;
            }
            right[row] -= factor * right[i];
        }
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|j| matrix[i][j] * right[j]).sum();
        right[i] = (right[i] - sum) / matrix[i][i];
    }
    right.iter().all(|v| v.is_finite()).then_some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_and_rings_of_all_sizes_are_solved() {
        for (k, n) in (1..=2).flat_map(|k| (1..30).map(move |n| (k, n))) {
            for is_ring in [false, true] {
                let mut matrix = Banded::zero(n, k);
                for i in 0..n {
                    for offset in -(k as isize)..=k as isize {
                        let value = ((i * 7 + (offset + 3) as usize * 5) % 11) as f64 / 11.0 - 0.5;
                        matrix.add(i, offset, if offset == 0 { 4.0 + value } else { value });
                    }
                }
                let x: Vec<f64> = (0..n).map(|i| (i as f64 * 0.7).sin()).collect();
                let dense = matrix.dense(is_ring);
                let right: Vec<f64> = dense.iter().map(|row| row.iter().zip(&x).map(|(a, b)| a * b).sum()).collect();
                let found = matrix.solve(&right, is_ring).expect("a dominant diagonal");
                for (a, b) in found.iter().zip(&x) {
                    assert!((a - b).abs() < 1e-12, "k {k} n {n} ring {is_ring}: {a} {b}");
                }
            }
        }
    }
}
