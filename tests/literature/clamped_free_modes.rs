//! Frequencies of a clamped-free Euler beam: `omega = (b L)^2 sqrt(EI/(rho A L^4))` with `cos x cosh x = -1` (any textbook; S. S. Rao,
//! *Mechanical Vibrations*). The slenderness makes shear and rotary inertia change them by less than 1e-5.

use super::{Cantilever, assert_near};
use nalgebra::DMatrix;
use rom_generator::assembly::{Assembly, BlockMatrix};
use rom_generator::configuration::Configuration;
use rom_generator::solve::dense::generalised_eigen;

/// A sparse block matrix written out.
pub(crate) fn dense(a: &BlockMatrix) -> DMatrix<f64> {
    let n = a.pattern.n();
    let mut out = DMatrix::zeros(6 * n, 6 * n);
    for i in 0..n {
        for (j, slot) in a.pattern.row(i) {
            out.view_mut((6 * i, 6 * j), (6, 6)).copy_from(&a.values[slot]);
        }
    }
    out
}

#[test]
fn bending_torsion_and_stretch() {
    // Radius of gyration 1e-4 L in both planes; GJ chosen so that torsion lies among the first modes.
    let mesh = Cantilever {
        length: 1.0,
        section: "EA = 1e8\nGAy = 1e8\nGAz = 1e8\nGJ = 1e-5\nEIy = 1\nEIz = 4\nrhoA = 1\nrhoJ = [1e-8, 1e-9, 1e-9]",
        elements: 30,
        element_nodes: 3,
        load: r#"frame = "dead", force = [0, 0, 1]"#,
    }
    .mesh();
    let (assembly, at) = (Assembly::new(&mesh), Configuration::drawing(&mesh));
    let (k, m) = (dense(&assembly.stiffness(&at)), dense(&assembly.mass(&at).ss));
    // M x = omega^-2 K x: the largest values, which come without loss of digits, are the lowest modes.
    let (inverse, _) = generalised_eigen(&m, &k).unwrap();
    let found: Vec<f64> = inverse.iter().rev().map(|x| 1.0 / x.sqrt()).collect();
    let b = [1.875_104_068_711_961, 4.694_091_132_974_175, 7.854_757_438_237_613];
    let half = std::f64::consts::FRAC_PI_2;
    let mut expected: Vec<f64> = b.iter().flat_map(|x| [x * x, 2.0 * x * x]).collect();
    // Torsion: (2 i - 1) pi/2 sqrt(GJ/(rho J L^2)), here sqrt(1e3).
    expected.extend([1.0, 3.0].map(|i| i * half * 1e3f64.sqrt()));
    expected.sort_by(f64::total_cmp);
    for (k, expected) in expected.into_iter().enumerate().take(6) {
        // Fourth order in the wave number: (b h)^4/1000 is 5e-6 for the third bending mode.
        assert_near(found[k], expected, 3e-5 * expected, &format!("frequency {}", k + 1));
    }
}
