//! Sparse polynomials of second and third order in the modal amplitudes (docs/beyond.md): what bends shapes and kinetic
//! coordinates off the plane of the modes. For outputs: without scratch. What a step needs is in `curve.rs` and `lagrangian/`.

use alloc::vec::Vec;

use crate::data::PolynomialData;

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
struct Jet {
    factors: [usize; 3],
    value: f64,
    gradient: [f64; 3],
    second: f64,
}

impl Monomial {
    #[inline]
    fn jet(&self, q: &[f64], rate: &[f64]) -> Jet {
        let at = |values: &[f64], index: usize| values.get(index).copied().unwrap_or(0.0);
        let (x, y) = (at(q, self.i), at(q, self.j));
        let (dx, dy) = (at(rate, self.i), at(rate, self.j));
        match self.third {
            None => Jet {
                factors: [self.i, self.j, self.i],
                value: x * y,
                gradient: [y, x, 0.0],
                second: 2.0 * dx * dy,
            },
            Some(k) => {
                let (z, dz) = (at(q, k), at(rate, k));
                Jet {
                    factors: [self.i, self.j, k],
                    value: x * y * z,
                    gradient: [y * z, x * z, x * y],
                    second: 2.0 * (dx * dy * z + dx * y * dz + x * dy * dz),
                }
            }
        }
    }
}

impl Jet {
    #[inline]
    fn rate(&self, rate: &[f64]) -> f64 {
        self.factors.iter().zip(&self.gradient).map(|(&i, g)| g * rate.get(i).copied().unwrap_or(0.0)).sum()
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

    /// Terms of each row in turn.
    #[inline]
    fn rows(&self) -> impl Iterator<Item = &[(usize, f64)]> {
        let starts = core::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| self.terms.get(start..end).unwrap_or(&[]))
    }

    /// Values, rates and second derivatives along the rates, from the amplitudes: without scratch, for outputs.
    pub(crate) fn along(
        &self,
        q: &[f64],
        rate: &[f64],
        value: &mut [f64],
        first: &mut [f64],
        second: &mut [f64],
    ) {
        for (((value, first), second), terms) in value.iter_mut().zip(first).zip(second).zip(self.rows()) {
            for &(monomial, factor) in terms {
                let Some(monomial) = self.monomials.get(monomial) else { return };
                let jet = monomial.jet(q, rate);
                *value += factor * jet.value;
                *first += factor * jet.rate(rate);
                *second += factor * jet.second;
            }
        }
    }

    /// Values alone.
    pub(crate) fn values(&self, q: &[f64], value: &mut [f64]) {
        for (value, terms) in value.iter_mut().zip(self.rows()) {
            for &(monomial, factor) in terms {
                let Some(monomial) = self.monomials.get(monomial) else { return };
                *value += factor * monomial.jet(q, q).value;
            }
        }
    }

    /// Derivative along `direction`, row by row.
    pub(crate) fn derivative(&self, q: &[f64], direction: &[f64], out: &mut [f64]) {
        for (out, terms) in out.iter_mut().zip(self.rows()) {
            for &(monomial, factor) in terms {
                let Some(monomial) = self.monomials.get(monomial) else { return };
                *out += factor * monomial.jet(q, direction).rate(direction);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

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
    }
}
