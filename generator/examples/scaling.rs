//! Time of each stage of a build of the frame FMB with a given number of elements: `scaling 12000 20`.

use std::path::Path;
use std::time::Instant;

use rom_generator::{BuildOptions, ModeSelection, Stage, build::build, input::Structure};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let elements = arguments.get(1).map_or("12000", String::as_str);
    let modes = arguments.get(2).map_or(Ok(20), |s| s.parse())?;
    let start = Instant::now();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/fmb.toml");
    let structure = Structure::from_toml_path(&path, &[("elements".into(), elements.into())])?;
    let mut last = start;
    let mut report = |stage: Stage| {
        println!("{:8.3} s  until {stage:?}", last.elapsed().as_secs_f64());
        last = Instant::now();
    };
    let options =
        BuildOptions { modes: ModeSelection::Count(modes), all_nodes: true, ..BuildOptions::default() };
    let model = build(&structure, &options, &mut report)?;
    println!("{:8.3} s  in all", start.elapsed().as_secs_f64());
    println!("omega {:?}", model.modes.omega);
    println!("c {} entries, k {} entries", model.c.value.len(), model.k.value.len());
    for check in &model.checks {
        println!("{:10.2e} (limit {:.0e})  {}", check.value, check.limit, check.name);
    }
    Ok(())
}
