//! `romgen build`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use rom_generator::build::{BuildOptions, ModeSelection, build};
use rom_generator::input::Structure;
use rom_runtime::Model;

use super::structure::StructureArgs;
use crate::failure::Failure;
use crate::options::{self, Modes};
use crate::terminal;
use crate::text::{significant, thousands};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    structure: StructureArgs,
    /// Elastic modes to keep: the lowest so many (10), these (1,2,5), or all up to a frequency (60Hz, 400rad/s)
    #[arg(long, default_value = "10", value_parser = options::modes)]
    modes: Modes,
    /// Keep the mode shapes at every node, for pictures
    #[arg(long)]
    all_nodes: bool,
    /// Model file to write [default: the structure file's name with .rom, here]
    #[arg(short, long, value_name = "FILE.rom")]
    output: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let structure = args.structure.read()?;
    let output = match &args.output {
        Some(path) => path.clone(),
        None => Path::new(args.structure.path().file_name().unwrap_or_default()).with_extension("rom"),
    };
    write_model(&structure, &args.modes, args.all_nodes, &output, args.quiet)
}
