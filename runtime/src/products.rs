//! Products of two and three amplitudes, each made from a shorter one.

use alloc::collections::BTreeSet;
use alloc::{vec, vec::Vec};

use crate::data::PolynomialData;

/// The products that some polynomials are made of: the amplitudes, products of two, products of three. A product of three is one of two
/// times a last factor.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Products {
    modes: usize,
    quadratic: Vec<[usize; 2]>,
    /// Place among the products of two, and the last factor.
    cubic: Vec<[usize; 2]>,
}

/// The products on a path.
#[derive(Clone, Debug, Default)]
pub(crate) struct Path {
    /// The amplitudes and the products of two, and their rates - (len_quadratic).
    pub(crate) values: Vec<f64>,
    pub(crate) rates: Vec<f64>,
    /// Second derivatives along the rates; zero of the amplitudes - (len).
    pub(crate) seconds: Vec<f64>,
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
        Products {
            modes,
            cubic: three.iter().map(|&[i, j, k]| [place(i, j), k as usize]).collect(),
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
        for (to, &[i, j]) in quadratic.iter_mut().zip(&self.quadratic) {
            *to = at(linear, i) * at(linear, j);
        }
        for (to, &[pair, k]) in cubic.iter_mut().zip(&self.cubic) {
            *to = at(quadratic, pair) * at(linear, k);
        }
    }

    /// Scratch for [`Self::along`].
    pub(crate) fn path(&self) -> Path {
        let known = self.len_quadratic();
        Path { values: vec![0.0; known], rates: vec![0.0; known], seconds: vec![0.0; self.len()] }
    }

    /// Values, rates and second derivatives along the rates.
    #[inline(always)]
    pub(crate) fn along(&self, q: &[f64], q_dot: &[f64], path: &mut Path) {
        let Path { values, rates, seconds } = path;
        let (Some((q_kept, values)), Some((q_dot_kept, rates)), Some((_, seconds))) = (
            values.split_at_mut_checked(self.modes),
            rates.split_at_mut_checked(self.modes),
            seconds.split_at_mut_checked(self.modes),
        ) else {
            return;
        };
        for ((to, rate), (q, q_dot)) in q_kept.iter_mut().zip(q_dot_kept.iter_mut()).zip(q.iter().zip(q_dot))
        {
            (*to, *rate) = (*q, *q_dot);
        }
        let Some((seconds_2, seconds_3)) = seconds.split_at_mut_checked(self.quadratic.len()) else { return };
        let of_two = values.iter_mut().zip(rates.iter_mut()).zip(seconds_2.iter_mut());
        for (((value, rate), second), &[i, j]) in of_two.zip(&self.quadratic) {
            let (x, y, dx, dy) = (at(q_kept, i), at(q_kept, j), at(q_dot_kept, i), at(q_dot_kept, j));
            (*value, *rate, *second) = (x * y, dx * y + x * dy, 2.0 * (dx * dy));
        }
        for (second, &[pair, k]) in seconds_3.iter_mut().zip(&self.cubic) {
            *second = at(seconds_2, pair) * at(q_kept, k) + 2.0 * (at(rates, pair) * at(q_dot_kept, k));
        }
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
        for (&weight, &[pair, k]) in weight_3.iter().zip(&self.cubic) {
            add(weight_2, pair, weight * at(value_1, k));
            add(weight_1, k, weight * at(rest, pair));
        }
        for (&weight, &[i, j]) in weight_2.iter().zip(&self.quadratic) {
            add(weight_1, i, weight * at(value_1, j));
            add(weight_1, j, weight * at(value_1, i));
        }
        for (out, weight) in out.iter_mut().zip(weight_1.iter()) {
            *out += *weight;
        }
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
