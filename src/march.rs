//! Marches one load case by any method and records what every method records.

use std::borrow::{Borrow, BorrowMut};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use rom_generator::reference::method::{Output, Run};
use rom_runtime::loads::LoadCase;
use rom_runtime::{
    ErrorEstimate, Integrator, Ledger, Model, PointMotion, PointOutput, Reaction, RigidOutput, SectionForces,
    SensorReading, Settings, Simulation, StepError,
};
use serde_json::{Map, Value};

use crate::interrupt;
use crate::results::{
    ChannelSpec, LEDGER, MOTION, REACTION, Results, error_channels, point_channels, point_motion_channels,
    section_channels, sensor_channels,
};
use crate::run::{ErrorSummary, Failure, Peaks, TimeGrid, Timing};

/// What to run on a reduced model.
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
    /// Whether to record their attitudes, velocities and accelerations too.
    pub point_motion: bool,
    /// Whether to record the rates of the modal amplitudes.
    pub rates: bool,
}

/// What to write down of a run.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Instants.
    pub grid: TimeGrid,
    /// Points to record: index in the run's list, and name.
    pub points: Vec<(usize, String)>,
    /// Whether to record the attitudes, velocities and accelerations of the points.
    pub point_motion: bool,
    /// Whether to record the rates of the amplitudes.
    pub rates: bool,
    /// Sensors to record: all of the run's first ones, by name.
    pub sensors: Vec<String>,
    /// Places whose section forces to record: all of the run's, by name.
    pub sections: Vec<String>,
    /// Numbers of the elastic modes whose amplitudes the run has.
    pub modes: Vec<u32>,
    /// Whether to record what the body does to what moves or holds frame A.
    pub reaction: bool,
    /// What to do when the numbers fail.
    pub help: &'static str,
}

/// Something that goes forward in time and tells where it is.
pub trait Marching {
    /// One step.
    ///
    /// # Errors
    /// Why it cannot be made, in words; the state is then the one before it.
    fn advance(&mut self) -> Result<(), String>;

    /// Motion of frame A.
    fn rigid(&self) -> RigidOutput;

    /// Modal amplitudes - (modes recorded).
    fn amplitudes(&self) -> &[f64];

    /// Their rates - (modes recorded); none for a method that does not tell them.
    fn rates(&self) -> &[f64] {
        &[]
    }

    /// A named point, or none where there is no such index.
    fn point(&self, index: usize) -> Option<PointOutput>;

    /// Attitude, velocities and accelerations of a named point, or none where there is no such index.
    fn point_motion(&self, index: usize) -> Option<PointMotion>;

    /// What a sensor reads, or none where the run has no such index.
    fn sensor(&self, index: usize) -> Option<SensorReading>;

    /// Section forces at the places of internal loads - (places).
    fn sections(&self) -> &[SectionForces];

    /// What the body does to what moves or holds frame A; none in free flight.
    fn reaction(&self) -> Option<Reaction>;

    /// Centre of mass, momenta and energies.
    fn ledger(&self) -> Ledger;

    /// Estimated errors so far; none where nothing estimates them.
    fn errors(&self) -> Option<ErrorEstimate>;
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
    /// Estimated errors, where there are any.
    pub errors: Option<ErrorSummary>,
}

/// Steps between two looks at what a reduced method leaves out.
pub const ERRORS_EVERY: u32 = 12;

/// Steps between two words to `progress`.
const REPORT_EVERY: u64 = 64;

/// What to do when a reduced model fails.
pub const HELP_REDUCED: &str = "The results until then are written. Look at them for what grows; take a shorter --dt or \
    smaller loads, or build the model with --inertia consistent --elastic geometric: without, it holds for small elastic \
    displacements and rates.";

impl Job<'_> {
    /// Whether the job can be started.
    ///
    /// # Errors
    /// Settings or loads that do not fit the model, in words.
    pub fn check(&self) -> Result<(), String> {
        self.start().map(|_| ())
    }

    fn start(&self) -> Result<impl Marching, String> {
        let settings = Settings {
            dt: self.grid.dt,
            integrator: self.integrator,
            numerical_damping: self.numerical_damping,
            ..Settings::default()
        };
        let loads = self.model.prepare(self.case).map_err(|e| e.to_string())?;
        let start = self.model.initial_state(self.case).map_err(|e| e.to_string())?;
        let mut simulation = Simulation::new(Arc::clone(self.model), settings).map_err(|e| e.to_string())?;
        simulation.restore(&start).map_err(|e| e.to_string())?;
        simulation.watch_errors(ERRORS_EVERY);
        // Solves the accelerations at the start, too.
        simulation.find_section_forces(&loads).map_err(|e| e.to_string())?;
        // RK4 leaves no accelerations behind: they cost an evaluation more per step.
        let solve = self.point_motion || !self.model.data().sensors.is_empty();
        let sections = !self.model.data().cuts.is_empty();
        let (grid, mut steps) = (self.grid, 0);
        Ok(Reduced::new(simulation, move |simulation: &mut Simulation| {
            simulation.step(&loads)?;
            steps += 1;
            if sections && grid.is_written(steps) {
                simulation.find_section_forces(&loads)?;
            }
            if solve { simulation.solve_accelerations(&loads) } else { Ok(()) }
        }))
    }

    /// Whether something moves or holds frame A.
    pub fn is_driven(&self) -> bool {
        self.case.motion.is_some() || self.model.is_clamped()
    }

    fn recording(&self) -> Recording {
        let data = self.model.data();
        Recording {
            grid: self.grid,
            points: self.points.iter().map(|&i| (i, data.points[i].name.clone())).collect(),
            point_motion: self.point_motion,
            rates: self.rates,
            sensors: data.sensors.iter().map(|sensor| sensor.name.clone()).collect(),
            sections: self.model.section_names().map(String::from).collect(),
            modes: data.modes.number.clone(),
            reaction: self.is_driven(),
            help: HELP_REDUCED,
        }
    }
}

/// Runs a job from where its load case starts; `progress` is told the number of steps made so far and shown the run. A run whose
/// numbers fail is an outcome too: it holds the results until then.
///
/// # Errors
/// When the job cannot be started, see [`Job::check`].
pub fn march(
    job: &Job,
    metadata: Map<String, Value>,
    progress: impl FnMut(u64, &dyn Marching),
) -> Result<Outcome, String> {
    Ok(record(&mut job.start()?, &job.recording(), metadata, progress))
}

/// Marches to the end of the grid, or until the numbers fail or Ctrl-C is pressed; `progress` is told the number of steps made so
/// far and shown the run.
pub fn record(
    run: &mut impl Marching,
    recording: &Recording,
    metadata: Map<String, Value>,
    mut progress: impl FnMut(u64, &dyn Marching),
) -> Outcome {
    let grid = &recording.grid;
    let mut recorder = Recorder::new(recording, metadata, run.errors().is_some());
    let start = Instant::now();
    recorder.see(run, 0);
    let (mut steps, mut failure) = (0, None);
    while steps < grid.steps {
        if interrupt::requested() {
            let (message, help) =
                (interrupt::MESSAGE.to_owned(), "The results until then are written.".to_owned());
            failure = Some(Failure { time: grid.time(steps), message, help });
            break;
        }
        if let Err(message) = run.advance() {
            failure = Some(Failure { time: grid.time(steps), message, help: recording.help.to_owned() });
            break;
        }
        steps += 1;
        recorder.see(run, steps);
        if steps.is_multiple_of(REPORT_EVERY) || steps == grid.steps {
            progress(steps, run);
        }
    }
    if failure.is_some() && !grid.is_written(steps) {
        recorder.write(run, steps);
    }
    let timing = Timing::new(steps, grid.dt, start.elapsed().as_secs_f64());
    let peaks = recorder.peaks.into_iter().collect();
    let errors = recorder.estimated;
    Outcome { results: recorder.results, peaks, steps, timing, failure, errors }
}

/// A reduced model, owned or borrowed, and how it makes a step: under a load case, or whatever a host applies.
pub struct Reduced<S, F> {
    simulation: S,
    step: F,
}

impl<S: Borrow<Simulation>, F> Reduced<S, F> {
    /// `step` is called once for every step.
    pub fn new(simulation: S, step: F) -> Self {
        Self { simulation, step }
    }
}

impl<S, F> Marching for Reduced<S, F>
where
    S: BorrowMut<Simulation>,
    F: FnMut(&mut Simulation) -> Result<(), StepError>,
{
    fn advance(&mut self) -> Result<(), String> {
        (self.step)(self.simulation.borrow_mut()).map_err(|e| e.to_string())
    }

    fn rigid(&self) -> RigidOutput {
        self.simulation.borrow().rigid_output()
    }

    fn amplitudes(&self) -> &[f64] {
        &self.simulation.borrow().state().q
    }

    fn rates(&self) -> &[f64] {
        &self.simulation.borrow().state().q_dot
    }

    fn point(&self, index: usize) -> Option<PointOutput> {
        self.simulation.borrow().point_output(index)
    }

    fn point_motion(&self, index: usize) -> Option<PointMotion> {
        self.simulation.borrow().point_motion(index)
    }

    fn sensor(&self, index: usize) -> Option<SensorReading> {
        self.simulation.borrow().sensor_reading(index)
    }

    fn sections(&self) -> &[SectionForces] {
        self.simulation.borrow().section_forces()
    }

    fn reaction(&self) -> Option<Reaction> {
        self.simulation.borrow().reaction()
    }

    fn ledger(&self) -> Ledger {
        self.simulation.borrow().ledger()
    }

    fn errors(&self) -> Option<ErrorEstimate> {
        self.simulation.borrow().error_estimate()
    }
}

/// A run of any method.
pub struct AnyMethod<'a> {
    run: Box<dyn Run + 'a>,
    output: Output,
}

impl<'a> AnyMethod<'a> {
    /// Where the run stands.
    pub fn new(run: Box<dyn Run + 'a>) -> Self {
        Self { output: run.output(), run }
    }

    /// Displacements of these nodes of the mesh in A since the equilibrium, m, node by node; empty for the reduced methods.
    pub fn node_displacements(&self, nodes: &[usize]) -> Vec<f64> {
        self.run.node_displacements(nodes).iter().flat_map(|d| [d.x, d.y, d.z]).collect()
    }

    /// Velocities of nodes in G, m/s - (nodes x 3).
    pub fn node_velocities(&self, nodes: &[usize]) -> Vec<f64> {
        self.run.node_velocities(nodes).iter().flat_map(|v| [v.x, v.y, v.z]).collect()
    }
}

impl Marching for AnyMethod<'_> {
    fn advance(&mut self) -> Result<(), String> {
        self.run.step()?;
        self.output = self.run.output();
        Ok(())
    }

    fn rigid(&self) -> RigidOutput {
        let frame = &self.output.frame;
        let q = frame.rotation.quaternion();
        RigidOutput {
            r_g: frame.position.into(),
            v_a: (frame.rotation.inverse() * frame.velocity).into(),
            w_a: frame.spin.into(),
            v_g: frame.velocity.into(),
            w_g: (frame.rotation * frame.spin).into(),
            zeta: [q.w, q.i, q.j, q.k],
        }
    }

    fn amplitudes(&self) -> &[f64] {
        &self.output.q
    }

    fn rates(&self) -> &[f64] {
        &self.output.q_dot
    }

    fn point(&self, index: usize) -> Option<PointOutput> {
        let (dr_a, r_g) = (self.output.dr_a.get(index)?, self.output.r_g.get(index)?);
        Some(PointOutput { dr_a: (*dr_a).into(), r_g: (*r_g).into() })
    }

    fn point_motion(&self, index: usize) -> Option<PointMotion> {
        self.output.motion.get(index).copied()
    }

    /// Only a model file has sensors.
    fn sensor(&self, _: usize) -> Option<SensorReading> {
        None
    }

    fn sections(&self) -> &[SectionForces] {
        &self.output.sections
    }

    fn reaction(&self) -> Option<Reaction> {
        self.output.reaction
    }

    fn ledger(&self) -> Ledger {
        let totals = &self.output.totals;
        Ledger {
            r_cm_g: totals.centre_of_mass.into(),
            linear_momentum_g: totals.linear_momentum.into(),
            angular_momentum_g: totals.angular_momentum.into(),
            kinetic_energy: totals.kinetic_energy,
            elastic_energy: totals.elastic_energy,
            gravity_energy: totals.gravity_energy,
        }
    }

    fn errors(&self) -> Option<ErrorEstimate> {
        self.output.errors
    }
}

/// Turns states into rows.
struct Recorder<'a> {
    recording: &'a Recording,
    results: Results,
    motion: Vec<usize>,
    /// None where there are no amplitudes to write.
    modal: Option<usize>,
    rates: Option<usize>,
    ledger: Vec<usize>,
    /// `error_indicator` and `predicted_error`, where errors are estimated.
    errors: Option<[usize; 2]>,
    estimated: Option<ErrorSummary>,
    /// Channels `P.dR_A` and `P.R_G` of each recorded point.
    points: Vec<[usize; 2]>,
    /// Channels of the motion of each recorded point, where asked for, and of each sensor.
    motions: Vec<[usize; 5]>,
    sensors: Vec<[usize; 3]>,
    /// Channels of the section forces at each place.
    sections: Vec<Vec<usize>>,
    reaction: Option<[usize; 4]>,
    /// Channel and extremes of `v_G`, `w_G`, then of the recorded points.
    peaks: Vec<(String, Peaks)>,
}

impl<'a> Recorder<'a> {
    fn new(recording: &'a Recording, metadata: Map<String, Value>, estimates: bool) -> Self {
        let rows = usize::try_from(recording.grid.rows()).unwrap_or(0);
        let mut results = Results::new(metadata);
        let mut add = |spec: &ChannelSpec| results.add(spec, rows);
        let motion = MOTION.map(|spec| add(&spec.into())).to_vec();
        let numbers = &recording.modes;
        let modal = (!numbers.is_empty()).then(|| add(&ChannelSpec::modal(numbers)));
        let rates = (recording.rates && modal.is_some()).then(|| add(&ChannelSpec::modal_rates(numbers)));
        let names = recording.points.iter().map(|(_, name)| name.as_str());
        let points = names.clone().map(|name| point_channels(name).map(|spec| add(&spec))).collect();
        let moving = names.clone().filter(|_| recording.point_motion);
        let motions = moving.map(|name| point_motion_channels(name).map(|spec| add(&spec))).collect();
        let sensors = recording.sensors.iter();
        let sensors = sensors.map(|name| sensor_channels(name).map(|spec| add(&spec))).collect();
        let reduced = !recording.modes.is_empty();
        let sections = recording.sections.iter();
        let sections =
            sections.map(|name| section_channels(name, reduced).iter().map(&mut add).collect()).collect();
        let reaction = recording.reaction.then(|| REACTION.map(|spec| add(&spec.into())));
        let ledger = LEDGER.map(|spec| add(&spec.into())).to_vec();
        let errors = estimates.then(|| error_channels().map(|spec| add(&spec)));
        let watched = ["v_G", "w_G"].map(String::from).into_iter().chain(names.map(|n| format!("{n}.dR_A")));
        let peaks = watched.map(|name| (name, Peaks::new(3))).collect();
        Self {
            recording,
            results,
            motion,
            modal,
            rates,
            ledger,
            errors,
            estimated: None,
            points,
            motions,
            sensors,
            sections,
            reaction,
            peaks,
        }
    }

    /// Takes in the state after `step` steps.
    fn see(&mut self, run: &impl Marching, step: u64) {
        let (grid, rigid) = (&self.recording.grid, run.rigid());
        let points = self.recording.points.iter().filter_map(|&(point, _)| Some(run.point(point)?.dr_a));
        let vectors = [rigid.v_g, rigid.w_g].into_iter().chain(points);
        for ((_, peaks), vector) in self.peaks.iter_mut().zip(vectors) {
            peaks.see(grid.time(step), &vector);
        }
        if let Some(estimate) = run.errors() {
            self.estimated.get_or_insert_default().see(grid.time(step), &estimate);
        }
        if grid.is_written(step) {
            self.write(run, step);
        }
    }

    /// Writes the row after `step` steps.
    fn write(&mut self, run: &impl Marching, step: u64) {
        let rigid = run.rigid();
        let t = [self.recording.grid.time(step)];
        let motion: [&[f64]; 7] =
            [&t, &rigid.r_g, &rigid.v_g, &rigid.w_g, &rigid.v_a, &rigid.w_a, &rigid.zeta];
        for (&channel, row) in self.motion.iter().zip(motion) {
            self.results.push(channel, row);
        }
        if let Some(channel) = self.modal {
            self.results.push(channel, run.amplitudes());
        }
        if let Some(channel) = self.rates {
            self.results.push(channel, run.rates());
        }
        for ((point, _), channels) in self.recording.points.iter().zip(&self.points) {
            if let Some(output) = run.point(*point) {
                self.results.push(channels[0], &output.dr_a);
                self.results.push(channels[1], &output.r_g);
            }
        }
        for ((point, _), channels) in self.recording.points.iter().zip(&self.motions) {
            if let Some(PointMotion { attitude, v_g, w_g, a_g, alpha_g }) = run.point_motion(*point) {
                let values: [&[f64]; 5] = [&attitude, &v_g, &w_g, &a_g, &alpha_g];
                channels.iter().zip(values).for_each(|(&channel, row)| self.results.push(channel, row));
            }
        }
        for (index, channels) in self.sensors.iter().enumerate() {
            if let Some(SensorReading { a, w, alpha }) = run.sensor(index) {
                let values = [a, w, alpha];
                channels.iter().zip(values).for_each(|(&channel, row)| self.results.push(channel, &row));
            }
        }
        for (channels, SectionForces { best, by_modes }) in self.sections.iter().zip(run.sections()) {
            let values = [best, by_modes].into_iter().flat_map(|s| s.chunks_exact(3));
            channels.iter().zip(values).for_each(|(&channel, row)| self.results.push(channel, row));
        }
        if let (Some([indicator, predicted]), Some(estimate)) = (self.errors, run.errors()) {
            self.results.push(indicator, &[estimate.indicator()]);
            self.results.push(predicted, &[estimate.v_g, estimate.w_g, estimate.dr_a]);
        }
        if let (Some(channels), Some(reaction)) = (&self.reaction, run.reaction()) {
            let values = [reaction.total(), reaction.inertia, reaction.loads, reaction.increment];
            channels.iter().zip(values).for_each(|(&channel, row)| self.results.push(channel, &row));
        }
        let ledger = run.ledger();
        let (kinetic, elastic, gravity) =
            ([ledger.kinetic_energy], [ledger.elastic_energy], [ledger.gravity_energy]);
        let values: [&[f64]; 6] = [
            &ledger.r_cm_g,
            &ledger.linear_momentum_g,
            &ledger.angular_momentum_g,
            &kinetic,
            &elastic,
            &gravity,
        ];
        for (&channel, row) in self.ledger.iter().zip(values) {
            self.results.push(channel, row);
        }
    }
}
