//! Princeton beam (E. H. Dowell and J. J. Traybar, AMS reports 1194 and 1257, Princeton University, 1975): a slender aluminium
//! cantilever of rectangular section under a dead tip force at an angle beta to its stiff direction, so that flatwise and
//! chordwise bending and torsion couple.
//!
//! Numbers: data and tip displacements of L. Obrezkov, P. Eliasson, A. B. Harish and M. K. Matikainen, "Performance review of locking
//! alleviation methods for continuum ANCF beam elements", Nonlinear Dynamics 109 (2022), by ANSYS beam elements, and of the shear
//! deformable ANCF beam of Exudyn with 16 elements and the section constants below (its example `ANCFBeamTest`). The two codes differ by
//! up to 0.36 mm (their torsion and shear constants are not the same, nor are their meshes converged alike).
//! Ours, converged, is within 0.5 mm of both, a quarter of a percent of the largest displacement.

use super::{Cantilever, assert_near, displacement, equilibrium};

const WIDTH: f64 = 3.2024e-3;
const HEIGHT: f64 = 12.3777e-3;

/// Tip displacement (stiff direction, soft direction), m.
fn tip(force: f64, beta_degrees: f64) -> [f64; 3] {
    let (e, nu) = (71.7e9, 0.31);
    let g = e / (2.0 * (1.0 + nu));
    let area = WIDTH * HEIGHT;
    let (soft, stiff) = (HEIGHT * WIDTH.powi(3) / 12.0, WIDTH * HEIGHT.powi(3) / 12.0);
    // Chord along y: bending about z is stiff.
    let section = format!(
        "EA = {}\nGAy = {}\nGAz = {}\nGJ = {}\nEIy = {}\nEIz = {}\nrhoA = 1\nrhoJ = [2, 1, 1]",
        e * area,
        g * area,
        g * area,
        0.198 * g * (soft + stiff),
        e * soft,
        e * stiff
    );
    let (sin, cos) = beta_degrees.to_radians().sin_cos();
    let load = format!(r#"frame = "dead", force = [0, {}, {}]"#, -force * cos, force * sin);
    let cantilever =
        Cantilever { length: 0.508, section: &section, elements: 24, element_nodes: 3, load: &load };
    let mesh = cantilever.mesh();
    displacement(&mesh, &equilibrium(&mesh), "tip").into()
}

struct Published {
    force: f64,
    /// (beta in degrees, ANSYS: stiff and soft displacement, Exudyn: x, y, z).
    rows: [(f64, [f64; 2], [f64; 3]); 7],
}

const PUBLISHED: [Published; 2] = [
    Published {
        force: 8.896,
        rows: [
            (0.0, [1.071417630e-2, 0.0], [-0.0001352, -0.0107023, 0.0]),
            (15.0, [1.061328706e-2, 4.208232124e-2], [-0.0022414, -0.0106295, 0.0421374]),
            (30.0, [1.011169630e-2, 7.939482948e-2], [-0.0076567, -0.0101861, 0.0794434]),
            (45.0, [8.837226265e-3, 0.108987937], [-0.0143664, -0.0089529, 0.1089703]),
            (60.0, [6.604665004e-3, 0.129887616], [-0.0204225, -0.0067182, 0.1297877]),
            (75.0, [3.538889001e-3, 0.142194370], [-0.0245093, -0.0036079, 0.1420319]),
            (90.0, [0.0, 0.146245978], [-0.0259403, 0.0, 0.1460608]),
        ],
    },
    Published {
        force: 13.345,
        rows: [
            (0.0, [1.606423724e-2, 0.0], [-0.0003039, -0.0160454, 0.0]),
            (15.0, [1.645825752e-2, 6.435812858e-2], [-0.005319, -0.0165469, 0.064622]),
            (30.0, [1.665873206e-2, 0.117735994], [-0.0171901, -0.0169316, 0.1179818]),
            (45.0, [1.518618440e-2, 0.156467239], [-0.0303357, -0.0155488, 0.1565214]),
            (60.0, [1.157837500e-2, 0.181861627], [-0.0411035, -0.0118996, 0.1817173]),
            (75.0, [6.248967384e-3, 0.196097131], [-0.0479101, -0.0064334, 0.1958343]),
            (90.0, [0.0, 0.200677707], [-0.0502184, 0.0, 0.2003738]),
        ],
    },
];

#[test]
fn tip_displacements_at_all_angles() {
    let (mut ansys_worst, mut exudyn_worst): (f64, f64) = (0.0, 0.0);
    for published in PUBLISHED {
        for (beta, ansys, exudyn) in published.rows {
            let u = tip(published.force, beta);
            let what = format!("{} N at {beta} degrees: {u:?}", published.force);
            ansys_worst = ansys_worst.max((-u[1] - ansys[0]).abs()).max((u[2] - ansys[1]).abs());
            assert_near(-u[1], ansys[0], 5e-4, &what);
            assert_near(u[2], ansys[1], 5e-4, &what);
            for k in 0..3 {
                exudyn_worst = exudyn_worst.max((u[k] - exudyn[k]).abs());
                assert_near(u[k], exudyn[k], 4e-4, &what);
            }
        }
    }
    println!("largest difference: ANSYS {ansys_worst:.2e} m, Exudyn {exudyn_worst:.2e} m");
}
