//! The published structures, part of the program.

/// Flexible multi-beam frame (Hesse & Palacios 2012, section 4.2): `models/fmb.toml`.
pub const FRAME: &str = include_str!("../models/fmb.toml");

/// Flying flexible beam (section 4.1): `models/ffb.toml`.
pub const BEAM: &str = include_str!("../models/ffb.toml");
