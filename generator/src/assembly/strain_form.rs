//! The elastic stiffness applied to fields of motion, element by element through their strains.
//!
//! In the assembled blocks the rows of a fine mesh are small sums of large entries, each rounded by itself: of the response to a load
//! some `eps (L/h)^2.5` is wrong. The strains `B x` of an element lose `eps L/h` of their own, at random from one element to the
//! next, of which the sum over a member keeps `eps sqrt(L/h)`. Residuals taken this way bring the solution of the assembled
//! equations to that accuracy.

use nalgebra::{Matrix6, SMatrix};

use super::{AnyBeam, Assembly, BlockMatrix};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::internal_force::{geometric_stiffness, strain_maps};

/// `K_SS` as the sum over stiffness points of `B^t S B`, and the geometric stiffness.
#[derive(Clone, Debug)]
pub struct StrainForm {
    two: Vec<Point<2>>,
    three: Vec<Point<3>>,
    /// None where nothing is stressed.
    geometric: Option<BlockMatrix>,
}

/// A stiffness point of an element.
#[derive(Clone, Debug)]
struct Point<const N: usize> {
    /// Block rows of its nodes; none at the reference node.
    rows: [Option<usize>; N],
    /// Strains per motion of each node, axes as in [`strain_maps`].
    maps: [Matrix6<f64>; N],
    /// Section stiffness times the weight of the point.
    stiffness: Matrix6<f64>,
}

impl StrainForm {
    /// About a configuration.
    pub fn new(assembly: &Assembly, at: &Configuration) -> Self {
        let mut form = Self { two: Vec::new(), three: Vec::new(), geometric: None };
        let mut geometric = BlockMatrix::zeros(assembly.pattern.clone());
        for beam in &assembly.beams {
            match beam {
                AnyBeam::Two(b) => add_beam(&mut form.two, &mut geometric, assembly, b, at),
                AnyBeam::Three(b) => add_beam(&mut form.three, &mut geometric, assembly, b, at),
            }
        }
        form.geometric = (geometric.amax() > 0.0).then_some(geometric);
        form
    }

    /// `y -= K_SS x` for panels of motions over the unknowns.
    pub fn subtract<const B: usize>(&self, x: &[SMatrix<f64, 6, B>], y: &mut [SMatrix<f64, 6, B>]) {
        self.two.iter().for_each(|point| point.subtract(x, y));
        self.three.iter().for_each(|point| point.subtract(x, y));
        let Some(geometric) = &self.geometric else { return };
        for (i, y) in y.iter_mut().enumerate() {
            for (j, slot) in geometric.pattern.row(i) {
                *y -= geometric.values[slot] * x[j];
            }
        }
    }
}

impl<const N: usize> Point<N> {
    fn subtract<const B: usize>(&self, x: &[SMatrix<f64, 6, B>], y: &mut [SMatrix<f64, 6, B>]) {
        let nodes = || self.rows.iter().zip(&self.maps).filter_map(|(row, map)| row.map(|row| (row, map)));
        let strain: SMatrix<f64, 6, B> = nodes().map(|(row, map)| map * x[row]).sum();
        let stress = self.stiffness * strain;
        for (row, map) in nodes() {
            y[row] -= map.tr_mul(&stress);
        }
    }
}

fn add_beam<const N: usize>(
    points: &mut Vec<Point<N>>,
    geometric: &mut BlockMatrix,
    assembly: &Assembly,
    beam: &Beam<N>,
    at: &Configuration,
) {
    let state = at.of(beam);
    let rows = beam.nodes.map(|node| assembly.unknown[node]);
    for (point, maps) in beam.stiffness_points().iter().zip(strain_maps(beam, &state)) {
        points.push(Point { rows, maps, stiffness: point.stiffness * point.weight });
    }
    assembly.add(geometric, &beam.nodes, &geometric_stiffness(beam, &state));
}
