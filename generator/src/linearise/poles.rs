//! Eigenvalues of the linear model.

use nalgebra::DMatrix;

use crate::solve::dense::{DenseError, general_eigen, symmetric_eigen};

/// Singular values of the balanced matrix that are zero, relative to the largest.
const ZERO: f64 = 1e-9;

/// An eigenvalue of `A`; of a pair the one with a positive imaginary part, and its mirror image after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pole {
    /// Real part: growth, 1/s.
    pub re: f64,
    /// Imaginary part, rad/s.
    pub im: f64,
}

impl Pole {
    /// Circular frequency, its distance from the origin, rad/s.
    pub fn omega(&self) -> f64 {
        self.re.hypot(self.im)
    }

    /// Damping ratio; negative where it grows, none for a pole at the origin.
    pub fn damping(&self) -> Option<f64> {
        (self.omega() > 0.0).then(|| -self.re / self.omega())
    }

    /// By frequency, upper half first.
    pub(super) fn order(&self, other: &Self) -> std::cmp::Ordering {
        // Both of a pair have the same distance but for round-off.
        let size = |pole: &Self| (pole.omega() * 1e12).round() / 1e12;
        size(self).total_cmp(&size(other)).then(other.im.total_cmp(&self.im))
    }
}

/// Eigenvalues in ascending order of frequency.
///
/// Those at the origin come in chains (a tilt accelerates sideways), which an iteration smears over a circle of the cube root of
/// round-off. They are taken out first, kernel by kernel: with an orthonormal basis `(N, P)`, `A N = 0`, the others are those of `P^t A P`.
pub(super) fn poles(a: &DMatrix<f64>) -> Result<Vec<Pole>, DenseError> {
    let mut a = balanced(a);
    let mut poles = Vec::new();
    while a.nrows() > 0 && a.iter().all(|x| x.is_finite()) {
        let gram = symmetric_eigen(&a.tr_mul(&a))?;
        let Some(rest) = complement_of_kernel(&a, &gram) else { break };
        poles.extend((rest.ncols()..a.nrows()).map(|_| Pole { re: 0.0, im: 0.0 }));
        a = rest.tr_mul(&(&a * &rest));
    }
    let (values, _) = general_eigen(&a)?;
    poles.extend(values.iter().map(|x| Pole { re: x.re, im: x.im }));
    poles.sort_by(Pole::order);
    Ok(poles)
}

/// What is orthogonal to the kernel of a matrix, or none where it has no kernel: its singular vectors are looked at again one by one, as
/// those of `A^t A` are known to half the digits only.
fn complement_of_kernel(a: &DMatrix<f64>, gram: &(Vec<f64>, DMatrix<f64>)) -> Option<DMatrix<f64>> {
    let (values, vectors) = gram;
    let largest = values.last().copied().unwrap_or(0.0).sqrt();
    if largest == 0.0 {
        return Some(DMatrix::zeros(a.nrows(), 0));
    }
    let kernel = (0..values.len()).filter(|&k| (a * vectors.column(k)).norm() <= ZERO * largest).count();
    (kernel > 0).then(|| vectors.columns(kernel, values.len() - kernel).into_owned())
}

/// A similar matrix whose rows and columns have about the same size (Osborne's balancing by powers of two, without round-off): amplitudes
/// and rates of fast modes differ by their frequency.
fn balanced(a: &DMatrix<f64>) -> DMatrix<f64> {
    let (mut a, n) = (a.clone(), a.nrows());
    for _ in 0..100 {
        let mut changed = false;
        for i in 0..n {
            let off = |k: usize, x: f64| if k == i { 0.0 } else { x.abs() };
            let column: f64 = (0..n).map(|k| off(k, a[(k, i)])).sum();
            let row: f64 = (0..n).map(|k| off(k, a[(i, k)])).sum();
            if column == 0.0 || row == 0.0 {
                continue;
            }
            let factor = (0.5 * (row / column).log2()).round().exp2();
            if factor != 1.0 {
                a.column_mut(i).scale_mut(factor);
                a.row_mut(i).scale_mut(1.0 / factor);
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of four zeros (position, velocity, tilt, rate) beside an oscillator, in a basis that mixes them.
    #[test]
    fn chains_of_zeros_do_not_smear() {
        let mut a = DMatrix::zeros(7, 7);
        (a[(0, 1)], a[(1, 2)], a[(2, 3)]) = (1.0, 9.81, 1.0);
        (a[(4, 5)], a[(5, 4)], a[(5, 5)], a[(6, 6)]) = (1.0, -400.0, -0.8, -3.0);
        let basis = DMatrix::from_fn(7, 7, |i, j| if i == j { 2.0 } else { ((3 * i + 5 * j) as f64).sin() });
        let mixed = &basis * a * basis.clone().try_inverse().unwrap();
        let found = poles(&mixed).unwrap();
        assert_eq!(found.iter().filter(|pole| pole.omega() == 0.0).count(), 4, "{found:?}");
        assert!((found[4].re + 3.0).abs() < 1e-8, "{found:?}");
        // Round-off of a norm of 400, times the condition of the basis squared: it mixes with angles of some degrees.
        assert!((found[5].omega() - 20.0).abs() < 1e-8 && (found[5].damping().unwrap() - 0.02).abs() < 1e-9);
        assert!(found[5].im > 0.0 && found[6].im < 0.0);
        assert!(poles(&DMatrix::zeros(3, 3)).unwrap().iter().all(|pole| pole.omega() == 0.0));
        assert!(poles(&DMatrix::zeros(0, 0)).unwrap().is_empty());
        assert!(poles(&DMatrix::from_element(2, 2, f64::NAN)).is_err());
    }
}
