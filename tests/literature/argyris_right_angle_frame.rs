//! Lateral buckling of a right-angle frame under a dead force in its plane: J. H. Argyris et al., "Finite element method - the natural
//! approach", Comput. Methods Appl. Mech. Engrg. 17/18 (1979), and J. C. Simo and L. Vu-Quoc, Part II (1986). Arms of 240 mm, section
//! 30 mm x 0.6 mm, E = 71240 N/mm^2, nu = 0.31; clamped at one end, pulled along the first arm at the free end of the second.
//! Critical load 1.088 N (quoted with a thin section's torsion, GJ = G h t^3/3, and no shear correction, by Nachbagauer and Gerstmayr,
//! J. Comput. Nonlinear Dynam. 9 (2014)); Argyris: 1.088 to 1.090.

use super::{assert_near, mesh, try_equilibrium};
use rom_generator::equilibrium::EquilibriumError;

fn critical_load(elements: usize, element_nodes: usize) -> f64 {
    let mesh = mesh(&format!(
        r#"
        [structure]
        name = "frame"
        reference = "clamp"
        element_nodes = {element_nodes}
        [parameters]
        E = 71240e6
        G = "E / 2.62"
        h = 0.03
        thickness = 0.0006
        [sections.strip]
        shape = "constants"
        EA = "E * h * thickness"
        GAy = "G * h * thickness"
        GAz = "G * h * thickness"
        GJ = "G * h * thickness^3 / 3"
        EIy = "E * h * thickness^3 / 12"
        EIz = "E * thickness * h^3 / 12"
        rhoA = 1
        rhoJ = [2, 1, 1]
        [points]
        clamp = [0, 0, 0]
        corner = [0.24, 0, 0]
        tip = [0.24, -0.24, 0]
        [[members]]
        name = "first arm"
        path = ["clamp", "corner"]
        section = "strip"
        elements = {elements}
        local_y = [0, 1, 0]
        [[members]]
        name = "second arm"
        path = ["corner", "tip"]
        section = "strip"
        elements = {elements}
        local_y = [1, 0, 0]
        [load_cases.pull]
        t_end = 1
        dt = 1
        loads = [{{ point = "tip", frame = "dead", force = [2, 0, 0] }}]
        "#
    ));
    match try_equilibrium(&mesh).map(|e| e.stability) {
        Err(EquilibriumError::Buckling { load_factor, negative_eigenvalues: 1, .. }) => 2.0 * load_factor,
        other => panic!("expected to buckle into one mode: {other:?}"),
    }
}

#[test]
fn buckles_out_of_its_plane() {
    let (linear, quadratic) = (critical_load(40, 2), critical_load(16, 3));
    println!("critical load {linear} N (linear), {quadratic} N (quadratic)");
    // The loss of stability is enclosed to 1e-4 and the printed value is rounded to 5e-4; the linear elements' own error is
    // some (pi h/(2 l))^2/6 = 3e-4.
    assert_near(linear, 1.088, 1.5e-3, "40 linear elements an arm");
    assert_near(quadratic, 1.088, 1e-3, "16 quadratic elements an arm");
}
