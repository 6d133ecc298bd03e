//! `romgen build`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use rom_generator::build::{BuildError, BuildOptions, Elastic, Inertia, ModeSelection, Stage, build};
use rom_generator::input::Structure;
use rom_generator::{Reduction, ResidualSelection};
use rom_runtime::data::ModelData;
use rom_runtime::{LoadCase, Model};

use super::describe_model::write_report;
use super::structure::StructureArgs;
use crate::failure::Failure;
use crate::info::{EquilibriumInfo, Info};
use crate::select::{Goal, report, select};
use crate::text::{significant, thousands};
use crate::validate::Setup;
use crate::{options, terminal};

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    #[command(flatten)]
    structure: StructureArgs,
    /// Elastic modes to keep: the lowest so many (10), these (1,2,5), or all up to a frequency (60Hz, 400rad/s) [default: those of
    /// the structure file, or 10]
    #[arg(long, value_parser = options::modes)]
    modes: Option<ModeSelection>,
    /// Add residual modes, which complete the static response to loads on these points (P,Q) or on all that carry loads (all) [default:
    /// those of the structure file, or none]
    #[arg(long, value_name = "POINTS", value_parser = options::residual)]
    residual: Option<ResidualSelection>,
    /// Choose modes and options so that the errors in the load cases of --for stay below this against the nonlinear structure: 1% or
    /// 0.01, of v_G, w_G and the displacements of the named points
    #[arg(long, value_name = "ERROR", value_parser = options::fraction, requires = "cases", conflicts_with_all = ["modes", "residual", "inertia", "elastic"])]
    target_error: Option<f64>,
    /// Load cases of the structure for --target-error (lc1,lc2), or all
    #[arg(long = "for", id = "cases", value_name = "NAMES", value_parser = options::names, requires = "target_error")]
    cases: Option<Names>,
    /// With --target-error, write the best model found even where it does not meet the target
    #[arg(long, requires = "target_error")]
    keep_best: bool,
    /// Keep the mode shapes at every node for pictures, not only at as many as a drawing needs
    #[arg(long)]
    all_nodes: bool,
    /// Mass matrix: constant, that of the equilibrium (the paper's), or consistent, that of the deformed body [default: that of the
    /// structure file, or constant]
    #[arg(long, value_name = "KIND", value_parser = <Inertia as std::str::FromStr>::from_str)]
    inertia: Option<Inertia>,
    /// Elastic forces: linear, or geometric, those of large deflections (with consistent inertia) [default: those of the structure
    /// file, or linear]
    #[arg(long, value_name = "KIND", value_parser = <Elastic as std::str::FromStr>::from_str)]
    elastic: Option<Elastic>,
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

/// Clap would take a bare vector for an option given several times.
type Names = Vec<String>;

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
  romgen build models/fmb.toml --modes 15Hz --all-nodes --report wide.html -o wide.rom
  romgen build models/fmb.toml --modes 3 --residual P,Q -o few.rom
  romgen build models/fmb.toml --set sigma=300 --target-error 2% --for lc2 -o fine.rom";

pub(super) fn run(args: &Args, command: String) -> Result<(), Failure> {
    let structure = args.structure.read()?;
    let output = match &args.output {
        Some(path) => path.clone(),
        None => Path::new(args.structure.path().file_name().unwrap_or_default()).with_extension("rom"),
    };
    let asked = Reduction {
        modes: args.modes.clone(),
        residual: args.residual.clone(),
        inertia: args.inertia,
        elastic: args.elastic,
    };
    let options = asked.or(structure.reduction()).options(args.all_nodes);
    let telling = Telling { report: args.report.clone(), json: args.json, quiet: args.quiet, command };
    if let (Some(error), Some(cases)) = (args.target_error, &args.cases) {
        return write_selected(&structure, error, cases, args, &output, &telling);
    }
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
    write_data(data.map_err(build_failure)?, output, start, telling)
}

/// Selects modes and options, and writes the model where it meets the target or the best is asked for.
fn write_selected(
    structure: &Structure,
    error: f64,
    cases: &[String],
    args: &Args,
    output: &Path,
    telling: &Telling,
) -> Result<(), Failure> {
    let start = Instant::now();
    let mesh = structure.mesh();
    let setup = |case: LoadCase| {
        let name = case.name.clone();
        Setup::new(structure.clone(), mesh.clone(), case).map_err(|e| {
            Failure::input(format!("load case {name}: {e}"), "see [[loads]] in docs/structure-file.md")
        })
    };
    let setups = super::validate::load_cases(structure, &mesh, cases)?.into_iter().map(setup);
    let goal = Goal { error, setups: setups.collect::<Result<_, _>>()?, all_nodes: args.all_nodes };
    let quiet = telling.quiet || telling.json;
    let bar = terminal::spinner(quiet);
    let found = select(&goal, &|stage| bar.set_message(stage.to_owned()));
    bar.finish_and_clear();
    let mut found = found.map_err(|e| {
        Failure::numerical(
            e,
            "the target is measured against the nonlinear structure: take load cases that it can be run in",
        )
    })?;
    let options = &mut found.data.provenance.options;
    options.push(("--target-error".to_owned(), error.to_string()));
    options.push(("--for".to_owned(), cases.join(",")));
    if let (Some(selection), false) = (&found.data.selection, quiet) {
        terminal::say(&report(selection))?;
    }
    if found.meets || args.keep_best {
        write_data(found.data.clone(), output, start, telling)?;
    }
    if found.meets {
        return Ok(());
    }
    let errors = found.data.selection.iter().flat_map(|selection| &selection.errors);
    let worst = errors.max_by(|a, b| a.1.total_cmp(&b.1));
    let (name, reached) = worst.map_or(("nothing", f64::INFINITY), |(name, error)| (name.as_str(), *error));
    Err(Failure::numerical(
        format!(
            "no model meets {} %: the best of {} elastic modes has {} % in {name}",
            significant(100.0 * error, 3),
            found.modes.len(),
            significant(100.0 * reached, 3)
        ),
        if args.keep_best {
            format!(
                "{} holds the best; neither more modes nor better equations help: ask for less, or for milder load cases",
                output.display()
            )
        } else {
            "nothing was written (--keep-best writes the best); neither more modes nor better equations help: ask for less, or for milder load cases".to_owned()
        },
    ))
}

/// Writes a model and says what it holds.
fn write_data(data: ModelData, output: &Path, start: Instant, telling: &Telling) -> Result<(), Failure> {
    let model = Model::new(data).map_err(|e| {
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
        BuildError::Residual(_) => Failure::input(
            error.to_string(),
            "name points of the structure, or all that carry loads: --residual all",
        ),
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
    let p = &data.provenance;
    let residual = data.residual.as_ref().map_or(0, |residual| residual.count as usize);
    let (omega, added) = data.modes.omega.split_at(data.modes.omega.len() - residual);
    let range = |omega: &[f64]| match (omega.first(), omega.last()) {
        (Some(&low), Some(&high)) => {
            format!("from {} to {} rad/s", significant(low, 5), significant(high, 5))
        }
        _ => String::new(),
    };
    let mut modes = match omega.len() {
        0 => "no elastic mode: a rigid body".to_owned(),
        n => format!("{n} elastic modes {}", range(omega)),
    };
    if residual > 0 {
        modes.push_str(&format!(", {residual} residual modes {}", range(added)));
    }
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
