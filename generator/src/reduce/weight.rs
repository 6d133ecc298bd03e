//! Second derivatives of the first moment of mass in A by the modal amplitudes: `H_jk` of `mu = m c_0 + S_j q_j + 1/2 H_jk q_j q_k`.
//!
//! Positions are linear in the amplitudes, so that only masses beside the axis contribute, which move on circles:
//!
//! ```text
//! g . H_jk = phi_j^t (d weight(g) / d(R, theta)) phi_k      for the three unit fields g
//! ```

use nalgebra::{DMatrix, Matrix3, Vector3, Vector6};

use super::modes::Modes;
use crate::assembly::{AnyBeam, Assembly};
use crate::configuration::Configuration;
use crate::element::internal_force::{ElementMatrix, split};
use crate::element::weight::{lump_weight, lump_weight_tangent, weight, weight_tangent};
use crate::math::so3::skew;

/// `H`, component by component (3 x m x m), in kg m; empty where no mass is beside its axis.
pub fn second_moment(assembly: &Assembly, at: &Configuration, modes: &Modes) -> Vec<f64> {
    let m = modes.m();
    let mut any = false;
    let mut sums: [DMatrix<f64>; 3] = std::array::from_fn(|_| DMatrix::zeros(m, m));
    for (k, sum) in sums.iter_mut().enumerate() {
        let g = Vector3::ith(k, 1.0);
        for beam in &assembly.beams {
            any |= match beam {
                AnyBeam::Two(b) => {
                    let state = at.of(b);
                    add(sum, modes, &b.nodes, weight_tangent(b, &state, &g), &weight(b, &state, &g))
                }
                AnyBeam::Three(b) => {
                    let state = at.of(b);
                    add(sum, modes, &b.nodes, weight_tangent(b, &state, &g), &weight(b, &state, &g))
                }
            };
        }
        for lump in &assembly.lumped {
            let q = at.rotation_matrix(lump.node);
            let tangent = lump_weight_tangent(lump, &q, &g);
            any |= add(sum, modes, &[lump.node], tangent, &[lump_weight(lump, &q, &g)]);
        }
    }
    if !any || m == 0 {
        return Vec::new();
    }
    // Symmetric but for round-off.
    sums.iter().flat_map(|h| ((h + h.transpose()) * 0.5).iter().copied().collect::<Vec<_>>()).collect()
}

/// Adds `phi^t (tangent - 1/2 m~) phi` over the nodal rotations: the second term turns the tangent in spins into that in `theta`.
/// Returns whether there was a tangent.
fn add<const N: usize>(
    sum: &mut DMatrix<f64>,
    modes: &Modes,
    nodes: &[usize; N],
    tangent: Option<ElementMatrix<N>>,
    force: &[Vector6<f64>; N],
) -> bool {
    let Some(tangent) = tangent else { return false };
    for a in 0..N {
        for b in 0..N {
            let mut block: Matrix3<f64> = tangent[a][b].fixed_view::<3, 3>(3, 3).into_owned();
            if a == b {
                block -= skew(&split(&force[a]).1) * 0.5;
            }
            let (left, right) = (modes.at_node(nodes[a]), modes.at_node(nodes[b]));
            for (k, phi_k) in right.iter().enumerate() {
                let moment = block * split(phi_k).1;
                for (j, phi_j) in left.iter().enumerate() {
                    sum[(j, k)] += split(phi_j).1.dot(&moment);
                }
            }
        }
    }
    true
}
