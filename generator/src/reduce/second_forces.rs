//! Second derivatives of the elastic forces along pairs of modes.
//!
//! ```text
//! d2 f(phi_i, phi_j) = (K(h phi_i) - K(-h phi_i)) phi_j / 2h,      K = df/dx, x = (R, theta) from the configuration
//! ```
//!
//! The exact tangent of the elements makes one difference along each mode serve all its pairs.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::modes::Modes;
use crate::assembly::{AnyBeam, Assembly};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::internal_force::{ElementMatrix, spin_tangent};
use crate::math::so3::{MatrixFunction, exp};

/// Largest nodal rotation, rad, or displacement over the size of the body, of a difference: its truncation is of the order of the
/// square, its round-off well below.
const STEP: f64 = 1e-3;

/// Second derivatives of the elastic forces about a configuration.
pub(super) struct SecondForces<'a> {
    assembly: &'a Assembly,
    at: &'a Configuration,
    modes: &'a Modes,
    /// Amplitude `h` of each mode - (m).
    step: Vec<f64>,
}

impl<'a> SecondForces<'a> {
    pub(super) fn new(assembly: &'a Assembly, at: &'a Configuration, modes: &'a Modes) -> Self {
        let size = at.positions.iter().map(Vector3::norm).fold(f64::MIN_POSITIVE, f64::max);
        let largest = |i: usize| {
            let nodes = (0..at.positions.len()).map(|node| {
                let phi = modes.at_node(node)[i];
                (phi.fixed_rows::<3>(0).norm() / size).max(phi.fixed_rows::<3>(3).norm())
            });
            nodes.fold(f64::MIN_POSITIVE, f64::max)
        };
        let step = (0..modes.m()).map(|i| STEP / largest(i)).collect();
        Self { assembly, at, modes, step }
    }

    /// `-d2 f(phi_i, phi_j)` on the unknowns, for all `j` from `i` to below `end` - (end - i of n).
    pub(super) fn along(&self, i: usize, end: usize) -> Vec<Vec<Vector6<f64>>> {
        let mut out = vec![vec![Vector6::zeros(); self.assembly.n_blocks()]; end - i];
        for beam in &self.assembly.beams {
            match beam {
                AnyBeam::Two(b) => self.add_beam(b, i, &mut out),
                AnyBeam::Three(b) => self.add_beam(b, i, &mut out),
            }
        }
        out
    }

    fn add_beam<const N: usize>(&self, beam: &Beam<N>, i: usize, out: &mut [Vec<Vector6<f64>>]) {
        let h = self.step[i];
        let (ahead, behind) = (self.tangent(beam, i, h), self.tangent(beam, i, -h));
        for a in 0..N {
            let Some(row) = self.assembly.unknown[beam.nodes[a]] else { continue };
            for b in 0..N {
                let change = (ahead[a][b] - behind[a][b]) / (2.0 * h);
                let phi = &self.modes.at_node(beam.nodes[b])[i..];
                out.iter_mut().zip(phi).for_each(|(out, phi)| out[row] -= change * phi);
            }
        }
    }

    /// `df/dx` of an element at `x = h phi_i`: the moments about `theta` are `T^t m`.
    fn tangent<const N: usize>(&self, beam: &Beam<N>, i: usize, h: f64) -> ElementMatrix<N> {
        let moved = |node: usize| self.modes.at_node(node)[i] * h;
        let turn = |node: usize| moved(node).fixed_rows::<3>(3).into_owned();
        let state = beam.state(
            |node| self.at.positions[node] + moved(node).fixed_rows::<3>(0),
            |node| self.at.rotation_matrix(node) * exp(&turn(node)),
        );
        let functions = beam.nodes.map(|node| MatrixFunction::tangential(&turn(node)));
        let (force, mut k) = spin_tangent(beam, &state, &functions.map(|t| t.matrix()));
        for (a, function) in functions.iter().enumerate() {
            let transposed = function.transposed();
            for block in &mut k[a] {
                turn_rows(block, &transposed);
            }
            let moment = force.force[a].fixed_rows::<3>(3).into_owned();
            let mut corner = k[a][a].fixed_view_mut::<3, 3>(3, 3);
            corner += transposed.derivative_times(&moment);
        }
        k
    }
}

fn turn_rows(block: &mut Matrix6<f64>, by: &MatrixFunction) {
    let turned = by.matrix() * block.fixed_view::<3, 6>(3, 0);
    block.fixed_view_mut::<3, 6>(3, 0).copy_from(&turned);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::so3::exp_quaternion;
    use crate::reduce::modes::elastic_modes;
    use crate::test_structures::fmb;

    /// Elastic forces in the coordinates `(R, theta)`.
    fn force(
        assembly: &Assembly,
        at: &Configuration,
        modes: &Modes,
        x: &[(usize, f64)],
    ) -> Vec<Vector6<f64>> {
        let mut moved = at.clone();
        let mut turns = vec![Vector3::zeros(); at.positions.len()];
        for (node, turn) in turns.iter_mut().enumerate() {
            let phi: Vector6<f64> = x.iter().map(|&(i, h)| modes.at_node(node)[i] * h).sum();
            moved.positions[node] += phi.fixed_rows::<3>(0);
            *turn = phi.fixed_rows::<3>(3).into_owned();
            moved.rotations[node] *= exp_quaternion(turn);
        }
        let mut force = assembly.elastic_force(&moved);
        for (force, turn) in force.iter_mut().zip(&turns) {
            let moment = MatrixFunction::tangential(turn).matrix().transpose() * force.fixed_rows::<3>(3);
            force.fixed_rows_mut::<3>(3).copy_from(&moment);
        }
        assembly.gather(&force)
    }

    /// Along every pair, at a bent and stressed state, against second differences of the forces themselves; both elements.
    #[test]
    fn is_the_second_derivative_of_the_forces() {
        for nodes in [2, 3] {
            let mesh = fmb(10.0, 12, nodes);
            let (assembly, drawing) = (Assembly::new(&mesh), Configuration::drawing(&mesh));
            let (mass, k) = (assembly.mass(&drawing), assembly.stiffness(&drawing));
            let modes = elastic_modes(&assembly, &drawing, &mass, &k, 5).unwrap();
            let mut bent = drawing.clone();
            for node in 0..bent.positions.len() {
                let phi: Vector6<f64> = modes.at_node(node)[..3].iter().sum();
                bent.positions[node] += phi.fixed_rows::<3>(0);
                bent.rotations[node] *= exp_quaternion(&phi.fixed_rows::<3>(3).into_owned());
            }
            let second = SecondForces::new(&assembly, &bent, &modes);
            for i in 0..5 {
                for (found, j) in second.along(i, 5).iter().zip(i..) {
                    // Larger than the step of the derivatives: these lose the square of the digits.
                    let (a, b) = (5.0 * second.step[i], 5.0 * second.step[j]);
                    let at = |x: f64, y: f64| force(&assembly, &bent, &modes, &[(i, x * a), (j, y * b)]);
                    let corners = [at(1.0, 1.0), at(1.0, -1.0), at(-1.0, 1.0), at(-1.0, -1.0)];
                    let scale = found.iter().map(|f| f.amax()).fold(0.0, f64::max);
                    for row in 0..assembly.n_blocks() {
                        let [pp, pm, mp, mm] = corners.each_ref().map(|f| f[row]);
                        let expected = -(pp - pm - mp + mm) / (4.0 * a * b);
                        let error = (found[row] - expected).amax();
                        // Both are cut at the square of their steps: 2.5e-5 and its like.
                        assert!(
                            error < 2e-4 * scale,
                            "{nodes} nodes, {i}, {j}, row {row}: {error} of {scale}"
                        );
                    }
                }
            }
        }
    }
}
