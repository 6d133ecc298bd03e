//! Products of two and three amplitudes, each made from a shorter one.

use alloc::collections::BTreeSet;
use alloc::vec::Vec;

use crate::data::PolynomialData;

/// The products that some polynomials are made of: the amplitudes, products of two, products of three. A product of three is one of two
/// times a last factor.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Products {
    modes: usize,
    quadratic: Vec<[usize; 2]>,
    /// Place among the products of two, and the last factor.
    cubic: Vec<[usize; 2]>,
    /// Where the products of two with each first factor end, and those of three with each product of two.
    quadratic_ends: Vec<usize>,
    cubic_ends: Vec<usize>,
}

impl Products {
    /// All that the terms need: of (row, factors) with two or three factors in ascending order.
    pub(crate) fn new<'a>(modes: usize, terms: impl Iterator<Item = &'a [u32]>) -> Self {
        let (mut two, mut three) = (BTreeSet::new(), BTreeSet::new());
        for factors in terms {
            match *factors {
                [i, j] => {
                    two.insert([i, j]);
                }
                [i, j, k] => {
                    two.insert([i, j]);
                    three.insert([i, j, k]);
                }
                _ => {}
            }
        }
        let quadratic: Vec<[u32; 2]> = two.into_iter().collect();
        let place = |i: u32, j: u32| quadratic.binary_search(&[i, j]).unwrap_or_default();
        let cubic: Vec<[usize; 2]> = three.iter().map(|&[i, j, k]| [place(i, j), k as usize]).collect();
        let quadratic_ends = (0..modes).map(|i| quadratic.partition_point(|pair| pair[0] as usize <= i));
        let cubic_ends = (0..quadratic.len()).map(|pair| cubic.partition_point(|it| it[0] <= pair));
        Products {
            modes,
            quadratic_ends: quadratic_ends.collect(),
            cubic_ends: cubic_ends.collect(),
            cubic,
            quadratic: quadratic.iter().map(|pair| pair.map(|i| i as usize)).collect(),
        }
    }

    /// Those of stored polynomials.
    pub(crate) fn of<'a>(modes: usize, data: impl Iterator<Item = &'a PolynomialData> + Clone) -> Self {
        let quadratic = data.clone().flat_map(|data| &data.quadratic).map(|(_, factors, _)| &factors[..]);
        let cubic = data.flat_map(|data| &data.cubic).map(|(_, factors, _)| &factors[..]);
        Products::new(modes, quadratic.chain(cubic))
    }

    pub(crate) fn len(&self) -> usize {
        self.modes + self.quadratic.len() + self.cubic.len()
    }

    /// Number of products of up to two amplitudes.
    pub(crate) fn len_quadratic(&self) -> usize {
        self.modes + self.quadratic.len()
    }

    /// Place of a product of one to three factors in ascending order.
    pub(crate) fn place(&self, factors: &[u32]) -> Option<usize> {
        let two = |i: u32, j: u32| self.quadratic.binary_search(&[i as usize, j as usize]).ok();
        match *factors {
            [i] => Some(i as usize),
            [i, j] => two(i, j).map(|place| self.modes + place),
            [i, j, k] => {
                let last = [two(i, j)?, k as usize];
                self.cubic.binary_search(&last).ok().map(|place| self.len_quadratic() + place)
            }
            _ => None,
        }
    }

    /// All products at amplitudes - (len).
    #[inline(always)]
    pub(crate) fn values(&self, q: &[f64], out: &mut [f64]) {
        let Some((known, cubic)) = out.split_at_mut_checked(self.len_quadratic()) else { return };
        let Some((linear, quadratic)) = known.split_at_mut_checked(self.modes) else { return };
        for (to, from) in linear.iter_mut().zip(q) {
            *to = *from;
        }
        multiply(linear.iter(), &self.quadratic_ends, &self.quadratic, linear, quadratic);
        multiply(quadratic.iter(), &self.cubic_ends, &self.cubic, linear, cubic);
    }

    /// Adds `sum weight dproduct/dq` to `out`; the weights of the shorter products gather those of the longer ones.
    #[inline(always)]
    pub(crate) fn pull_back(&self, values: &[f64], weights: &mut [f64], out: &mut [f64]) {
        let (Some((value_1, rest)), Some((known, weight_3))) =
            (values.split_at_checked(self.modes), weights.split_at_mut_checked(self.len_quadratic()))
        else {
            return;
        };
        let Some((weight_1, weight_2)) = known.split_at_mut_checked(self.modes) else { return };
        let pairs = rest.iter().zip(weight_2.iter_mut());
        divide(pairs, &self.cubic_ends, &self.cubic, weight_3, value_1, weight_1);
        let mut start = 0;
        for (i, (&end, &x)) in self.quadratic_ends.iter().zip(value_1).enumerate() {
            let mut sum = 0.0;
            let group = self.quadratic.get(start..end).unwrap_or(&[]);
            for (&[_, j], &weight) in group.iter().zip(weight_2.get(start..end).unwrap_or(&[])) {
                sum += weight * at(value_1, j);
                add(weight_1, j, weight * x);
            }
            add(weight_1, i, sum);
            start = end;
        }
        for (out, weight) in out.iter_mut().zip(weight_1.iter()) {
            *out += *weight;
        }
    }
}

/// Products of first ones, group by group, and last factors.
#[inline(always)]
fn multiply<'a>(
    firsts: impl Iterator<Item = &'a f64>,
    ends: &[usize],
    factors: &[[usize; 2]],
    linear: &[f64],
    out: &mut [f64],
) {
    let mut start = 0;
    for (&first, &end) in firsts.zip(ends) {
        let group = factors.get(start..end).unwrap_or(&[]);
        for (&[_, last], to) in group.iter().zip(out.get_mut(start..end).unwrap_or_default()) {
            *to = first * at(linear, last);
        }
        start = end;
    }
}

/// Hands the weights of products of three to the products of two and the last factors in them.
#[inline(always)]
fn divide<'a>(
    pairs: impl Iterator<Item = (&'a f64, &'a mut f64)>,
    ends: &[usize],
    factors: &[[usize; 2]],
    weights: &[f64],
    linear: &[f64],
    out: &mut [f64],
) {
    let mut start = 0;
    for ((&value, of_pair), &end) in pairs.zip(ends) {
        let group = factors.get(start..end).unwrap_or(&[]);
        for (&[_, last], &weight) in group.iter().zip(weights.get(start..end).unwrap_or(&[])) {
            *of_pair += weight * at(linear, last);
            add(out, last, weight * value);
        }
        start = end;
    }
}

#[inline(always)]
fn at(values: &[f64], index: usize) -> f64 {
    values.get(index).copied().unwrap_or(0.0)
}

#[inline(always)]
fn add(values: &mut [f64], index: usize, x: f64) {
    if let Some(value) = values.get_mut(index) {
        *value += x;
    }
}
