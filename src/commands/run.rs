//! `romrun`.

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rom_generator::input::{self, PointTable};
use rom_runtime::data::ModelData;
use rom_runtime::loads::LoadCase;
use rom_runtime::{Integrator, Method, Model, Settings};
use serde_json::{Map, Value, json};

use super::{VERSION, describe_model};
use crate::failure::Failure;
use crate::live::Live;
use crate::march::{Job, march};
use crate::run::{GridError, RunFacts, Summary, TimeGrid};
use crate::serve::Options;
use crate::text::{columns, significant, thousands};
use crate::{atomic, describe, files, interrupt, options, scene, terminal, vtk};

#[derive(Debug, Clone, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    /// Model file
    #[arg(value_name = "FILE.rom")]
    pub(super) model: PathBuf,
    /// Load cases: names in the model (lc1,lc2), all of them (all), or a file of load cases (FILE.toml); without this
    /// option the load cases are listed
    #[arg(long, value_name = "NAMES|FILE.toml", value_parser = options::names)]
    pub(super) loads: Option<Names>,
    /// Give a parameter of a file of load cases another value; repeatable
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = options::assignment, requires = "loads")]
    pub(super) sets: Vec<(String, String)>,
    /// Run a case for every value: NAME=1,2,3, NAME=0..20 or NAME=0.5..1.5:11; repeated, every combination. NAME is scale (factor on
    /// all loads), scale.POINT, v_A.x, w_A.z, r_G.y (motion at t = 0), q.1, q_dot.1 (modes at t = 0) or a parameter of a file of load
    /// cases. Extremes of every case go to cases.csv and cases.npz; started again, a stopped sweep goes on
    #[arg(long = "sweep", value_name = "NAME=VALUES", value_parser = crate::sweep::values, requires = "loads",
          conflicts_with_all = ["every", "point_motion"])]
    pub(super) sweeps: Vec<(String, Vec<f64>)>,
    /// The same for the cases of a table: names on its first line, the values of a case on every other, between commas
    #[arg(long, value_name = "FILE.csv", requires = "loads", conflicts_with_all = ["sweeps", "every", "point_motion"])]
    pub(super) cases: Option<PathBuf>,
    /// Time step, s [default: the load case's]
    #[arg(long)]
    dt: Option<f64>,
    /// End of the run, s [default: the load case's]
    #[arg(long)]
    t_end: Option<f64>,
    /// Method: rom (the reduced model), mean-axes (elastic and rigid motion coupled only by the loads) or rigid
    #[arg(long, default_value = "rom")]
    method: Method,
    /// Integrator: newmark, gen-alpha, rk4, or energy-momentum (models with consistent inertia)
    #[arg(long, default_value = "newmark")]
    pub(super) integrator: Integrator,
    /// Numerical damping of newmark and gen-alpha [default: the load case's]
    #[arg(long)]
    numerical_damping: Option<f64>,
    /// Write every so many steps, and the last
    #[arg(long, default_value_t = 1)]
    every: u64,
    /// Folder for the results, made if missing; several load cases get a folder each inside it
    #[arg(long, default_value = "results", value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Named points to record [default: all]
    #[arg(long, value_parser = options::names, value_name = "NAMES")]
    pub(super) points: Option<Names>,
    /// Record attitudes, velocities and accelerations of the named points too
    #[arg(long)]
    point_motion: bool,
    /// Write the motion for ParaView too: structure.pvd and grids in vtk/, at most so many instants [default with the option: 200]
    #[arg(long, value_name = "FRAMES", num_args = 0..=1, require_equals = true, default_missing_value = "200")]
    vtk: Option<usize>,
    /// Write the plots of the report as SVG files for papers too, in plots/
    #[arg(long)]
    svg: bool,
    /// Follow the run in the terminal: a plot of the largest displacement over time and the figures of now
    #[arg(long, conflicts_with = "quiet")]
    live: bool,
    /// Print the summary as JSON: an object, or a list of them for several load cases
    #[arg(long)]
    pub(super) json: bool,
    /// Print nothing but errors (and JSON, if asked for)
    #[arg(long, short)]
    pub(super) quiet: bool,
    /// Write no HTML report
    #[arg(long)]
    no_report: bool,
    /// Serve the model to a host instead: udp:PORT on this machine only, udp:ADDRESS:PORT elsewhere; a load case acts besides
    #[arg(long, value_name = "udp:PORT", value_parser = super::serve::address,
        conflicts_with_all = ["t_end", "every", "out", "vtk", "svg", "live", "no_report"])]
    serve: Option<SocketAddr>,
    /// The command as typed, for the report.
    #[arg(skip)]
    command: String,
}

const EXAMPLES: &str = "Examples:
  romrun fmb.rom                                      list the load cases
  romrun fmb.rom --loads lc2                          run one; results in results/
  romrun fmb.rom --loads all --out runs --no-report   run all of them
  romrun fmb.rom --loads gust.toml --set gain=2       load cases of a file, with another parameter
  romrun fmb.rom --loads lc2 --dt 0.002 --every 5     shorter steps, every fifth written
  romrun fmb.rom --loads all --sweep scale=0.5..1.5:101 --out sweep    extremes of many cases, on all cores
  romrun fmb.rom --loads lc2 --vtk --live             for ParaView; follow it in the terminal
  romrun fmb.rom --serve udp:5005                     step it from another program, see docs/udp.md
  romrun fmb.rom --loads lc2 --json | jq .points.P.peak

Exit codes: 0 done, 1 other failure, 2 wrong input or command line, 3 numerical failure, 130 stopped by Ctrl-C (results until then
are written).";

impl Args {
    /// With the command line that these arguments came from.
    pub(super) fn typed(self, command: String) -> Self {
        Self { command, ..self }
    }

    /// Runs one load case of a model with everything else at its default.
    pub(super) fn one(model: PathBuf, load_case: &str, out: PathBuf, command: String) -> Self {
        Self {
            model,
            loads: Some(vec![load_case.to_owned()]),
            sets: Vec::new(),
            sweeps: Vec::new(),
            cases: None,
            dt: None,
            t_end: None,
            method: Method::Rom,
            integrator: Integrator::Newmark,
            numerical_damping: None,
            every: 1,
            out,
            points: None,
            point_motion: false,
            vtk: None,
            svg: false,
            live: false,
            json: false,
            quiet: false,
            no_report: false,
            serve: None,
            command,
        }
    }
}

/// Clap would take a bare vector for an option given several times.
pub(super) type Names = Vec<String>;

/// Most bytes of results kept in memory until they are written.
const MOST_BYTES: f64 = 8e9;

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let model = Arc::new(describe_model::read(&args.model)?);
    if let Some(address) = args.serve {
        return serve(model, address, args);
    }
    let Some(loads) = &args.loads else {
        return list(&model, args);
    };
    if args.cases.is_some() || !args.sweeps.is_empty() {
        return super::sweep::run(args, model, loads);
    }
    let cases = load_cases(&model, loads, &args.sets)?;
    let whole = Arc::clone(&model);
    let model = simplified(model, args)?;
    let points = points(&model, args.points.as_deref())?;
    // Everything that can be refused is refused before the first run starts.
    let jobs: Vec<Job> =
        cases.iter().map(|case| job(&model, case, &points, args)).collect::<Result<_, Failure>>()?;
    let folders = folders(&args.out, &cases);
    let mut summaries = Vec::with_capacity(jobs.len());
    let mut failed = Vec::new();
    for (job, folder) in jobs.iter().zip(&folders) {
        if interrupt::requested() {
            break;
        }
        let summary = run_one(job, whole.data(), folder, args)?;
        if let Some(failure) = &summary.failure {
            failed.push((job.case.name.clone(), failure.clone()));
        }
        summaries.push(summary);
    }
    if args.json {
        match summaries.as_slice() {
            [one] => terminal::say_json(one)?,
            several => terminal::say_json(&several)?,
        }
    }
    if interrupt::requested() {
        return Err(stopped(&summaries, jobs.len()));
    }
    match failed.into_iter().next() {
        Some((case, failure)) => {
            Err(Failure::numerical(format!("load case {case}: {}", failure.message), failure.help))
        }
        None => Ok(()),
    }
}

/// The model by the method asked for.
pub(super) fn simplified(model: Arc<Model>, args: &Args) -> Result<Arc<Model>, Failure> {
    match args.method {
        Method::Rom => Ok(model),
        simpler => Ok(Arc::new(model.with_method(simpler).map_err(|e| {
            Failure::input(
                format!("{}: {e}", args.model.display()),
                "build the model again with `romgen build`",
            )
        })?)),
    }
}

/// With `--serve`: steps as a host asks for them.
fn serve(model: Arc<Model>, address: SocketAddr, args: &Args) -> Result<(), Failure> {
    let cases = match &args.loads {
        Some(loads) => load_cases(&model, loads, &args.sets)?,
        None => Vec::new(),
    };
    if cases.len() > 1 {
        return Err(Failure::input(
            "--serve takes one load case besides the loads of the host",
            "name one: --loads NAME",
        ));
    }
    let case = cases.into_iter().next();
    let model = simplified(model, args)?;
    let defaults = Settings::default();
    let adjustable = args.integrator.has_numerical_damping();
    let damping = case.as_ref().map_or(0.0, |case| if adjustable { case.numerical_damping } else { 0.0 });
    let settings = Settings {
        dt: args.dt.or(case.as_ref().map(|case| case.dt)).unwrap_or(defaults.dt),
        integrator: args.integrator,
        numerical_damping: args.numerical_damping.unwrap_or(damping),
        ..defaults
    };
    let options = Options {
        settings,
        case,
        points: points(&model, args.points.as_deref())?,
        point_motion: args.point_motion,
    };
    super::serve::run(&args.model, &model, options, address, (args.quiet, args.json))
}

/// What Ctrl-C left.
fn stopped(summaries: &[Summary], asked: usize) -> Failure {
    let done = summaries.iter().filter(|summary| summary.completed).count();
    let at = match summaries.last().filter(|summary| !summary.completed) {
        Some(last) => format!(", load case {} at t = {} s", last.load_case, significant(last.last.t, 6)),
        None => String::new(),
    };
    Failure::interrupted(
        format!("interrupted: {done} of {asked} load cases done{at}"),
        "the results until then are written, with completed: false in their summary",
    )
}

/// Without `--loads`: which there are.
fn list(model: &Model, args: &Args) -> Result<(), Failure> {
    let data = model.data();
    if args.json {
        terminal::say_json(&data.load_cases)?;
        return Ok(());
    }
    let mut text = if data.load_cases.is_empty() {
        format!(
            "{} has no load cases of its own: write some to a file and run it with --loads FILE.toml\n",
            data.provenance.name
        )
    } else {
        columns(&describe::load_case_rows(&data.load_cases))
    };
    if let Some(first) = data.load_cases.first() {
        text += &format!("\nrun one of them: romrun {} --loads {}\n", args.model.display(), first.name);
    }
    terminal::say(&text)?;
    Ok(())
}

/// The load cases asked for, each once, in the order asked for.
pub(super) fn load_cases(
    model: &Model,
    wanted: &[String],
    sets: &[(String, String)],
) -> Result<Vec<LoadCase>, Failure> {
    let mut cases: Vec<LoadCase> = Vec::new();
    let mut from_file = false;
    for name in wanted {
        if is_file(name) {
            from_file = true;
            cases.extend(read_load_cases(model.data(), Path::new(name), sets)?);
        } else if name == "all" {
            cases.extend(model.data().load_cases.iter().cloned());
        } else {
            let case = model.load_case(name);
            cases.push(
                case.map_err(|e| Failure::input(e.to_string(), "or name a file: --loads FILE.toml"))?.clone(),
            );
        }
    }
    if !sets.is_empty() && !from_file {
        return Err(Failure::input(
            "--set has nothing to act on: the load cases of a model file are fixed",
            "use `romgen build --set`, or run a file of load cases: --loads FILE.toml --set name=value",
        ));
    }
    if cases.is_empty() {
        return Err(Failure::input("the model has no load cases", "write some to a file: --loads FILE.toml"));
    }
    match (1..cases.len()).find(|&i| cases[..i].iter().any(|c| c.name == cases[i].name)) {
        Some(i) => Err(Failure::input(
            format!("two load cases are named {}", cases[i].name),
            "run them one after the other, each with its own --out",
        )),
        None => Ok(cases),
    }
}

pub(super) fn is_file(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"))
}

fn read_load_cases(
    data: &ModelData,
    path: &Path,
    sets: &[(String, String)],
) -> Result<Vec<LoadCase>, Failure> {
    let table = PointTable::new(&data.points, &data.lines, &data.provenance.parameters);
    Ok(input::read_load_cases(&input::read_text(path)?, &path.display().to_string(), &table, sets)?)
}

/// Indices of the points to record.
pub(super) fn points(model: &Model, wanted: Option<&[String]>) -> Result<Vec<usize>, Failure> {
    let Some(names) = wanted else {
        return Ok((0..model.n_points()).collect());
    };
    let index = |name: &String| {
        model
            .point(name)
            .map_err(|e| Failure::input(e.to_string(), "--points takes names of the model's points"))
    };
    names.iter().map(index).collect()
}

pub(super) fn job<'a>(
    model: &'a Arc<Model>,
    case: &'a LoadCase,
    points: &[usize],
    args: &Args,
) -> Result<Job<'a>, Failure> {
    let in_case = |message: String| format!("load case {}: {message}", case.name);
    let grid = TimeGrid::new(args.dt.unwrap_or(case.dt), args.t_end.unwrap_or(case.t_end), args.every)
        .map_err(|GridError { message, help }| Failure::input(in_case(message), help))?;
    // That of the load case is meant for the integrators that have one to adjust.
    let adjustable = args.integrator.has_numerical_damping();
    let numerical_damping =
        args.numerical_damping.unwrap_or(if adjustable { case.numerical_damping } else { 0.0 });
    let per_point = if args.point_motion { 22 } else { 6 };
    let reaction = if case.motion.is_some() || model.is_clamped() { 24 } else { 0 };
    let modal = if args.vtk.is_some() { 2 } else { 1 } * model.n_modes();
    let columns = 25 + reaction + modal + per_point * points.len() + 9 * model.data().sensors.len();
    let bytes = grid.rows() as f64 * columns as f64 * 8.0;
    if bytes > MOST_BYTES {
        let message = format!(
            "the results would be {:.1} GB, more than the {:.0} GB that are kept in memory",
            bytes / 1e9,
            MOST_BYTES / 1e9
        );
        let every = (bytes / MOST_BYTES * grid.every as f64).ceil();
        return Err(Failure::input(
            in_case(message),
            format!("write fewer steps: --every {every}, or fewer --points"),
        ));
    }
    let job = Job {
        model,
        case,
        grid,
        integrator: args.integrator,
        numerical_damping,
        points: points.to_vec(),
        point_motion: args.point_motion,
        rates: args.vtk.is_some(),
    };
    job.check()
        .map_err(|message| Failure::input(in_case(message), "see `romrun --help` for what can be set"))?;
    Ok(job)
}

/// `out` for one load case, a folder inside it for each of several.
fn folders(out: &Path, cases: &[LoadCase]) -> Vec<PathBuf> {
    if let [_] = cases {
        return vec![out.to_owned()];
    }
    let mut taken = BTreeSet::new();
    cases.iter().map(|case| out.join(files::folder_name(&case.name, &mut taken))).collect()
}

/// `whole`: the reduced model, also where a simpler method runs.
fn run_one(job: &Job, whole: &ModelData, folder: &Path, args: &Args) -> Result<Summary, Failure> {
    let bar = terminal::progress(job.grid.steps, args.quiet);
    bar.set_message(job.case.name.clone());
    let outcome = if args.live {
        let points = job.points.iter().map(|&i| (i, job.model.data().points[i].name.clone())).collect();
        let picture = terminal::picture();
        let mut live = Live::new(picture.clone(), points, job.grid.steps, job.grid.dt);
        let outcome = march(job, metadata(job), |steps, run| live.see(steps, run));
        picture.finish_and_clear();
        outcome
    } else {
        march(job, metadata(job), |steps, _| bar.set_position(steps))
    };
    bar.finish_and_clear();
    let outcome =
        outcome.map_err(|message| Failure::input(message, "see `romrun --help` for what can be set"))?;
    let facts = facts(job, args);
    let report = !args.no_report;
    let scene = match report {
        true => scene::of_run(whole, job.case, &outcome.results, job.model.method().name()),
        false => None,
    };
    let vtk = match args.vtk {
        Some(frames) => {
            atomic::make_folder(folder)?;
            Some(vtk::write_run(whole, &outcome.results, frames, folder)?)
        }
        None => None,
    };
    let summary = files::write(&facts, outcome, folder, files::Shown { report, svg: args.svg, scene, vtk })?;
    if !args.quiet && !args.json {
        let files: Vec<&str> = summary.files.values().map(String::as_str).collect();
        terminal::say(&format!("{}  wrote {}\n", summary.to_text(), files.join(", ")))?;
        let remark = job.grid.to_string();
        if !remark.is_empty() {
            terminal::say(&format!("  {remark}\n"))?;
        }
    }
    Ok(summary)
}

/// Facts for the result file: nothing that differs when the same run is made again.
fn metadata(job: &Job) -> Map<String, Value> {
    let provenance = &job.model.data().provenance;
    let facts = json!({
        "tool": format!("romrun {VERSION}"),
        "structure": provenance.name,
        "parameters": provenance.parameters,
        "input_sha256": provenance.input_sha256,
        "load_case": job.case.name,
        "method": job.model.method().name(),
        "integrator": job.integrator.name(),
        "dt": job.grid.dt,
        "t_end": job.grid.t_end,
        "every": job.grid.every,
        "numerical_damping": job.numerical_damping,
    });
    match facts {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

fn facts(job: &Job, args: &Args) -> RunFacts {
    let data = job.model.data();
    RunFacts {
        structure: data.provenance.name.clone(),
        file: args.model.display().to_string(),
        load_case: job.case.name.clone(),
        description: job.case.description.clone(),
        method: job.model.method().name().to_owned(),
        integrator: job.integrator.name().to_owned(),
        numerical_damping: job.numerical_damping,
        grid: job.grid,
        command: args.command.clone(),
        tool: format!("romrun {VERSION}"),
        model: model_facts(data),
        loads: {
            let spread = job.case.distributed.iter().map(|load| {
                let line = data.lines.get(load.member as usize);
                describe::distributed(load, line.map(|line| line.name.as_str()))
            });
            let loads = job.case.loads.iter().map(|load| describe::load(load, &data.points));
            loads.chain(spread).collect()
        },
        input_text: data.provenance.input_text.clone(),
    }
}

/// What the report says about the model.
fn model_facts(data: &ModelData) -> Vec<(String, String)> {
    let (p, omega) = (&data.provenance, &data.modes.omega);
    let pairs = |list: Vec<String>| if list.is_empty() { "none".to_owned() } else { list.join(", ") };
    let modes = match (omega.first(), omega.last()) {
        (Some(&low), Some(&high)) => {
            format!("{}, from {} to {} rad/s", omega.len(), significant(low, 5), significant(high, 5))
        }
        _ => "none: a rigid body".to_owned(),
    };
    let (elements, dof) = (thousands(p.n_elements as f64), thousands(p.n_dof as f64));
    let facts = [
        ("structure", p.name.clone()),
        ("finite elements", format!("{elements}, with {dof} degrees of freedom")),
        ("elastic modes", modes),
        ("mass", format!("{} kg", significant(data.rigid.mass, 6))),
        ("parameters", pairs(p.parameters.iter().map(|(name, value)| format!("{name} = {value}")).collect())),
        ("build options", pairs(p.options.iter().map(|(name, value)| format!("{name} {value}")).collect())),
        ("written by", p.generator.clone()),
        ("SHA-256 of the structure file", p.input_sha256.clone()),
    ];
    facts.map(|(name, value)| (name.to_owned(), value)).to_vec()
}
