//! Inertial sensors: what an inertial measurement unit on a named point reads.

use crate::data::SensorData;
use crate::error::ModelError;
use crate::math::{Vec3, constant, mul_t, sub};
use crate::model::{Model, unknown};
use crate::point_motion::{PointMotion, turned_into};
use crate::real::Real;
use crate::state::State;

/// What a sensor reads, in its own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorReading<R = f64> {
    /// Acceleration, less that of free fall where the sensor feels gravity (specific force), m/s^2 - (3).
    pub a: [R; 3],
    /// Angular velocity, rad/s - (3).
    pub w: [R; 3],
    /// Angular acceleration, rad/s^2 - (3).
    pub alpha: [R; 3],
}

impl Model {
    /// Index of a sensor.
    ///
    /// # Errors
    /// [`ModelError::Unknown`], which lists the names there are.
    pub fn sensor(&self, name: &str) -> Result<usize, ModelError> {
        let sensors = &self.data().sensors;
        sensors
            .iter()
            .position(|sensor| sensor.name == name)
            .ok_or_else(|| unknown("sensor", name, sensors.iter().map(|sensor| &sensor.name)))
    }

    /// What a sensor reads, or none when there is no such index. `u_dot` as in [`Model::point_motion`]. Does not allocate.
    pub fn sensor_reading(&self, state: &State, u_dot: &[f64], index: usize) -> Option<SensorReading> {
        self.sensor_reading_under(self.gravity(), state, u_dot, index)
    }

    /// The reading in another field of gravity, in G.
    pub(crate) fn sensor_reading_under(
        &self,
        gravity: Vec3,
        state: &State,
        u_dot: &[f64],
        index: usize,
    ) -> Option<SensorReading> {
        let sensor = self.data().sensors.get(index)?;
        let motion = self.point_motion(state, u_dot, sensor.point as usize)?;
        Some(sensor.reading(gravity, &motion))
    }
}

impl SensorData {
    /// What it reads in a motion of its point.
    pub(crate) fn reading<R: Real>(&self, gravity: Vec3, motion: &PointMotion<R>) -> SensorReading<R> {
        // G to node, node to sensor.
        let axes = constant(&self.axes);
        let own = |vector: Vec3<R>| mul_t(&axes, turned_into(motion.attitude, vector));
        let felt = if self.gravity { sub(motion.a_g, gravity.map(R::of)) } else { motion.a_g };
        SensorReading { a: own(felt), w: own(motion.w_g), alpha: own(motion.alpha_g) }
    }
}
