//! Pages that compare methods.
use std::collections::BTreeMap;

use super::rows::{Row, compared, find, shown, table};
use super::study::{Outcome, Study, Unit};
use crate::report::{Block, Curves, Document, Look, Plot, Section, Table};
use crate::results::{Channel, Results};
use crate::run::view;
use crate::scene::Scene;

/// Most sweep points whose motions are drawn on one page.
pub(super) const MOST_OVERLAYS: usize = 4;

/// The page of a study: errors, the motions of the methods over each other, and error curves over what is swept.
pub fn report(study: &Study, runs: &BTreeMap<Unit, Outcome>, rows: &[Row]) -> Document {
    let mut sections = Vec::new();
    let failures = failures(rows);
    if !failures.is_empty() {
        sections.push(Section { title: "Not completed".to_owned(), blocks: failures });
    }
    let several = load_cases(study).len() > 1;
    for loads in load_cases(study) {
        let title = if several { format!("Errors, load case {loads}") } else { "Errors".to_owned() };
        sections.push(Section { title, blocks: errors(study, runs, rows, &loads) });
    }
    sections.extend(motions(study, runs));
    if let Some(output) = &study.output {
        let settings = study.settings.first().map(|s| {
            let setup = &s.setup;
            vec![
                ("integrator".to_owned(), setup.integrator.to_string()),
                ("time step".to_owned(), format!("{} s", setup.grid.dt)),
                ("end".to_owned(), format!("{} s", setup.grid.t_end)),
                ("numerical damping".to_owned(), setup.numerical_damping.to_string()),
            ]
        });
        sections.push(Section {
            title: "Run".to_owned(),
            blocks: vec![Block::Verbatim(output.command.clone()), Block::Facts(settings.unwrap_or_default())],
        });
    }
    let name = study.settings.first().map_or("", |s| s.setup.structure.name());
    let others: Vec<&str> = study.methods.iter().skip(1).map(|m| m.name()).collect();
    Document {
        title: format!("{name}, load case {}", load_cases(study).join(", ")),
        subtitle: format!("{} against {}", others.join(", "), study.methods[0]),
        highlights: Vec::new(),
        sections,
        footer: format!("Written by {}. SI units.", study.tool),
    }
}

pub(super) fn load_cases(study: &Study) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for setting in &study.settings {
        if !names.contains(&setting.setup.case.name) {
            names.push(setting.setup.case.name.clone());
        }
    }
    names
}

/// Each reason once.
fn failures(rows: &[Row]) -> Vec<Block> {
    let mut reasons: Vec<&String> = Vec::new();
    for reason in rows.iter().filter_map(|row| row.failure.as_ref()) {
        if !reasons.contains(&reason) {
            reasons.push(reason);
        }
    }
    reasons.into_iter().map(|reason| Block::Warning(reason.clone())).collect()
}

fn errors(study: &Study, runs: &BTreeMap<Unit, Outcome>, rows: &[Row], loads: &str) -> Vec<Block> {
    let mut blocks = vec![Block::Text(
        "Relative error: the largest distance from the reference over time, divided by the largest length of the reference over time."
            .to_owned(),
    )];
    let rows: Vec<&Row> = rows.iter().filter(|row| row.loads == loads).collect();
    blocks.extend(curves(study, runs, &rows, loads).into_iter().map(Block::Plot));
    let owned: Vec<Row> = rows.into_iter().cloned().collect();
    let mut table = table(study, runs, &owned, loads);
    if !table.is_empty() {
        let columns = table.remove(0);
        let caption = format!(
            "against {}; a dash: zero throughout in the reference, so that there is no relative error",
            study.methods[0]
        );
        blocks.push(Block::Table(Table { caption, columns, rows: table }));
    }
    blocks
}

/// Errors over what is swept: one plot per quantity and choice of the other swept values.
fn curves(study: &Study, runs: &BTreeMap<Unit, Outcome>, rows: &[&Row], loads: &str) -> Vec<Plot> {
    let Some(first) = study.settings.iter().position(|s| s.setup.case.name == loads) else {
        return Vec::new();
    };
    let names: Vec<String> = shown(study, runs, first).collect();
    // The number of modes is the variable where it is swept, else the last parameter; the others tell the plots apart.
    let swept = study.settings[first].swept.len();
    let by_modes = study.modes.len() > 1;
    if !by_modes && swept == 0 {
        return Vec::new();
    }
    let fixed = if by_modes { swept } else { swept - 1 };
    let key = |row: &Row| study.settings[row.at.0].swept[..fixed].to_vec();
    let abscissa = |row: &Row| {
        if by_modes {
            return row.modes.map(|m| m as f64);
        }
        let name = &study.settings[row.at.0].swept[fixed].0;
        row.set.get(name).and_then(serde_json::Value::as_f64)
    };
    let mut keys: Vec<Vec<(String, String)>> = Vec::new();
    for row in rows {
        if !keys.contains(&key(row)) {
            keys.push(key(row));
        }
    }
    let label =
        if by_modes { "elastic modes".to_owned() } else { study.settings[first].swept[fixed].0.clone() };
    let mut plots = Vec::new();
    for chosen in keys {
        let rows: Vec<&&Row> = rows.iter().filter(|row| key(row) == chosen).collect();
        let mut x: Vec<f64> = rows.iter().filter_map(|row| abscissa(row)).collect();
        x.sort_by(f64::total_cmp);
        x.dedup();
        if x.is_empty() {
            // What is swept is no number.
            continue;
        }
        let place: Vec<String> = chosen.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        for name in &names {
            let series = study.methods.iter().skip(1).map(|method| {
                let at = |x: &f64| {
                    let row =
                        rows.iter().find(|row| row.method == method.name() && abscissa(row) == Some(*x));
                    let error = row.and_then(|row| row.errors.iter().find(|(n, _)| n == name)?.1);
                    error.filter(|e| *e > 0.0).unwrap_or(f64::NAN)
                };
                (method.to_string(), x.iter().map(at).collect())
            });
            let title = std::iter::once(format!("Error of {name}"))
                .chain(place.clone())
                .collect::<Vec<_>>()
                .join(", ");
            plots.push(Plot {
                title,
                x_label: label.clone(),
                y_label: "relative error".to_owned(),
                curves: Curves::Over { x: x.clone(), series: series.collect() },
                look: Look {
                    log_x: !by_modes && x.iter().all(|&x| x > 0.0),
                    log_y: true,
                    markers: true,
                    ..Look::default()
                },
                ..Plot::default()
            });
        }
    }
    plots
}

/// The motions of all methods at each sweep point, where these are few.
fn motions(study: &Study, all: &BTreeMap<Unit, Outcome>) -> Vec<Section> {
    let points = study.settings.len() * study.modes.len();
    if points > MOST_OVERLAYS {
        let text = format!("{points} sweep points: the motions themselves are in the folders of the runs.");
        return vec![Section { title: "Motions".to_owned(), blocks: vec![Block::Note(text)] }];
    }
    let mut sections = Vec::new();
    for (s, setting) in study.settings.iter().enumerate() {
        for m in 0..study.modes.len() {
            let mut place: Vec<String> = setting.swept.iter().map(|(n, v)| format!("{n} = {v}")).collect();
            if load_cases(study).len() > 1 {
                place.insert(0, setting.setup.case.name.clone());
            }
            if study.modes.len() > 1 {
                place.push(format!("{} modes", super::modes_in_words(&study.modes[m])));
            }
            let runs: Vec<(&str, &Results)> = study
                .methods
                .iter()
                .filter_map(|&method| Some((method.name(), &find(all, s, method, m)?.as_ref().ok()?.results)))
                .collect();
            let plots = compared(setting).flat_map(|name| overlay(&runs, &name, &title_of(&name)));
            let titled = |what: &str| {
                std::iter::once(what.to_owned()).chain(place.clone()).collect::<Vec<_>>().join(", ")
            };
            if let Some(scene) = together(study, all, s, m) {
                sections.push(Section { title: titled("In space"), ..view(scene) });
            }
            let title = titled("Motions");
            sections.push(Section { title, blocks: plots.map(Block::Plot).collect() });
        }
    }
    sections
}

/// The bodies of all methods in one view.
fn together(study: &Study, runs: &BTreeMap<Unit, Outcome>, setting: usize, modes: usize) -> Option<Scene> {
    let scene = |&method| find(runs, setting, method, modes)?.as_ref().ok()?.scene.clone();
    Scene::together(study.methods.iter().filter_map(scene).collect())
}

fn title_of(name: &str) -> String {
    match (name, name.strip_suffix(".dR_A")) {
        (_, Some(point)) => format!("Displacement of {point} in A"),
        ("v_G", _) => "Velocity of A, components in G".to_owned(),
        _ => "Angular velocity of A, components in G".to_owned(),
    }
}

/// A channel by several methods, one plot per component that moves.
pub fn overlay(runs: &[(&str, &Results)], name: &str, title: &str) -> Vec<Plot> {
    let channels: Vec<(&str, &Channel)> =
        runs.iter().filter_map(|(method, results)| Some((*method, results.channel(name)?))).collect();
    let Some(longest) = runs.iter().filter_map(|(_, r)| r.channel("t")).max_by_key(|t| t.rows()) else {
        return Vec::new();
    };
    let Some(&(_, first)) = channels.first() else { return Vec::new() };
    let size = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |m, v| m.max(v.abs()));
    let whole = channels.iter().map(|(_, c)| size(&mut c.data.iter().copied())).fold(0.0, f64::max);
    let plot = |j: usize| {
        let moves = channels.iter().any(|(_, c)| size(&mut c.column(j)) > 1e-9 * whole);
        let series = channels.iter().map(|(method, c)| {
            let mut values: Vec<f64> = c.column(j).collect();
            // A run that stopped early leaves a gap.
            values.resize(longest.rows(), f64::NAN);
            ((*method).to_owned(), values)
        });
        let component = first.components.get(j).map_or(String::new(), |c| format!(", {c}"));
        moves.then(|| Plot {
            title: format!("{title}{component}"),
            x_label: "t (s)".to_owned(),
            y_label: format!("{} ({})", first.column_names()[j], first.unit),
            curves: Curves::Over { x: longest.data.clone(), series: series.collect() },
            ..Plot::default()
        })
    };
    (0..first.width()).filter_map(plot).collect()
}
