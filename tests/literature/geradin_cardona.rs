//! Cantilever under a dead tip force: M. Geradin and A. Cardona, *Flexible Multibody Dynamics: A Finite Element Approach*, Wiley, 2001,
//! used since as the first static check of aeroelastic codes. L = 5 m, EA = 4.8e8 N, GA = 3.231e8 N, GJ = 1e6 N m^2, EI = 9.346e6 N m^2,
//! tip force 600 kN: 2.159 m down, 0.596 m shorter, turned by 0.672 rad. Ours, converged: 2.1597, 0.5965, 0.6720; so the book's third
//! digit is cut, not rounded, and one unit of it is allowed.

use super::{Cantilever, assert_near, displacement, equilibrium, node};

#[test]
fn tip_deflection() {
    for (elements, element_nodes) in [(60, 2), (10, 3)] {
        let mesh = Cantilever {
            length: 5.0,
            section: "EA = 4.8e8\nGAy = 3.231e8\nGAz = 3.231e8\nGJ = 1e6\nEIy = 9.346e6\nEIz = 9.346e6\nrhoA = 1\nrhoJ = [2, 1, 1]",
            elements,
            element_nodes,
            load: r#"frame = "dead", force = [0, 0, -600e3]"#,
        }
        .mesh();
        let state = equilibrium(&mesh);
        let u = displacement(&mesh, &state, "tip");
        let turn = state.configuration.rotations[node(&mesh, "tip")].scaled_axis();
        assert_near(u.z, -2.159, 1e-3, "tip deflection");
        assert_near(-u.x, 0.596, 1e-3, "shortening");
        assert_near(turn.y, 0.672, 1e-3, "tip rotation");
        assert!(u.y.abs() < 1e-12 && turn.x.abs() < 1e-12 && turn.z.abs() < 1e-12);
        // Statics: the clamp carries the force and its moment about the root.
        assert_near(state.reaction_force.z, 600e3, 1e-4, "reaction");
        assert_near(state.reaction_moment.y, -600e3 * (5.0 + u.x), 1e-3, "root moment");
    }
}
