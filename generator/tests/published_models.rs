//! The published structures in `models/`: mass properties, geometry and load cases against the figures in the papers.

use approx::assert_relative_eq;
use nalgebra::{Matrix3, Matrix6, Vector3};
use rom_generator::input::Structure;
use rom_generator::mesh::Mesh;
use rom_generator::{BuildOptions, ModeSelection, build::build};
use rom_runtime::data::ModesData;
use rom_runtime::loads::LoadFrame;
use rom_runtime::time::TimeFunction;

fn model(name: &str, sets: &[(&str, &str)]) -> Structure {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../models").join(name);
    let sets: Vec<_> = sets.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
    Structure::from_toml_path(&path, &sets).unwrap_or_else(|e| panic!("{e}"))
}

/// 6x6 mass about the origin of A of the straight elements, integrated exactly: the section's mass is constant in
/// drawing axes and the position linear along the element.
fn rigid_mass(mesh: &Mesh) -> Matrix6<f64> {
    let mut total = Matrix6::zeros();
    for element in &mesh.elements {
        assert_eq!(element.n_nodes, 2);
        let [a, b] = [mesh.nodes[element.nodes[0]], mesh.nodes[element.nodes[1]]];
        let e = element.frames[0];
        let mut rotation = Matrix6::zeros();
        rotation.fixed_view_mut::<3, 3>(0, 0).copy_from(&e);
        rotation.fixed_view_mut::<3, 3>(3, 3).copy_from(&e);
        let section = rotation * mesh.sections[element.sections[0]].mass * rotation.transpose();
        // Two Gauss points integrate the quadratic exactly.
        for xi in [-1.0, 1.0].map(|s: f64| 0.5 + s / 12f64.sqrt()) {
            let r: Vector3<f64> = a + (b - a) * xi;
            let mut velocity = Matrix6::identity();
            velocity.fixed_view_mut::<3, 3>(0, 3).copy_from(&-r.cross_matrix());
            total += velocity.transpose() * section * velocity * (element.length / 2.0);
        }
    }
    total
}

/// Torsion of a straight beam moves no node: its sign, too, is that of the structure, not of how many modes are asked for. Runs of all methods start
/// in the same amplitudes.
#[test]
fn modes_are_the_same_however_many_are_asked_for() {
    let structure = model("ffb.toml", &[]);
    let modes = |count: usize| {
        let options = BuildOptions { modes: ModeSelection::Count(count), ..BuildOptions::default() };
        build(&structure, &options, &mut |_| ()).unwrap().modes
    };
    let many = modes(10);
    for count in [1, 4, 8] {
        let few = modes(count);
        for j in 0..count {
            let shape =
                |of: &ModesData, m: usize| -> Vec<f64> { (0..6).map(|r| of.phi_r[r * m + j]).collect() };
            let (a, b) = (shape(&few, count), shape(&many, 10));
            let (same, size): (f64, f64) =
                (a.iter().zip(&b).map(|(a, b)| a * b).sum(), b.iter().map(|b| b * b).sum());
            assert_relative_eq!(same, size, max_relative = 1e-6);
        }
    }
}

#[test]
fn fmb_has_the_published_mass_properties() {
    for elements in ["60", "120", "1200", "12000"] {
        let structure = model("fmb.toml", &[("elements", elements)]);
        let mesh = structure.mesh();
        let n: usize = elements.parse().unwrap();
        assert_eq!((mesh.elements.len(), mesh.nodes.len(), structure.element_count()), (n, n + 1, n));
        let mass = rigid_mass(&mesh);
        assert_relative_eq!(mass[(0, 0)], 405.0, max_relative = 1e-12);
        // M_vw = -m r_CM~: row 0, column 4 is m z.
        assert_relative_eq!(mass[(0, 4)] / 405.0, 5.0 / 6.0, max_relative = 1e-12);
        assert!(mass[(1, 3)] + mass[(0, 4)] < 1e-9 && mass[(0, 5)].abs() < 1e-9);
        // To the digits of the paper.
        for (i, published) in [(3, 1125.4), (4, 23625.1), (5, 22500.4)] {
            assert!((mass[(i, i)] - published).abs() < 0.05, "{i}: {}", mass[(i, i)]);
        }
        assert!(mass[(3, 4)].abs().max(mass[(3, 5)].abs()).max(mass[(4, 5)].abs()) < 1e-6);
    }
}

#[test]
fn fmb_nodes_frames_and_points() {
    let mesh = model("fmb.toml", &[]).mesh();
    assert_eq!(mesh.nodes[mesh.reference], Vector3::zeros());
    assert_eq!(mesh.members.len(), 4);
    // A chain: numbered from tip to tip.
    for element in &mesh.elements {
        assert_eq!(element.nodes[0].abs_diff(element.nodes[1]), 1);
        assert_relative_eq!(element.length, 0.25, max_relative = 1e-14);
    }
    let y = Vector3::y();
    for (member, x) in [(0, Vector3::x()), (1, Vector3::z()), (2, -Vector3::x()), (3, Vector3::z())] {
        let e = mesh.elements[mesh.members[member].elements.start].frames[0];
        assert_relative_eq!(e, Matrix3::from_columns(&[x, y, x.cross(&y)]), epsilon = 1e-15);
    }
    let at = |name: &str| {
        let point = mesh.points.iter().find(|p| p.name == name).unwrap();
        (mesh.nodes[point.node().unwrap()] + point.offset, point.sections.len())
    };
    assert_eq!(at("P"), (Vector3::new(10.0, 0.0, 5.0), 1));
    assert_eq!(at("Q"), (Vector3::new(-10.0, 0.0, 5.0), 1));
    assert_eq!(at("right corner"), (Vector3::new(10.0, 0.0, 0.0), 2));
    assert_eq!(at("CM"), (Vector3::new(0.0, 0.0, 5.0 / 6.0), 2));
    // Section at sigma = 10, E0 = 70 GPa, nu = 0.3: literal numbers of CASES.
    let s = mesh.sections[0].stiffness;
    let (e, g) = (7e11, 7e11 / 2.6);
    let (area, iy, iz) = (0.005, 0.1 * 0.05f64.powi(3) / 12.0, 0.05 * 0.1f64.powi(3) / 12.0);
    let gj = 0.22887745119762 * g * 0.1 * 0.05f64.powi(3);
    let expected = [e * area, g * area * 5.0 / 6.0, g * area * 5.0 / 6.0, gj, e * iy, e * iz];
    for (i, value) in expected.into_iter().enumerate() {
        assert_relative_eq!(s[(i, i)], value, max_relative = 1e-14);
    }
}

#[test]
fn fmb_load_cases() {
    let mesh = model("fmb.toml", &[]).mesh();
    let names: Vec<&str> = mesh.load_cases.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["lc1", "lc2", "spiral"]);
    let [lc1, lc2, spiral] = &mesh.load_cases[..] else { unreachable!() };
    assert_eq!((lc1.t_end, lc1.dt, lc1.numerical_damping), (20.0, 0.01, 0.01));
    assert_eq!((lc2.t_end, lc2.dt, lc2.numerical_damping), (10.0, 0.01, 0.01));
    assert_eq!((spiral.t_end, spiral.dt, spiral.numerical_damping), (80.0, 0.1, 0.01));
    assert_eq!(lc2.loads, [&lc1.loads[..2], &lc1.loads[4..6]].concat());
    assert_eq!(lc1.loads[0].time, TimeFunction::Ramp { rate: 100.0, start: 0.0, end: 10.0 });
    // The resultant force of case 1 at full load: F/4 = 250 N along y, the rest in couples.
    let resultant = lc1.loads.iter().fold(Vector3::zeros(), |sum, l| sum + Vector3::from(l.force) * 1000.0);
    assert_eq!(resultant, Vector3::new(0.0, 250.0, 0.0));
    // The right arm runs along z with local y = y: local z = -x.
    let section = [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    assert_eq!(lc1.loads[2].frame, LoadFrame::Follower { section });
    assert_eq!(lc1.loads[2].moment, [0.0, 2.0, 0.0]);
}

#[test]
fn ffb_runs_from_a_to_b() {
    let mesh = model("ffb.toml", &[]).mesh();
    assert_eq!(mesh.elements.len(), 20);
    let e = mesh.elements[0].frames[0];
    assert_relative_eq!(e.column(0).into_owned(), Vector3::new(-0.6, 0.0, 0.8), epsilon = 1e-15);
    assert_relative_eq!(e.column(1).into_owned(), Vector3::y(), epsilon = 1e-15);
    let mass = rigid_mass(&mesh);
    assert_relative_eq!(mass[(0, 0)], 10.0, max_relative = 1e-14);
    assert_eq!(mesh.sections[0].mass.diagonal().as_slice(), [1.0, 1.0, 1.0, 20.0, 10.0, 10.0]);
    let names: Vec<&str> = mesh.load_cases.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["planar", "spatial"]);
    let TimeFunction::Step { value, start, end } = mesh.load_cases[0].loads[0].time else { unreachable!() };
    assert_eq!((value, start, end), (80.0, 0.0, 2.5));
}

/// Every structure in `models/`: its reduced model passes its own checks and every load case of it runs.
#[test]
fn every_model_builds_and_runs() {
    use rom_generator::build::{BuildOptions, ModeSelection, build};
    use rom_runtime::{Model, Settings, Simulation};
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".toml") && name != "gust.toml") // a file of load cases
        .collect();
    names.sort();
    assert!(names.len() >= 5, "{names:?}");
    for name in names {
        let options =
            BuildOptions { modes: ModeSelection::Count(6), all_nodes: false, ..BuildOptions::default() };
        let data = build(&model(&name, &[]), &options, &mut |_| ()).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(data.checks.iter().all(|c| c.value <= c.limit), "{name}: {:?}", data.checks);
        let built = std::sync::Arc::new(Model::new(data).unwrap());
        for case in built.data().load_cases.clone() {
            let loads = built.prepare(&case).unwrap();
            let settings =
                Settings { dt: case.dt, numerical_damping: case.numerical_damping, ..Settings::default() };
            let mut simulation = Simulation::new(built.clone(), settings).unwrap();
            simulation.solve_accelerations(&loads).unwrap();
            for _ in 0..30 {
                simulation.step(&loads).unwrap_or_else(|e| panic!("{name}, {}: {e}", case.name));
            }
        }
    }
}
