//! Attitude, velocities and accelerations of named points, with all gyroscopic terms.
//!
//! A point sits at `r = R0 + t + N o` in A, with `N = Q0 exp(theta~)` and `(t, theta) = Phi q`, of second and third order besides
//! on a curved manifold. With the spin of the node
//! relative to A, `W = T(theta) theta_dot` (node axes), everything below is the exact time derivative of that position:
//!
//! ```text
//! v_P = v + w x r + r_dot                                             r_dot  = t_dot + N (W x o)
//! a_P = v_dot + w x v + w_dot x r + w x (w x r) + 2 w x r_dot + r_ddot      r_ddot = t_ddot + N (W_dot x o + W x (W x o))
//! w_P = w + N W         alpha_P = w_dot + w x N W + N W_dot           W_dot  = T theta_ddot + T_dot theta_dot
//! ```

use crate::math::{
    Vec3, Vec6, add, combine, constant, cross, mat_mul, matrix, mul, mul_t, quaternion, quaternion_product,
    rotation_and_tangential, split, tangential_rate,
};
use crate::model::{Model, Point};
use crate::real::{Real, Smooth};
use crate::state::{State, true_velocity};

/// How a named point moves, seen from G.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMotion<R = f64> {
    /// Attitude of the axes of its node, scalar first: node axes (those of the drawing at rest) to G - (4).
    pub attitude: [R; 4],
    /// Velocity in G, m/s - (3).
    pub v_g: [R; 3],
    /// Angular velocity of the node in G, rad/s - (3).
    pub w_g: [R; 3],
    /// Acceleration in G, m/s^2 - (3).
    pub a_g: [R; 3],
    /// Angular acceleration of the node in G, rad/s^2 - (3).
    pub alpha_g: [R; 3],
}

/// Components of a vector of G in axes whose attitude (axes to G, scalar first) is `zeta`: those of A with
/// [`State::attitude`], those of a node with [`PointMotion::attitude`].
pub fn into_axes(zeta: [f64; 4], vector_g: [f64; 3]) -> [f64; 3] {
    turned_into(zeta, vector_g)
}

/// As [`into_axes`].
pub(crate) fn turned_into<R: Real>(zeta: [R; 4], vector_g: Vec3<R>) -> Vec3<R> {
    mul_t(&matrix(zeta), vector_g)
}

/// What the motion of points follows from.
pub(crate) struct Moving<'a, R> {
    pub(crate) q: &'a [R],
    pub(crate) q_dot: &'a [R],
    pub(crate) q_ddot: &'a [R],
    /// True velocity of A in A, and its rate.
    pub(crate) beta: Vec6<R>,
    pub(crate) beta_dot: Vec6<R>,
    pub(crate) attitude: [R; 4],
    pub(crate) position: Vec3<R>,
}

/// A node relative to A: axes and rates.
struct Turning<R> {
    attitude: [R; 4],
    /// Velocity and acceleration of the point in A as an observer on A sees them.
    r: Vec3<R>,
    r_dot: Vec3<R>,
    r_ddot: Vec3<R>,
    /// Spin relative to A and its rate, components in A.
    spin: Vec3<R>,
    spin_rate: Vec3<R>,
}

impl Model {
    /// How a named point moves, or none when there is no such index. `u_dot` are the accelerations
    /// `(q_ddot, beta*_dot)` that belong to the state - (m + 6): [`State::u_dot`] where they are known, or
    /// [`crate::StateRate::u_dot`]. Does not allocate.
    pub fn point_motion(&self, state: &State, u_dot: &[f64], index: usize) -> Option<PointMotion> {
        self.motion_of_point(state, u_dot, self.points.get(index)?)
    }

    /// How a station of a block moves, its section in place of a node; as [`Model::point_motion`].
    pub fn station_motion(
        &self,
        state: &State,
        u_dot: &[f64],
        block: usize,
        station: usize,
    ) -> Option<PointMotion> {
        self.motion_of_point(state, u_dot, self.station(block, station)?)
    }

    fn motion_of_point(&self, state: &State, u_dot: &[f64], point: &Point) -> Option<PointMotion> {
        let (q_ddot, beta_star_dot) = u_dot.split_last_chunk::<6>()?;
        Some(point.motion(&Moving {
            q: &state.q,
            q_dot: &state.q_dot,
            q_ddot,
            beta: self.velocity(state),
            beta_dot: true_velocity(&self.phi_r, q_ddot, beta_star_dot),
            attitude: state.attitude,
            position: state.position,
        }))
    }
}

impl Point {
    pub(crate) fn motion<R: Smooth>(&self, of: &Moving<R>) -> PointMotion<R> {
        let (v, w) = split(&of.beta);
        let (v_dot, w_dot) = split(&of.beta_dot);
        let at = self.turning(of);
        let to_g = matrix(of.attitude);

        let velocity = add(v, add(cross(w, at.r), at.r_dot));
        // w x (v + w x r + r_dot) holds one of the two Coriolis terms.
        let transport = add(v_dot, add(cross(w_dot, at.r), cross(w, add(velocity, at.r_dot))));
        PointMotion {
            attitude: quaternion_product(of.attitude, at.attitude),
            v_g: mul(&to_g, velocity),
            w_g: mul(&to_g, add(w, at.spin)),
            a_g: mul(&to_g, add(transport, at.r_ddot)),
            alpha_g: mul(&to_g, add(w_dot, add(cross(w, at.spin), at.spin_rate))),
        }
    }

    fn turning<R: Smooth>(&self, of: &Moving<R>) -> Turning<R> {
        let [mut moved, mut rate, mut second] = [of.q, of.q_dot, of.q_ddot].map(|x| combine(&self.phi, x));
        self.curve.along(of.q, of.q_dot, &mut moved, &mut rate, &mut second);
        self.curve.derivative(of.q, of.q_ddot, &mut second);
        let ((t, theta), (t_dot, theta_dot), (t_ddot, theta_ddot)) =
            (split(&moved), split(&rate), split(&second));
        let (turn, tangential) = rotation_and_tangential(theta);
        let node = mat_mul(&constant(&self.node_rotation), &turn);
        let offset = self.offset.map(R::of);
        let spin = mul(&tangential, theta_dot);
        let spin_rate = add(mul(&tangential, theta_ddot), tangential_rate(theta, theta_dot));
        let whirl = cross(spin, offset);
        Turning {
            attitude: quaternion_product(self.node_quaternion.map(R::of), quaternion(theta)),
            r: add(self.node_position.map(R::of), add(t, mul(&node, offset))),
            r_dot: add(t_dot, mul(&node, whirl)),
            r_ddot: add(t_ddot, mul(&node, add(cross(spin_rate, offset), cross(spin, whirl)))),
            spin: mul(&node, spin),
            spin_rate: mul(&node, spin_rate),
        }
    }
}
