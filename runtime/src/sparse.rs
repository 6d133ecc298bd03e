//! Sparse matrices by rows of four numbers, times numbers: `y = A x`.
//!
//! The rows with most terms come first: rows of equally many follow each other, so that the machine foresees where each ends. Every sum
//! stays in a register from its first term to its last, and nothing is scattered.

use alloc::{collections::BTreeMap, vec::Vec};

use crate::four::{Four, Machine};

/// Rows of four. A row without terms is none: what it would write to is left as it is.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sparse {
    rows: Vec<Row>,
    /// Row after row, the places of the numbers and the coefficients.
    places: Vec<u32>,
    coefficients: Vec<Coefficients>,
}

/// Where the sum of a row goes, and how many terms it has.
#[derive(Clone, Copy, Debug)]
struct Row {
    target: u32,
    terms: u32,
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
        let mut by_row: BTreeMap<u32, Vec<(u32, Four)>> = BTreeMap::new();
        for ((target, place), four) in terms.0 {
            by_row.entry(target).or_default().push((place, four));
        }
        let mut by_row: Vec<_> = by_row.into_iter().collect();
        by_row.sort_by_key(|(_, terms)| core::cmp::Reverse(terms.len()));
        let row = |(target, terms): &(u32, Vec<_>)| Row { target: *target, terms: terms.len() as u32 };
        let terms = || by_row.iter().flat_map(|(_, terms)| terms);
        Sparse {
            rows: by_row.iter().map(row).collect(),
            places: terms().map(|(place, _)| *place).collect(),
            coefficients: terms().map(|(_, four)| Coefficients(*four)).collect(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// `y = A x`.
    #[inline(always)]
    pub(crate) fn apply<M: Machine>(&self, m: M, x: &[Four], y: &mut [Four]) {
        self.for_each(m, [x], |target, [sum]| {
            if let Some(to) = y.get_mut(target) {
                *to = m.store(sum);
            }
        });
    }

    /// `A x` of several `x` at once, row by row with the target of each.
    #[inline(always)]
    pub(crate) fn for_each<M: Machine, const N: usize>(
        &self,
        m: M,
        x: [&[Four]; N],
        mut found: impl FnMut(usize, [M::Lanes; N]),
    ) {
        let x = x.map(|x| x.as_flattened());
        let (mut places, mut coefficients) = (self.places.as_slice(), self.coefficients.as_slice());
        for Row { target, terms } in &self.rows {
            let terms = *terms as usize;
            let (Some((of_places, rest)), Some((of_coefficients, other))) =
                (places.split_at_checked(terms), coefficients.split_at_checked(terms))
            else {
                return;
            };
            (places, coefficients) = (rest, other);
            found(*target as usize, row(m, of_places, of_coefficients, x));
        }
    }
}

/// One row. Even and odd terms have sums of their own, so that no addition waits for the one before.
#[inline(always)]
fn row<M: Machine, const N: usize>(
    m: M,
    places: &[u32],
    coefficients: &[Coefficients],
    x: [&[f64]; N],
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
    place: u32,
    coefficients: &Coefficients,
    x: [&[f64]; N],
) {
    let coefficients = m.load(&coefficients.0);
    for (sum, x) in sums.iter_mut().zip(x) {
        if let Some(x) = x.get(place as usize) {
            *sum = *sum + m.splat(*x) * coefficients;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::four::Plain;
    use alloc::vec;

    #[test]
    fn rows_times_numbers() {
        let (rows, columns) = (23_usize, 11_usize);
        // Rows of no terms, of one and of up to all.
        let entry = |i: usize, j: usize| {
            if i / 4 == 3 || (i * j) % 3 != 1 { 0.0 } else { libm::sin((7 * i + j * j + 1) as f64) }
        };
        let mut terms = Terms::default();
        for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
            if entry(i, j) != 0.0 {
                terms.add(i / 4, i % 4, j, entry(i, j));
            }
        }
        let a = Sparse::new(terms);
        let x: Vec<Four> = vec![[0.3, -1.0, 0.7, 2.0], [1.1, 0.4, -0.2, 0.9], [-3.0, 0.5, 1.7, 0.0]];
        let mut y = vec![[9.0; 4]; rows.div_ceil(4)];
        a.apply(Plain, &x, &mut y);
        for (i, y) in y.as_flattened().iter().enumerate().take(rows) {
            let expected: f64 = (0..columns).map(|j| entry(i, j) * x.as_flattened()[j]).sum::<f64>();
            let expected = if i / 4 == 3 { 9.0 } else { expected };
            assert!((y - expected).abs() < 1e-14, "{i}: {y} instead of {expected}");
        }
        let twice: Vec<Four> = x.iter().map(|x| x.map(|x| 2.0 * x)).collect();
        a.for_each(Plain, [&x, &twice], |target, [once, twice]| {
            assert_eq!(Plain.store(once), y[target]);
            assert_eq!(Plain.store(twice), y[target].map(|y| 2.0 * y));
        });
    }
}
