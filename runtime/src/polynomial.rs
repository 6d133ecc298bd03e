//! Sparse polynomials of second and third order in the modal amplitudes (docs/beyond.md): what bends shapes and kinetic
//! coordinates off the plane of the modes.

use alloc::{vec, vec::Vec};

use crate::data::PolynomialData;
use crate::real::Real;

/// Rows of polynomials. Every function here adds to what it is given.
#[derive(Clone, Debug, Default)]
pub(crate) struct Polynomial {
    monomials: Vec<Monomial>,
    /// Where the terms of each row end - (rows).
    ends: Vec<usize>,
    /// Index of the monomial and coefficient, row by row.
    terms: Vec<(usize, f64)>,
}

/// A product of two or three amplitudes; of two where `third` is none.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Monomial {
    i: usize,
    j: usize,
    third: Option<usize>,
}

/// A monomial on a path: value, derivatives by its factors, second derivative along the rates.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Jet<R = f64> {
    factors: [usize; 3],
    value: R,
    gradient: [R; 3],
    second: R,
    /// What a pull-back collects.
    weight: R,
}

impl Monomial {
    #[inline]
    fn jet<R: Real>(&self, q: &[R], rate: &[R]) -> Jet<R> {
        let (zero, two) = (R::of(0.0), R::of(2.0));
        let at = |values: &[R], index: usize| values.get(index).copied().unwrap_or(zero);
        let (x, y) = (at(q, self.i), at(q, self.j));
        let (dx, dy) = (at(rate, self.i), at(rate, self.j));
        match self.third {
            None => Jet {
                factors: [self.i, self.j, self.i],
                value: x * y,
                gradient: [y, x, zero],
                second: two * dx * dy,
                weight: zero,
            },
            Some(k) => {
                let (z, dz) = (at(q, k), at(rate, k));
                Jet {
                    factors: [self.i, self.j, k],
                    value: x * y * z,
                    gradient: [y * z, x * z, x * y],
                    second: two * (dx * dy * z + dx * y * dz + x * dy * dz),
                    weight: zero,
                }
            }
        }
    }
}

impl<R: Real> Jet<R> {
    #[inline]
    fn rate(&self, rate: &[R]) -> R {
        let mut sum = R::of(0.0);
        for (&i, g) in self.factors.iter().zip(&self.gradient) {
            sum += *g * rate.get(i).copied().unwrap_or(R::of(0.0));
        }
        sum
    }
}

impl Polynomial {
    /// Terms sorted by row, with rows below `rows`.
    pub(crate) fn new(rows: usize, data: &PolynomialData) -> Self {
        let index = |values: &[u32]| values.iter().map(|&i| i as usize).collect::<Vec<_>>();
        let mut all: Vec<(usize, Monomial, f64)> = Vec::new();
        for (row, factors, value) in &data.quadratic {
            if let [i, j] = index(factors)[..] {
                all.push((*row as usize, Monomial { i, j, third: None }, *value));
            }
        }
        for (row, factors, value) in &data.cubic {
            if let [i, j, k] = index(factors)[..] {
                all.push((*row as usize, Monomial { i, j, third: Some(k) }, *value));
            }
        }
        all.sort_by_key(|(row, ..)| *row);
        let mut monomials: Vec<Monomial> = all.iter().map(|(_, monomial, _)| *monomial).collect();
        let key = |m: &Monomial| (m.third, m.i, m.j);
        monomials.sort_by_key(key);
        monomials.dedup();
        let ends = (0..rows).map(|row| all.partition_point(|(r, ..)| *r <= row)).collect();
        let terms = all
            .iter()
            .map(|(_, m, value)| (monomials.binary_search_by_key(&key(m), key).unwrap_or_default(), *value))
            .collect();
        Polynomial { monomials, ends, terms }
    }

    /// Scratch for [`Self::prepare`].
    pub(crate) fn jets<R: Real>(&self) -> Vec<Jet<R>> {
        vec![Jet::default(); self.monomials.len()]
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// The monomials at amplitudes and rates.
    #[inline]
    pub(crate) fn prepare<R: Real>(&self, q: &[R], rate: &[R], jets: &mut [Jet<R>]) {
        for (jet, monomial) in jets.iter_mut().zip(&self.monomials) {
            *jet = monomial.jet(q, rate);
        }
    }

    /// Terms of each row in turn.
    #[inline]
    fn rows(&self) -> impl Iterator<Item = &[(usize, f64)]> {
        let starts = core::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| self.terms.get(start..end).unwrap_or(&[]))
    }

    /// Values, rates and second derivatives along the rates, from the amplitudes: without scratch, for outputs.
    pub(crate) fn along<R: Real>(
        &self,
        q: &[R],
        rate: &[R],
        value: &mut [R],
        first: &mut [R],
        second: &mut [R],
    ) {
        for (((value, first), second), terms) in value.iter_mut().zip(first).zip(second).zip(self.rows()) {
            for &(monomial, factor) in terms {
                let Some(monomial) = self.monomials.get(monomial) else { return };
                let jet = monomial.jet(q, rate);
                let factor = R::of(factor);
                *value += factor * jet.value;
                *first += factor * jet.rate(rate);
                *second += factor * jet.second;
            }
        }
    }

    /// Values alone, from the amplitudes.
    pub(crate) fn at(&self, q: &[f64], value: &mut [f64]) {
        for (value, terms) in value.iter_mut().zip(self.rows()) {
            for &(monomial, factor) in terms {
                let Some(monomial) = self.monomials.get(monomial) else { return };
                *value += factor * monomial.jet(q, q).value;
            }
        }
    }

    /// Derivative along `direction`, row by row.
    pub(crate) fn derivative<R: Real>(&self, q: &[R], direction: &[R], out: &mut [R]) {
        for (out, terms) in out.iter_mut().zip(self.rows()) {
            for &(monomial, factor) in terms {
                let Some(monomial) = self.monomials.get(monomial) else { return };
                *out += R::of(factor) * monomial.jet(q, direction).rate(direction);
            }
        }
    }

    /// Values from prepared monomials.
    #[inline]
    pub(crate) fn values<R: Real>(&self, jets: &[Jet<R>], value: &mut [R]) {
        for (value, terms) in value.iter_mut().zip(self.rows()) {
            for &(monomial, factor) in terms {
                *value += R::of(factor) * jets.get(monomial).map_or(R::of(0.0), |jet| jet.value);
            }
        }
    }

    /// Values and rates along `rate`, from monomials freshly prepared with it.
    #[inline]
    pub(crate) fn values_and_rates(
        &self,
        jets: &mut [Jet],
        rate: &[f64],
        value: &mut [f64],
        first: &mut [f64],
    ) {
        for jet in jets.iter_mut() {
            jet.weight = jet.rate(rate);
        }
        for ((value, first), terms) in value.iter_mut().zip(first).zip(self.rows()) {
            for &(monomial, factor) in terms {
                let Some(jet) = jets.get(monomial) else { return };
                *value += factor * jet.value;
                *first += factor * jet.weight;
            }
        }
    }

    /// `sum over rows of force d row/d q_i`, from freshly prepared monomials.
    #[inline]
    pub(crate) fn pull_back<R: Real>(&self, jets: &mut [Jet<R>], force: &[R], out: &mut [R]) {
        for (force, terms) in force.iter().zip(self.rows()) {
            for &(monomial, factor) in terms {
                if let Some(jet) = jets.get_mut(monomial) {
                    jet.weight += *force * R::of(factor);
                }
            }
        }
        for jet in jets.iter().take(self.monomials.len()) {
            for (&i, g) in jet.factors.iter().zip(&jet.gradient) {
                if let Some(entry) = out.get_mut(i) {
                    *entry += jet.weight * *g;
                }
            }
        }
    }

    /// Rows picked from several polynomials, in that order: (polynomial, row).
    pub(crate) fn gather<'a>(rows: impl Iterator<Item = (&'a PolynomialData, usize)>) -> Self {
        let (mut data, mut n) = (PolynomialData::default(), 0);
        for (to, (from, row)) in rows.enumerate() {
            n = to + 1;
            let of_row = |r: &u32| *r as usize == row;
            data.quadratic
                .extend(from.quadratic.iter().filter(|t| of_row(&t.0)).map(|t| (to as u32, t.1, t.2)));
            data.cubic.extend(from.cubic.iter().filter(|t| of_row(&t.0)).map(|t| (to as u32, t.1, t.2)));
        }
        Polynomial::new(n, &data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_derivatives_are_those_of_the_polynomials() {
        // y_0 = 2 q_0 q_1 + q_0^2, y_1 = 0, y_2 = -q_0^2 q_1 + 3 q_1^3.
        let data = PolynomialData {
            quadratic: vec![(0, [0, 0], 1.0), (0, [0, 1], 2.0)],
            cubic: vec![(2, [0, 0, 1], -1.0), (2, [1, 1, 1], 3.0)],
        };
        let polynomial = Polynomial::new(3, &data);
        let (q, rate) = ([0.5, -0.75], [2.0, 1.25]);
        let [x, y] = q;
        let [dx, dy] = rate;
        let value = [2.0 * x * y + x * x, 0.0, -x * x * y + 3.0 * y * y * y];
        let gradient = [[2.0 * y + 2.0 * x, 2.0 * x], [0.0; 2], [-2.0 * x * y, -x * x + 9.0 * y * y]];
        let second =
            [4.0 * dx * dy + 2.0 * dx * dx, 0.0, -2.0 * y * dx * dx - 4.0 * x * dx * dy + 18.0 * y * dy * dy];
        let mut jets = polynomial.jets();
        polynomial.prepare(&q, &rate, &mut jets);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-14;
        let (mut along, mut first, mut again) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        polynomial.along(&q, &rate, &mut along, &mut first, &mut again);
        for row in 0..3 {
            assert!(close(along[row], value[row]) && close(again[row], second[row]));
            assert!(close(first[row], gradient[row][0] * dx + gradient[row][1] * dy));
            for (k, derivative) in gradient[row].iter().enumerate() {
                let (mut direction, mut out) = ([0.0; 2], [0.0; 3]);
                direction[k] = 1.0;
                polynomial.derivative(&q, &direction, &mut out);
                assert!(close(out[row], *derivative));
            }
        }
        let (mut again, mut rates) = ([0.0; 3], [0.0; 3]);
        polynomial.values_and_rates(&mut jets.clone(), &rate, &mut again, &mut rates);
        assert_eq!((again, rates), (along, first));
        let (force, mut back) = ([0.3, 7.0, -1.1], [0.0; 2]);
        polynomial.pull_back(&mut jets, &force, &mut back);
        for i in 0..2 {
            assert!(close(back[i], (0..3).map(|row| force[row] * gradient[row][i]).sum()));
        }
        let picked = Polynomial::gather([(&data, 2), (&data, 0)].into_iter());
        let mut v = [0.0; 2];
        picked.along(&q, &rate, &mut v, &mut [0.0; 2], &mut [0.0; 2]);
        assert!(close(v[0], value[2]) && close(v[1], value[0]));
    }
}
