//! Polynomials of second and third order in the amplitudes, four rows side by side, with their derivatives (docs/beyond.md).
//!
//! Every product of amplitudes is evaluated once with what is left of it without each of its factors. A term adds these to the columns of
//! its factors, its value to the polynomial and its second derivative along the rates to that of the polynomial.

use alloc::{collections::BTreeMap, vec::Vec};

use crate::data::PolynomialData;
use crate::four::{Four, Machine};

/// Rows of polynomials in blocks of four.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    /// Factors of the products of two amplitudes and of those of three.
    pairs: Vec<[u32; 2]>,
    triples: Vec<[u32; 3]>,
    /// Terms of the second and of the third order, block by block, and where they end in each.
    quadratic: Vec<Term>,
    cubic: Vec<Term>,
    ends: Vec<[usize; 2]>,
}

/// A product and its coefficient in four rows.
type Term = (u32, Four);

/// A product on a path.
#[derive(Clone, Copy, Debug)]
struct Product<const N: usize> {
    columns: [u32; N],
    /// The product without each of its factors, and the rates of these.
    left: [f64; N],
    rates: [f64; N],
    value: f64,
    /// Second derivative along the rates.
    second: f64,
}

impl<const N: usize> Default for Product<N> {
    fn default() -> Self {
        Product { columns: [0; N], left: [0.0; N], rates: [0.0; N], value: 0.0, second: 0.0 }
    }
}

/// The products of some rows on a path.
#[derive(Clone, Debug, Default)]
pub(crate) struct Products {
    pairs: Vec<Product<2>>,
    triples: Vec<Product<3>>,
}

impl Products {
    /// For the products of stored polynomials, or some of them.
    pub(crate) fn of<'a>(data: impl Iterator<Item = &'a PolynomialData> + Clone) -> Self {
        let pairs = distinct(data.clone().flat_map(|it| it.quadratic.iter().map(|term| term.1)));
        let triples = distinct(data.flat_map(|it| it.cubic.iter().map(|term| term.1)));
        Products {
            pairs: pairs.iter().map(|_| Product::default()).collect(),
            triples: triples.iter().map(|_| Product::default()).collect(),
        }
    }
}

/// In order, every one once.
pub(crate) fn distinct<const N: usize>(factors: impl Iterator<Item = [u32; N]>) -> Vec<[u32; N]> {
    let mut distinct: Vec<[u32; N]> = factors.collect();
    distinct.sort_unstable();
    distinct.dedup();
    distinct
}

impl Rows {
    /// So many blocks of rows; the rows of the terms are places in them, `4 block + lane`.
    pub(crate) fn new(blocks: usize, data: &PolynomialData) -> Self {
        let (pairs, quadratic, two) = laid_out(blocks, &data.quadratic);
        let (triples, cubic, three) = laid_out(blocks, &data.cubic);
        let ends = two.into_iter().zip(three).map(|(two, three)| [two, three]).collect();
        Rows { pairs, triples, quadratic, cubic, ends }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.quadratic.is_empty() && self.cubic.is_empty()
    }

    /// Where the terms of each block begin and end.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> impl Iterator<Item = [[usize; 2]; 2]> {
        let starts = core::iter::once([0; 2]).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| [start, *end])
    }

    /// The products at amplitudes.
    #[inline(always)]
    pub(crate) fn at(&self, q: &[f64], products: &mut Products) {
        let at = |mode: u32| q.get(mode as usize).copied();
        for (product, &columns) in products.pairs.iter_mut().zip(&self.pairs) {
            let [i, j] = columns;
            if let (Some(x), Some(y)) = (at(i), at(j)) {
                (product.columns, product.left, product.value) = (columns, [y, x], x * y);
            }
        }
        for (product, &columns) in products.triples.iter_mut().zip(&self.triples) {
            let [i, j, k] = columns;
            if let (Some(x), Some(y), Some(z)) = (at(i), at(j), at(k)) {
                product.columns = columns;
                (product.left, product.value) = ([y * z, x * z, x * y], x * y * z);
            }
        }
    }

    /// The products at amplitudes and rates.
    #[inline(always)]
    pub(crate) fn along(&self, q: &[f64], q_dot: &[f64], products: &mut Products) {
        let at = |mode: u32| Some((*q.get(mode as usize)?, *q_dot.get(mode as usize)?));
        for (product, &columns) in products.pairs.iter_mut().zip(&self.pairs) {
            let [i, j] = columns;
            if let (Some((x, dx)), Some((y, dy))) = (at(i), at(j)) {
                (product.columns, product.left, product.rates) = (columns, [y, x], [dy, dx]);
                (product.value, product.second) = (x * y, 2.0 * (dx * dy));
            }
        }
        for (product, &columns) in products.triples.iter_mut().zip(&self.triples) {
            let [i, j, k] = columns;
            if let (Some((x, dx)), Some((y, dy)), Some((z, dz))) = (at(i), at(j), at(k)) {
                (product.columns, product.left) = (columns, [y * z, x * z, x * y]);
                product.rates = [dy * z + y * dz, dx * z + x * dz, dx * y + x * dy];
                product.value = x * y * z;
                product.second = 2.0 * (dx * dy * z + (dx * y + x * dy) * dz);
            }
        }
    }

    /// Adds the derivatives of a block to `row` - (modes) -, its values and second derivatives to what is given.
    #[inline(always)]
    pub(crate) fn add<M: Machine>(
        &self,
        m: M,
        block: [[usize; 2]; 2],
        products: &Products,
        row: &mut [Four],
        sums: [M::Lanes; 2],
    ) -> [M::Lanes; 2] {
        let [[two, three], [two_end, three_end]] = block;
        let sums = add_terms(m, self.quadratic.get(two..two_end), &products.pairs, row, sums);
        add_terms(m, self.cubic.get(three..three_end), &products.triples, row, sums)
    }

    /// Adds `factor` times the rates of the derivatives pulled back by `along`, four numbers a block, at the products of [`Self::along`].
    /// `weights` is scratch - (products).
    #[inline(always)]
    pub(crate) fn add_rate_pull_back<M: Machine>(
        &self,
        m: M,
        factor: f64,
        along: &[Four],
        products: &Products,
        weights: &mut [Four],
        out: &mut [f64],
    ) {
        weights.fill([0.0; 4]);
        let Some((of_pairs, of_triples)) = weights.split_at_mut_checked(self.pairs.len()) else { return };
        for (along, [[two, three], [two_end, three_end]]) in along.iter().zip(self.blocks()) {
            let along = m.load(along);
            weigh(m, self.quadratic.get(two..two_end), along, of_pairs);
            weigh(m, self.cubic.get(three..three_end), along, of_triples);
        }
        hand_out(m, factor, &products.pairs, of_pairs, out);
        hand_out(m, factor, &products.triples, of_triples, out);
    }

    /// Number of products.
    pub(crate) fn n_products(&self) -> usize {
        self.pairs.len() + self.triples.len()
    }
}

#[inline(always)]
fn add_terms<M: Machine, const N: usize>(
    m: M,
    terms: Option<&[Term]>,
    products: &[Product<N>],
    row: &mut [Four],
    [mut value, mut second]: [M::Lanes; 2],
) -> [M::Lanes; 2] {
    for (place, coefficients) in terms.unwrap_or(&[]) {
        let Some(product) = products.get(*place as usize) else { continue };
        let coefficients = m.load(coefficients);
        value = value + m.splat(product.value) * coefficients;
        second = second + m.splat(product.second) * coefficients;
        for (column, left) in product.columns.iter().zip(product.left) {
            if let Some(to) = row.get_mut(*column as usize) {
                *to = m.store(m.load(to) + m.splat(left) * coefficients);
            }
        }
    }
    [value, second]
}

/// Adds what the rows `along` give the products of their terms.
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
    products: &[Product<N>],
    weights: &[Four],
    out: &mut [f64],
) {
    for (product, weight) in products.iter().zip(weights) {
        let weight = factor * m.sum(m.load(weight));
        for (column, rate) in product.columns.iter().zip(product.rates) {
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
    let products = distinct(polynomials.iter().map(|term| term.1));
    let mut found: BTreeMap<(u32, usize), Four> = BTreeMap::new();
    for (row, factors, value) in polynomials {
        let place = products.partition_point(|it| it < factors);
        let four = found.entry((row / 4, place)).or_default();
        if let Some(to) = four.get_mut(*row as usize % 4) {
            *to = *value;
        }
    }
    let mut ends = Vec::with_capacity(blocks);
    let mut terms = Vec::with_capacity(found.len());
    let mut found = found.into_iter().peekable();
    for block in 0..blocks {
        while let Some(((_, place), four)) = found.next_if(|((of, _), _)| *of as usize == block) {
            terms.push((place as u32, four));
        }
        ends.push(terms.len());
    }
    (products, terms, ends)
}
