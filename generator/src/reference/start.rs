//! Where a run begins.

use std::sync::Arc;

use nalgebra::{Quaternion, UnitQuaternion, Vector3, Vector6};
use rom_runtime::expression::Variables;
use rom_runtime::loads::{InitialState, LoadCase};

use super::applied::Displaced;
use super::external::ExternalLoads;
use super::floating::Rows;
use super::method::{Method, Prepared};
use super::motion::{FrameMotion, Motion};
use crate::configuration::Configuration;
use crate::element::internal_force::{split, stack};
use crate::equilibrium::{EquilibriumSettings, WhenUnstable, solve};
use crate::math::so3::{MatrixFunction, log_quaternion};
use crate::reduce::modes::elastic_modes;
use crate::solve::block_ldu::{Factor, Symbolic};

/// Most iterations for a static shape of the linear method.
const MAX_ITERATIONS: usize = 200;
/// Last change of that shape relative to its size.
const SETTLED: f64 = 1e-13;

/// Motion of frame A and of the structure in it at t = 0.
#[derive(Clone, Debug)]
pub struct Start {
    /// Frame A.
    pub frame: FrameMotion,
    /// Displacements `(R, theta)` from the equilibrium - (block rows).
    pub x: Vec<Vector6<f64>>,
    /// Their rates - (block rows).
    pub x_dot: Vec<Vector6<f64>>,
}

impl Start {
    /// At rest in the equilibrium, the reference node where the drawing has it.
    pub fn at_rest(prepared: &Prepared) -> Self {
        let zero = vec![Vector6::zeros(); prepared.assembly.n_blocks()];
        let rotation =
            prepared.equilibrium.as_ref().map_or(UnitQuaternion::identity(), |found| found.attitude);
        let frame = FrameMotion {
            position: prepared.mesh.reference_position,
            rotation,
            velocity: Vector3::zeros(),
            spin: Vector3::zeros(),
        };
        Self { frame, x: zero.clone(), x_dot: zero }
    }

    /// As a load case says. The shape under static loads is that of the method: linear, or of the nonlinear structure.
    ///
    /// # Errors
    /// Loads that the structure cannot carry, modes that it does not have, in words.
    pub fn of_case(prepared: &Prepared, case: &LoadCase, method: Method) -> Result<Self, String> {
        let mut start = Self::at_rest(prepared);
        let rest = InitialState::default();
        let initial = case.initial.as_ref().unwrap_or(&rest);
        if let Some([s, x, y, z]) = initial.attitude {
            start.frame.rotation = UnitQuaternion::new_normalize(Quaternion::new(s, x, y, z));
        }
        if let Some(position) = initial.position {
            start.frame.position = position.into();
        }
        let rotation = start.frame.rotation;
        let velocity = Vector3::from(initial.velocity.unwrap_or_default());
        let spin = Vector3::from(initial.angular_velocity.unwrap_or_default());
        let (to_g, to_a) = (
            if initial.inertial { UnitQuaternion::identity() } else { rotation },
            if initial.inertial { rotation.inverse() } else { UnitQuaternion::identity() },
        );
        (start.frame.velocity, start.frame.spin) = (to_g * velocity, to_a * spin);
        if !initial.shape.is_empty() || !initial.shape_distributed.is_empty() {
            // Together with the loads of the equilibrium.
            let case = prepared.with_trim(&initial.shape_case());
            start.x = match method {
                Method::Linear => linear_shape(prepared, &case, &start.frame)?,
                _ => nonlinear_shape(prepared, &case, rotation)?,
            };
        }
        start.add_modes(prepared, initial)?;
        if let Some(base) = prepared.base(case) {
            start.frame = base.at(&start.frame, 0.0).frame;
        }
        Ok(start)
    }

    /// Adds `Phi_S q` and `Phi_S qdot`.
    fn add_modes(&mut self, prepared: &Prepared, initial: &InitialState) -> Result<(), String> {
        let last = |values: &[f64]| values.iter().rposition(|v| *v != 0.0).map_or(0, |last| last + 1);
        let count = last(&initial.amplitudes).max(last(&initial.rates));
        if count == 0 {
            return Ok(());
        }
        let Prepared { assembly, at, mass, stiffness, .. } = prepared;
        let modes = elastic_modes(assembly, at, mass, stiffness, count)
            .map_err(|e| format!("initial amplitudes: {e}"))?;
        for (node, unknown) in assembly.unknown.iter().enumerate() {
            let Some(i) = unknown else { continue };
            for (values, x) in [(&initial.amplitudes, &mut self.x[*i]), (&initial.rates, &mut self.x_dot[*i])]
            {
                *x += modes.at_node(node).iter().zip(values).map(|(phi, q)| phi * *q).sum::<Vector6<f64>>();
            }
        }
        Ok(())
    }

    /// The same as the absolute motion of all nodes.
    pub fn motion(&self, prepared: &Prepared) -> Motion {
        let at = prepared.displaced(&self.x);
        let FrameMotion { position, rotation, velocity, spin } = self.frame;
        let mut out = Motion::at_rest(&prepared.mesh, &at);
        for node in 0..at.positions.len() {
            let (r, q) = (at.positions[node], at.rotations[node]);
            let (mut r_dot, mut relative) = (Vector3::zeros(), Vector3::zeros());
            if let Some(i) = prepared.assembly.unknown[node] {
                let (rate, theta_dot) = split(&self.x_dot[i]);
                r_dot = rate;
                relative = MatrixFunction::tangential(&split(&self.x[i]).1).matrix() * theta_dot;
            }
            out.position[node] = position + rotation * r;
            out.rotation[node] = rotation * q;
            out.velocity[node] = velocity + rotation * (r_dot + spin.cross(&r));
            out.spin[node] = relative + q.inverse() * spin;
        }
        out
    }
}

/// `Kstif x + Qstif(eta0) = Qext(eta0 + x)`, by iteration on the loads.
fn linear_shape(
    prepared: &Prepared,
    case: &LoadCase,
    frame: &FrameMotion,
) -> Result<Vec<Vector6<f64>>, String> {
    let n = prepared.assembly.n_blocks();
    let mut factor = Factor::new(Arc::new(Symbolic::new(prepared.stiffness.pattern.clone())));
    factor.refactor(&prepared.stiffness).map_err(|e| format!("initial shape: {e}"))?;
    let external = ExternalLoads::new(&prepared.mesh, case);
    let variables = Variables { r_g: frame.position.into(), ..Variables::default() };
    let to_g = frame.rotation.to_rotation_matrix().into_inner();
    let mut x = vec![Vector6::zeros(); n];
    for _ in 0..MAX_ITERATIONS {
        let mut rows = Rows { s: prepared.elastic_force.clone(), r: Vector6::zeros() };
        Displaced { prepared, x: &x, frame: to_g }.subtract(&external, variables, &mut rows);
        factor.solve(&mut rows.s);
        let next: Vec<Vector6<f64>> = rows.s.iter().map(|x| -x).collect();
        let size = next.iter().map(|x| x.amax()).fold(0.0, f64::max);
        let change = next.iter().zip(&x).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
        x = next;
        if change <= SETTLED * size {
            return Ok(x);
        }
    }
    Err("initial shape: these loads turn with the structure so far that it has no balance nearby; take smaller ones"
        .into())
}

/// The nonlinear equilibrium with the reference node held.
fn nonlinear_shape(
    prepared: &Prepared,
    case: &LoadCase,
    attitude: UnitQuaternion<f64>,
) -> Result<Vec<Vector6<f64>>, String> {
    let settings = EquilibriumSettings {
        attitude,
        when_unstable: WhenUnstable::Accept,
        ..EquilibriumSettings::default()
    };
    let found = solve(&prepared.mesh, case, &settings).map_err(|e| format!("initial shape: {e}"))?;
    Ok(displacements(prepared, &found.configuration))
}

/// Displacements `(R, theta)` of a configuration from the equilibrium - (block rows).
fn displacements(prepared: &Prepared, to: &Configuration) -> Vec<Vector6<f64>> {
    let from = &prepared.at;
    let nodal: Vec<Vector6<f64>> = (0..to.positions.len())
        .map(|node| {
            let turn = from.rotations[node].inverse() * to.rotations[node];
            let theta = log_quaternion(&turn);
            stack(&(to.positions[node] - from.positions[node]), &theta)
        })
        .collect();
    prepared.assembly.gather(&nodal)
}
