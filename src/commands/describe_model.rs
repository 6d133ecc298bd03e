//! `romgen info` and `romgen export`.

use std::path::{Path, PathBuf};

use clap::ArgGroup;
use rom_fmu::description::Fmi;
use rom_runtime::Model;

use crate::failure::Failure;
use crate::info::Info;
use crate::{describe, export, fmu, options, terminal};

#[derive(Debug, clap::Args)]
pub(super) struct InfoArgs {
    /// Model file
    #[arg(value_name = "FILE.rom")]
    model: PathBuf,
    /// Print JSON for machines
    #[arg(long)]
    json: bool,
}

#[derive(Debug, clap::Args)]
#[command(group(ArgGroup::new("what").args(["npz", "fmu"]).required(true).multiple(true)))]
pub(super) struct ExportArgs {
    /// Model file
    #[arg(value_name = "FILE.rom")]
    model: PathBuf,
    /// NumPy archive to write, with every array by name
    #[arg(long, value_name = "OUT.npz")]
    npz: Option<PathBuf>,
    /// Co-simulation FMU to write: OUT.fmu for FMI 3.0 and OUT-fmi2.fmu for FMI 2.0
    #[arg(long, value_name = "OUT.fmu")]
    fmu: Option<PathBuf>,
    /// Write only the FMU of this version of FMI, to OUT.fmu: 2 or 3
    #[arg(long, requires = "fmu", value_parser = options::fmi_version)]
    fmi: Option<Fmi>,
    /// Put the library for another platform into the FMU, such as x86_64-windows=rom_fmu.dll; repeatable
    #[arg(long, requires = "fmu", value_name = "PLATFORM=FILE", value_parser = options::assignment)]
    fmu_library: Vec<(String, String)>,
}

pub(super) fn info(args: &InfoArgs) -> Result<(), Failure> {
    let model = read(&args.model)?;
    let info = Info::new(&model);
    if args.json {
        terminal::say_json(&info)?;
    } else {
        let loaded: Vec<&str> =
            describe::loaded_points(model.data()).iter().map(|p| p.name.as_str()).collect();
        terminal::say(&info.to_text(&loaded))?;
    }
    Ok(())
}

pub(super) fn export(args: &ExportArgs) -> Result<(), Failure> {
    let model = read(&args.model)?;
    if let Some(path) = &args.npz {
        export::write_npz(model.data(), path)?;
        terminal::say(&format!("wrote {}\n", path.display()))?;
    }
    if let Some(path) = &args.fmu {
        let libraries = fmu::Libraries::new(&args.fmu_library)?;
        let file = std::fs::read(&args.model)?;
        let both = [(Fmi::V3, path.clone()), (Fmi::V2, fmu::path_of_version_2(path))];
        let wanted = match args.fmi {
            Some(version) => vec![(version, path.clone())],
            None => both.to_vec(),
        };
        for (version, path) in wanted {
            fmu::write(version, &model, &file, &libraries, &path)?;
            terminal::say(&format!("wrote {} ({})\n", path.display(), fmu::name(version)))?;
        }
    }
    Ok(())
}

/// Reads a model file.
pub(super) fn read(path: &Path) -> Result<Model, Failure> {
    Model::read_path(path).map_err(|e| {
        Failure::input(e.to_string(), "expected a model file written by `romgen build STRUCTURE -o FILE.rom`")
    })
}
