//! The report of one run.

use super::{RunFacts, Summary};
use crate::report::{Block, Curves, Document, Highlight, Look, Plot, Section, Table};
use crate::results::{Channel, Results};
use crate::scene::Scene;
use crate::text::{significant, thousands, vector};

/// Page with the motion and the curves of a run, its figures, and what is needed to run it again.
pub fn report(facts: &RunFacts, results: &Results, summary: &Summary, scene: Option<Scene>) -> Document {
    let mut sections = Vec::new();
    if let Some(failure) = &summary.failure {
        let text =
            format!("The run stopped at t = {} s: {}. {}", failure.time, failure.message, failure.help);
        sections.push(Section { title: "Stopped early".to_owned(), blocks: vec![Block::Warning(text)] });
    }
    if let Some(warning) = summary.errors.as_ref().and_then(super::ErrorSummary::warning) {
        sections
            .push(Section { title: "Range of the model".to_owned(), blocks: vec![Block::Warning(warning)] });
    }
    sections.extend(scene.map(view));
    let hint = "Drag in a plot to zoom in, double-click to see all of it again; click a name below a plot to hide its curve.";
    let mut rigid = section("Rigid-body motion", rigid_plots(results));
    rigid.blocks.insert(0, Block::Note(hint.to_owned()));
    sections.extend([
        rigid,
        section("Trajectory", trajectory(results)),
        section("Elastic motion", elastic_plots(results)),
        section(
            "Estimated errors",
            over_time(results, "Estimated relative errors so far", "error", &["predicted_error"])
                .into_iter()
                .collect(),
        ),
        section("Sensors and moving points", motion_plots(results)),
        section("What is conserved without loads", ledger_plots(results)),
        Section { title: "Figures".to_owned(), blocks: figures(summary) },
        Section { title: "Run".to_owned(), blocks: run_blocks(facts, summary) },
        Section { title: "Model".to_owned(), blocks: model_blocks(facts) },
    ]);
    sections.retain(|s| !s.blocks.is_empty());
    Document {
        title: format!("{}, load case {}", facts.structure, facts.load_case),
        subtitle: facts.description.clone(),
        highlights: highlights(summary),
        sections,
        footer: format!(
            "Written by {}. SI units. G is the inertial frame, A the frame of the reference node.",
            facts.tool
        ),
    }
}

/// The structure in space, with what can be done there.
pub fn view(scene: Scene) -> Section {
    let hint = "Drag to turn, right-drag or two fingers to move, wheel or pinch to come closer. Balls are named points, \
        arrows are forces and, with two heads, moments; red, green and blue are the axes x, y and z of G and A.";
    Section {
        title: "In space".to_owned(),
        blocks: vec![Block::Note(hint.to_owned()), Block::Scene(Box::new(scene))],
    }
}

fn section(title: &str, plots: Vec<Plot>) -> Section {
    Section { title: title.to_owned(), blocks: plots.into_iter().map(Block::Plot).collect() }
}

fn highlights(summary: &Summary) -> Vec<Highlight> {
    let mut out = Vec::new();
    let mut points: Vec<_> = summary.points.iter().collect();
    points.sort_by(|a, b| b.1.peak.total_cmp(&a.1.peak));
    for (name, point) in points.into_iter().filter(|(_, p)| p.peak > 0.0).take(2) {
        out.push(Highlight {
            label: format!("peak displacement of {name}"),
            value: format!("{} m", significant(point.peak, 4)),
            note: format!("in A, at t = {} s", significant(point.peak_time, 5)),
        });
    }
    let fastest =
        summary.range.get("w_G").map_or(0.0, |r| r.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs())));
    out.push(Highlight {
        label: "fastest turn".to_owned(),
        value: format!("{} rad/s", significant(fastest, 4)),
        note: "about one axis of G".to_owned(),
    });
    out.push(Highlight {
        label: "attitude at the end".to_owned(),
        value: format!("{}°", significant(summary.last.rotation_deg, 4)),
        note: format!("about {}", vector(&summary.last.rotation_axis, 2)),
    });
    out.push(Highlight {
        label: "centre-of-mass travel".to_owned(),
        value: format!("{} m", significant(summary.centre_of_mass_travel, 3)),
        note: "at most, from its start".to_owned(),
    });
    out.push(Highlight {
        label: "faster than real time".to_owned(),
        value: format!("{}×", thousands(summary.timing.real_time_factor)),
        note: format!("{} steps/s", thousands(summary.timing.steps_per_second)),
    });
    out
}

/// Channels over time in one plot; those missing are left out.
fn over_time(results: &Results, title: &str, y_label: &str, names: &[&str]) -> Option<Plot> {
    let channels: Vec<&Channel> = names.iter().filter_map(|name| results.channel(name)).collect();
    let single = channels.len() == 1;
    let series = channels.iter().flat_map(|channel| {
        (0..channel.width()).map(move |j| {
            let name = match channel.components.get(j) {
                Some(component) if single => component.clone(),
                _ => channel.column_names()[j].clone(),
            };
            (name, channel.column(j).collect())
        })
    });
    let series: Vec<(String, Vec<f64>)> = series.collect();
    let x = results.channel("t")?.data.clone();
    (!series.is_empty()).then(|| Plot {
        title: title.to_owned(),
        x_label: "t (s)".to_owned(),
        y_label: y_label.to_owned(),
        curves: Curves::Over { x, series },
        note: String::new(),
        look: Look::default(),
    })
}

/// Curves minus their first values: small travel far from zero would look like none.
fn from_start(mut plot: Plot) -> Plot {
    if let Curves::Over { series, .. } = &mut plot.curves {
        for (_, values) in series {
            let first = values.first().copied().unwrap_or(0.0);
            values.iter_mut().for_each(|v| *v -= first);
        }
    }
    plot
}

fn rigid_plots(results: &Results) -> Vec<Plot> {
    [
        over_time(results, "Velocity of A, components in G", "v_G (m/s)", &["v_G"]),
        over_time(results, "Angular velocity of A, components in G", "w_G (rad/s)", &["w_G"]),
        over_time(results, "Position of A in G", "r_G (m)", &["r_G"]),
        over_time(results, "Attitude quaternion", "zeta", &["zeta"]),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The origin of A, the centre of mass and the named points, seen along each axis of G.
fn trajectory(results: &Results) -> Vec<Plot> {
    let origin = results.channel("r_G").map(|c| c.data.as_slice());
    // A point on the reference node takes the path of A.
    let named = results.channels().iter().filter(|c| Some(c.data.as_slice()) != origin);
    let named = named.filter_map(|c| Some((c.name.strip_suffix(".R_G")?, c)));
    let fixed = [("A", "r_G"), ("centre of mass", "r_CM_G")];
    let fixed = fixed.into_iter().filter_map(|(label, name)| Some((label, results.channel(name)?)));
    let tracks: Vec<(&str, &Channel)> = fixed.chain(named).collect();
    let plot = |title: &str, axes: [(usize, &str); 2]| {
        let path = |(label, channel): &(&str, &Channel)| {
            ((*label).to_owned(), channel.column(axes[0].0).collect(), channel.column(axes[1].0).collect())
        };
        Plot {
            title: title.to_owned(),
            x_label: format!("{} (m)", axes[0].1),
            y_label: format!("{} (m)", axes[1].1),
            curves: Curves::Paths(tracks.iter().map(path).collect()),
            note: String::new(),
            look: Look::default(),
        }
    };
    vec![
        plot("Side view, along y (ring: start)", [(0, "x"), (2, "z")]),
        plot("Top view, along z", [(0, "x"), (1, "y")]),
        plot("End view, along x", [(1, "y"), (2, "z")]),
    ]
}

fn elastic_plots(results: &Results) -> Vec<Plot> {
    let mut plots = Vec::new();
    for channel in results.channels() {
        let Some(point) = channel.name.strip_suffix(".dR_A") else { continue };
        // The reference node and what is fixed to it do not move in A; a flat line is not worth a plot.
        if channel.data.iter().all(|&v| v == 0.0) {
            continue;
        }
        plots.extend(over_time(
            results,
            &format!("Displacement of {point} in A"),
            "dR_A (m)",
            &[&channel.name],
        ));
    }
    plots.extend(over_time(results, "Modal amplitudes, by number of the mode", "q", &["q"]));
    plots
}

/// What sensors read, section forces, and velocities and accelerations of points where they were recorded.
fn motion_plots(results: &Results) -> Vec<Plot> {
    let kinds = [
        (".a_S", "Acceleration read by", "a (m/s²)"),
        (".w_S", "Angular velocity read by", "w (rad/s)"),
        (".F", "Section force at", "F (N)"),
        (".M", "Section moment at", "M (N m)"),
        (".v_G", "Velocity in G of", "v (m/s)"),
        (".a_G", "Acceleration in G of", "a (m/s²)"),
        (".w_G", "Angular velocity in G of", "w (rad/s)"),
    ];
    let plot = |channel: &Channel| {
        let (suffix, title, unit) = kinds.iter().find(|kind| channel.name.ends_with(kind.0))?;
        let name = channel.name.strip_suffix(suffix)?;
        over_time(results, &format!("{title} {name}"), unit, &[&channel.name])
    };
    results.channels().iter().filter_map(plot).collect()
}

fn ledger_plots(results: &Results) -> Vec<Plot> {
    [
        over_time(results, "Energy", "E (J)", &["E_kin", "E_el", "E_grav"]),
        over_time(results, "Centre of mass in G, from its start", "Δr_CM_G (m)", &["r_CM_G"]).map(from_start),
        over_time(results, "Linear momentum, components in G", "p_G (kg m/s)", &["p_G"]),
        over_time(results, "Angular momentum about the origin of G", "L_G (kg m²/s)", &["L_G"]),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn figures(summary: &Summary) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut rows = summary.point_rows();
    if rows.len() > 1 {
        let columns = rows.remove(0);
        blocks.push(Block::Table(Table {
            caption: "Named points, over all steps".to_owned(),
            columns,
            rows,
        }));
    }
    let rows = summary.range.iter().map(|(name, range)| {
        let cell = |r: &[f64; 2]| format!("{} … {}", significant(r[0], 4), significant(r[1], 4));
        std::iter::once(name.clone()).chain(range.iter().map(cell)).collect()
    });
    blocks.push(Block::Table(Table {
        caption: "Range of the rigid-body velocities, over all steps".to_owned(),
        columns: ["", "x", "y", "z"].map(String::from).to_vec(),
        rows: rows.collect(),
    }));
    let last = &summary.last;
    blocks.push(Block::Facts(facts_of([
        ("last instant", format!("{} s", significant(last.t, 8))),
        ("r_G", format!("{} m", vector(&last.r_g, 6))),
        ("v_G", format!("{} m/s", vector(&last.v_g, 6))),
        ("w_G", format!("{} rad/s", vector(&last.w_g, 6))),
        ("zeta", vector(&last.zeta, 6)),
    ])));
    blocks
}

fn run_blocks(facts: &RunFacts, summary: &Summary) -> Vec<Block> {
    let grid = &facts.grid;
    let mut rows = vec![
        ("method", facts.method.clone()),
        ("integrator", facts.integrator.clone()),
        ("time step", format!("{} s", grid.dt)),
        ("steps", format!("{} of {}", thousands(summary.steps as f64), thousands(grid.steps as f64))),
        ("rows written", thousands(summary.rows as f64)),
        ("numerical damping", facts.numerical_damping.to_string()),
    ];
    let remark = grid.to_string();
    if !remark.is_empty() {
        rows.push(("end", remark));
    }
    let mut blocks = vec![Block::Verbatim(facts.command.clone()), Block::Facts(facts_of(rows))];
    if !facts.loads.is_empty() {
        blocks.push(Block::Table(Table {
            caption: "Loads: each is the force and the moment times the function of time".to_owned(),
            columns: ["point", "frame", "force (N)", "moment (N m)", "function of time"]
                .map(String::from)
                .to_vec(),
            rows: facts.loads.iter().map(|load| load.to_vec()).collect(),
        }));
    }
    blocks
}

fn model_blocks(facts: &RunFacts) -> Vec<Block> {
    let mut blocks = vec![Block::Facts(facts.model.clone())];
    if !facts.input_text.is_empty() {
        blocks.push(Block::Text("The structure file it was made from:".to_owned()));
        blocks.push(Block::Verbatim(facts.input_text.clone()));
    }
    blocks
}

fn facts_of<'a>(pairs: impl IntoIterator<Item = (&'a str, String)>) -> Vec<(String, String)> {
    pairs.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}
