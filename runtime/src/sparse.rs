//! Sparse matrices by rows of four numbers, times numbers: `y = A x`.
//!
//! The rows with most terms come first: rows of equally many follow each other, so that the machine foresees where each ends. Every sum
//! stays in a register from its first term to its last, and nothing is scattered. Numbers lie in windows of 256: a byte names one in its
//! window and cannot lead out of it, so that the sums run without checks.

use alloc::{collections::BTreeMap, vec, vec::Vec};

use crate::four::{Four, Machine};

/// Numbers that a byte can name.
const WINDOW: usize = 1 << u8::BITS;
/// Blocks of four in a window.
pub(crate) const WINDOW_BLOCKS: usize = WINDOW / 4;
const EMPTY: &[f64; WINDOW] = &[0.0; WINDOW];

/// Zeros for so many blocks of numbers that a matrix is to be multiplied with: whole windows.
pub(crate) fn windows(blocks: usize) -> Vec<Four> {
    vec![[0.0; 4]; blocks.next_multiple_of(WINDOW_BLOCKS)]
}

/// Rows of four. A row without terms is none: what it would write to is left as it is.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sparse {
    rows: Vec<Row>,
    /// Row after row, the places of the numbers in their window and the coefficients.
    places: Vec<u8>,
    coefficients: Vec<Coefficients>,
}

/// The terms of a row in one window, and where their sum goes.
#[derive(Clone, Copy, Debug)]
struct Row {
    target: u32,
    terms: u32,
    window: u32,
    /// Whether the row has terms in a window before.
    more: bool,
}

/// In four rows. Aligned, none is in two lines of the cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Coefficients(Four);

/// Terms of a matrix that is being put together: coefficients of four by target and place.
#[derive(Clone, Debug, Default)]
pub(crate) struct Terms(BTreeMap<(u32, u32), Four>);

impl Terms {
    /// Adds to one of the four.
    pub(crate) fn add(&mut self, target: usize, lane: usize, place: usize, value: f64) {
        let four = self.0.entry((target as u32, place as u32)).or_default();
        if let Some(to) = four.get_mut(lane) {
            *to += value;
        }
    }
}

impl Sparse {
    pub(crate) fn new(terms: Terms) -> Self {
        let mut by_row: BTreeMap<(u32, u32), Vec<(u8, Four)>> = BTreeMap::new();
        for ((target, place), four) in terms.0 {
            let window = place / WINDOW as u32;
            by_row.entry((target, window)).or_default().push(((place % WINDOW as u32) as u8, four));
        }
        let mut rows: Vec<(Row, Vec<(u8, Four)>)> = Vec::with_capacity(by_row.len());
        for ((target, window), terms) in by_row {
            let more = rows.last().is_some_and(|(row, _)| row.target == target);
            rows.push((Row { target, terms: terms.len() as u32, window, more }, terms));
        }
        rows.sort_by_key(|(row, _)| (row.window, core::cmp::Reverse(row.terms)));
        let terms = || rows.iter().flat_map(|(_, terms)| terms);
        Sparse {
            rows: rows.iter().map(|(row, _)| *row).collect(),
            places: terms().map(|(place, _)| *place).collect(),
            coefficients: terms().map(|(_, four)| Coefficients(*four)).collect(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// `y = A x`, `x` of [`windows`].
    #[inline(always)]
    pub(crate) fn apply<M: Machine>(&self, m: M, x: &[Four], y: &mut [Four]) {
        self.for_each(m, [x], |target, more, [sum]| {
            if let Some(to) = y.get_mut(target) {
                *to = m.store(if more { m.load(to) + sum } else { sum });
            }
        });
    }

    /// `A x` of several `x` at once, row by row: the target of each, whether the sums come on top of what was found for it before, and the
    /// sums.
    #[inline(always)]
    pub(crate) fn for_each<M: Machine, const N: usize>(
        &self,
        m: M,
        x: [&[Four]; N],
        mut found: impl FnMut(usize, bool, [M::Lanes; N]),
    ) {
        let x = x.map(|x| x.as_flattened().as_chunks::<WINDOW>().0);
        let (mut places, mut coefficients) = (self.places.as_slice(), self.coefficients.as_slice());
        for row in &self.rows {
            let terms = row.terms as usize;
            let (Some((of_places, rest)), Some((of_coefficients, other))) =
                (places.split_at_checked(terms), coefficients.split_at_checked(terms))
            else {
                return;
            };
            (places, coefficients) = (rest, other);
            let mut window = [EMPTY; N];
            for (window, x) in window.iter_mut().zip(x) {
                *window = x.get(row.window as usize).unwrap_or(EMPTY);
            }
            found(row.target as usize, row.more, sums(m, of_places, of_coefficients, window));
        }
    }
}

/// One row. Even and odd terms have sums of their own, so that no addition waits for the one before.
#[inline(always)]
fn sums<M: Machine, const N: usize>(
    m: M,
    places: &[u8],
    coefficients: &[Coefficients],
    x: [&[f64; WINDOW]; N],
) -> [M::Lanes; N] {
    let (mut even, mut odd) = ([m.zero(); N], [m.zero(); N]);
    let (pairs, last) = places.as_chunks::<2>();
    let (of_pairs, of_last) = coefficients.as_chunks::<2>();
    for ([a, b], [of_a, of_b]) in pairs.iter().zip(of_pairs) {
        add(m, &mut even, *a, of_a, x);
        add(m, &mut odd, *b, of_b, x);
    }
    if let ([place], [coefficients]) = (last, of_last) {
        add(m, &mut even, *place, coefficients, x);
    }
    let mut sums = even;
    for (sum, odd) in sums.iter_mut().zip(odd) {
        *sum = *sum + odd;
    }
    sums
}

#[inline(always)]
fn add<M: Machine, const N: usize>(
    m: M,
    sums: &mut [M::Lanes; N],
    place: u8,
    coefficients: &Coefficients,
    x: [&[f64; WINDOW]; N],
) {
    let coefficients = m.load(&coefficients.0);
    for (sum, x) in sums.iter_mut().zip(x) {
        if let Some(x) = x.get(usize::from(place)) {
            *sum = *sum + m.splat(*x) * coefficients;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::four::Plain;

    #[test]
    fn rows_times_numbers() {
        let (rows, columns) = (23_usize, 700_usize);
        // Rows of no terms, of one and of many, in one window and in several.
        let entry = |i: usize, j: usize| {
            let used = match i / 4 {
                3 => false,
                4 => j == 300,
                _ => (5 * i + 3 * j) % 7 == 1,
            };
            if used { libm::sin((7 * i + j * j + 1) as f64) } else { 0.0 }
        };
        let mut terms = Terms::default();
        for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
            if entry(i, j) != 0.0 {
                terms.add(i / 4, i % 4, j, entry(i, j));
            }
        }
        let a = Sparse::new(terms);
        let mut x = windows(columns.div_ceil(4));
        for (j, x) in x.as_flattened_mut().iter_mut().enumerate() {
            *x = libm::cos((3 * j) as f64);
        }
        let mut y = vec![[9.0; 4]; rows.div_ceil(4)];
        a.apply(Plain, &x, &mut y);
        for (i, y) in y.as_flattened().iter().enumerate().take(rows) {
            let expected: f64 = (0..columns).map(|j| entry(i, j) * x.as_flattened()[j]).sum::<f64>();
            let expected = if i / 4 == 3 { 9.0 } else { expected };
            assert!((y - expected).abs() < 1e-13, "{i}: {y} instead of {expected}");
        }
        let twice: Vec<Four> = x.iter().map(|x| x.map(|x| 2.0 * x)).collect();
        let mut both = vec![[Plain.zero(); 2]; y.len()];
        a.for_each(Plain, [&x, &twice], |target, more, sums| {
            for (to, sum) in both[target].iter_mut().zip(sums) {
                *to = if more { *to + sum } else { sum };
            }
        });
        for (target, [once, twice]) in both.into_iter().enumerate().filter(|(target, _)| *target != 3) {
            assert_eq!(Plain.store(once), y[target]);
            assert_eq!(Plain.store(twice), y[target].map(|y| 2.0 * y));
        }
    }
}
