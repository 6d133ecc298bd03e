//! Elimination of a symmetric system in tiles of four rows and four columns. The tiles on the diagonal are inverted, by pairs of rows:
//! two divisions each, one after the other, and products in place of substitutions.
//!
//! Rows that a block of four has too many carry a one on the diagonal and nothing else. Every tile is taken out, worked on and put back
//! whole, so that the compiler finds vector instructions and need not ask whether rows overlap.

use alloc::{vec, vec::Vec};

use crate::four::{Four, Machine};

/// Four rows of four columns.
type Tile = [Four; 4];
/// Two rows of two columns, row by row.
pub(super) type Pairs = [f64; 4];

/// A symmetric positive definite matrix by its upper tiles, later its factors: rows `U` of tiles, and the inverses of those on the diagonal
/// in place of these.
#[derive(Clone, Debug)]
pub(super) struct System {
    blocks: usize,
    /// Row after row; of the tiles on the diagonal the upper triangle counts - (blocks x blocks).
    tiles: Vec<Tile>,
    /// Inverses of the first two rows and columns of the tiles on the diagonal - (blocks).
    leading: Vec<Pairs>,
}

impl System {
    pub(super) fn new(blocks: usize) -> Self {
        System { blocks, tiles: vec![[[0.0; 4]; 4]; blocks * blocks], leading: vec![[0.0; 4]; blocks] }
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
            let (inverse, leading) = inverse(&self.tile(pivot, pivot));
            self.set_tile(pivot, pivot, inverse);
            if let Some(place) = self.leading.get_mut(pivot) {
                *place = leading;
            }
            for row in pivot + 1..blocks {
                let rows = load(m, &self.tile(pivot, row));
                // One by one: a closure that arrays are mapped with is not inlined.
                let [p, q, r, s] = &inverse;
                let scaled = [
                    m.store(weighted(m, p, rows)),
                    m.store(weighted(m, q, rows)),
                    m.store(weighted(m, r, rows)),
                    m.store(weighted(m, s, rows)),
                ];
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

    /// Solves in place for as many block rows as `x` has, with the factors of these alone; `cut` where only the first two rows of the last
    /// block are to be there. Their solution does not depend on the rows after them.
    #[inline(always)]
    pub(super) fn substitute<M: Machine>(&self, m: M, cut: bool, x: &mut [Four]) {
        for pivot in 0..x.len() {
            let Some((value, rest)) = x.get_mut(pivot..).and_then(<[Four]>::split_first_mut) else { return };
            let [a, b, c, d] = m.store(times(m, &self.tile(pivot, pivot), value));
            let (a, b, c, d) = (m.splat(a), m.splat(b), m.splat(c), m.splat(d));
            for (below, x) in rest.iter_mut().enumerate() {
                let [p, q, r, s] = load(m, &self.tile(pivot, pivot + 1 + below));
                *x = m.store(m.load(x) - ((a * p + b * q) + (c * r + d * s)));
            }
        }
        let last = x.len().saturating_sub(1);
        for pivot in (0..x.len()).rev() {
            let Some((value, rest)) = x.get_mut(pivot..).and_then(<[Four]>::split_first_mut) else { return };
            if cut && pivot == last {
                let ([a, b, ..], [p, q, r, s]) =
                    (*value, self.leading.get(pivot).copied().unwrap_or_default());
                *value = [p * a + q * b, r * a + s * b, 0.0, 0.0];
                continue;
            }
            let [mut a, mut b, mut c, mut d] = [m.zero(); 4];
            for (below, x) in rest.iter().enumerate() {
                let ([k, l, n, o], x) = (load(m, &self.tile(pivot, pivot + 1 + below)), m.load(x));
                (a, b, c, d) = (a + k * x, b + l * x, c + n * x, d + o * x);
            }
            let left = m.store(m.load(value) - m.load(&m.sums([a, b, c, d])));
            *value = m.store(times(m, &self.tile(pivot, pivot), &left));
        }
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

/// A symmetric tile times a column.
#[inline(always)]
fn times<M: Machine>(m: M, tile: &Tile, column: &Four) -> M::Lanes {
    weighted(m, column, load(m, tile))
}

/// A sum of four rows.
#[inline(always)]
fn weighted<M: Machine>(m: M, [a, b, c, d]: &Four, [p, q, r, s]: [M::Lanes; 4]) -> M::Lanes {
    (m.splat(*a) * p + m.splat(*b) * q) + (m.splat(*c) * r + m.splat(*d) * s)
}

/// Inverse of a symmetric tile by its upper triangle, and that of its first two rows and columns.
#[inline(always)]
fn inverse(tile: &Tile) -> (Tile, Pairs) {
    let [[a, b, c, d], [_, e, f, g], [_, _, h, i], [_, _, _, j]] = *tile;
    let [p, q, r] = inverse_of_two(a, b, e);
    // | A  B |      Y = A^-1 B
    // | B^t C |     S = C - B^t Y
    let [y0, y1, y2, y3] = [p * c + q * f, p * d + q * g, q * c + r * f, q * d + r * g];
    let [u, v, w] = inverse_of_two(h - (c * y0 + f * y2), i - (c * y1 + f * y3), j - (d * y1 + g * y3));
    let [z0, z1, z2, z3] = [y0 * u + y1 * v, y0 * v + y1 * w, y2 * u + y3 * v, y2 * v + y3 * w];
    let mixed = q + (z0 * y2 + z1 * y3);
    let inverse = [
        [p + (z0 * y0 + z1 * y1), mixed, -z0, -z1],
        [mixed, r + (z2 * y2 + z3 * y3), -z2, -z3],
        [-z0, -z2, u, v],
        [-z1, -z3, v, w],
    ];
    (inverse, [p, q, q, r])
}

/// `[[a, b], [b, c]]^-1`, likewise.
#[inline(always)]
fn inverse_of_two(a: f64, b: f64, c: f64) -> [f64; 3] {
    let inverse = 1.0 / (a * c - b * b);
    [c * inverse, -(b * inverse), a * inverse]
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
            system.substitute(Plain, leading < n, &mut x);
            for (found, expected) in x.as_flattened().iter().zip(&expected) {
                assert!((found - expected).abs() < 1e-12, "{n} {leading}: {found} instead of {expected}");
            }
        }
    }
}
