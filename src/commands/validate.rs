//! `romgen validate`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use rom_generator::ResidualSelection;
use rom_generator::build::{BuildOptions, Elastic, Inertia, ModeSelection};
use rom_generator::equilibrium::trim::About;
use rom_generator::input::{self, Structure};
use rom_generator::mesh::Mesh;
use rom_generator::reference::method::Method;
use rom_runtime::format::MAGIC;
use rom_runtime::{Integrator, LoadCase};

use super::{VERSION, describe_model};
use crate::failure::Failure;
use crate::run::{GridError, TimeGrid};
use crate::validate::{self, Output, Row, Setting, Setup, Study, Sweep, combinations, rows, table};
use crate::{atomic, files, interrupt, options, terminal, text};

#[derive(Debug, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    /// Structure file, or a model file: then the structure, the --set values and the modes stored in it are taken
    #[arg(value_name = "STRUCTURE.toml|FILE.rom")]
    file: PathBuf,
    /// Load cases: names in the structure (lc1,lc2), all of them (all), or a file of load cases (FILE.toml)
    #[arg(long, value_name = "NAMES|FILE.toml", value_parser = options::names)]
    loads: Names,
    /// Methods, of nonlinear, constant-mass, linear, rom, mean-axes, rigid; the others are measured against the first
    #[arg(long = "method", value_name = "LIST", default_value = "nonlinear,constant-mass,linear,rom,mean-axes,rigid",
        value_parser = options::methods)]
    methods: Methods,
    /// Elastic modes of rom and mean-axes: the lowest so many (10), these (1,2,5), or all up to a frequency (60Hz)
    /// [default: those of the file, or 10]
    #[arg(long, value_parser = options::modes)]
    modes: Option<ModeSelection>,
    /// Residual modes of rom and mean-axes: for loads on these points (P,Q) or on all that carry loads (all) [default: those of the
    /// file, or none]
    #[arg(long, value_name = "POINTS", value_parser = options::residual)]
    residual: Option<ResidualSelection>,
    /// Give a parameter of the structure another value; repeatable
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = options::assignment)]
    sets: Vec<(String, String)>,
    /// Mass matrix of rom: constant or consistent [default: that of the file, or constant]
    #[arg(long, value_name = "KIND", value_parser = <Inertia as std::str::FromStr>::from_str)]
    inertia: Option<Inertia>,
    /// Elastic forces of rom: linear or geometric [default: those of the file, or linear]
    #[arg(long, value_name = "KIND", value_parser = <Elastic as std::str::FromStr>::from_str)]
    elastic: Option<Elastic>,
    /// Go through values of a parameter (sigma=3,5,10), or numbers of elastic modes (modes=0..20, ends included);
    /// several: all combinations
    #[arg(long = "sweep", value_name = "NAME=VALUES", value_parser = validate::sweep)]
    sweeps: Vec<Sweep>,
    /// Shape that linear, rom, mean-axes and rigid are about where the structure has an equilibrium: equilibrium, or drawing (the
    /// undeformed structure, as if it were in balance); also --sweep about=equilibrium,drawing [default: equilibrium]
    #[arg(long, value_name = "SHAPE")]
    about: Option<About>,
    /// Time step, s [default: the load case's]
    #[arg(long)]
    dt: Option<f64>,
    /// End of the run, s [default: the load case's]
    #[arg(long)]
    t_end: Option<f64>,
    /// Integrator: newmark, gen-alpha, or (reduced methods only) rk4, energy-momentum
    #[arg(long, default_value = "newmark")]
    integrator: Integrator,
    /// Numerical damping of newmark and gen-alpha [default: the load case's]
    #[arg(long)]
    numerical_damping: Option<f64>,
    /// Write every so many steps, and the last; errors are always over all steps
    #[arg(long, default_value_t = 1)]
    every: u64,
    /// Folder for the results, made if missing: those of romrun for each run, and a report that compares them [default:
    /// write nothing]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Named points to compare [default: all]
    #[arg(long, value_parser = options::names, value_name = "NAMES")]
    points: Option<Names>,
    /// Write the errors as a list of JSON objects; - is standard output, and nothing else is then printed
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Print nothing but errors (and JSON, if asked for)
    #[arg(long, short)]
    quiet: bool,
    /// With --out, write the plots of the reports as SVG files for papers too, in folders plots/
    #[arg(long, requires = "out")]
    svg: bool,
    /// With --out, write the motion of every run for ParaView too: structure.pvd and grids in vtk/, at most so many instants [default
    /// with the option: 200]
    #[arg(long, value_name = "FRAMES", num_args = 0..=1, require_equals = true, default_missing_value = "200", requires = "out")]
    vtk: Option<usize>,
    /// With --out, write no HTML reports
    #[arg(long)]
    no_report: bool,
}

const AFTER_HELP: &str = "Examples:
  romgen validate models/fmb.toml --loads lc2 --points P --out validation
  romgen validate fmb.rom --loads lc2 --method linear,rom --sweep modes=0..10 --json errors.json
  romgen validate models/fmb.toml --loads lc2 --method nonlinear,linear --sweep sigma=10,100,1000 --points P

The error of X is the largest |X - X_ref| over time, divided by the largest |X_ref| over time; X is v_G, w_G or the \
    displacement dR_A of a point. A run that fails is reported with its reason, the others are compared all the same, and \
    the exit code is 3.";

/// Clap would take a bare vector for an option given several times.
type Names = Vec<String>;
type Methods = Vec<Method>;

/// Name of the sweep over the shapes that linearised methods are about.
const ABOUT: &str = "about";
/// Most bytes of results kept in memory at once.
const MOST_BYTES: f64 = 8e9;

pub(super) fn run(args: &Args, command: String) -> Result<(), Failure> {
    let study = study(args, command)?;
    let units = study.units();
    let steps = units.iter().map(|unit| study.settings[unit.setting].setup.grid.steps).sum();
    let bar = terminal::progress(steps, args.quiet);
    bar.set_message(format!("{} runs", units.len()));
    let runs = study.run(&|steps| bar.inc(steps));
    bar.finish_and_clear();
    let runs = runs?;
    if interrupt::requested() {
        return Err(stopped(&study, &runs));
    }
    let rows = rows(&study, &runs);
    if let (Some(output), true) = (&study.output, study.methods.len() > 1) {
        write_comparison(&study, &runs, &rows, output)?;
    }
    write_json(args, &rows)?;
    let silent = args.quiet || args.json.as_deref() == Some(Path::new("-"));
    if !silent {
        terminal::say(&told(&study, &runs, &rows))?;
    }
    failure(&study, &runs)
}

/// What Ctrl-C left: runs that were done have their files, nothing is compared.
fn stopped(study: &Study, runs: &Runs) -> Failure {
    let done = runs.values().flatten().filter(|run| run.failure.is_none()).count();
    let help = match &study.output {
        Some(output) => format!("their results are in {}; nothing was compared", output.folder.display()),
        None => "nothing was compared; with --out the results of the runs would be kept".to_owned(),
    };
    Failure::interrupted(format!("interrupted: {done} of {} runs done", runs.len()), help)
}

/// What is to be run; all that can be refused is refused here.
fn study(args: &Args, command: String) -> Result<Study, Failure> {
    let source = Source::read(args)?;
    let mut swept_modes = None;
    let mut sweeps: Vec<(String, Vec<String>)> = Vec::new();
    for sweep in &args.sweeps {
        match sweep {
            Sweep::Modes(_) if swept_modes.is_some() => return Err(twice("modes")),
            Sweep::Modes(counts) => swept_modes = Some(counts.clone()),
            Sweep::About(values) => {
                if args.about.is_some() || sweeps.iter().any(|(n, _)| n == ABOUT) {
                    return Err(twice(ABOUT));
                }
                sweeps.push((ABOUT.to_owned(), values.clone()));
            }
            Sweep::Parameter(name, values) => {
                if sweeps.iter().any(|(n, _)| n == name) || args.sets.iter().any(|(n, _)| n == name) {
                    return Err(twice(name));
                }
                sweeps.push((name.clone(), values.clone()));
            }
        }
    }
    if swept_modes.is_some() && args.modes.is_some() {
        return Err(twice("modes"));
    }
    let modes = match swept_modes {
        Some(counts) => counts.into_iter().map(ModeSelection::Count).collect(),
        None => vec![args.modes.clone().unwrap_or(source.modes.clone())],
    };
    let mut settings = Vec::new();
    for swept in combinations(&sweeps) {
        settings.extend(source.settings(&swept, args)?);
    }
    let several_loads = settings.iter().any(|s| s.setup.case.name != settings[0].setup.case.name);
    let mut taken = BTreeSet::new();
    for setting in &mut settings {
        setting.folder = folder(setting, several_loads, &mut taken);
    }
    let output = args.out.clone().map(|folder| Output {
        folder,
        reports: !args.no_report,
        svg: args.svg,
        vtk: args.vtk,
        command,
    });
    let study =
        Study { settings, methods: args.methods.clone(), modes, output, tool: format!("romgen {VERSION}") };
    check_memory(&study)?;
    Ok(study)
}

fn twice(name: &str) -> Failure {
    Failure::input(format!("{name} is given twice"), "set it or sweep it, once")
}

fn folder(setting: &Setting, several_loads: bool, taken: &mut BTreeSet<String>) -> PathBuf {
    let values = setting.swept.iter().map(|(name, value)| format!("{name}={value}"));
    let loads = several_loads.then(|| setting.setup.case.name.clone());
    let name: Vec<String> = loads.into_iter().chain(values).collect();
    if name.is_empty() { PathBuf::new() } else { files::folder_name(&name.join(" "), taken).into() }
}

/// The text of a structure and what was set when a model was built from it.
struct Source {
    text: String,
    name: String,
    sets: Vec<(String, String)>,
    modes: ModeSelection,
    residual: ResidualSelection,
    dynamics: (Inertia, Elastic),
}

impl Source {
    fn read(args: &Args) -> Result<Self, Failure> {
        let name = args.file.display().to_string();
        let mut source = if is_model(&args.file) {
            let model = describe_model::read(&args.file)?;
            let provenance = &model.data().provenance;
            let values =
                |key: &'static str| provenance.options.iter().filter(move |(k, _)| k == key).map(|(_, v)| v);
            let damaged = |e| Failure::input(format!("{name}: {e}"), "build the model again");
            let sets =
                values("--set").map(|v| options::assignment(v)).collect::<Result<_, _>>().map_err(damaged)?;
            let modes =
                values("--modes").next_back().map_or(Ok(ModeSelection::Count(10)), |v| options::modes(v));
            let residual = values("--residual")
                .next_back()
                .map_or(Ok(ResidualSelection::None), |v| options::residual(v));
            let (consistent, geometric) = model.consistent();
            let dynamics = (
                if consistent { Inertia::Consistent } else { Inertia::Constant },
                if geometric { Elastic::Geometric } else { Elastic::Linear },
            );
            Self {
                text: provenance.input_text.clone(),
                sets,
                modes: modes.map_err(damaged)?,
                residual: residual.map_err(damaged)?,
                dynamics,
                name,
            }
        } else {
            let text = input::read_text(&args.file)?;
            let structure = Structure::from_toml_str(&text, &name, &args.sets)?;
            let BuildOptions { modes, residual, inertia, elastic, .. } =
                structure.reduction().clone().options(false);
            Self { text, name, sets: Vec::new(), modes, residual, dynamics: (inertia, elastic) }
        };
        source.override_sets(&args.sets);
        let (inertia, elastic) = source.dynamics;
        source.dynamics = (args.inertia.unwrap_or(inertia), args.elastic.unwrap_or(elastic));
        if source.dynamics == (Inertia::Constant, Elastic::Geometric) {
            return Err(Failure::input(
                "--elastic geometric asks for consistent inertia",
                "add --inertia consistent",
            ));
        }
        Ok(source)
    }

    fn override_sets(&mut self, sets: &[(String, String)]) {
        self.sets.retain(|(name, _)| !sets.iter().any(|(n, _)| n == name));
        self.sets.extend_from_slice(sets);
    }

    /// The load cases asked for, with these parameters.
    fn settings(&self, swept: &[(String, String)], args: &Args) -> Result<Vec<Setting>, Failure> {
        let mut sets = self.sets.clone();
        sets.retain(|(name, _)| !swept.iter().any(|(n, _)| n == name));
        sets.extend(swept.iter().filter(|(name, _)| name != ABOUT).cloned());
        let about = swept.iter().find(|(name, _)| name == ABOUT).and_then(|(_, value)| value.parse().ok());
        let about = about.or(args.about).unwrap_or_default();
        let structure = Structure::from_toml_str(&self.text, &self.name, &sets)?;
        let mesh = structure.mesh();
        let value = |name: &String| structure.parameters().iter().find(|(n, _)| n == name).map(|(_, v)| *v);
        let set: Vec<(String, f64)> =
            sets.iter().filter_map(|(name, _)| Some((name.clone(), value(name)?))).collect();
        let points = points(&mesh, args.points.as_deref())?;
        let setting = |case: LoadCase| {
            let mut setup = setup(structure.clone(), mesh.clone(), case, points.clone(), args)?;
            setup.residual = args.residual.clone().unwrap_or_else(|| self.residual.clone());
            setup.residual.points(&setup.mesh).map_err(|e| Failure::input(e, "see --residual"))?;
            setup.dynamics = self.dynamics;
            setup.about = about;
            Ok(Setting { swept: swept.to_vec(), set: set.clone(), setup, folder: PathBuf::new() })
        };
        load_cases(&structure, &mesh, &args.loads)?.into_iter().map(setting).collect()
    }
}

/// Whether a file is a model: by its first bytes, so that its name does not matter.
fn is_model(path: &Path) -> bool {
    use std::io::Read as _;
    let mut start = [0; MAGIC.len()];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut start));
    // What is called a model but is damaged at its start is for the reader of models to refuse.
    read.is_ok() && start == MAGIC || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("rom"))
}

/// The load cases asked for, each once, in the order asked for.
pub(super) fn load_cases(
    structure: &Structure,
    mesh: &Mesh,
    wanted: &[String],
) -> Result<Vec<LoadCase>, Failure> {
    let mut cases: Vec<LoadCase> = Vec::new();
    for name in wanted {
        if Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
            let table = structure.point_table();
            cases.extend(input::read_load_cases(&input::read_text(Path::new(name))?, name, &table, &[])?);
        } else if name == "all" {
            cases.extend(mesh.load_cases.iter().cloned());
        } else {
            let case = mesh.load_cases.iter().find(|case| case.name == *name);
            cases.push(
                case.cloned()
                    .ok_or_else(|| unknown("load case", name, mesh.load_cases.iter().map(|c| &c.name)))?,
            );
        }
    }
    if cases.is_empty() {
        return Err(Failure::input(
            "the structure has no load cases",
            "write some to a file: --loads FILE.toml",
        ));
    }
    match (1..cases.len()).find(|&i| cases[..i].iter().any(|c| c.name == cases[i].name)) {
        Some(i) => Err(Failure::input(
            format!("two load cases are named {}", cases[i].name),
            "run them one after the other, each with its own --out",
        )),
        None => Ok(cases),
    }
}

fn unknown<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a String>) -> Failure {
    let known: Vec<&str> = known.map(String::as_str).collect();
    let help = if known.is_empty() {
        "there is none".to_owned()
    } else {
        format!("there are: {}", known.join(", "))
    };
    Failure::input(format!("the structure has no {what} {name:?}"), help)
}

fn points(mesh: &Mesh, wanted: Option<&[String]>) -> Result<Vec<(usize, String)>, Failure> {
    let all = || mesh.points.iter().map(|p| p.name.clone());
    let Some(names) = wanted else { return Ok(all().enumerate().collect()) };
    let index = |name: &String| {
        let found = all().position(|n| n == *name);
        found
            .map(|i| (i, name.clone()))
            .ok_or_else(|| unknown("point", name, mesh.points.iter().map(|p| &p.name)))
    };
    names.iter().map(index).collect()
}

fn setup(
    structure: Structure,
    mesh: Mesh,
    case: LoadCase,
    points: Vec<(usize, String)>,
    args: &Args,
) -> Result<Setup, Failure> {
    let in_case = |message: String| format!("load case {}: {message}", case.name);
    let grid = TimeGrid::new(args.dt.unwrap_or(case.dt), args.t_end.unwrap_or(case.t_end), args.every)
        .map_err(|GridError { message, help }| Failure::input(in_case(message), help))?;
    // That of the load case is meant for the integrators that have one to adjust.
    let of_case = if args.integrator.has_numerical_damping() { case.numerical_damping } else { 0.0 };
    let numerical_damping = args.numerical_damping.unwrap_or(of_case);
    if !(0.0..=1.0).contains(&numerical_damping) {
        let message = format!("the numerical damping is {numerical_damping}");
        return Err(Failure::input(in_case(message), "give a number from 0 to 1"));
    }
    let mut mesh = mesh;
    if mesh.load_cases.iter().all(|known| known.name != case.name) {
        // What `--residual all` looks at.
        mesh.load_cases.push(case.clone());
    }
    Ok(Setup {
        structure,
        mesh,
        case,
        grid,
        integrator: args.integrator,
        numerical_damping,
        points,
        residual: ResidualSelection::None,
        about: About::default(),
        dynamics: Default::default(),
    })
}

/// Every run keeps what is compared; those in work hold all channels.
fn check_memory(study: &Study) -> Result<(), Failure> {
    let kept = |s: &Setting| s.setup.grid.steps as f64 * 8.0 * (7 + 3 * s.setup.points.len()) as f64;
    let bytes: f64 = study.units().iter().map(|unit| 2.0 * kept(&study.settings[unit.setting])).sum();
    if bytes > MOST_BYTES {
        let message = format!(
            "{} runs would keep {:.1} GB, more than the {:.0} GB that are kept in memory",
            study.units().len(),
            bytes / 1e9,
            MOST_BYTES / 1e9
        );
        return Err(Failure::input(message, "take fewer sweep points, fewer --points or a larger --dt"));
    }
    Ok(())
}

type Runs = std::collections::BTreeMap<validate::Unit, validate::Outcome>;

fn write_comparison(study: &Study, runs: &Runs, rows: &[Row], output: &Output) -> Result<(), Failure> {
    atomic::make_folder(&output.folder)?;
    let errors = serde_json::to_vec_pretty(rows).map_err(std::io::Error::from)?;
    atomic::write(&output.folder.join("errors.json"), |sink| sink.write_all(&errors))?;
    let document = validate::report(study, runs, rows);
    if output.reports {
        document.write(&output.folder.join("report.html"))?;
    }
    if output.svg {
        document.write_svg(&output.folder.join("plots"))?;
    }
    Ok(())
}

fn write_json(args: &Args, rows: &[Row]) -> Result<(), Failure> {
    match args.json.as_deref() {
        None => Ok(()),
        Some(path) if path == Path::new("-") => Ok(terminal::say_json(&rows)?),
        Some(path) => {
            let text = serde_json::to_string_pretty(rows).map_err(std::io::Error::from)?;
            Ok(atomic::write(path, |sink| sink.write_all((text + "\n").as_bytes()))?)
        }
    }
}

/// For the terminal: the summary of a single method, else a table per load case.
fn told(study: &Study, runs: &Runs, rows: &[Row]) -> String {
    let mut out = String::new();
    if let [_] = study.methods.as_slice() {
        for run in runs.values().flatten() {
            out += &run.summary.to_text();
            let files: Vec<&str> = run.summary.files.values().map(String::as_str).collect();
            if !files.is_empty() {
                out += &format!("  wrote {}\n", files.join(", "));
            }
        }
        return out;
    }
    let mut loads: Vec<&str> = rows.iter().map(|row| row.loads.as_str()).collect();
    loads.dedup();
    loads.sort_unstable();
    loads.dedup();
    for case in loads {
        let name = study.settings.first().map_or("", |s| s.setup.structure.name());
        out += &format!("{name}, load case {case}: relative errors against {}\n\n", study.methods[0]);
        out += &text::columns(&table(study, runs, rows, case));
        out.push('\n');
    }
    if let Some(output) = &study.output {
        let what = if output.reports {
            "report.html, errors.json and a folder per run"
        } else {
            "errors.json and a folder per run"
        };
        out += &format!("  wrote {}: {what}\n", output.folder.display());
    }
    out
}

/// What failed: each method and reason once, with the number of runs it stands for.
fn failure(study: &Study, runs: &Runs) -> Result<(), Failure> {
    let mut reasons: Vec<(String, String, usize)> = Vec::new();
    for (unit, run) in runs {
        let (message, help) = match run {
            Err(reason) => (reason.clone(), "leave the method out, or change the settings"),
            Ok(run) => match &run.failure {
                None => continue,
                Some(f) => (
                    format!("stopped at t = {} s: {}", text::significant(f.time, 6), f.message),
                    f.help.as_str(),
                ),
            },
        };
        let known = reasons.iter_mut().find(|(m, _, _)| m.ends_with(&message));
        match known {
            Some((_, _, count)) => *count += 1,
            None => reasons.push((format!("{}: {message}", place(study, unit)), help.to_owned(), 1)),
        }
    }
    let failure = |(message, help, count): (String, String, usize)| {
        let more = if count > 1 { format!(" (the same in {count} runs)") } else { String::new() };
        Failure::numerical(message + &more, help)
    };
    match reasons.into_iter().map(failure).reduce(Failure::and) {
        None => Ok(()),
        Some(failure) => Err(failure),
    }
}

fn place(study: &Study, unit: &validate::Unit) -> String {
    let setting = &study.settings[unit.setting];
    let swept: String = setting.swept.iter().map(|(name, value)| format!(", {name} = {value}")).collect();
    format!("{}, load case {}{swept}", unit.method, setting.setup.case.name)
}
