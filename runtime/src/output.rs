//! What can be read from a state. Nothing here allocates or changes anything.

use crate::equations;
use crate::lagrangian::Energies;
use crate::math::{
    Mat3, Vec3, Vec6, add, add_6, axpy, combine, constant, cross, dot, dot_6, join, mat_mul, matrix, mul,
    mul6_symmetric, rotation, scale, split, sub,
};
use crate::model::{Model, Point};
use crate::point_motion::Moving;
use crate::real::Real;
use crate::state::{State, true_velocity};

/// Motion of frame A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidOutput<R = f64> {
    /// Position of the origin of A in G, m - (3).
    pub r_g: [R; 3],
    /// Velocity of the origin of A in A, m/s - (3).
    pub v_a: [R; 3],
    /// Angular velocity of A in A, rad/s - (3).
    pub w_a: [R; 3],
    /// Velocity of the origin of A in G, m/s - (3).
    pub v_g: [R; 3],
    /// Angular velocity of A in G, rad/s - (3).
    pub w_g: [R; 3],
    /// Attitude quaternion, scalar first, components in A to components in G - (4).
    pub zeta: [R; 4],
}

/// Where a named point is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointOutput<R = f64> {
    /// Displacement from the equilibrium in A, m - (3).
    pub dr_a: [R; 3],
    /// Position in G, m - (3).
    pub r_g: [R; 3],
}

/// The quantities whose balance tells whether a result can be trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ledger {
    /// Centre of mass in G, m - (3).
    pub r_cm_g: [f64; 3],
    /// Linear momentum in G, kg m/s - (3).
    pub linear_momentum_g: [f64; 3],
    /// Angular momentum in G about the origin of G, kg m^2/s - (3).
    pub angular_momentum_g: [f64; 3],
    /// Kinetic energy, J.
    pub kinetic_energy: f64,
    /// Elastic energy of the kept modes, J.
    pub elastic_energy: f64,
    /// Potential energy in the field of gravity, zero with the centre of mass at the origin of G, J.
    pub gravity_energy: f64,
}

/// Rate of an attitude quaternion, `1/2 zeta (0, w)`, 1/s: `zeta` turns components in A to components in G, scalar first - (4); `w` is the
/// angular velocity of A, components in A, rad/s - (3). Linear in each.
pub fn attitude_rate(zeta: [f64; 4], w: [f64; 3]) -> [f64; 4] {
    equations::attitude_rate(zeta, w)
}

impl Model {
    /// Position, velocities and attitude of frame A.
    pub fn rigid_output(&self, state: &State) -> RigidOutput {
        self.rigid_output_of(&self.moving(state))
    }

    pub(crate) fn rigid_output_of<R: Real>(&self, of: &Moving<R>) -> RigidOutput<R> {
        let (mut v_a, w_a) = split(&of.beta);
        let attitude = matrix(of.attitude);
        let mut r_g = of.position;
        if let Some(relative) = &self.relative {
            // The state is about the centre of mass; A sits on the reference node, which moves in the modes.
            let (shift, rate) = (combine(&relative.phi_r, of.q), combine(&relative.phi_r, of.q_dot));
            let origin = add(relative.origin.map(R::of), split(&shift).0);
            v_a = add(v_a, add(cross(w_a, origin), split(&rate).0));
            r_g = add(r_g, mul(&attitude, origin));
        }
        RigidOutput { r_g, v_a, w_a, v_g: mul(&attitude, v_a), w_g: mul(&attitude, w_a), zeta: of.attitude }
    }

    /// Rates `(v_A_dot, w_A_dot)` of the components in A of its velocity: m/s^2, rad/s^2 - (6). The inertial acceleration of the origin is
    /// `v_A_dot + w_A x v_A`. `u_dot` as in [`Model::point_motion`]; none where it has another length.
    pub fn frame_rate(&self, state: &State, u_dot: &[f64]) -> Option<[f64; 6]> {
        let (q_ddot, beta_star_dot) = u_dot.split_last_chunk::<6>()?;
        let beta_dot = true_velocity(&self.phi_r, q_ddot, beta_star_dot);
        Some(self.frame_rate_of(&Moving { q_ddot, beta_dot, ..self.moving(state) }))
    }

    pub(crate) fn frame_rate_of<R: Real>(&self, of: &Moving<R>) -> Vec6<R> {
        let Some(relative) = &self.relative else { return of.beta_dot };
        let along = |rates: &[R]| split(&combine(&relative.phi_r, rates)).0;
        let (v_dot, w_dot) = split(&of.beta_dot);
        let origin = add(relative.origin.map(R::of), along(of.q));
        let turned = add(cross(w_dot, origin), cross(split(&of.beta).1, along(of.q_dot)));
        join(add(v_dot, add(turned, along(of.q_ddot))), w_dot)
    }

    /// Displacement and position of a named point, or none when there is no such index.
    pub fn point_output(&self, state: &State, index: usize) -> Option<PointOutput> {
        self.point_output_of(&self.moving(state), index)
    }

    pub(crate) fn point_output_of<R: Real>(&self, of: &Moving<R>, index: usize) -> Option<PointOutput<R>> {
        let point = self.points.get(index)?;
        let moved = point.displacement(&point.phi, of.q);
        let dr_a = match &self.relative {
            Some(relative) => point.displacement(relative.phi.get(index)?, of.q),
            None => moved,
        };
        Some(PointOutput { dr_a, r_g: point.position_in_g(of, moved) })
    }

    /// A state without its accelerations.
    fn moving<'a>(&self, state: &'a State) -> Moving<'a, f64> {
        Moving {
            q: &state.q,
            q_dot: &state.q_dot,
            q_ddot: &[],
            beta: self.velocity(state),
            beta_dot: [0.0; 6],
            attitude: state.attitude,
            position: state.position,
        }
    }

    /// Centre of mass, momenta and energies of the reduced model. Where the mass matrix is constant: with modes orthogonal
    /// to the rigid motions the momenta are `M_RR beta*` and the kinetic energy
    /// `1/2 sum m_i q_dot_i^2 + 1/2 beta*^t M_RR beta*`.
    pub fn ledger(&self, state: &State) -> Ledger {
        self.ledger_under(self.gravity(), state)
    }

    /// The ledger in another field of gravity, in G.
    pub(crate) fn ledger_under(&self, gravity: Vec3, state: &State) -> Ledger {
        let attitude = matrix(state.attitude);
        if let Some(lagrangian) = &self.lagrangian {
            let found = lagrangian.energies(&state.q, &state.q_dot, &self.velocity(state));
            return self.ledger_of(gravity, state, &attitude, &found);
        }
        let rigid = mul6_symmetric(&self.rigid_mass, &state.beta_star);
        // The modes of a clamped structure carry momentum.
        let modal = combine(&self.participation, &state.q_dot);
        let momentum = add_6(&rigid, &modal);
        let (p_a, h_a) = split(&momentum);
        let linear_momentum_g = mul(&attitude, p_a);
        let (mut kinetic, mut elastic) = (dot_6(&add_6(&momentum, &modal), &state.beta_star), 0.0);
        for ((mode, q), q_dot) in self.elastic.iter().zip(&state.q).zip(&state.q_dot) {
            kinetic += mode.mass * q_dot * q_dot;
            elastic += mode.stiffness * q * q;
        }
        Ledger {
            r_cm_g: add(state.position, mul(&attitude, self.centre_of_mass_a(state))),
            linear_momentum_g,
            angular_momentum_g: add(cross(state.position, linear_momentum_g), mul(&attitude, h_a)),
            kinetic_energy: 0.5 * kinetic,
            elastic_energy: 0.5 * elastic + self.trim_energy(&state.q),
            gravity_energy: -dot(gravity, self.weighed(state, &attitude)),
        }
    }

    /// The ledger of a consistent model.
    fn ledger_of(&self, gravity: Vec3, state: &State, attitude: &Mat3, found: &Energies) -> Ledger {
        let (mass, (p_a, h_a)) = (self.data().rigid.mass, split(&found.momentum));
        let linear_momentum_g = mul(attitude, p_a);
        let weighed = axpy(mul(attitude, found.first_moment), mass, state.position);
        Ledger {
            r_cm_g: scale(1.0 / mass, weighed),
            linear_momentum_g,
            angular_momentum_g: add(cross(state.position, linear_momentum_g), mul(attitude, h_a)),
            kinetic_energy: found.kinetic,
            elastic_energy: found.elastic + self.trim_energy(&state.q),
            gravity_energy: -dot(gravity, weighed),
        }
    }

    /// First moment of mass in G, kg m, to second order in the amplitudes as the weight has it.
    fn weighed(&self, state: &State, attitude: &Mat3) -> Vec3 {
        let moment = mul(attitude, self.weight.first_moment(&state.q));
        axpy(moment, self.data().rigid.mass, state.position)
    }

    /// Elastic energy of the equilibrium and its first-order part, J.
    fn trim_energy(&self, q: &[f64]) -> f64 {
        self.data().trim.as_ref().map_or(0.0, |trim| {
            trim.elastic_energy + trim.elastic_force.iter().zip(q).map(|(force, q)| force * q).sum::<f64>()
        })
    }

    /// Centre of mass of the deformed structure in A, m - (3).
    pub fn centre_of_mass_a(&self, state: &State) -> [f64; 3] {
        if let Some(lagrangian) = &self.lagrangian {
            return scale(1.0 / self.data().rigid.mass, lagrangian.first_moment(&state.q));
        }
        let m = self.n_modes();
        let moment = &self.data().modes.first_moment;
        let row = |row: usize| -> f64 {
            moment.iter().skip(row * m).zip(&state.q).map(|(moment, q)| moment * q).sum()
        };
        let shift: Vec3 = [row(0), row(1), row(2)];
        add(self.centre_of_mass, scale(1.0 / self.data().rigid.mass, shift))
    }
}

impl Point {
    /// Displacement for given shapes: R = R0 + Phi q, Q = Q0 exp(theta~), P = R + Q offset. Not taken as the difference of two
    /// positions, which would lose its small digits.
    pub(crate) fn displacement<R: Real>(&self, phi: &[Vec6], q: &[R]) -> Vec3<R> {
        let zero = [R::of(0.0); 6];
        let mut moved = combine(phi, q);
        self.curve.along(q, q, &mut moved, &mut { zero }, &mut { zero });
        self.displaced(&moved)
    }

    /// Displacement for a motion of the node: translation in A, rotation in the node frame.
    pub(crate) fn displaced<R: Real>(&self, moved: &Vec6<R>) -> Vec3<R> {
        let (translation, theta) = split(moved);
        if self.offset == [0.0; 3] {
            return translation;
        }
        let (rest, offset) = (constant(&self.node_rotation), self.offset.map(R::of));
        let arm = mul(&mat_mul(&rest, &rotation(theta)), offset);
        add(translation, sub(arm, mul(&rest, offset)))
    }

    /// Displacement for a small motion of the node.
    #[inline]
    pub(crate) fn led(&self, (translation, theta): (Vec3, Vec3)) -> Vec3 {
        if self.offset == [0.0; 3] {
            return translation;
        }
        add(translation, mul(&self.node_rotation, cross(theta, self.offset)))
    }

    /// Position in G with a displacement in A.
    pub(crate) fn position_in_g<R: Real>(&self, of: &Moving<R>, moved: Vec3<R>) -> Vec3<R> {
        add(of.position, mul(&matrix(of.attitude), add(self.position.map(R::of), moved)))
    }
}
