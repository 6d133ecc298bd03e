//! What the sections hold: the parts of [`ModelData`], each encoded by bincode.
//!
//! The only place that names bincode. Its bytes in this configuration (fixed-width, little-endian, u64 lengths, u32 enum
//! variants) are specified in `docs/rom-format.md`, so that another encoder can take over without changing a file.

use alloc::{format, string::ToString, vec, vec::Vec};
use bincode::config::{Configuration, Fixint, LittleEndian};
use serde::{Deserialize, Serialize};

use super::container::Section;
use super::error::{FormatError, SectionName};
use crate::data::ModelData;

const PROVENANCE: SectionName = SectionName(*b"PROV");
const RIGID: SectionName = SectionName(*b"RIGI");
const MODES: SectionName = SectionName(*b"MODE");
const TENSOR_C: SectionName = SectionName(*b"TENC");
const TENSOR_K: SectionName = SectionName(*b"TENK");
const POINTS: SectionName = SectionName(*b"PNTS");
const LOAD_CASES: SectionName = SectionName(*b"LOAD");
const PICTURE: SectionName = SectionName(*b"PICT");
const PICTURE_CURVE: SectionName = SectionName(*b"PCUR");
const TRIM: SectionName = SectionName(*b"TRIM");
const SENSORS: SectionName = SectionName(*b"SENS");
const GRAVITY: SectionName = SectionName(*b"GRAV");
const RESIDUAL: SectionName = SectionName(*b"RESI");
const VALIDITY: SectionName = SectionName(*b"VALI");
const SELECTION: SectionName = SectionName(*b"SELE");
const STATIONS: SectionName = SectionName(*b"STAT");
const CUTS: SectionName = SectionName(*b"CUTS");
const LINES: SectionName = SectionName(*b"LINE");
const LAGRANGIAN: SectionName = SectionName(*b"LAGR");
const DAMPING: SectionName = SectionName(*b"DAMP");
const CLAMPED: SectionName = SectionName(*b"CLMP");
const CHECKS: SectionName = SectionName(*b"CHEK");

const fn configuration() -> Configuration<LittleEndian, Fixint> {
    bincode::config::standard().with_little_endian().with_fixed_int_encoding()
}

/// Sections in the order of the file.
pub(super) fn encode(data: &ModelData) -> Result<Vec<(SectionName, Vec<u8>)>, FormatError> {
    let mut sections = vec![
        section(PROVENANCE, &data.provenance)?,
        section(RIGID, &data.rigid)?,
        section(MODES, &data.modes)?,
        section(TENSOR_C, &data.c)?,
        section(TENSOR_K, &data.k)?,
        section(POINTS, &data.points)?,
        section(LOAD_CASES, &data.load_cases)?,
        section(CHECKS, &data.checks)?,
    ];
    if let Some(picture) = &data.picture {
        sections.push(section(PICTURE, picture)?);
    }
    if let Some(curve) = &data.picture_curve {
        sections.push(section(PICTURE_CURVE, curve)?);
    }
    if let Some(trim) = &data.trim {
        sections.push(section(TRIM, trim)?);
    }
    if let Some(gravity) = &data.gravity {
        sections.push(section(GRAVITY, gravity)?);
    }
    if let Some(residual) = &data.residual {
        sections.push(section(RESIDUAL, residual)?);
    }
    if let Some(validity) = &data.validity {
        sections.push(section(VALIDITY, validity)?);
    }
    if let Some(selection) = &data.selection {
        sections.push(section(SELECTION, selection)?);
    }
    if !data.stations.is_empty() {
        sections.push(section(STATIONS, &data.stations)?);
    }
    if !data.cuts.is_empty() {
        sections.push(section(CUTS, &data.cuts)?);
    }
    if !data.lines.is_empty() {
        sections.push(section(LINES, &data.lines)?);
    }
    if let Some(lagrangian) = &data.lagrangian {
        sections.push(section(LAGRANGIAN, lagrangian)?);
    }
    if let Some(damping) = &data.damping {
        sections.push(section(DAMPING, damping)?);
    }
    if let Some(clamped) = &data.clamped {
        sections.push(section(CLAMPED, clamped)?);
    }
    if !data.sensors.is_empty() {
        sections.push(section(SENSORS, &data.sensors)?);
    }
    Ok(sections)
}

fn section<T: Serialize>(name: SectionName, value: &T) -> Result<(SectionName, Vec<u8>), FormatError> {
    match bincode::serde::encode_to_vec(value, configuration()) {
        Ok(bytes) => Ok((name, bytes)),
        Err(error) => Err(FormatError::Encode { section: name, problem: error.to_string() }),
    }
}

/// Model data from checked sections. Unknown sections (of a newer minor version) are left alone.
pub(super) fn decode(sections: &[Section<'_>]) -> Result<ModelData, FormatError> {
    Ok(ModelData {
        provenance: required(sections, PROVENANCE)?,
        rigid: required(sections, RIGID)?,
        modes: required(sections, MODES)?,
        c: required(sections, TENSOR_C)?,
        k: required(sections, TENSOR_K)?,
        points: required(sections, POINTS)?,
        load_cases: required(sections, LOAD_CASES)?,
        picture: optional(sections, PICTURE)?,
        picture_curve: optional(sections, PICTURE_CURVE)?,
        trim: optional(sections, TRIM)?,
        sensors: optional(sections, SENSORS)?.unwrap_or_default(),
        gravity: optional(sections, GRAVITY)?,
        residual: optional(sections, RESIDUAL)?,
        validity: optional(sections, VALIDITY)?,
        selection: optional(sections, SELECTION)?,
        lines: optional(sections, LINES)?.unwrap_or_default(),
        lagrangian: optional(sections, LAGRANGIAN)?,
        stations: optional(sections, STATIONS)?.unwrap_or_default(),
        cuts: optional(sections, CUTS)?.unwrap_or_default(),
        damping: optional(sections, DAMPING)?,
        clamped: optional(sections, CLAMPED)?,
        checks: required(sections, CHECKS)?,
    })
}

fn required<'a, T: Deserialize<'a>>(sections: &[Section<'a>], name: SectionName) -> Result<T, FormatError> {
    optional(sections, name)?.ok_or(FormatError::Missing { section: name })
}

/// Memory stays in proportion to the section: strings are borrowed from it before they are copied
/// ([`super::text`]), and serde reserves at most 1 MiB for a sequence before it has seen its elements.
fn optional<'a, T: Deserialize<'a>>(
    sections: &[Section<'a>],
    name: SectionName,
) -> Result<Option<T>, FormatError> {
    let Some(section) = sections.iter().find(|section| section.name == name) else { return Ok(None) };
    let failed = |problem| FormatError::Decode { section: name, offset: section.offset, problem };
    let (value, used) = bincode::serde::borrow_decode_from_slice(section.bytes, configuration())
        .map_err(|error| failed(error.to_string()))?;
    if used != section.bytes.len() {
        return Err(failed(format!("it has {} bytes, its contents end after {used}", section.bytes.len())));
    }
    Ok(Some(value))
}
