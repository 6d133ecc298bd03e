//! Outputs along a direction: how they change with the state and with the accelerations.

use super::{Jacobian, Parts};
use crate::forward::Forward;
use crate::math::Vec6;
use crate::model::Model;
use crate::output::{PointOutput, RigidOutput};
use crate::point_motion::{Moving, PointMotion};
use crate::real::Real;
use crate::sensor::SensorReading;
use crate::state::true_velocity;

/// A direction: changes of the state in the coordinates of [`Jacobian`] - (2 m + 12) -, and of the accelerations `(q_ddot, beta*_dot)`
/// that go with it - (m + 6).
///
/// Along a state they are the rows `m .. 2 m + 6` of its column of [`Jacobian::matrix`]; along a load the state does not change, and
/// the accelerations are the same rows of [`Jacobian::by_load`].
#[derive(Clone, Copy, Debug)]
pub struct Direction<'a> {
    /// Change of the state - (2 m + 12); empty where there is none.
    pub state: &'a [f64],
    /// Change of the accelerations - (m + 6).
    pub u_dot: &'a [f64],
}

impl Jacobian {
    /// Derivative of the motion of frame A, see [`crate::Model::rigid_output`], along a direction at the state evaluated last; that of the
    /// quaternion too. Does not allocate.
    pub fn rigid_output(&mut self, along: Direction<'_>) -> RigidOutput {
        let Jacobian { model, parts, .. } = self;
        let of = model.rigid_output_of(&parts.moving(model, along));
        let slope = |x: [Forward; 3]| x.map(first);
        RigidOutput {
            r_g: slope(of.r_g),
            v_a: slope(of.v_a),
            w_a: slope(of.w_a),
            v_g: slope(of.v_g),
            w_g: slope(of.w_g),
            zeta: of.zeta.map(first),
        }
    }

    /// Derivative of the rates of the velocity of A, see [`crate::Model::frame_rate`], along a direction. Does not allocate.
    pub fn frame_rate(&mut self, along: Direction<'_>) -> [f64; 6] {
        let Jacobian { model, parts, .. } = self;
        model.frame_rate_of(&parts.moving(model, along)).map(first)
    }

    /// Derivative of the displacement and the position of a named point, or none when there is no such index.
    pub fn point_output(&mut self, along: Direction<'_>, index: usize) -> Option<PointOutput> {
        let Jacobian { model, parts, .. } = self;
        let of = model.point_output_of(&parts.moving(model, along), index)?;
        Some(PointOutput { dr_a: of.dr_a.map(first), r_g: of.r_g.map(first) })
    }

    /// Derivative of the motion of a named point, or none when there is no such index.
    pub fn point_motion(&mut self, along: Direction<'_>, index: usize) -> Option<PointMotion> {
        Some(slopes(&self.parts.forward_point(&self.model, along, index)?))
    }

    /// Derivative of what a sensor reads, or none when there is no such index.
    pub fn sensor_reading(&mut self, along: Direction<'_>, index: usize) -> Option<SensorReading> {
        let Jacobian { model, parts, .. } = self;
        let sensor = model.data().sensors.get(index)?;
        let motion = parts.forward_point(model, along, sensor.point as usize)?;
        let of = sensor.reading(parts.work.gravity, &motion);
        Some(SensorReading { a: of.a.map(first), w: of.w.map(first), alpha: of.alpha.map(first) })
    }

    /// Derivative of the motion of a station of a block as if it were a named point, its section for the node; with the derivative of
    /// its displacement in A. None when there is no such index. See [`Jacobian::point_motion`].
    pub fn station_motion(
        &mut self,
        along: Direction<'_>,
        block: usize,
        station: usize,
    ) -> Option<(PointMotion, [f64; 3])> {
        let Jacobian { model, parts, .. } = self;
        let point = model.station(block, station)?;
        let moving = parts.moving(model, along);
        let of = point.motion(&moving);
        let displacement = point.displacement(&point.phi, moving.q);
        Some((slopes(&of), displacement.map(first)))
    }

    /// Derivative of the position of a station of a block in G, or none when there is no such index. Does not allocate.
    pub fn station_position(
        &mut self,
        along: Direction<'_>,
        block: usize,
        station: usize,
    ) -> Option<[f64; 3]> {
        let Jacobian { model, parts, .. } = self;
        let point = model.station(block, station)?;
        let moving = parts.moving(model, along);
        let moved = point.displacement(&point.phi, moving.q);
        Some(point.position_in_g(&moving, moved).map(first))
    }
}

impl Parts {
    fn forward_point(
        &mut self,
        model: &Model,
        along: Direction<'_>,
        index: usize,
    ) -> Option<PointMotion<Forward>> {
        let point = model.points.get(index)?;
        Some(point.motion(&self.moving(model, along)))
    }

    /// The state with its accelerations, and their slopes along a direction.
    pub(super) fn moving(&mut self, model: &Model, along: Direction<'_>) -> Moving<'_, Forward> {
        let Parts { state, forward, u_dot, .. } = self;
        let slopes = along.state.iter().enumerate().map(|(coordinate, slope)| (coordinate, 0, *slope));
        forward.place(model, state, slopes);
        let with_slope = |(value, slope): (&f64, &f64)| {
            let mut x = Forward::of(*value);
            x.seed(0, *slope);
            x
        };
        let rates = || u_dot.iter().zip(along.u_dot.iter().chain(core::iter::repeat(&0.0))).map(with_slope);
        let m = model.n_modes();
        let mut beta_dot: Vec6<Forward> = [Forward::default(); 6];
        for (to, from) in beta_dot.iter_mut().zip(rates().skip(m)) {
            *to = from;
        }
        let moving = forward.moving(rates().take(m));
        let beta_dot = true_velocity(&model.phi_r, moving.q_ddot, &beta_dot);
        Moving { beta_dot, ..moving }
    }
}

fn slopes(of: &PointMotion<Forward>) -> PointMotion {
    PointMotion {
        attitude: of.attitude.map(first),
        v_g: of.v_g.map(first),
        w_g: of.w_g.map(first),
        a_g: of.a_g.map(first),
        alpha_g: of.alpha_g.map(first),
    }
}

pub(super) fn first(x: Forward) -> f64 {
    x.slope(0)
}
