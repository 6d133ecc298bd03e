//! Elimination of a symmetric system in tiles of four rows and four columns.
//!
//! Rows that a block of four has too many carry a one on the diagonal and nothing else. Every tile is taken out, worked on and put back
//! whole, so that the compiler finds vector instructions and need not ask whether rows overlap.

use alloc::{vec, vec::Vec};

use crate::four::{Four, Machine};

/// Four rows of four columns.
pub(super) type Tile = [Four; 4];

/// A symmetric positive definite matrix by its upper tiles, later its factors `U^t diag U`.
#[derive(Clone, Debug)]
pub(super) struct System {
    blocks: usize,
    /// Row after row; of the tiles on the diagonal the upper triangle counts - (blocks x blocks).
    tiles: Vec<Tile>,
    inverse_pivots: Vec<Four>,
}

impl System {
    pub(super) fn new(blocks: usize) -> Self {
        System { blocks, tiles: vec![[[0.0; 4]; 4]; blocks * blocks], inverse_pivots: vec![[1.0; 4]; blocks] }
    }

    #[inline(always)]
    fn tile(&self, row: usize, column: usize) -> Tile {
        self.tiles.get(row * self.blocks + column).copied().unwrap_or_default()
    }

    #[inline(always)]
    pub(super) fn set(&mut self, row: usize, column: usize, tile: Tile) {
        if let Some(place) = self.tiles.get_mut(row * self.blocks + column) {
            *place = tile;
        }
    }

    /// Adds one to the last entries of a diagonal tile, from `first` on.
    #[inline(always)]
    pub(super) fn add_to_diagonal(&mut self, row: usize, first: usize) {
        if let Some(tile) = self.tiles.get_mut(row * self.blocks + row) {
            for (k, line) in tile.iter_mut().enumerate().skip(first) {
                if let Some(entry) = line.get_mut(k) {
                    *entry += 1.0;
                }
            }
        }
    }

    /// Factors in place of the block rows from `first` on.
    #[inline(always)]
    pub(super) fn factorise<M: Machine>(&mut self, m: M, first: usize) {
        for pivot in first..self.blocks {
            let (upper, inverse) = factors(m, &self.tile(pivot, pivot));
            self.set(pivot, pivot, upper);
            if let Some(place) = self.inverse_pivots.get_mut(pivot) {
                *place = inverse;
            }
            let [u0, u1, u2, _] = upper;
            let [i0, i1, i2, i3] = inverse;
            let (f01, f02, f03) = (m.splat(u0[1] * i0), m.splat(u0[2] * i0), m.splat(u0[3] * i0));
            let (f12, f13, f23) = (m.splat(u1[2] * i1), m.splat(u1[3] * i1), m.splat(u2[3] * i2));
            for column in pivot + 1..self.blocks {
                let [a, b, c, d] = load(m, &self.tile(pivot, column));
                let b = b - f01 * a;
                let c = c - f02 * a - f12 * b;
                let d = d - f03 * a - f13 * b - f23 * c;
                self.set(pivot, column, [m.store(a), m.store(b), m.store(c), m.store(d)]);
            }
            let inverses = [m.splat(i0), m.splat(i1), m.splat(i2), m.splat(i3)];
            for row in pivot + 1..self.blocks {
                let [a, b, c, d] = load(m, &self.tile(pivot, row));
                let [i0, i1, i2, i3] = inverses;
                let scaled = [m.store(i0 * a), m.store(i1 * b), m.store(i2 * c), m.store(i3 * d)];
                for column in row..self.blocks {
                    let update = load(m, &self.tile(pivot, column));
                    let [a, b, c, d] = load(m, &self.tile(row, column));
                    let next = [
                        reduced(m, a, 0, &scaled, update),
                        reduced(m, b, 1, &scaled, update),
                        reduced(m, c, 2, &scaled, update),
                        reduced(m, d, 3, &scaled, update),
                    ];
                    self.set(row, column, next);
                }
            }
        }
    }

    /// Solves in place for as many block rows from `first` on as `x` has: with the factors of these alone.
    #[inline(always)]
    pub(super) fn substitute<M: Machine>(&self, m: M, first: usize, x: &mut [Four]) {
        for pivot in 0..x.len() {
            let Some((value, rest)) = x.get_mut(pivot..).and_then(<[Four]>::split_first_mut) else { return };
            let (row, inverse) = (first + pivot, self.inverse(first + pivot));
            let [u0, u1, u2, _] = self.tile(row, row);
            let [a, b, c, d] = *value;
            let s0 = a * inverse[0];
            let b = b - s0 * u0[1];
            let s1 = b * inverse[1];
            let c = c - s0 * u0[2] - s1 * u1[2];
            let s2 = c * inverse[2];
            let d = d - s0 * u0[3] - s1 * u1[3] - s2 * u2[3];
            *value = [a, b, c, d];
            let (s0, s1, s2, s3) = (m.splat(s0), m.splat(s1), m.splat(s2), m.splat(d * inverse[3]));
            for (below, x) in rest.iter_mut().enumerate() {
                let [a, b, c, d] = load(m, &self.tile(row, row + 1 + below));
                *x = m.store(m.load(x) - s0 * a - s1 * b - s2 * c - s3 * d);
            }
        }
        for pivot in (0..x.len()).rev() {
            let Some((value, rest)) = x.get_mut(pivot..).and_then(<[Four]>::split_first_mut) else { return };
            let (row, inverse) = (first + pivot, self.inverse(first + pivot));
            let [mut a, mut b, mut c, mut d] = [m.zero(); 4];
            for (below, x) in rest.iter().enumerate() {
                let ([k, l, n, o], x) = (load(m, &self.tile(row, row + 1 + below)), m.load(x));
                (a, b, c, d) = (a + k * x, b + l * x, c + n * x, d + o * x);
            }
            let [ka, kb, kc, kd] = m.sums([a, b, c, d]);
            let [u0, u1, u2, _] = self.tile(row, row);
            let [a, b, c, d] = *value;
            let d = (d - kd) * inverse[3];
            let c = (c - kc - u2[3] * d) * inverse[2];
            let b = (b - kb - u1[2] * c - u1[3] * d) * inverse[1];
            let a = (a - ka - u0[1] * b - u0[2] * c - u0[3] * d) * inverse[0];
            *value = [a, b, c, d];
        }
    }

    #[inline(always)]
    fn inverse(&self, row: usize) -> Four {
        self.inverse_pivots.get(row).copied().unwrap_or_default()
    }
}

#[inline(always)]
fn load<M: Machine>(m: M, tile: &Tile) -> [M::Lanes; 4] {
    let [a, b, c, d] = tile;
    [m.load(a), m.load(b), m.load(c), m.load(d)]
}

/// A row less the multiples of four others, the factors in one column of `scaled`.
#[inline(always)]
fn reduced<M: Machine>(m: M, row: M::Lanes, lane: usize, scaled: &Tile, update: [M::Lanes; 4]) -> Four {
    let factor = |k: usize| m.splat(scaled.get(k).and_then(|four| four.get(lane)).copied().unwrap_or(0.0));
    let [a, b, c, d] = update;
    m.store(row - factor(0) * a - factor(1) * b - factor(2) * c - factor(3) * d)
}

/// The upper factor of a tile on the diagonal, and the inverses of its pivots.
#[inline(always)]
fn factors<M: Machine>(m: M, tile: &Tile) -> (Tile, Four) {
    let ([row, ..], [a, b, c, d]) = (*tile, load(m, tile));
    let i0 = 1.0 / row[0];
    let b = b - m.splat(row[1] * i0) * a;
    let c = c - m.splat(row[2] * i0) * a;
    let d = d - m.splat(row[3] * i0) * a;
    let second = m.store(b);
    let i1 = 1.0 / second[1];
    let c = c - m.splat(second[2] * i1) * b;
    let d = d - m.splat(second[3] * i1) * b;
    let third = m.store(c);
    let i2 = 1.0 / third[2];
    let last = m.store(d - m.splat(third[3] * i2) * c);
    ([row, second, third, last], [i0, i1, i2, 1.0 / last[3]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::four::Plain;

    /// `B^t B + 1` of numbers without order.
    fn matrix(n: usize) -> Vec<Vec<f64>> {
        let b = |i: usize, j: usize| libm::sin((3 * i * i + 7 * j + i * j) as f64);
        let entry = |i: usize, j: usize| {
            (0..n).map(|k| b(k, i) * b(k, j)).sum::<f64>() + if i == j { 1.0 } else { 0.0 }
        };
        (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
    }

    #[test]
    fn systems_are_solved_whole_and_in_part() {
        let blocks = 4;
        let a = matrix(4 * blocks);
        for (first, count) in [(0, 4), (2, 2), (0, 2)] {
            let mut system = System::new(blocks);
            for row in 0..blocks {
                for column in row..blocks {
                    let entry = |i: usize, j: usize| a[4 * row + i][4 * column + j];
                    system.set(row, column, core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j))));
                }
            }
            system.factorise(Plain, first);
            let expected: Vec<f64> = (0..4 * count).map(|k| 1.0 - 0.3 * k as f64).collect();
            let rows = 4 * first..4 * (first + count);
            let right = |i: usize| rows.clone().zip(&expected).map(|(j, x)| a[i][j] * x).sum::<f64>();
            let mut x: Vec<Four> =
                (0..count).map(|k| core::array::from_fn(|l| right(4 * (first + k) + l))).collect();
            system.substitute(Plain, first, &mut x);
            for (found, expected) in x.as_flattened().iter().zip(&expected) {
                assert!((found - expected).abs() < 1e-12, "{first} {count}: {found} instead of {expected}");
            }
        }
    }
}
