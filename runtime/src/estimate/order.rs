//! How much a geometric model leaves out of its defect: it has all terms of second order, and those of third. What it lacks is smaller by two
//! orders, each of the ratio that the displacements off the straight lines of the modes have to all, over the mass of the body
//! (docs/validity.md).

use alloc::{vec, vec::Vec};

use crate::limits::FOURTH_ORDER;
use crate::model::Model;
use crate::polynomial::Polynomial;

/// The kinetic coordinates `y = A q + c(q)`, whose squares are those of the displacements in the mass matrix.
#[derive(Clone, Debug)]
pub(super) struct Order {
    curve: Polynomial,
    /// `A` - (m x m).
    linear: Vec<f64>,
    /// `y` - (n).
    values: Vec<f64>,
    /// Largest squares so far of `c` and of `y`.
    off: f64,
    all: f64,
}

impl Order {
    /// None of a model with linear elastic forces.
    pub(super) fn of(model: &Model) -> Option<Self> {
        let lagrangian = model.data().lagrangian.as_ref().filter(|it| it.geometric)?;
        let n = lagrangian.fields as usize;
        Some(Order {
            curve: Polynomial::new(n, &lagrangian.curve),
            linear: lagrangian.linear.clone(),
            values: vec![0.0; n],
            off: 0.0,
            all: 0.0,
        })
    }

    /// Begins again.
    pub(super) fn reset(&mut self) {
        (self.off, self.all) = (0.0, 0.0);
    }

    /// Takes in amplitudes; the part of the defect that is left out.
    pub(super) fn look(&mut self, q: &[f64]) -> f64 {
        let squares = |values: &[f64]| values.iter().map(|y| y * y).sum::<f64>();
        self.values.fill(0.0);
        self.curve.at(q, &mut self.values);
        self.off = self.off.max(squares(&self.values));
        for (y, row) in self.values.iter_mut().zip(self.linear.chunks_exact(q.len().max(1))) {
            *y += row.iter().zip(q).map(|(a, q)| a * q).sum::<f64>();
        }
        self.all = self.all.max(squares(&self.values));
        if self.all > 0.0 { FOURTH_ORDER * self.off / self.all } else { 0.0 }
    }
}
