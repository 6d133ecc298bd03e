//! Many runs: every method at every sweep point, on all cores.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rom_generator::build::ModeSelection;
use rom_generator::mesh::{Cut, Member, Mesh};
use rom_generator::reference::method::Method;

use super::norms::largest;
use super::report::MOST_OVERLAYS;
use super::setup::Setup;
use crate::atomic;
use crate::failure::Failure;
use crate::files::{self, Shown};
use crate::interrupt;
use crate::parallel;
use crate::results::Results;
use crate::run::{Failure as Stop, Summary, Timing};
use crate::scene::Scene;
use crate::vtk::{self, Along, Place};

/// What to run.
#[derive(Debug)]
pub struct Study {
    /// One per load case and choice of parameters.
    pub settings: Vec<Setting>,
    /// The first is the one the others are measured against.
    pub methods: Vec<Method>,
    /// Modes of the reduced methods; several for a sweep over their number.
    pub modes: Vec<ModeSelection>,
    /// Where to write what, if anything is to be written.
    pub output: Option<Output>,
    /// Tool and version, for the files.
    pub tool: String,
}

/// A choice of parameters under a load case.
#[derive(Debug)]
pub struct Setting {
    /// Swept parameters and their values as given.
    pub swept: Vec<(String, String)>,
    /// All parameters that were set, swept ones included, with their values.
    pub set: Vec<(String, f64)>,
    /// What to run.
    pub setup: Setup,
    /// Folder of its runs below that of the study; empty: the same.
    pub folder: PathBuf,
}

/// What to write.
#[derive(Debug)]
pub struct Output {
    /// Folder of the study.
    pub folder: PathBuf,
    /// Write a report of each run.
    pub reports: bool,
    /// Write the plots of the reports as SVG files.
    pub svg: bool,
    /// Write the motions for ParaView, of at most so many instants.
    pub vtk: Option<usize>,
    /// The command, as it would be typed.
    pub command: String,
}

/// One run to make. The finite-element methods and the rigid body do not depend on the modes: they are run once for all of
/// them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Unit {
    /// Index of the setting.
    pub setting: usize,
    /// Method.
    pub method: Method,
    /// Index of the modes, for methods that have any.
    pub modes: Option<usize>,
}

/// What is kept of a run.
#[derive(Debug)]
pub struct Finished {
    /// `t`, `v_G`, `w_G` and the `dR_A` of all points, at every step.
    pub results: Results,
    /// Below these lengths `v_G`, `w_G` and each `P.dR_A` are zero but for round-off.
    pub floors: BTreeMap<String, f64>,
    /// Why it ended early, if it did.
    pub failure: Option<Stop>,
    /// Figures of the run.
    pub summary: Summary,
    /// Speed.
    pub timing: Timing,
    /// Number of elastic modes it had.
    pub modes: usize,
    /// Its motion in space, where there is a report to show it.
    pub scene: Option<Scene>,
}

/// A run, or why it could not start.
pub type Outcome = Result<Finished, String>;

impl Study {
    /// All runs to make, in a fixed order.
    pub fn units(&self) -> Vec<Unit> {
        let mut units = Vec::new();
        for setting in 0..self.settings.len() {
            for &method in &self.methods {
                if depends_on_modes(method) {
                    units.extend((0..self.modes.len()).map(|m| Unit { setting, method, modes: Some(m) }));
                } else {
                    units.push(Unit { setting, method, modes: None });
                }
            }
        }
        units
    }

    /// Makes all runs; `progress` is told how many steps have been made since it was told last.
    ///
    /// # Errors
    /// Those of writing files. A run that fails is an outcome.
    pub fn run(&self, progress: &(impl Fn(u64) + Sync)) -> Result<BTreeMap<Unit, Outcome>, Failure> {
        let units = self.units();
        let outcomes = parallel::map(&units, |&unit| self.run_unit(unit, progress));
        units.into_iter().zip(outcomes).map(|(unit, outcome)| Ok((unit, outcome?))).collect()
    }

    fn run_unit(&self, unit: Unit, progress: &impl Fn(u64)) -> Result<Outcome, Failure> {
        let setting = &self.settings[unit.setting];
        let modes = &self.modes[unit.modes.unwrap_or(0)];
        let setup = &setting.setup;
        if interrupt::requested() {
            return Ok(Err(interrupt::MESSAGE.to_owned()));
        }
        let mut told = 0;
        let mut advance = |steps: u64| {
            progress(steps - told);
            told = steps;
        };
        let filmed = self.output.as_ref().is_some_and(|output| output.reports || output.vtk.is_some());
        let outcome = setup.run_filmed(unit.method, modes, &self.tool, filmed, &mut advance);
        // The bar counts steps that will not be made too.
        advance(setup.grid.steps);
        let (mut outcome, scene) = match outcome {
            Ok(outcome) => outcome,
            Err(reason) => return Ok(Err(reason)),
        };
        let count = outcome.results.channel("q").map_or(0, |q| q.width());
        let (failure, timing) = (outcome.failure.clone(), outcome.timing);
        let compared = |name: &str| matches!(name, "t" | "v_G" | "w_G") || name.ends_with(".dR_A");
        let floors = floors(&outcome.results, setup);
        let kept = outcome.results.clone().only(compared);
        let command = self.output.as_ref().map_or("", |o| &o.command);
        let facts = setup.facts(unit.method, &modes_in_words(modes), command, &self.tool);
        let summary = match &self.output {
            None => files::summary(&facts, &outcome),
            Some(output) => {
                let folder = output.folder.join(self.folder(unit));
                let vtk = match (output.vtk, &scene) {
                    (Some(frames), Some(scene)) => {
                        atomic::make_folder(&folder)?;
                        vtk::write_film(scene, &along(&setup.mesh), &outcome.results, frames, &folder)?
                    }
                    _ => None,
                };
                outcome.results = outcome.results.thinned(|row| setup.grid.is_written(row as u64));
                let shown = Shown { report: output.reports, svg: output.svg, scene: scene.clone(), vtk };
                files::write(&facts, outcome, &folder, shown)?
            }
        };
        // Long sweeps show the motions in the reports of the runs alone.
        let scene = scene.filter(|_| self.settings.len() * self.modes.len() <= MOST_OVERLAYS);
        Ok(Ok(Finished { results: kept, floors, failure, summary, timing, modes: count, scene }))
    }

    /// Folder of a run below that of the study: the setting's, one for the number of modes where that is swept, and one for
    /// the method where there are several.
    pub fn folder(&self, unit: Unit) -> PathBuf {
        let mut folder = self.settings[unit.setting].folder.clone();
        if let (Some(m), true) = (unit.modes, self.modes.len() > 1) {
            folder.push(format!("modes={}", modes_in_words(&self.modes[m])));
        }
        if self.methods.len() > 1 {
            folder.push(unit.method.name());
        }
        folder
    }
}

/// Where the structure tells internal loads; lines are its members.
fn along(mesh: &Mesh) -> Along {
    let place = |cut: &Cut| Place { name: cut.name.clone(), line: cut.member, fraction: cut.fraction };
    let knots = |member: &Member| {
        let lengths = mesh.elements[member.elements.clone()].iter().map(|element| element.length);
        let ends: Vec<f64> = std::iter::once(0.0)
            .chain(lengths)
            .scan(0.0, |end, l| {
                *end += l;
                Some(*end)
            })
            .collect();
        let length = ends.last().copied().unwrap_or(1.0);
        ends.into_iter().map(|end| end / length).collect()
    };
    Along { places: mesh.cuts.iter().map(place).collect(), knots: mesh.members.iter().map(knots).collect() }
}

fn depends_on_modes(method: Method) -> bool {
    method.is_reduced() && method != Method::Rigid
}

/// As `--modes` would be given.
pub fn modes_in_words(modes: &ModeSelection) -> String {
    match modes {
        ModeSelection::Count(n) => n.to_string(),
        ModeSelection::List(list) => list.iter().map(usize::to_string).collect::<Vec<_>>().join(","),
        ModeSelection::Below(omega) => format!("{omega}rad/s"),
    }
}

/// What is zero but for round-off: velocities against the fastest motion there is in the run, displacements against the
/// distances they are differences of.
pub fn floors(results: &Results, setup: &Setup) -> BTreeMap<String, f64> {
    const SOLVED: f64 = 1e-9;
    const ROUND_OFF: f64 = 1e-12;
    let extent = setup.mesh.nodes.iter().map(|r| r.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let length = |name: &str| results.channel(name).map_or(0.0, largest);
    let speed = length("v_G") + extent * length("w_G");
    let mut floors =
        BTreeMap::from([("v_G".to_owned(), SOLVED * speed), ("w_G".to_owned(), SOLVED * speed / extent)]);
    for (_, point) in &setup.points {
        floors.insert(format!("{point}.dR_A"), ROUND_OFF * (extent + length(&format!("{point}.R_G"))));
    }
    floors
}
