//! `romgen codegen`.

use std::path::PathBuf;

use rom_runtime::{Method, Model};

use super::{VERSION, describe_model};
use crate::codegen::{self, Request};
use crate::failure::Failure;
use crate::{atomic, options, terminal};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Model file
    #[arg(value_name = "FILE.rom")]
    model: PathBuf,
    /// C file to write [default: the name of the model file with .c]
    #[arg(long, short, value_name = "OUT.c")]
    out: Option<PathBuf>,
    /// Load case of the model that is written into the file; a host can load it besides
    #[arg(long, value_name = "NAME")]
    loads: Option<String>,
    /// Method: rom (the reduced model), mean-axes (elastic and rigid motion coupled only by the loads) or rigid
    #[arg(long, default_value = "rom")]
    method: Method,
    /// Integrator; the generated step is explicit, so that its work does not depend on the state
    #[arg(long, default_value = "rk4", value_parser = ["rk4"])]
    integrator: String,
    /// Time step, s [default: the load case's, or half the longest stable one]
    #[arg(long)]
    dt: Option<f64>,
    /// Single precision: float instead of double
    #[arg(long)]
    float: bool,
    /// Named points kept, for loads and results; those of the load case and of sensors are kept anyway [default: all]
    #[arg(long, value_parser = options::names, value_name = "NAMES")]
    points: Option<Names>,
    /// Places of internal loads told, by name, or all of them; their tables are large [default: none]
    #[arg(long, value_parser = options::names, value_name = "NAMES")]
    internal_loads: Option<Names>,
    /// Begins every name that other C files see
    #[arg(long, default_value = "rom", value_parser = codegen::check_prefix)]
    prefix: String,
}

/// Clap would take a bare vector for an option given several times.
type Names = Vec<String>;

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let model = describe_model::read(&args.model)?;
    let case = match &args.loads {
        None => None,
        Some(name) => Some(model.load_case(name).map_err(|e| {
            Failure::input(e.to_string(), "--loads takes the name of one load case of the model")
        })?),
    };
    let out = args.out.clone().unwrap_or_else(|| args.model.with_extension("c"));
    let tool = format!("romgen {VERSION}");
    let dt = args.dt.or(case.map(|case| case.dt)).unwrap_or_else(|| default_dt(&model));
    let request = Request {
        model: &model,
        method: args.method,
        dt,
        case,
        points: points(&model, args.points.as_deref())?,
        sections: sections(&model, args.internal_loads.as_deref().unwrap_or_default())?,
        float: args.float,
        prefix: &args.prefix,
        tool: &tool,
    };
    let text = codegen::write(&request).map_err(|message| {
        Failure::input(format!("{}: {message}", args.model.display()), "see `romgen codegen --help`")
    })?;
    atomic::write(&out, |sink| sink.write_all(text.as_bytes()))?;
    terminal::say(&format!(
        "wrote {}: {} elastic modes, steps of {dt} s, {} precision\n",
        out.display(),
        if args.method == Method::Rigid { 0 } else { model.n_modes() },
        if args.float { "single" } else { "double" }
    ))?;
    Ok(())
}

/// Half the longest stable step, or a hundredth of a second for a rigid body.
fn default_dt(model: &Model) -> f64 {
    rom_runtime::Integrator::Rk4.stable_dt(model).map_or(0.01, |limit| 0.5 * limit.dt)
}

fn points(model: &Model, wanted: Option<&[String]>) -> Result<Vec<usize>, Failure> {
    let Some(names) = wanted else { return Ok((0..model.n_points()).collect()) };
    let index = |name: &String| {
        model
            .point(name)
            .map_err(|e| Failure::input(e.to_string(), "--points takes names of the model's points"))
    };
    names.iter().map(index).collect()
}

fn sections(model: &Model, wanted: &[String]) -> Result<Vec<usize>, Failure> {
    if wanted == ["all"] {
        return Ok((0..model.section_names().len()).collect());
    }
    let index = |name: &String| {
        model.section(name).map_err(|e| {
            let help = "--internal-loads takes names of the model's places of internal loads, or all";
            Failure::input(e.to_string(), help)
        })
    };
    wanted.iter().map(index).collect()
}
