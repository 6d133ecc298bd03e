//! Anderson acceleration of a fixed-point iteration (Walker & Ni 2011).
//!
//! The iteration matrix of the floating-frame methods leaves out gyroscopic and load stiffness, which slow a few soft modes
//! or make them diverge. Combining the last corrections so that their residual is smallest takes these out, like a
//! Krylov method would, without forming the missing matrices.

use nalgebra::{DMatrix, DVector};

/// Corrections remembered.
const DEPTH: usize = 6;

/// History of one iteration `x <- x + f(x)`.
#[derive(Clone, Debug, Default)]
pub struct Anderson {
    last: Option<(DVector<f64>, DVector<f64>)>,
    /// Differences of successive iterates and of their residuals.
    dx: Vec<DVector<f64>>,
    df: Vec<DVector<f64>>,
}

impl Anderson {
    /// Forgets everything.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// The step to take from `x`, where the plain iteration would add `f`.
    pub fn step(&mut self, x: DVector<f64>, f: DVector<f64>) -> DVector<f64> {
        if let Some((x0, f0)) = self.last.take() {
            if self.dx.len() == DEPTH {
                self.dx.remove(0);
                self.df.remove(0);
            }
            self.dx.push(&x - x0);
            self.df.push(&f - f0);
        }
        let step = self.weights(&f).map_or_else(
            || f.clone(),
            |weights| {
                let mut step = f.clone();
                for ((dx, df), w) in self.dx.iter().zip(&self.df).zip(weights.iter()) {
                    step -= (dx + df) * *w;
                }
                step
            },
        );
        self.last = Some((x, f));
        step
    }

    /// `min |f - dF w|`, by the normal equations of the normalised columns with a small ridge: the columns become parallel
    /// as the iteration converges, and then the ridge only costs what acceleration no longer gives.
    fn weights(&self, f: &DVector<f64>) -> Option<DVector<f64>> {
        let m = self.df.len();
        let norms: Vec<f64> = self.df.iter().map(|c| c.norm()).collect();
        if m == 0 || norms.contains(&0.0) {
            return None;
        }
        let gram = DMatrix::from_fn(m, m, |i, j| {
            let ridge = if i == j { 1e-12 } else { 0.0 };
            self.df[i].dot(&self.df[j]) / (norms[i] * norms[j]) + ridge
        });
        let right = DVector::from_fn(m, |i, _| self.df[i].dot(f) / norms[i]);
        let scaled = gram.cholesky()?.solve(&right);
        Some(DVector::from_fn(m, |i, _| scaled[i] / norms[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear iteration with two diverging directions: plain substitution blows up, the accelerated one ends in a few
    /// steps.
    #[test]
    fn converges_where_substitution_diverges() {
        let n = 30;
        let rates = DVector::from_fn(n, |i, _| match i {
            0 => 1.5,
            1 => -2.0,
            _ => 0.02 / (i as f64),
        });
        let target = DVector::from_fn(n, |i, _| (i as f64).sin());
        let mut x = DVector::zeros(n);
        let mut anderson = Anderson::default();
        for _ in 0..12 {
            let f = (&x - &target).component_mul(&rates) + &target - &x;
            x += anderson.step(x.clone(), f);
        }
        assert!((x - target).amax() < 1e-10);
    }
}
