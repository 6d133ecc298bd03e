//! Frequencies and shapes as a NumPy archive.

use std::io;
use std::path::Path;

use npyz::npz::NpzWriter;
use rom_generator::vibration::{ModeSet, Shape};

use crate::atomic;
use crate::results::write_array;

/// Writes `omega` (m), `positions` (n x 3, m, in A), `translations` and `rotations` (m x n x 3, in space, axes of A, per unit amplitude of
/// the mode scaled to 1 kg m^2), `frame` (m x 6, the motion of A), `kinetic_share` (m x 6), `effective_mass` (m x 6) and
/// `centre_of_mass` (3).
///
/// # Errors
/// Those of the file system, naming the file.
pub fn write_npz(set: &ModeSet, path: &Path) -> io::Result<()> {
    let (m, n) = (set.modes.len() as u64, set.at.positions.len() as u64);
    let all = |of: &dyn Fn(&Shape) -> Vec<f64>| set.modes.iter().flat_map(of).collect::<Vec<f64>>();
    let flat = |v: &[nalgebra::Vector3<f64>]| v.iter().flat_map(|v| [v.x, v.y, v.z]).collect::<Vec<f64>>();
    atomic::write(path, |sink| {
        let mut archive = NpzWriter::new(sink);
        let mut array =
            |name: &str, shape: &[u64], data: Vec<f64>| write_array(&mut archive, name, shape, &data);
        array("omega", &[m], all(&|mode| vec![mode.omega]))?;
        array("positions", &[n, 3], flat(&set.at.positions))?;
        array("translations", &[m, n, 3], all(&|mode| flat(&mode.translations)))?;
        array("rotations", &[m, n, 3], all(&|mode| flat(&mode.rotations)))?;
        array("frame", &[m, 6], all(&|mode| mode.frame.iter().copied().collect()))?;
        array("kinetic_share", &[m, 6], all(&|mode| mode.kinetic_share.to_vec()))?;
        array("effective_mass", &[m, 6], all(&|mode| mode.effective_mass.to_vec()))?;
        array("centre_of_mass", &[3], set.centre_of_mass.iter().copied().collect())?;
        archive.zip_writer().finish()?;
        Ok(())
    })
}
