//! `[damping]`: what it means for sections and modes, and what is refused.

use rom_generator::input::Structure;
use rom_generator::mesh::Mesh;

const BASE: &str = r#"
[structure]
name = "beam"
reference = "A"

[materials.alloy]
E = 70e9
nu = 0.3
rho = 2700

[materials.rubber]
E = 1e8
nu = 0.4
rho = 1100
retardation_time = 0.05

[sections.spar]
shape = "circle"
material = "alloy"
diameter = 0.1

[sections.pad]
shape = "circle"
material = "rubber"
diameter = 0.1

[sections.tip]
shape = "constants"
EA = 1e6
GAy = 1e6
GAz = 1e6
GJ = 1e4
EIy = 1e4
EIz = 1e4
rhoA = 1
rhoJ = [0.02, 0.01, 0.01]
retardation_time = 0.01

[points]
A = [0, 0, 0]
B = [1, 0, 0]
C = [2, 0, 0]
D = [3, 0, 0]

[[members]]
name = "one"
path = ["A", "B"]
section = "spar"
elements = 2
local_y = [0, 1, 0]

[[members]]
name = "two"
path = ["B", "C"]
section = "pad"
elements = 2
local_y = [0, 1, 0]

[[members]]
name = "three"
path = ["C", "D"]
section = ["pad", "tip"]
elements = 2
local_y = [0, 1, 0]
"#;

fn read(damping: &str) -> Result<Mesh, String> {
    let text = format!("{BASE}\n[damping]\n{damping}\n");
    Structure::from_toml_str(&text, "beam.toml", &[]).map(|s| s.mesh()).map_err(|e| e.to_string())
}

/// Retardation times at both ends of every second element.
fn times(mesh: &Mesh) -> Vec<[f64; 2]> {
    mesh.elements.iter().map(|e| e.sections.map(|s| mesh.sections[s].retardation)).collect()
}

#[test]
fn retardation_times_are_those_of_section_material_or_structure() {
    let mesh = read("retardation_time = 0.002\nrayleigh = { stiffness = 0.001 }").unwrap();
    let expected =
        [[0.003, 0.003], [0.003, 0.003], [0.051, 0.051], [0.051, 0.051], [0.051, 0.031], [0.031, 0.011]];
    for (found, expected) in times(&mesh).iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() < 1e-15, "{found} {expected}");
    }
    assert_eq!(times(&read("").unwrap())[0], [0.0, 0.0]);
}

#[test]
fn two_ratios_make_two_factors() {
    let mesh = read("rayleigh = { omega = [10, 40], ratio = [0.02, 0.03] }").unwrap();
    let (alpha, beta) = (mesh.damping.alpha, times(&mesh)[0][0]);
    for (omega, ratio) in [(10.0, 0.02), (40.0, 0.03)] {
        assert!((alpha / (2.0 * omega) + beta * omega / 2.0 - ratio).abs() < 1e-15);
    }
}

#[test]
fn modal_ratios_go_by_number() {
    let ratios = |text: &str| {
        let modal = read(&format!("modal_ratio = {text}")).unwrap().damping.modal;
        ([1, 2, 3, 4].map(|mode| modal.of(mode)), modal.count())
    };
    assert_eq!(ratios("0.01"), ([0.01; 4], 30));
    assert_eq!(ratios("[0.01, \"2/100\"]"), ([0.01, 0.02, 0.0, 0.0], 2));
    assert_eq!(ratios("[[3, 0.03], [1, 0.01]]"), ([0.01, 0.0, 0.03, 0.0], 3));
    assert_eq!(ratios("[]"), ([0.0; 4], 0));
}

#[test]
fn what_cannot_be_is_refused() {
    for (damping, words) in [
        ("modal_ratio = 1.5", "ratio is 1.5, expected 0 to below 1"),
        ("modal_ratio = [0.1, -0.1]", "ratio is -0.1"),
        ("modal_ratio = [[1, 0.1], 0.2]", "expected [mode, ratio]"),
        ("modal_ratio = [[1, 0.1], [1, 0.2]]", "mode 1 has a ratio already"),
        ("modal_ratio = [[20000, 0.1]]", "mode 20000, expected at most 10000"),
        ("modal_ratio = [[0.5, 0.1]]", "expected a whole number from 1"),
        ("retardation_time = -1", "retardation time is -1 s, expected zero or more"),
        ("rayleigh = { mass = -1 }", "factor on the mass is -1 1/s"),
        ("rayleigh = { mass = 1, omega = [1, 2], ratio = [0.1, 0.1] }", "one of two ways"),
        ("rayleigh = { omega = [1, 2] }", "one of two ways"),
        ("rayleigh = { omega = [2, 1], ratio = [0.1, 0.1] }", "frequencies are 2 and 1 rad/s"),
        ("rayleigh = { omega = [1, 2], ratio = [0.1, 0.5] }", "feed energy in"),
        ("ratio = 0.01", "no key `ratio`"),
    ] {
        let message = read(damping).unwrap_err();
        assert!(message.contains(words) && message.contains("beam.toml"), "{damping}: {message}");
    }
}
