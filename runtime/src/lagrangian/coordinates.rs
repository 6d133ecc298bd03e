//! The kinetic coordinates `y(q)` of (B.3), laid out for their derivatives, four coordinates side by side.
//!
//! With the products `p` of one and two amplitudes that `D = dy/dq` is made of, `D = A + E_1 p_1 + E_2 p_2`, and as every term is
//! homogeneous `y = (A + E_1 p_1/2 + E_2 p_2/3) q`. One pass over the entries of `E` gives both, one over the terms of `y` its second
//! derivative along the rates.

use alloc::{collections::BTreeMap, vec, vec::Vec};

use super::arrangement::Arrangement;
use crate::data::{LagrangianData, PolynomialData};
use crate::dense::{rows, rows_mut};
use crate::four::{Four, Machine};
use crate::products::{Path as ProductPath, Products};

/// `y(q)` by blocks of four.
#[derive(Clone, Debug)]
pub(super) struct Coordinates {
    modes: usize,
    blocks: usize,
    products: Products,
    /// What a column of `D` is made of, block by block - (modes x blocks).
    cells: Vec<Cell>,
    /// Product of amplitudes and its factors in the four rows: `E`.
    terms: Vec<(u32, Four)>,
    /// Monomials of the second and third order of `y` and their coefficients, block by block, and where those of a block end.
    curve: Vec<(u32, Four)>,
    curve_ends: Vec<usize>,
    n_terms: usize,
}

/// Four rows of a column of `D`.
#[derive(Clone, Copy, Debug)]
struct Cell {
    linear: Four,
    /// Where the terms with one amplitude end, and those with two after them.
    ends: [usize; 2],
}

/// The coordinates on a path.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    products: ProductPath,
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
        let mut derivatives = derivatives(&curve);
        derivatives.sort_by_key(cell_of);
        let all =
            curve.quadratic.iter().map(|term| &term.1[..]).chain(curve.cubic.iter().map(|term| &term.1[..]));
        let products = Products::new(modes, derivatives.iter().map(|it| &it.2[..]).chain(all));
        let (mut cells, mut terms) = (Vec::new(), Vec::new());
        for column in 0..modes {
            for block in 0..blocks {
                let cell = (column as u32, block as u32);
                let first = derivatives.partition_point(|it| cell_of(it) < cell);
                let of_cell = derivatives.iter().skip(first).take_while(|it| cell_of(it) == cell);
                let of_cell = gathered(of_cell.map(|it| (it.0 as usize % 4, products.place(&it.2), it.3)));
                let first = terms.len() + of_cell.partition_point(|term| (term.0 as usize) < modes);
                terms.extend(of_cell);
                let entry = |field: usize| data.linear.get(field * modes + column).copied().unwrap_or(0.0);
                let linear = arrangement.four(block, entry);
                cells.push(Cell { linear, ends: [first, terms.len()] });
            }
        }
        let (mut placed, mut curve_ends) = (Vec::new(), Vec::new());
        for block in 0..blocks {
            let quadratic =
                curve.quadratic.iter().map(|(row, factors, value)| (*row, products.place(factors), *value));
            let cubic =
                curve.cubic.iter().map(|(row, factors, value)| (*row, products.place(factors), *value));
            let of_block = quadratic.chain(cubic).filter(|it| it.0 as usize / 4 == block);
            placed.extend(gathered(of_block.map(|(row, place, value)| (row as usize % 4, place, value))));
            curve_ends.push(placed.len());
        }
        let n_terms = data.curve.quadratic.len() + data.curve.cubic.len();
        Coordinates { modes, blocks, products, cells, terms, curve: placed, curve_ends, n_terms }
    }

    pub(super) fn n_terms(&self) -> usize {
        self.n_terms
    }

    pub(super) fn path(&self) -> Path {
        let Coordinates { modes, blocks, .. } = *self;
        Path {
            products: self.products.path(),
            y: vec![[0.0; 4]; blocks],
            y_dot: vec![[0.0; 4]; blocks],
            second: vec![[0.0; 4]; blocks],
            d: vec![[0.0; 4]; modes.next_multiple_of(2) * blocks],
        }
    }

    /// `y`, its rate, its second derivative along the rates, and `D`.
    #[inline(always)]
    pub(super) fn evaluate<M: Machine>(&self, m: M, q: &[f64], q_dot: &[f64], at: &mut Path) {
        let Path { products, y, y_dot, second, d } = at;
        self.products.along(q, q_dot, products);
        y.fill([0.0; 4]);
        y_dot.fill([0.0; 4]);
        let (half, third) = (m.splat(0.5), m.splat(1.0 / 3.0));
        let mut start = 0;
        let columns = rows_mut(d, self.blocks).zip(rows(&self.cells, self.blocks));
        for ((d, cells), (&q, &q_dot)) in columns.zip(q.iter().zip(q_dot)) {
            let (q, q_dot) = (m.splat(q), m.splat(q_dot));
            let y = y.iter_mut().zip(y_dot.iter_mut());
            for ((d, Cell { linear, ends: [middle, end] }), (y, y_dot)) in d.iter_mut().zip(cells).zip(y) {
                let one = sum(m, self.terms.get(start..*middle), &products.values);
                let two = sum(m, self.terms.get(*middle..*end), &products.values);
                start = *end;
                let linear = m.load(linear);
                let derivative = linear + (one + two);
                *d = m.store(derivative);
                *y = m.store(m.load(y) + q * (linear + half * one + third * two));
                *y_dot = m.store(m.load(y_dot) + q_dot * derivative);
            }
        }
        let mut start = 0;
        for (second, &end) in second.iter_mut().zip(&self.curve_ends) {
            *second = m.store(sum(m, self.curve.get(start..end), &products.seconds));
            start = end;
        }
    }

    /// Adds `factor D_dot^t along` at the amplitudes and rates evaluated last.
    #[inline(always)]
    pub(super) fn add_rate_pull_back<M: Machine>(
        &self,
        m: M,
        factor: f64,
        along: &[Four],
        at: &Path,
        out: &mut [f64],
    ) {
        let mut start = 0;
        for (out, cells) in out.iter_mut().zip(rows(&self.cells, self.blocks)) {
            let mut sums = m.zero();
            for (&Cell { ends: [_, end], .. }, along) in cells.iter().zip(along) {
                let rate = sum(m, self.terms.get(start..end), &at.products.rates);
                start = end;
                sums = sums + rate * m.load(along);
            }
            *out += factor * m.sum(sums);
        }
    }
}

/// `sum value_k c_k`.
#[inline(always)]
fn sum<M: Machine>(m: M, terms: Option<&[(u32, Four)]>, values: &[f64]) -> M::Lanes {
    let mut sum = m.zero();
    for (place, coefficients) in terms.unwrap_or(&[]) {
        if let Some(&value) = values.get(*place as usize) {
            sum = sum + m.splat(value) * m.load(coefficients);
        }
    }
    sum
}

/// Terms (lane, place of a product, value) with the four lanes of a product side by side, sorted by product.
fn gathered(terms: impl Iterator<Item = (usize, Option<usize>, f64)>) -> Vec<(u32, Four)> {
    let mut fours: BTreeMap<u32, Four> = BTreeMap::new();
    for (lane, place, value) in terms {
        let Some(place) = place else { continue };
        if let Some(to) = fours.entry(place as u32).or_default().get_mut(lane) {
            *to = value;
        }
    }
    fours.into_iter().collect()
}

/// A term of `D`: row, column, the factors left, coefficient.
type Derivative = (u32, u32, Vec<u32>, f64);

/// Column and block of rows.
fn cell_of(term: &Derivative) -> (u32, u32) {
    (term.1, term.0 / 4)
}

/// The terms of `D`.
fn derivatives(curve: &PolynomialData) -> Vec<Derivative> {
    let quadratic = curve.quadratic.iter().map(|(row, factors, value)| (*row, &factors[..], *value));
    let cubic = curve.cubic.iter().map(|(row, factors, value)| (*row, &factors[..], *value));
    let mut out = Vec::new();
    for (row, factors, value) in quadratic.chain(cubic) {
        let mut last = None;
        for (at, &column) in factors.iter().enumerate() {
            // Factors ascend: equal ones follow each other.
            if last != Some(column) {
                let count = factors.iter().filter(|&&other| other == column).count();
                let rest = factors.iter().enumerate().filter(|(other, _)| *other != at);
                out.push((row, column, rest.map(|(_, i)| *i).collect(), value * count as f64));
            }
            last = Some(column);
        }
    }
    out
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
            coordinates.add_rate_pull_back(Plain, 2.0, &along, &path, &mut rates);
            for k in 0..m {
                let expected = derivative(&q, row, k) + row_of_a(k);
                assert!(close(path.d[k * arrangement.blocks() + block][lane], expected), "{row} {k}");
                let expected = 0.25 + 3.0 * (derivative(&after, row, k) - derivative(&before, row, k));
                assert!((rates[k] - expected).abs() < 1e-13, "{row} {k}: {} {expected}", rates[k]);
            }
        }
    }
}
