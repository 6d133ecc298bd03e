//! Header, table of sections and checksums. Knows nothing of what the sections hold.

use alloc::vec::Vec;

use super::error::{FormatError, SectionName};

/// First bytes of every model file. Not text, and it notices a transfer that treats it as text.
pub const MAGIC: [u8; 8] = *b"\x89ROM\r\n\x1a\n";
/// A reader refuses files of another major version.
pub const VERSION_MAJOR: u16 = 1;
/// A reader accepts files of any minor version: they only add sections.
pub const VERSION_MINOR: u16 = 0;

/// Magic, versions (2 x u16), number of sections (u32), length of the file (u64).
pub(super) const HEADER: usize = 24;
/// Name, CRC-32, offset (u64), length (u64).
const ENTRY: usize = 24;
/// CRC-32 of header and table.
const TABLE_CHECKSUM: usize = 4;
/// What the checksum of header and table is called in errors.
const TABLE: SectionName = SectionName(*b"head");

/// A section: its name, where its bytes are, and the bytes.
pub(super) struct Section<'a> {
    pub(super) name: SectionName,
    pub(super) offset: u64,
    pub(super) bytes: &'a [u8],
}

/// The header, checked for magic and version.
pub(super) struct Header {
    n_sections: u32,
    pub(super) length: u64,
}

/// Joins sections to a file.
pub(super) fn write(sections: &[(SectionName, Vec<u8>)]) -> Result<Vec<u8>, FormatError> {
    let first = HEADER + sections.len() * ENTRY + TABLE_CHECKSUM;
    let length = first + sections.iter().map(|(_, bytes)| bytes.len()).sum::<usize>();
    let mut file = Vec::with_capacity(length);
    file.extend_from_slice(&MAGIC);
    file.extend_from_slice(&VERSION_MAJOR.to_le_bytes());
    file.extend_from_slice(&VERSION_MINOR.to_le_bytes());
    file.extend_from_slice(&(sections.len() as u32).to_le_bytes());
    file.extend_from_slice(&(length as u64).to_le_bytes());
    let mut offset = first;
    for (name, bytes) in sections {
        file.extend_from_slice(&name.0);
        file.extend_from_slice(&crc32fast::hash(bytes).to_le_bytes());
        file.extend_from_slice(&(offset as u64).to_le_bytes());
        file.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
        offset += bytes.len();
    }
    file.extend_from_slice(&crc32fast::hash(&file).to_le_bytes());
    for (_, bytes) in sections {
        file.extend_from_slice(bytes);
    }
    Ok(file)
}

/// Takes a file apart. When this returns, every byte of it has been covered by a checksum that agrees.
pub(super) fn read(file: &[u8]) -> Result<Vec<Section<'_>>, FormatError> {
    let header = header(file)?;
    let found = file.len() as u64;
    if found != header.length {
        return Err(FormatError::Length { what: "the file", offset: 0, found, expected: header.length });
    }
    // The table has to fit into the file before anything is made of its size. No overflow: u32 times a small number.
    let table_end = HEADER as u64 + u64::from(header.n_sections) * ENTRY as u64;
    let first = table_end + TABLE_CHECKSUM as u64;
    if found < first {
        let what = "the table of sections";
        return Err(FormatError::Length { what, offset: HEADER as u64, found, expected: first });
    }
    let mut reader = Reader { bytes: file };
    let covered = reader.take(table_end as usize).unwrap_or_default();
    verify(TABLE, 0, covered, reader.u32().unwrap_or_default())?;

    let mut entries = Reader { bytes: covered.get(HEADER..).unwrap_or_default() };
    let mut sections: Vec<Section<'_>> = Vec::with_capacity(header.n_sections as usize);
    let mut expected_offset = first;
    while let Some((name, checksum, offset, length)) = entries.entry() {
        let malformed = |problem| FormatError::Table { section: name, offset, problem };
        if offset != expected_offset {
            return Err(malformed("does not start where the one before ends"));
        }
        if sections.iter().any(|section| section.name == name) {
            return Err(malformed("appears twice"));
        }
        let rest = reader.bytes.len() as u64;
        if length > rest {
            let what = "the rest of the file, for a section,";
            return Err(FormatError::Length { what, offset, found: rest, expected: length });
        }
        let bytes = reader.take(length as usize).unwrap_or_default();
        verify(name, offset, bytes, checksum)?;
        sections.push(Section { name, offset, bytes });
        expected_offset += length;
    }
    if !reader.bytes.is_empty() {
        let (what, found) = ("what follows the last section", reader.bytes.len() as u64);
        return Err(FormatError::Length { what, offset: expected_offset, found, expected: 0 });
    }
    Ok(sections)
}

/// Magic, version and the numbers of the header. Needs no more than the first [`HEADER`] bytes.
pub(super) fn header(file: &[u8]) -> Result<Header, FormatError> {
    let mut reader = Reader { bytes: file };
    let mut found = [0; 8];
    for (found, byte) in found.iter_mut().zip(reader.take(8).unwrap_or(file)) {
        *found = *byte;
    }
    if found != MAGIC {
        return Err(FormatError::Magic { found, expected: MAGIC });
    }
    let short = || FormatError::Length {
        what: "the header",
        offset: 0,
        found: file.len() as u64,
        expected: HEADER as u64,
    };
    let found_major = reader.u16().ok_or_else(short)?;
    let found_minor = reader.u16().ok_or_else(short)?;
    if found_major != VERSION_MAJOR {
        return Err(FormatError::Version { found_major, found_minor, supported_major: VERSION_MAJOR });
    }
    Ok(Header { n_sections: reader.u32().ok_or_else(short)?, length: reader.u64().ok_or_else(short)? })
}

fn verify(what: SectionName, offset: u64, bytes: &[u8], expected: u32) -> Result<(), FormatError> {
    let found = crc32fast::hash(bytes);
    if found == expected { Ok(()) } else { Err(FormatError::Checksum { what, offset, found, expected }) }
}

/// Little-endian numbers off the front of a slice.
struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(n)?;
        self.bytes = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.bytes.split_first_chunk()?;
        self.bytes = rest;
        Some(*taken)
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn entry(&mut self) -> Option<(SectionName, u32, u64, u64)> {
        Some((SectionName(self.array()?), self.u32()?, self.u64()?, self.u64()?))
    }
}
