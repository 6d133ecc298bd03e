//! What the loads of an equilibrium and its gravity do on the terms that a model drops (docs/beyond.md).
//!
//! Loads and weight that are in balance do large work on the curvature of the shapes, which cancels but for the geometric stiffness. Terms
//! that are dropped would take some of it away. Their work at the equilibrium is kept as a part of the elastic energy,
//!
//! ```text
//! V(q) = - x_P . F_P - (int X) . g + e_0 . e      over what is dropped of the motion x_P of places, of int X and of the self-stress e   (B.6a)
//! ```
//!
//! of which the second order is stiffness, and the third order the square of one more coordinate like those of the self-stress.

use nalgebra::{DMatrix, Vector3, Vector6};
use rom_runtime::data::PolynomialData;

use super::fields::Fields;
use super::manifold::Manifold;
use super::{CarriedPlace, StressCoordinates, moved, polynomial};

/// Constant part of the coordinate of the third order, over the root of twice the elastic energy of a mode at its range. Its square has
/// twice the product with the constant, which is what is meant, and the square of the rest, a thousandth or less over this.
const CONSTANT: f64 = 1e4;
/// Terms of third order below this part of that energy are dropped for good.
const TOLERANCE: f64 = 1e-5;

/// Loads of an equilibrium and its gravity.
#[derive(Clone, Debug)]
pub struct EquilibriumLoads {
    /// Force in A (N) and moment in the place's own axes (N m) on every place - (places).
    pub places: Vec<Vector6<f64>>,
    /// Acceleration of free fall, in A, m/s^2.
    pub gravity: Vector3<f64>,
}

/// What a model keeps.
pub(super) struct Kept<'a> {
    /// Of the motion of places - (places).
    pub(super) places: &'a [PolynomialData],
    pub(super) fields: &'a Fields,
    /// Of the coordinates of the fields.
    pub(super) coordinates: &'a PolynomialData,
}

/// The potential `V` over the scaled monomials, J - (monomials).
pub(super) struct Potential(Vec<f64>);

impl EquilibriumLoads {
    /// The work (B.6a). `stress`: `e_0 . e` of what is dropped of the self-stress - (monomials).
    pub(super) fn potential(
        &self,
        manifold: &Manifold,
        places: &[CarriedPlace],
        kept: &Kept<'_>,
        stress: &[f64],
    ) -> Potential {
        let monomials = &manifold.monomials;
        let loaded = places.iter().zip(kept.places).zip(&self.places);
        let loaded: Vec<_> = loaded.filter(|(_, force)| **force != Vector6::zeros()).collect();
        let mut potential = stress.to_vec();
        for (index, potential) in potential.iter_mut().enumerate() {
            let work = loaded.iter().map(|((place, _), force)| moved(manifold, place, index).dot(force));
            *potential -= work.sum::<f64>() + kept.fields.first_moment_of[index].dot(&self.gravity);
        }
        let mut keep = |terms: &PolynomialData, force: &dyn Fn(usize) -> f64| {
            let quadratic = terms.quadratic.iter().map(|(row, factors, value)| (*row, &factors[..], value));
            let cubic = terms.cubic.iter().map(|(row, factors, value)| (*row, &factors[..], value));
            for (row, factors, value) in quadratic.chain(cubic) {
                let factors: Vec<usize> = factors.iter().map(|&i| i as usize).collect();
                let range: f64 = factors.iter().map(|&i| manifold.range[i]).product();
                potential[monomials.index(factors)] += value * range * force(row as usize);
            }
        };
        for ((_, curve), force) in &loaded {
            keep(curve, &|row| force[row]);
        }
        keep(kept.coordinates, &|field| kept.fields.first_moment[field].dot(&self.gravity));
        potential[monomials.of_order(1)].fill(0.0);
        Potential(potential)
    }
}

impl Potential {
    /// Second derivatives at the equilibrium - (m x m).
    pub(super) fn stiffness(&self, manifold: &Manifold) -> DMatrix<f64> {
        let range = &manifold.range;
        let mut k = DMatrix::zeros(range.len(), range.len());
        for index in manifold.monomials.of_order(2) {
            if let [i, j] = manifold.monomials.factors[index][..] {
                // A product gives its factor to both places of the matrix, a square twice to one.
                let value = self.0[index] / (range[i] * range[j]);
                k[(i, j)] += value;
                k[(j, i)] += value;
            }
        }
        k
    }

    /// Adds a coordinate for the third order where there is any. `energy`: twice that of a mode at its range, J.
    pub(super) fn add_third_order(&self, manifold: &Manifold, energy: f64, to: &mut StressCoordinates) {
        let constant = CONSTANT * energy.sqrt();
        let mut row = DMatrix::zeros(1, self.0.len());
        for index in manifold.monomials.of_order(3) {
            row[(0, index)] = self.0[index] / constant;
        }
        let (terms, _) = polynomial(manifold, &row, |_| [f64::INFINITY, TOLERANCE * energy / constant]);
        if terms.cubic.is_empty() {
            return;
        }
        let place = to.constant.len() as u32;
        to.curve.cubic.extend(terms.cubic.iter().map(|(_, factors, value)| (place, *factors, *value)));
        to.constant.push(constant);
    }
}
