//! What the loads of an equilibrium and its gravity do on terms of second order that a model drops (docs/beyond.md).
//!
//! Loads and weight that are in balance do large work on the curvature of the shapes, which cancels but for the geometric stiffness. Dropped
//! terms would take some of it away: their work at the equilibrium is kept as a part of the stiffness,
//!
//! ```text
//! dK_ij = - Theta^P_ij . F_P - (d2/dq_i dq_j int X) . g + e_0 . e_ij      over what is dropped of Theta^P, int X and the self-stress e      (B.6a)
//! ```

use nalgebra::{DMatrix, Vector3, Vector6};
use rom_runtime::data::PolynomialData;

use super::fields::Fields;
use super::manifold::Manifold;
use super::{CarriedPlace, moved};

/// Loads of an equilibrium and its gravity.
#[derive(Clone, Debug)]
pub struct EquilibriumLoads {
    /// Force in A (N) and moment in the place's own axes (N m) on every place - (places).
    pub places: Vec<Vector6<f64>>,
    /// Acceleration of free fall, in A, m/s^2.
    pub gravity: Vector3<f64>,
}

/// What a model keeps of second order.
pub(super) struct Kept<'a> {
    /// Of the motion of places - (places).
    pub(super) places: &'a [PolynomialData],
    pub(super) fields: &'a Fields,
    /// Of the coordinates of the fields.
    pub(super) coordinates: &'a PolynomialData,
}

impl EquilibriumLoads {
    /// The stiffness (B.6a) - (m x m). `stress`: elastic energy of what is dropped of the self-stress beside that of the equilibrium, over the
    /// monomials.
    pub(super) fn stiffness(
        &self,
        manifold: &Manifold,
        places: &[CarriedPlace],
        kept: &Kept<'_>,
        stress: &[f64],
    ) -> DMatrix<f64> {
        let range = &manifold.range;
        let loaded = places.iter().zip(kept.places).zip(&self.places);
        let loaded: Vec<_> = loaded.filter(|(_, force)| **force != Vector6::zeros()).collect();
        let mut k = DMatrix::zeros(range.len(), range.len());
        // A product in the potential gives its factor to both places of the matrix, a square twice to one.
        let mut add = |[i, j]: [usize; 2], potential: f64| {
            k[(i, j)] += potential;
            k[(j, i)] += potential;
        };
        for index in manifold.monomials.of_order(2) {
            let [i, j] = manifold.monomials.factors[index][..] else { continue };
            let work: f64 =
                loaded.iter().map(|((place, _), force)| moved(manifold, place, index).dot(force)).sum();
            let weight = kept.fields.first_moment_of[index].dot(&self.gravity);
            add([i, j], (stress[index] - work - weight) / (range[i] * range[j]));
        }
        for ((_, curve), force) in &loaded {
            for (row, factors, value) in &curve.quadratic {
                add(factors.map(|i| i as usize), value * force[*row as usize]);
            }
        }
        for (field, factors, value) in &kept.coordinates.quadratic {
            let weight = kept.fields.first_moment[*field as usize].dot(&self.gravity);
            add(factors.map(|i| i as usize), value * weight);
        }
        k
    }
}
