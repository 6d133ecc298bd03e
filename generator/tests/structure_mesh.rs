//! From structure files to meshes: geometry, section axes, joints, masses, points.

use std::f64::consts::{FRAC_PI_2, PI};

use approx::assert_relative_eq;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use rom_generator::input::Structure;
use rom_generator::mesh::Mesh;

/// A structure with one section and the given points and members.
fn structure(rest: &str) -> String {
    format!(
        "[structure]\nname = \"test\"\nreference = \"A\"\n\
         [sections.s]\nshape = \"constants\"\nEA = 1\nGAy = 1\nGAz = 1\nGJ = 1\nEIy = 1\nEIz = 1\nrhoA = 1\nrhoJ = [2, 1, 1]\n{rest}"
    )
}

fn mesh(rest: &str) -> Mesh {
    Structure::from_toml_str(&structure(rest), "test.toml", &[]).unwrap_or_else(|e| panic!("{e}")).mesh()
}

fn member(name: &str, path: &str, more: &str) -> String {
    format!("[[members]]\nname = \"{name}\"\n{path}\nsection = \"s\"\n{more}\n")
}

/// What holds for every mesh.
fn check_sound(mesh: &Mesh) {
    assert_eq!(mesh.nodes[mesh.reference], Vector3::zeros());
    let mut used = vec![false; mesh.nodes.len()];
    for (index, member) in mesh.members.iter().enumerate() {
        let mut along: Vec<usize> = vec![];
        for element in &mesh.elements[member.elements.clone()] {
            assert_eq!(element.member, index);
            let nodes = &element.nodes[..element.n_nodes];
            if let Some(last) = along.pop() {
                assert_eq!(last, nodes[0]);
            }
            along.extend(nodes);
            for (i, frame) in element.frames[..element.n_nodes].iter().enumerate() {
                assert!((frame.transpose() * frame - Matrix3::identity()).amax() < 1e-14);
                assert_relative_eq!(frame.determinant(), 1.0, epsilon = 1e-14);
                used[nodes[i]] = true;
            }
        }
        assert_eq!(along, member.nodes);
        // Inner nodes are numbered in a row.
        let inner = &member.nodes[1..member.nodes.len() - 1];
        assert!(inner.windows(2).all(|w| w[0].abs_diff(w[1]) == 1), "{inner:?}");
    }
    assert!(used.iter().all(|&u| u), "a node without an element");
}

#[test]
fn arc_of_two_node_elements() {
    let points = "[points]\nA = [2, 0, 1]\nB = [0, 2, 1]\n";
    let on = "arc = { from = \"A\", to = \"B\", center = [0, 0, 1] }";
    let mesh = mesh(&(points.to_owned() + &member("hoop", on, "elements = 9\nlocal_y = [0, 0, 1]")));
    check_sound(&mesh);
    assert_eq!(mesh.reference_position, Vector3::new(2.0, 0.0, 1.0));
    assert_relative_eq!(*mesh.nodes.last().unwrap(), Vector3::new(-2.0, 2.0, 0.0), epsilon = 1e-15);
    for (k, element) in mesh.elements.iter().enumerate() {
        assert_relative_eq!(element.length, PI / 9.0, max_relative = 1e-14);
        for i in 0..2 {
            let phi = FRAC_PI_2 * (k + i) as f64 / 9.0;
            let r = mesh.nodes[element.nodes[i]] + mesh.reference_position;
            assert_relative_eq!(r, Vector3::new(2.0 * phi.cos(), 2.0 * phi.sin(), 1.0), epsilon = 1e-14);
            let tangent = Vector3::new(-phi.sin(), phi.cos(), 0.0);
            let expected = Matrix3::from_columns(&[tangent, Vector3::z(), tangent.cross(&Vector3::z())]);
            assert_relative_eq!(element.frames[i], expected, epsilon = 1e-14);
        }
    }
}

#[test]
fn arc_of_three_node_elements_has_its_middle_nodes_at_half_arc_length() {
    let points = "[points]\nA = [1, 0, 0]\nB = [-1, 0, 0]\n";
    let on = "arc = { from = \"A\", to = \"B\", through = [0, 1, 0] }";
    let more = "elements = 4\nelement_nodes = 3\nlocal_y = [0, 0, 1]";
    let mesh = mesh(&(points.to_owned() + &member("hoop", on, more)));
    check_sound(&mesh);
    assert_eq!((mesh.nodes.len(), mesh.elements.len()), (9, 4));
    for (k, element) in mesh.elements.iter().enumerate() {
        assert_eq!((element.n_nodes, element.nodes), (3, [2 * k, 2 * k + 1, 2 * k + 2]));
        assert_relative_eq!(element.length, PI / 4.0, max_relative = 1e-14);
        let phi = PI * (2 * k + 1) as f64 / 8.0;
        let middle = mesh.nodes[element.nodes[1]] + mesh.reference_position;
        assert_relative_eq!(middle, Vector3::new(phi.cos(), phi.sin(), 0.0), epsilon = 1e-14);
    }
}

#[test]
fn twist_runs_linearly_along_the_arc_length_and_across_corners() {
    let points = "[points]\nA = [0, 0, 0]\nB = [1, 0, 0]\nC = [1, 0, 3]\n";
    let path = "path = [\"A\", \"B\", \"C\"]";
    let more = "elements = 8\nlocal_y = [0, 1, 0]\ntwist = [\"10*deg\", \"50*deg\"]";
    let mesh = mesh(&(points.to_owned() + &member("m", path, more)));
    check_sound(&mesh);
    // Shared out by length: 2 of 0.5 m and 6 of 0.5 m.
    assert!(mesh.elements.iter().all(|e| (e.length - 0.5).abs() < 1e-15));
    for (k, element) in mesh.elements.iter().enumerate() {
        for i in 0..2 {
            let angle = (10.0 + 40.0 * (k + i) as f64 / 8.0).to_radians();
            // Local y leans from y towards z = x cross y.
            let x = if k < 2 { Vector3::x() } else { Vector3::z() };
            let y = Vector3::y() * angle.cos() + x.cross(&Vector3::y()) * angle.sin();
            assert_relative_eq!(element.frames[i].column(1).into_owned(), y, epsilon = 1e-15);
            assert_relative_eq!(element.frames[i].column(0).into_owned(), x, epsilon = 1e-15);
        }
    }
}

#[test]
fn local_y_needs_not_be_normal_to_the_axis() {
    let points = "[points]\nA = [0, 0, 0]\nB = [1, 0, 0]\n";
    let mesh = mesh(
        &(points.to_owned() + &member("m", "path = [\"A\", \"B\"]", "elements = 1\nlocal_y = [5, 0, 0.5]")),
    );
    let expected = Matrix3::from_columns(&[Vector3::x(), Vector3::z(), -Vector3::y()]);
    assert_relative_eq!(mesh.elements[0].frames[0], expected, epsilon = 1e-15);
}

#[test]
fn elements_are_shared_out_by_length_with_one_at_least() {
    let points = "[points]\nA = [0, 0, 0]\nB = [1, 0, 0]\nC = [1.013, 0, 0]\nD = [3.013, 0, 0]\n";
    let path = "path = [\"A\", \"B\", \"C\", \"D\"]";
    let counts = |elements: &str| {
        let more = format!("elements = {elements}\nlocal_y = [0, 1, 0]");
        let mesh = mesh(&(points.to_owned() + &member("m", path, &more)));
        check_sound(&mesh);
        let lengths = [1.0, 0.013, 2.0];
        let mut counts = vec![];
        let mut rest = &mesh.elements[..];
        for length in lengths {
            let n = rest.iter().take_while(|e| (e.length - rest[0].length).abs() < 1e-12).count();
            assert_relative_eq!(rest[0].length * n as f64, length, max_relative = 1e-12);
            counts.push(n);
            rest = &rest[n..];
        }
        counts
    };
    assert_eq!(counts("3"), [1, 1, 1]);
    assert_eq!(counts("7"), [2, 1, 4]);
    assert_eq!(counts("300"), [100, 1, 199]);
    assert_eq!(counts("[5, 2, 3]"), [5, 2, 3]);
}

#[test]
fn a_corner_keeps_both_section_frames() {
    let points = "[points]\nA = [0, 0, 0]\nB = [1, 0, 0]\nC = [1, 0, 1]\nS = [2, 0, 0]\n";
    let members = member("bent", "path = [\"A\", \"B\", \"C\"]", "elements = 4\nlocal_y = [0, 1, 0]")
        + &member("straight", "path = [\"B\", \"S\"]", "elements = 4\nlocal_y = [0, 1, 0]");
    let mesh = mesh(&(points.to_owned() + &members));
    check_sound(&mesh);
    let b = &mesh.points[1];
    let names: Vec<&str> = b.sections.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["bent", "bent", "straight"]);
    assert_relative_eq!(b.sections[1].1.column(0).into_owned(), Vector3::z(), epsilon = 1e-15);
    let load = |member: &str| {
        let load = format!("{{ point = \"B\", frame = \"follower\"{member}, force = [1, 0, 0] }}");
        let case = format!("[load_cases.one]\nt_end = 1\ndt = 0.1\nloads = [{load}]\n");
        let text = structure(&(points.to_owned() + &members + &case));
        Structure::from_toml_str(&text, "test.toml", &[]).map_err(|e| e.to_string())
    };
    assert!(load(", member = \"straight\"").is_ok());
    assert!(load(", member = \"bent\"").unwrap_err().contains("has a corner at point `B`"));
    assert!(load("").unwrap_err().contains("`bent`, `straight`"));
}

#[test]
fn closed_loops_and_junctions() {
    let points = "[points]\nA = [0, 0, 0]\nB = [1, 0, 0]\nC = [1, 0, 1]\nD = [0, 0, 1]\nE = [0, 1, 0]\n";
    let one = |from: &str, to: &str| {
        member(
            &format!("{from}{to}"),
            &format!("path = [\"{from}\", \"{to}\"]"),
            "elements = 5\nlocal_y = [1, 1, 1]",
        )
    };
    let ring = one("A", "B") + &one("C", "B") + &one("C", "D") + &one("A", "D");
    let closed = mesh(&(points.replace("E = [0, 1, 0]\n", "") + &ring));
    check_sound(&closed);
    assert_eq!((closed.nodes.len(), closed.elements.len()), (20, 20));
    let junction = mesh(&(points.to_owned() + &ring + &one("A", "E")));
    check_sound(&junction);
    assert_eq!(junction.nodes.len(), 25);
    assert_eq!(junction.points[0].sections.len(), 3);
    // One member may close on itself, and two may run side by side.
    let single = member("loop", "path = [\"A\", \"B\", \"C\", \"A\"]", "elements = 6\nlocal_y = [0, 1, 0]");
    let twin = one("A", "B") + &member("twin", "path = [\"A\", \"B\"]", "elements = 3\nlocal_y = [0, 1, 0]");
    let only = |names: &[&str]| {
        points
            .lines()
            .filter(|l| l.starts_with('[') || names.iter().any(|n| l.starts_with(n)))
            .fold(String::new(), |text, line| text + line + "\n")
    };
    check_sound(&mesh(&(only(&["A", "B", "C"]) + &single)));
    let side_by_side = mesh(&(only(&["A", "B"]) + &twin));
    check_sound(&side_by_side);
    assert_eq!(side_by_side.nodes.len(), 6 + 2);
}

#[test]
fn a_chain_is_numbered_from_end_to_end_whatever_the_order_and_sense_of_its_members() {
    let points = "[points]\nA = [0, 0, 0]\nB = [1, 0, 0]\nC = [2, 0, 1]\nD = [3, 0, 0]\nE = [4, 0, 0]\n";
    let one = |from: &str, to: &str| {
        let more = "elements = 3\nelement_nodes = 3\nlocal_y = [0, 1, 0]";
        member(&format!("{from}{to}"), &format!("path = [\"{from}\", \"{to}\"]"), more)
    };
    let mesh = mesh(&(points.to_owned() + &one("C", "B") + &one("E", "D") + &one("C", "D") + &one("A", "B")));
    check_sound(&mesh);
    assert_eq!(mesh.nodes.len(), 25);
    let band =
        mesh.elements.iter().map(|e| e.nodes.iter().max().unwrap() - e.nodes.iter().min().unwrap()).max();
    assert_eq!(band, Some(2));
}

#[test]
fn lumped_mass_has_the_kinetic_energy_of_its_body() {
    let points =
        "[points]\nA = [1, 0, 0]\nB = [0, 2, 0]\nL = { linked_to = \"B\", offset = [0.1, -0.2, 0.3] }\n";
    let masses = "[[masses]]\npoint = \"L\"\nmass = 3\noffset = [0.4, 0.5, -0.6]\n\
                  inertia = [[2, 0.1, 0.2], [0.1, 2.5, -0.3], [0.2, -0.3, 1.5]]\n\
                  [[masses]]\npoint = \"B\"\nmass = 7\n";
    let mesh = mesh(
        &(points.to_owned()
            + &member("m", "path = [\"A\", \"B\"]", "elements = 2\nlocal_y = [0, 0, 1]")
            + masses),
    );
    let j = Matrix3::new(2.0, 0.1, 0.2, 0.1, 2.5, -0.3, 0.2, -0.3, 1.5);
    let r = Vector3::new(0.5, 0.3, -0.3);
    assert_eq!(mesh.points[2].offset, Vector3::new(0.1, -0.2, 0.3));
    assert_eq!(Some(mesh.lumped[0].node), mesh.points[1].node());
    assert_eq!(mesh.lumped[1].mass.fixed_view::<3, 3>(3, 3).amax(), 0.0);
    for seed in 0..6 {
        let nu = Vector6::from_fn(|i, _| ((seed * 7 + i as i32 * 3) as f64).sin());
        let (v, w) = (nu.fixed_rows::<3>(0).into_owned(), nu.fixed_rows::<3>(3).into_owned());
        let twice = 3.0 * (v + w.cross(&r)).norm_squared() + (j * w).dot(&w);
        assert_relative_eq!((mesh.lumped[0].mass * nu).dot(&nu), twice, max_relative = 1e-14);
    }
    assert!((mesh.lumped[0].mass - mesh.lumped[0].mass.transpose()).amax() < 1e-15);
}

#[test]
fn points_on_members_and_on_nodes() {
    let points = "[points]\nA = [1, 1, 1]\nB = [4, 1, 1]\nthird = [\"1 + 3/3\", 1, 1]\nhalf = { member = \"m\", fraction = 0.5 }\n\
                  end = { member = \"m\", fraction = 1 }\n";
    let mesh = mesh(
        &(points.to_owned() + &member("m", "path = [\"A\", \"B\"]", "elements = 6\nlocal_y = [0, 0, 1]")),
    );
    let nodes: Vec<usize> = mesh.points.iter().filter_map(|p| p.node()).collect();
    assert_eq!(nodes, [0, 6, 2, 3, 6]);
    assert!(mesh.points.iter().all(|p| p.sections.len() == 1 && p.offset == Vector3::zeros()));
}

#[test]
fn shapes_give_the_classical_constants() {
    let with = |shape: &str| {
        let text = structure("[points]\nA = [0, 0, 0]\nB = [1, 0, 0]\n").replace(
            "shape = \"constants\"\nEA = 1\nGAy = 1\nGAz = 1\nGJ = 1\nEIy = 1\nEIz = 1\nrhoA = 1\nrhoJ = [2, 1, 1]",
            &format!("material = \"steel\"\n{shape}\n[materials.steel]\nE = 2.08e11\nnu = 0.3\nrho = 8000"),
        ) + &member("m", "path = [\"A\", \"B\"]", "elements = 1\nlocal_y = [0, 1, 0]");
        let mesh = Structure::from_toml_str(&text, "test.toml", &[]).unwrap_or_else(|e| panic!("{e}")).mesh();
        (mesh.sections[0].stiffness.diagonal(), mesh.sections[0].mass.diagonal())
    };
    let (e, g, rho) = (2.08e11, 8e10, 8000.0);
    // Cowper's factors: 0.886 for the full circle at nu = 0.3, 2 (1 + nu)/(4 + 3 nu) for the thin tube.
    let (area, i) = (PI / 4.0 * 0.01, PI / 64.0 * 1e-4);
    let (s, m) = with("shape = \"circle\"\ndiameter = 0.1");
    let k = 6.0 * 1.3 / 8.8;
    let expected = Vector6::new(e * area, k * g * area, k * g * area, 2.0 * g * i, e * i, e * i);
    assert_relative_eq!(s, expected, max_relative = 1e-14);
    let line = rho * area;
    assert_relative_eq!(
        m,
        Vector6::new(line, line, line, 2.0 * rho * i, rho * i, rho * i),
        max_relative = 1e-14
    );

    let (s, m) = with("shape = \"tube\"\nouter_diameter = 1\nwall_thickness = 1e-6");
    let area = PI * 1e-6;
    assert_relative_eq!(s[0], e * area, max_relative = 2e-6);
    assert_relative_eq!(s[1], 2.0 * 1.3 / 4.9 * g * area, max_relative = 1e-5);
    assert_relative_eq!(s[3], g * area / 4.0, max_relative = 1e-5);
    assert_relative_eq!(s[4], e * area / 8.0, max_relative = 1e-5);
    assert_relative_eq!(m[3], rho * area / 4.0, max_relative = 1e-5);

    let (s, m) = with("shape = \"rectangle\"\nwidth_y = 0.1\nwidth_z = 0.2");
    assert_relative_eq!(s[1], 5.0 / 6.0 * g * 0.02, max_relative = 1e-14);
    // Bending about y works against the width along z.
    assert_relative_eq!(s[4], e * 0.1 * 0.2f64.powi(3) / 12.0, max_relative = 1e-14);
    assert_relative_eq!(s[5], e * 0.2 * 0.1f64.powi(3) / 12.0, max_relative = 1e-14);
    assert_relative_eq!(s[3], 0.228_682 * g * 0.2 * 0.1f64.powi(3), max_relative = 1e-5);
    assert_relative_eq!(m[3], rho * 0.02 * (0.01 + 0.04) / 12.0, max_relative = 1e-14);
}

#[test]
fn matrices_are_taken_as_they_are() {
    let text = structure("[points]\nA = [0, 0, 0]\nB = [1, 0, 0]\n").replace(
        "shape = \"constants\"\nEA = 1\nGAy = 1\nGAz = 1\nGJ = 1\nEIy = 1\nEIz = 1\nrhoA = 1\nrhoJ = [2, 1, 1]",
        "shape = \"matrix\"\n\
         stiffness = [[9,1,0,0,0,0],[1,8,0,0,0,0],[0,0,7,0,0,2],[0,0,0,6,0,0],[0,0,0,0,5,0],[0,0,2,0,0,4]]\n\
         mass = [[2,0,0,0,0.2,-0.4],[0,2,0,-0.2,0,0],[0,0,2,0.4,0,0],[0,-0.2,0.4,3,0,0],[0.2,0,0,0,1,0.1],[-0.4,0,0,0,0.1,2]]",
    ) + &member("m", "path = [\"A\", \"B\"]", "elements = 1\nlocal_y = [0, 1, 0]");
    let mesh = Structure::from_toml_str(&text, "test.toml", &[]).unwrap_or_else(|e| panic!("{e}")).mesh();
    let section = &mesh.sections[0];
    assert_eq!(
        (section.stiffness[(2, 5)], section.stiffness[(5, 2)], section.stiffness[(0, 1)]),
        (2.0, 2.0, 1.0)
    );
    let m: Matrix6<f64> = section.mass;
    assert_eq!((m[(0, 4)], m[(4, 0)], m[(0, 5)], m[(2, 3)], m[(4, 5)]), (0.2, 0.2, -0.4, 0.4, 0.1));
}

#[test]
fn a_million_elements_are_checked_and_meshed() {
    let points = "[points]\nA = [0, 0, 0]\nB = [100, 0, 0]\nmiddle = [50, 0, 0]\n";
    let mesh = mesh(
        &(points.to_owned() + &member("m", "path = [\"A\", \"B\"]", "elements = 1e6\nlocal_y = [0, 0, 1]")),
    );
    assert_eq!((mesh.nodes.len(), mesh.points[2].node()), (1_000_001, Some(500_000)));
}
