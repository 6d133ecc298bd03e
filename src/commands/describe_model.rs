//! `romgen info` and `romgen export`.

use std::path::{Path, PathBuf};

use rom_runtime::Model;

use crate::failure::Failure;
use crate::info::Info;
use crate::{describe, export, terminal};

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
pub(super) struct ExportArgs {
    /// Model file
    #[arg(value_name = "FILE.rom")]
    model: PathBuf,
    /// NumPy archive to write, with every array by name
    #[arg(long, value_name = "OUT.npz")]
    npz: PathBuf,
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
    export::write_npz(model.data(), &args.npz)?;
    terminal::say(&format!("wrote {}\n", args.npz.display()))?;
    Ok(())
}

/// Reads a model file.
pub(super) fn read(path: &Path) -> Result<Model, Failure> {
    Model::read_path(path).map_err(|e| {
        Failure::input(e.to_string(), "expected a model file written by `romgen build STRUCTURE -o FILE.rom`")
    })
}
