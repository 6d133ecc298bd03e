//! One evaluation of the equations of motion and one step of each integrator, beside the bare time of contracting the
//! stored tensor entries (the limit), in the same run.
//!
//! `cargo bench -p rom-runtime`. With `ROM_BENCH_MODEL=fmb.rom` (and `ROM_BENCH_CASE=lc2`) that model is measured too.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    Integrator, Load, LoadCase, LoadFrame, Model, PreparedLoads, Settings, Simulation, StateRate, Workspace,
};

/// Two dead couples on tips and corners of the frame, as in load case 2 of the paper, or follower loads there, which need
/// the rotations of the nodes too.
fn couples(model: &Model, frame: LoadFrame) -> LoadCase {
    let load = |point: u32, force: [f64; 3]| Load {
        point,
        frame,
        force,
        moment: [0.0; 3],
        time: TimeFunction::Ramp { rate: 10.0, start: 0.0, end: 10.0 },
    };
    let (left, right) = (0, model.n_points() as u32 - 1);
    let corner = if right < 20 { 0 } else { 20 };
    LoadCase {
        name: "couples".into(),
        description: String::new(),
        t_end: 10.0,
        dt: 0.01,
        numerical_damping: 0.01,
        loads: vec![
            load(right, [0.0, 0.0, 1.0]),
            load(left, [0.0, 0.0, -1.0]),
            load(right - corner, [0.0, 0.1, 0.0]),
            load(left + corner, [0.0, -0.1, 0.0]),
        ],
    }
}

/// `y_i = c_ilr u_l beta_r + k_ilrs q_l beta_r beta_s` straight from the stored entries, sorted by row: every entry read
/// once, one running sum. Products of velocities are taken as given.
fn bare(model: &Model, u: &[f64], q: &[f64], beta: &[f64; 6], squares: &[f64; 36], y: &mut [f64]) {
    y.fill(0.0);
    let (c, k) = (&model.data().c, &model.data().k);
    for (((i, l), r), value) in c.i.iter().zip(&c.l).zip(&c.r).zip(&c.value) {
        y[*i as usize] += value * u[*l as usize] * beta[*r as usize];
    }
    for (((i, l), rs), value) in k.i.iter().zip(&k.l).zip(&k.r).zip(&k.value) {
        y[*i as usize] += value * q[*l as usize] * squares[*rs as usize];
    }
}

fn measure(criterion: &mut Criterion, name: &str, model: &Arc<Model>, case: &LoadCase) {
    let (stored, held) = model.tensor_fill();
    println!(
        "{name}: {} modes, {stored} tensor entries, {held} values held by the row blocks",
        model.n_modes()
    );
    let mut group = criterion.benchmark_group(name);
    let loads = model.prepare(case).unwrap();

    // A state in full motion.
    let settings = Settings { dt: 1e-3, ..Settings::default() };
    let mut simulation = Simulation::new(model.clone(), settings).unwrap();
    for _ in 0..2000 {
        simulation.step(&loads).unwrap();
    }
    let state = simulation.state().clone();

    let u: Vec<f64> = state.q_dot.iter().chain(&state.beta_star).copied().collect();
    let beta = model.velocity(&state);
    let squares: [f64; 36] = std::array::from_fn(|rs| beta[rs / 6] * beta[rs % 6]);
    let mut y = vec![0.0; u.len()];
    group.bench_function("bare contraction", |b| {
        b.iter(|| bare(model, black_box(&u), black_box(&state.q), &beta, &squares, black_box(&mut y)));
    });
    let (mut work, mut rate) = (Workspace::new(model), StateRate::new(model));
    let mut evaluation = |name: &str, loads: &PreparedLoads| {
        group.bench_function(name, |b| {
            b.iter(|| model.derivatives(black_box(&state), loads, &mut work, black_box(&mut rate)).unwrap());
        });
    };
    evaluation("evaluation, no loads", &model.no_loads());
    evaluation("evaluation", &loads);
    let section = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let follower = couples(model, LoadFrame::Follower { section });
    evaluation("evaluation, follower loads", &model.prepare(&follower).unwrap());

    let limit = Integrator::Rk4.stable_dt(model).map_or(0.01, |limit| limit.dt);
    for (integrator, dt) in [
        (Integrator::Rk4, (0.5 * limit).min(0.01)),
        (Integrator::Newmark, 0.01),
        (Integrator::GeneralizedAlpha, 0.01),
    ] {
        let settings = Settings { dt, integrator, ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        group.bench_function(format!("step {integrator} dt={dt:.1e}"), |b| {
            let mut steps = 0;
            b.iter(|| {
                // The same stretch of motion again and again, so that a long measurement stays in range.
                if steps == 0 {
                    simulation.restore(&state).unwrap();
                }
                steps = (steps + 1) % 200;
                simulation.step(black_box(&loads)).unwrap();
            });
        });
    }
    group.finish();
}

fn step(criterion: &mut Criterion) {
    for modes in [0, 10, 40] {
        let model = Arc::new(Model::new(common::Lumped::frame(modes).data(1)).unwrap());
        measure(criterion, &format!("frame, {modes} modes"), &model, &couples(&model, LoadFrame::Dead));
    }
    if let Some(path) = std::env::var_os("ROM_BENCH_MODEL") {
        let model = Arc::new(Model::read_path(&path).unwrap());
        let name = std::env::var("ROM_BENCH_CASE").unwrap_or_else(|_| "lc2".into());
        let case = model.load_case(&name).unwrap().clone();
        measure(criterion, &format!("{} {name}", path.display()), &model, &case);
    }
}

criterion_group!(benches, step);
criterion_main!(benches);
