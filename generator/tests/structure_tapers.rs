//! Sections and twist given at fractions of a member.

use approx::assert_relative_eq;
use nalgebra::Vector6;
use rom_generator::input::Structure;
use rom_generator::mesh::Mesh;

const HEAD: &str = "[structure]\nname = \"taper\"\nreference = \"A\"\n[points]\nA = [0, 0, 0]\nB = [4, 0, 0]\n\
    [materials.steel]\nE = 2.08e11\nnu = 0.3\nrho = 8000\n[materials.wood]\nE = 1e10\nnu = 0.3\nrho = 500\n";

const SECTIONS: &str = "[sections.root]\nshape = \"rectangle\"\nmaterial = \"steel\"\nwidth_y = 0.2\nwidth_z = 0.4\n\
    [sections.tip]\nshape = \"rectangle\"\nmaterial = \"steel\"\nwidth_y = 0.1\nwidth_z = 0.2\n\
    [sections.wooden]\nshape = \"rectangle\"\nmaterial = \"wood\"\nwidth_y = 0.2\nwidth_z = 0.4\n\
    [sections.pipe]\nshape = \"tube\"\nmaterial = \"steel\"\nouter_diameter = 0.2\nwall_thickness = 0.02\n\
    [sections.thin]\nshape = \"tube\"\nmaterial = \"steel\"\nouter_diameter = 0.1\nwall_thickness = 0.01\n";

fn mesh(member: &str) -> Mesh {
    let text = format!(
        "{HEAD}{SECTIONS}[[members]]\nname = \"m\"\npath = [\"A\", \"B\"]\nlocal_y = [0, 1, 0]\n{member}\n"
    );
    Structure::from_toml_str(&text, "taper.toml", &[]).unwrap_or_else(|e| panic!("{e}")).mesh()
}

/// Diagonals of stiffness and mass at the start of every element and at the end of the last.
fn sections(mesh: &Mesh) -> Vec<(Vector6<f64>, Vector6<f64>)> {
    let at = |index: usize| (mesh.sections[index].stiffness.diagonal(), mesh.sections[index].mass.diagonal());
    for pair in mesh.elements.windows(2) {
        assert_eq!(pair[0].sections[1], pair[1].sections[0], "neighbours share the section between them");
    }
    let last = mesh.elements.last().map(|e| at(e.sections[1]));
    mesh.elements.iter().map(|e| at(e.sections[0])).chain(last).collect()
}

#[test]
fn sizes_of_one_shape_are_linear() {
    let found = sections(&mesh("section = [\"root\", \"tip\"]\nelements = 8"));
    for (k, (stiffness, mass)) in found.iter().enumerate() {
        let scale = 1.0 - k as f64 / 16.0;
        let (b, h) = (0.2 * scale, 0.4 * scale);
        assert_relative_eq!(stiffness[0], 2.08e11 * b * h, max_relative = 1e-14);
        assert_relative_eq!(stiffness[4], 2.08e11 * b * h.powi(3) / 12.0, max_relative = 1e-14);
        // Sections of one proportion: J goes with the fourth power of the size.
        assert_relative_eq!(stiffness[3], found[0].0[3] * scale.powi(4), max_relative = 1e-12);
        assert_relative_eq!(mass[0], 8000.0 * b * h, max_relative = 1e-14);
    }
    let tubes = sections(&mesh("section = [\"pipe\", \"thin\"]\nelements = 2"));
    let (d, i): (f64, f64) = (0.15, 0.12);
    let area = std::f64::consts::FRAC_PI_4 * (d * d - i * i);
    assert_relative_eq!(tubes[1].0[0], 2.08e11 * area, max_relative = 1e-13);
    assert_relative_eq!(tubes[1].0[4], 2.08e11 * area * (d * d + i * i) / 16.0, max_relative = 1e-13);
}

#[test]
fn matrices_of_different_kinds_are_linear() {
    for pair in ["[\"root\", \"wooden\"]", "[\"pipe\", \"tip\"]"] {
        let found = sections(&mesh(&format!("section = {pair}\nelements = 4")));
        for (k, (stiffness, mass)) in found.iter().enumerate() {
            let x = k as f64 / 4.0;
            assert_relative_eq!(*stiffness, found[0].0 * (1.0 - x) + found[4].0 * x, max_relative = 1e-13);
            assert_relative_eq!(*mass, found[0].1 * (1.0 - x) + found[4].1 * x, max_relative = 1e-13);
        }
    }
}

/// Stations are met where they are nodes, equal stations make no new sections, and a constant member none at all.
#[test]
fn stations_along_the_member() {
    let course = "section = [[0, \"root\"], [0.25, \"root\"], [0.75, \"tip\"], [1, \"pipe\"]]";
    let mesh = mesh(&format!("{course}\nelements = 8\ntwist = [[0, 0.1], [0.5, 0.3], [1, -0.1]]"));
    let names: Vec<&str> = mesh.elements.iter().map(|e| mesh.sections[e.sections[1]].name.as_str()).collect();
    let expected = [
        "root",
        "root",
        "root to tip at 0.2500",
        "root to tip at 0.5000",
        "root to tip at 0.7500",
        "tip",
        "tip to pipe at 0.5000",
        "pipe",
    ];
    assert_eq!(names, expected);
    assert_eq!(mesh.sections.len(), 5 + 4);
    for (k, element) in mesh.elements.iter().enumerate() {
        let x = k as f64 / 8.0;
        let twist = if x <= 0.5 { 0.1 + 0.4 * x } else { 0.3 - 0.8 * (x - 0.5) };
        assert_relative_eq!(
            element.frames[0][(2, 1)].atan2(element.frames[0][(1, 1)]),
            twist,
            epsilon = 1e-14
        );
    }
    assert_eq!(self::mesh("section = \"root\"\nelements = 3").sections.len(), 5);
}
