//! Linear models as files, and what is said of them.

mod mat;
mod npz;
mod page;

use std::io;
use std::path::Path;

use rom_generator::linearise::{Channel, Pole, StateSpace, Steady};
use serde_json::{Value, json};

use crate::atomic;
use crate::text::{columns, significant, vector};

/// Kind of a file to write, by the end of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `.npz`: NumPy archive.
    Npz,
    /// `.mat`: MATLAB file of level 5.
    Mat,
    /// `.svg`: the poles in the plane of complex numbers.
    Svg,
    /// `.html`: a page with the steady state, the poles and the names of all channels.
    Html,
}

impl Kind {
    /// None for another end.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "npz" => Some(Self::Npz),
            "mat" => Some(Self::Mat),
            "svg" => Some(Self::Svg),
            "html" => Some(Self::Html),
            _ => None,
        }
    }
}

/// Where a linear model comes from, in words.
#[derive(Clone, Debug)]
pub struct Origin {
    /// What it is a model of.
    pub name: String,
    /// The command as typed.
    pub command: String,
    /// Tool and version.
    pub tool: String,
}

/// Writes a linear model: matrices with the names of states, inputs and outputs, or what there is to look at.
///
/// # Errors
/// Those of the file system, naming the file.
pub fn write(model: &StateSpace, path: &Path, kind: Kind, origin: &Origin) -> io::Result<()> {
    let words = format!("{}; {}", origin.command, origin.tool);
    match kind {
        Kind::Npz => atomic::write(path, |sink| npz::write(model, &words, sink)),
        Kind::Mat => atomic::write(path, |sink| mat::write(model, &words, sink)),
        Kind::Svg => {
            let text = page::pole_plot(&model.poles).to_svg()?;
            atomic::write(path, |sink| sink.write_all(text.as_bytes()))
        }
        Kind::Html => page::page(model, origin).write(path),
    }
}

/// What goes into the files besides the matrices, as text.
fn metadata(model: &StateSpace, origin: &str) -> Value {
    let mut value = to_json(model);
    value["origin"] = origin.into();
    value
}

/// Names, units, the steady state and the poles.
pub fn to_json(model: &StateSpace) -> Value {
    let channels = |of: &[Channel]| -> Vec<Value> {
        of.iter().map(|c| json!({ "name": c.name, "unit": c.unit, "description": c.description })).collect()
    };
    let steady = &model.steady;
    let pole = |pole: &Pole| {
        json!({
            "re": pole.re, "im": pole.im, "omega": pole.omega(), "frequency_hz": pole.omega() / std::f64::consts::TAU,
            "damping": pole.damping(),
        })
    };
    json!({
        "states": channels(&model.states),
        "inputs": channels(&model.inputs),
        "outputs": channels(&model.outputs),
        "dropped_outputs": model.dropped,
        "ignorable_states": model.ignorable,
        "poles": model.poles.iter().map(pole).collect::<Vec<_>>(),
        "steady": {
            "q": steady.q,
            "velocity": steady.velocity,
            "attitude": steady.attitude,
            "position": steady.position,
            "factors": steady.factors,
            "wrench": steady.wrench,
            "residual": steady.residual,
            "corrections": steady.corrections,
            "driven": steady.driven,
        },
    })
}

/// For people: where it is about, its size, its poles.
pub fn to_text(model: &StateSpace) -> String {
    let mut text = about(&model.steady);
    text += &format!(
        "  {} states, {} inputs, {} outputs",
        model.states.len(),
        model.inputs.len(),
        model.outputs.len()
    );
    let left_out = model.states.len() < full_size(&model.steady);
    text += &match (model.ignorable, left_out) {
        (0, _) => "\n".to_owned(),
        (n, false) => format!("; nothing depends on {n} of them (--reduce leaves them out)\n"),
        (n, true) => format!("; {n} that nothing depends on are left out\n"),
    };
    if !model.dropped.is_empty() {
        text += &format!("  outputs left out with them: {}\n", model.dropped.join(", "));
    }
    text + "\n" + &columns(&pole_rows(&model.poles))
}

fn full_size(steady: &Steady) -> usize {
    2 * steady.q.len() + if steady.driven { 0 } else { 12 }
}

/// Where it is about.
fn about(steady: &Steady) -> String {
    let (v, w) = steady.velocity.split_at(3);
    let still = steady.velocity.iter().all(|x| *x == 0.0);
    let mut text = match (still, steady.driven) {
        (true, true) => "  A held".to_owned(),
        (true, false) => "  at rest".to_owned(),
        (false, moved) => format!(
            "  {} v = {} m/s, w = {} rad/s in A",
            if moved { "A moved with" } else { "in steady motion with" },
            vector(v, 6),
            vector(w, 6)
        ),
    };
    let largest = steady.q.iter().fold(0.0_f64, |largest, q| largest.max(q.abs()));
    // A trim is balanced to some digits; its rest moves the amplitudes a little.
    if largest > 0.0 {
        text += &format!(", amplitudes up to {} from the shape of the model", significant(largest, 3));
    }
    text += &format!("\n  accelerations left: {} of those of the loads\n", significant(steady.residual, 2));
    for (name, change) in &steady.factors {
        text += &format!("  factor on \"{name}\" changed by {}\n", significant(*change, 6));
    }
    if let Some(wrench) = &steady.wrench {
        text += &format!(
            "  held by F = {} N, M = {} N m on A, in A\n",
            vector(&wrench[..3], 6),
            vector(&wrench[3..], 6)
        );
    }
    text
}

/// Poles of the upper half, those at zero counted.
fn pole_rows(poles: &[Pole]) -> Vec<Vec<String>> {
    let heading = ["pole", "omega (rad/s)", "f (Hz)", "damping ratio", "growth (1/s)", "kind"];
    let mut rows = vec![heading.map(String::from).to_vec()];
    let zeros = poles.iter().filter(|pole| pole.omega() == 0.0).count();
    if zeros > 0 {
        let cells = [&zeros.to_string(), "0", "0", "–", "0", "at the origin: rigid-body motion"];
        rows.push(cells.map(String::from).to_vec());
        rows[1][0] = format!("{zeros} x");
    }
    let upper = poles.iter().filter(|pole| pole.omega() > 0.0 && pole.im >= 0.0);
    for (k, pole) in upper.enumerate() {
        let kind = match (pole.im > 0.0, pole.re > 1e-9 * pole.omega()) {
            (true, false) => "pair",
            (true, true) => "pair, grows",
            (false, false) => "real",
            (false, true) => "real, grows",
        };
        // Round-off of undamped poles says nothing.
        let re = if pole.re.abs() > 1e-9 * pole.omega() { pole.re } else { 0.0 };
        rows.push(vec![
            (k + 1).to_string(),
            significant(pole.omega(), 7),
            significant(pole.omega() / std::f64::consts::TAU, 6),
            significant(-re / pole.omega(), 4),
            significant(re, 4),
            kind.to_owned(),
        ]);
    }
    rows
}
