//! `romrun --sweep` and `romrun --cases`.

use std::io;
use std::sync::Arc;

use rom_runtime::Model;
use serde_json::json;

use super::run::{Args, is_file, job, load_cases, points, simplified};
use crate::failure::Failure;
use crate::sweep::{Case, Sweep, Variable, table};
use crate::terminal;
use crate::text::thousands;

/// Most cases of a sweep; more is a slip of the keyboard.
const MOST: usize = 1_000_000;

pub(super) fn run(args: &Args, file: Arc<Model>, loads: &[String]) -> Result<(), Failure> {
    let bytes = std::fs::read(&args.model)
        .map_err(|e| Failure::input(format!("{}: {e}", args.model.display()), "give a model file"))?;
    let (names, rows) = rows(args)?;
    let model = simplified(file.clone(), args)?;
    let variables = variables(&names, &model, loads)?;
    let points = points(&model, args.points.as_deref())?;
    let mut sweep = Sweep {
        model: model.clone(),
        load_cases: Vec::new(),
        cases: Vec::new(),
        integrator: args.integrator,
        points: points.clone(),
        identity: format!("crc32 {}, {} bytes", crc32fast::hash(&bytes), bytes.len()),
        names,
    };
    let mut asked = None;
    for row in &rows {
        let values: Vec<(Variable, f64)> = variables.iter().cloned().zip(row.iter().copied()).collect();
        let cases = match &asked {
            // Only parameters of a file make reading it again worth while.
            Some(cases) if !variables.iter().any(|v| matches!(v, Variable::Parameter(_))) => {
                Vec::clone(cases)
            }
            _ => {
                let mut sets = args.sets.clone();
                sets.extend(values.iter().filter_map(|(variable, value)| match variable {
                    Variable::Parameter(name) => Some((name.clone(), value.to_string())),
                    _ => None,
                }));
                load_cases(&file, loads, &sets)?
            }
        };
        sweep.load_cases = cases.iter().map(|case| case.name.clone()).collect();
        for (load_case, case) in cases.iter().enumerate() {
            let mut case = case.clone();
            values.iter().for_each(|(variable, value)| variable.change_loads(*value, &mut case));
            let job = job(&model, &case, &points, args)?;
            let (grid, numerical_damping) = (job.grid, job.numerical_damping);
            sweep.cases.push(Case { grid, numerical_damping, values: values.clone(), load_case, case });
        }
        asked = Some(cases);
    }
    // A load case after the other, so that those of one step are marched together.
    sweep.cases.sort_by_key(|case| case.load_case);
    march(args, &sweep)
}

/// Names of the variables, and their values in every case.
fn rows(args: &Args) -> Result<(Vec<String>, Vec<Vec<f64>>), Failure> {
    if let Some(path) = &args.cases {
        let text = rom_generator::input::read_text(path)?;
        return table(&text).map_err(|message| {
            Failure::input(
                format!("{}: {message}", path.display()),
                "for example: scale,v_A.x on line 1, 1.5,20 on line 2",
            )
        });
    }
    let names: Vec<String> = args.sweeps.iter().map(|(name, _)| name.clone()).collect();
    if let Some(i) = (0..names.len()).find(|&i| names[..i].contains(&names[i])) {
        return Err(Failure::input(format!("{} is swept twice", names[i]), "give all its values at once"));
    }
    let count: f64 = args.sweeps.iter().map(|(_, values)| values.len() as f64).product();
    if count > MOST as f64 {
        let message =
            format!("the combinations are {} cases, more than {}", thousands(count), thousands(MOST as f64));
        return Err(Failure::input(message, "give a table of the cases that matter: --cases FILE.csv"));
    }
    let mut rows = vec![Vec::new()];
    for (_, values) in &args.sweeps {
        rows = rows
            .into_iter()
            .flat_map(|row: Vec<f64>| values.iter().map(move |value| [&row[..], &[*value]].concat()))
            .collect();
    }
    Ok((names, rows))
}

fn variables(names: &[String], model: &Model, loads: &[String]) -> Result<Vec<Variable>, Failure> {
    let variables = names.iter().map(|name| {
        let variable = Variable::parse(name, model)
            .map_err(|message| Failure::input(message, "see `romrun --help` for what can be swept"))?;
        match variable {
            Variable::Parameter(name) if !loads.iter().any(|loads| is_file(loads)) => Err(Failure::input(
                format!("{name} is no parameter: the load cases of a model file are fixed"),
                "sweep scale, scale.POINT, v_A.x, q.1 and the like, or run a file of load cases: --loads FILE.toml",
            )),
            other => Ok(other),
        }
    });
    variables.collect()
}

fn march(args: &Args, sweep: &Sweep) -> Result<(), Failure> {
    let bar = terminal::progress(sweep.cases.len() as u64, args.quiet);
    let start = std::time::Instant::now();
    let done = sweep.run(&args.out, |done| bar.set_position(done));
    bar.finish_and_clear();
    let done = done.map_err(|e| {
        if e.kind() == io::ErrorKind::InvalidInput {
            Failure::input(e.to_string(), "give this one another folder (--out), or remove that one")
        } else {
            Failure::from(e)
        }
    })?;
    let (cases, found) = done.cases;
    if args.json {
        terminal::say_json(&json!({
            "cases": cases,
            "found": found,
            "failed": done.failed,
            "wall_seconds": start.elapsed().as_secs_f64(),
            "csv": done.csv,
            "npz": done.npz,
        }))?;
    } else if !args.quiet {
        let earlier = if found > 0 {
            format!(", {} of them from an earlier run", thousands(found as f64))
        } else {
            String::new()
        };
        terminal::say(&format!(
            "{} cases{earlier}\n\n{}\n  wrote {}, {}\n",
            thousands(cases as f64),
            done.summary,
            done.csv.display(),
            done.npz.display()
        ))?;
    }
    if cases < sweep.cases.len() {
        return Err(Failure::interrupted(
            format!("interrupted: {cases} of {} cases done", sweep.cases.len()),
            "the same command goes on from there",
        ));
    }
    match done.failed.first() {
        None => Ok(()),
        Some(first) => Err(Failure::numerical(
            format!("{} of {cases} cases ended early, the first is case {first}", done.failed.len()),
            "completed is 0 in their lines of cases.csv; take a shorter --dt, or smaller loads",
        )),
    }
}
