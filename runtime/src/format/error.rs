//! Errors of the model file.

use alloc::string::String;

use crate::error::ModelError;

/// Why a model file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The first bytes are not those of a model file.
    #[error("not a .rom model file: it starts with {found:02x?}, expected {expected:02x?}")]
    Magic {
        /// The first eight bytes, or as many as there are, padded with zeros.
        found: [u8; 8],
        /// The magic.
        expected: [u8; 8],
    },
    /// The file follows a format this version cannot read.
    #[error(
        "the model file has format version {found_major}.{found_minor}, this program reads {supported_major}.x; \
         read it with a newer program, or build it again from its structure file with this one"
    )]
    Version {
        /// Major version of the file.
        found_major: u16,
        /// Minor version of the file.
        found_minor: u16,
        /// Major version this program reads.
        supported_major: u16,
    },
    /// The file is shorter or longer than it says, or than its parts need.
    #[error(
        "the model file is damaged at byte {offset}: {what} is {found} bytes, expected {expected} \
         (a broken download or a file cut short?)"
    )]
    Length {
        /// What has the wrong length.
        what: &'static str,
        /// Where, from the start of the file.
        offset: u64,
        /// Bytes found.
        found: u64,
        /// Bytes expected.
        expected: u64,
    },
    /// A checksum does not agree with the bytes it covers.
    #[error(
        "the model file is damaged: CRC-32 of {what} (from byte {offset}) is {found:08x}, expected {expected:08x}"
    )]
    Checksum {
        /// What the checksum covers.
        what: SectionName,
        /// First byte covered.
        offset: u64,
        /// Of the bytes.
        found: u32,
        /// Stored in the file.
        expected: u32,
    },
    /// The table of sections breaks a rule of the format.
    #[error("the model file is malformed: section {section} at byte {offset} {problem}")]
    Table {
        /// Which.
        section: SectionName,
        /// Where the table says it is.
        offset: u64,
        /// In words.
        problem: &'static str,
    },
    /// A section that every file must have is missing.
    #[error("the model file has no section {section}, which every model needs")]
    Missing {
        /// Which.
        section: SectionName,
    },
    /// A section does not decode.
    #[error("section {section} of the model file (from byte {offset}) does not decode: {problem}")]
    Decode {
        /// Which.
        section: SectionName,
        /// Where it starts.
        offset: u64,
        /// The decoder's message.
        problem: String,
    },
    /// The data cannot be encoded.
    #[error("section {section} cannot be encoded: {problem}")]
    Encode {
        /// Which.
        section: SectionName,
        /// The encoder's message.
        problem: String,
    },
    /// The file is sound but its contents make no model.
    #[error("the model file is complete, but its contents make no model: {0}")]
    Model(#[from] ModelError),
    /// The operating system refused.
    #[cfg(feature = "std")]
    #[error("cannot {action}: {source}")]
    Io {
        /// What was being done.
        action: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Any of the others, with the file it happened in.
    #[cfg(feature = "std")]
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: std::path::PathBuf,
        /// What happened.
        source: alloc::boxed::Box<FormatError>,
    },
}

/// Four-letter name of a section, or the table itself.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct SectionName(pub [u8; 4]);

impl core::fmt::Display for SectionName {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "\"{}\"", self.0.escape_ascii())
    }
}

impl core::fmt::Debug for SectionName {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        core::fmt::Display::fmt(self, f)
    }
}
