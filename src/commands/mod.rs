//! One module per command: arguments in, work done by the libraries, words and files out.

mod build;
mod codegen;
mod demo;
mod describe_model;
mod linearise;
mod manual;
mod modes;
mod reproduce;
mod run;
mod serve;
mod structure;
mod sweep;
mod validate;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::failure::Failure;
use crate::{interrupt, options};

/// Version of the tools as they name themselves in files.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Makes reduced-order models of flexible bodies that fly, and tells what is in them.
#[derive(Debug, Parser)]
#[command(name = "romgen", version, arg_required_else_help = true, after_help = ROMGEN)]
struct Romgen {
    #[command(subcommand)]
    command: Command,
}

const ROMGEN: &str = "Examples:
  romgen demo                                       the whole way, with a report that opens
  romgen build models/fmb.toml -o fmb.rom           make a model; then: romrun fmb.rom --loads lc2
  romgen info fmb.rom                               say what is in it
  romgen validate models/fmb.toml --loads lc2       set methods side by side
  romgen build --help                               options and examples of a command

Exit codes: 0 done, 1 other failure, 2 wrong input or command line, 3 numerical failure, 130 stopped by Ctrl-C.
Colours are shown on terminals only, and not where NO_COLOR is set.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Build a model file from a structure file
    Build(build::Args),
    /// Check a structure file and say what is in it, without building
    Check(structure::CheckArgs),
    /// Show the natural modes of a structure: table, pictures, frequencies against a load level
    Modes(modes::Args),
    /// Print the JSON Schema of structure files, for editors
    #[command(after_help = "Examples:\n  romgen schema > structure.schema.json")]
    Schema,
    /// Say what is in a model file
    Info(describe_model::InfoArgs),
    /// Write a model file for other programs: every array for NumPy, or a co-simulation FMU
    Export(describe_model::ExportArgs),
    /// Write a linear state-space model about the equilibrium, a trim or a steady rotation, and print its poles
    Linearise(linearise::Args),
    /// Write a model and its step as one self-contained C file
    Codegen(codegen::Args),
    /// Run a load case by several methods and say how far they are from the first
    Validate(validate::Args),
    /// Run the published cases and say, figure by figure, whether they come out
    Reproduce(reproduce::Args),
    /// Build the flexible multi-beam frame, run load case 2 and open its report
    Demo(demo::Args),
    /// Print a script that completes commands and options in a shell
    Completions(manual::CompletionsArgs),
    /// Write manual pages
    Man(manual::ManArgs),
    /// Print the command reference of the documentation
    #[command(hide = true)]
    Reference,
}

/// Marches load cases of a model file and writes what happens.
#[derive(Debug, Parser)]
#[command(name = "romrun", version)]
struct Romrun {
    #[command(flatten)]
    args: run::Args,
}

/// The program `romgen`.
pub fn romgen() -> ExitCode {
    let command = options::shell_command("romgen", std::env::args().skip(1));
    let parsed = Romgen::parse().command;
    // A build writes nothing before its end: Ctrl-C may end it on the spot.
    if matches!(parsed, Command::Validate(_) | Command::Reproduce(_) | Command::Demo(_)) {
        interrupt::listen();
    }
    let result = match parsed {
        Command::Build(args) => build::run(&args, command),
        Command::Check(args) => structure::check(&args),
        Command::Modes(args) => modes::run(&args, command),
        Command::Schema => structure::schema(),
        Command::Info(args) => describe_model::info(&args, &command),
        Command::Export(args) => describe_model::export(&args),
        Command::Linearise(args) => linearise::run(&args, &command),
        Command::Codegen(args) => codegen::run(&args),
        Command::Validate(args) => validate::run(&args, command),
        Command::Reproduce(args) => reproduce::run(&args, command),
        Command::Demo(args) => demo::run(&args),
        Command::Completions(args) => manual::completions(&args),
        Command::Man(args) => manual::man(&args),
        Command::Reference => manual::reference(),
    };
    finish(result)
}

/// The program `romrun`.
pub fn romrun() -> ExitCode {
    let command = options::shell_command("romrun", std::env::args().skip(1));
    let parsed = Romrun::parse();
    interrupt::listen();
    finish(run::run(&parsed.args.typed(command)))
}

fn finish(result: Result<(), Failure>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
