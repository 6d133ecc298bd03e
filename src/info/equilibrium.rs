//! The loaded equilibrium that a model is about.

use std::fmt::Write;

use rom_generator::equilibrium::SELF_BALANCED;
use rom_runtime::data::{ModelData, TrimData};
use serde::Serialize;

use crate::text::{columns, significant, vector};

/// The equilibrium of a model, and gravity.
#[derive(Clone, Debug, Serialize)]
pub struct EquilibriumInfo {
    /// Attitude quaternion of A, scalar first, components in A to components in G.
    pub attitude: [f64; 4],
    /// Factors that were solved for: name of the loads, factor.
    pub factors: Vec<(String, f64)>,
    /// Named points: displacement from the drawing, in A, m.
    pub displacements: Vec<(String, [f64; 3])>,
    /// Force at the reference node that would hold the body, in A, N.
    pub reaction_force: [f64; 3],
    /// Moment at the reference node that would hold the body, in A about its origin, N m.
    pub reaction_moment: [f64; 3],
    /// The larger of force over the sum of all forces and moment over the sum of all moments.
    pub self_balance: f64,
    /// Whether the body flies by itself in this state.
    pub balanced: bool,
    /// Whether a clamp holds it, which needs no balance.
    pub clamped: bool,
    /// Elastic energy, J.
    pub elastic_energy: f64,
    /// Load steps.
    pub load_steps: u64,
    /// Newton iterations.
    pub iterations: u64,
}

impl EquilibriumInfo {
    /// From a model about a loaded equilibrium.
    pub fn new(data: &ModelData, trim: &TrimData) -> Self {
        let [fx, fy, fz, mx, my, mz] = trim.reaction;
        let (force, moment) = ([fx, fy, fz], [mx, my, mz]);
        let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let share = |reaction: f64, scale: f64| if scale > 0.0 { reaction / scale } else { 0.0 };
        let self_balance = share(length(force), trim.scales[0]).max(share(length(moment), trim.scales[1]));
        let names = data.points.iter().map(|p| p.name.clone());
        Self {
            attitude: trim.attitude,
            factors: trim.factors.clone(),
            displacements: names.zip(trim.displacements.iter().copied()).collect(),
            reaction_force: force,
            reaction_moment: moment,
            self_balance,
            balanced: self_balance <= SELF_BALANCED,
            clamped: data.clamped.is_some(),
            elastic_energy: trim.elastic_energy,
            load_steps: trim.effort[0],
            iterations: trim.effort[1],
        }
    }

    /// For people, indented by two.
    pub fn to_text(&self) -> String {
        let mut out = format!(
            "  found in {} load steps and {} iterations; elastic energy {} J\n",
            self.load_steps,
            self.iterations,
            significant(self.elastic_energy, 5)
        );
        if self.attitude != [1.0, 0.0, 0.0, 0.0] {
            let _ = writeln!(out, "  attitude quaternion {}", vector(&self.attitude, 6));
        }
        for (name, factor) in &self.factors {
            let _ = writeln!(out, "  factor on `{name}`: {}", significant(*factor, 8));
        }
        let mut rows = vec![["point", "displacement from the drawing in A (m)"].map(String::from).to_vec()];
        rows.extend(self.displacements.iter().map(|(name, d)| vec![name.clone(), vector(d, 5)]));
        out.push_str(&columns(&rows));
        let verdict = match (self.clamped, self.balanced) {
            (true, _) => "held by the clamp",
            (false, true) => "it flies by itself",
            (false, false) => "NOT IN BALANCE: it moves off when let go",
        };
        let _ = writeln!(
            out,
            "  reaction at the reference node {} N, {} N m ({} of the loads): {verdict}",
            vector(&self.reaction_force, 3),
            vector(&self.reaction_moment, 3),
            significant(self.self_balance, 2)
        );
        out
    }
}
