//! A figure or table of the paper as it comes out here.

use super::statement::{HEADING, Statement};
use crate::report::{Block, Curves, Look, Plot, Section, Table};

/// One figure or table.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Its name in the paper: `Fig. 3`.
    pub name: &'static str,
    /// What it shows.
    pub title: String,
    /// How it was made here, and what of the paper's cannot be compared.
    pub text: String,
    /// Plots and tables; or why there are none.
    pub blocks: Vec<Block>,
    /// What is stated about it.
    pub statements: Vec<Statement>,
}

impl Figure {
    /// As a section of the report: what it shows, the statements beside what was found, the plots.
    pub fn section(&self) -> Section {
        let mut blocks = vec![Block::Text(self.text.clone())];
        if !self.statements.is_empty() {
            blocks.push(Block::Table(Table {
                caption: String::new(),
                columns: HEADING.map(String::from).to_vec(),
                rows: self.statements.iter().map(Statement::cells).collect(),
            }));
        }
        blocks.extend(self.blocks.iter().cloned());
        Section { title: format!("{}: {}", self.name, self.title), blocks }
    }
}

/// Blocks, or the reason why there are none.
pub(super) fn or_reason(blocks: Result<Vec<Block>, String>) -> Vec<Block> {
    blocks.unwrap_or_else(|reason| vec![Block::Warning(format!("No figure: {reason}"))])
}

/// Curves over one variable.
pub(super) fn curves(
    title: &str,
    [x_label, y_label]: [&str; 2],
    x: &[f64],
    series: Vec<(String, Vec<f64>)>,
) -> Plot {
    Plot {
        title: title.to_owned(),
        x_label: x_label.to_owned(),
        y_label: y_label.to_owned(),
        curves: Curves::Over { x: x.to_vec(), series },
        ..Plot::default()
    }
}

/// Errors over sigma, both axes logarithmic.
pub(super) fn over_sigma(title: &str, y_label: &str, x: &[f64], series: Vec<(String, Vec<f64>)>) -> Plot {
    let look = Look { log_x: true, log_y: true, markers: true, ..Look::default() };
    Plot { look, ..curves(title, ["stiffness parameter sigma", y_label], x, series) }
}

/// Paths in a plane, one colour each.
pub(super) fn paths(
    title: &str,
    [x_label, y_label]: [&str; 2],
    paths: Vec<(String, Vec<f64>, Vec<f64>)>,
) -> Plot {
    Plot {
        title: title.to_owned(),
        x_label: x_label.to_owned(),
        y_label: y_label.to_owned(),
        curves: Curves::Paths(paths),
        ..Plot::default()
    }
}

/// Shapes at several times, from light (first) to dark (last): components `axes` of positions.
pub(super) fn snapshots(
    title: &str,
    labels: [&str; 2],
    axes: [usize; 2],
    shapes: &[(f64, Vec<[f64; 3]>)],
) -> Plot {
    let projected = |shape: &Vec<[f64; 3]>| shape.iter().map(|r| [r[axes[0]], r[axes[1]]]).collect();
    stages(title, labels, shapes.iter().map(|(t, shape)| (*t, projected(shape))).collect())
}

/// Shapes at several times seen from above at an angle, as plotting programs show three dimensions.
pub(super) fn snapshots_3d(title: &str, shapes: &[(f64, Vec<[f64; 3]>)]) -> Plot {
    let seen = |shape: &Vec<[f64; 3]>| shape.iter().map(seen_from_above).collect();
    let plot = stages(title, ["m", "m"], shapes.iter().map(|(t, shape)| (*t, seen(shape))).collect());
    Plot { note: VIEW.to_owned(), ..plot }
}

pub(super) const VIEW: &str = "Parallel projection from azimuth -37.5°, elevation 30°: z points up, x to the right and back, y to the left and back.";

/// Horizontal and vertical coordinate of a point in a parallel projection from azimuth -37.5 degrees, elevation 30 degrees.
pub(super) fn seen_from_above(r: &[f64; 3]) -> [f64; 2] {
    let (azimuth, elevation) = (-37.5_f64.to_radians(), 30.0_f64.to_radians());
    let ((sa, ca), (se, ce)) = (azimuth.sin_cos(), elevation.sin_cos());
    [r[0] * ca + r[1] * sa, -r[0] * se * sa + r[1] * se * ca + r[2] * ce]
}

fn stages(title: &str, labels: [&str; 2], shapes: Vec<(f64, Vec<[f64; 2]>)>) -> Plot {
    let path = |(t, shape): (f64, Vec<[f64; 2]>)| {
        let (x, y) = shape.into_iter().map(|[x, y]| (x, y)).unzip();
        (format!("t = {t} s"), x, y)
    };
    let look = Look { stages: true, ..Look::default() };
    Plot { look, ..paths(title, labels, shapes.into_iter().map(path).collect()) }
}
