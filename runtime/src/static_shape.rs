//! Amplitudes in balance with loads while A is held: the shape that a load case can start from.

use alloc::{string::ToString, vec, vec::Vec};

use crate::dense::rows_mut;
use crate::equations::{Motion, Workspace, about_centre, forces};
use crate::error::ModelError;
use crate::integrator::newton::{factorise, substitute};
use crate::loading::Acting;
use crate::loading::sealed::Acts;
use crate::loads::InitialState;
use crate::math::{Mat3, Vec3, Vec6, dot_6, matrix};
use crate::model::Model;
use crate::state::State;

/// Most iterations.
const MAX_ITERATIONS: usize = 200;
/// Last change relative to the size, both as square roots of elastic energies.
const SETTLED: f64 = 1e-13;
/// Largest change that Newton's method makes at once, and smallest size that changes are told relative to, over the range of the model:
/// the polynomials of a manifold mean nothing far beyond it, and a shape may be that of the model itself.
const STRIDE: f64 = 0.5;
const SMALLEST: f64 = 1e-2;
/// Step of central differences over the range: cubic terms leave 1e-10 of them, round-off 1e-11.
const DIFFERENCE: f64 = 1e-5;

impl Model {
    /// Amplitudes in balance with the shape's loads at the attitude and place of a state: of the paper's model
    /// `omega^2 m q + g = Phi_S^t Q_S(q)`, the projection of the static shape of the finite elements on the modes, by inserting `q` on the
    /// right until it stays; of a consistent model all but the accelerations of (B.7), by Newton's method, as forces on a curved manifold
    /// are stiffness too.
    pub(crate) fn static_shape(&self, initial: &InitialState, start: &State) -> Result<Vec<f64>, ModelError> {
        let prepared = self.prepare(&initial.shape_case())?;
        let mut balance = Balance {
            model: self,
            loads: prepared.acting(),
            attitude: matrix(start.attitude),
            position: start.position,
            work: Workspace::new(self),
            u: vec![0.0; self.n_modes() + 6],
        };
        match &self.lagrangian {
            None => balance.settle(0.0, |balance, q| Some(balance.linear_change(q))),
            Some(_) => {
                let data = self.data().lagrangian.as_ref();
                let range = data.map_or(&[][..], |it| &it.range);
                // The modes have the same energy at their range.
                let size = self.elastic.iter().zip(range).map(|(mode, range)| mode.stiffness * range * range);
                let size = size.fold(0.0, f64::max);
                balance.settle(SMALLEST * SMALLEST * size, |balance, q| {
                    let mut change = balance.newton_change(q, range)?;
                    let stride = STRIDE * libm::sqrt(size / self.energy(&change).max(f64::MIN_POSITIVE));
                    if stride < 1.0 {
                        change.iter_mut().for_each(|change| *change *= stride);
                    }
                    Some(change)
                })
            }
        }
    }

    /// Twice the elastic energy of amplitudes, of small motions.
    fn energy(&self, q: &[f64]) -> f64 {
        q.iter().zip(&self.elastic).map(|(q, mode)| mode.stiffness * q * q).sum()
    }
}

/// Forces on a structure at rest.
struct Balance<'a> {
    model: &'a Model,
    loads: &'a Acting,
    attitude: Mat3,
    position: Vec3,
    work: Workspace,
    /// Zero.
    u: Vec<f64>,
}

impl Balance<'_> {
    /// Changes `q` until the change is round-off of its size, or of the smallest energy that counts.
    fn settle(
        &mut self,
        smallest: f64,
        mut change: impl FnMut(&mut Self, &[f64]) -> Option<Vec<f64>>,
    ) -> Result<Vec<f64>, ModelError> {
        let mut q = vec![0.0; self.model.n_modes()];
        let mut relative = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let Some(change) = change(self, &q) else { break };
            q.iter_mut().zip(&change).for_each(|(q, change)| *q += change);
            let size = self.model.energy(&q).max(smallest).max(f64::MIN_POSITIVE);
            relative = libm::sqrt(self.model.energy(&change) / size);
            if relative <= SETTLED {
                return Ok(q);
            }
            if !relative.is_finite() {
                break;
            }
        }
        Err(ModelError::Value {
            what: "last relative change of the initial shape".to_string(),
            index: 0,
            found: relative,
            expected: "below 1e-13: these loads bend or turn the structure so far that it has no balance nearby; take smaller ones",
        })
    }

    /// Finds the forces.
    fn evaluate(&mut self, q: &[f64]) {
        let (attitude, position) = (self.attitude, self.position);
        let here = Motion { t: 0.0, q, u: &self.u, attitude, position, beta: [0.0; 6] };
        forces(self.model, self.loads, &here, &mut self.work);
    }

    /// To the amplitudes that the loads at `q` have for their own.
    fn linear_change(&mut self, q: &[f64]) -> Vec<f64> {
        self.evaluate(q);
        let model = self.model;
        let (phi_r, origin) = match &model.relative {
            Some(relative) => (&relative.phi_r, relative.origin),
            None => (&model.phi_r, [0.0; 3]),
        };
        let rigid: Vec6 = self.work.external.last_chunk::<6>().copied().unwrap_or_default();
        // Held, the structure loses the part of the modes that moves A.
        let rigid = about_centre(origin, &rigid);
        let rows = self.work.external.iter().zip(phi_r).zip(&model.elastic).zip(q);
        rows.map(|(((force, phi), mode), q)| (force - dot_6(phi, &rigid)) / mode.stiffness - q).collect()
    }

    /// Of Newton's method; none where the forces have no inverse.
    fn newton_change(&mut self, q: &[f64], range: &[f64]) -> Option<Vec<f64>> {
        let m = q.len();
        let (mut slopes, mut pivots, mut at) = (vec![0.0; m * m], vec![0; m], q.to_vec());
        for (column, range) in range.iter().enumerate() {
            let step = DIFFERENCE * range;
            for sign in [1.0, -1.0] {
                *at.get_mut(column)? = q.get(column)? + sign * step;
                self.evaluate(&at);
                for (row, force) in rows_mut(&mut slopes, m).zip(&self.work.relative) {
                    *row.get_mut(column)? -= sign * force / (2.0 * step);
                }
            }
            *at.get_mut(column)? = *q.get(column)?;
        }
        self.evaluate(q);
        at.iter_mut().zip(&self.work.relative).for_each(|(at, force)| *at = *force);
        if !factorise(&mut slopes, &mut pivots, m) {
            return None;
        }
        substitute(&slopes, &pivots, m, &mut at);
        Some(at)
    }
}
