//! Nonlinear run of a load case: `nonlinear models/fmb.toml lc1 [name=value ...]`. Prints cost and a few figures.

use std::path::Path;
use std::time::Instant;

use rom_generator::configuration::Configuration;
use rom_generator::input::Structure;
use rom_generator::reference::nonlinear::Nonlinear;
use rom_generator::reference::scheme::{Family, Scheme};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let sets: Vec<(String, String)> = arguments[3..]
        .iter()
        .filter_map(|s| s.split_once('='))
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .collect();
    let structure = Structure::from_toml_path(Path::new(&arguments[1]), &sets)?;
    let mesh = structure.mesh();
    let case = mesh.load_cases.iter().find(|c| c.name == arguments[2]).ok_or("no such load case")?;
    let scheme = Scheme::new(Family::Newmark, case.dt, case.numerical_damping);
    let at = Configuration::drawing(&mesh);
    let mut run = Nonlinear::new(&mesh, &at, case, scheme)?;
    let steps = (case.t_end / case.dt).round() as usize;
    let (mut w_min, mut w_max) = ([f64::MAX; 3], [f64::MIN; 3]);
    let (mut d_min, mut d_max) = (f64::MAX, f64::MIN);
    let start = Instant::now();
    for _ in 0..steps {
        run.step()?;
        let frame = run.motion().frame(mesh.reference);
        let w = frame.rotation * frame.spin;
        for k in 0..3 {
            w_min[k] = w_min[k].min(w[k]);
            w_max[k] = w_max[k].max(w[k]);
        }
        if let Some(node) = mesh.points.iter().find(|p| p.name == "P").and_then(|p| p.node()) {
            let r = frame.rotation.inverse() * (run.motion().position[node] - frame.position);
            let d = r.z - at.positions[node].z;
            d_min = d_min.min(d);
            d_max = d_max.max(d);
        }
    }
    let elapsed = start.elapsed().as_secs_f64();
    println!("{steps} steps, {:.3} ms per step", 1e3 * elapsed / steps as f64);
    println!(
        "iterations per step {:.2}, factorisations {:.2}",
        run.iterations as f64 / steps as f64,
        run.factorisations as f64 / steps as f64
    );
    println!("w_G min {w_min:?} max {w_max:?}");
    println!("P.dR_A z: {d_min} {d_max}");
    let totals = run.totals();
    println!("{totals:#?}");
    println!("v_CM {:?}", totals.linear_momentum / totals.mass);
    println!("{:?}", run.motion().frame(mesh.reference));
    Ok(())
}
