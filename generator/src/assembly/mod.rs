//! From elements to sparse block matrices: the pattern once, then sums in element order.

pub mod block_matrix;
pub mod strain_form;
pub mod structure;

pub use block_matrix::{BlockMatrix, BlockPattern};
pub use strain_form::StrainForm;
pub use structure::{AnyBeam, Assembly, MassMatrix, beam_of, beams};
