//! `romgen build`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use rom_generator::build::{BuildError, BuildOptions, Elastic, Inertia, ModeSelection, Stage, build};
use rom_generator::input::Structure;
use rom_runtime::Model;
use rom_runtime::data::ModelData;

use super::describe_model::write_report;
use super::structure::StructureArgs;
use crate::failure::Failure;
use crate::info::{EquilibriumInfo, Info};
use crate::text::{significant, thousands};
use crate::{options, terminal};

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    #[command(flatten)]
    structure: StructureArgs,
    /// Elastic modes to keep: the lowest so many (10), these (1,2,5), or all up to a frequency (60Hz, 400rad/s)
    #[arg(long, default_value = "10", value_parser = options::modes)]
    modes: ModeSelection,
    /// Keep the mode shapes at every node for pictures, not only at as many as a drawing needs
    #[arg(long)]
    all_nodes: bool,
    /// Mass matrix: constant, that of the equilibrium (the paper's), or consistent, that of the deformed body
    #[arg(long, default_value = "constant", value_name = "KIND", value_parser = <Inertia as std::str::FromStr>::from_str)]
    inertia: Inertia,
    /// Elastic forces: linear, or geometric, those of large deflections (with --inertia consistent)
    #[arg(long, default_value = "linear", value_name = "KIND", value_parser = <Elastic as std::str::FromStr>::from_str)]
    elastic: Elastic,
    /// Model file to write [default: the structure file's name with .rom, here]
    #[arg(short, long, value_name = "FILE.rom")]
    output: Option<PathBuf>,
    /// Write an HTML report too: what is in the model, with its modes moving in space
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Print what is in the model as JSON, as `romgen info --json` does
    #[arg(long)]
    json: bool,
    /// Print nothing but errors (and JSON, if asked for)
    #[arg(long, short)]
    quiet: bool,
}

/// What to tell of a build besides writing the model.
#[derive(Debug, Default)]
pub(super) struct Telling {
    /// Report to write.
    pub(super) report: Option<PathBuf>,
    pub(super) json: bool,
    pub(super) quiet: bool,
    /// The command as typed, for the report.
    pub(super) command: String,
}

const EXAMPLES: &str = "Examples:
  romgen build models/fmb.toml -o fmb.rom
  romgen build models/fmb.toml --set sigma=30 --modes 1,2,5 -o stiff.rom
  romgen build models/fmb.toml --modes 15Hz --all-nodes --report wide.html -o wide.rom";

pub(super) fn run(args: &Args, command: String) -> Result<(), Failure> {
    let structure = args.structure.read()?;
    let output = match &args.output {
        Some(path) => path.clone(),
        None => Path::new(args.structure.path().file_name().unwrap_or_default()).with_extension("rom"),
    };
    let options = BuildOptions {
        modes: args.modes.clone(),
        all_nodes: args.all_nodes,
        inertia: args.inertia,
        elastic: args.elastic,
    };
    let telling = Telling { report: args.report.clone(), json: args.json, quiet: args.quiet, command };
    write_model(&structure, &options, &output, &telling)
}

/// Builds a model, writes it and says what it holds.
pub(super) fn write_model(
    structure: &Structure,
    options: &BuildOptions,
    output: &Path,
    telling: &Telling,
) -> Result<(), Failure> {
    let start = Instant::now();
    let bar = terminal::spinner(telling.quiet || telling.json);
    let data = build(structure, options, &mut |stage| {
        bar.set_message(words(stage));
    });
    bar.finish_and_clear();
    let model = Model::new(data.map_err(build_failure)?).map_err(|e| {
        Failure::other(format!("the model just built is refused by the runtime, which is a defect: {e}"))
    })?;
    model.write_path(output).map_err(|e| Failure::other(e.to_string()))?;
    if telling.report.is_some() || telling.json {
        let info = Info::new(&model);
        if let Some(path) = &telling.report {
            write_report(&model, &info, &telling.command, path)?;
        }
        if telling.json {
            terminal::say_json(&info)?;
        }
    }
    if !telling.quiet && !telling.json {
        terminal::say(&told(model.data(), output, start.elapsed().as_secs_f64()))?;
    }
    let failed = model.data().checks.iter().find(|c| c.value.is_nan() || c.value > c.limit);
    match failed {
        None => Ok(()),
        Some(check) => Err(Failure::numerical(
            format!("check not passed: {}: {:e}, limit {:e}", check.name, check.value, check.limit),
            format!("{} was written so that it can be looked at; do not trust it", output.display()),
        )),
    }
}

fn words(stage: Stage) -> &'static str {
    match stage {
        Stage::Equilibrium => "finding the equilibrium",
        Stage::Assembly => "assembling the matrices",
        Stage::Modes => "finding the free-free modes",
        Stage::Tensors => "projecting the tensors",
        Stage::Lagrangian => "expanding the Lagrangian",
        Stage::Done => "writing",
    }
}

fn build_failure(error: BuildError) -> Failure {
    match error {
        BuildError::Selection(_) => {
            Failure::input(error.to_string(), "see `romgen build --help` for --modes")
        }
        BuildError::Dynamics(_) => {
            Failure::input(error.to_string(), "see `romgen build --help` for --inertia and --elastic")
        }
        BuildError::CoarseElement { .. } => {
            Failure::input(error.to_string(), "raise `elements` of that member")
        }
        BuildError::Equilibrium(_) => {
            Failure::numerical(error.to_string(), "see [equilibrium] in docs/structure-file.md")
        }
        _ => Failure::numerical(
            error.to_string(),
            "look for sections of very different stiffness, or masses near zero, in the structure file",
        ),
    }
}

fn told(data: &ModelData, output: &Path, seconds: f64) -> String {
    let (p, omega) = (&data.provenance, &data.modes.omega);
    let modes = match (omega.first(), omega.last()) {
        (Some(&low), Some(&high)) => {
            format!(
                "{} elastic modes from {} to {} rad/s",
                omega.len(),
                significant(low, 5),
                significant(high, 5)
            )
        }
        _ => "no elastic mode: a rigid body".to_owned(),
    };
    let equilibrium = data.trim.as_ref().map_or(String::new(), |trim| {
        format!("  about a loaded equilibrium\n{}", EquilibriumInfo::new(data, trim).to_text())
    });
    let lagrangian = data.lagrangian.as_ref().map_or(String::new(), |it| {
        format!(
            "  consistent inertia, {} elastic forces: {} kinetic coordinates, {} terms of higher order in them\n",
            if it.geometric { "geometric" } else { "linear" },
            it.fields,
            thousands((it.curve.quadratic.len() + it.curve.cubic.len()) as f64)
        )
    });
    format!(
        "{}: {} elements, {} degrees of freedom, mass {} kg\n  {modes}\n  {} and {} entries in the tensors c and k\n{lagrangian}  \
         {} checks passed of {}\n{equilibrium}  wrote {} in {} s\n",
        p.name,
        thousands(p.n_elements as f64),
        thousands(p.n_dof as f64),
        significant(data.rigid.mass, 6),
        thousands(data.c.value.len() as f64),
        thousands(data.k.value.len() as f64),
        data.checks.iter().filter(|c| c.value <= c.limit).count(),
        data.checks.len(),
        output.display(),
        significant(seconds, 2),
    )
}
