//! Newton's method at one load factor, on displacements and section forces, damped by the natural monotonicity test.
//!
//! A step that turns a section by `theta` stretches it by `theta^2/2` if its displacement is taken along the old tangent. The axial
//! stiffness makes a huge force of that, which exists only between iterations but would enter the geometric stiffness of the
//! next one: slender beams then need tens of iterations for what is nearly a quadratic problem. So the section forces `s` at the
//! stiffness points are unknowns of their own while iterating (Magisano, Leonetti & Garcea, *Comput. Methods Appl. Mech. Engrg.* 313
//! (2017): "mixed integration point" strategy):
//!
//! ```text
//! int B(eta)^t s = Qext(eta)            S^{-1} s = eps(eta)
//! (int B^t S B + K_g(s) - K_ext) d eta = Qext - int B^t S eps(eta)        d s = S eps + S B d eta - s
//! ```
//!
//! The right-hand side is the ordinary residual, the size of the system stays, and so does the solution, at which `s = S eps`.
//!
//! A step is judged by displacements and rotations, not by forces: with the tangent of the iterate, a fraction `f` of it is taken
//! when the correction that the same tangent would ask for next is shorter than `(1 - f/4)` of it (Deuflhard, *Newton Methods for
//! Nonlinear Problems*, section 3.3). That test does not change with units or with the scaling of the equations.

use std::sync::Arc;

use nalgebra::{Vector3, Vector6};

use super::balance::{Balance, TooBent};
use crate::assembly::BlockMatrix;
use crate::configuration::Configuration;
use crate::element::internal_force::{Stresses, split};
use crate::math::so3::exp_quaternion;
use crate::solve::block_ldu::{Factor, SingularPivot, Symbolic};

/// Iterations before a load step is given up.
const MAX_ITERATIONS: usize = 25;
/// Shortest fraction of a Newton step that is tried.
const SHORTEST: f64 = 1.0 / 64.0;
/// Largest rotation of a node over one load step, rad. Rotations are only known up to full turns and rolled-up structures have many
/// equilibria; a step of less than a third of a half turn stays on its path.
pub(crate) const MAX_TURN: f64 = 1.0;

/// Why an iteration was given up.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Failure {
    /// No fraction of the Newton step comes closer to balance.
    Stalled,
    /// Too many iterations.
    Slow,
    /// The next equilibrium is more than [`MAX_TURN`] away.
    Far,
    /// An element left the range of its interpolation.
    Bent(TooBent),
    /// The tangent is singular.
    Singular(SingularPivot),
}

/// Displacements and section forces of an iteration.
#[derive(Clone)]
struct Iterate {
    at: Configuration,
    stress: Vec<Stresses>,
}

/// Newton's iteration and its storage.
pub(crate) struct Newton {
    tangent: BlockMatrix,
    factor: Factor,
    size: f64,
    tolerance: f64,
    /// Iterations so far.
    pub(crate) iterations: usize,
    /// Corrections of the last run, relative: what its convergence is judged by.
    pub(crate) corrections: Vec<f64>,
}

impl Newton {
    pub(crate) fn new(balance: &Balance<'_>, tolerance: f64) -> Self {
        let pattern = balance.assembly.pattern.clone();
        Self {
            tangent: BlockMatrix::zeros(pattern.clone()),
            factor: Factor::new(Arc::new(Symbolic::new(pattern))),
            size: balance.size(),
            tolerance,
            iterations: 0,
            corrections: Vec::new(),
        }
    }

    /// Balance at `factor` near `from`.
    pub(crate) fn solve(
        &mut self,
        balance: &Balance<'_>,
        from: &Configuration,
        factor: f64,
    ) -> Result<Configuration, Failure> {
        let mut now = Iterate { at: from.clone(), stress: balance.stresses(from) };
        self.corrections.clear();
        for _ in 0..MAX_ITERATIONS {
            self.iterations += 1;
            balance.mixed_tangent(&now.at, &now.stress, factor, &mut self.tangent);
            self.factor.refactor(&self.tangent).map_err(Failure::Singular)?;
            let step = self.correction(balance, &balance.residual(&now.at, factor).nodal);
            let length = self.length(&step);
            self.corrections.push(length);
            if !length.is_finite() {
                return Err(Failure::Stalled);
            }
            if length <= self.tolerance {
                // Quadratic convergence: this last correction leaves round-off.
                return Ok(moved(balance, &now.at, &step, 1.0));
            }
            now = self.search(balance, &now, &step, length, factor)?;
            if turned(from, &now.at) > MAX_TURN {
                return Err(Failure::Far);
            }
        }
        Err(Failure::Slow)
    }

    /// The longest of the fractions 1, 1/2, 1/4, .. of a step that passes the natural monotonicity test.
    fn search(
        &self,
        balance: &Balance<'_>,
        now: &Iterate,
        step: &[Vector6<f64>],
        length: f64,
        factor: f64,
    ) -> Result<Iterate, Failure> {
        let strained = balance.stresses(&now.at);
        let increments = balance.stress_increments(&now.at, step);
        let mut fraction = 1.0;
        let mut bent = None;
        while fraction >= SHORTEST {
            let at = moved(balance, &now.at, step, fraction);
            bent = balance.too_bent(&at);
            if bent.is_none() {
                let mut stress = now.stress.clone();
                for ((s, strained), increment) in stress.iter_mut().zip(&strained).zip(&increments) {
                    for k in 0..s.len() {
                        s[k] += (strained[k] + increment[k] - s[k]) * fraction;
                    }
                }
                let next = self.length(
                    &self.correction(balance, &balance.mixed_residual(&now.at, &at, &stress, factor)),
                );
                if next <= (1.0 - 0.25 * fraction) * length {
                    return Ok(Iterate { at, stress });
                }
            }
            fraction *= 0.5;
        }
        Err(bent.map_or(Failure::Stalled, Failure::Bent))
    }

    /// Factorises the tangent of a state in which the section forces are those of the strains.
    pub(crate) fn factorise(
        &mut self,
        balance: &Balance<'_>,
        at: &Configuration,
        factor: f64,
    ) -> Result<&Factor, SingularPivot> {
        balance.tangent(at, factor, &mut self.tangent);
        self.factor.refactor(&self.tangent)?;
        Ok(&self.factor)
    }

    /// `-K^{-1} r` over the unknowns.
    fn correction(&self, balance: &Balance<'_>, residual: &[Vector6<f64>]) -> Vec<Vector6<f64>> {
        let mut step = balance.assembly.gather(residual);
        step.iter_mut().for_each(|r| *r = -*r);
        self.factor.solve(&mut step);
        step
    }

    /// Largest displacement over the size of the structure, or largest rotation; not a number if any entry is not.
    pub(crate) fn length(&self, step: &[Vector6<f64>]) -> f64 {
        let mut largest: f64 = 0.0;
        for delta in step {
            let (x, theta) = split(delta);
            let length = (x.norm() / self.size).max(theta.norm());
            // `max` would hide what is not a number.
            if !(x.norm().is_finite() && theta.norm().is_finite()) {
                return f64::NAN;
            }
            largest = largest.max(length);
        }
        largest
    }
}

/// `R + s x`, `Q exp(s theta~)` on every node with unknowns.
pub(crate) fn moved(
    balance: &Balance<'_>,
    at: &Configuration,
    step: &[Vector6<f64>],
    fraction: f64,
) -> Configuration {
    let mut to = at.clone();
    for (node, unknown) in balance.assembly.unknown.iter().enumerate() {
        let Some(row) = *unknown else { continue };
        let (x, theta): (Vector3<f64>, Vector3<f64>) = split(&(step[row] * fraction));
        to.positions[node] += x;
        to.rotations[node] *= exp_quaternion(&theta);
        to.rotations[node].renormalize();
    }
    to
}

/// Largest rotation of a node between two configurations, rad.
fn turned(from: &Configuration, to: &Configuration) -> f64 {
    from.rotations.iter().zip(&to.rotations).map(|(a, b)| a.angle_to(b)).fold(0.0, f64::max)
}
