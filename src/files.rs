//! The files of a run and the folders they are in.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

use crate::atomic;
use crate::march::Outcome;
use crate::run::{RunFacts, Summary, report};
use crate::scene::Scene;

/// What is written of a run for people, beside its results.
#[derive(Clone, Debug, Default)]
pub struct Shown {
    /// The report.
    pub report: bool,
    /// Its plots as SVG files.
    pub svg: bool,
    /// What the report shows in space.
    pub scene: Option<Scene>,
    /// A collection for ParaView that is there already.
    pub vtk: Option<PathBuf>,
}

/// Writes all files of a run; the summary last, so that where there is one everything is there.
///
/// # Errors
/// Those of the file system, naming the file.
pub fn write(facts: &RunFacts, outcome: Outcome, folder: &Path, shown: Shown) -> io::Result<Summary> {
    atomic::make_folder(folder)?;
    let mut summary = summary(facts, &outcome);
    let mut results = outcome.results;
    results.metadata.insert("completed".to_owned(), summary.completed.into());
    let mut path = |kind: &str, name: &str| {
        let path = folder.join(name);
        summary.files.insert(kind.to_owned(), path.display().to_string());
        path
    };
    let (npz, csv, html) =
        (path("npz", "results.npz"), path("csv", "results.csv"), folder.join("report.html"));
    let (json, plots) = (path("summary", "summary.json"), folder.join("plots"));
    if shown.report {
        path("report", "report.html");
    }
    if shown.svg {
        path("plots", "plots");
    }
    if let Some(vtk) = shown.vtk {
        summary.files.insert("vtk".to_owned(), vtk.display().to_string());
    }
    results.write_npz(&npz)?;
    results.write_csv(&csv)?;
    if shown.report || shown.svg {
        let document = report(facts, &results, &summary, shown.scene);
        if shown.report {
            document.write(&html)?;
        }
        if shown.svg {
            document.write_svg(&plots)?;
        }
    }
    let text = serde_json::to_vec_pretty(&summary)?;
    atomic::write(&json, |sink| sink.write_all(&text))?;
    Ok(summary)
}

/// The figures of a run.
pub fn summary(facts: &RunFacts, outcome: &Outcome) -> Summary {
    let mut summary = Summary::new(facts, &outcome.results, &outcome.peaks, outcome.steps, outcome.timing);
    summary.failure.clone_from(&outcome.failure);
    summary
}

/// A name that is one plain folder on any system, whatever `name` is, and not taken yet.
pub fn folder_name(name: &str, taken: &mut BTreeSet<String>) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_+= ".contains(c) { c } else { '_' };
    let base: String = name.trim().chars().map(plain).collect();
    let base = if base.is_empty() { "_".to_owned() } else { base };
    let mut candidate = base.clone();
    let mut number = 1;
    // File systems may not tell upper from lower case.
    while !taken.insert(candidate.to_lowercase()) {
        number += 1;
        candidate = format!("{base}-{number}");
    }
    candidate
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_can_be_a_folder_outside() {
        let mut taken = BTreeSet::new();
        let names =
            ["../../etc", "a/b", "a_b", "..", "", "Lc1", "lc1", "böe 2"].map(|n| folder_name(n, &mut taken));
        assert_eq!(names, ["______etc", "a_b", "a_b-2", "__", "_", "Lc1", "lc1-2", "böe 2"]);
    }
}
