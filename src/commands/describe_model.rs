//! `romgen info` and `romgen export`.

use std::path::{Path, PathBuf};

use clap::ArgGroup;
use rom_fmu::description::Fmi;
use rom_runtime::Model;

use super::VERSION;
use crate::failure::Failure;
use crate::info::Info;
use crate::{describe, export, fmu, options, scene, terminal, vtk};

#[derive(Debug, clap::Args)]
#[command(after_help = INFO)]
pub(super) struct InfoArgs {
    /// Model file
    #[arg(value_name = "FILE.rom")]
    model: PathBuf,
    /// Print JSON for machines
    #[arg(long)]
    json: bool,
    /// Write an HTML report too: the same, with the modes moving in space
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Print nothing but errors (and JSON, if asked for)
    #[arg(long, short)]
    quiet: bool,
}

const INFO: &str = "Examples:
  romgen info fmb.rom
  romgen info fmb.rom --report fmb.html --quiet
  romgen info fmb.rom --json | jq '.modes[].frequency_hz'";

#[derive(Debug, clap::Args)]
#[command(after_help = EXPORT)]
#[command(group(ArgGroup::new("what").args(["npz", "vtk", "fmu"]).required(true).multiple(true)))]
pub(super) struct ExportArgs {
    /// Model file
    #[arg(value_name = "FILE.rom")]
    model: PathBuf,
    /// NumPy archive to write, with every array by name
    #[arg(long, value_name = "OUT.npz")]
    npz: Option<PathBuf>,
    /// VTK grid to write for ParaView: the structure with its mode shapes as vectors on the nodes
    #[arg(long, value_name = "OUT.vtu")]
    vtk: Option<PathBuf>,
    /// Co-simulation FMU to write: OUT.fmu for FMI 3.0 and OUT-fmi2.fmu for FMI 2.0
    #[arg(long, value_name = "OUT.fmu")]
    fmu: Option<PathBuf>,
    /// Write only the FMU of this version of FMI, to OUT.fmu: 2 or 3
    #[arg(long, requires = "fmu", value_parser = options::fmi_version)]
    fmi: Option<Fmi>,
    /// Blocks of stations among the variables, by name, or all: arrays in FMI 3.0, many scalars in FMI 2.0 [default: none]
    #[arg(long, requires = "fmu", value_parser = options::names, value_name = "NAMES")]
    stations: Option<Names>,
    /// Put the library for another platform into the FMU, such as x86_64-windows=rom_fmu.dll; repeatable
    #[arg(long, requires = "fmu", value_name = "PLATFORM=FILE", value_parser = options::assignment)]
    fmu_library: Vec<(String, String)>,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

/// Clap would take a bare vector for an option given several times.
type Names = Vec<String>;

const EXPORT: &str = "Examples:
  romgen export fmb.rom --npz fmb.npz
  romgen export fmb.rom --fmu fmb.fmu        for FMI 3.0; fmb-fmi2.fmu for FMI 2.0
  romgen export hale.rom --fmu hale.fmu --stations wing,tailplane
  romgen export fmb.rom --vtk modes.vtu      in ParaView: Warp By Vector, \"mode 1\"";

pub(super) fn info(args: &InfoArgs, command: &str) -> Result<(), Failure> {
    let model = read(&args.model)?;
    let info = Info::new(&model);
    if let Some(path) = &args.report {
        write_report(&model, &info, command, path)?;
    }
    if args.json {
        terminal::say_json(&info)?;
    } else if !args.quiet {
        let loaded: Vec<&str> =
            describe::loaded_points(model.data()).iter().map(|p| p.name.as_str()).collect();
        terminal::say(&info.to_text(&loaded))?;
    }
    Ok(())
}

/// Writes the report on a model.
pub(super) fn write_report(model: &Model, info: &Info, command: &str, path: &Path) -> Result<(), Failure> {
    let tool = format!("romgen {VERSION}");
    let document =
        info.report(scene::modes(model.data()), command, &tool, &model.data().provenance.input_text);
    Ok(document.write(path)?)
}

pub(super) fn export(args: &ExportArgs) -> Result<(), Failure> {
    let model = read(&args.model)?;
    let mut written = Vec::new();
    if let Some(path) = &args.npz {
        export::write_npz(model.data(), path)?;
        written.push(path.display().to_string());
    }
    if let Some(path) = &args.vtk {
        vtk::write_modes(model.data(), path)?;
        written.push(path.display().to_string());
    }
    if let Some(path) = &args.fmu {
        let stations = fmu::stations(&model, args.stations.as_deref().unwrap_or_default())?;
        let libraries = fmu::Libraries::new(&args.fmu_library)?;
        let file = std::fs::read(&args.model)?;
        let both = [(Fmi::V3, path.clone()), (Fmi::V2, fmu::path_of_version_2(path))];
        let wanted = match args.fmi {
            Some(version) => vec![(version, path.clone())],
            None => both.to_vec(),
        };
        for (version, path) in wanted {
            fmu::write(version, &model, &stations, &file, &libraries, &path)?;
            written.push(format!("{} ({})", path.display(), fmu::name(version)));
        }
    }
    if !args.quiet {
        for file in written {
            terminal::say(&format!("wrote {file}\n"))?;
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
