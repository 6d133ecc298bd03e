//! Frequencies of a structure whose reference node is held by a hub that turns steadily: centrifugal stiffening and softening, Coriolis
//! coupling (theory section 3 with `beta` constant).
//!
//! About the shape that the rotation gives the structure,
//!
//! ```text
//! M_SS xddot + C_SS(beta) xdot + K_S(beta) x = 0
//! ```
//!
//! with skew `C_SS` and symmetric `K_S`: undamped in a stable rotation. It is solved on the lowest clamped modes of that shape, of which
//! several times as many as wanted are taken.

use nalgebra::{Complex, DMatrix, Vector3, Vector6};
use rom_runtime::loads::LoadCase;

use super::shapes::in_space;
use super::tracking::Spectrum;
use super::{Support, VibrationError};
use crate::assembly::Assembly;
use crate::configuration::Configuration;
use crate::equilibrium::{EquilibriumSettings, solve};
use crate::mesh::Mesh;
use crate::reduce::modes::{Modes, elastic_modes};
use crate::reduce::tensors::{pairs, project};
use crate::solve::dense::general_eigen;

/// Clamped modes that the shapes on the hub are combined from, beyond four times those wanted.
const SPARE: usize = 12;
/// Most of them.
const MOST: usize = 120;

/// The lowest `count` frequencies on a hub that turns with `spin` (rad/s, axes of A) about the reference node.
///
/// # Errors
/// No equilibrium in the rotation, dead loads or gravity, which turn against the hub, a balance to be solved for, no modes.
pub fn spinning(mesh: &Mesh, spin: &Vector3<f64>, count: usize) -> Result<Spectrum, VibrationError> {
    let beta = Vector6::new(0.0, 0.0, 0.0, spin.x, spin.y, spin.z);
    let at = shape(mesh, beta)?;
    let mut assembly = Assembly::new(mesh);
    assembly.support = Support::Clamped;
    let mass = assembly.mass(&at);
    let stiffness = assembly.stiffness(&at);
    let basis = (4 * count + SPARE).min(MOST).min(6 * assembly.n_blocks()).max(count);
    let modes = elastic_modes(&assembly, &at, &mass, &stiffness, basis)?;
    let m = modes.m();
    let tensors = project(&assembly, &at, &modes);
    let mut gyroscopic = DMatrix::zeros(m, m);
    for r in 3..6 {
        gyroscopic += tensors.c[r].view((0, 0), (m, m)) * beta[r];
    }
    let mut elastic =
        DMatrix::from_fn(m, m, |i, j| if i == j { modes.omega[i] * modes.omega[i] } else { 0.0 });
    for (p, (r, s)) in pairs().enumerate() {
        elastic += tensors.k[p].view((0, 0), (m, m)) * (beta[r] * beta[s]);
    }
    let mut first_order = DMatrix::zeros(2 * m, 2 * m);
    first_order.view_mut((0, m), (m, m)).fill_with_identity();
    first_order.view_mut((m, 0), (m, m)).copy_from(&-elastic);
    first_order.view_mut((m, m), (m, m)).copy_from(&-gyroscopic);
    let (values, vectors) = general_eigen(&first_order)?;
    Ok(spectrum(&at, &modes, &values, &vectors, count))
}

/// The shape in the rotation, under the loads of the file's equilibrium if there are any.
fn shape(mesh: &Mesh, beta: Vector6<f64>) -> Result<Configuration, VibrationError> {
    let trim = mesh.trim.as_ref();
    if trim.is_some_and(|trim| !trim.balance.is_empty()) {
        return Err(VibrationError::BalanceInTurn);
    }
    let case = trim.map_or_else(|| LoadCase::empty("steady rotation"), |trim| trim.case.clone());
    let settings = trim.map_or_else(EquilibriumSettings::default, |trim| trim.settings);
    Ok(solve(mesh, &case, &EquilibriumSettings { beta, ..settings })?.configuration)
}

/// The eigenvalues with a positive imaginary part in ascending order, and instabilities without one, which count as frequency zero.
fn spectrum(
    at: &Configuration,
    modes: &Modes,
    values: &[Complex<f64>],
    vectors: &DMatrix<Complex<f64>>,
    count: usize,
) -> Spectrum {
    let m = modes.m();
    let largest = values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let wanted = |v: &Complex<f64>| v.im > 1e-9 * largest || (v.im.abs() <= 1e-9 * largest && v.re > 0.0);
    let mut order: Vec<usize> = (0..values.len()).filter(|&k| wanted(&values[k])).collect();
    order.sort_by(|&a, &b| values[a].im.total_cmp(&values[b].im).then(values[b].re.total_cmp(&values[a].re)));
    order.truncate(count);
    let fields: Vec<_> = (0..m).map(|j| in_space(at, modes, j)).collect();
    let size = at.positions.iter().map(Vector3::norm).fold(0.0, f64::max);
    let shape = |k: &usize| {
        let mut out = vec![Complex::new(0.0, 0.0); 6 * at.positions.len()];
        for (j, (translations, rotations)) in fields.iter().enumerate() {
            let amplitude = vectors[(j, *k)];
            let values = translations.iter().zip(rotations).flat_map(|(t, r)| {
                let r = r * (0.1 * size);
                [t.x, t.y, t.z, r.x, r.y, r.z]
            });
            out.iter_mut().zip(values).for_each(|(sum, value)| *sum += amplitude * value);
        }
        out
    };
    Spectrum {
        omega: order.iter().map(|&k| values[k].im.max(0.0)).collect(),
        growth: order.iter().map(|&k| values[k].re).collect(),
        shapes: order.iter().map(shape).collect(),
    }
}
