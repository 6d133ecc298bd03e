//! `romgen demo`: the main job without any other file.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use rom_generator::build::BuildOptions;
use rom_generator::input::Structure;

use super::{build, run};
use crate::failure::Failure;
use crate::published::FRAME;
use crate::{atomic, options, terminal};

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    /// Folder for the structure file, the model and the results, made if missing
    #[arg(long, default_value = "fmb-demo", value_name = "DIR")]
    out: PathBuf,
    /// Give a parameter of the frame another value (sigma: stiffness, elements: mesh); repeatable
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = options::assignment)]
    sets: Vec<(String, String)>,
    /// Do not open the report
    #[arg(long)]
    no_open: bool,
}

const EXAMPLES: &str = "Examples:
  romgen demo
  romgen demo --set sigma=3 --out soft --no-open";

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    atomic::make_folder(&args.out)?;
    let (toml, model) = (args.out.join("fmb.toml"), args.out.join("fmb.rom"));
    atomic::write(&toml, |sink| sink.write_all(FRAME.as_bytes()))?;
    let structure = Structure::from_toml_path(&toml, &args.sets)?;
    let options = BuildOptions { all_nodes: false, ..BuildOptions::default() };
    build::write_model(&structure, &options, &model, &build::Telling::default())?;
    let command = ["--loads", "lc2", "--out"].map(String::from).into_iter();
    let command =
        std::iter::once(model.display().to_string()).chain(command).chain([args.out.display().to_string()]);
    let command = options::shell_command("romrun", command);
    run::run(&run::Args::one(model, "lc2", args.out.clone(), command))?;
    let report = args.out.join("report.html");
    if args.no_open || !open(&report) {
        terminal::say(&format!("open {} in a browser\n", report.display()))?;
    }
    Ok(())
}

/// Hands a file to what the desktop opens such files with, if there is a desktop; says whether it did.
fn open(path: &Path) -> bool {
    let (program, arguments): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("cmd", &["/C", "start", ""])
    } else {
        let has_display =
            ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|v| std::env::var_os(v).is_some_and(|v| !v.is_empty()));
        if !has_display {
            return false;
        }
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(path).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // Whether it exits at once or stays is its own business; that it could not be started is ours.
    command.spawn().is_ok()
}
