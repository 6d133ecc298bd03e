//! Elimination of a symmetric system in tiles of four rows and four columns.
//!
//! Rows that a block of four has too many carry a one on the diagonal and nothing else. Every tile is taken out, worked on and put back
//! whole, so that the compiler finds vector instructions and need not ask whether rows overlap.

use alloc::{vec, vec::Vec};

use crate::four::{Four, Machine};

/// Four rows of four columns.
type Tile = [Four; 4];
/// Two rows of two columns, row by row.
pub(super) type Pairs = [f64; 4];

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
    fn set_tile(&mut self, row: usize, column: usize, tile: Tile) {
        if let Some(place) = self.tiles.get_mut(row * self.blocks + column) {
            *place = tile;
        }
    }

    /// Sets the entries of a pair of rows and a pair of columns.
    #[inline(always)]
    pub(super) fn set(&mut self, row: usize, column: usize, [a, b, c, d]: Pairs) {
        let Some(tile) = self.tiles.get_mut(row / 2 * self.blocks + column / 2) else { return };
        let [r0, r1, r2, r3] = tile;
        let (first, second) = if row.is_multiple_of(2) { (r0, r1) } else { (r2, r3) };
        if column.is_multiple_of(2) {
            (first[0], first[1], second[0], second[1]) = (a, b, c, d);
        } else {
            (first[2], first[3], second[2], second[3]) = (a, b, c, d);
        }
    }

    /// Makes the rows from `n` to the end of their block those of the unit matrix. Of an odd number the last column is zero already.
    #[inline(always)]
    pub(super) fn close(&mut self, n: usize) {
        if !n.is_multiple_of(2) {
            self.add_to_diagonal(n);
        }
        let pair = n.div_ceil(2);
        if !pair.is_multiple_of(2) {
            for row in 0..pair {
                self.set(row, pair, [0.0; 4]);
            }
            self.set(pair, pair, [1.0, 0.0, 0.0, 1.0]);
        }
    }

    #[inline(always)]
    fn add_to_diagonal(&mut self, row: usize) {
        let tile = self.tiles.get_mut(row / 4 * (self.blocks + 1));
        if let Some(entry) =
            tile.and_then(|tile| tile.get_mut(row % 4)).and_then(|line| line.get_mut(row % 4))
        {
            *entry += 1.0;
        }
    }

    /// Factors in place of the first so many block rows.
    #[inline(always)]
    pub(super) fn factorise<M: Machine>(&mut self, m: M, blocks: usize) {
        let blocks = blocks.min(self.blocks);
        for pivot in 0..blocks {
            let (upper, inverse) = factors(m, &self.tile(pivot, pivot));
            self.set_tile(pivot, pivot, upper);
            if let Some(place) = self.inverse_pivots.get_mut(pivot) {
                *place = inverse;
            }
            let [u0, u1, u2, _] = upper;
            let [i0, i1, i2, i3] = inverse;
            let (f01, f02, f03) = (m.splat(u0[1] * i0), m.splat(u0[2] * i0), m.splat(u0[3] * i0));
            let (f12, f13, f23) = (m.splat(u1[2] * i1), m.splat(u1[3] * i1), m.splat(u2[3] * i2));
            for column in pivot + 1..blocks {
                let [a, b, c, d] = load(m, &self.tile(pivot, column));
                let b = b - f01 * a;
                let c = c - f02 * a - f12 * b;
                let d = d - f03 * a - f13 * b - f23 * c;
                self.set_tile(pivot, column, [m.store(a), m.store(b), m.store(c), m.store(d)]);
            }
            let inverses = [m.splat(i0), m.splat(i1), m.splat(i2), m.splat(i3)];
            for row in pivot + 1..blocks {
                let [a, b, c, d] = load(m, &self.tile(pivot, row));
                let [i0, i1, i2, i3] = inverses;
                let scaled = [m.store(i0 * a), m.store(i1 * b), m.store(i2 * c), m.store(i3 * d)];
                for column in row..blocks {
                    let update = load(m, &self.tile(pivot, column));
                    let [a, b, c, d] = load(m, &self.tile(row, column));
                    let next = [
                        reduced(m, a, 0, &scaled, update),
                        reduced(m, b, 1, &scaled, update),
                        reduced(m, c, 2, &scaled, update),
                        reduced(m, d, 3, &scaled, update),
                    ];
                    self.set_tile(row, column, next);
                }
            }
        }
    }

    /// Solves in place for as many block rows as `x` has, with the factors of these alone: of the first `n` rows, whose solution does not
    /// depend on the others.
    #[inline(always)]
    pub(super) fn substitute<M: Machine>(&self, m: M, n: usize, x: &mut [Four]) {
        for pivot in 0..x.len() {
            let Some((value, rest)) = x.get_mut(pivot..).and_then(<[Four]>::split_first_mut) else { return };
            let (row, inverse) = (pivot, self.inverse(pivot));
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
        if let Some(others) = x.as_flattened_mut().get_mut(n..) {
            others.fill(0.0);
        }
        for pivot in (0..x.len()).rev() {
            let Some((value, rest)) = x.get_mut(pivot..).and_then(<[Four]>::split_first_mut) else { return };
            let (row, inverse) = (pivot, self.inverse(pivot));
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
        // Rows of the system, rows solved for.
        for (n, leading) in
            [(16_usize, 16_usize), (16, 6), (13, 13), (11, 11), (10, 6), (8, 8), (5, 5), (1, 1)]
        {
            let a = matrix(n);
            let mut system = System::new(5);
            // What an elimination before has left.
            system.tiles.fill([[7.0; 4]; 4]);
            let entry = |i: usize, j: usize| if i < n && j < n { a[i][j] } else { 0.0 };
            for row in 0..n.div_ceil(2) {
                for column in row..n.div_ceil(2) {
                    let at = |i: usize, j: usize| entry(2 * row + i, 2 * column + j);
                    system.set(row, column, [at(0, 0), at(0, 1), at(1, 0), at(1, 1)]);
                }
            }
            system.close(n);
            system.factorise(Plain, n.div_ceil(4));
            let expected: Vec<f64> = (0..leading).map(|k| 1.0 - 0.3 * k as f64).collect();
            let right = |i: usize| expected.iter().enumerate().map(|(j, x)| entry(i, j) * x).sum::<f64>();
            let mut x: Vec<Four> = vec![[0.0; 4]; leading.div_ceil(4)];
            x.as_flattened_mut().iter_mut().take(leading).enumerate().for_each(|(i, x)| *x = right(i));
            system.substitute(Plain, leading, &mut x);
            for (found, expected) in x.as_flattened().iter().zip(&expected) {
                assert!((found - expected).abs() < 1e-12, "{n} {leading}: {found} instead of {expected}");
            }
        }
    }
}
