//! Polynomials in the modal amplitudes from their values along straight lines: polarisation.
//!
//! A form of second or third order is known from its values along the modes, their sums and differences in pairs, and their sums in
//! threes. So one series in one variable per line is all that has to be expanded.

/// Which products of amplitudes are kept, and the lines that tell their coefficients.
#[derive(Clone, Debug)]
pub(super) struct Monomials {
    modes: usize,
    /// Modes with terms of third order: the first so many.
    cubic: usize,
    /// Factors of every monomial, ascending: linear, then quadratic, then cubic ones.
    pub(super) factors: Vec<Vec<usize>>,
    /// Directions of the lines: (mode, factor).
    pub(super) lines: Vec<Vec<(usize, f64)>>,
}

impl Monomials {
    /// All products of two of `modes` amplitudes and of three of the first `cubic`.
    pub(super) fn new(modes: usize, cubic: usize) -> Self {
        let cubic = cubic.min(modes);
        let mut factors: Vec<Vec<usize>> = (0..modes).map(|i| vec![i]).collect();
        factors.extend((0..modes).flat_map(|i| (i..modes).map(move |j| vec![i, j])));
        for i in 0..cubic {
            for j in i..cubic {
                factors.extend((j..cubic).map(|k| vec![i, j, k]));
            }
        }
        let mut lines: Vec<Vec<(usize, f64)>> = (0..modes).map(|i| vec![(i, 1.0)]).collect();
        for i in 0..modes {
            lines.extend((i + 1..modes).map(|j| vec![(i, 1.0), (j, 1.0)]));
        }
        for i in 0..cubic {
            lines.extend((i + 1..cubic).map(|j| vec![(i, 1.0), (j, -1.0)]));
        }
        for i in 0..cubic {
            for j in i + 1..cubic {
                lines.extend((j + 1..cubic).map(|k| vec![(i, 1.0), (j, 1.0), (k, 1.0)]));
            }
        }
        Self { modes, cubic, factors, lines }
    }

    pub(super) fn len(&self) -> usize {
        self.factors.len()
    }

    /// Indices of the monomials of one order.
    pub(super) fn of_order(&self, order: usize) -> std::ops::Range<usize> {
        let quadratic = self.modes * (self.modes + 1) / 2;
        match order {
            1 => 0..self.modes,
            2 => self.modes..self.modes + quadratic,
            _ => self.modes + quadratic..self.len(),
        }
    }

    pub(super) fn index(&self, mut factors: impl AsMut<[usize]>) -> usize {
        let factors = factors.as_mut();
        factors.sort_unstable();
        let range = self.of_order(factors.len());
        let found = self.factors[range.clone()].binary_search_by(|known| known.as_slice().cmp(factors));
        range.start + found.expect("monomials hold all products of their modes")
    }

    /// Values of the monomials of one order along a line: (index, value), zeros left out.
    pub(super) fn along(&self, line: &[(usize, f64)], order: usize) -> Vec<(usize, f64)> {
        let mut out = Vec::new();
        for (a, &(i, x)) in line.iter().enumerate() {
            if order == 1 {
                out.push((i, x));
                continue;
            }
            for (b, &(j, y)) in line.iter().enumerate().skip(a) {
                if order == 2 {
                    out.push((self.index([i, j]), x * y));
                } else if i.max(j) < self.cubic {
                    let third = line[b..].iter().filter(|(k, _)| *k < self.cubic);
                    out.extend(third.map(|&(k, z)| (self.index([i, j, k]), x * y * z)));
                }
            }
        }
        out
    }

    /// Coefficients of a form of an order from its values along the lines: `values` and `coefficients` have `width` numbers per line
    /// and per monomial.
    pub(super) fn polarise(&self, order: usize, width: usize, values: &[f64], coefficients: &mut [f64]) {
        let (m, c) = (self.modes, self.cubic);
        let plus = |i: usize, j: usize| m + i * m - i * (i + 1) / 2 + j - i - 1;
        let minus = |i: usize, j: usize| m + m * (m - 1) / 2 + i * c - i * (i + 1) / 2 + j - i - 1;
        let value = |line: usize, at: usize| values[line * width + at];
        let triples = m + m * (m - 1) / 2 + c * c.saturating_sub(1) / 2;
        for at in 0..width {
            let mut set = |factors: Vec<usize>, x: f64| coefficients[self.index(factors) * width + at] = x;
            if order == 1 {
                (0..m).for_each(|i| set(vec![i], value(i, at)));
                continue;
            }
            if order == 2 {
                for i in 0..m {
                    set(vec![i, i], value(i, at));
                    for j in i + 1..m {
                        set(vec![i, j], value(plus(i, j), at) - value(i, at) - value(j, at));
                    }
                }
                continue;
            }
            // c_ijj and c_iij of i < j.
            let mixed = |i: usize, j: usize| {
                let (sum, difference) = (value(plus(i, j), at), value(minus(i, j), at));
                (0.5 * (sum + difference) - value(i, at), 0.5 * (sum - difference) - value(j, at))
            };
            let mut triple = triples;
            for i in 0..c {
                set(vec![i, i, i], value(i, at));
                for j in i + 1..c {
                    let (ijj, iij) = mixed(i, j);
                    set(vec![i, j, j], ijj);
                    set(vec![i, i, j], iij);
                    for k in j + 1..c {
                        let pairs = [mixed(i, j), mixed(i, k), mixed(j, k)];
                        let known: f64 = pairs.iter().map(|(a, b)| a + b).sum();
                        let cubes = value(i, at) + value(j, at) + value(k, at);
                        set(vec![i, j, k], value(triple, at) - known - cubes);
                        triple += 1;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::tests::Random;

    #[test]
    fn polarisation_finds_the_coefficients_of_random_forms() {
        let mut random = Random::new(11);
        for (modes, cubic) in [(1, 1), (2, 2), (4, 3), (5, 5), (4, 0)] {
            let monomials = Monomials::new(modes, cubic);
            for order in 1..=3 {
                let width = 2;
                let mut expected = vec![0.0; monomials.len() * width];
                for index in monomials.of_order(order) {
                    (0..width).for_each(|k| expected[index * width + k] = random.next());
                }
                let mut values = vec![0.0; monomials.lines.len() * width];
                for (line, values) in monomials.lines.iter().zip(values.chunks_exact_mut(width)) {
                    for (index, x) in monomials.along(line, order) {
                        (0..width).for_each(|k| values[k] += x * expected[index * width + k]);
                    }
                }
                let mut found = vec![0.0; monomials.len() * width];
                if !monomials.of_order(order).is_empty() {
                    monomials.polarise(order, width, &values, &mut found);
                }
                for (a, b) in found.iter().zip(&expected) {
                    assert!((a - b).abs() < 1e-14, "{modes} {cubic} {order}: {a} instead of {b}");
                }
            }
        }
    }
}
