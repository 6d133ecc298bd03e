//! `romgen modes`: natural modes for people. Table, pictures and arrays of the modes of a structure about its equilibrium, and frequencies
//! against a load level.

mod arrays;
mod frequencies;
mod page;
mod picture;
mod table;
#[cfg(test)]
mod tests;

pub use arrays::write_npz;
pub use frequencies::{Frequencies, Level, Swept, frequencies};
pub use page::{frequency_page, frequency_plot, mode_page};
pub use picture::picture;
pub use table::{ModeRow, mode_rows, table};

use rom_generator::configuration::Configuration;
use rom_generator::equilibrium::trim;
use rom_generator::mesh::Mesh;
use rom_generator::vibration::{ModeSet, Parity, Support, VibrationError, analyse};

/// The modes of a mesh about the shape that its equilibrium, if any, says.
///
/// # Errors
/// No such equilibrium, no such modes.
pub fn of_mesh(mesh: &Mesh, support: Support, count: usize) -> Result<ModeSet, VibrationError> {
    let at = trim::of_mesh(mesh)?.map_or_else(|| Configuration::drawing(mesh), |found| found.configuration);
    analyse(mesh, at, support, count)
}

/// Symmetry of a mode about the planes of its set, in words.
fn symmetry(set: &ModeSet, parity: &[Parity]) -> String {
    let word = |(plane, parity): (&rom_generator::vibration::MirrorPlane, &Parity)| match (plane.flat, parity)
    {
        (true, Parity::Symmetric) => format!("in {}", plane.name()),
        (true, Parity::Antisymmetric) => format!("out of {}", plane.name()),
        (false, Parity::Symmetric) => format!("symmetric {}", plane.name()),
        (false, Parity::Antisymmetric) => format!("antisymmetric {}", plane.name()),
        (_, Parity::Mixed) => format!("mixed {}", plane.name()),
    };
    set.planes.iter().zip(parity).map(word).collect::<Vec<_>>().join(", ")
}
