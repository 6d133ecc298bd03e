//! Amplitudes and rates up to which a model holds.

use rom_runtime::data::ModelData;
use rom_runtime::{LIMIT_LEVELS as LEVELS, LeftOut};
use serde::Serialize;

use crate::text::{columns, vector};

/// Limits of a model, learned when it was built.
#[derive(Clone, Debug, Serialize)]
pub struct Limits {
    /// Shares of the kept terms that the terms left out reach at the limits below.
    pub levels: [f64; 3],
    /// For each elastic mode.
    pub amplitudes: Vec<AmplitudeLimit>,
    /// For the angular rates about x, y, z of A; none about an axis about which spinning stiffens no mode.
    pub rates: [Option<RateLimit>; 3],
}

/// Limits of one modal amplitude.
#[derive(Clone, Debug, Serialize)]
pub struct AmplitudeLimit {
    /// Number of the mode.
    pub mode: u32,
    /// Amplitude at each level.
    pub amplitude: [f64; 3],
    /// What is left out first: `inertia` (the change of the mass matrix), `curvature` (second-order displacements), or `higher order` (what
    /// the polynomials of a model with geometric elastic forces lack).
    pub by: &'static str,
    /// Named point that moves farthest in the mode.
    pub point: Option<String>,
    /// How far it moves at each level, m.
    pub displacement: Option<[f64; 3]>,
}

/// Limits of an angular rate.
#[derive(Clone, Debug, Serialize)]
pub struct RateLimit {
    /// Rate at each level, rad/s.
    pub rate: [f64; 3],
    /// Number of the mode whose stiffness changes first.
    pub mode: u32,
}

impl Limits {
    /// Of a model.
    pub fn new(data: &ModelData) -> Self {
        let number = &data.modes.number;
        let amplitudes = number.iter().enumerate().filter_map(|(j, mode)| {
            let by = match data.amplitude_limit(j, LEVELS[0])?.1 {
                LeftOut::Inertia => "inertia",
                LeftOut::HigherOrder => "higher order",
                _ => "curvature",
            };
            let amplitude = LEVELS.map(|level| data.amplitude_limit(j, level).map_or(0.0, |it| it.0));
            let farthest = farthest(data, j);
            Some(AmplitudeLimit {
                mode: *mode,
                amplitude,
                by,
                displacement: farthest.as_ref().map(|(_, unit)| amplitude.map(|q| q * unit)),
                point: farthest.map(|(name, _)| name),
            })
        });
        let rate = |axis: usize| {
            let limits = number.iter().enumerate().filter_map(|(j, mode)| {
                let rate = LEVELS.map(|level| data.rate_limit(axis, j, level));
                let [Some(a), Some(b), Some(c)] = rate else { return None };
                Some(RateLimit { rate: [a, b, c], mode: *mode })
            });
            limits.min_by(|a, b| a.rate[0].total_cmp(&b.rate[0]))
        };
        Self { levels: LEVELS, amplitudes: amplitudes.collect(), rates: [0, 1, 2].map(rate) }
    }

    /// For the terminal.
    pub fn to_text(&self) -> String {
        let mut out =
            String::from("\nRange of the model: where the terms left out reach 1, 5, 10 % of those kept\n");
        let heading = ["mode", "amplitude", "moves", "by (m)", "left out first"];
        let mut rows = vec![heading.map(String::from).to_vec()];
        for limit in &self.amplitudes {
            rows.push(vec![
                limit.mode.to_string(),
                vector(&limit.amplitude, 3),
                limit.point.clone().unwrap_or_default(),
                limit.displacement.map_or_else(String::new, |d| vector(&d, 3)),
                limit.by.to_owned(),
            ]);
        }
        out.push_str(&columns(&rows));
        for (axis, limit) in ["x", "y", "z"].iter().zip(&self.rates) {
            out.push_str(&match limit {
                Some(RateLimit { rate, mode }) => {
                    format!("  angular rate about {axis}: {} rad/s, by mode {mode}\n", vector(rate, 3))
                }
                None => format!("  angular rate about {axis}: no limit\n"),
            });
        }
        out
    }
}

/// The named point that moves farthest in a mode relative to A, and how far per unit amplitude.
fn farthest(data: &ModelData, j: usize) -> Option<(String, f64)> {
    let m = data.modes.omega.len();
    let length = |rows: &[f64]| (0..3).map(|k| rows[k * m + j].powi(2)).sum::<f64>().sqrt();
    let points = data.points.iter().map(|point| (point.name.clone(), length(&point.phi_translation)));
    let farthest = points.max_by(|a, b| a.1.total_cmp(&b.1))?;
    // In torsion of a straight beam no point moves but by round-off: against the modes that do.
    let all = data.points.iter().flat_map(|point| &point.phi_translation);
    let largest = all.fold(0.0, |largest: f64, x| largest.max(x.abs()));
    (farthest.1 > 1e-9 * largest).then_some(farthest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tenth of the change per unit amplitude; the square root for rates, whose square stiffens.
    #[test]
    fn limits_are_levels_over_ratios() {
        let mut data = super::super::sample();
        data.validity = Some(rom_runtime::data::ValidityData {
            modes: 2,
            fields: vec![0.0; 3 * 15],
            points: vec![vec![0.0; 18]],
            amplitude: vec![0.02, 0.05, 0.4, 0.1],
            stiffening: vec![0.0, 0.0, 0.1, 0.0, 0.0, 0.025],
            curve: None,
            missing: Default::default(),
        });
        let limits = Limits::new(&data);
        assert_eq!(limits.amplitudes[0].by, "curvature");
        assert!((limits.amplitudes[0].amplitude[2] - 2.0).abs() < 1e-12);
        assert_eq!(limits.amplitudes[1].by, "inertia");
        assert!((limits.amplitudes[1].amplitude[1] - 0.125).abs() < 1e-12);
        assert!(limits.rates[0].is_none());
        let z = limits.rates[2].as_ref().unwrap();
        assert!((z.rate[2] - 1.0).abs() < 1e-12 && z.mode == 1);
        assert!(limits.to_text().contains("no limit"));
    }
}
