//! `romgen linearise`.

use std::path::PathBuf;
use std::sync::Arc;

use rom_generator::linearise::{LineariseError, Request, linearise};
use rom_runtime::{LoadCase, Method};

use super::{VERSION, describe_model, run};
use crate::failure::Failure;
use crate::linearise::{Kind, Origin, to_json, to_text, write};
use crate::{options, terminal};

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    /// Model file
    #[arg(value_name = "FILE.rom")]
    model: PathBuf,
    /// File to write: .npz for NumPy, .mat for MATLAB and Octave, .svg for a plot of the poles, .html for a page to look at; repeatable
    /// [default: write nothing, print the poles]
    #[arg(short, long, value_name = "OUT.npz|.mat|.svg|.html", value_parser = output)]
    output: Vec<Output>,
    /// Load case whose loads act and whose initial state is where the search begins: a name in the model, or NAME of a file of load
    /// cases (FILE.toml:NAME) [default: the equilibrium of the model]
    #[arg(long, value_name = "NAME|FILE.toml[:NAME]")]
    loads: Option<String>,
    /// Time at which the loads are taken, s
    #[arg(long, default_value_t = 0.0)]
    time: f64,
    /// Velocity of the origin of A in A, m/s, instead of the load case's
    #[arg(long, value_name = "X,Y,Z", value_parser = options::three, allow_hyphen_values = true)]
    velocity: Option<Three>,
    /// Angular velocity of A in A, rad/s, instead of the load case's. A free body turns about the principal axis next to it
    #[arg(long, value_name = "X,Y,Z", value_parser = options::three, allow_hyphen_values = true)]
    rate: Option<Three>,
    /// Loads of the equilibrium whose factors may change for the balance (lift,elevator)
    #[arg(long, value_name = "NAMES", value_parser = options::names)]
    balance: Option<Names>,
    /// Balance what is left by a wrench on A, constant in A
    #[arg(long)]
    hold: bool,
    /// Inputs: points and blocks of stations (force and moment), A (a wrench, or its acceleration where something moves it), loads of
    /// the equilibrium (their factor), modes [default: the points that load cases load, A, all loads of the equilibrium]
    #[arg(long, value_name = "NAMES", value_parser = options::names)]
    inputs: Option<Names>,
    /// Outputs: A, points, blocks of stations, sensors, places of internal loads, modes, and reaction where something moves A
    /// [default: A or reaction, all sensors and places of internal loads, the points that load cases load]
    #[arg(long, value_name = "NAMES", value_parser = options::names)]
    outputs: Option<Names>,
    /// Leave out the states that nothing depends on: position, heading, in weightlessness the attitude
    #[arg(long)]
    reduce: bool,
    /// Method: rom (the reduced model), mean-axes or rigid
    #[arg(long, default_value = "rom")]
    method: Method,
    /// Print names, steady state and poles as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing but errors (and JSON, if asked for)
    #[arg(long, short)]
    quiet: bool,
}

/// Clap would take these for options given several times.
type Names = Vec<String>;
type Three = [f64; 3];

const EXAMPLES: &str = "Examples:
  romgen linearise fmb.rom -o fmb.mat                            about the equilibrium of the model
  romgen linearise hale.rom --reduce --inputs elevator --outputs A -o pitch.npz
  romgen linearise fmb.rom -o poles.svg                          a plot of the poles
  romgen linearise fmb.rom --rate 0,0.5,0 --json | jq .poles     about a steady rotation
  romgen linearise hale.rom --velocity 25,0,0 --rate 0,0,0.1 --hold    held on a turn";

/// A file to write.
type Output = (PathBuf, Kind);

fn output(text: &str) -> Result<Output, String> {
    let path = PathBuf::from(text);
    match Kind::of(&path) {
        Some(kind) => Ok((path, kind)),
        None => Err(format!("expected a name that ends in .npz, .mat, .svg or .html, found {text:?}")),
    }
}

pub(super) fn run(args: &Args, command: &str) -> Result<(), Failure> {
    let model = Arc::new(describe_model::read(&args.model)?);
    let case = case(args, &model)?;
    let model = match args.method {
        Method::Rom => model,
        simpler => Arc::new(model.with_method(simpler).map_err(|e| {
            Failure::input(
                e.to_string(),
                "build the model again with `romgen build`, or take another --method",
            )
        })?),
    };
    let request = Request {
        time: args.time,
        velocity: args.velocity,
        rate: args.rate,
        balance: args.balance.clone().unwrap_or_default(),
        hold: args.hold,
        inputs: args.inputs.clone(),
        outputs: args.outputs.clone(),
        reduce: args.reduce,
        ..case.map_or_else(Request::of_equilibrium, Request::new)
    };
    let found = linearise(&model, &request).map_err(failed)?;
    let name = model.data().provenance.name.clone();
    let origin = Origin { name, command: command.to_owned(), tool: format!("romgen {VERSION}") };
    for (path, kind) in &args.output {
        write(&found, path, *kind, &origin)?;
    }
    if args.json {
        terminal::say_json(&to_json(&found))?;
    } else if !args.quiet {
        let mut text = format!("{}: linear model\n", args.model.display());
        text += &to_text(&found);
        for (path, _) in &args.output {
            text += &format!("\n  wrote {}\n", path.display());
        }
        terminal::say(&text)?;
    }
    Ok(())
}

/// The load case asked for.
fn case(args: &Args, model: &rom_runtime::Model) -> Result<Option<LoadCase>, Failure> {
    let Some(loads) = &args.loads else { return Ok(None) };
    let (file, name) = match loads.rsplit_once(':') {
        Some((file, name)) if run::is_file(file) => (file, Some(name)),
        _ => (loads.as_str(), None),
    };
    let cases = run::load_cases(model, &[file.to_owned()], &[])?;
    let names = || cases.iter().map(|case| case.name.as_str()).collect::<Vec<_>>().join(", ");
    match name {
        Some(name) => match cases.iter().find(|case| case.name == name) {
            Some(case) => Ok(Some(case.clone())),
            None => Err(Failure::input(
                format!("{file} has no load case {name:?}"),
                format!("it has: {}", names()),
            )),
        },
        None if cases.len() > 1 => Err(Failure::input(
            format!("a linear model is about one load case, {file} stands for {}", cases.len()),
            format!("take one of: {} (of a file: {file}:NAME)", names()),
        )),
        None => Ok(cases.into_iter().next()),
    }
}

fn failed(error: LineariseError) -> Failure {
    let message = error.to_string();
    match error {
        LineariseError::NotSteady { .. } => Failure::numerical(
            message,
            "let loads of the equilibrium change (--balance), hold A by a wrench (--hold), build the model about its \
             [equilibrium], or choose another --time of the load case",
        ),
        LineariseError::Passing { .. } => Failure::numerical(
            message,
            "turn about the direction of gravity, or without it; loads constant in G cannot act on a body that turns",
        ),
        LineariseError::Accelerated { .. } => {
            Failure::input(message, "choose a --time at which A moves steadily, or another load case")
        }
        LineariseError::Dense(_) => Failure::numerical(message, "look at the matrices in the .npz file"),
        LineariseError::Step(_) => Failure::input(message, "take --method rom"),
        _ => Failure::input(message, "see docs/linearise.md"),
    }
}
