//! Runs finite-element methods and the reduced model on a load case and prints their errors against the first:
//! `methods models/fmb.toml lc2 nonlinear,linear,rom [name=value ...]`.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use rom_generator::input::Structure;
use rom_generator::reference::method::{Method, Output, Prepared, RunSettings, start_reduced};
use rom_generator::{BuildOptions, build::build};
use rom_runtime::{Integrator, Model};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let sets: Vec<(String, String)> = arguments[4..]
        .iter()
        .filter_map(|s| s.split_once('='))
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .collect();
    let structure = Structure::from_toml_path(Path::new(&arguments[1]), &sets)?;
    let prepared = Prepared::new(structure.mesh());
    let case = prepared.mesh.load_cases.iter().find(|c| c.name == arguments[2]).ok_or("no such load case")?;
    let model = Arc::new(Model::new(build(&structure, &BuildOptions::default(), &mut |_| ())?)?);
    let settings = RunSettings {
        dt: case.dt,
        integrator: Integrator::Newmark,
        numerical_damping: case.numerical_damping,
    };
    let steps = (case.t_end / case.dt).round() as usize;
    let p = prepared.mesh.points.iter().position(|p| p.name == "P").unwrap_or(0);
    let mut reference: Vec<Output> = Vec::new();
    for name in arguments[3].split(',') {
        let method: Method = name.parse()?;
        let start = Instant::now();
        let mut run = if method.is_reduced() {
            start_reduced(&model, method, case, &settings)?
        } else {
            prepared.start(method, case, &settings)?
        };
        let mut series = vec![run.output()];
        for _ in 0..steps {
            run.step()?;
            series.push(run.output());
        }
        let time = start.elapsed().as_secs_f64();
        if reference.is_empty() {
            reference = series.clone();
        }
        let error = |f: &dyn Fn(&Output) -> nalgebra::Vector3<f64>| {
            let difference =
                series.iter().zip(&reference).map(|(a, b)| (f(a) - f(b)).norm()).fold(0.0, f64::max);
            difference / reference.iter().map(|b| f(b).norm()).fold(0.0, f64::max)
        };
        println!(
            "{name:14} {:8.3} ms/step  v_G {:8.4} %  w_G {:8.4} %  dR_A {:8.4} %  CM {:9.2e} m",
            1e3 * time / steps as f64,
            100.0 * error(&|o| o.frame.velocity),
            100.0 * error(&|o| o.frame.rotation * o.frame.spin),
            100.0 * error(&|o| o.dr_a[p]),
            series
                .iter()
                .map(|o| (o.totals.centre_of_mass - series[0].totals.centre_of_mass).norm())
                .fold(0.0, f64::max),
        );
    }
    Ok(())
}
