//! Closed loops with answers in closed form: a free ring (A. E. H. Love, *A Treatise on the Mathematical Theory of Elasticity*, art. 293)
//! and a portal frame clamped at both feet (any textbook of structural analysis, by the slope-deflection method).

use super::{assert_near, displacement, equilibrium, mesh, node};
use rom_generator::assembly::Assembly;
use rom_generator::configuration::Configuration;
use rom_generator::reduce::modes::elastic_modes;

/// A ring of thin wire, radius 1 m, EI = 1 and 3 N m^2 in and across its plane, GJ = 2 N m^2, 1 kg/m.
#[test]
fn free_ring() {
    let mesh = mesh(
        r#"
        [structure]
        name = "ring"
        reference = "east"
        element_nodes = 3
        [sections.wire]
        shape = "constants"
        EA = 1e7
        GAy = 1e7
        GAz = 1e7
        GJ = 2
        EIy = 3
        EIz = 1
        rhoA = 1
        rhoJ = [2e-7, 1e-7, 1e-7]
        [points]
        east = [1, 0, 0]
        west = [-1, 0, 0]
        [[members]]
        name = "north"
        arc = { from = "east", to = "west", through = [0, 1, 0] }
        section = "wire"
        elements = 30
        local_y = [0, 0, 1]
        twist = "90*deg"
        [[members]]
        name = "south"
        arc = { from = "west", to = "east", through = [0, -1, 0] }
        section = "wire"
        elements = 30
        local_y = [0, 0, 1]
        twist = "90*deg"
        [load_cases.none]
        t_end = 1
        dt = 1
        loads = [{ point = "east", frame = "dead", force = [0, 0, 1] }]
        "#,
    );
    let (assembly, at) = (Assembly::new(&mesh), Configuration::drawing(&mesh));
    let modes = elastic_modes(&assembly, &at, &assembly.mass(&at), &assembly.stiffness(&at), 12).unwrap();
    // Each wave number twice: its two modes differ by a turn of the ring.
    let (in_plane, across, torsion) = (1.0, 3.0, 2.0);
    let mut expected = Vec::new();
    for n in [2.0, 3.0, 4.0] {
        let square: f64 = n * n * (n * n - 1.0) * (n * n - 1.0);
        expected.extend([(in_plane * square / (n * n + 1.0)).sqrt(); 2]);
        expected.extend([(across * square / (n * n + across / torsion)).sqrt(); 2]);
    }
    expected.sort_by(f64::total_cmp);
    for (k, expected) in expected.into_iter().enumerate().take(10) {
        // Stretch, shear and rotary inertia change the frequencies by some 1e-6, the elements by (n h)^4/1000 < 1e-4.
        assert_near(modes.omega[k], expected, 1e-4 * expected, &format!("mode {}", k + 1));
    }
}

/// Columns of height h, beam of span L and another stiffness, k = (I_beam/I_column) h/L; a force H at the level of the beam sways
/// it by H h^3 (3 k + 2)/(12 E I (6 k + 1)), half at each corner; the corners turn by H h^2/(4 E I (6 k + 1)).
#[test]
fn portal_frame() {
    let (h, span, ratio) = (3.0, 4.0, 2.0);
    let mesh = mesh(&format!(
        r#"
        [structure]
        name = "portal"
        reference = "left foot"
        element_nodes = 3
        [sections.column]
        shape = "constants"
        EA = 1e12
        GAy = 1e12
        GAz = 1e12
        GJ = 1e3
        EIy = 1e3
        EIz = 1e3
        rhoA = 1
        rhoJ = [2e-4, 1e-4, 1e-4]
        [sections.beam]
        shape = "constants"
        EA = 1e12
        GAy = 1e12
        GAz = 1e12
        GJ = 1e3
        EIy = "{ratio} * 1e3"
        EIz = "{ratio} * 1e3"
        rhoA = 1
        rhoJ = [2e-4, 1e-4, 1e-4]
        [points]
        "left foot" = [0, 0, 0]
        "left corner" = [0, 0, {h}]
        "right corner" = [{span}, 0, {h}]
        "right foot" = [{span}, 0, 0]
        [[links]]
        name = "ground"
        points = ["left foot", "right foot"]
        [[members]]
        name = "left column"
        path = ["left foot", "left corner"]
        section = "column"
        elements = 8
        local_y = [0, 1, 0]
        [[members]]
        name = "beam"
        path = ["left corner", "right corner"]
        section = "beam"
        elements = 8
        local_y = [0, 1, 0]
        [[members]]
        name = "right column"
        path = ["right corner", "right foot"]
        section = "column"
        elements = 8
        local_y = [0, 1, 0]
        [load_cases.push]
        t_end = 1
        dt = 1
        loads = [
          {{ point = "left corner", frame = "dead", force = [0.5e-3, 0, 0] }},
          {{ point = "right corner", frame = "dead", force = [0.5e-3, 0, 0] }},
        ]
        "#
    ));
    let state = equilibrium(&mesh);
    let k = ratio * h / span;
    let sway = 1e-3 * h * h * h * (3.0 * k + 2.0) / (12.0 * 1e3 * (6.0 * k + 1.0));
    let turn = 1e-3 * h * h / (4.0 * 1e3 * (6.0 * k + 1.0));
    for corner in ["left corner", "right corner"] {
        // Loads small enough for linear answers. Eight quadratic elements a member, sampled at two points, are stiffer by some 1/8^4/10.
        assert_near(displacement(&mesh, &state, corner).x, sway, 1e-4 * sway, corner);
        let found = state.configuration.rotations[node(&mesh, corner)].scaled_axis().y;
        assert_near(found, turn, 1e-4 * turn, corner);
    }
}

/// A light rod with two masses at each end, beside its axis: the torsion of two flywheels, `J = 2 m e^2` each, and the stretch of
/// two heavy ends. Masses on rigid offsets, several at a place.
#[test]
fn dumbbell_of_offset_masses() {
    let mesh = mesh(
        r#"
        [structure]
        name = "dumbbell"
        reference = "left"
        element_nodes = 3
        [sections.rod]
        shape = "constants"
        EA = 800
        GAy = 1e9
        GAz = 1e9
        GJ = 50
        EIy = 1e7
        EIz = 1e7
        rhoA = 1e-7
        rhoJ = [2e-9, 1e-9, 1e-9]
        [points]
        left = [0, 0, 0]
        right = [2, 0, 0]
        over = { linked_to = "right", offset = [0, 0, 0.5] }
        under = { linked_to = "right", offset = [0, 0, -0.5] }
        [[members]]
        name = "rod"
        path = ["left", "right"]
        section = "rod"
        elements = 2
        local_y = [0, 1, 0]
        [[masses]]
        point = "over"
        mass = 4
        [[masses]]
        point = "under"
        mass = 4
        [[masses]]
        point = "left"
        mass = 4
        offset = [0, 0.5, 0]
        [[masses]]
        point = "left"
        mass = 4
        offset = [0, -0.5, 0]
        "#,
    );
    let (assembly, at) = (Assembly::new(&mesh), Configuration::drawing(&mesh));
    let mass = assembly.mass(&at);
    let (total, centre) = Assembly::centre_of_mass(&mass.rr);
    assert_near(total, 16.0 + 2e-7, 1e-12, "mass");
    assert_near((centre - nalgebra::Vector3::new(1.0, 0.0, 0.0)).norm(), 0.0, 1e-12, "centre of mass");
    let modes = elastic_modes(&assembly, &at, &mass, &assembly.stiffness(&at), 2).unwrap();
    // sqrt(GJ/L (1/J + 1/J)) with J = 2 kg m^2, sqrt(EA/L (1/m + 1/m)) with m = 8 kg.
    assert_near(modes.omega[0], 5.0, 1e-6, "torsion");
    assert_near(modes.omega[1], 10.0, 1e-6, "stretch");
}
