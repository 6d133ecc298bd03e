//! Shape functions and Gauss points of 2- and 3-node elements on the arc length.

/// Shape functions and their derivatives in arc length at one point of an element with `N` nodes.
#[derive(Clone, Copy, Debug)]
pub struct Shape<const N: usize> {
    /// `N_a`, 1 - (N).
    pub n: [f64; N],
    /// `N_a'`, 1/m - (N).
    pub dn: [f64; N],
    /// Position along the element, 0 at its start and 1 at its end.
    pub x: f64,
}

impl<const N: usize> Shape<N> {
    /// At `x` in 0..1 of an element of arc length `length` (m). Nodes are equally spaced.
    pub fn at(x: f64, length: f64) -> Self {
        let (mut n, mut dn) = ([0.0; N], [0.0; N]);
        match N {
            2 => {
                n.copy_from_slice(&[1.0 - x, x]);
                dn.copy_from_slice(&[-1.0 / length, 1.0 / length]);
            }
            3 => {
                n.copy_from_slice(&[(1.0 - x) * (1.0 - 2.0 * x), 4.0 * x * (1.0 - x), x * (2.0 * x - 1.0)]);
                let d = [4.0 * x - 3.0, 4.0 - 8.0 * x, 4.0 * x - 1.0];
                dn.copy_from_slice(&d.map(|d| d / length));
            }
            _ => unreachable!("elements have 2 or 3 nodes"),
        }
        Self { n, dn, x }
    }
}

/// Abscissas in 0..1 and weights (sum 1) of the Gauss rule with 1, 2 or 3 points.
pub fn gauss(points: usize) -> &'static [(f64, f64)] {
    // 1/2 -+ 1/(2 sqrt 3), 1/2 -+ sqrt(3/5)/2.
    const ONE: [(f64, f64); 1] = [(0.5, 1.0)];
    const TWO: [(f64, f64); 2] = [(0.211_324_865_405_187_13, 0.5), (0.788_675_134_594_812_9, 0.5)];
    const THREE: [(f64, f64); 3] =
        [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
    match points {
        1 => &ONE,
        2 => &TWO,
        3 => &THREE,
        _ => unreachable!("rules with 1 to 3 points are used"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_polynomials_of_degree_2n_minus_1() {
        for points in 1..=3 {
            for degree in 0..2 * points {
                let sum: f64 = gauss(points).iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!((sum - 1.0 / (degree as f64 + 1.0)).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn shapes_reproduce_their_polynomials() {
        for x in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let s = Shape::<2>::at(x, 4.0);
            assert!((s.n[1] - x).abs() < 1e-15 && (s.dn[0] + s.dn[1]).abs() < 1e-15);
            let q = Shape::<3>::at(x, 4.0);
            let value = 0.25 * q.n[1] + q.n[2];
            let slope = (0.25 * q.dn[1] + q.dn[2]) * 4.0;
            assert!((value - x * x).abs() < 1e-15 && (slope - 2.0 * x).abs() < 1e-14);
        }
    }
}
