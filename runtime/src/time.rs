//! Time functions of loads.
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

use crate::expression::Program;

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
