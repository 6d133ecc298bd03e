//! The instants of a run.

use std::fmt;

/// `t = 0, dt, 2 dt, ...` up to the first instant at or beyond `t_end`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeGrid {
    /// Time step, s.
    pub dt: f64,
    /// End asked for, s.
    pub t_end: f64,
    /// Number of steps.
    pub steps: u64,
    /// Every how many steps a row is written.
    pub every: u64,
}

/// Settings that make no grid.
#[derive(Clone, Debug, PartialEq)]
pub struct GridError {
    /// What is wrong, with the value found.
    pub message: String,
    /// What to do.
    pub help: String,
}

/// More steps than anyone waits for; a slip of the decimal point is far likelier.
const MOST_STEPS: f64 = 1e11;

impl TimeGrid {
    /// The grid, if `dt`, `t_end` and `every` make sense.
    ///
    /// # Errors
    /// For a step or an end that is not positive and finite, for `every = 0`, and for absurdly many steps.
    pub fn new(dt: f64, t_end: f64, every: u64) -> Result<Self, GridError> {
        let refuse = |message: String, help: &str| Err(GridError { message, help: help.to_owned() });
        if !(dt.is_finite() && dt > 0.0) {
            return refuse(format!("the time step is {dt} s"), "give a positive one: --dt 0.01");
        }
        if !(t_end.is_finite() && t_end > 0.0) {
            return refuse(format!("the run ends at {t_end} s"), "give a positive end: --t-end 10");
        }
        if every == 0 {
            return refuse("--every 0 would write nothing".to_owned(), "--every 1 writes every step");
        }
        let ratio = t_end / dt;
        if ratio > MOST_STEPS {
            return refuse(
                format!("{t_end} s in steps of {dt} s are {ratio:.1e} steps"),
                "take a larger --dt or a smaller --t-end",
            );
        }
        // A quotient such as 10 / 0.01 misses its whole number by round-off only; that is no step more.
        let nearest = ratio.round().max(1.0);
        let steps = if (ratio - nearest).abs() <= 1e-9 * nearest { nearest } else { ratio.ceil() };
        Ok(Self { dt, t_end, steps: steps as u64, every })
    }

    /// Time after `step` steps, s: a product, so that it does not drift.
    pub fn time(&self, step: u64) -> f64 {
        step as f64 * self.dt
    }

    /// Whether the state after `step` steps is written: every `every`-th one and the last.
    pub fn is_written(&self, step: u64) -> bool {
        step.is_multiple_of(self.every) || step == self.steps
    }

    /// Number of rows written, the initial state included.
    pub fn rows(&self) -> u64 {
        1 + self.steps.div_ceil(self.every)
    }
}

/// Says what happens where the end is not a whole number of steps; empty otherwise.
impl fmt::Display for TimeGrid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (last, dt, t_end) = (self.time(self.steps), self.dt, self.t_end);
        if (last - t_end).abs() > 1e-9 * t_end {
            write!(f, "{t_end} s is not a whole number of steps of {dt} s: the run ends at {last} s")?;
        }
        Ok(())
    }
}
