//! Kelvin-Voigt damping of the section strains: `(F, M) = S (eps + tau eps_dot)` with the retardation time `tau` of the section.
//!
//! The rate of the strains is the strain operator on the rates of the nodes, `eps_dot = B (Rdot, w)`. A rigid motion strains
//! nothing, whatever the frame the rates are given in: it is not damped, and the forces have no resultant.

use nalgebra::{Matrix6, Vector6};

use super::beam::{Beam, BeamState};
use super::internal_force::{ElementMatrix, Stresses, strain_maps};

impl<const N: usize> Beam<N> {
    /// Whether its strains are damped.
    pub fn is_viscous(&self) -> bool {
        self.stiffness_points().iter().any(|point| point.retardation > 0.0)
    }
}

/// Section forces `S tau eps_dot` at the stiffness points; `rates` are those of the nodes: velocity in the axes of the state, spin in
/// the node frame.
pub fn viscous_stresses<const N: usize>(
    beam: &Beam<N>,
    state: &BeamState<N>,
    rates: &[Vector6<f64>; N],
) -> Stresses {
    let mut out = [Vector6::zeros(); 2];
    let points = beam.stiffness_points().iter().zip(strain_maps(beam, state));
    for (stress, (point, maps)) in out.iter_mut().zip(points) {
        let rate: Vector6<f64> = maps.iter().zip(rates).map(|(map, rate)| map * rate).sum();
        *stress = point.stiffness * rate * point.retardation;
    }
    out
}

/// `D = int B^t S tau B ds`: the forces that rates of the nodes make in a state, and their derivative in these rates.
pub fn viscous_matrix<const N: usize>(beam: &Beam<N>, state: &BeamState<N>) -> ElementMatrix<N> {
    let mut out = [[Matrix6::zeros(); N]; N];
    for (point, maps) in beam.stiffness_points().iter().zip(strain_maps(beam, state)) {
        let viscosity = point.stiffness * (point.retardation * point.weight);
        for a in 0..N {
            let left = maps[a].transpose() * viscosity;
            for b in 0..N {
                out[a][b] += left * maps[b];
            }
        }
    }
    out
}
