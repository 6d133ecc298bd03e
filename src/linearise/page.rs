//! What there is to look at of a linear model: its poles, where it holds, its channels.

use rom_generator::linearise::{Channel, Pole, StateSpace};

use super::{Origin, about, full_size, pole_rows};
use crate::report::{Block, Curves, Document, Highlight, Look, Plot, Section, Table};
use crate::text::significant;

/// The poles in the plane of complex numbers, those that grow apart from the others.
pub(super) fn pole_plot(poles: &[Pole]) -> Plot {
    // Round-off of undamped poles says nothing.
    let re = |pole: &Pole| if pole.re.abs() > 1e-9 * pole.omega() { pole.re } else { 0.0 };
    let mut sorted: Vec<&Pole> = poles.iter().collect();
    sorted.sort_by(|a, b| re(a).total_cmp(&re(b)));
    let of = |grows: bool| -> Vec<f64> {
        sorted.iter().map(|pole| if (re(pole) > 0.0) == grows { pole.im } else { f64::NAN }).collect()
    };
    let mut series = vec![("poles".to_owned(), of(false))];
    if sorted.iter().any(|pole| re(pole) > 0.0) {
        series.push(("poles that grow".to_owned(), of(true)));
    }
    Plot {
        title: "Poles".to_owned(),
        x_label: "growth (1/s)".to_owned(),
        y_label: "frequency (rad/s)".to_owned(),
        curves: Curves::Over { x: sorted.iter().map(|pole| re(pole)).collect(), series },
        look: Look { scattered: true, ..Look::default() },
        note: "Those on the left decay. Poles at the origin are rigid-body motion.".to_owned(),
    }
}

/// A page on a linear model.
pub(super) fn page(model: &StateSpace, origin: &Origin) -> Document {
    let mut rows = pole_rows(&model.poles);
    let columns = if rows.is_empty() { Vec::new() } else { rows.remove(0) };
    let growing = model.poles.iter().filter(|pole| pole.re > 1e-9 * pole.omega() && pole.im >= 0.0).count();
    let highlight = |label: &str, value: String, note: &str| Highlight {
        label: label.to_owned(),
        value,
        note: note.to_owned(),
    };
    let left_out = full_size(&model.steady) - model.states.len();
    let mut facts = vec![Block::Verbatim(about(&model.steady).trim_end().to_owned())];
    if !model.dropped.is_empty() {
        let names = model.dropped.join(", ");
        facts
            .push(Block::Note(format!("Outputs left out with the states that nothing depends on: {names}.")));
    }
    Document {
        title: format!("{}: linear model", origin.name),
        subtitle: "x_dot = A x + B u, y = C x + D u: small changes from a steady state, components in A"
            .to_owned(),
        highlights: vec![
            highlight(
                "states",
                model.states.len().to_string(),
                &if left_out > 0 { format!("{left_out} left out") } else { String::new() },
            ),
            highlight("inputs", model.inputs.len().to_string(), ""),
            highlight("outputs", model.outputs.len().to_string(), ""),
            highlight("poles that grow", growing.to_string(), "of each pair one"),
            highlight("accelerations left", significant(model.steady.residual, 2), "of those of the loads"),
        ],
        sections: vec![
            Section { title: "Steady state".to_owned(), blocks: facts },
            Section {
                title: "Poles".to_owned(),
                blocks: vec![
                    Block::Plot(pole_plot(&model.poles)),
                    Block::Table(Table { caption: "One of each pair".to_owned(), columns, rows }),
                ],
            },
            Section {
                title: "Channels".to_owned(),
                blocks: vec![
                    channels("States", &model.states),
                    channels("Inputs", &model.inputs),
                    channels("Outputs", &model.outputs),
                ],
            },
            Section { title: "Command".to_owned(), blocks: vec![Block::Verbatim(origin.command.clone())] },
        ],
        footer: origin.tool.clone(),
    }
}

fn channels(caption: &str, of: &[Channel]) -> Block {
    Block::Table(Table {
        caption: caption.to_owned(),
        columns: ["name", "unit", "what it is"].map(String::from).to_vec(),
        rows: of.iter().map(|c| vec![c.name.clone(), c.unit.to_owned(), c.description.clone()]).collect(),
    })
}
