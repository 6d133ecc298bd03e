//! Choice of modes and options for a reduced model that is to meet an error in given load cases (docs/validation.md).
//!
//! Each load case is run once on the nonlinear structure and once on a model with many modes, whose motion tells what every mode
//! contributes. Modes are taken in the order of their contributions until the model, run against the nonlinear reference, meets the
//! target; then those that turn out not to be needed are left again.

mod contributions;
mod report;

pub use report::report;

use std::collections::BTreeMap;
use std::sync::Arc;

use rom_generator::ResidualSelection;
use rom_generator::build::{BuildOptions, Elastic, Inertia, ModeSelection, build_mesh, provenance};
use rom_generator::reference::method::Method;
use rom_runtime::Model;
use rom_runtime::data::{ModelData, SelectionChoice, SelectionData};

use crate::march::Outcome;
use crate::parallel;
use crate::validate::norms::relative_error;
use crate::validate::{Setup, floors};
use contributions::{Contribution, contributions};

/// Most modes looked at.
pub const POOL: usize = 30;
/// Modes added without getting nearer to the target before no more are.
const PATIENCE: usize = 4;

/// What is asked for.
#[derive(Clone, Debug)]
pub struct Goal {
    /// Largest relative error of `v_G`, `w_G` and the displacements of the named points, as a fraction.
    pub error: f64,
    /// The load cases, ready to run.
    pub setups: Vec<Setup>,
    /// Whether to keep the mode shapes at every node.
    pub all_nodes: bool,
}

/// Modes and options.
#[derive(Clone, Debug, PartialEq)]
struct Candidate {
    /// Numbers, ascending.
    modes: Vec<usize>,
    residual: ResidualSelection,
    dynamics: Dynamics,
}

/// Mass matrix and elastic forces.
type Dynamics = (Inertia, Elastic);

/// From the cheapest step to the dearest.
const DYNAMICS: [Dynamics; 3] = [
    (Inertia::Constant, Elastic::Linear),
    (Inertia::Consistent, Elastic::Linear),
    (Inertia::Consistent, Elastic::Geometric),
];

/// A candidate that was built and run.
struct Tried {
    candidate: Candidate,
    data: ModelData,
    errors: Errors,
}

/// Relative errors by load case and quantity; infinite where a run fails.
type Errors = Vec<(String, f64)>;

/// The model that was found.
#[derive(Clone, Debug)]
pub struct Found {
    /// Contents of the model file, the selection among them.
    pub data: ModelData,
    /// Its modes.
    pub modes: Vec<usize>,
    /// Whether it meets the target.
    pub meets: bool,
}

/// Finds the smallest model that meets the goal, or the best there is. `progress` is told what is being done.
///
/// # Errors
/// A reference that fails, a structure that cannot be reduced; in words.
pub fn select(goal: &Goal, progress: &(dyn Fn(&str) + Sync)) -> Result<Found, String> {
    let search = Search::new(goal, progress)?;
    let available = search.available;
    let all: Vec<usize> = (1..=available.min(POOL)).collect();
    progress("running many modes");
    let many = Candidate { modes: all, residual: ResidualSelection::None, dynamics: DYNAMICS[0] };
    let (many, runs) = search.run(&many)?;
    let mut ranking = contributions(&many.data, &runs, &search.goal.setups);
    ranking.sort_by(|a, b| b.share.total_cmp(&a.share).then(a.number.cmp(&b.number)));
    let mut choices = Vec::new();
    let mut best = search.grow(&ranking, &ResidualSelection::None, DYNAMICS[0])?;
    best = search.with_dynamics(&ranking, best, &mut choices)?;
    best = search.with_residual_modes(&ranking, best, &mut choices)?;
    let meets = worst(&best.errors) <= goal.error;
    choices.extend(mode_choices(&ranking, &best.candidate, goal.error));
    let mut data = best.data;
    data.selection = Some(SelectionData {
        target: goal.error,
        cases: goal.setups.iter().map(|setup| setup.case.name.clone()).collect(),
        errors: best.errors,
        choices,
    });
    Ok(Found { data, modes: best.candidate.modes, meets })
}

struct Search<'a> {
    goal: &'a Goal,
    progress: &'a (dyn Fn(&str) + Sync),
    references: Vec<(Outcome, BTreeMap<String, f64>)>,
    /// Elastic modes of the structure.
    available: usize,
}

impl<'a> Search<'a> {
    fn new(goal: &'a Goal, progress: &'a (dyn Fn(&str) + Sync)) -> Result<Self, String> {
        progress("running the nonlinear structure");
        let none = ModeSelection::Count(0);
        let run = |setup: &Setup| {
            let outcome = setup.run(Method::Nonlinear, &none, "romgen", |_| ())?;
            match &outcome.failure {
                None => {
                    let floors = floors(&outcome.results, setup);
                    Ok((outcome, floors))
                }
                Some(stop) => Err(format!(
                    "the nonlinear structure cannot be run in load case {}: at t = {} s {}",
                    setup.case.name, stop.time, stop.message
                )),
            }
        };
        let references = parallel::map(&goal.setups, run).into_iter().collect::<Result<_, String>>()?;
        let available = goal.setups.first().map_or(0, |setup| 6 * (setup.mesh.nodes.len() - 1));
        Ok(Self { goal, progress, references, available })
    }

    /// Builds a candidate and runs it in every load case.
    fn run(&self, candidate: &Candidate) -> Result<(Tried, Vec<Option<Outcome>>), String> {
        let setups = &self.goal.setups;
        let Some(first) = setups.first() else { return Err("no load case".to_owned()) };
        let options = BuildOptions {
            modes: ModeSelection::List(candidate.modes.clone()),
            residual: candidate.residual.clone(),
            all_nodes: self.goal.all_nodes,
            inertia: candidate.dynamics.0,
            elastic: candidate.dynamics.1,
        };
        let origin = provenance(&first.structure, &options, &first.mesh);
        let data = build_mesh(&first.mesh, origin, &options, &mut |_| ()).map_err(|e| e.to_string())?;
        let model = Arc::new(Model::new(data.clone()).map_err(|e| e.to_string())?);
        let runs =
            parallel::map(setups, |setup| setup.run_model(&model, Method::Rom, "romgen", false, |_| ()));
        let runs = runs.into_iter().collect::<Result<Vec<_>, _>>()?;
        let runs: Vec<_> = runs.into_iter().map(|(run, _)| run.failure.is_none().then_some(run)).collect();
        let errors = setups
            .iter()
            .zip(&self.references)
            .zip(&runs)
            .flat_map(|((setup, reference), run)| errors_of(setup, reference, run.as_ref()));
        let errors = errors.collect();
        Ok((Tried { candidate: candidate.clone(), data, errors }, runs))
    }

    /// The fewest modes, in the order of their contributions, that meet the target; else those after which more do not help.
    fn grow(
        &self,
        ranking: &[Contribution],
        residual: &ResidualSelection,
        dynamics: Dynamics,
    ) -> Result<Tried, String> {
        let tried = |n: usize| -> Result<Tried, String> {
            (self.progress)(&format!("trying {n} modes, inertia {}, elastic {}", dynamics.0, dynamics.1));
            let mut modes: Vec<usize> = ranking[..n].iter().map(|mode| mode.number).collect();
            modes.sort_unstable();
            Ok(self.run(&Candidate { modes, residual: residual.clone(), dynamics })?.0)
        };
        let target = self.goal.error;
        let start = ranking.iter().filter(|mode| mode.share > target / 3.0).count().clamp(1, ranking.len());
        let mut best = tried(start)?;
        let (mut n, mut in_vain) = (start, 0);
        while worst(&best.errors) > target && n < ranking.len() && in_vain < PATIENCE {
            n += 1;
            let next = tried(n)?;
            // Less than a twentieth better is truncation that does not matter beside what the equations leave out.
            in_vain = if worst(&next.errors) < 0.95 * worst(&best.errors) { 0 } else { in_vain + 1 };
            if worst(&next.errors) < worst(&best.errors) {
                best = next;
            }
        }
        n = best.candidate.modes.len();
        while n > 1 && worst(&best.errors) <= target {
            n -= 1;
            let fewer = tried(n)?;
            if worst(&fewer.errors) > target {
                break;
            }
            best = fewer;
        }
        Ok(best)
    }

    /// Better equations where those tried do not meet the target: the first that do, or the best.
    fn with_dynamics(
        &self,
        ranking: &[Contribution],
        mut best: Tried,
        choices: &mut Vec<SelectionChoice>,
    ) -> Result<Tried, String> {
        for dynamics in &DYNAMICS[1..] {
            let what = format!("inertia {}, elastic {}", dynamics.0, dynamics.1);
            let before = worst(&best.errors);
            if before <= self.goal.error {
                let why = "dearer, and the target is met without".to_owned();
                choices.push(SelectionChoice { what, taken: false, why });
                continue;
            }
            let next = match self.grow(ranking, &ResidualSelection::None, *dynamics) {
                Ok(next) => next,
                // A structure that these equations cannot be made for.
                Err(why) => {
                    choices.push(SelectionChoice { what, taken: false, why });
                    continue;
                }
            };
            let after = worst(&next.errors);
            let taken = after < before;
            let why = format!(
                "largest error {} with {} modes, {} without",
                report::percent(after),
                next.candidate.modes.len(),
                report::percent(before)
            );
            choices.push(SelectionChoice { what, taken, why });
            if taken {
                best = next;
            }
        }
        // Only what was taken last is in the model.
        let last = choices.iter().rposition(|choice| choice.taken);
        choices.iter_mut().enumerate().for_each(|(k, choice)| choice.taken = Some(k) == last);
        Ok(best)
    }

    /// Residual modes of the loaded points, where they save modes or reach what modes alone do not.
    fn with_residual_modes(
        &self,
        ranking: &[Contribution],
        plain: Tried,
        choices: &mut Vec<SelectionChoice>,
    ) -> Result<Tried, String> {
        let residual = self.loaded();
        if residual == ResidualSelection::None {
            return Ok(plain);
        }
        let corrected = self.grow(ranking, &residual, plain.candidate.dynamics)?;
        let (n, r) = (plain.data.modes.omega.len(), corrected.data.modes.omega.len());
        let (without, with) = (worst(&plain.errors), worst(&corrected.errors));
        let target = self.goal.error;
        let take = match (without <= target, with <= target) {
            (true, true) => r < n,
            (true, false) => false,
            (false, true) => true,
            (false, false) => with < 0.9 * without,
        };
        choices.push(SelectionChoice {
            what: "residual modes of the loaded points".to_owned(),
            taken: take,
            why: format!(
                "largest error {} with {r} modes in all, {} with {n} modes and none of them",
                report::percent(with),
                report::percent(without)
            ),
        });
        Ok(if take { corrected } else { plain })
    }

    /// Points that carry loads in the cases, by name.
    fn loaded(&self) -> ResidualSelection {
        let mut names = Vec::new();
        for setup in &self.goal.setups {
            for load in &setup.case.loads {
                let name = &setup.mesh.points[load.point as usize].name;
                if !names.contains(name) {
                    names.push(name.clone());
                }
            }
        }
        if names.is_empty() { ResidualSelection::None } else { ResidualSelection::Points(names) }
    }
}

/// The largest of the errors.
fn worst(errors: &Errors) -> f64 {
    // Spelt so that a NaN counts as large.
    errors.iter().fold(0.0, |worst, (_, error)| if *error <= worst { worst } else { *error })
}

fn errors_of(setup: &Setup, reference: &(Outcome, BTreeMap<String, f64>), run: Option<&Outcome>) -> Errors {
    let (reference, floors) = reference;
    let points = setup.points.iter().map(|(_, name)| format!("{name}.dR_A"));
    let names = ["v_G", "w_G"].map(String::from).into_iter().chain(points);
    let error = |name: String| {
        let floor = floors.get(&name).copied().unwrap_or(0.0);
        let error = match run {
            None => Some(f64::INFINITY),
            Some(run) => {
                relative_error(run.results.channel(&name)?, reference.results.channel(&name)?, floor)
            }
        };
        Some((format!("{} {name}", setup.case.name), error?))
    };
    names.filter_map(error).collect()
}

/// Why each mode was taken or left; those that make next to nothing in one line.
fn mode_choices(ranking: &[Contribution], chosen: &Candidate, target: f64) -> Vec<SelectionChoice> {
    let told = |mode: &&Contribution| mode.share > 0.1 * target || chosen.modes.contains(&mode.number);
    let mut choices: Vec<SelectionChoice> = ranking
        .iter()
        .filter(told)
        .map(|mode| SelectionChoice {
            what: format!("mode {}", mode.number),
            taken: chosen.modes.contains(&mode.number),
            why: format!(
                "makes up to {} of {}; its peak generalised force over omega^2 {} of it, gyroscopic couplings at most {}",
                report::percent(mode.share),
                mode.of,
                report::percent(mode.driven),
                report::percent(mode.coupling)
            ),
        })
        .collect();
    let others = ranking.len() - choices.len();
    if others > 0 {
        choices.push(SelectionChoice {
            what: format!("{others} others of the lowest {}", ranking.len()),
            taken: false,
            why: format!("make less than {} each", report::percent(0.1 * target)),
        });
    }
    choices
}
