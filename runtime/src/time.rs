//! Time functions of loads.
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

use crate::expression::{Program, Variables};

/// Dimensionless factor over time t (s).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum TimeFunction {
    /// `value` at all times.
    Constant {
        /// Value.
        value: f64,
    },
    /// Zero before `start`, `value` from `start` on, zero again from `end` on (`end` may be infinite in the input: stored as `f64::MAX`).
    Step {
        /// Value.
        value: f64,
        /// First instant of the step, s.
        start: f64,
        /// Instant at which it ends, s.
        end: f64,
    },
    /// `rate * (t - start)` from `start` to `end`, constant afterwards.
    Ramp {
        /// Slope, 1/s.
        rate: f64,
        /// Start, s.
        start: f64,
        /// End of the slope, s.
        end: f64,
    },
    /// Zero outside (start, end), `peak` at `at`, linear between.
    Triangle {
        /// Height.
        peak: f64,
        /// Start, s.
        start: f64,
        /// Instant of the peak, s.
        at: f64,
        /// End, s.
        end: f64,
    },
    /// `amplitude * sin(omega (t - start) + phase)` from `start` to `end`.
    Sine {
        /// Amplitude.
        amplitude: f64,
        /// Circular frequency, rad/s.
        omega: f64,
        /// Phase at `start`, rad.
        phase: f64,
        /// Start, s.
        start: f64,
        /// End, s.
        end: f64,
    },
    /// `amplitude/2 (1 - cos(2 pi (t - start)/duration))` for `duration` from `start`, zero outside.
    OneMinusCosine {
        /// Peak value.
        amplitude: f64,
        /// Start, s.
        start: f64,
        /// Duration, s.
        duration: f64,
    },
    /// Linear interpolation in a table, constant outside it.
    Table {
        /// Instants, strictly increasing, s - (n).
        t: Vec<f64>,
        /// Values - (n).
        value: Vec<f64>,
    },
    /// Expression of time and of the rigid velocities.
    Expression {
        /// Compiled form.
        program: Program,
    },
}

impl TimeFunction {
    /// Value at time `variables.t`. Does not allocate.
    ///
    /// Jumps take their new value at the instant itself. Instants are compared to within four units in the last place,
    /// so that a jump at 2.5 s is seen by the step whose end `n dt` rounds to just below it.
    pub fn value(&self, variables: &Variables) -> f64 {
        let t = variables.t;
        match *self {
            Self::Constant { value } => value,
            Self::Step { value, start, end } => {
                if reached(t, start) && !reached(t, end) {
                    value
                } else {
                    0.0
                }
            }
            Self::Ramp { rate, start, end } => {
                if reached(t, start) {
                    rate * (t.min(end) - start)
                } else {
                    0.0
                }
            }
            Self::Triangle { peak, start, at, end } => {
                if t <= start || t >= end {
                    0.0
                } else if t < at {
                    peak * ((t - start) / (at - start))
                } else {
                    peak * ((end - t) / (end - at))
                }
            }
            Self::Sine { amplitude, omega, phase, start, end } => {
                if reached(t, start) && !reached(t, end) {
                    amplitude * libm::sin(omega * (t - start) + phase)
                } else {
                    0.0
                }
            }
            Self::OneMinusCosine { amplitude, start, duration } => {
                let s = (t - start) / duration;
                if s <= 0.0 || s >= 1.0 {
                    return 0.0;
                }
                // (1 - cos 2x)/2 = sin^2 x does not cancel near the ends.
                let sine = libm::sin(core::f64::consts::PI * s);
                amplitude * sine * sine
            }
            Self::Table { t: ref instants, ref value } => interpolate(instants, value, t),
            Self::Expression { ref program } => program.value(variables),
        }
    }
}

/// `t >= instant`, forgiving the rounding of `n dt`.
fn reached(t: f64, instant: f64) -> bool {
    t >= instant - 4.0 * f64::EPSILON * instant.abs()
}

/// Linear interpolation, constant outside; `instants` increase strictly.
fn interpolate(instants: &[f64], values: &[f64], t: f64) -> f64 {
    let after = instants.partition_point(|&instant| instant <= t);
    let point = |i: usize| Some((*instants.get(i)?, *values.get(i)?));
    match (after.checked_sub(1).and_then(point), point(after)) {
        (Some((t0, v0)), Some((t1, v1))) => v0 + (v1 - v0) * ((t - t0) / (t1 - t0)),
        (Some((_, v)), None) | (None, Some((_, v))) => v,
        (None, None) => 0.0,
    }
}
