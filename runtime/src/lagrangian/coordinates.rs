//! The kinetic coordinates `y(q)` of (B.3), laid out for their derivatives, four coordinates side by side.
//!
//! Every product of amplitudes is evaluated once with what is left of it without each of its factors. Block by block `D = dy/dq` begins as
//! `A`, and every term adds these to the columns of its factors, its value to `y` and its second derivative along the rates.

use alloc::{collections::BTreeMap, vec, vec::Vec};

use super::arrangement::Arrangement;
use crate::data::LagrangianData;
use crate::dense::{rows, rows_mut};
use crate::four::{Four, Machine};

/// `y(q)` by blocks of four.
#[derive(Clone, Debug)]
pub(super) struct Coordinates {
    modes: usize,
    blocks: usize,
    /// Factors of the products of two amplitudes and of those of three.
    pairs: Vec<[u32; 2]>,
    triples: Vec<[u32; 3]>,
    /// `A` - (blocks x modes).
    linear: Vec<Four>,
    /// Terms of the second and of the third order, block by block, and where they end in each.
    quadratic: Vec<Term>,
    cubic: Vec<Term>,
    ends: Vec<[usize; 2]>,
    n_terms: usize,
}

/// A product and its coefficient in four coordinates.
type Term = (u32, Four);

/// A product on a path.
#[derive(Clone, Copy, Debug)]
struct Jet<const N: usize> {
    columns: [u32; N],
    /// The product without each of its factors, and the rates of these.
    left: [f64; N],
    rates: [f64; N],
    value: f64,
    /// Second derivative along the rates.
    second: f64,
}

/// The coordinates on a path.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    pairs: Vec<Jet<2>>,
    triples: Vec<Jet<3>>,
    /// Rows of `D` - (modes).
    row: Vec<Four>,
    /// What a pull-back collects - (pairs, then triples).
    weights: Vec<Four>,
    /// `y`, its rate, and its second derivative along the rates - (blocks).
    pub(super) y: Vec<Four>,
    pub(super) y_dot: Vec<Four>,
    pub(super) second: Vec<Four>,
    /// `D`, column by column; a column of zeros last where there are odd many - (columns x blocks).
    pub(super) d: Vec<Four>,
}

impl Coordinates {
    pub(super) fn new(modes: usize, arrangement: &Arrangement, data: &LagrangianData) -> Self {
        let blocks = arrangement.blocks();
        let curve = arrangement.placed(&data.curve);
        let entry = |field: usize, mode: usize| data.linear.get(field * modes + mode).copied().unwrap_or(0.0);
        let linear = (0..blocks).flat_map(|block| (0..modes).map(move |mode| (block, mode)));
        let (pairs, quadratic, pair_ends) = laid_out(blocks, &curve.quadratic);
        let (triples, cubic, triple_ends) = laid_out(blocks, &curve.cubic);
        Coordinates {
            modes,
            blocks,
            pairs,
            triples,
            linear: linear.map(|(block, mode)| arrangement.four(block, |field| entry(field, mode))).collect(),
            quadratic,
            cubic,
            ends: pair_ends.into_iter().zip(triple_ends).map(|(two, three)| [two, three]).collect(),
            n_terms: data.curve.quadratic.len() + data.curve.cubic.len(),
        }
    }

    pub(super) fn n_terms(&self) -> usize {
        self.n_terms
    }

    pub(super) fn path(&self) -> Path {
        let Coordinates { modes, blocks, .. } = *self;
        let zero = [0.0; 4];
        Path {
            pairs: self.pairs.iter().map(|&columns| Jet::of(columns)).collect(),
            triples: self.triples.iter().map(|&columns| Jet::of(columns)).collect(),
            row: vec![zero; modes],
            weights: vec![zero; self.pairs.len() + self.triples.len()],
            y: vec![zero; blocks],
            y_dot: vec![zero; blocks],
            second: vec![zero; blocks],
            d: vec![zero; modes.next_multiple_of(2) * blocks],
        }
    }

    /// `y`, its rate, its second derivative along the rates, and `D`.
    #[inline(always)]
    pub(super) fn evaluate<M: Machine>(&self, m: M, q: &[f64], q_dot: &[f64], at: &mut Path) {
        at.multiply(q, q_dot);
        let Path { pairs, triples, row, y, y_dot, second, d, .. } = at;
        let mut starts = [0; 2];
        let results = y.iter_mut().zip(y_dot.iter_mut()).zip(second.iter_mut());
        let blocks = results.zip(rows(&self.linear, self.modes)).zip(&self.ends);
        for (block, ((((y, y_dot), second), linear), &ends)) in blocks.enumerate() {
            let mut value = m.zero();
            for ((row, linear), &q) in row.iter_mut().zip(linear).zip(q) {
                *row = *linear;
                value = value + m.splat(q) * m.load(linear);
            }
            let terms = self.quadratic.get(starts[0]..ends[0]);
            let (value, of_two) = add_terms(m, terms, pairs, row, (value, m.zero()));
            let terms = self.cubic.get(starts[1]..ends[1]);
            let (value, of_three) = add_terms(m, terms, triples, row, (value, of_two));
            starts = ends;
            (*y, *second) = (m.store(value), m.store(of_three));
            let mut rate = m.zero();
            for ((column, row), &q_dot) in rows_mut(d, self.blocks).zip(row.iter()).zip(q_dot) {
                rate = rate + m.splat(q_dot) * m.load(row);
                if let Some(to) = column.get_mut(block) {
                    *to = *row;
                }
            }
            *y_dot = m.store(rate);
        }
    }

    /// Adds `factor D_dot^t along` at the amplitudes and rates evaluated last.
    #[inline(always)]
    pub(super) fn add_rate_pull_back<M: Machine>(
        &self,
        m: M,
        factor: f64,
        along: &[Four],
        at: &mut Path,
        out: &mut [f64],
    ) {
        let Path { pairs, triples, weights, .. } = at;
        weights.fill([0.0; 4]);
        let Some((of_pairs, of_triples)) = weights.split_at_mut_checked(pairs.len()) else { return };
        let mut starts = [0; 2];
        for (along, &ends) in along.iter().zip(&self.ends) {
            let along = m.load(along);
            weigh(m, self.quadratic.get(starts[0]..ends[0]), along, of_pairs);
            weigh(m, self.cubic.get(starts[1]..ends[1]), along, of_triples);
            starts = ends;
        }
        hand_out(m, factor, pairs, of_pairs, out);
        hand_out(m, factor, triples, of_triples, out);
    }
}

impl<const N: usize> Jet<N> {
    fn of(columns: [u32; N]) -> Self {
        Jet { columns, left: [0.0; N], rates: [0.0; N], value: 0.0, second: 0.0 }
    }
}

impl Path {
    /// The products at amplitudes and rates.
    #[inline(always)]
    fn multiply(&mut self, q: &[f64], q_dot: &[f64]) {
        let at = |mode: u32| -> Option<(f64, f64)> { Some((*q.get(mode as usize)?, *q_dot.get(mode as usize)?)) };
        for jet in &mut self.pairs {
            let [i, j] = jet.columns;
            if let (Some((x, dx)), Some((y, dy))) = (at(i), at(j)) {
                (jet.left, jet.rates) = ([y, x], [dy, dx]);
                (jet.value, jet.second) = (x * y, 2.0 * (dx * dy));
            }
        }
        for jet in &mut self.triples {
            let [i, j, k] = jet.columns;
            if let (Some((x, dx)), Some((y, dy)), Some((z, dz))) = (at(i), at(j), at(k)) {
                jet.left = [y * z, x * z, x * y];
                jet.rates = [dy * z + y * dz, dx * z + x * dz, dx * y + x * dy];
                (jet.value, jet.second) = (x * y * z, 2.0 * (dx * dy * z + (dx * y + x * dy) * dz));
            }
        }
    }
}

/// Adds terms to a row of `D`, to values and second derivatives.
#[inline(always)]
fn add_terms<M: Machine, const N: usize>(
    m: M,
    terms: Option<&[Term]>,
    jets: &[Jet<N>],
    row: &mut [Four],
    sums: (M::Lanes, M::Lanes),
) -> (M::Lanes, M::Lanes) {
    let (mut value, mut second) = sums;
    for (place, coefficients) in terms.unwrap_or(&[]) {
        let Some(jet) = jets.get(*place as usize) else { continue };
        let coefficients = m.load(coefficients);
        value = value + m.splat(jet.value) * coefficients;
        second = second + m.splat(jet.second) * coefficients;
        for (column, left) in jet.columns.iter().zip(jet.left) {
            if let Some(to) = row.get_mut(*column as usize) {
                *to = m.store(m.load(to) + m.splat(left) * coefficients);
            }
        }
    }
    (value, second)
}

/// Adds what the coordinates `along` give the products of their terms.
#[inline(always)]
fn weigh<M: Machine>(m: M, terms: Option<&[Term]>, along: M::Lanes, weights: &mut [Four]) {
    for (place, coefficients) in terms.unwrap_or(&[]) {
        if let Some(weight) = weights.get_mut(*place as usize) {
            *weight = m.store(m.load(weight) + along * m.load(coefficients));
        }
    }
}

/// Adds weights times the rates of the derivatives of the products.
#[inline(always)]
fn hand_out<M: Machine, const N: usize>(
    m: M,
    factor: f64,
    jets: &[Jet<N>],
    weights: &[Four],
    out: &mut [f64],
) {
    for (jet, weight) in jets.iter().zip(weights) {
        let weight = factor * m.sum(m.load(weight));
        for (column, rate) in jet.columns.iter().zip(jet.rates) {
            if let Some(out) = out.get_mut(*column as usize) {
                *out += weight * rate;
            }
        }
    }
}

/// Polynomials by place: the products in them, the terms block by block with four rows side by side, and where those of a block end.
fn laid_out<const N: usize>(
    blocks: usize,
    polynomials: &[(u32, [u32; N], f64)],
) -> (Vec<[u32; N]>, Vec<Term>, Vec<usize>) {
    let mut products: Vec<[u32; N]> = polynomials.iter().map(|term| term.1).collect();
    products.sort_unstable();
    products.dedup();
    let mut found: BTreeMap<(u32, usize), Four> = BTreeMap::new();
    for (row, factors, value) in polynomials {
        let place = products.partition_point(|it| it < factors);
        let four = found.entry((row / 4, place)).or_default();
        if let Some(to) = four.get_mut(*row as usize % 4) {
            *to = *value;
        }
    }
    let ends = (0..blocks).map(|block| found.range(..(block as u32 + 1, 0)).count()).collect();
    (products, found.into_iter().map(|((_, place), four)| (place as u32, four)).collect(), ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::TensorData;
    use crate::four::Plain;
    use crate::polynomial::Polynomial;
    use alloc::string::String;

    #[test]
    fn values_and_derivatives_are_those_of_the_polynomials() {
        let curve = PolynomialData {
            quadratic: vec![(0, [0, 0], 1.0), (0, [0, 4], 2.0), (6, [1, 3], -0.7)],
            cubic: vec![(2, [0, 0, 4], -1.0), (2, [4, 4, 4], 3.0), (6, [0, 1, 2], 0.3), (6, [1, 1, 3], 0.9)],
        };
        let (m, n) = (5, 7);
        let linear: Vec<f64> =
            (0..m * m).map(|k| if k % m >= k / m { 1.0 / (k + 1) as f64 } else { 0.0 }).collect();
        let none = TensorData {
            i: vec![],
            l: vec![],
            r: vec![],
            value: vec![],
            threshold: 0.0,
            scale: String::new(),
            dropped_norm: 0.0,
            dropped_count: 0,
        };
        let data = LagrangianData {
            geometric: true,
            fields: n as u32,
            linear: linear.clone(),
            curve: curve.clone(),
            first_moment: vec![],
            moment_0: vec![],
            moment: none,
            stiffness: vec![],
            self_stress: vec![],
            self_stress_curve: PolynomialData::default(),
            points: vec![],
            range: vec![],
            tolerance: 0.0,
            dropped_norm: 0.0,
        };
        let arrangement = Arrangement::new(m, &data);
        let coordinates = Coordinates::new(m, &arrangement, &data);
        let mut path = coordinates.path();
        let (q, q_dot) = ([0.5, -0.75, 0.2, 1.1, -0.4], [2.0, 1.25, -0.3, 0.6, 0.9]);
        coordinates.evaluate(Plain, &q, &q_dot, &mut path);
        let polynomial = Polynomial::new(n, &curve);
        let (mut y, mut rate, mut second) = ([0.0; 7], [0.0; 7], [0.0; 7]);
        polynomial.along(&q, &q_dot, &mut y, &mut rate, &mut second);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-14;
        // `D_dot` of one row at a time, by its definition: differences of `D` along the rates are exact to second degree.
        let derivative = |q: &[f64], row: usize, k: usize| {
            let (mut direction, mut out) = ([0.0; 5], [0.0; 7]);
            direction[k] = 1.0;
            polynomial.derivative(q, &direction, &mut out);
            out[row]
        };
        let moved = |h: f64| -> Vec<f64> { q.iter().zip(&q_dot).map(|(q, rate)| q + h * rate).collect() };
        let (before, after) = (moved(-0.5), moved(0.5));
        for row in 0..n {
            let place = arrangement.place(row as u32);
            let (block, lane) = (place / 4, place % 4);
            let row_of_a = |i: usize| if row < m { linear[row * m + i] } else { 0.0 };
            let line = |x: &[f64]| (0..m).map(|i| row_of_a(i) * x[i]).sum::<f64>();
            assert!(close(path.y[block][lane], y[row] + line(&q)));
            assert!(close(path.y_dot[block][lane], rate[row] + line(&q_dot)));
            assert!(close(path.second[block][lane], second[row]));
            let mut along = vec![[0.0; 4]; arrangement.blocks()];
            along[block][lane] = 1.5;
            let mut rates = vec![0.25; m];
            coordinates.add_rate_pull_back(Plain, 2.0, &along, &mut path, &mut rates);
            for k in 0..m {
                let expected = derivative(&q, row, k) + row_of_a(k);
                assert!(close(path.d[k * arrangement.blocks() + block][lane], expected), "{row} {k}");
                let expected = 0.25 + 3.0 * (derivative(&after, row, k) - derivative(&before, row, k));
                assert!((rates[k] - expected).abs() < 1e-13, "{row} {k}: {} {expected}", rates[k]);
            }
        }
    }
}
