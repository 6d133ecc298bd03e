//! What was chosen and why, for the terminal.

use rom_runtime::data::SelectionData;

use crate::text::{columns, significant};

/// A fraction as a percentage.
pub(super) fn percent(fraction: f64) -> String {
    if fraction.is_finite() {
        format!("{} %", significant(100.0 * fraction, 3))
    } else {
        "a run that fails".to_owned()
    }
}

/// Errors reached, and every choice with its reason.
pub fn report(selection: &SelectionData) -> String {
    let target = percent(selection.target);
    let mut text = format!("Errors against the nonlinear structure, target {target}\n");
    let rows: Vec<Vec<String>> = selection
        .errors
        .iter()
        .map(|(name, error)| {
            let verdict = if *error <= selection.target { "" } else { "above the target" };
            vec![name.clone(), percent(*error), verdict.to_owned()]
        })
        .collect();
    text.push_str(&columns(&rows));
    text.push_str("Taken and left\n");
    let choice = |taken: bool| if taken { "taken" } else { "left" }.to_owned();
    let rows: Vec<Vec<String>> =
        selection.choices.iter().map(|c| vec![c.what.clone(), choice(c.taken), c.why.clone()]).collect();
    text.push_str(&columns(&rows));
    text
}
