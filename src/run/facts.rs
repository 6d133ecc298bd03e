//! What is known of a run besides its results.

use serde::Serialize;

use super::TimeGrid;

/// Who ran what, and how.
#[derive(Clone, Debug)]
pub struct RunFacts {
    /// Name of the structure.
    pub structure: String,
    /// The model or structure file, as given.
    pub file: String,
    /// Name of the load case.
    pub load_case: String,
    /// One line on it.
    pub description: String,
    /// Method: `rom`, `nonlinear`, ...
    pub method: String,
    /// Integrator by its name on the command line.
    pub integrator: String,
    /// Numerical damping of the integrator.
    pub numerical_damping: f64,
    /// Instants.
    pub grid: TimeGrid,
    /// The command, as it would be typed.
    pub command: String,
    /// Tool and version that ran it.
    pub tool: String,
    /// What is in the model, name and value, for the report.
    pub model: Vec<(String, String)>,
    /// Loads in words: point, frame, force, moment, time function.
    pub loads: Vec<[String; 5]>,
    /// The structure file, verbatim.
    pub input_text: String,
}

/// Why a run ended early.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    /// Time of the last state that is good, s.
    pub time: f64,
    /// What went wrong and where.
    pub message: String,
    /// What to do.
    pub help: String,
}

/// How fast it went.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Timing {
    /// Time on the clock for the steps, outputs included and writing excluded, s.
    pub wall_seconds: f64,
    /// Steps per second of it.
    pub steps_per_second: f64,
    /// Simulated time over time on the clock.
    pub real_time_factor: f64,
}

impl Timing {
    /// From the number of steps of `dt` and the time they took, both in seconds.
    pub fn new(steps: u64, dt: f64, wall_seconds: f64) -> Self {
        let wall_seconds = wall_seconds.max(1e-9);
        let steps_per_second = steps as f64 / wall_seconds;
        Self { wall_seconds, steps_per_second, real_time_factor: steps_per_second * dt }
    }
}
