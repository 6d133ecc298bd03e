//! Time functions of loads.
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

use crate::expression::{Instruction, Program, Variable, Variables};
use crate::forward::{Forward, ForwardVariables};
use crate::real::Real;

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

    /// Whether it depends on more than time.
    #[inline]
    pub(crate) fn sees_motion(&self) -> bool {
        matches!(self, Self::Expression { .. })
    }

    /// Value at time `variables.t`, with its slopes along motions of the body: those of expressions. Does not allocate.
    pub(crate) fn along(&self, variables: &ForwardVariables) -> Forward {
        match self {
            Self::Expression { program } => crate::expression_rate::along(program, variables),
            _ => Forward::of(self.value(&variables.values())),
        }
    }

    /// Rate at time `t`, 1/s, of a function of the time alone; at a jump or a kink that after it.
    pub(crate) fn rate(&self, t: f64) -> f64 {
        match *self {
            Self::Constant { .. } | Self::Step { .. } => 0.0,
            Self::Expression { ref program } => crate::expression_rate::rate(program, t),
            Self::Ramp { rate, start, end } => {
                if reached(t, start) && !reached(t, end) {
                    rate
                } else {
                    0.0
                }
            }
            Self::Triangle { peak, start, at, end } => {
                if !reached(t, start) || reached(t, end) {
                    0.0
                } else if reached(t, at) {
                    -peak / (end - at)
                } else {
                    peak / (at - start)
                }
            }
            Self::Sine { amplitude, omega, phase, start, end } => {
                if reached(t, start) && !reached(t, end) {
                    amplitude * omega * libm::cos(omega * (t - start) + phase)
                } else {
                    0.0
                }
            }
            Self::OneMinusCosine { amplitude, start, duration } => {
                let s = (t - start) / duration;
                if s <= 0.0 || s >= 1.0 {
                    return 0.0;
                }
                let turn = core::f64::consts::PI / duration;
                amplitude * turn * libm::sin(2.0 * core::f64::consts::PI * s)
            }
            Self::Table { t: ref instants, ref value } => {
                let after = instants.partition_point(|&instant| reached(t, instant));
                let point = |i: usize| Some((*instants.get(i)?, *value.get(i)?));
                match (after.checked_sub(1).and_then(point), point(after)) {
                    (Some((t0, v0)), Some((t1, v1))) => (v1 - v0) / (t1 - t0),
                    _ => 0.0,
                }
            }
        }
    }

    /// Largest jump of the value of a shape, which a velocity of a body cannot have; none known of an expression.
    pub fn largest_jump(&self) -> f64 {
        match *self {
            Self::Step { value, .. } => value.abs(),
            Self::Sine { amplitude, omega, phase, start, end } => {
                let from = if start > 0.0 { libm::sin(phase) } else { 0.0 };
                let to = if end < f64::MAX { libm::sin(omega * (end - start) + phase) } else { 0.0 };
                amplitude.abs() * from.abs().max(to.abs())
            }
            _ => 0.0,
        }
    }

    /// Whether it depends on nothing but the time.
    pub fn is_of_time_alone(&self) -> bool {
        match self {
            Self::Expression { program } => program.code.iter().all(|instruction| {
                !matches!(instruction, Instruction::Variable(variable) if *variable != Variable::T)
            }),
            _ => true,
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

#[cfg(test)]
mod tests {
    use super::*;

    fn at(function: &TimeFunction, t: f64) -> f64 {
        function.value(&Variables { t, ..Variables::default() })
    }

    #[test]
    fn jumps_take_their_new_value_at_the_instant_itself() {
        let step = TimeFunction::Step { value: 3.0, start: 1.0, end: 2.5 };
        assert_eq!([0.0, 0.999, 1.0, 2.499, 2.5, 3.0].map(|t| at(&step, t)), [0.0, 0.0, 3.0, 3.0, 0.0, 0.0]);
        // 29 steps of 0.1 s round to just below 2.9 s.
        let t = 29.0 * 0.1;
        assert!(t >= 2.9 - 1e-15);
        let late = TimeFunction::Step { value: 1.0, start: 100.0 * 0.29, end: f64::MAX };
        assert_eq!(at(&late, 28.999999999999996), 1.0);
        assert_eq!(at(&late, 28.9999), 0.0);
    }

    #[test]
    fn continuous_shapes_have_the_values_of_their_definition() {
        let ramp = TimeFunction::Ramp { rate: 2.0, start: 1.0, end: 3.0 };
        assert_eq!([0.0, 1.0, 2.0, 3.0, 9.0].map(|t| at(&ramp, t)), [0.0, 0.0, 2.0, 4.0, 4.0]);
        let triangle = TimeFunction::Triangle { peak: 6.0, start: 0.0, at: 2.0, end: 3.0 };
        assert_eq!(
            [-1.0, 0.0, 1.0, 2.0, 2.5, 3.0, 4.0].map(|t| at(&triangle, t)),
            [0.0, 0.0, 3.0, 6.0, 3.0, 0.0, 0.0]
        );
        let saw = TimeFunction::Triangle { peak: 6.0, start: 0.0, at: 0.0, end: 3.0 };
        assert_eq!(at(&saw, 1.0), 4.0);
        let sine = TimeFunction::Sine { amplitude: 2.0, omega: 3.0, phase: 0.5, start: 1.0, end: 2.0 };
        assert_eq!(at(&sine, 1.5), 2.0 * libm::sin(3.0 * 0.5 + 0.5));
        assert_eq!((at(&sine, 0.9), at(&sine, 2.0)), (0.0, 0.0));
        let gust = TimeFunction::OneMinusCosine { amplitude: 4.0, start: 1.0, duration: 2.0 };
        for t in [1.0, 1.3, 2.0, 2.9, 3.0] {
            let expected = 2.0 * (1.0 - libm::cos(core::f64::consts::PI * (t - 1.0)));
            assert!((at(&gust, t) - expected).abs() < 1e-14, "{t}");
        }
        assert_eq!((at(&gust, 0.5), at(&gust, 3.5)), (0.0, 0.0));
        assert_eq!(at(&TimeFunction::Constant { value: 7.0 }, 1e9), 7.0);
    }

    #[test]
    fn tables_interpolate_and_hold_their_ends() {
        let table = TimeFunction::Table { t: alloc::vec![0.0, 1.0, 4.0], value: alloc::vec![2.0, 4.0, -2.0] };
        assert_eq!(
            [-1.0, 0.0, 0.5, 1.0, 2.5, 4.0, 9.0].map(|t| at(&table, t)),
            [2.0, 2.0, 3.0, 4.0, 1.0, -2.0, -2.0]
        );
        let single = TimeFunction::Table { t: alloc::vec![1.0], value: alloc::vec![5.0] };
        assert_eq!([0.0, 1.0, 2.0].map(|t| at(&single, t)), [5.0; 3]);
    }
}
