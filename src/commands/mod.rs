//! One module per command: arguments in, work done by the libraries, words and files out.

mod build;
mod demo;
mod describe_model;
mod modes;
mod reproduce;
mod run;
mod structure;
mod validate;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::failure::Failure;
use crate::options;

/// Version of the tools as they name themselves in files.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Makes reduced-order models of flexible bodies that fly, and tells what is in them.
#[derive(Debug, Parser)]
#[command(name = "romgen", version, arg_required_else_help = true, after_help = EXIT_CODES)]
struct Romgen {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str =
    "Exit codes: 0 done, 1 other failure, 2 wrong input or command line, 3 numerical failure";

#[derive(Debug, Subcommand)]
enum Command {
    /// Build a model file from a structure file
    Build(build::Args),
    /// Check a structure file and say what is in it, without building
    Check(structure::CheckArgs),
    /// Show the natural modes of a structure: table, pictures, frequencies against a load level
    Modes(modes::Args),
    /// Print the JSON Schema of structure files, for editors
    Schema,
    /// Say what is in a model file
    Info(describe_model::InfoArgs),
    /// Write every array of a model file for other languages
    Export(describe_model::ExportArgs),
    /// Run a load case by several methods and say how far they are from the first
    Validate(validate::Args),
    /// Run the published cases and say, figure by figure, whether they come out
    Reproduce(reproduce::Args),
    /// Build the flexible multi-beam frame, run load case 2 and open its report
    Demo(demo::Args),
}

/// Marches load cases of a model file and writes what happens.
#[derive(Debug, Parser)]
#[command(name = "romrun", version, after_help = EXIT_CODES)]
struct Romrun {
    #[command(flatten)]
    args: run::Args,
}

/// The program `romgen`.
pub fn romgen() -> ExitCode {
    let command = options::shell_command("romgen", std::env::args().skip(1));
    let result = match Romgen::parse().command {
        Command::Build(args) => build::run(&args),
        Command::Check(args) => structure::check(&args),
        Command::Modes(args) => modes::run(&args, command),
        Command::Schema => structure::schema(),
        Command::Info(args) => describe_model::info(&args),
        Command::Export(args) => describe_model::export(&args),
        Command::Validate(args) => validate::run(&args, command),
        Command::Reproduce(args) => reproduce::run(&args, command),
        Command::Demo(args) => demo::run(&args),
    };
    finish(result)
}

/// The program `romrun`.
pub fn romrun() -> ExitCode {
    let command = options::shell_command("romrun", std::env::args().skip(1));
    finish(run::run(&Romrun::parse().args.typed(command)))
}

fn finish(result: Result<(), Failure>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
