//! Forms of second and third order in the amplitudes, many at a time: `f_r(q) = C_rp P_p(q)` with the products `P` of two and of three
//! amplitudes.
//!
//! The products are formed once at an instant, whatever number of forms has terms of them, and four that the same forms have terms of
//! stand side by side. Values and second derivatives of forms are sums over these; `w_r df_r/dq_i` is collected product by product first.

use alloc::collections::BTreeMap;
use alloc::{vec, vec::Vec};

use crate::data::PolynomialData;
use crate::four::{self, Four, Kernel, Machine};
use crate::tensor::row_blocks;

/// A term of a form.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    form: usize,
    first: [u32; 2],
    third: Option<u32>,
    value: f64,
}

impl Entry {
    pub(super) fn quadratic(form: usize, first: [u32; 2], value: f64) -> Self {
        Entry { form, first, third: None, value }
    }

    /// Terms of polynomials, whose rows are the forms from `first` on.
    pub(super) fn of(first: usize, data: &PolynomialData) -> impl Iterator<Item = Entry> + '_ {
        let quadratic = move |(row, factors, value): &(u32, [u32; 2], f64)| {
            Entry::quadratic(first + *row as usize, *factors, *value)
        };
        let cubic = move |(row, [i, j, k], value): &(u32, [u32; 3], f64)| Entry {
            form: first + *row as usize,
            first: [*i, *j],
            third: Some(*k),
            value: *value,
        };
        data.quadratic.iter().map(quadratic).chain(data.cubic.iter().map(cubic))
    }
}

/// Forms that have terms of a product, with the coefficients.
type Of = Vec<(u32, f64)>;

/// The terms that a form has of four products.
#[derive(Clone, Copy, Debug)]
struct Term {
    block: u32,
    coefficients: Four,
}

/// Forms and what they are at an instant.
#[derive(Clone, Debug, Default)]
pub(super) struct Forms {
    /// Factors of the products of two; of three the place of the product of the first two, and the third factor. Either list is filled up to
    /// fours with products that no form has a term of.
    pairs: Vec<[u32; 2]>,
    triples: Vec<[u32; 2]>,
    /// Form after form, and where those of each begin and the last end - (forms + 1).
    terms: Vec<Term>,
    bounds: Vec<usize>,
    /// Amplitudes with their rates and accelerations - (modes).
    motion: Vec<[f64; 3]>,
    /// Products, those of two before those of three, and their second derivatives - (blocks). First ones of those of two.
    value: Vec<Four>,
    rate: Vec<Four>,
    second: Vec<Four>,
    /// Weights of the products that a pull-back collects - (blocks).
    weight: Vec<Four>,
}

impl Forms {
    /// So many forms in so many amplitudes.
    pub(super) fn new(modes: usize, forms: usize, entries: &[Entry]) -> Self {
        let mut pairs: BTreeMap<[u32; 2], Of> = BTreeMap::new();
        let mut triples: BTreeMap<([u32; 2], u32), Of> = BTreeMap::new();
        for &Entry { form, first, third, value } in entries {
            let of_pair = pairs.entry(first).or_default();
            let terms = third.map_or(of_pair, |third| triples.entry((first, third)).or_default());
            terms.push((form as u32, value));
        }
        let (pairs, of_pairs) = arranged(pairs, forms);
        let (triples, of_triples) = arranged(triples, forms);
        let places = (0..).zip(&pairs).filter_map(|(place, pair)| Some(((*pair)?, place)));
        let places: BTreeMap<[u32; 2], u32> = places.collect();
        let mut terms: BTreeMap<(u32, u32), Four> = BTreeMap::new();
        for (place, products) in of_pairs.into_iter().chain(of_triples).enumerate() {
            for (form, value) in products {
                let four = terms.entry((form, place as u32 / 4)).or_default();
                if let Some(to) = four.get_mut(place % 4) {
                    *to += value;
                }
            }
        }
        let terms: Vec<((u32, u32), Four)> = terms.into_iter().collect();
        let blocks = (pairs.len() + triples.len()) / 4;
        let triple = |triple: &Option<([u32; 2], u32)>| {
            triple.map_or([0, 0], |(first, k)| [places.get(&first).copied().unwrap_or(0), k])
        };
        let before = |form: usize| terms.partition_point(|((of, _), _)| (*of as usize) < form);
        Forms {
            bounds: (0..=forms).map(before).collect(),
            terms: terms
                .iter()
                .map(|((_, block), four)| Term { block: *block, coefficients: *four })
                .collect(),
            triples: triples.iter().map(triple).collect(),
            rate: vec![[0.0; 4]; pairs.len() / 4],
            pairs: pairs.iter().map(|pair| pair.unwrap_or_default()).collect(),
            motion: vec![[0.0; 3]; modes],
            value: vec![[0.0; 4]; blocks],
            second: vec![[0.0; 4]; blocks],
            weight: vec![[0.0; 4]; blocks],
        }
    }

    /// The products at amplitudes, and their second derivatives along rates and accelerations.
    pub(super) fn look(&mut self, q: &[f64], q_dot: &[f64], q_ddot: &[f64]) {
        for (motion, ((q, q_dot), q_ddot)) in self.motion.iter_mut().zip(q.iter().zip(q_dot).zip(q_ddot)) {
            *motion = [*q, *q_dot, *q_ddot];
        }
        four::run(Look { forms: self });
        self.weight.fill([0.0; 4]);
    }

    /// Values of the forms from `first` on, as many as there is room for.
    pub(super) fn values(&self, first: usize, out: &mut [f64]) {
        four::run(Sums { rows: self.rows(first), of: &self.value, out });
    }

    /// Their second derivatives along the motion.
    pub(super) fn seconds(&self, first: usize, out: &mut [f64]) {
        four::run(Sums { rows: self.rows(first), of: &self.second, out });
    }

    /// Weighs the forms from `first` on for the next [`Self::pull_back`].
    pub(super) fn weigh(&mut self, first: usize, weights: &[f64]) {
        let Forms { terms, bounds, weight, .. } = self;
        four::run(Weigh { rows: Rows::new(terms, bounds, first), weights, collected: weight });
    }

    fn rows(&self, first: usize) -> Rows<'_> {
        Rows::new(&self.terms, &self.bounds, first)
    }

    /// Adds `weight_r df_r/dq_i`.
    pub(super) fn pull_back(&mut self, out: &mut [f64]) {
        let Forms { pairs, triples, motion, value, weight, .. } = self;
        let Some((of_pairs, of_triples)) = weight.as_flattened_mut().split_at_mut_checked(pairs.len()) else {
            return;
        };
        let of_mode = |i: u32| motion.get(i as usize).map_or(0.0, |[x, ..]| *x);
        for ([pair, k], weight) in triples.iter().zip(of_triples.iter()) {
            let product = value.as_flattened().get(*pair as usize);
            if let (Some(p), Some(of_pair), Some(to)) =
                (product, of_pairs.get_mut(*pair as usize), out.get_mut(*k as usize))
            {
                *of_pair += weight * of_mode(*k);
                *to += weight * p;
            }
        }
        for ([i, j], weight) in pairs.iter().zip(of_pairs.iter()) {
            let (x, y) = (of_mode(*i), of_mode(*j));
            for (i, factor) in [(i, y), (j, x)] {
                if let Some(to) = out.get_mut(*i as usize) {
                    *to += weight * factor;
                }
            }
        }
    }
}

/// Products with their terms in an order in which four that share forms stand side by side; none where a four is filled up.
fn arranged<K: Copy>(products: BTreeMap<K, Of>, forms: usize) -> (Vec<Option<K>>, Vec<Of>) {
    let (keys, terms): (Vec<K>, Vec<Of>) = products.into_iter().unzip();
    let blocks = row_blocks(&terms, forms);
    let places = blocks.as_flattened().iter();
    let of = |place: &u32| terms.get(*place as usize).cloned().unwrap_or_default();
    (places.clone().map(|place| keys.get(*place as usize).copied()).collect(), places.map(of).collect())
}

/// The products at a motion.
struct Look<'a> {
    forms: &'a mut Forms,
}

impl Kernel for Look<'_> {
    type Output = ();

    #[inline(always)]
    fn on<M: Machine>(self, m: M) {
        let Forms { pairs, triples, motion, value, rate, second, .. } = self.forms;
        let none = [0.0; 3];
        let of_mode = |i: u32| motion.get(i as usize).unwrap_or(&none);
        let (two, blocks) = (m.splat(2.0), pairs.as_chunks::<4>().0);
        let found = value.iter_mut().zip(second.iter_mut()).zip(rate.iter_mut());
        for (((value, second), rate), &[a, b, c, d]) in found.zip(blocks) {
            let [x, dx, ddx] = across(m, [of_mode(a[0]), of_mode(b[0]), of_mode(c[0]), of_mode(d[0])]);
            let [y, dy, ddy] = across(m, [of_mode(a[1]), of_mode(b[1]), of_mode(c[1]), of_mode(d[1])]);
            *value = m.store(x * y);
            *rate = m.store(dx * y + x * dy);
            *second = m.store(two * dx * dy + (ddx * y + x * ddy));
        }
        let Some(((of_pairs, value), (second_of_pairs, second))) =
            value.split_at_mut_checked(blocks.len()).zip(second.split_at_mut_checked(blocks.len()))
        else {
            return;
        };
        let of = |list: &[Four], pair: u32| list.as_flattened().get(pair as usize).copied().unwrap_or(0.0);
        let of_pair = |pair: u32| [of(of_pairs, pair), of(rate, pair), of(second_of_pairs, pair)];
        let blocks = triples.as_chunks::<4>().0;
        for ((value, second), &[a, b, c, d]) in value.iter_mut().zip(second).zip(blocks) {
            let [p, dp, ddp] = across(m, [&of_pair(a[0]), &of_pair(b[0]), &of_pair(c[0]), &of_pair(d[0])]);
            let [z, dz, ddz] = across(m, [of_mode(a[1]), of_mode(b[1]), of_mode(c[1]), of_mode(d[1])]);
            *value = m.store(p * z);
            *second = m.store(two * dp * dz + (ddp * z + p * ddz));
        }
    }
}

/// Value, rate and second derivative of four side by side.
#[inline(always)]
fn across<M: Machine>(m: M, [a, b, c, d]: [&[f64; 3]; 4]) -> [M::Lanes; 3] {
    let ([x, dx, ddx], [y, dy, ddy], [z, dz, ddz], [w, dw, ddw]) = (a, b, c, d);
    [m.load(&[*x, *y, *z, *w]), m.load(&[*dx, *dy, *dz, *dw]), m.load(&[*ddx, *ddy, *ddz, *ddw])]
}

/// Terms of forms, one form after another.
struct Rows<'a> {
    terms: &'a [Term],
    bounds: &'a [usize],
}

impl<'a> Rows<'a> {
    fn new(terms: &'a [Term], bounds: &'a [usize], first: usize) -> Self {
        let bounds = bounds.get(first..).unwrap_or_default();
        let start = bounds.first().copied().unwrap_or(0);
        Rows { terms: terms.get(start..).unwrap_or_default(), bounds }
    }

    #[inline(always)]
    fn each(self) -> impl Iterator<Item = &'a [Term]> {
        let mut terms = self.terms;
        self.bounds.windows(2).map_while(move |bounds| {
            let &[start, end] = bounds else { return None };
            let (own, rest) = terms.split_at_checked(end.saturating_sub(start))?;
            terms = rest;
            Some(own)
        })
    }
}

/// Sums of the products by their coefficients.
struct Sums<'a> {
    rows: Rows<'a>,
    of: &'a [Four],
    out: &'a mut [f64],
}

impl Kernel for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn on<M: Machine>(self, m: M) {
        let Sums { rows, of, out } = self;
        for (out, terms) in out.iter_mut().zip(rows.each()) {
            let mut sum = m.zero();
            for term in terms {
                if let Some(x) = of.get(term.block as usize) {
                    sum = sum + m.load(x) * m.load(&term.coefficients);
                }
            }
            *out = m.sum(sum);
        }
    }
}

/// Weights of forms passed on to their products.
struct Weigh<'a> {
    rows: Rows<'a>,
    weights: &'a [f64],
    collected: &'a mut [Four],
}

impl Kernel for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn on<M: Machine>(self, m: M) {
        let Weigh { rows, weights, collected } = self;
        for (weight, terms) in weights.iter().zip(rows.each()).filter(|(weight, _)| **weight != 0.0) {
            let weight = m.splat(*weight);
            for term in terms {
                if let Some(to) = collected.get_mut(term.block as usize) {
                    *to = m.store(m.load(to) + weight * m.load(&term.coefficients));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the polynomials written out, along a path by differences.
    #[test]
    fn forms_are_their_polynomials() {
        // f_0 = 2 q_0 q_1 + q_0^2, f_1 = 0, f_2 = 1/2 q_2^2, f_3 = -q_0^2 q_1 + 3 q_1 q_2^2, f_4 = 0.4 q_2^3 - q_0 q_2.
        let data = PolynomialData {
            quadratic: vec![(0, [0, 0], 1.0), (0, [0, 1], 2.0), (3, [0, 2], -1.0)],
            cubic: vec![(2, [0, 0, 1], -1.0), (2, [1, 2, 2], 3.0), (3, [2, 2, 2], 0.4)],
        };
        let shifted = |row: u32| if row == 0 { 0 } else { row as usize + 1 };
        let mut entries: Vec<Entry> = Entry::of(0, &data).collect();
        entries.iter_mut().for_each(|entry| entry.form = shifted(entry.form as u32));
        entries.push(Entry::quadratic(2, [2, 2], 0.5));
        let f = |q: &[f64]| {
            let [x, y, z] = [q[0], q[1], q[2]];
            [2.0 * x * y + x * x, 0.0, 0.5 * z * z, -x * x * y + 3.0 * y * z * z, 0.4 * z * z * z - x * z]
        };
        let mut forms = Forms::new(3, 5, &entries);
        let (q, q_dot, q_ddot) = ([0.5, -0.75, 0.3], [2.0, 1.25, -0.7], [-3.0, 0.2, 1.1]);
        forms.look(&q, &q_dot, &q_ddot);
        let (mut values, mut seconds) = ([f64::NAN; 5], [f64::NAN; 3]);
        forms.values(0, &mut values);
        forms.seconds(2, &mut seconds);
        let h = 1e-3;
        let later =
            |h: f64| -> Vec<f64> { (0..3).map(|i| q[i] + h * q_dot[i] + 0.5 * h * h * q_ddot[i]).collect() };
        for form in 0..5 {
            assert!((values[form] - f(&q)[form]).abs() < 1e-15, "{form}: {values:?}");
            let second = (f(&later(h))[form] - 2.0 * f(&q)[form] + f(&later(-h))[form]) / (h * h);
            // A difference leaves out the fourth derivative, of order 100 here, by the square of the step over twelve.
            assert!(form < 2 || (seconds[form - 2] - second).abs() < 1e-4, "{form}: {seconds:?} {second}");
        }
        let weights = [0.3, 7.0, -1.1, 0.0, 2.0];
        forms.weigh(0, &weights[..2]);
        forms.weigh(2, &weights[2..]);
        let mut found = [1.0, 2.0, 3.0];
        forms.pull_back(&mut found);
        for i in 0..3 {
            let along = |h: f64| -> f64 {
                let mut q = q;
                q[i] += h;
                weights.iter().zip(f(&q)).map(|(w, f)| w * f).sum()
            };
            // Exact but for the third derivative.
            let expected = (i + 1) as f64 + (along(h) - along(-h)) / (2.0 * h);
            assert!((found[i] - expected).abs() < 1e-5, "{i}: {found:?} {expected}");
        }
    }
}
