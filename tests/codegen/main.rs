//! The generated C file, compiled strictly and marched beside the runtime.

#[path = "../../runtime/tests/common/mod.rs"]
mod common;

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;

use assert_cmd::Command as Program;
use common::{Lumped, Random, rotation_rows};
use rom_runtime::data::{
    CutData, DampingData, GravityData, LineData, ModelData, SensorData, SummationData, TrimData,
};
use rom_runtime::expression::{Binary, Instruction, Program as Code, Unary, Variable};
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    DistributedFrame, DistributedLoad, Integrator, Load, LoadCase, LoadFrame, LoadSet, Method, Model,
    Settings, Simulation,
};

const STRICT: [&str; 9] =
    ["-std=c99", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror", "-lm"];

fn romgen(arguments: &[&str]) -> Output {
    Program::cargo_bin("romgen").unwrap().args(arguments).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Marches `steps` steps in C, with `host` as statements that fill the loads, and prints everything every `every` steps.
fn driver(steps: usize, every: usize, host: &str) -> String {
    format!(
        r#"#include "model.c"
#include <stdio.h>
static void put(const rom_real *x, int n) {{
    int i;
    for (i = 0; i < n; i++) printf("%.17g ", (double)x[i]);
}}
int main(void) {{
    static rom_loads loads;
    rom_state state;
    rom_rate rate;
    rom_rigid rigid;
    int step, i;
    rom_init(&state);
    {host}
    for (step = 0; step <= {steps}; step++) {{
        if (step % {every} == 0) {{
            put(&state.time, 1);
            put(state.q, ROM_MODES);
            put(state.q_dot, ROM_MODES);
            rom_rigid_output(&state, &rigid);
            put(rigid.r_g, 3); put(rigid.v_a, 3); put(rigid.w_a, 3); put(rigid.v_g, 3); put(rigid.w_g, 3);
            put(rigid.attitude, 4);
            rom_derivatives(&state, &loads, &rate);
#if ROM_POINTS > 0
            for (i = 0; i < ROM_POINTS; i++) {{
                rom_point point;
                rom_motion motion;
                if (rom_point_output(&state, i, &point) || rom_point_motion(&state, &rate, i, &motion)) return 2;
                put(point.dr_a, 3); put(point.r_g, 3);
                put(motion.attitude, 4); put(motion.v_g, 3); put(motion.w_g, 3); put(motion.a_g, 3);
                put(motion.alpha_g, 3);
            }}
#endif
#if ROM_SENSORS > 0
            for (i = 0; i < ROM_SENSORS; i++) {{
                rom_reading reading;
                if (rom_sensor_output(&state, &rate, i, &reading)) return 2;
                put(reading.a, 3); put(reading.w, 3); put(reading.alpha, 3);
            }}
#endif
#if ROM_SECTIONS > 0
            for (i = 0; i < ROM_SECTIONS; i++) {{
                rom_real section[6];
                if (rom_section_output(&state, &loads, &rate, i, section)) return 2;
                put(section, 6);
            }}
            if (!rom_section_output(&state, &loads, &rate, ROM_SECTIONS, 0)) return 3;
#endif
            (void)i;
            printf("\n");
        }}
        if (rom_step(&state, &loads) != 0) return 1;
    }}
    return 0;
}}
"#
    )
}

/// The numbers the driver prints, from the runtime; with internal loads at all places, or without.
fn expected(
    model: &Arc<Model>,
    loads: &LoadSet,
    dt: f64,
    steps: usize,
    every: usize,
    internal: bool,
) -> Vec<Vec<f64>> {
    let settings = Settings { dt, integrator: Integrator::Rk4, ..Settings::default() };
    let mut simulation = Simulation::new(model.clone(), settings).unwrap();
    let mut rows = Vec::new();
    for step in 0..=steps {
        if step % every == 0 {
            simulation.solve_accelerations(loads).unwrap();
            let state = simulation.state();
            let mut row = vec![state.time];
            row.extend(state.q.iter().chain(&state.q_dot));
            let rigid = simulation.rigid_output();
            row.extend([rigid.r_g, rigid.v_a, rigid.w_a, rigid.v_g, rigid.w_g].iter().flatten());
            row.extend(rigid.zeta);
            for index in 0..model.n_points() {
                let (point, motion) =
                    (simulation.point_output(index).unwrap(), simulation.point_motion(index).unwrap());
                row.extend(point.dr_a.iter().chain(&point.r_g).chain(&motion.attitude));
                row.extend([motion.v_g, motion.w_g, motion.a_g, motion.alpha_g].iter().flatten());
            }
            for index in 0..model.data().sensors.len() {
                let reading = simulation.sensor_reading(index).unwrap();
                row.extend([reading.a, reading.w, reading.alpha].iter().flatten());
            }
            if internal {
                let forces = simulation.find_section_forces(loads).unwrap();
                row.extend(forces.iter().flat_map(|section| section.best));
            }
            rows.push(row);
        }
        simulation.step(loads).unwrap();
    }
    rows
}

/// Compiles with the model written by `romgen codegen`, runs, and reads what is printed.
fn marched(folder: &Path, arguments: &[&str], driver: &str) -> Vec<Vec<f64>> {
    let c = folder.join("model.c");
    let output = romgen(&[&["codegen"], arguments, &["-o", text(&c)]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    std::fs::write(folder.join("main.c"), driver).unwrap();
    let main = folder.join("main.c");
    let program = folder.join("main");
    let compiled = Command::new("cc")
        .arg(&main)
        .args(STRICT.iter().take(8))
        .arg("-o")
        .arg(&program)
        .arg("-lm")
        .output()
        .expect("a C compiler (cc)");
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let run = Command::new(&program).output().unwrap();
    assert!(run.status.success(), "{:?}", run.status);
    let numbers = |line: &str| line.split_whitespace().map(|x| x.parse().unwrap()).collect();
    String::from_utf8(run.stdout).unwrap().lines().map(numbers).collect()
}

/// Largest difference of any column, relative to the largest number of its column (or to 1e-3 of the row's largest, for columns that
/// are round-off).
fn difference(found: &[Vec<f64>], expected: &[Vec<f64>]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest = |column: usize| expected.iter().map(|row| row[column].abs()).fold(0.0, f64::max);
    let widths = found.iter().zip(expected).all(|(a, b)| a.len() == b.len());
    assert!(widths, "{} columns, expected {}", found[0].len(), expected[0].len());
    let overall = (0..expected[0].len()).map(largest).fold(0.0, f64::max);
    let mut worst = 0.0_f64;
    for column in 0..expected[0].len() {
        let scale = largest(column).max(1e-3 * overall);
        for (a, b) in found.iter().zip(expected) {
            let one = (a[column] - b[column]).abs() / scale;
            assert!(one.is_finite());
            worst = worst.max(one);
        }
    }
    worst
}

/// Load case 2 of the paper's frame to its end by all methods; in single precision too.
#[test]
fn the_frame_has_the_motion_of_the_runtime() {
    let folder = tempfile::tempdir().unwrap();
    let rom = folder.path().join("fmb.rom");
    let structure = concat!(env!("CARGO_MANIFEST_DIR"), "/models/fmb.toml");
    assert!(romgen(&["build", structure, "--set", "elements=60", "-o", text(&rom)]).status.success());
    let source = Model::read_path(&rom).unwrap();
    let case = source.load_case("lc2").unwrap().clone();
    let (dt, steps, every) = (case.dt, (case.t_end / case.dt).round() as usize, 20);
    for method in Method::ALL {
        let model = Arc::new(source.with_method(method).unwrap());
        let loads = LoadSet::with_case(&model, &[], &case).unwrap();
        let expected = expected(&model, &loads, dt, steps, every, false);
        let arguments = [text(&rom), "--loads", "lc2", "--method", method.name()];
        let driver = driver(steps, every, "");
        let double = difference(&marched(folder.path(), &arguments, &driver), &expected);
        // The same formulas with sums in another order, over a thousand steps.
        assert!(double < 1e-12, "{method}: {double:e}");
        let float = [&arguments[..], &["--float"]].concat();
        let single = difference(&marched(folder.path(), &float, &driver), &expected);
        println!("{method}: double {double:.1e}, single {single:.1e}");
        // A thousand steps of four stages, each rounded once or twice to 6e-8, should they all go the same way; docs/codegen.md tells
        // what it costs on this case.
        assert!(single > 1e-7 && single < 5e-4, "{method}: {single:e}");
    }
}

/// A model with all there is: gravity, trim, sensors, every time function, loads of the host on points, on A and on modes.
fn everything() -> ModelData {
    let m = 4;
    let mut lumped = Lumped::random(m, 9);
    lumped.damping_ratio = 0.02;
    let mut data = lumped.data(9);
    let mut random = Random::new(2);
    let mut second = vec![0.0; 3 * m * m];
    for k in 0..3 {
        for (i, j) in (0..m).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let value = 0.1 * random.next();
            second[(k * m + i) * m + j] = value;
            second[(k * m + j) * m + i] = value;
        }
    }
    data.gravity = Some(GravityData { acceleration: [0.1, -0.2, -9.0], second_moment: second });
    data.trim = Some(TrimData {
        distributed: Vec::new(),
        loads: vec![load(1, LoadFrame::Body, &mut random, TimeFunction::Constant { value: 1.0 })],
        elastic_force: (0..m).map(|_| random.next()).collect(),
        elastic_energy: 1.0,
        attitude: [0.8, 0.6, 0.0, 0.0],
        factors: vec![],
        load_names: Vec::new(),
        reaction: [0.0; 6],
        scales: [1.0; 2],
        displacements: vec![[0.0; 3]; data.points.len()],
        effort: [1; 2],
    });
    let pairs = (0..m).flat_map(|i| (0..m).map(move |j| if i == j { 0.0 } else { 0.01 }));
    data.damping = Some(DampingData { coupling: pairs.collect() });
    data.sensors = vec![
        SensorData { name: "imu".into(), point: 2, axes: rotation_rows(&random.vector()), gravity: true },
        SensorData { name: "gyro 2".into(), point: 0, axes: rotation_rows(&random.vector()), gravity: false },
    ];
    // Stations where two of the points are.
    data.lines = vec![LineData {
        name: "boom".into(),
        length: 2.0,
        knots: vec![0.0, 1.0],
        stations: common::sections_at(&[&data.points[1..3], &data.points[..1]].concat()),
    }];
    let place = |name: &str, random: &mut Random| CutData {
        name: name.into(),
        member: "boom".into(),
        fraction: 0.5,
        rest: random.array(1.0),
        modal: (0..6 * m).map(|_| random.next()).collect(),
        modal_rate: (0..6 * m).map(|_| 0.1 * random.next()).collect(),
        summation: Some(SummationData {
            constant: random.array(1.0),
            inertia: (0..6 * (m + 6)).map(|_| random.next()).collect(),
            damping: (0..6 * m).map(|_| 0.1 * random.next()).collect(),
            c: (0..36 * (m + 6)).map(|_| random.next()).collect(),
            k: (0..126 * m).map(|_| random.next()).collect(),
            gravity: (0..18 * m).map(|_| 0.1 * random.next()).collect(),
            places: (0..36 * (data.points.len() + 3)).map(|_| random.next()).collect(),
        }),
    };
    data.cuts = vec![place("root 1", &mut random), place("tip", &mut random)];
    let section = rotation_rows(&random.vector());
    let frames = [LoadFrame::Dead, LoadFrame::Body, LoadFrame::Follower { section }];
    let loads =
        times().into_iter().enumerate().map(|(i, time)| load(i as u32 % 5, frames[i % 3], &mut random, time));
    data.load_cases = vec![LoadCase {
        dt: 0.005,
        loads: loads.collect(),
        distributed: [DistributedFrame::Dead, DistributedFrame::Body, DistributedFrame::Follower]
            .into_iter()
            .zip(times())
            .map(|(frame, time)| DistributedLoad {
                member: 0,
                frame,
                force: random.array::<9>(2.0).to_vec(),
                moment: if frame == DistributedFrame::Follower { vec![0.3; 9] } else { vec![] },
                time,
            })
            .collect(),
        ..LoadCase::empty("all */ of it")
    }];
    data
}

fn load(point: u32, frame: LoadFrame, random: &mut Random, time: TimeFunction) -> Load {
    Load { point, frame, force: random.array(2.0), moment: random.array(1.0), time }
}

fn times() -> Vec<TimeFunction> {
    use Instruction::{Binary as B, Constant as C, Unary as U, Variable as V};
    let program = |code: Vec<Instruction>| TimeFunction::Expression {
        program: Code { source: "as coded".into(), code },
    };
    vec![
        TimeFunction::Step { value: 1.0, start: 0.05, end: f64::MAX },
        TimeFunction::Step { value: -1.0, start: 0.1, end: 0.3 },
        TimeFunction::Ramp { rate: 2.0, start: 0.0, end: 0.3 },
        TimeFunction::Triangle { peak: 1.0, start: 0.0, at: 0.1, end: 0.2 },
        TimeFunction::Triangle { peak: 1.0, start: 0.1, at: 0.1, end: 0.2 },
        TimeFunction::Sine { amplitude: 1.0, omega: 5.0, phase: -0.1, start: 0.0, end: 0.4 },
        TimeFunction::OneMinusCosine { amplitude: 1.0, start: 0.1, duration: 0.3 },
        TimeFunction::Table { t: vec![0.0, 0.1, 0.3], value: vec![0.0, 1.0, -1.0] },
        program(vec![
            V(Variable::Vx),
            U(Unary::Sign),
            V(Variable::Vx),
            C(2.0),
            B(Binary::Pow),
            B(Binary::Mul),
            U(Unary::Neg),
            V(Variable::T),
            U(Unary::Cos),
            V(Variable::Wz),
            B(Binary::Max),
            B(Binary::Add),
        ]),
        program(vec![
            V(Variable::Z),
            V(Variable::Y),
            C(3.0),
            B(Binary::Sub),
            B(Binary::Atan2),
            U(Unary::Tanh),
        ]),
    ]
}

#[test]
fn every_part_of_a_model_has_the_motion_of_the_runtime() {
    let folder = tempfile::tempdir().unwrap();
    let rom = folder.path().join("all.rom");
    let source = Model::new(everything()).unwrap();
    source.write_path(&rom).unwrap();
    let case = &source.data().load_cases[0];
    for method in Method::ALL {
        let model = Arc::new(source.with_method(method).unwrap());
        let mut loads = LoadSet::with_case(&model, &[3, 5], case).unwrap();
        let mut host = String::new();
        let mut random = Random::new(6);
        let turn = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let frames = [
            ("dead", LoadFrame::Dead),
            ("body", LoadFrame::Body),
            ("node", LoadFrame::Follower { section: turn }),
        ];
        for (name, frame) in frames {
            for (slot, place) in [(Some(0), "point[3]"), (Some(1), "point[5]"), (None, "frame_a")] {
                let (force, moment) = (random.array(2.0), random.array(1.0));
                match slot {
                    Some(slot) => assert!(loads.add(slot, &frame, force, moment)),
                    None => loads.add_wrench(&frame, force, moment),
                }
                for k in 0..3 {
                    let _ = writeln!(host, "loads.{place}.{name}_force[{k}] = (rom_real){:?};", force[k]);
                    let _ = writeln!(host, "loads.{place}.{name}_moment[{k}] = (rom_real){:?};", moment[k]);
                }
            }
        }
        let modal: [f64; 4] = random.array(1.0);
        assert!(loads.add_modal(&modal[..model.n_modes()]));
        for (i, force) in modal.iter().enumerate().take(model.n_modes()) {
            let _ = writeln!(host, "loads.modal[{i}] = (rom_real){force:?};");
        }
        let (steps, every) = (100, 5);
        let expected = expected(&model, &loads, case.dt, steps, every, true);
        let arguments =
            [text(&rom), "--loads", &case.name, "--method", method.name(), "--internal-loads", "all"];
        let found = marched(folder.path(), &arguments, &driver(steps, every, &host));
        let double = difference(&found, &expected);
        assert!(double < 1e-12, "{method}: {double:e}");
        let float = [&arguments[..], &["--float"]].concat();
        let single = difference(&marched(folder.path(), &float, &driver(steps, every, &host)), &expected);
        println!("{method}: double {double:.1e}, single {single:.1e}");
        // 400 evaluations, each rounded to 6e-8 of terms that cancel to a tenth.
        assert!(single < 3e-4, "{method}: {single:e}");
    }
}

/// An aircraft held up by lift along its wing, through a gust: distributed loads of the equilibrium and of the case, internal loads by name.
#[test]
fn an_aircraft_in_a_gust_has_the_motion_of_the_runtime() {
    let folder = tempfile::tempdir().unwrap();
    let rom = folder.path().join("hale.rom");
    let structure = concat!(env!("CARGO_MANIFEST_DIR"), "/models/hale.toml");
    let options = ["--set", "wing_elements=6", "--modes", "4", "-o", text(&rom)];
    assert!(romgen(&[&["build", structure], &options[..]].concat()).status.success());
    let model = Arc::new(Model::read_path(&rom).unwrap());
    let loads = LoadSet::with_case(&model, &[], model.load_case("gust").unwrap()).unwrap();
    let (steps, every) = (200, 20);
    let expected = expected(&model, &loads, 0.01, steps, every, true);
    let all: Vec<&str> = model.section_names().collect();
    let names = all.join(",");
    let arguments = [text(&rom), "--loads", "gust", "--dt", "0.01", "--internal-loads", &names];
    let difference = difference(&marched(folder.path(), &arguments, &driver(steps, every, "")), &expected);
    assert!(difference < 1e-11, "{difference:e}");
    // What keeps it up is there: it has not fallen.
    let last = expected.last().unwrap();
    assert!(last.iter().all(|x| x.is_finite()) && model.gravity()[2] < -9.0);
}

#[test]
fn no_loads_no_points_another_prefix_and_declarations_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (rom, c) = (folder.path().join("m.rom"), folder.path().join("m.c"));
    let mut data = Lumped::random(2, 1).data(1);
    data.points.clear();
    Model::new(data).unwrap().write_path(&rom).unwrap();
    // The file's name with another ending where none is given.
    assert!(romgen(&["codegen", text(&rom), "--prefix", "wing", "--dt", "0.001"]).status.success());
    let main = "#define WING_DECLARATIONS_ONLY\n#include \"m.c\"\n\
                int main(void) { wing_state s; wing_init(&s); return wing_step(&s, 0); }\n";
    std::fs::write(folder.path().join("main.c"), main).unwrap();
    let program = folder.path().join("main");
    let compiled = Command::new("cc")
        .args([folder.path().join("main.c"), c])
        .args(STRICT.iter().take(8))
        .arg("-o")
        .arg(&program)
        .arg("-lm")
        .output()
        .unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    assert!(Command::new(program).status().unwrap().success());
}

#[test]
fn what_cannot_be_written_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let rom = folder.path().join("m.rom");
    Model::new(Lumped::random(2, 1).data(1)).unwrap().write_path(&rom).unwrap();
    for (arguments, word) in [
        (&["--dt", "10"][..], "too long"),
        (&["--dt=-1"], "time step"),
        (&["--loads", "lc9"], "no load case lc9"),
        (&["--points", "nowhere"], "no point nowhere"),
        (&["--integrator", "newmark"], "rk4"),
        (&["--prefix", "2x"], "lower-case"),
        (&["--internal-loads", "root"], "no place of internal loads root; it has: none"),
    ] {
        let output = romgen(&[&["codegen", text(&rom)], arguments].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        let said = said.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(word), "{arguments:?}: {said}");
        assert!(!folder.path().join("m.c").exists());
    }
}
