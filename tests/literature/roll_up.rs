//! Cantilever rolled up by an end moment: exact at M = 2 pi n EI/L, an n-fold circle (J. C. Simo and L. Vu-Quoc, "A three-dimensional
//! finite-strain rod model. Part II", Comput. Methods Appl. Mech. Engrg. 58 (1986), section 4.1).
//!
//! The curvature is constant, so that rotations are exact on any mesh; nodes lie on a polygon whose sides have the length of the
//! elements (linear) or differ from the arc by O(h^4) (quadratic), and a polygon of equal sides and angles closes too.

use super::{Cantilever, assert_near, equilibrium, node};
use std::f64::consts::PI;

#[test]
fn closes_to_a_circle_and_to_two() {
    for (elements, element_nodes) in [(8, 2), (40, 2), (6, 3), (20, 3)] {
        for turns in [0.5, 1.0, 2.0] {
            let moment = 2.0 * PI * turns * 2.0 / 10.0;
            let load = format!(r#"frame = "follower", moment = [0, 0, {moment:.17}]"#);
            let mesh = Cantilever {
                length: 10.0,
                section: "EA = 1e4\nGAy = 1e4\nGAz = 1e4\nGJ = 2\nEIy = 2\nEIz = 2\nrhoA = 1\nrhoJ = [2, 1, 1]",
                elements,
                element_nodes,
                load: &load,
            }
            .mesh();
            let state = equilibrium(&mesh);
            let what = format!("{turns} turns, {elements} elements of {element_nodes} nodes");
            let tip = node(&mesh, "tip");
            if turns >= 1.0 {
                assert!(state.configuration.positions[tip].norm() < 1e-9, "{what}");
                assert!(state.configuration.rotations[tip].angle() < 1e-9, "{what}");
            }
            // Energy of a constant curvature: M^2 L/(2 EI). The turns are all there.
            assert_near(state.energy, moment * moment * 10.0 / 4.0, 1e-9 * state.energy, &what);
            // The moment is the same everywhere.
            assert_near(state.reaction_moment.z, -moment, 1e-9, &what);
            assert!(state.reaction_force.norm() < 1e-9);
        }
    }
}

#[test]
fn half_a_turn_lands_on_the_diameter() {
    // Tip of a half circle of length L: (0, 2 L/pi). Order of the error: 2 with linear, 4 with quadratic elements.
    for (element_nodes, order) in [(2, 2.0), (3, 4.0)] {
        let error = |elements| {
            let load = format!(r#"frame = "follower", moment = [0, 0, {:.17}]"#, PI * 2.0 / 10.0);
            let mesh = Cantilever {
                length: 10.0,
                section: "EA = 1e4\nGAy = 1e4\nGAz = 1e4\nGJ = 2\nEIy = 2\nEIz = 2\nrhoA = 1\nrhoJ = [2, 1, 1]",
                elements,
                element_nodes,
                load: &load,
            }
            .mesh();
            let at = equilibrium(&mesh).configuration.positions[node(&mesh, "tip")];
            (at - nalgebra::Vector3::new(0.0, 20.0 / PI, 0.0)).norm()
        };
        let slope = (error(8) / error(16)).log2();
        assert_near(slope, order, 0.1, "order of convergence");
    }
}
