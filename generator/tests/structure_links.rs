//! Rigid links: what the mesh makes of them, and that they are exact.

use nalgebra::{Matrix6, Vector3};
use rom_generator::build::{BuildOptions, ModeSelection, build};
use rom_generator::input::Structure;

fn read(text: &str) -> Structure {
    Structure::from_toml_str(text, "links.toml", &[]).unwrap_or_else(|e| panic!("{e}"))
}

const SECTION: &str = "[sections.s]\nshape = \"matrix\"\n\
    stiffness = [[1e6, 0, 0, 0, 0, 1e3], [0, 3e5, 0, 0, 0, 0], [0, 0, 3e5, 0, 0, 0],\n\
                 [0, 0, 0, 2e3, 500, 0], [0, 0, 0, 500, 4e3, 0], [1e3, 0, 0, 0, 0, 5e3]]\n\
    mass = [[2, 0, 0, 0, 0, 0.1], [0, 2, 0, 0, 0, 0], [0, 0, 2, -0.1, 0, 0],\n\
            [0, 0, -0.1, 0.05, 0, 0], [0, 0, 0, 0, 0.02, 0], [0.1, 0, 0, 0, 0, 0.03]]\n";

/// A boom with a tailplane above its end and a tank below its middle; `joints` says what joins them.
fn tail(reference: &str, joints: &str) -> String {
    format!(
        "[structure]\nname = \"tail\"\nreference = \"{reference}\"\n{SECTION}\
         [points]\nnose = [-3, 0, 0]\nmiddle = [0, 0, 0]\nend = [3, 0, 0]\nleft = [3.2, -1, 0.5]\ncentre = [3.2, 0, 0.5]\n\
         right = [3.2, 1, 0.5]\nfront = [-0.5, 0, -0.7]\nback = [0.5, 0, -0.7]\nlight = {{ linked_to = \"centre\", offset = [0, 0, 0.1] }}\n\
         [[members]]\nname = \"boom\"\npath = [\"nose\", \"middle\", \"end\"]\nsection = \"s\"\nelements = 8\nlocal_y = [0, 1, 0]\n\
         [[members]]\nname = \"tailplane\"\npath = [\"left\", \"centre\", \"right\"]\nsection = \"s\"\nelements = 4\nlocal_y = [-1, 0, 0]\n\
         [[members]]\nname = \"tank\"\npath = [\"front\", \"back\"]\nsection = \"s\"\nelements = 2\nlocal_y = [0, 1, 0]\n\
         [[masses]]\npoint = \"centre\"\nmass = 1.5\noffset = [0, 0, 0.2]\ninertia = [0.1, 0.1, 0.1]\n{joints}"
    )
}

const LINKS: &str = "[[links]]\nname = \"fin\"\npoints = [\"end\", \"centre\"]\n[[links]]\npoints = [\"front\", \"middle\"]\n";

fn frequencies(text: &str) -> Vec<f64> {
    let options = BuildOptions { modes: ModeSelection::Count(8), ..BuildOptions::default() };
    build(&read(text), &options, &mut |_| {}).unwrap_or_else(|e| panic!("{e}")).modes.omega
}

#[test]
fn linked_ends_share_a_node() {
    let mesh = read(&tail("centre", LINKS)).mesh();
    // Three members of 9, 5 and 3 nodes, two of which are joined twice.
    assert_eq!((mesh.nodes.len(), mesh.elements.len()), (9 + 5 + 3 - 2, 14));
    let centre = Vector3::new(3.2, 0.0, 0.5);
    assert_eq!(mesh.reference_position, centre);
    let mut levers = 0;
    for member in &mesh.members {
        let mut end: Option<Vector3<f64>> = None;
        for element in &mesh.elements[member.elements.clone()] {
            let place = |a: usize| mesh.nodes[element.nodes[a]] + element.levers[a] + mesh.reference_position;
            assert!(((place(1) - place(0)).norm() - element.length).abs() < 1e-14);
            if let Some(end) = end {
                assert!((place(0) - end).norm() < 1e-15, "the member is in one piece");
            }
            end = Some(place(1));
            levers += element.levers[..2].iter().filter(|r| r.norm() > 0.0).count();
        }
    }
    // The reference carries the end of the boom; `middle` comes before `front` and carries it.
    assert_eq!(levers, 2);
    for point in &mesh.points {
        let drawn = match point.name.as_str() {
            "end" => Vector3::new(3.0, 0.0, 0.0),
            "front" => Vector3::new(-0.5, 0.0, -0.7),
            "light" => centre + Vector3::new(0.0, 0.0, 0.1),
            _ => continue,
        };
        let place = mesh.nodes[point.node().unwrap()] + point.offset + mesh.reference_position;
        assert!((place - drawn).norm() < 1e-15, "{}", point.name);
    }
    // The boom's end node carries the tailplane where the reference is elsewhere, and with it the mass.
    let mesh = read(&tail("nose", LINKS)).mesh();
    let arm = Vector3::new(0.2, 0.0, 0.7);
    let mut expected = Matrix6::identity() * 1.5;
    expected.fixed_view_mut::<3, 3>(0, 3).copy_from(&(arm.cross_matrix() * -1.5));
    expected.fixed_view_mut::<3, 3>(3, 0).copy_from(&(arm.cross_matrix() * 1.5));
    let inertia = nalgebra::Matrix3::identity() * 0.1 - arm.cross_matrix() * arm.cross_matrix() * 1.5;
    expected.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
    assert!((mesh.lumped[0].mass - expected).amax() < 1e-14);
}

/// Neither the node that carries a link nor the order of anything changes the structure: frequencies to the accuracy of the
/// eigenvalue solver.
#[test]
fn the_carrying_node_is_a_matter_of_numbering() {
    let one = frequencies(&tail("nose", LINKS));
    let turned = "[[links]]\npoints = [\"middle\", \"front\"]\n[[links]]\npoints = [\"centre\", \"end\"]\n";
    for other in [tail("nose", turned), tail("centre", LINKS), tail("front", LINKS), tail("end", turned)] {
        for (a, b) in one.iter().zip(frequencies(&other)) {
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }
}

/// The limit of stiff, light members in place of the links. One million times stiffer and lighter: what the elastic link adds is
/// of the order of 1e-6 of the compliance.
#[test]
fn a_link_is_the_limit_of_a_stiff_member() {
    let stiff = "[sections.stiff]\nshape = \"constants\"\nEA = 1e12\nGAy = 1e12\nGAz = 1e12\nGJ = 1e10\nEIy = 1e10\nEIz = 1e10\n\
        rhoA = 1e-6\nrhoJ = [1e-8, 1e-8, 1e-8]\n\
        [[members]]\nname = \"fin\"\npath = [\"end\", \"centre\"]\nsection = \"stiff\"\nelements = 1\nlocal_y = [0, 1, 0]\n\
        [[members]]\nname = \"strut\"\npath = [\"front\", \"middle\"]\nsection = \"stiff\"\nelements = 1\nlocal_y = [0, 1, 0]\n";
    let (linked, stiff) = (frequencies(&tail("nose", LINKS)), frequencies(&tail("nose", stiff)));
    for (a, b) in linked.iter().zip(&stiff) {
        assert!((a / b - 1.0).abs() < 1e-5, "{linked:?} {stiff:?}");
    }
}
