use rom_runtime::data::{CheckData, ModesData, Provenance, RigidData};

use super::*;

fn tensor_of(entries: &[(u32, u32, u32, f64)]) -> TensorData {
    TensorData {
        i: entries.iter().map(|e| e.0).collect(),
        l: entries.iter().map(|e| e.1).collect(),
        r: entries.iter().map(|e| e.2).collect(),
        value: entries.iter().map(|e| e.3).collect(),
        threshold: 1e-14,
        scale: "of the largest entry".to_owned(),
        dropped_norm: 0.0,
        dropped_count: 0,
    }
}

/// Two modes, numbers 1 and 3; one point 2 m along x with an offset of 1 m, its node turned a quarter about z.
pub(crate) fn sample() -> ModelData {
    let mut mass_matrix = vec![0.0; 36];
    for (i, m) in [4.0, 4.0, 4.0, 9.0, 9.0, 9.0].into_iter().enumerate() {
        mass_matrix[7 * i] = m;
    }
    let half = std::f64::consts::FRAC_1_SQRT_2;
    ModelData {
        provenance: Provenance {
            name: "frame".to_owned(),
            generator: "romgen 0".to_owned(),
            input_text: "[structure]".to_owned(),
            input_sha256: "00".to_owned(),
            options: vec![("--modes".to_owned(), "1,3".to_owned())],
            parameters: vec![("sigma".to_owned(), 10.0)],
            n_elements: 4,
            n_dof: 24,
        },
        rigid: RigidData { mass: 4.0, centre_of_mass: [0.0; 3], mass_matrix, initial_position: [0.0; 3] },
        modes: ModesData {
            number: vec![1, 3],
            omega: vec![2.0, std::f64::consts::TAU],
            mass: vec![1.0, 1.0],
            damping_ratio: vec![0.0, 0.01],
            // Mode 1 moves A along y; mode 3 turns it about z.
            phi_r: vec![0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25],
            first_moment: vec![0.0; 6],
            kinetic_share: vec![0.0, 0.9, 0.0, 0.0, 0.0, 0.1, 0.5, 0.25, 0.25, 0.0, 0.0, 0.0],
            next_omega: Some(8.0),
        },
        c: tensor_of(&[(0, 1, 5, -2.0), (0, 5, 4, 0.5), (0, 6, 3, 0.1), (1, 0, 5, 1.5), (6, 1, 3, 3.0)]),
        k: tensor_of(&[(0, 0, 28, -1.5), (0, 0, 35, 0.5), (1, 1, 7, 9.0)]),
        points: vec![PointData {
            name: "P".to_owned(),
            node_position: [2.0, 0.0, 0.0],
            node_rotation: [half, 0.0, 0.0, half],
            offset: [1.0, 0.0, 0.0],
            phi_translation: vec![0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
            phi_rotation: vec![0.0, 0.0, 0.0, 0.0, 0.0, 2.0],
            sections: vec![("arm".to_owned(), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])],
        }],
        load_cases: Vec::new(),
        picture: None,
        picture_curve: None,
        trim: None,
        sensors: Vec::new(),
        gravity: None,
        residual: None,
        validity: None,
        selection: None,
        lagrangian: None,
        damping: None,
        clamped: None,
        checks: vec![CheckData { name: "orthogonality".to_owned(), value: 1e-3, limit: 1e-9 }],
        lines: Vec::new(),
        stations: Vec::new(),
        cuts: Vec::new(),
    }
}

#[test]
fn participation_is_the_inertial_motion_of_the_point() {
    let info = Info::new(&Model::new(sample()).unwrap());
    // The offset, turned a quarter about z, points along y.
    assert!(info.points[0].position.iter().zip([2.0, 1.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-15));
    let first = &info.modes[0].participation[0];
    assert_eq!(first.force, [0.0, 1.5, 0.0], "its own 1 and 0.5 of A");
    // theta_z = 2 moves the offset (along y) by -2 along x; A's 0.25 about z sweeps (2, 1) by (-0.25, 0.5).
    let second = &info.modes[1].participation[0];
    assert!(
        second.force.iter().zip([-2.25, 0.5, 0.0]).all(|(a, b)| (a - b).abs() < 1e-15),
        "{:?}",
        second.force
    );
    assert_eq!(second.moment, [0.0, 0.0, 2.25]);
}

#[test]
fn couplings_are_told_in_words() {
    let told = couplings(&sample());
    let texts: Vec<&str> = told.iter().map(|c| c.text.as_str()).collect();
    assert_eq!(
        texts,
        [
            "yaw rate (w_z) couples mode 1 with mode 3 (-2 on mode 1, 1.5 on mode 3)",
            "roll rate (w_x) times pitch rate (w_y) drives mode 1 (0.2)",
            "roll rate (w_x) times the rate of mode 3 reacts on pitch (about y) (1)",
            "pitch rate (w_y) squared softens mode 1 (-1.5 on its frequency squared)",
            "yaw rate (w_z) squared stiffens mode 1 (0.5 on its frequency squared)",
        ]
    );
}

#[test]
fn text_and_json_say_the_same() {
    let info = Info::new(&Model::new(sample()).unwrap());
    let text = info.to_text(&["P"]);
    for part in ["frame: 2 elastic modes", "6.28319", "FAILED: orthogonality", "sigma = 10", "--modes 1,3"] {
        assert!(text.contains(part), "no {part} in\n{text}");
    }
    let json = serde_json::to_value(&info).unwrap();
    assert_eq!(json["modes"][1]["frequency_hz"], 1.0);
    assert_eq!(json["modes"][1]["number"], 3);
    assert_eq!(json["tensors"]["c"]["possible"], 8 * 8 * 6);
    assert!(json["stable_time_step"]["gen-alpha"].is_null());
    // omega dt = 2 sqrt(2) without damping; a little of it changes that a little.
    let limit = json["stable_time_step"]["rk4"].as_f64().unwrap() * std::f64::consts::TAU;
    assert!((limit - 8.0_f64.sqrt()).abs() < 0.05, "{limit}");
}
