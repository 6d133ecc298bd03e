//! `cargo bench -p rom-generator`: time of a build and of a nonlinear step against the number of elements.

use std::path::Path;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use rom_generator::build::build;
use rom_generator::configuration::Configuration;
use rom_generator::input::Structure;
use rom_generator::reference::nonlinear::Nonlinear;
use rom_generator::reference::scheme::{Family, Scheme};
use rom_generator::{BuildOptions, ModeSelection};

fn frame(elements: usize, sigma: &str) -> Structure {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/fmb.toml");
    let sets = [("elements".to_owned(), elements.to_string()), ("sigma".to_owned(), sigma.to_owned())];
    Structure::from_toml_path(&path, &sets).expect("the published frame is a valid structure")
}

/// Structure file to model contents, 20 modes.
fn build_time(c: &mut Criterion) {
    let mut group = c.benchmark_group("build, 20 modes");
    group.sample_size(10);
    for elements in [120, 1200, 12000] {
        let structure = frame(elements, "10");
        let options =
            BuildOptions { modes: ModeSelection::Count(20), all_nodes: false, ..BuildOptions::default() };
        group.bench_with_input(BenchmarkId::from_parameter(elements), &structure, |b, s| {
            b.iter(|| build(s, &options, &mut |_| ()).expect("it builds"));
        });
    }
    group.finish();
}

/// One step of the nonlinear path, load case 1 at sigma = 1, from t = 8 s on.
fn nonlinear_step(c: &mut Criterion) {
    let mut group = c.benchmark_group("nonlinear step, lc1");
    group.sample_size(20);
    for elements in [60, 120, 1200] {
        let mesh = frame(elements, "1").mesh();
        let case = mesh.load_cases.iter().find(|case| case.name == "lc1").expect("lc1 is there");
        let scheme = Scheme::new(Family::Newmark, case.dt, case.numerical_damping);
        let mut run = Nonlinear::new(&mesh, &Configuration::drawing(&mesh), case, scheme).expect("it starts");
        for _ in 0..800 {
            run.step().expect("it converges");
        }
        group.bench_function(BenchmarkId::from_parameter(elements), |b| {
            b.iter(|| run.step().expect("it converges"))
        });
    }
    group.finish();
}

criterion_group!(benches, build_time, nonlinear_step);
criterion_main!(benches);
