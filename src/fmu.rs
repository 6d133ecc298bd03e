//! Functional mock-up units: a description, a model file and libraries in one archive.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use rom_fmu::description::{Fmi, model_description, model_identifier};
use rom_fmu::token::Token;
use rom_fmu::variables::check_stations;
use rom_fmu::{MODEL_FILE, STATIONS_FILE};
use rom_runtime::Model;
use zip::write::FileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::atomic;
use crate::failure::Failure;

/// The library for the platform that this program was built for, see build.rs; empty where there is none.
const OWN: &[u8] = include_bytes!(env!("ROM_FMU_LIBRARY"));
const OWN_PLATFORM: &str = env!("ROM_FMU_PLATFORM");

/// Platforms: as FMI 3.0 names them, as FMI 2.0 does, ending of their libraries.
const PLATFORMS: [(&str, Option<&str>, &str); 8] = [
    ("x86_64-linux", Some("linux64"), "so"),
    ("x86-linux", Some("linux32"), "so"),
    ("aarch64-linux", None, "so"),
    ("x86_64-windows", Some("win64"), "dll"),
    ("x86-windows", Some("win32"), "dll"),
    ("aarch64-windows", None, "dll"),
    ("x86_64-darwin", Some("darwin64"), "dylib"),
    ("aarch64-darwin", None, "dylib"),
];

/// The libraries to put into an FMU: place among the platforms, and bytes.
#[derive(Debug)]
pub struct Libraries(Vec<(usize, Vec<u8>)>);

impl Libraries {
    /// The own one, and files for other platforms, which may replace it.
    ///
    /// # Errors
    /// Platforms that do not exist or are named twice, files that cannot be read, and no library at all.
    pub fn new(given: &[(String, String)]) -> Result<Self, Failure> {
        let mut all: Vec<(usize, Vec<u8>)> = Vec::new();
        for (name, path) in given {
            let Some(place) = PLATFORMS.iter().position(|(platform, ..)| platform == name) else {
                let known = PLATFORMS.map(|(platform, ..)| platform).join(", ");
                return Err(Failure::input(
                    format!("--fmu-library: there is no platform {name}"),
                    format!("expected one of {known}"),
                ));
            };
            if all.iter().any(|(known, _)| *known == place) {
                return Err(Failure::input(
                    format!("--fmu-library: {name} is given twice"),
                    "an FMU has one library for a platform",
                ));
            }
            let bytes = fs::read(path).map_err(|e| {
                Failure::input(
                    format!("--fmu-library: {path}: {e}"),
                    "expected the library that `cargo build --release -p rom-fmu` makes on that platform",
                )
            })?;
            all.push((place, bytes));
        }
        let own = PLATFORMS.iter().position(|(platform, ..)| *platform == OWN_PLATFORM);
        if let Some(own) = own.filter(|own| !OWN.is_empty() && all.iter().all(|(place, _)| place != own)) {
            all.push((own, OWN.to_vec()));
        }
        if all.is_empty() {
            return Err(Failure::input(
                format!("this program was built without an FMU library for {OWN_PLATFORM}"),
                "make one with `cargo build --release -p rom-fmu` and give it: --fmu-library PLATFORM=FILE",
            ));
        }
        all.sort();
        Ok(Self(all))
    }
}

/// The standard by its name.
pub fn name(version: Fmi) -> &'static str {
    match version {
        Fmi::V2 => "FMI 2.0",
        Fmi::V3 => "FMI 3.0",
    }
}

/// Where the FMU for FMI 2.0 goes that is written along with one for FMI 3.0: `fmb-fmi2.fmu` beside `fmb.fmu`.
pub fn path_of_version_2(path: &Path) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push("-fmi2");
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Indices of blocks of stations by their names; `all` is for all.
///
/// # Errors
/// Blocks that the model does not have, or more stations than an FMU has variables for.
pub fn stations(model: &Model, names: &[String]) -> Result<Vec<usize>, Failure> {
    let help = "--stations takes names of the model's blocks of stations, or all";
    let all: Result<Vec<usize>, String> = if names == ["all"] {
        match model.data().stations.len() {
            0 => Err("the model has no block of stations".to_owned()),
            n => Ok((0..n).collect()),
        }
    } else {
        names.iter().map(|name| model.station_block(name).map_err(|e| e.to_string())).collect()
    };
    let checked = all.and_then(|all| check_stations(model.data(), &all).map(|()| all));
    checked.map_err(|message| Failure::input(message, help))
}

/// Writes the FMU of a model, whose file has the bytes `file`, with the blocks of stations of these indices among its variables. The same
/// model gives the same bytes.
///
/// # Errors
/// Those of the file system, naming the file; a platform that the version of FMI has no name for.
pub fn write(
    version: Fmi,
    model: &Model,
    stations: &[usize],
    file: &[u8],
    libraries: &Libraries,
    path: &Path,
) -> Result<(), Failure> {
    let identifier = model_identifier(model.data());
    let mut entries: Vec<(String, &[u8])> = Vec::new();
    let description = model_description(version, model, stations, Token::of_model(file, stations));
    entries.push(("modelDescription.xml".to_owned(), description.as_bytes()));
    for (place, library) in &libraries.0 {
        let (platform, old_name, ending) = PLATFORMS[*place];
        let folder = match version {
            Fmi::V3 => platform,
            Fmi::V2 => old_name.ok_or_else(|| {
                Failure::input(
                    format!("FMI 2.0 has no name for the platform {platform}"),
                    "write an FMU for FMI 3.0: --fmi 3",
                )
            })?,
        };
        entries.push((format!("binaries/{folder}/{identifier}.{ending}"), library));
    }
    let indices: String = stations.iter().map(|block| format!("{block}\n")).collect();
    if !stations.is_empty() {
        entries.push((format!("resources/{STATIONS_FILE}"), indices.as_bytes()));
    }
    entries.push((format!("resources/{MODEL_FILE}"), file));
    atomic::write(path, |sink| {
        let mut archive = ZipWriter::new(sink);
        for (name, bytes) in &entries {
            let options = FileOptions::default()
                .compression_method(CompressionMethod::Deflated)
                .last_modified_time(DateTime::default())
                .unix_permissions(if name.starts_with("binaries") { 0o755 } else { 0o644 });
            archive.start_file(name, options).map_err(io::Error::from)?;
            archive.write_all(bytes)?;
        }
        archive.finish().map_err(io::Error::from)?;
        Ok(())
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_file_is_beside_the_first() {
        for (path, second) in
            [("a/fmb.fmu", "a/fmb-fmi2.fmu"), ("fmb", "fmb-fmi2"), ("x.y.fmu", "x.y-fmi2.fmu")]
        {
            assert_eq!(path_of_version_2(Path::new(path)), Path::new(second));
        }
    }

    #[test]
    fn platforms_are_known_or_refused() {
        for given in [("amiga", "a"), ("x86_64-windows", "no such file")] {
            let given = [(given.0.to_owned(), given.1.to_owned())];
            assert_eq!(Libraries::new(&given).unwrap_err().code(), 2);
        }
    }
}
