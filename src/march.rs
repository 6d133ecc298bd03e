//! Marches one load case of a reduced model and records what every method records.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use rom_runtime::loads::LoadCase;
use rom_runtime::{Integrator, Model, PreparedLoads, Settings, Simulation, StepError};
use serde_json::{Map, Value};

use crate::results::{ChannelSpec, LEDGER, MOTION, Results, point_channels};
use crate::run::{Failure, Peaks, TimeGrid, Timing};

/// What to run.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// The model.
    pub model: &'a Arc<Model>,
    /// Loads.
    pub case: &'a LoadCase,
    /// Instants.
    pub grid: TimeGrid,
    /// Integrator.
    pub integrator: Integrator,
    /// Numerical damping of the implicit ones.
    pub numerical_damping: f64,
    /// Indices of the points to record.
    pub points: Vec<usize>,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Rows at the instants of the grid, up to the last good one.
    pub results: Results,
    /// Extremes over all steps, of `v_G`, `w_G` and each `P.dR_A`, by channel.
    pub peaks: BTreeMap<String, Peaks>,
    /// Steps made.
    pub steps: u64,
    /// Speed.
    pub timing: Timing,
    /// Why it ended early, if it did.
    pub failure: Option<Failure>,
}

/// Steps between two words to `progress`.
const REPORT_EVERY: u64 = 4096;

impl Job<'_> {
    /// Whether the job can be started.
    ///
    /// # Errors
    /// Settings or loads that do not fit the model, in words.
    pub fn check(&self) -> Result<(), String> {
        self.start().map(|_| ())
    }

    fn start(&self) -> Result<(Simulation, PreparedLoads), String> {
        let settings = Settings {
            dt: self.grid.dt,
            integrator: self.integrator,
            numerical_damping: self.numerical_damping,
            ..Settings::default()
        };
        let loads = self.model.prepare(self.case).map_err(|e| e.to_string())?;
        let simulation = Simulation::new(Arc::clone(self.model), settings).map_err(|e| e.to_string())?;
        Ok((simulation, loads))
    }
}

/// Runs a job from rest; `progress` is told the number of steps made so far. A run whose numbers fail is an outcome
/// too: it holds the results until then.
///
/// # Errors
/// When the job cannot be started, see [`Job::check`].
pub fn march(
    job: &Job,
    metadata: Map<String, Value>,
    mut progress: impl FnMut(u64),
) -> Result<Outcome, String> {
    let (mut simulation, loads) = job.start()?;
    let mut recorder = Recorder::new(job, metadata);
    let start = Instant::now();
    recorder.see(job, &simulation, 0);
    let (mut steps, mut failure) = (0, None);
    while steps < job.grid.steps {
        if let Err(error) = simulation.step(&loads) {
            failure = Some(stopped(job.grid.time(steps), &error));
            break;
        }
        steps += 1;
        recorder.see(job, &simulation, steps);
        if steps.is_multiple_of(REPORT_EVERY) {
            progress(steps);
        }
    }
    if failure.is_some() && !job.grid.is_written(steps) {
        recorder.write(job, &simulation, steps);
    }
    let timing = Timing::new(steps, job.grid.dt, start.elapsed().as_secs_f64());
    let peaks = recorder.peaks.into_iter().collect();
    Ok(Outcome { results: recorder.results, peaks, steps, timing, failure })
}

fn stopped(time: f64, error: &StepError) -> Failure {
    let help = "The results until then are written. Look at them for what grows; take a shorter --dt, or smaller loads: \
        the reduced model holds for small elastic displacements.";
    Failure { time, message: error.to_string(), help: help.to_owned() }
}

/// Turns states into rows.
struct Recorder {
    results: Results,
    motion: Vec<usize>,
    /// None for a rigid body, which has no amplitudes to write.
    modal: Option<usize>,
    ledger: Vec<usize>,
    /// Channels `P.dR_A` and `P.R_G` of each recorded point.
    points: Vec<[usize; 2]>,
    /// Channel and extremes of `v_G`, `w_G`, then of the recorded points.
    peaks: Vec<(String, Peaks)>,
}

impl Recorder {
    fn new(job: &Job, metadata: Map<String, Value>) -> Self {
        let data = job.model.data();
        let rows = usize::try_from(job.grid.rows()).unwrap_or(0);
        let mut results = Results::new(metadata);
        let mut add = |spec: &ChannelSpec| results.add(spec, rows);
        let motion = MOTION.map(|spec| add(&spec.into())).to_vec();
        let numbers = &data.modes.number;
        let modal = (!numbers.is_empty()).then(|| add(&ChannelSpec::modal(numbers)));
        let point_names = job.points.iter().map(|&i| data.points[i].name.as_str());
        let points = point_names.clone().map(|name| point_channels(name).map(|spec| add(&spec))).collect();
        let ledger = LEDGER.map(|spec| add(&spec.into())).to_vec();
        let watched =
            ["v_G", "w_G"].map(String::from).into_iter().chain(point_names.map(|n| format!("{n}.dR_A")));
        let peaks = watched.map(|name| (name, Peaks::new(3))).collect();
        Self { results, motion, modal, ledger, points, peaks }
    }

    /// Takes in the state after `step` steps.
    fn see(&mut self, job: &Job, simulation: &Simulation, step: u64) {
        let (model, state, t) = (job.model, simulation.state(), job.grid.time(step));
        let rigid = model.rigid_output(state);
        let points = job.points.iter().filter_map(|&point| Some(model.point_output(state, point)?.dr_a));
        let vectors = [rigid.v_g, rigid.w_g].into_iter().chain(points);
        for ((_, peaks), vector) in self.peaks.iter_mut().zip(vectors) {
            peaks.see(t, &vector);
        }
        if job.grid.is_written(step) {
            self.write(job, simulation, step);
        }
    }

    /// Writes the row after `step` steps.
    fn write(&mut self, job: &Job, simulation: &Simulation, step: u64) {
        let (model, state) = (job.model, simulation.state());
        let rigid = model.rigid_output(state);
        let t = [job.grid.time(step)];
        let motion: [&[f64]; 7] =
            [&t, &rigid.r_g, &rigid.v_g, &rigid.w_g, &rigid.v_a, &rigid.w_a, &rigid.zeta];
        for (&channel, row) in self.motion.iter().zip(motion) {
            self.results.push(channel, row);
        }
        if let Some(channel) = self.modal {
            self.results.push(channel, &state.q);
        }
        for (&point, channels) in job.points.iter().zip(&self.points) {
            if let Some(output) = model.point_output(state, point) {
                self.results.push(channels[0], &output.dr_a);
                self.results.push(channels[1], &output.r_g);
            }
        }
        let ledger = model.ledger(state);
        let (kinetic, elastic) = ([ledger.kinetic_energy], [ledger.elastic_energy]);
        let values: [&[f64]; 5] =
            [&ledger.r_cm_g, &ledger.linear_momentum_g, &ledger.angular_momentum_g, &kinetic, &elastic];
        for (&channel, row) in self.ledger.iter().zip(values) {
            self.results.push(channel, row);
        }
    }
}
