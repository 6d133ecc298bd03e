//! The steady state of the reduced model itself: amplitudes, and what may change with them, for which the accelerations vanish while A
//! keeps its velocities.
//!
//! Unknown are the amplitudes; where the body turns freely, its velocities too, with the angular rate along the axis asked for fixed, so
//! that a body finds the principal axis near it; factors on loads that may change; a wrench on A where one holds it. Newton with the exact
//! Jacobian; of the solutions of an underdetermined system the one that moves least.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rom_runtime::loads::{InitialState, LoadCase};
use rom_runtime::{Jacobian, LoadFrame, LoadSet, Model, PrescribedMotion, State};

use super::inputs::{factor_column, load_column, names, of_name, unknown, wrench_column};
use super::{LineariseError, Request};

/// Most corrections.
const MAX_CORRECTIONS: usize = 60;
/// Accelerations that count as none, relative to what the loads, the weight and the turn amount to.
const STEADY: f64 = 1e-6;
/// Singular values of the scaled system below which a direction is free.
const FREE: f64 = 1e-11;

/// A steady state.
#[derive(Clone, Debug)]
pub struct Steady {
    /// Amplitudes - (m).
    pub q: Vec<f64>,
    /// True velocity of A in A (of the mean axes in a mean-axes model), m/s, rad/s - (6).
    pub velocity: [f64; 6],
    /// Attitude, unit quaternion, scalar first.
    pub attitude: [f64; 4],
    /// Position of the origin of A in G, m.
    pub position: [f64; 3],
    /// Changes of the factors on loads of the equilibrium.
    pub factors: Vec<(String, f64)>,
    /// Wrench on A, constant in A, that holds it: N, N m.
    pub wrench: Option<[f64; 6]>,
    /// Accelerations that are left, relative to what the loads amount to.
    pub residual: f64,
    /// Corrections made.
    pub corrections: usize,
    /// Whether something moves A, or holds it.
    pub driven: bool,
}

/// The equations at a steady state.
pub(super) struct At {
    pub(super) jacobian: Jacobian,
    /// Everything that acts.
    pub(super) loads: LoadSet,
}

/// What accelerations are measured against.
#[derive(Clone, Debug)]
pub(super) struct Weights {
    /// m/s^2.
    acceleration: f64,
    /// Radius of gyration, m.
    pub(super) length: f64,
    /// Root of the mass.
    root_mass: f64,
    m: usize,
}

impl Weights {
    /// Accelerations `(q_ddot, v_dot, w_dot)` made comparable: m/s^2 over what is there.
    pub(super) fn relative(&self, row: usize) -> f64 {
        let unit = match row.checked_sub(self.m) {
            None => 1.0 / self.root_mass,
            Some(k) if k < 3 => 1.0,
            Some(_) => self.length,
        };
        unit / self.acceleration
    }

    fn largest(&self, accelerations: &[f64], rows: usize) -> f64 {
        let sizes = accelerations.iter().take(rows).enumerate().map(|(i, a)| (a * self.relative(i)).abs());
        // Spelt so that a NaN is the largest.
        sizes.fold(0.0, |largest, x| if x <= largest { largest } else { x })
    }
}

/// An unknown besides the amplitudes.
#[derive(Clone, Debug)]
enum Unknown {
    Velocity(usize),
    Factor(usize),
    Wrench(usize),
}

struct Search<'a> {
    model: &'a Arc<Model>,
    case: LoadCase,
    state: State,
    factors: Vec<(String, f64)>,
    wrench: [f64; 6],
    driven: bool,
    jacobian: Jacobian,
}

/// Finds it, with the Jacobian there and what acts.
pub(super) fn find(model: &Arc<Model>, request: &Request) -> Result<(Steady, At, Weights), LineariseError> {
    let mut search = Search::new(model, request)?;
    let axis = Vector3::from_row_slice(&model.velocity(&search.state)[3..]);
    let mut unknowns: Vec<Unknown> = (0..search.factors.len()).map(Unknown::Factor).collect();
    if request.hold && !search.driven {
        unknowns.extend((0..6).map(Unknown::Wrench));
    } else if axis.norm() > 0.0 && !search.driven {
        unknowns.extend((0..6).map(Unknown::Velocity));
    }
    search.evaluate()?;
    let weights = search.weights()?;
    let (mut residual, mut corrections) = (search.residual(&weights), 0);
    while corrections < MAX_CORRECTIONS && residual > 1e-14 {
        let before = (search.state.clone(), search.factors.clone(), search.wrench);
        let step = search.correction(&weights, &unknowns, &axis)?;
        let mut improved = false;
        for halving in 0..6 {
            search.take(&unknowns, &step, 0.5_f64.powi(halving));
            search.evaluate()?;
            let now = search.residual(&weights);
            if now < residual {
                (residual, improved) = (now, true);
                break;
            }
            (search.state, search.factors, search.wrench) = before.clone();
        }
        if !improved {
            // Round-off, or as near as it gets.
            search.evaluate()?;
            break;
        }
        corrections += 1;
    }
    // Spelt so that a NaN is none.
    let is_steady = residual <= STEADY;
    if !is_steady {
        return Err(search.not_steady(&weights, residual));
    }
    search.stays(&weights)?;
    let steady = Steady {
        q: search.state.q.clone(),
        velocity: model.velocity(&search.state),
        attitude: search.state.attitude,
        position: search.state.position,
        factors: search.factors.clone(),
        wrench: (request.hold && !search.driven).then_some(search.wrench),
        residual,
        corrections,
        driven: search.driven,
    };
    let loads = search.loads()?;
    Ok((steady, At { jacobian: search.jacobian, loads }, weights))
}

impl<'a> Search<'a> {
    fn new(model: &'a Arc<Model>, request: &Request) -> Result<Self, LineariseError> {
        let finite = |what, values: &[f64]| match values.iter().find(|x| !x.is_finite()) {
            Some(&found) => Err(LineariseError::Value { what, found, expected: "finite numbers" }),
            None => Ok(()),
        };
        finite("time", &[request.time])?;
        finite("velocity", request.velocity.as_ref().map_or(&[], |x| x))?;
        finite("rate", request.rate.as_ref().map_or(&[], |x| x))?;
        let known = names(model);
        for name in &request.balance {
            if !known.contains(name) {
                return Err(unknown("load of an equilibrium", name, known.iter().map(String::as_str)));
            }
        }
        let driven = model.is_clamped() || request.case.motion.is_some();
        let mut case = request.case.clone();
        with_velocities(model, &mut case, request);
        let mut state = model.initial_state(&case)?;
        state.time = request.time;
        // Steady is without rates.
        let velocity = model.velocity(&state);
        state.q_dot.fill(0.0);
        state.beta_star = velocity;
        if let Some(motion) = &case.motion {
            let at = motion.at(&model.motion_of(&state), request.time);
            constant(&at, request.time)?;
            state.beta_star = at.velocity;
        }
        if driven {
            // Functions, or the clamp, say how A moves; a rate asked for turns the hub of a clamped structure.
            let asked = [request.velocity, request.rate];
            for (k, part) in asked.into_iter().enumerate() {
                if let Some(part) = part {
                    state.beta_star[3 * k..3 * k + 3].copy_from_slice(&part);
                }
            }
            case.motion = None;
        }
        Ok(Search {
            model,
            case,
            state,
            factors: request.balance.iter().map(|name| (name.clone(), 0.0)).collect(),
            wrench: [0.0; 6],
            driven,
            jacobian: Jacobian::new(Arc::clone(model)),
        })
    }

    /// Everything that acts now.
    fn loads(&self) -> Result<LoadSet, LineariseError> {
        let mut case = self.case.clone();
        for (name, change) in &self.factors {
            let (loads, distributed) = of_name(self.model, name, *change);
            case.loads.extend(loads);
            case.distributed.extend(distributed);
        }
        let mut set = LoadSet::with_case(self.model, &[], &case)?;
        let [fx, fy, fz, mx, my, mz] = self.wrench;
        set.add_wrench(&LoadFrame::Body, [fx, fy, fz], [mx, my, mz]);
        Ok(set)
    }

    fn evaluate(&mut self) -> Result<(), LineariseError> {
        let loads = self.loads()?;
        if self.driven {
            self.jacobian.evaluate_prescribed(&self.state, &loads, &[0.0; 6])?;
        } else {
            self.jacobian.evaluate(&self.state, &loads)?;
        }
        Ok(())
    }

    /// Rows whose accelerations have to vanish.
    fn rows(&self) -> usize {
        self.model.n_modes() + if self.driven { 0 } else { 6 }
    }

    fn residual(&self, weights: &Weights) -> f64 {
        weights.largest(self.jacobian.accelerations(), self.rows())
    }

    /// What the loads, the weight and the turn amount to.
    fn weights(&mut self) -> Result<Weights, LineariseError> {
        let data = self.model.data();
        let (mass, inertia) = (data.rigid.mass, &data.rigid.mass_matrix);
        let length = ((inertia[21] + inertia[28] + inertia[35]) / (2.0 * mass)).sqrt();
        let m = self.model.n_modes();
        let mut weights = Weights { acceleration: 1.0, length, root_mass: mass.sqrt(), m };
        let loads = self.loads()?;
        let column = load_column(&mut self.jacobian, &loads)?;
        let size = |x: &[f64]| Vector3::from_row_slice(x).norm();
        let (v, w) = (size(&self.state.beta_star[..3]), size(&self.state.beta_star[3..]));
        let of_loads = weights.largest(&column.rates[m..], self.rows());
        let all = size(&self.model.gravity()) + w * (v + w * length) + of_loads;
        // Where nothing acts nothing accelerates.
        weights.acceleration = if all > 0.0 { all } else { 1.0 };
        Ok(weights)
    }

    /// Changes of amplitudes and unknowns that cancel the accelerations to first order.
    fn correction(
        &mut self,
        weights: &Weights,
        unknowns: &[Unknown],
        axis: &Vector3<f64>,
    ) -> Result<DVector<f64>, LineariseError> {
        let (m, rows) = (self.model.n_modes(), self.rows());
        let turning = unknowns.iter().any(|unknown| matches!(unknown, Unknown::Velocity(_)));
        let mut columns: Vec<Vec<f64>> = (0..m).map(|k| self.jacobian.column(k).collect()).collect();
        let n = self.jacobian.size();
        let u_dot = self.jacobian.accelerations().to_vec();
        for unknown in unknowns {
            columns.push(match unknown {
                Unknown::Velocity(k) => self.jacobian.column(2 * m + k).collect(),
                Unknown::Factor(k) => {
                    let name = self.factors[*k].0.clone();
                    factor_column(self.model, &mut self.jacobian, &name)?.rates
                }
                Unknown::Wrench(k) => wrench_column(self.model, &mut self.jacobian, *k)?.rates,
            });
        }
        debug_assert!(columns.iter().all(|column| column.len() == n));
        let mut a = DMatrix::zeros(rows + usize::from(turning), columns.len());
        for (j, column) in columns.iter().enumerate() {
            (0..rows).for_each(|i| a[(i, j)] = column[m + i] * weights.relative(i));
            if let Some(Unknown::Velocity(k)) = j.checked_sub(m).and_then(|k| unknowns.get(k))
                && turning
                && *k >= 3
            {
                a[(rows, j)] = axis[k - 3] / axis.norm_squared();
            }
        }
        let mut right = DVector::zeros(a.nrows());
        (0..rows).for_each(|i| right[i] = -u_dot[i] * weights.relative(i));
        if let Some(k) = a.iter().chain(right.iter()).position(|x| !x.is_finite()) {
            let found = a.iter().chain(right.iter()).nth(k).copied().unwrap_or(f64::NAN);
            return Err(LineariseError::Value { what: "an acceleration", found, expected: "finite numbers" });
        }
        let mut scales: Vec<f64> = a.column_iter().map(|column| column.norm()).collect();
        if turning {
            // The velocities are the last six. One that changes nothing but round-off is no way to change anything.
            let first = scales.len() - 6;
            for three in scales[first..].chunks_mut(3) {
                let largest = three.iter().fold(0.0, |largest: f64, x| largest.max(*x));
                three.fill(largest);
            }
        }
        scales.iter_mut().filter(|scale| **scale == 0.0).for_each(|scale| *scale = 1.0);
        for (mut column, scale) in a.column_iter_mut().zip(&scales) {
            column /= *scale;
        }
        let svd = a.svd(true, true);
        let limit = FREE * svd.singular_values.iter().fold(0.0, |s: f64, x| s.max(*x));
        let mut step = svd.solve(&right, limit).unwrap_or_else(|_| DVector::zeros(scales.len()));
        step.iter_mut().zip(&scales).for_each(|(x, scale)| *x /= scale);
        Ok(step)
    }

    fn take(&mut self, unknowns: &[Unknown], step: &DVector<f64>, part: f64) {
        let m = self.model.n_modes();
        self.state.q.iter_mut().zip(step.iter()).for_each(|(q, step)| *q += part * step);
        for (unknown, step) in unknowns.iter().zip(step.iter().skip(m)) {
            let place = match unknown {
                Unknown::Velocity(k) => &mut self.state.beta_star[*k],
                Unknown::Factor(k) => &mut self.factors[*k].1,
                Unknown::Wrench(k) => &mut self.wrench[*k],
            };
            *place += part * step;
        }
    }

    /// The body moves on along its velocity: nothing may change as it does.
    fn stays(&self, weights: &Weights) -> Result<(), LineariseError> {
        let (m, rows) = (self.model.n_modes(), self.rows());
        let velocity = self.model.velocity(&self.state);
        let [s, x, y, z] = self.state.attitude;
        let turn = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(s, x, y, z));
        let c: Matrix3<f64> = turn.to_rotation_matrix().into_inner();
        let (v, w) = (Vector3::from_row_slice(&velocity[..3]), Vector3::from_row_slice(&velocity[3..]));
        let mut change = vec![0.0; rows];
        for (k, rate) in w.iter().chain((c * v).iter()).enumerate() {
            let column = self.jacobian.column(2 * m + 6 + k).skip(m);
            change.iter_mut().zip(column).for_each(|(sum, slope)| *sum += rate * slope);
        }
        let found = weights.largest(&change, rows);
        let pace = w.norm() + v.norm() / weights.length;
        if found > STEADY * pace {
            return Err(LineariseError::Passing { found: found * weights.acceleration });
        }
        Ok(())
    }

    fn not_steady(&self, weights: &Weights, relative: f64) -> LineariseError {
        let (m, rows) = (self.model.n_modes(), self.rows());
        let found = self.jacobian.accelerations();
        let size = |i: &usize| (found[*i] * weights.relative(*i)).abs();
        let mut left = Vec::new();
        if rows > m {
            let three = |k: usize| vector(&found[m + k..m + k + 3]);
            left.push(format!("frame A accelerates by {} m/s^2 and {} rad/s^2", three(0), three(3)));
        }
        if let Some(worst) = (0..m).max_by(|i, j| size(i).total_cmp(&size(j))) {
            let number = self.model.data().modes.number[worst];
            left.push(format!("elastic mode {number} by {:.3e} 1/s^2", found[worst]));
        }
        LineariseError::NotSteady { left: left.join(", "), relative }
    }
}

/// Components for people.
fn vector(values: &[f64]) -> String {
    let parts: Vec<String> = values.iter().map(|x| format!("{x:.3e}")).collect();
    format!("({})", parts.join(", "))
}

/// The velocities asked for as those the case starts with.
fn with_velocities(model: &Model, case: &mut LoadCase, request: &Request) {
    if request.velocity.is_none() && request.rate.is_none() || model.is_clamped() {
        return;
    }
    let initial = case.initial.get_or_insert_with(InitialState::default);
    if initial.inertial {
        let [s, x, y, z] = initial.attitude.unwrap_or(model.initial_attitude());
        let turn = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(s, x, y, z));
        let in_a = |v: [f64; 3]| -> [f64; 3] { turn.inverse_transform_vector(&Vector3::from(v)).into() };
        initial.velocity = initial.velocity.map(in_a);
        initial.angular_velocity = initial.angular_velocity.map(in_a);
        initial.inertial = false;
    }
    initial.velocity = request.velocity.or(initial.velocity);
    initial.angular_velocity = request.rate.or(initial.angular_velocity);
}

/// Refuses a motion of A that is accelerated.
fn constant(at: &PrescribedMotion, time: f64) -> Result<(), LineariseError> {
    let size = |x: &[f64]| Vector3::from_row_slice(x).norm();
    let (found, turning) = (size(&at.rate[..3]), size(&at.rate[3..]));
    if found > 0.0 || turning > 0.0 {
        return Err(LineariseError::Accelerated { found, turning, time });
    }
    Ok(())
}
