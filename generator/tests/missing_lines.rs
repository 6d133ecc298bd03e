//! What few modes miss of the response to loads per length: against all modes of the structure, and against runs with all of them.

use std::sync::Arc;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3, Vector6};
use rom_generator::input::Structure;
use rom_generator::{BuildOptions, Inertia, ModeSelection, build::build};
use rom_runtime::data::{MissingLine, ModelData, StationSet};
use rom_runtime::{DistributedFrame, LoadFrame, LoadSet, Model, Settings, Simulation};

/// A wing with a kink and with masses beside its axis, under a load of each frame.
const WING: &str = r#"
[structure]
name = "wing"
reference = "root"

[sections.spar]
shape = "constants"
EA = 1e4
GAy = 1e4
GAz = 1e4
GJ = 40
EIy = 60
EIz = 900
rhoA = 0.5
rhoJ = [0.02, 0.002, 0.018]

[points]
root = [0, 0, 0]
tip = [0.3, 2, 0.4]
other = [0, -1.5, 0]
pod = { linked_to = "tip", offset = [0.2, 0.1, -0.3] }
rear = { linked_to = "other", offset = [-0.3, 0, 0.1] }

[[members]]
name = "left"
path = ["root", "tip"]
section = "spar"
elements = 2
local_y = [-1, 0, 0]

[[members]]
name = "right"
path = ["root", "other"]
section = "spar"
elements = 2
local_y = [-1, 0, 0]

[[masses]]
point = "root"
mass = 4
inertia = [0.2, 0.5, 0.6]

[[masses]]
point = "pod"
mass = 0.3

[damping]
modal_ratio = 0.02

[load_cases.dead]
t_end = 1
dt = 0.002

[[load_cases.dead.distributed_loads]]
member = "left"
frame = "dead"
force = [0.1, 0.02, 0.3]
moment = [0.1, -0.05, 0.2]
along = "1 - fraction/2"
time = { shape = "one-minus-cosine", amplitude = 0.02, duration = 1 }

[load_cases.body]
t_end = 1
dt = 0.002

[[load_cases.body.distributed_loads]]
member = "right"
frame = "body"
force = [0.02, -0.1, 0.3]
moment = [0.1, 0.3, -0.04]
along = "fraction"
time = { shape = "one-minus-cosine", amplitude = 0.02, duration = 1 }

[load_cases.follower]
t_end = 1
dt = 0.002

[[load_cases.follower.distributed_loads]]
member = "left"
frame = "follower"
force = [0.02, -0.1, 0.3]
moment = [0.1, 0.3, -0.04]
time = { shape = "one-minus-cosine", amplitude = 0.02, duration = 1 }
"#;

/// Loads that it is bent by at rest.
const BENT: &str = r#"
[equilibrium]
unbalanced = "warn"
loads = [{ point = "tip", frame = "follower", force = [0, 0, 6] }]

[[equilibrium.distributed_loads]]
member = "right"
frame = "follower"
force = [0, 0, -4]
moment = [0.5, 0, 0]
"#;

/// All of its modes, and those that are kept.
const ALL: usize = 24;
const FEW: usize = 4;

fn data(modes: usize, about: &str) -> ModelData {
    let structure = Structure::from_toml_str(&format!("{WING}{about}"), "wing.toml", &[]).unwrap();
    let options = BuildOptions { modes: ModeSelection::Count(modes), ..BuildOptions::default() };
    assert_eq!(options.inertia, Inertia::Constant);
    build(&structure, &options, &mut |_| ()).unwrap()
}

fn vector(list: &[f64], n: usize) -> Vector3<f64> {
    list.get(3 * n..3 * n + 3).map_or_else(Vector3::zeros, Vector3::from_column_slice)
}

fn rotation(q: &[f64]) -> Matrix3<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3])).to_rotation_matrix().into_inner()
}

fn six(force: Vector3<f64>, moment: Vector3<f64>) -> Vector6<f64> {
    Vector6::from_iterator(force.iter().chain(moment.iter()).copied())
}

fn column(rows: &[f64], m: usize, j: usize, first: usize) -> Vector3<f64> {
    Vector3::from_fn(|k, _| rows[(first + k) * m + j])
}

/// Translation and rotation of a station in a mode.
fn at_station(set: &StationSet, n: usize, m: usize, j: usize) -> (Vector3<f64>, Vector3<f64>) {
    (column(&set.phi_translation, m, j, 3 * n), column(&set.phi_rotation, m, j, 3 * n))
}

/// Forces and moments in A on the stations, of a column of a load.
fn on_stations(line: &MissingLine, set: &StationSet, column: usize) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    (0..set.len())
        .map(|n| {
            let (p, m) = (vector(&line.force, n), vector(&line.moment, n));
            let axes = rotation(&set.rotation[4 * n..4 * n + 4]);
            match line.frame {
                DistributedFrame::Dead => {
                    let along = Vector3::ith(column / 3, 1.0);
                    (along * p[column % 3], along * m[column % 3])
                }
                DistributedFrame::Body => (p, m),
                DistributedFrame::Follower => (axes * p, axes * m),
            }
        })
        .collect()
}

/// Amplitudes of the missing modes under every source: unit loads on the loaded points, columns of the loads per length.
fn missing_amplitudes(few: &ModelData, all: &ModelData) -> Vec<Vec<f64>> {
    let m = ALL;
    let missing = &few.validity.as_ref().unwrap().missing;
    let answer = |work: &dyn Fn(usize) -> f64, resultant: Vector6<f64>| -> Vec<f64> {
        let of_mode = |j: usize| {
            let phi_r = Vector6::from_fn(|k, _| all.modes.phi_r[k * m + j]);
            (work(j) + phi_r.dot(&resultant)) / all.modes.omega[j].powi(2)
        };
        (0..m).map(|j| if j < FEW { 0.0 } else { of_mode(j) }).collect()
    };
    let mut out = Vec::new();
    for &point in &missing.loaded {
        let p = &all.points[point as usize];
        for k in 0..6 {
            let unit = Vector3::ith(k % 3, 1.0);
            let place = Vector3::from(p.node_position);
            if k < 3 {
                let work = |j: usize| column(&p.phi_translation, m, j, 0).dot(&unit);
                out.push(answer(&work, six(unit, place.cross(&unit))));
            } else {
                let work = |j: usize| column(&p.phi_rotation, m, j, 0).dot(&unit);
                out.push(answer(&work, six(Vector3::zeros(), rotation(&p.node_rotation) * unit)));
            }
        }
    }
    for line in &missing.lines {
        let set = &all.lines[line.member as usize].stations;
        for k in 0..line.columns() {
            let loads = on_stations(line, set, k);
            let each = || loads.iter().enumerate();
            let work = |j: usize| -> f64 {
                let of_station = |(n, (f, moment)): (usize, &(Vector3<f64>, Vector3<f64>))| {
                    let (t, theta) = at_station(set, n, m, j);
                    t.dot(f) + theta.dot(&rotation(&set.rotation[4 * n..4 * n + 4]).tr_mul(moment))
                };
                each().map(of_station).sum()
            };
            let of_station = |(n, (f, moment)): (usize, &(Vector3<f64>, Vector3<f64>))| {
                six(*f, vector(&set.position, n).cross(f) + moment)
            };
            out.push(answer(&work, each().map(of_station).sum()));
        }
    }
    out
}

/// What a load reads of missing amplitudes.
fn readings(line: &MissingLine, few: &ModelData, all: &ModelData, amplitudes: &[f64]) -> Vec<f64> {
    let set = &all.lines[line.member as usize].stations;
    let own = &few.lines[line.member as usize].stations;
    let loads = on_stations(line, set, 0);
    let (mut dyad, mut wrench, mut rows) = (Matrix3::zeros(), Vector6::zeros(), vec![0.0; FEW]);
    for n in 0..set.len() {
        let (mut t, mut theta) = (Vector3::zeros(), Vector3::zeros());
        for (j, a) in amplitudes.iter().enumerate() {
            let (phi_t, phi_theta) = at_station(set, n, ALL, j);
            t += phi_t * *a;
            theta += phi_theta * *a;
        }
        let p = vector(&line.force, n);
        dyad += t * p.transpose();
        let (f, moment) = loads[n];
        if line.frame == DistributedFrame::Body {
            wrench += six(Vector3::zeros(), t.cross(&f));
        } else {
            let turn = rotation(&set.rotation[4 * n..4 * n + 4]) * theta;
            let turned = turn.cross(&f);
            let place = vector(&set.position, n);
            wrench += six(turned, t.cross(&f) + place.cross(&turned) + turn.cross(&moment));
            for (i, row) in rows.iter_mut().enumerate() {
                *row += at_station(own, n, FEW, i).0.dot(&turned);
            }
        }
    }
    match line.frame {
        DistributedFrame::Dead => dyad.transpose().iter().copied().collect(),
        DistributedFrame::Body => wrench.iter().skip(3).copied().collect(),
        DistributedFrame::Follower => wrench.iter().copied().chain(rows).collect(),
    }
}

fn close(found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let largest = expected.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    assert!(largest > 0.0, "{what} is zero");
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        // Digits: the static response is some hundred times what is missed.
        assert!((found - expected).abs() < 1e-7 * largest, "{what}, entry {k}: {found} {expected}");
    }
}

/// The part that the model file holds is the sum over all modes that are not in the model, of what it moves and of what it does to the loads.
#[test]
fn what_is_missed_is_in_the_other_modes() {
    let (few, all) = (data(FEW, BENT), data(ALL, BENT));
    let missing = &few.validity.as_ref().unwrap().missing;
    assert_eq!(missing.lines.len(), 4, "of the equilibrium, dead, body, follower");
    let amplitudes = missing_amplitudes(&few, &all);
    assert_eq!(amplitudes.len(), missing.n_sources());
    let mut source = 6 * missing.loaded.len();
    for (index, line) in missing.lines.iter().enumerate() {
        let own = &amplitudes[source..source + line.columns()];
        source += line.columns();
        let mut motion = Vec::new();
        for a in own {
            for point in &all.points {
                let rows = point.phi_translation.chunks(ALL).chain(point.phi_rotation.chunks(ALL));
                motion.extend(rows.map(|row| row.iter().zip(a).map(|(phi, a)| phi * a).sum::<f64>()));
            }
        }
        close(&line.flexibility, &motion, &format!("flexibility of line {index}"));
        let rigid = own.iter().flat_map(|a| {
            all.modes.phi_r.chunks(ALL).map(move |row| row.iter().zip(a).map(|(phi, a)| phi * a).sum::<f64>())
        });
        close(&line.rigid, &rigid.collect::<Vec<_>>(), &format!("motion of A under line {index}"));
        let by_source: Vec<Vec<f64>> =
            amplitudes.iter().map(|amplitudes| readings(line, &few, &all, amplitudes)).collect();
        let n = line.n_readings(FEW);
        for row in 0..n {
            let expected: Vec<f64> = by_source.iter().map(|readings| readings[row]).collect();
            let found = &line.readings[row * by_source.len()..(row + 1) * by_source.len()];
            close(found, &expected, &format!("reading {row} of line {index}"));
        }
    }
}

/// At rest in its equilibrium the elastic forces do the work of the loads in any shape, the second derivatives of the modes among them.
#[test]
fn loads_balance_the_elastic_forces_in_second_derivatives() {
    for frame in ["follower", "body", "dead"] {
        let about = BENT.replace(
            "member = \"right\"\nframe = \"follower\"",
            &format!("member = \"right\"\nframe = \"{frame}\""),
        );
        let data = data(FEW, &about);
        let validity = data.validity.as_ref().unwrap();
        let load = &data.trim.as_ref().unwrap().loads[0];
        let point = &data.points[load.point as usize];
        let LoadFrame::Follower { section } = load.frame else { panic!("{:?}", load.frame) };
        let section = Matrix3::from_fn(|i, j| section[i][j]);
        let force = rotation(&point.node_rotation) * section * Vector3::from(load.force);
        let pairs = FEW * (FEW + 1) / 2;
        let (mut elastic, mut work) = (Vec::new(), Vec::new());
        for pair in 0..pairs {
            elastic.push(validity.fields[pair * (13 + FEW)]);
            let theta = column(&validity.points[load.point as usize], pairs, pair, 0);
            let line = &validity.missing.lines[0];
            let read = &line.curvature[pair * line.n_curvature()..];
            // The attitude is the identity: so is C of a dead load.
            let of_line = if frame == "dead" { read[0] + read[4] + read[8] } else { read[0] };
            work.push(theta.dot(&force) + of_line);
        }
        close(&work, &elastic, &format!("work of the {frame} load"));
    }
}

/// Errors of a run with few modes, measured against one with all of them and estimated: v_G, w_G, and of the worst point.
fn measured_and_estimated(few: &Arc<Model>, all: &Arc<Model>, name: &str) -> [[f64; 2]; 3] {
    let case = few.load_case(name).unwrap();
    let settings = Settings { dt: case.dt, ..Settings::default() };
    let start = |model: &Arc<Model>| Simulation::new(model.clone(), settings).unwrap();
    let (mut short, mut full) = (start(few), start(all));
    short.watch_errors(2);
    let loads = [few, all].map(|model| model.prepare(case).unwrap());
    let n = 2 + few.n_points();
    let (mut errors, mut values) = (vec![0.0_f64; n], vec![0.0_f64; n]);
    for _ in 0..500 {
        short.step(&loads[0]).unwrap();
        full.step(&loads[1]).unwrap();
        let read = |model: &Model, simulation: &Simulation| -> Vec<Vector3<f64>> {
            let rigid = model.rigid_output(simulation.state());
            let points =
                (0..model.n_points()).map(|p| model.point_output(simulation.state(), p).unwrap().dr_a);
            [rigid.v_g, rigid.w_g].into_iter().chain(points).map(Vector3::from).collect()
        };
        let (found, truth) = (read(few, &short), read(all, &full));
        for k in 0..n {
            errors[k] = errors[k].max((found[k] - truth[k]).norm());
            values[k] = values[k].max(truth[k].norm());
        }
    }
    let farthest = values[2..].iter().fold(0.0_f64, |max, x| max.max(*x));
    let points = (2..n).filter(|&k| values[k] > 0.1 * farthest).map(|k| errors[k] / values[k]);
    let estimate = short.error_estimate().unwrap();
    assert!(!estimate.unseen_loads);
    [
        [errors[0] / values[0], estimate.v_g],
        [errors[1] / values[1], estimate.w_g],
        [points.fold(0.0, f64::max), estimate.dr_a],
    ]
}

/// The estimate under loads of every frame, so small that nothing is left out but the missing modes. Their deflections are told mode by mode but as
/// if they answered at once (a second against a fifth of one at most), the velocities they give A as of one oscillator.
#[test]
fn the_estimate_is_the_error() {
    let model = |modes: usize| Arc::new(Model::new(data(modes, "")).unwrap());
    let (few, all) = (model(FEW), model(ALL));
    for name in ["dead", "body", "follower"] {
        for (what, [measured, estimated]) in
            ["v_G", "w_G", "dR_A"].iter().zip(measured_and_estimated(&few, &all, name))
        {
            let allowed = if *what == "dR_A" { 0.03 } else { 0.2 };
            let off = (estimated / measured - 1.0).abs();
            assert!(off < allowed, "{name}, {what}: measured {measured}, estimated {estimated}");
        }
    }
}

/// Loads per length that the model was not built with, and those that a host sets, are told.
#[test]
fn other_loads_are_told() {
    let model = Arc::new(Model::new(data(FEW, BENT)).unwrap());
    let mut case = model.load_case("body").unwrap().clone();
    let unseen = |loads: &dyn Fn(&Model) -> LoadSet| {
        let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
        simulation.watch_errors(1);
        simulation.step(&loads(&model)).unwrap();
        simulation.error_estimate().unwrap().unseen_loads
    };
    assert!(!unseen(&|model| LoadSet::with_case(model, &[], &case).unwrap()));
    case.distributed[0].force.iter_mut().for_each(|p| *p *= 2.0);
    assert!(unseen(&|model| LoadSet::with_case(model, &[], &case).unwrap()));
    case.distributed[0].force.fill(0.0);
    case.distributed[0].moment.fill(0.0);
    assert!(!unseen(&|model| LoadSet::with_case(model, &[], &case).unwrap()));
}
