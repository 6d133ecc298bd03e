//! Frame A moved, or held, by functions of time in the finite-element methods.

use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};
use rom_runtime::{BaseMotion, PrescribedMotion, Reaction};

use super::motion::FrameMotion;
use crate::element::internal_force::{split, stack};
use crate::math::so3::scalar_first;

/// What moves A, and the rigid body whose inertia is told apart in the reaction.
#[derive(Clone, Debug)]
pub struct Base {
    motion: BaseMotion,
    /// `M_RR` at the equilibrium.
    rigid_mass: Matrix6<f64>,
}

/// Motion of A with its accelerations.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// Position, attitude, velocities.
    pub frame: FrameMotion,
    /// Acceleration of the origin in G, m/s^2.
    pub acceleration: Vector3<f64>,
    /// Angular acceleration in A, rad/s^2.
    pub spin_rate: Vector3<f64>,
}

impl Base {
    /// `rigid_mass` is `M_RR` at the equilibrium.
    pub fn new(motion: BaseMotion, rigid_mass: Matrix6<f64>) -> Self {
        Self { motion, rigid_mass }
    }

    /// The motion at the start of a run at `t` whose frame is at `frame`.
    pub fn at(&self, frame: &FrameMotion, t: f64) -> Moved {
        moved(&self.motion.at(&prescribed(frame), t))
    }

    /// The motion at `t1` of a frame that is at `frame` at `t0`.
    pub fn advance(&self, frame: &FrameMotion, t0: f64, t1: f64) -> Moved {
        moved(&self.motion.advance(&prescribed(frame), t0, t1))
    }

    /// What the body does to the base, from the whole wrench on the base and the resultant of the loads, `(force, moment)` about the
    /// origin of A in A.
    pub fn reaction(&self, total: &Vector6<f64>, loads: &Vector6<f64>, moved: &Moved) -> Reaction {
        let to_a = moved.frame.rotation.inverse();
        let (v, w) = (to_a * moved.frame.velocity, moved.frame.spin);
        let beta_dot = stack(&(to_a * moved.acceleration - w.cross(&v)), &moved.spin_rate);
        let (p, h) = split(&(self.rigid_mass * stack(&v, &w)));
        let rate = self.rigid_mass * beta_dot;
        let inertia = -(rate + stack(&w.cross(&p), &(w.cross(&h) + v.cross(&p))));
        Reaction {
            inertia: inertia.into(),
            loads: (*loads).into(),
            increment: (total - inertia - loads).into(),
        }
    }
}

fn prescribed(frame: &FrameMotion) -> PrescribedMotion {
    PrescribedMotion {
        velocity: stack(&(frame.rotation.inverse() * frame.velocity), &frame.spin).into(),
        rate: [0.0; 6],
        attitude: scalar_first(&frame.rotation),
        position: frame.position.into(),
    }
}

fn moved(motion: &PrescribedMotion) -> Moved {
    let [s, x, y, z] = motion.attitude;
    let rotation = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(s, x, y, z));
    let ((v, w), (v_dot, w_dot)) = (split(&motion.velocity.into()), split(&motion.rate.into()));
    Moved {
        frame: FrameMotion { position: motion.position.into(), rotation, velocity: rotation * v, spin: w },
        acceleration: rotation * (v_dot + w.cross(&v)),
        spin_rate: w_dot,
    }
}
