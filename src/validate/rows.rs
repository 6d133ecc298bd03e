//! The errors of a study as rows: for machines as JSON, for people as tables.

use std::collections::BTreeMap;

use rom_generator::build::ModeSelection;
use rom_generator::reference::method::Method;
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};

use super::norms::{largest, relative_error};
use super::study::{Finished, Outcome, Setting, Study, Unit};
use crate::run::Predicted;
use crate::text::significant;

/// One method at one sweep point, against the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Load case.
    pub loads: String,
    /// Parameters that were set, swept ones included.
    pub set: Map<String, Value>,
    /// Method.
    pub method: &'static str,
    /// Elastic modes of the reduced methods at this sweep point; none where a frequency limit selects them and no reduced
    /// method has run.
    pub modes: Option<usize>,
    /// The reference.
    pub against: &'static str,
    /// Relative error of `v_G`, `w_G` and each `P.dR_A` as a fraction; none where the reference is zero throughout, or where
    /// one of the two runs has failed.
    #[serde(serialize_with = "as_map")]
    pub errors: Vec<(String, Option<f64>)>,
    /// The worst `dR_A` of the compared points that move at least a tenth as far as the farthest of them, in the reference: what the
    /// estimate of a run is of.
    #[serde(rename = "worst_dR_A")]
    pub worst: Option<f64>,
    /// What the method itself estimates these errors at while it runs; of the displacements the worst.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predicted: Option<Predicted>,
    /// Why there are no errors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// Index of the setting and of the modes, for tables.
    #[serde(skip)]
    pub(super) at: (usize, usize),
}

fn as_map<S: Serializer>(errors: &[(String, Option<f64>)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(errors.iter().map(|(name, error)| (name, error)))
}

/// All rows, in the order of settings, modes and methods.
pub fn rows(study: &Study, runs: &BTreeMap<Unit, Outcome>) -> Vec<Row> {
    let Some((&reference, others)) = study.methods.split_first() else { return Vec::new() };
    let mut rows = Vec::new();
    for (s, setting) in study.settings.iter().enumerate() {
        for m in 0..study.modes.len() {
            let base = find(runs, s, reference, m);
            rows.extend(others.iter().map(|&method| {
                let (errors, failure) =
                    compare(setting, (method, find(runs, s, method, m)), (reference, base));
                let worst = base.and_then(|base| worst(base.as_ref().ok()?, &errors));
                Row {
                    loads: setting.setup.case.name.clone(),
                    set: set(setting),
                    method: method.name(),
                    modes: mode_count(study, runs, s, m),
                    against: reference.name(),
                    errors,
                    worst,
                    predicted: find(runs, s, method, m)
                        .and_then(|run| run.as_ref().ok()?.summary.errors)
                        .map(|errors| errors.predicted),
                    failure,
                    at: (s, m),
                }
            }));
        }
    }
    rows
}

/// Parameters with their values, and what is swept without being one.
fn set(setting: &Setting) -> Map<String, Value> {
    let parameters = setting.set.iter().map(|(name, value)| (name.clone(), Value::from(*value)));
    let others = setting.swept.iter().filter(|(name, _)| setting.set.iter().all(|(set, _)| set != name));
    parameters.chain(others.map(|(name, value)| (name.clone(), Value::from(value.as_str())))).collect()
}

/// The run of a method at a sweep point: its own for these modes, or the one for all modes.
pub(super) fn find(
    runs: &BTreeMap<Unit, Outcome>,
    setting: usize,
    method: Method,
    modes: usize,
) -> Option<&Outcome> {
    let unit = |modes| Unit { setting, method, modes };
    runs.get(&unit(Some(modes))).or_else(|| runs.get(&unit(None)))
}

fn mode_count(study: &Study, runs: &BTreeMap<Unit, Outcome>, setting: usize, modes: usize) -> Option<usize> {
    match &study.modes[modes] {
        ModeSelection::Count(n) => Some(*n),
        ModeSelection::List(list) => Some(list.len()),
        ModeSelection::Below(_) => {
            let run = |&method| find(runs, setting, method, modes)?.as_ref().ok();
            let reduced = study.methods.iter().filter(|m| matches!(m, Method::Rom | Method::MeanAxes));
            reduced.filter_map(run).map(|run| run.modes).next()
        }
    }
}

/// Errors of what is compared, or why there are none.
fn compare(
    setting: &Setting,
    (method, run): (Method, Option<&Outcome>),
    (reference, base): (Method, Option<&Outcome>),
) -> (Vec<(String, Option<f64>)>, Option<String>) {
    let names = compared(setting);
    let sound = [(method, run), (reference, base)].map(|(method, run)| match run {
        Some(Ok(run)) => match &run.failure {
            None => Ok(run),
            Some(stop) => {
                Err(format!("{method} stopped at t = {} s: {}", significant(stop.time, 6), stop.message))
            }
        },
        Some(Err(reason)) => Err(format!("{method} did not start: {reason}")),
        None => Err(format!("{method} was not run")),
    });
    match sound {
        [Ok(run), Ok(base)] => {
            (names.map(|name| (error(run, base, &name), name)).map(|(e, n)| (n, e)).collect(), None)
        }
        [run, base] => {
            let reasons: Vec<String> = [run.err(), base.err()].into_iter().flatten().collect();
            (names.map(|name| (name, None)).collect(), Some(reasons.join("; ")))
        }
    }
}

fn error(run: &Finished, base: &Finished, name: &str) -> Option<f64> {
    let floor = base.floors.get(name).copied().unwrap_or(0.0);
    relative_error(run.results.channel(name)?, base.results.channel(name)?, floor)
}

/// The worst error of the points that move at least a tenth as far as the farthest.
fn worst(base: &Finished, errors: &[(String, Option<f64>)]) -> Option<f64> {
    let moves = |(name, error): &(String, Option<f64>)| {
        let error = (*error).filter(|_| name.ends_with(".dR_A"))?;
        Some((largest(base.results.channel(name)?), error))
    };
    let moving: Vec<(f64, f64)> = errors.iter().filter_map(moves).collect();
    let far = moving.iter().fold(0.0, |far: f64, it| far.max(it.0));
    moving.iter().filter(|it| it.0 >= 0.1 * far).map(|it| it.1).max_by(f64::total_cmp)
}

/// Names of what is compared: `v_G`, `w_G` and the displacement of each point.
pub(super) fn compared(setting: &Setting) -> impl Iterator<Item = String> + '_ {
    let points = setting.setup.points.iter().map(|(_, name)| format!("{name}.dR_A"));
    ["v_G", "w_G"].map(String::from).into_iter().chain(points)
}

/// A fraction as a percentage, or a dash.
pub fn error_text(error: Option<f64>) -> String {
    match error {
        None => "–".to_owned(),
        Some(e) if e < 1e-9 => "< 1e-7 %".to_owned(),
        Some(e) => format!("{} %", significant(100.0 * e, 3)),
    }
}

/// Heading and rows of the errors under one load case, for people: swept values, method, errors in percent, and the time
/// the run took. Where nothing is swept, the reference's largest lengths come first.
pub fn table(study: &Study, runs: &BTreeMap<Unit, Outcome>, rows: &[Row], loads: &str) -> Vec<Vec<String>> {
    let Some(first) = study.settings.iter().position(|s| s.setup.case.name == loads) else {
        return Vec::new();
    };
    let swept: Vec<&String> = study.settings[first].swept.iter().map(|(name, _)| name).collect();
    let with_modes = study.modes.len() > 1;
    let names: Vec<String> = shown(study, runs, first).collect();
    let mut heading: Vec<String> = swept.into_iter().cloned().collect();
    heading.extend(with_modes.then(|| "modes".to_owned()));
    heading.push("method".to_owned());
    heading.extend(names.iter().cloned());
    let predicts = runs.values().any(|run| run.as_ref().is_ok_and(|run| run.summary.errors.is_some()));
    heading.extend(predicts.then(|| "predicted v_G, w_G, dR_A".to_owned()));
    heading.push("time (s)".to_owned());
    let mut table = vec![heading];
    let lead = |s: usize, modes: Option<usize>| {
        let mut cells: Vec<String> = study.settings[s].swept.iter().map(|(_, value)| value.clone()).collect();
        cells.extend(with_modes.then(|| modes.map_or("–".to_owned(), |m| m.to_string())));
        cells
    };
    if study.settings.len() == 1 && !with_modes {
        table.extend(reference_row(study, runs, first, &names));
    }
    for row in rows.iter().filter(|row| row.loads == loads) {
        let mut cells = lead(row.at.0, row.modes);
        cells.push(row.method.to_owned());
        let error = |name: &String| row.errors.iter().find(|(n, _)| n == name).and_then(|(_, e)| *e);
        match &row.failure {
            None => cells.extend(names.iter().map(|name| error_text(error(name)))),
            Some(_) => cells.extend(names.iter().map(|_| "failed".to_owned())),
        }
        let method = study.methods.iter().find(|m| m.name() == row.method);
        let run = method.and_then(|&method| find(runs, row.at.0, method, row.at.1)?.as_ref().ok());
        cells.extend(predicts.then(|| {
            let predicted = run.and_then(|run| run.summary.errors).map(|errors| errors.predicted);
            predicted.map_or("–".to_owned(), |p| {
                format!("{} %", [p.v_g, p.w_g, p.dr_a].map(|e| significant(100.0 * e, 2)).join(", "))
            })
        }));
        cells.push(run.map_or("–".to_owned(), |run| significant(run.timing.wall_seconds, 2)));
        table.push(cells);
    }
    table
}

/// What is worth a column: what moves in some reference run.
pub(super) fn shown<'a>(
    study: &'a Study,
    runs: &'a BTreeMap<Unit, Outcome>,
    first: usize,
) -> impl Iterator<Item = String> + 'a {
    let reference = study.methods[0];
    let moves = move |name: &String| {
        let references = runs.iter().filter(move |(unit, _)| unit.method == reference);
        let mut references = references.filter_map(|(_, run)| run.as_ref().ok()).peekable();
        let none = references.peek().is_none();
        let exceeds = |run: &Finished| {
            let floor = run.floors.get(name).copied().unwrap_or(0.0);
            run.results.channel(name).is_some_and(|c| largest(c) > floor)
        };
        none || references.any(exceeds)
    };
    compared(&study.settings[first]).filter(moves)
}

/// The reference's largest lengths, with their units.
fn reference_row(
    study: &Study,
    runs: &BTreeMap<Unit, Outcome>,
    setting: usize,
    names: &[String],
) -> Option<Vec<String>> {
    let method = study.methods[0];
    let run = find(runs, setting, method, 0)?.as_ref().ok()?;
    let length = |name: &String| {
        let channel = run.results.channel(name)?;
        Some(format!("{} {}", significant(largest(channel), 3), channel.unit))
    };
    let mut cells = vec![format!("{method}: max |X|")];
    cells.extend(names.iter().map(|name| length(name).unwrap_or_else(|| "–".to_owned())));
    let predicts = runs.values().any(|run| run.as_ref().is_ok_and(|run| run.summary.errors.is_some()));
    cells.extend(predicts.then(|| "–".to_owned()));
    cells.push(significant(run.timing.wall_seconds, 2));
    Some(cells)
}
