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
    Integrator, Load, LoadCase, LoadFrame, Model, PreparedLoads, Settings, Simulation, State, StateRate,
    Workspace,
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
        t_end: 10.0,
        dt: 0.01,
        numerical_damping: 0.01,
        loads: vec![
            load(right, [0.0, 0.0, 1.0]),
            load(left, [0.0, 0.0, -1.0]),
            load(right - corner, [0.0, 0.1, 0.0]),
            load(left + corner, [0.0, -0.1, 0.0]),
        ],
        ..LoadCase::empty("couples")
    }
}

/// The limit: every stored entry read once, times a product of the state that is taken as given, summed row by row in
/// four registers.
struct Bare {
    rows: Vec<Vec<(f64, u32)>>,
}

impl Bare {
    fn new(model: &Model) -> Self {
        let n = model.n_modes() + 6;
        let (c, k) = (&model.data().c, &model.data().k);
        let mut rows = vec![Vec::new(); n];
        for entry in 0..c.value.len() {
            rows[c.i[entry] as usize].push((c.value[entry], c.l[entry] * 6 + c.r[entry]));
        }
        for entry in 0..k.value.len() {
            rows[k.i[entry] as usize].push((k.value[entry], n as u32 * 6 + k.l[entry] * 36 + k.r[entry]));
        }
        Bare { rows }
    }

    /// All products `u_l beta_r` and `q_l beta_r beta_s`.
    fn products(model: &Model, state: &State) -> Vec<f64> {
        let beta = model.velocity(state);
        let u = state.q_dot.iter().chain(&state.beta_star);
        let mut products: Vec<f64> = u.flat_map(|u| beta.map(|beta| u * beta)).collect();
        products.extend(state.q.iter().flat_map(|q| (0..36).map(move |rs| q * beta[rs / 6] * beta[rs % 6])));
        products
    }

    fn contract(&self, products: &[f64], y: &mut [f64]) {
        for (row, y) in self.rows.iter().zip(y) {
            let (fours, rest) = row.as_chunks::<4>();
            let mut sums = [0.0; 4];
            for four in fours {
                for (sum, (value, at)) in sums.iter_mut().zip(four) {
                    *sum += value * products[*at as usize];
                }
            }
            *y = sums.iter().sum::<f64>()
                + rest.iter().map(|(value, at)| value * products[*at as usize]).sum::<f64>();
        }
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

    let (bare, products) = (Bare::new(model), Bare::products(model, &state));
    let mut y = vec![0.0; model.n_modes() + 6];
    group.bench_function("bare contraction", |b| {
        b.iter(|| bare.contract(black_box(&products), black_box(&mut y)));
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
