//! The `.rom` model file: `docs/rom-format.md` specifies it byte by byte.
//!
//! A container of our own (magic, version, table of sections, checksums over every byte) around sections encoded by
//! bincode in its fixed-width little-endian configuration. Reading checks, in this order: that the file is one, its
//! version, its length, the checksums, then decodes, then checks the meaning ([`Model::new`]); nothing is allocated for
//! contents before the checksums agree. The same model gives the same bytes.

mod container;
mod error;
#[cfg(feature = "std")]
mod file;
mod sections;
pub(crate) mod text;

pub use container::{MAGIC, VERSION_MAJOR, VERSION_MINOR};
pub use error::FormatError;

use alloc::vec::Vec;

use crate::data::ModelData;
use crate::model::Model;

impl ModelData {
    /// The bytes of the model file.
    ///
    /// # Errors
    /// None for data that fits into memory; kept for the encoder's sake.
    pub fn to_bytes(&self) -> Result<Vec<u8>, FormatError> {
        container::write(&sections::encode(self)?)
    }

    /// Decodes a model file without checking its meaning.
    ///
    /// # Errors
    /// [`FormatError`] for anything that is not a complete, undamaged file of a supported version.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        sections::decode(&container::read(bytes)?)
    }
}

impl Model {
    /// The bytes of the model file.
    ///
    /// # Errors
    /// As [`ModelData::to_bytes`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, FormatError> {
        self.data().to_bytes()
    }

    /// A model from the bytes of its file.
    ///
    /// # Errors
    /// [`FormatError`] for a file that is damaged, of a newer format, or whose contents make no model.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Ok(Model::new(ModelData::from_bytes(bytes)?)?)
    }
}
