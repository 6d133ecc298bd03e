//! The figures of a run that fit on a screen.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use super::{ErrorSummary, Extreme, Failure, Peaks, RunFacts, Timing};
use crate::results::Results;
use crate::text::{columns, significant, thousands, vector};

/// Summary of one run; `romrun --json` prints it as it is here.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the structure.
    pub structure: String,
    /// The file that was run.
    pub file: String,
    /// Load case.
    pub load_case: String,
    /// Method.
    pub method: String,
    /// Integrator.
    pub integrator: String,
    /// Time step, s.
    pub dt: f64,
    /// End asked for, s.
    pub t_end: f64,
    /// Numerical damping of the integrator.
    pub numerical_damping: f64,
    /// Steps made.
    pub steps: u64,
    /// Rows written.
    pub rows: u64,
    /// Whether the end was reached.
    pub completed: bool,
    /// Why not.
    pub failure: Option<Failure>,
    /// Named points, by name.
    pub points: BTreeMap<String, PointSummary>,
    /// Last state.
    pub last: LastState,
    /// Smallest and largest value of each component of `v_G` (m/s) and `w_G` (rad/s), over all steps.
    pub range: BTreeMap<String, Vec<[f64; 2]>>,
    /// Largest distance of the centre of mass from its first position, m.
    pub centre_of_mass_travel: f64,
    /// Estimated errors of a reduced method.
    pub errors: Option<ErrorSummary>,
    /// Speed.
    pub timing: Timing,
    /// Files written, by kind.
    pub files: BTreeMap<String, String>,
}

/// One named point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointSummary {
    /// Largest length of the displacement in A, m.
    pub peak: f64,
    /// When, s.
    pub peak_time: f64,
    /// The displacement then, in A, m.
    pub peak_dr_a: [f64; 3],
    /// Of each component the value farthest from zero, m.
    pub extreme_dr_a: [f64; 3],
    /// When each of them, s.
    pub extreme_time: [f64; 3],
    /// Displacement at the end, in A, m.
    pub last_dr_a: [f64; 3],
}

/// Where frame A ends up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LastState {
    /// Time, s.
    pub t: f64,
    /// Position of the origin of A in G, m.
    pub r_g: [f64; 3],
    /// Its velocity, components in G, m/s.
    pub v_g: [f64; 3],
    /// Angular velocity, components in G, rad/s.
    pub w_g: [f64; 3],
    /// Attitude quaternion, scalar first.
    pub zeta: [f64; 4],
    /// The same as a rotation from the axes of G: angle, degrees.
    pub rotation_deg: f64,
    /// About this unit axis in G.
    pub rotation_axis: [f64; 3],
}

impl Summary {
    /// From what a run wrote and what was seen at every step; `peaks` holds `v_G`, `w_G` and each `P.dR_A` by name.
    ///
    /// # Panics
    /// When `results` lacks the channels of [`crate::results::MOTION`] or has no row.
    pub fn new(
        facts: &RunFacts,
        results: &Results,
        peaks: &BTreeMap<String, Peaks>,
        steps: u64,
        timing: Timing,
    ) -> Self {
        let last = LastState::of(results);
        let range = ["v_G", "w_G"].into_iter().filter_map(|name| {
            let range = peaks.get(name)?.components.iter().map(|e| [e.min.0, e.max.0]).collect();
            Some((name.to_owned(), range))
        });
        Self {
            structure: facts.structure.clone(),
            file: facts.file.clone(),
            load_case: facts.load_case.clone(),
            method: facts.method.clone(),
            integrator: facts.integrator.clone(),
            dt: facts.grid.dt,
            t_end: facts.grid.t_end,
            numerical_damping: facts.numerical_damping,
            steps,
            rows: results.rows() as u64,
            completed: steps == facts.grid.steps,
            failure: None,
            points: point_summaries(results, peaks),
            last,
            range: range.collect(),
            centre_of_mass_travel: travel(results),
            errors: None,
            timing,
            files: BTreeMap::new(),
        }
    }

    /// For the terminal.
    pub fn to_text(&self) -> String {
        let mut text = format!(
            "{}, load case {}: {} steps of {} s, {} ({})\n",
            self.structure,
            self.load_case,
            thousands(self.steps as f64),
            significant(self.dt, 6),
            self.integrator,
            self.method
        );
        if !self.points.is_empty() {
            text.push('\n');
            text.push_str(&columns(&self.point_rows()));
        }
        let last = &self.last;
        let _ = writeln!(
            text,
            "\n  at t = {} s  r_G = {} m, turned by {} deg about {}\n  v_G = {} m/s, w_G = {} rad/s",
            significant(last.t, 6),
            vector(&last.r_g, 4),
            significant(last.rotation_deg, 4),
            vector(&last.rotation_axis, 3),
            vector(&last.v_g, 4),
            vector(&last.w_g, 4)
        );
        let _ = writeln!(
            text,
            "  the centre of mass travelled up to {} m",
            significant(self.centre_of_mass_travel, 3)
        );
        if let Some(errors) = &self.errors {
            let _ = writeln!(text, "  {}", errors.to_text());
            if let Some(warning) = errors.warning() {
                let _ = writeln!(text, "  warning: {warning}");
            }
        }
        let _ = writeln!(
            text,
            "  {} steps/s, {} times real time",
            thousands(self.timing.steps_per_second),
            thousands(self.timing.real_time_factor)
        );
        text
    }

    /// Heading and one row per named point.
    pub fn point_rows(&self) -> Vec<Vec<String>> {
        let heading =
            ["point", "peak |dR_A| (m)", "at t (s)", "dR_A then (m)", "farthest dR_x, dR_y, dR_z (m)"];
        let mut rows = vec![heading.map(String::from).to_vec()];
        for (name, point) in &self.points {
            rows.push(vec![
                name.clone(),
                significant(point.peak, 4),
                significant(point.peak_time, 5),
                vector(&point.peak_dr_a, 4),
                vector(&point.extreme_dr_a, 4),
            ]);
        }
        rows
    }
}

impl LastState {
    fn of(results: &Results) -> Self {
        let row = results.rows() - 1;
        let zeta: [f64; 4] = fixed(results, "zeta", row);
        let sine = zeta[1..].iter().map(|v| v * v).sum::<f64>().sqrt();
        // zeta and -zeta are the same attitude: take the one that turns by at most half a turn.
        let sign = if zeta[0] < 0.0 { -1.0 } else { 1.0 };
        let axis = if sine > 0.0 { [1, 2, 3].map(|i| sign * zeta[i] / sine) } else { [0.0, 0.0, 1.0] };
        Self {
            t: fixed::<1>(results, "t", row)[0],
            r_g: fixed(results, "r_G", row),
            v_g: fixed(results, "v_G", row),
            w_g: fixed(results, "w_G", row),
            zeta,
            rotation_deg: 2.0 * sine.atan2(zeta[0].abs()).to_degrees(),
            rotation_axis: axis,
        }
    }
}

/// Row `row` of a channel that every run has.
fn fixed<const N: usize>(results: &Results, name: &str, row: usize) -> [f64; N] {
    let channel = results.channel(name).unwrap_or_else(|| panic!("results without {name}"));
    channel.row(row).try_into().unwrap_or_else(|_| panic!("{name} has {} components", channel.width()))
}

fn point_summaries(results: &Results, peaks: &BTreeMap<String, Peaks>) -> BTreeMap<String, PointSummary> {
    let mut points = BTreeMap::new();
    for (channel, seen) in peaks {
        let Some(point) = channel.strip_suffix(".dR_A") else { continue };
        let farthest: Vec<(f64, f64)> = seen.components.iter().map(Extreme::farthest).collect();
        let summary = PointSummary {
            peak: seen.length.0,
            peak_time: seen.length.1,
            peak_dr_a: std::array::from_fn(|i| seen.at_longest[i]),
            extreme_dr_a: std::array::from_fn(|i| farthest[i].0),
            extreme_time: std::array::from_fn(|i| farthest[i].1),
            last_dr_a: fixed(results, channel, results.rows() - 1),
        };
        points.insert(point.to_owned(), summary);
    }
    points
}

/// Largest distance of the centre of mass from where it was first.
fn travel(results: &Results) -> f64 {
    let Some(channel) = results.channel("r_CM_G") else { return 0.0 };
    let start = channel.row(0);
    let distance = |i| channel.row(i).iter().zip(start).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    (0..channel.rows()).map(distance).fold(0.0, f64::max)
}
