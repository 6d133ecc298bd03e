//! The Lagrangian of a consistent model, for people and as JSON.

use rom_runtime::data::LagrangianData;
use serde::Serialize;

use crate::text::{significant, thousands, vector};

/// Sizes of the Lagrangian, and what was left out of it.
#[derive(Clone, Debug, Serialize)]
pub struct LagrangianInfo {
    /// `geometric` for the elastic energy of large deflections, `linear` else.
    pub elastic: &'static str,
    /// Kinetic coordinates.
    pub fields: u32,
    /// Terms of second and third order in them.
    pub terms: [usize; 2],
    /// Entries of their moments `P_ab`.
    pub moments: usize,
    /// Coordinates of self-stress in closed loops, and of the work of a loaded equilibrium.
    pub self_stress: usize,
    /// Terms of second and third order in the motion of points and stations.
    pub point_terms: [usize; 2],
    /// Amplitudes for which terms were kept or dropped, one for each mode.
    pub range: Vec<f64>,
    /// Terms below this part of the largest were dropped, at those amplitudes.
    pub tolerance: f64,
    /// Root of the sum of squares of what was dropped of the coordinates, over the largest linear term.
    pub dropped_norm: f64,
    /// Norm and number of the moments dropped.
    pub dropped_moments: (f64, u64),
}

impl LagrangianInfo {
    pub(super) fn new(data: &LagrangianData) -> Self {
        let points =
            |count: fn(&rom_runtime::data::PolynomialData) -> usize| data.points.iter().map(count).sum();
        Self {
            elastic: if data.geometric { "geometric" } else { "linear" },
            fields: data.fields,
            terms: [data.curve.quadratic.len(), data.curve.cubic.len()],
            moments: data.moment.value.len(),
            self_stress: data.self_stress.len(),
            point_terms: [points(|p| p.quadratic.len()), points(|p| p.cubic.len())],
            range: data.range.clone(),
            tolerance: data.tolerance,
            dropped_norm: data.dropped_norm,
            dropped_moments: (data.moment.dropped_norm, data.moment.dropped_count),
        }
    }

    pub(super) fn to_text(&self) -> String {
        let count = |n: usize| thousands(n as f64);
        let [quadratic, cubic] = self.terms.map(count);
        let [bent, twice] = self.point_terms.map(count);
        let loops = match self.self_stress {
            0 => String::new(),
            1 => "  1 coordinate of self-stress or of the work of the equilibrium\n".to_owned(),
            n => format!("  {n} coordinates of self-stress and of the work of the equilibrium\n"),
        };
        format!(
            "\nConsistent inertia, {} elastic forces\n  {} kinetic coordinates, {quadratic} terms of second order, {cubic} of third\n  \
             {} moments of their fields, {} dropped of norm {}\n{loops}  {bent} and {twice} terms in the motion of points\n  \
             kept to {} at amplitudes {}, dropped norm {}\n",
            self.elastic,
            self.fields,
            count(self.moments),
            thousands(self.dropped_moments.1 as f64),
            significant(self.dropped_moments.0, 3),
            significant(self.tolerance, 3),
            vector(&self.range, 3),
            significant(self.dropped_norm, 3),
        )
    }
}
