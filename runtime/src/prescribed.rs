//! Frame A moved by the host instead of by the equations of motion.
//!
//! With the true velocity `beta(t)` given, `beta* = beta - Phi_R q_dot` is no unknown any more, and a virtual displacement
//! of the modes leaves A where it is: the elastic rows lose `Phi_R^t` times the rigid ones, whose residual is the wrench
//! that holds A on its course,
//!
//! ```text
//! (m + Phi_R^t M_RR Phi_R) q_ddot + 2 zeta omega m q_dot + omega^2 m q + N - Q = Phi_R^t (M_RR beta_dot + N_R - Q_R)
//! reaction = M_RR (beta_dot - Phi_R q_ddot) + N_R - Q_R
//! ```
//!
//! The modal mass becomes that of the shapes relative to A, a matrix of rank six more than the diagonal.
//!
//! The modes of a clamped structure have `Phi_R = 0` and momenta `L = M_RS Phi_S` instead:
//!
//! ```text
//! m q_ddot + 2 zeta omega m q_dot + omega^2 m q + N - Q = -L^t beta_dot
//! reaction = M_RR beta_dot + L q_ddot + N_R - Q_R
//! ```

use alloc::vec::Vec;

use crate::equations::{Motion, Workspace, damp, forces, modal, rigid_net};
use crate::error::StepError;
use crate::integrator::implicit::{start_algorithmic, tail};
use crate::lagrangian::Lagrangian;
use crate::loading::Acting;
use crate::math::{Vec6, add, combine, cross, dot_6, join, matrix, mul6_symmetric, split, sub_6};
use crate::model::{Model, invert_positive_definite};
use crate::state::{State, true_velocity};

/// Motion of frame A at an instant, prescribed by a host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrescribedMotion {
    /// Velocity of the origin of A and angular velocity of A, components in A, `beta = (v_A, w_A)`: m/s, rad/s - (6).
    pub velocity: [f64; 6],
    /// Rates of these components `(v_A_dot, w_A_dot)`: m/s^2, rad/s^2 - (6). The inertial acceleration of the origin is
    /// `v_A_dot + w_A x v_A`.
    pub rate: [f64; 6],
    /// Attitude quaternion, scalar first, components in A to components in G - (4).
    pub attitude: [f64; 4],
    /// Position of the origin of A in G, m - (3).
    pub position: [f64; 3],
}

impl Default for PrescribedMotion {
    /// At rest, A on G.
    fn default() -> Self {
        PrescribedMotion {
            velocity: [0.0; 6],
            rate: [0.0; 6],
            attitude: [1.0, 0.0, 0.0, 0.0],
            position: [0.0; 3],
        }
    }
}

impl PrescribedMotion {
    /// Finite numbers and a unit quaternion (to 1e-6).
    pub(crate) fn check(&self) -> Result<(), StepError> {
        let arrays: [(&str, &[f64]); 4] = [
            ("velocity", &self.velocity),
            ("rate", &self.rate),
            ("attitude", &self.attitude),
            ("position", &self.position),
        ];
        for (what, values) in arrays {
            if let Some(&found) = values.iter().find(|x| !x.is_finite()) {
                return Err(StepError::Motion { what, found, expected: "finite numbers" });
            }
        }
        let found: f64 = self.attitude.iter().map(|x| x * x).sum();
        if (found - 1.0).abs() <= 1e-6 {
            Ok(())
        } else {
            Err(StepError::Motion { what: "squared length of attitude", found, expected: "1 to 1e-6" })
        }
    }
}

/// What the body does to the host that moves its frame A: wrenches `(force, moment)` about the origin of A, components
/// in A, N and N m - (6) each.
///
/// All act **on the host**. The host accelerates by [`Reaction::total`] when it carries no inertia of the body itself; by
/// `loads + increment` when it carries the mass and inertia of the undeformed body; by `increment` alone when it applies
/// the loads itself too.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reaction {
    /// Inertia of the undeformed body in the prescribed motion, `-(M_RR beta_dot + C_RR(beta) beta)`.
    pub inertia: [f64; 6],
    /// Resultant of the loads at the deformed points, weight included where it is among the loads.
    pub loads: [f64; 6],
    /// What elasticity adds: inertia of the elastic motion and gyroscopic forces of the deformed body.
    pub increment: [f64; 6],
}

impl Reaction {
    /// Sum of the three: zero in free flight.
    pub fn total(&self) -> [f64; 6] {
        let mut sum = self.inertia;
        for ((sum, loads), increment) in sum.iter_mut().zip(&self.loads).zip(&self.increment) {
            *sum += loads + increment;
        }
        sum
    }

    /// From the forces evaluated before and the accelerations `(q_ddot, beta*_dot)`, with `beta*_dot = beta_dot - Phi_R q_ddot`.
    pub(crate) fn new(model: &Model, work: &Workspace, motion: &PrescribedMotion, u_dot: &[f64]) -> Self {
        let rows = |it: &Lagrangian| it.rigid_rows(&work.lagrangian, modal(u_dot), &motion.rate);
        Self::of(model, work, motion, u_dot, rows)
    }

    /// The same after an implicit step, which leaves the inertia of its accelerations with a consistent model.
    pub(crate) fn of_step(model: &Model, work: &Workspace, motion: &PrescribedMotion, u_dot: &[f64]) -> Self {
        Self::of(model, work, motion, u_dot, |_| work.lagrangian.rigid)
    }

    /// With the rigid rows of the inertia of a consistent model.
    fn of(
        model: &Model,
        work: &Workspace,
        motion: &PrescribedMotion,
        u_dot: &[f64],
        rows: impl Fn(&Lagrangian) -> Vec6,
    ) -> Self {
        let loads = tail(&work.external);
        let total = match &model.lagrangian {
            None => {
                let own = mul6_symmetric(&model.rigid_mass, &tail(u_dot));
                sub_6(
                    &sub_6(&rigid_net(&work.external, &work.gyroscopic), &own),
                    &combine(&model.participation, u_dot),
                )
            }
            Some(lagrangian) => sub_6(&loads, &rows(lagrangian)),
        };
        let inertia = rigid_inertia(model, motion);
        Reaction { inertia, loads, increment: sub_6(&sub_6(&total, &inertia), &loads) }
    }
}

/// `-(M_RR beta_dot + C_RR(beta) beta)`.
fn rigid_inertia(model: &Model, motion: &PrescribedMotion) -> Vec6 {
    let (p, h) = split(&mul6_symmetric(&model.rigid_mass, &motion.velocity));
    let (p_dot, h_dot) = split(&mul6_symmetric(&model.rigid_mass, &motion.rate));
    let (v, w) = split(&motion.velocity);
    let force = add(p_dot, cross(w, p));
    let moment = add(h_dot, add(cross(w, h), cross(v, p)));
    sub_6(&[0.0; 6], &join(force, moment))
}

/// Elastic rows with A held: solves `(diag + Phi_R^t M_RR Phi_R) x = r` by the Woodbury identity.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    inverse_diagonal: Vec<f64>,
    /// `(M_RR^-1 + Phi_R diag^-1 Phi_R^t)^-1` - (6 x 6).
    capacitance: [Vec6; 6],
}

impl Held {
    /// None when the matrix is not positive definite to the precision of the numbers.
    pub(crate) fn new(phi_r: &[Vec6], rigid_mass_inverse: &[Vec6; 6], diagonal: &[f64]) -> Option<Self> {
        let mut flexibility = *rigid_mass_inverse;
        for (phi, diagonal) in phi_r.iter().zip(diagonal) {
            for (row, phi_i) in flexibility.iter_mut().zip(phi) {
                for (entry, phi_j) in row.iter_mut().zip(phi) {
                    *entry += phi_i * phi_j / diagonal;
                }
            }
        }
        let capacitance = invert_positive_definite(&flexibility).ok()?;
        Some(Held { inverse_diagonal: diagonal.iter().map(|d| 1.0 / d).collect(), capacitance })
    }

    /// In place.
    #[inline]
    pub(crate) fn solve(&self, phi_r: &[Vec6], x: &mut [f64]) {
        for (x, inverse) in x.iter_mut().zip(&self.inverse_diagonal) {
            *x *= inverse;
        }
        let moved = mul6_symmetric(&self.capacitance, &true_velocity(phi_r, x, &[0.0; 6]));
        for ((x, inverse), phi) in x.iter_mut().zip(&self.inverse_diagonal).zip(phi_r) {
            *x -= inverse * dot_6(phi, &moved);
        }
    }
}

impl Model {
    /// What has to be known to hold frame A, or why it cannot be.
    pub(crate) fn held(&self) -> Result<&Held, StepError> {
        match (&self.relative, &self.held) {
            (None, Some(held)) => Ok(held),
            (Some(_), _) => Err(StepError::NotInFrameA {
                reason: "the mean-axes method is written about the centre of mass; take the reduced or the rigid one",
            }),
            (None, None) => Err(StepError::NotInFrameA {
                reason: "the modes move A by so much that the mass of their shapes relative to it is lost in round-off",
            }),
        }
    }

    /// Inertia about the origin of A with the modes free to respond, `(M_RR^-1 + Phi_R m^-1 Phi_R^t)^-1`: what a sudden change of
    /// its acceleration meets - (6 x 6), symmetric, kg, kg m, kg m^2. The modes take along the rest, `M_RR` less this: the
    /// part of [`Reaction::increment`] that is proportional to the rate of the motion is that times the rate.
    ///
    /// # Errors
    /// As for a prescribed motion: a mean-axes model, or modes that move A too much.
    pub fn apparent_inertia(&self) -> Result<[[f64; 6]; 6], StepError> {
        self.held().map(|held| held.capacitance)
    }

    /// The motion of A in a state, its rate where [`State::accelerations_known`].
    pub fn motion_of(&self, state: &State) -> PrescribedMotion {
        let rate = state.u_dot.last_chunk::<6>().copied().unwrap_or_default();
        PrescribedMotion {
            velocity: self.velocity(state),
            rate: true_velocity(&self.phi_r, &state.u_dot, &rate),
            attitude: state.attitude,
            position: state.position,
        }
    }

    /// Moves frame A of a state as a host says, solves the elastic accelerations and returns what the body does to the host.
    pub(crate) fn prescribe(
        &self,
        state: &mut State,
        loads: &Acting,
        motion: &PrescribedMotion,
        work: &mut Workspace,
    ) -> Result<Reaction, StepError> {
        let held = self.held()?;
        self.set_motion(state, motion);
        let State { q, q_dot, beta_star, u_dot, .. } = state;
        let attitude = matrix(state.attitude);
        self.with_u(q_dot, beta_star, work, |u, work| {
            let here =
                Motion { t: state.time, q, u, attitude, position: motion.position, beta: motion.velocity };
            forces(self, loads, &here, work);
            self.held_accelerations(held, &here, &motion.rate, work, u_dot);
        });
        // Before the scratch goes to another use.
        let reaction = Reaction::new(self, work, motion, &state.u_dot);
        start_algorithmic(self, state, work);
        state.accelerations_known = true;
        Ok(reaction)
    }

    /// Takes over the rigid motion of a host: `beta*`, attitude and position. Modal amplitudes and rates stay.
    pub(crate) fn set_motion(&self, state: &mut State, motion: &PrescribedMotion) {
        state.beta_star = self.own_velocity(&motion.velocity, &state.q_dot);
        state.attitude = crate::math::normalised(motion.attitude);
        state.position = motion.position;
    }

    /// `u_dot` under a prescribed `beta_dot`, from the forces found before.
    #[inline]
    pub(crate) fn held_accelerations(
        &self,
        held: &Held,
        at: &Motion,
        rate: &Vec6,
        work: &mut Workspace,
        u_dot: &mut [f64],
    ) {
        if let Some(lagrangian) = &self.lagrangian {
            damp(self, modal(at.u), &mut work.relative);
            let Some((q_ddot, beta_star_dot)) = u_dot.split_last_chunk_mut::<6>() else { return };
            lagrangian.solve_held(&mut work.lagrangian, &work.relative, rate, &[], q_ddot);
            *beta_star_dot = self.own_velocity(rate, q_ddot);
            return;
        }
        let shaken = self.base_force(rate, work);
        let net =
            work.external.iter().zip(&work.gyroscopic).map(|(external, gyroscopic)| external - gyroscopic);
        let elastic = self.elastic.iter().zip(&self.phi_r).zip(at.q).zip(at.u);
        let Some((q_ddot, beta_star_dot)) = u_dot.split_at_mut_checked(self.n_modes()) else { return };
        for ((q_ddot, net), (((mode, phi), q), q_dot)) in q_ddot.iter_mut().zip(net).zip(elastic) {
            *q_ddot = net - mode.damping * q_dot - mode.stiffness * q + dot_6(phi, &shaken);
        }
        self.shake(rate, q_ddot);
        held.solve(&self.phi_r, q_ddot);
        for (rate, own) in beta_star_dot.iter_mut().zip(self.own_velocity(rate, q_ddot)) {
            *rate = own;
        }
    }

    /// `beta* = beta - Phi_R q_dot`, and the same for accelerations.
    #[inline]
    pub(crate) fn own_velocity(&self, beta: &Vec6, q_dot: &[f64]) -> Vec6 {
        sub_6(beta, &true_velocity(&self.phi_r, q_dot, &[0.0; 6]))
    }

    /// Takes `L^t beta_dot`, the inertia force of the moving base of a clamped structure, off its elastic rows.
    #[inline]
    pub(crate) fn shake(&self, rate: &Vec6, elastic: &mut [f64]) {
        for (force, participation) in elastic.iter_mut().zip(&self.participation) {
            *force -= dot_6(participation, rate);
        }
    }

    /// `M_RR beta_dot + N_R - Q_R`: the reaction as it would be without elastic accelerations.
    #[inline]
    pub(crate) fn base_force(&self, rate: &Vec6, work: &Workspace) -> Vec6 {
        sub_6(&mul6_symmetric(&self.rigid_mass, rate), &rigid_net(&work.external, &work.gyroscopic))
    }
}
