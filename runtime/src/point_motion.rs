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
    Vec3, add, combine, cross, mat_mul, matrix, mul, mul_t, quaternion, quaternion_product,
    rotation_and_tangential, split, tangential_rate,
};
use crate::model::{Model, Point};
use crate::state::{State, true_velocity};

/// How a named point moves, seen from G.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMotion {
    /// Attitude of the axes of its node, scalar first: node axes (those of the drawing at rest) to G - (4).
    pub attitude: [f64; 4],
    /// Velocity in G, m/s - (3).
    pub v_g: [f64; 3],
    /// Angular velocity of the node in G, rad/s - (3).
    pub w_g: [f64; 3],
    /// Acceleration in G, m/s^2 - (3).
    pub a_g: [f64; 3],
    /// Angular acceleration of the node in G, rad/s^2 - (3).
    pub alpha_g: [f64; 3],
}

/// Components of a vector of G in axes whose attitude (axes to G, scalar first) is `zeta`: those of A with
/// [`State::attitude`], those of a node with [`PointMotion::attitude`].
pub fn into_axes(zeta: [f64; 4], vector_g: [f64; 3]) -> [f64; 3] {
    mul_t(&matrix(zeta), vector_g)
}

/// A node relative to A: axes and rates.
struct Turning {
    attitude: [f64; 4],
    /// Velocity and acceleration of the point in A as an observer on A sees them.
    r: Vec3,
    r_dot: Vec3,
    r_ddot: Vec3,
    /// Spin relative to A and its rate, components in A.
    spin: Vec3,
    spin_rate: Vec3,
}

impl Model {
    /// How a named point moves, or none when there is no such index. `u_dot` are the accelerations
    /// `(q_ddot, beta*_dot)` that belong to the state - (m + 6): [`State::u_dot`] where they are known, or
    /// [`crate::StateRate::u_dot`]. Does not allocate.
    pub fn point_motion(&self, state: &State, u_dot: &[f64], index: usize) -> Option<PointMotion> {
        let point = self.points.get(index)?;
        let (q_ddot, beta_star_dot) = u_dot.split_last_chunk::<6>()?;
        let (v, w) = split(&self.velocity(state));
        let (v_dot, w_dot) = split(&true_velocity(&self.phi_r, q_ddot, beta_star_dot));
        let at = point.turning(state, q_ddot);
        let to_g = matrix(state.attitude);

        let velocity = add(v, add(cross(w, at.r), at.r_dot));
        // w x (v + w x r + r_dot) holds one of the two Coriolis terms.
        let transport = add(v_dot, add(cross(w_dot, at.r), cross(w, add(velocity, at.r_dot))));
        Some(PointMotion {
            attitude: quaternion_product(state.attitude, at.attitude),
            v_g: mul(&to_g, velocity),
            w_g: mul(&to_g, add(w, at.spin)),
            a_g: mul(&to_g, add(transport, at.r_ddot)),
            alpha_g: mul(&to_g, add(w_dot, add(cross(w, at.spin), at.spin_rate))),
        })
    }
}

impl Point {
    fn turning(&self, state: &State, q_ddot: &[f64]) -> Turning {
        let [mut moved, mut rate, mut second] =
            [state.q.as_slice(), &state.q_dot, q_ddot].map(|x| combine(&self.phi, x));
        self.curve.along(&state.q, &state.q_dot, &mut moved, &mut rate, &mut second);
        self.curve.derivative(&state.q, q_ddot, &mut second);
        let ((t, theta), (t_dot, theta_dot), (t_ddot, theta_ddot)) =
            (split(&moved), split(&rate), split(&second));
        let (turn, tangential) = rotation_and_tangential(theta);
        let node = mat_mul(&self.node_rotation, &turn);
        let spin = mul(&tangential, theta_dot);
        let spin_rate = add(mul(&tangential, theta_ddot), tangential_rate(theta, theta_dot));
        let whirl = cross(spin, self.offset);
        Turning {
            attitude: quaternion_product(self.node_quaternion, quaternion(theta)),
            r: add(self.node_position, add(t, mul(&node, self.offset))),
            r_dot: add(t_dot, mul(&node, whirl)),
            r_ddot: add(t_ddot, mul(&node, add(cross(spin_rate, self.offset), cross(spin, whirl)))),
            spin: mul(&node, spin),
            spin_rate: mul(&node, spin_rate),
        }
    }
}
