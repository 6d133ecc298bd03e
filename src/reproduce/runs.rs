//! The runs the figures are made from.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rom_generator::build::ModeSelection;
use rom_generator::input::Structure;
use rom_generator::mesh::{Place, Point};
use rom_generator::reference::method::Method;

use crate::march::Outcome;
use crate::parallel;
use crate::published::{BEAM, FRAME};
use crate::results::{Channel, Results};
use crate::run::TimeGrid;
use crate::scene::Scene;
use crate::text::significant;
use crate::validate::Setup;

/// How much is computed.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Elements of the frame under load cases 1 and 2; the paper has 120.
    pub elements: usize,
    /// Elements of the frame on the spiral; the paper has 60.
    pub spiral_elements: usize,
    /// Stiffness parameters of load case 2.
    pub sigmas: Vec<f64>,
    /// Stiffness parameters of the spiral.
    pub spiral_sigmas: Vec<f64>,
    /// Numbers of elastic modes of Fig. 14.
    pub modes: Vec<usize>,
}

/// Modes of the mean-axes method: more change nothing.
const MEAN_AXES_MODES: usize = 40;
/// Stiffness of the spiral that is shown in space.
pub(super) const FILMED: f64 = 10.0;
/// Modes of the reduced model in Fig. 13.
pub(super) const MODES: usize = 10;

impl Plan {
    /// Everything as the paper has it.
    pub fn full() -> Self {
        let sigmas = [3, 4, 5, 6, 8, 10, 12, 15, 20, 30, 40, 50, 60, 80, 100, 200, 300, 500, 1000];
        let spiral = [3, 4, 5, 6, 7, 8, 10, 12, 15, 20, 25, 30, 40, 50, 70, 100];
        Self {
            elements: 120,
            spiral_elements: 60,
            sigmas: sigmas.map(f64::from).to_vec(),
            spiral_sigmas: spiral.map(f64::from).to_vec(),
            modes: (0..=20).collect(),
        }
    }

    /// Half the elements and a few sweep points.
    pub fn quick() -> Self {
        Self {
            elements: 60,
            spiral_elements: 60,
            sigmas: [3, 5, 10, 30, 50, 100, 1000].map(f64::from).to_vec(),
            spiral_sigmas: [4, 6, 10, 30, 50, 100].map(f64::from).to_vec(),
            modes: vec![0, 1, 2, 3, 4, 5, 6, 8, 10],
        }
    }

    fn jobs(&self) -> Result<Vec<Job>, String> {
        let mut jobs = Vec::new();
        // The longest first, so that the last ones fill the gaps.
        let frame = |sigma: f64, loads: &str| {
            setup(FRAME, &[("sigma", sigma), ("elements", self.elements as f64)], loads)
        };
        jobs.push(Job::new(LC1, with_all_nodes(frame(1.0, "lc1")?), Method::Nonlinear));
        for &sigma in &self.sigmas {
            for method in [Method::Nonlinear, Method::ConstantMass, Method::Linear, Method::MeanAxes] {
                jobs.push(Job::new(&lc2(sigma, method), only(frame(sigma, "lc2")?, "P"), method));
            }
        }
        for &sigma in &self.spiral_sigmas {
            let frame = only(
                setup(FRAME, &[("sigma", sigma), ("elements", self.spiral_elements as f64)], "spiral")?,
                "Q",
            );
            for method in [Method::Nonlinear, Method::Linear, Method::MeanAxes] {
                let job = Job::new(&spiral(sigma, method), frame.clone(), method);
                jobs.push(Job { film: sigma == FILMED, ..job });
            }
        }
        let rigid = only(setup(FRAME, &[("elements", self.spiral_elements as f64)], "spiral")?, "Q");
        jobs.push(Job { film: true, ..Job::new(SPIRAL_RIGID, rigid, Method::Rigid) });
        jobs.extend(beam_jobs()?);
        for &modes in &self.modes {
            let job = Job::new(&reduced(modes), only(frame(10.0, "lc2")?, "P"), Method::Rom);
            jobs.push(Job { modes, ..job });
        }
        Ok(jobs)
    }

    /// Number of time steps of all runs.
    ///
    /// # Errors
    /// A defect: the embedded structures are not read.
    pub fn steps(&self) -> Result<u64, String> {
        Ok(self.jobs()?.iter().map(|job| job.setup.grid.steps).sum())
    }

    /// Makes all runs on all cores; `progress` is told the number of steps made since it was told last.
    ///
    /// # Errors
    /// A defect: the embedded structures are not read.
    pub fn run(&self, tool: &str, progress: &(impl Fn(u64) + Sync)) -> Result<Runs, String> {
        let jobs = self.jobs()?;
        let outcomes = parallel::map(&jobs, |job| {
            let mut told = 0;
            let mut advance = |steps: u64| {
                progress(steps - told);
                told = steps;
            };
            let modes = ModeSelection::Count(job.modes);
            let outcome = job.setup.run_filmed(job.method, &modes, tool, job.film, &mut advance);
            // The bar counts steps that will not be made too.
            advance(job.setup.grid.steps);
            outcome
        });
        Ok(Runs(jobs.into_iter().map(|job| job.name).zip(outcomes).collect()))
    }
}

/// The beam of section 4.1, planar and spatial, with the meshes and steps that are compared.
fn beam_jobs() -> Result<Vec<Job>, String> {
    let mut jobs = Vec::new();
    for (name, elements, loads, dt, t_end) in [
        (BEAM_LONG, 20, "spatial", 0.01, 50.0),
        (BEAM_FINE, 10, "planar", 0.005, 10.0),
        (BEAM_PLANAR, 10, "planar", 0.01, 10.0),
        (BEAM_COARSE_STEP, 10, "planar", 0.1, 10.0),
        (BEAM_10, 10, "spatial", 0.01, 6.5),
    ] {
        let mut setup = with_all_nodes(setup(BEAM, &[("elements", f64::from(elements))], loads)?);
        setup.grid = TimeGrid::new(dt, t_end, 1).map_err(|e| e.message)?;
        jobs.push(Job::new(name, setup, Method::Nonlinear));
    }
    Ok(jobs)
}

/// A run to make.
struct Job {
    name: String,
    setup: Setup,
    method: Method,
    modes: usize,
    /// Its motion in space is kept for a view.
    film: bool,
}

impl Job {
    fn new(name: &str, setup: Setup, method: Method) -> Self {
        Self { name: name.to_owned(), setup, method, modes: MEAN_AXES_MODES, film: false }
    }
}

pub(super) const LC1: &str = "lc1";
pub(super) const SPIRAL_RIGID: &str = "spiral rigid";
pub(super) const BEAM_LONG: &str = "spatial beam, 20 elements, dt = 0.01 s";
pub(super) const BEAM_10: &str = "spatial beam, 10 elements, dt = 0.01 s";
pub(super) const BEAM_PLANAR: &str = "planar beam, dt = 0.01 s";
pub(super) const BEAM_FINE: &str = "planar beam, dt = 0.005 s";
pub(super) const BEAM_COARSE_STEP: &str = "planar beam, dt = 0.1 s";

/// Name of a run of load case 2.
pub(super) fn lc2(sigma: f64, method: Method) -> String {
    format!("lc2 sigma = {sigma} {method}")
}

/// Name of a run of load case 2 at sigma = 10 with so many modes.
pub(super) fn reduced(modes: usize) -> String {
    format!("lc2 with {modes} modes")
}

/// Name of a run of the spiral.
pub(super) fn spiral(sigma: f64, method: Method) -> String {
    format!("spiral sigma = {sigma} {method}")
}

/// A published structure under one of its load cases.
pub(super) fn setup(text: &str, sets: &[(&str, f64)], loads: &str) -> Result<Setup, String> {
    let sets: Vec<(String, String)> = sets.iter().map(|(n, v)| ((*n).to_owned(), v.to_string())).collect();
    let structure = Structure::from_toml_str(text, "published structure", &sets)
        .map_err(|errors| errors.iter().map(|e| e.message().to_owned()).collect::<Vec<_>>().join("; "))?;
    let mesh = structure.mesh();
    let case = mesh.load_cases.iter().find(|case| case.name == loads).cloned();
    Setup::new(structure, mesh, case.ok_or_else(|| format!("no load case {loads}"))?)
}

/// Every node recorded, named by its number; the structure's own points are kept.
pub(super) fn with_all_nodes(mut setup: Setup) -> Setup {
    let nodes = (0..setup.mesh.nodes.len()).map(|node| Point {
        name: node_name(node),
        place: Place::Node(node),
        offset: Vector3::zeros(),
        sections: Vec::new(),
    });
    setup.mesh.points.extend(nodes);
    setup.points = setup.mesh.points.iter().map(|p| p.name.clone()).enumerate().collect();
    setup
}

fn only(mut setup: Setup, point: &str) -> Setup {
    setup.points.retain(|(_, name)| name == point);
    setup
}

pub(super) fn node_name(node: usize) -> String {
    format!("node {node}")
}

/// Runs by name, with their motion in space where it was kept.
pub struct Runs(BTreeMap<String, Result<(Outcome, Option<Scene>), String>>);

impl Runs {
    /// All channels of a run that went to its end.
    ///
    /// # Errors
    /// Why there are none, or not to the end, in words.
    pub fn get(&self, name: &str) -> Result<&Results, String> {
        match &self.outcome(name)?.failure {
            None => Ok(&self.outcome(name)?.results),
            Some(stop) => Err(format!("{name} stopped at t = {} s", significant(stop.time, 6))),
        }
    }

    /// All channels of a run as far as it went.
    ///
    /// # Errors
    /// Why there are none, in words.
    pub fn until_stop(&self, name: &str) -> Result<&Results, String> {
        Ok(&self.outcome(name)?.results)
    }

    fn outcome(&self, name: &str) -> Result<&Outcome, String> {
        match self.0.get(name) {
            None => Err(format!("{name} was not run")),
            Some(Err(reason)) => Err(format!("{name} did not start: {reason}")),
            Some(Ok((outcome, _))) => Ok(outcome),
        }
    }

    /// The filmed ones of these runs in one view.
    pub(super) fn in_space(&self, names: &[String]) -> Option<Scene> {
        let scene = |name: &String| self.0.get(name)?.as_ref().ok()?.1.clone();
        Scene::together(names.iter().filter_map(scene).collect())
    }

    /// One channel of a run.
    ///
    /// # Errors
    /// As [`Runs::get`].
    pub fn channel(&self, name: &str, channel: &str) -> Result<&Channel, String> {
        self.get(name)?.channel(channel).ok_or_else(|| format!("{name} has no channel {channel}"))
    }

    /// Why runs failed, by name.
    pub fn failures(&self) -> Vec<String> {
        let reason = |name: &String| match self.outcome(name) {
            Err(reason) => Some(reason),
            Ok(outcome) => {
                let stop = outcome.failure.as_ref()?;
                Some(format!("{name} stopped at t = {} s: {}", significant(stop.time, 6), stop.message))
            }
        };
        self.0.keys().filter_map(reason).collect()
    }

    /// Number of runs.
    pub fn count(&self) -> usize {
        self.0.len()
    }
}

/// Position of each node of `nodes` at time `t` in a run with all nodes recorded.
pub(super) fn shape(results: &Results, nodes: &[usize], t: f64) -> Vec<[f64; 3]> {
    let row = row_at(results, t);
    let place = |node: &usize| {
        let channel = results.channel(&format!("{}.R_G", node_name(*node)))?;
        let r = channel.row(row);
        Some([r[0], r[1], r[2]])
    };
    nodes.iter().filter_map(place).collect()
}

/// The row nearest to a time.
pub(super) fn row_at(results: &Results, t: f64) -> usize {
    let Some(times) = results.channel("t") else { return 0 };
    let distance = |i: &usize| (times.data[*i] - t).abs();
    (0..times.rows()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}

/// A quantity over sigma: what could be computed, and what could not.
pub(super) struct Swept {
    /// (sigma, value).
    pub values: Vec<(f64, f64)>,
    /// What is missing and why, to be put behind what was found; empty when nothing is.
    pub missing: String,
}

impl Swept {
    /// For each sigma that `keep` wants.
    ///
    /// # Errors
    /// When nothing could be computed: why.
    pub(super) fn new(
        sigmas: &[f64],
        keep: impl Fn(f64) -> bool,
        value: impl Fn(f64) -> Result<f64, String>,
    ) -> Result<Self, String> {
        let (mut values, mut reasons) = (Vec::new(), Vec::new());
        for &sigma in sigmas.iter().filter(|sigma| keep(**sigma)) {
            match value(sigma) {
                Ok(value) => values.push((sigma, value)),
                Err(reason) => reasons.push(reason),
            }
        }
        let missing =
            if reasons.is_empty() { String::new() } else { format!("; left out: {}", reasons.join(", ")) };
        if values.is_empty() { Err(reasons.join(", ")) } else { Ok(Self { values, missing }) }
    }

    /// Smallest and largest value.
    pub(super) fn range(&self) -> (f64, f64) {
        self.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (_, v)| (a.min(*v), b.max(*v)))
    }

    /// The value at a sigma.
    pub(super) fn at(&self, sigma: f64) -> Option<f64> {
        self.values.iter().find(|(s, _)| *s == sigma).map(|(_, v)| *v)
    }
}

/// Values for a plot over sigma: gaps where there is none.
pub(super) fn plotted(sigmas: &[f64], value: impl Fn(f64) -> Result<f64, String>) -> Vec<f64> {
    sigmas.iter().map(|&sigma| value(sigma).unwrap_or(f64::NAN)).collect()
}
