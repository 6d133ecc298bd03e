//! Symmetry, effective masses, frequencies under load and on a turning hub.

use nalgebra::Vector3;

use super::{Parity, Spectrum, Support, analyse, spinning, track};
use crate::configuration::Configuration;
use crate::input::Structure;
use crate::mesh::Mesh;
use crate::test_structures::fmb;

/// A straight beam along x of 1 m, EI = 1 (flap, about y) and 4 (lag) N m^2, 1 kg/m, its reference node at x = 0.
fn beam(extra: &str) -> Mesh {
    let text = format!(
        r#"
        [structure]
        name = "beam"
        reference = "root"
        element_nodes = 3
        [sections.s]
        shape = "constants"
        EA = 1e7
        GAy = 1e7
        GAz = 1e7
        GJ = 1
        EIy = 1
        EIz = 4
        rhoA = 1
        rhoJ = [2e-6, 1e-6, 1e-6]
        [points]
        root = [0, 0, 0]
        tip = [1, 0, 0]
        [[members]]
        name = "beam"
        path = ["root", "tip"]
        section = "s"
        elements = 24
        local_y = [0, 1, 0]
        {extra}
        "#
    );
    Structure::from_toml_str(&text, "beam.toml", &[]).unwrap_or_else(|e| panic!("{e}")).mesh()
}

fn free(mesh: &Mesh, count: usize) -> super::ModeSet {
    analyse(mesh, Configuration::drawing(mesh), Support::Free, count).unwrap()
}

/// The paper's names for the modes of the frame (Table 3): it is a mirror image of itself about yz, and flat in xz.
#[test]
fn modes_of_the_frame_have_the_published_symmetry() {
    let mesh = fmb(10.0, 120, 2);
    let set = free(&mesh, 8);
    let names: Vec<_> = set.planes.iter().map(|p| (p.name(), p.flat)).collect();
    assert_eq!(names, [("yz", false), ("xz", true)]);
    use Parity::{Antisymmetric as A, Symmetric as S};
    // Symmetric in-plane, torsion, antisymmetric in-plane, symmetric out-of-plane, symmetric in-plane, ..
    let published = [[S, S], [A, A], [A, S], [S, A], [S, S], [A, S], [A, A], [S, S]];
    for (k, (mode, expected)) in set.modes.iter().zip(published).enumerate() {
        assert_eq!(mode.parity, expected, "mode {}", k + 1);
        assert!(mode.drift < 1e-9, "mode {}: {:e}", k + 1, mode.drift);
        assert!((mode.kinetic_share.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }
    // One tip heavier: the shape is as before, its modes are not.
    let mut mesh = mesh;
    mesh.lumped.push(crate::mesh::LumpedMass { node: 2, mass: nalgebra::Matrix6::identity() * 50.0 });
    let set = free(&mesh, 3);
    assert!(
        set.planes.iter().all(|p| p.name() != "yz")
            || set.modes.iter().any(|m| m.parity.contains(&Parity::Mixed))
    );
}

/// Textbook: the first mode of a cantilever carries 61.3 % of its mass, the second 18.8 %, the third 6.5 %; the rest falls off with the
/// square of the number. The softest of all modes keep their digits beside the stiffest.
#[test]
fn effective_masses_of_a_cantilever() {
    let mesh = beam("");
    let all = 6 * (mesh.nodes.len() - 1);
    let set = analyse(&mesh, Configuration::drawing(&mesh), Support::Clamped, all).unwrap();
    let flapping: Vec<f64> = set.modes.iter().map(|m| m.effective_mass[2]).filter(|m| *m > 1e-6).collect();
    for (found, expected) in flapping.iter().zip([0.6131, 0.1883, 0.0647]) {
        assert!((found - expected).abs() < 2e-4, "{found}, expected {expected}");
    }
    for axis in 1..3 {
        let sum: f64 = set.modes.iter().map(|m| m.effective_mass[axis]).sum();
        // All of them carry the whole mass but what the first node alone would: less than 2/15 of one of 24 elements.
        assert!((0.994..1.0).contains(&sum), "axis {axis}: {sum}");
    }
    assert!(set.modes.iter().all(|m| m.frame.norm() == 0.0));
}

/// A beam under tension T: with a load that stiffens it the frequencies rise as those of the equilibrium's geometric stiffness, and the
/// modes are told apart where their frequencies cross (flapping overtakes nothing here, but torsion stays while bending rises).
#[test]
fn modes_are_tracked_through_a_crossing() {
    let at = |stiffness: f64| {
        let mut mesh = beam("");
        for section in &mut mesh.sections {
            section.stiffness[(4, 4)] = stiffness;
        }
        Spectrum::from(&free(&mesh, 6))
    };
    // EI about y rises through that about z: first flapping crosses first lagging.
    let spectra: Vec<Spectrum> = [1.0, 2.0, 3.0, 5.0, 8.0].map(at).into();
    let tracked = track(&spectra);
    let of = |level: usize, mode: usize| spectra[level].omega[tracked[level][mode].unwrap().0];
    assert_eq!(tracked[0].iter().map(|p| p.unwrap().0).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
    // Mode 1 flaps with sqrt(EI), mode 2 lags and does not change.
    assert!((of(4, 0) / of(0, 0) - 8f64.sqrt()).abs() < 1e-3, "{} {}", of(4, 0), of(0, 0));
    assert!((of(4, 1) / of(0, 1) - 1.0).abs() < 1e-6);
    assert!(tracked[4][0].unwrap().0 > tracked[4][1].unwrap().0, "they have crossed");
}

/// Flapping and lagging on the hub (Wright et al. 1982): 5.5850 and 24.2733 at four times the unit of rate, lagging by Southwell's
/// `w_lag^2 = w_flap^2 - W^2` where both stiffnesses are equal.
#[test]
fn frequencies_on_a_turning_hub() {
    let mut mesh = beam("");
    for section in &mut mesh.sections {
        section.stiffness[(5, 5)] = 1.0;
    }
    let found = spinning(&mesh, &Vector3::new(0.0, 0.0, 4.0), 4).unwrap();
    let flap = [5.5850f64, 24.2733];
    let lag = flap.map(|w| (w * w - 16.0).sqrt());
    for (k, expected) in [lag[0], flap[0]].into_iter().enumerate() {
        assert!((found.omega[k] - expected).abs() < 1e-3, "{:?}", found.omega);
    }
    assert!(found.growth.iter().all(|g| g.abs() < 1e-6), "{:?}", found.growth);
    // No rotation: the clamped modes.
    let rest = spinning(&mesh, &Vector3::zeros(), 4).unwrap();
    let clamped = analyse(&mesh, Configuration::drawing(&mesh), Support::Clamped, 4).unwrap();
    for (a, b) in rest.omega.iter().zip(&clamped.modes) {
        assert!((a - b.omega).abs() < 1e-6 * b.omega, "{a} {}", b.omega);
    }
}
