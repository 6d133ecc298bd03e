//! The contraction of [`crate::tensor`] in the lanes of a batch.
//!
//! A single step has four rows side by side in a register, which multiply their columns together, and zeros where a row has no entry. In
//! the lanes are instances instead: every row is a register of its own, so that rows of a block that have little in common are taken
//! apart. What is added for each row stays in the same sums and order. Left out are zeros times a product: a sum begins as +0, becomes -0
//! nowhere, and keeps its bits when +0 or -0 is added to it. Products that are not finite would make NaN of that; each is in the sum of a
//! row that has an entry for it, whose acceleration is not finite then either, and the instance is stepped alone.
//!
//! A product is formed where it is needed: to store those of all modes and read them again takes as long, and more than the first cache.

use alloc::vec::Vec;

use crate::math::Vec6;
use crate::real::Lanes;
use crate::tensor::{BLOCK, Column, Contraction, GROUP, VELOCITIES, accumulate, sum_of_sums, velocities};

/// Rows that share their columns.
#[derive(Clone, Debug)]
struct Part {
    /// Rows of the model.
    rows: Vec<u32>,
    /// Number of columns of every sum.
    columns: [usize; GROUP],
}

/// `c_ilr u_l beta_r + k_ilrs q_l beta_r beta_s` for constant c, k.
#[derive(Clone, Debug)]
pub(super) struct LaneContraction {
    parts: Vec<Part>,
    /// See [`Column::factors`]; part by part, sum by sum.
    factors: Vec<[u32; 2]>,
    /// The values of its rows in every column.
    values: Vec<f64>,
}

impl LaneContraction {
    pub(super) fn new(contraction: &Contraction) -> Self {
        let mut new = LaneContraction { parts: Vec::new(), factors: Vec::new(), values: Vec::new() };
        for (rows, columns) in contraction.blocks() {
            let shares = best_shares(&rows, &columns);
            for share in 0..BLOCK {
                new.push(&rows, &columns, |row| shares.get(row) == Some(&share));
            }
        }
        new
    }

    /// A part of the rows of a block.
    fn push(&mut self, rows: &[u32; BLOCK], columns: &[Column], is_in: impl Fn(usize) -> bool) {
        let chosen: Vec<(usize, u32)> =
            rows.iter().copied().enumerate().filter(|&(row, of)| of != u32::MAX && is_in(row)).collect();
        if chosen.is_empty() {
            return;
        }
        let mut part = Part { rows: chosen.iter().map(|(_, of)| *of).collect(), columns: [0; GROUP] };
        for (sum, count) in part.columns.iter_mut().enumerate() {
            for column in columns.iter().filter(|column| column.sum == sum) {
                if !chosen.iter().any(|&(row, _)| has_entry(column, row)) {
                    continue;
                }
                *count += 1;
                self.factors.push(column.factors);
                self.values.extend(chosen.iter().filter_map(|&(row, _)| column.values.get(row)));
            }
        }
        self.parts.push(part);
    }

    /// `y = c u beta + k q beta beta` of `(q, u)`.
    #[inline(always)]
    pub(super) fn apply(&self, modal: &[Lanes], beta: &Vec6<Lanes>, y: &mut [Lanes]) {
        let velocities = velocities(beta);
        let mut entries = Entries { factors: &self.factors, values: &self.values };
        for part in &self.parts {
            let at = (&part.columns, modal, &velocities);
            match part.rows.len() {
                1 => put(&part.rows, entries.sums::<1>(at), y),
                2 => put(&part.rows, entries.sums::<2>(at), y),
                3 => put(&part.rows, entries.sums::<3>(at), y),
                _ => put(&part.rows, entries.sums::<BLOCK>(at), y),
            }
        }
    }
}

/// What is left of the entries.
struct Entries<'a> {
    factors: &'a [[u32; 2]],
    values: &'a [f64],
}

/// Numbers of columns, `(q, u)`, velocities and their products.
type At<'a> = (&'a [usize; GROUP], &'a [Lanes], &'a [Lanes; VELOCITIES]);

impl Entries<'_> {
    /// The sums of the next `N` rows.
    #[inline(always)]
    fn sums<const N: usize>(&mut self, (columns, modal, velocities): At) -> [Lanes; N] {
        // One sum of all rows after the other: more would not stay in the registers of every machine.
        let [a, b, c, d] = *columns;
        let mut sum = |n| self.sum::<N>(n, modal, velocities);
        sum_of_sums([sum(a), sum(b), sum(c), sum(d)])
    }

    #[inline(always)]
    fn sum<const N: usize>(
        &mut self,
        n: usize,
        modal: &[Lanes],
        velocities: &[Lanes; VELOCITIES],
    ) -> [Lanes; N] {
        let mut sums = [Lanes::default(); N];
        let (Some((factors, more_factors)), Some((values, more_values))) =
            (self.factors.split_at_checked(n), self.values.split_at_checked(n * N))
        else {
            return sums;
        };
        (self.factors, self.values) = (more_factors, more_values);
        for (&[a, b], values) in factors.iter().zip(values.as_chunks::<N>().0) {
            if let (Some(a), Some(b)) = (modal.get(a as usize), velocities.get(b as usize % VELOCITIES)) {
                accumulate(&mut sums, values, *a * *b);
            }
        }
        sums
    }
}

#[inline(always)]
fn put<const N: usize>(rows: &[u32], sums: [Lanes; N], y: &mut [Lanes]) {
    for (row, sum) in rows.iter().zip(&sums) {
        if let Some(y) = y.get_mut(*row as usize) {
            *y = *sum;
        }
    }
}

/// Whether a row has an entry in a column; where all are stored as zero, all of them have one.
fn has_entry(column: &Column, row: usize) -> bool {
    column.values == [0.0; BLOCK] || column.values.get(row).is_some_and(|value| *value != 0.0)
}

/// What begins and ends the four sums of a part, in numbers read.
const START_OF_SUMS: usize = 4 * 8;

/// The part that each row of a block goes into, such that least is read: two factors of every column and its values.
fn best_shares(rows: &[u32; BLOCK], columns: &[Column]) -> [usize; BLOCK] {
    let all = (0..BLOCK.pow(BLOCK as u32)).map(|code| {
        let mut rest = code;
        [(); BLOCK].map(|()| {
            let share = rest % BLOCK;
            rest /= BLOCK;
            share
        })
    });
    let cost = |shares: &[usize; BLOCK]| -> usize {
        let of_part = |part: usize| {
            let is_in = |row: usize| {
                rows.get(row).is_some_and(|row| *row != u32::MAX) && shares.get(row) == Some(&part)
            };
            let size = (0..BLOCK).filter(|row| is_in(*row)).count();
            let used =
                columns.iter().filter(|column| (0..BLOCK).any(|row| is_in(row) && has_entry(column, row)));
            if size == 0 { 0 } else { (2 + size) * used.count() + START_OF_SUMS }
        };
        (0..BLOCK).map(of_part).sum()
    };
    all.min_by_key(cost).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::TensorData;
    use crate::real::{LANES, Real};
    use alloc::{string::String, vec};

    /// Entries for which `keep` holds, in order, with values that depend on their place only.
    fn tensor(rows: u32, columns: u32, codes: u32, keep: impl Fn(u32, u32, u32) -> bool) -> TensorData {
        let (threshold, dropped_norm, dropped_count, scale) = (0.0, 0.0, 0, String::new());
        let (i, l, r, value) = (vec![], vec![], vec![], vec![]);
        let mut t = TensorData { i, l, r, value, threshold, scale, dropped_norm, dropped_count };
        let places =
            (0..rows).flat_map(|i| (0..columns).flat_map(move |l| (0..codes).map(move |r| (i, l, r))));
        for (i, l, r) in places.filter(|&(i, l, r)| keep(i, l, r)) {
            t.i.push(i);
            t.l.push(l);
            t.r.push(r);
            t.value.push(libm::sin(f64::from(7 * i + 13 * l + 29 * r + 1)));
        }
        t
    }

    /// Rows with different columns, of four classes, with products of velocities alone or without, in one window of products or more.
    #[test]
    fn every_lane_has_the_bits_of_the_contraction_alone() {
        let number = |k: usize| libm::sin(1.0 + 7.0 * k as f64) * libm::pow(10.0, (k % 7) as f64 - 3.0);
        for (m, velocities_alone) in [(0, true), (1, false), (3, true), (10, false), (12, true), (40, false)]
        {
            let ordered = |rs: u32| rs / 6 <= rs % 6 && (velocities_alone || rs % 6 >= 3);
            let c = tensor(m + 6, m + 6, 6, |i, l, r| (i + 2 * l + 3 * r) % 4 == 0);
            let k = tensor(m + 6, m, 36, |i, l, rs| ordered(rs) && (i + l + rs) % 3 != 1);
            let m = m as usize;
            let single = Contraction::new(m, &c, &k);
            let side_by_side = LaneContraction::new(&single);
            let (entries, held) = (c.value.len() + k.value.len(), side_by_side.values.len());
            assert!(entries <= held && held <= single.fill().1, "{entries}, {held}");

            let in_lane = |place: usize, lane: usize| number(LANES * place + lane);
            let lanes = |place: usize| Lanes(core::array::from_fn(|lane| in_lane(place, lane)));
            let modal: Vec<Lanes> = (0..2 * m + 6).map(lanes).collect();
            let beta: Vec6<Lanes> = core::array::from_fn(|r| lanes(2 * m + 6 + r));
            let mut y = vec![Lanes::of(f64::NAN); m + 6];
            side_by_side.apply(&modal, &beta, &mut y);
            for lane in 0..LANES {
                let alone: Vec<f64> = modal.iter().map(|x| x.get(lane)).collect();
                let (q, u) = alone.split_at(m);
                let mut expected = vec![f64::NAN; m + 6];
                single.apply(u, q, &beta.map(|x| x.get(lane)), &mut single.products(), &mut expected);
                for (found, expected) in y.iter().zip(&expected) {
                    assert_eq!(found.get(lane).to_bits(), expected.to_bits(), "lane {lane} of {m} modes");
                }
            }
        }
    }
}
