//! `romgen info` and `romgen export`.

use std::path::{Path, PathBuf};

use rom_runtime::Model;

use super::VERSION;
use crate::failure::Failure;
use crate::info::Info;
use crate::{describe, export, scene, terminal, vtk};

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
#[command(after_help = EXPORT, group = clap::ArgGroup::new("what").required(true).multiple(true))]
pub(super) struct ExportArgs {
    /// Model file
    #[arg(value_name = "FILE.rom")]
    model: PathBuf,
    /// NumPy archive to write, with every array by name
    #[arg(long, value_name = "OUT.npz", group = "what")]
    npz: Option<PathBuf>,
    /// VTK grid to write for ParaView: the structure with its mode shapes as vectors on the nodes
    #[arg(long, value_name = "OUT.vtu", group = "what")]
    vtk: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

const EXPORT: &str = "Examples:
  romgen export fmb.rom --npz fmb.npz
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
    if let Some(path) = &args.npz {
        export::write_npz(model.data(), path)?;
    }
    if let Some(path) = &args.vtk {
        vtk::write_modes(model.data(), path)?;
    }
    if !args.quiet {
        for path in [&args.npz, &args.vtk].into_iter().flatten() {
            terminal::say(&format!("wrote {}\n", path.display()))?;
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
