//! Damping of the reduced model: that of strains, mass and modes on the kept modes (theory section 10).

use nalgebra::{DMatrix, Vector6};

use super::modes::Modes;
use crate::assembly::{AnyBeam, Assembly};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::internal_force::strain_maps;
use crate::mesh::Damping;

/// Entries off the diagonal smaller than this, relative to the diagonal ones, are round-off.
const ROUND_OFF: f64 = 1e-9;

/// Damping of modes of unit generalised mass.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalDamping {
    /// `C_ii / (2 omega_i)` - (m).
    pub ratio: Vec<f64>,
    /// `C` off its diagonal, row by row, 1/s; none where it is diagonal - (m x m).
    pub coupling: Option<Vec<f64>>,
}

/// `C = Phi_S^t D Phi_S + alpha I + diag(2 zeta omega)` of the modes with the given numbers.
pub fn modal_damping(
    assembly: &Assembly,
    at: &Configuration,
    damping: &Damping,
    modes: &Modes,
    numbers: &[usize],
) -> ModalDamping {
    let m = modes.m();
    let mut c = DMatrix::zeros(m, m);
    for beam in &assembly.beams {
        match beam {
            AnyBeam::Two(b) => add_viscosity(&mut c, b, at, modes),
            AnyBeam::Three(b) => add_viscosity(&mut c, b, at, modes),
        }
    }
    c = (&c + c.transpose()) * 0.5;
    for (i, number) in numbers.iter().enumerate() {
        c[(i, i)] += damping.alpha + 2.0 * damping.modal.of(*number) * modes.omega[i];
    }
    let ratio = (0..m).map(|i| c[(i, i)] / (2.0 * modes.omega[i])).collect();
    let pairs = (0..m).flat_map(|i| (0..i).map(move |j| (i, j)));
    let couples = |(i, j): (usize, usize)| c[(i, j)].abs() > ROUND_OFF * (c[(i, i)] * c[(j, j)]).sqrt();
    let coupling = pairs.clone().any(couples).then(|| {
        c.fill_diagonal(0.0);
        c.iter().copied().collect()
    });
    ModalDamping { ratio, coupling }
}

/// `int (B phi_i)^t S tau (B phi_j)` of an element.
fn add_viscosity<const N: usize>(c: &mut DMatrix<f64>, beam: &Beam<N>, at: &Configuration, modes: &Modes) {
    if !beam.is_viscous() {
        return;
    }
    let m = c.nrows();
    for (point, maps) in beam.stiffness_points().iter().zip(strain_maps(beam, &at.of(beam))) {
        let rate = |j: usize| (0..N).map(|a| maps[a] * modes.at_node(beam.nodes[a])[j]).sum();
        let rates: Vec<Vector6<f64>> = (0..m).map(rate).collect();
        for j in 0..m {
            let stress = point.stiffness * rates[j] * (point.retardation * point.weight);
            for i in 0..m {
                c[(i, j)] += rates[i].dot(&stress);
            }
        }
    }
}
