//! How pictures of a model on a curved manifold bend: amplitudes of the shapes that its nodes have beyond those of the modes.

use alloc::{vec, vec::Vec};

use crate::data::PictureCurveData;
use crate::polynomial::Polynomial;

/// The amplitudes of [`PictureCurveData::shapes`] as functions of the modal ones.
#[derive(Clone, Debug)]
pub struct PictureCurve {
    curve: Polynomial,
    amplitudes: Vec<f64>,
    rates: Vec<f64>,
}

impl PictureCurve {
    /// For pictures of `nodes` nodes.
    pub fn new(data: &PictureCurveData, nodes: usize) -> Self {
        let n = data.shapes.len().checked_div(3 * nodes).unwrap_or(0);
        PictureCurve { curve: Polynomial::new(n, &data.curve), amplitudes: vec![0.0; n], rates: vec![0.0; n] }
    }

    /// Amplitudes and their rates at modal amplitudes and rates - (m): each as many as there are shapes.
    pub fn at(&mut self, q: &[f64], q_dot: &[f64]) -> (&[f64], &[f64]) {
        self.amplitudes.fill(0.0);
        self.rates.fill(0.0);
        self.curve.at(q, &mut self.amplitudes);
        self.curve.derivative(q, q_dot, &mut self.rates);
        (&self.amplitudes, &self.rates)
    }
}
