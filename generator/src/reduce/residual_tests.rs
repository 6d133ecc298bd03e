//! Residual modes against the sum over all modes of the structure.

use nalgebra::{DMatrix, Matrix6, Vector6};

use super::missing::missing;
use super::modes::{Modes, modes_of};
use super::residual::{LoadedPoint, ResidualSelection, with_residual_modes};
use crate::assembly::Assembly;
use crate::configuration::Configuration;
use crate::mesh::Mesh;
use crate::solve::eigen::FreeBody;
use crate::test_structures::{crooked, fmb};

const POINTS: [LoadedPoint; 2] = [
    LoadedPoint { point: 0, forces: true, moments: false },
    LoadedPoint { point: 1, forces: true, moments: true },
];

fn modes(mesh: &Mesh, count: usize, points: &[LoadedPoint]) -> (Modes, Vec<f64>) {
    let (assembly, at) = (Assembly::new(mesh), Configuration::drawing(mesh));
    let (mass, k) = (assembly.mass(&at), assembly.stiffness(&at));
    let body = FreeBody::new(&assembly, &at, &k, &mass).unwrap();
    let modes = modes_of(&body, &assembly, &at, &mass, count).unwrap();
    let (modes, loads) = with_residual_modes(mesh, &assembly, &at, &mass, &body, modes, points).unwrap();
    (modes, loads.iter().map(|load| load.missed).collect())
}

/// Flexibility `p^t Omega^{-2} p` of the free body between unit forces and moments on the points, A's own motion included.
fn flexibility(mesh: &Mesh, modes: &Modes) -> DMatrix<f64> {
    let at = Configuration::drawing(mesh);
    let columns: Vec<Vec<f64>> = (0..modes.m())
        .map(|j| {
            let of_point = |p: &LoadedPoint| {
                let node = mesh.points[p.point].node().expect("points of this mesh are nodes");
                let (phi, a) = (modes.at_node(node)[j], modes.phi_r[j]);
                let (v, w) = (a.fixed_rows::<3>(0).into_owned(), a.fixed_rows::<3>(3).into_owned());
                let moved = phi.fixed_rows::<3>(0) + v + w.cross(&at.positions[node]);
                let turned = phi.fixed_rows::<3>(3) + w;
                Vector6::from_iterator(moved.iter().chain(turned.iter()).copied())
            };
            POINTS
                .iter()
                .flat_map(|p| {
                    of_point(p).iter().take(if p.moments { 6 } else { 3 }).copied().collect::<Vec<_>>()
                })
                .collect()
        })
        .collect();
    let n = 9;
    DMatrix::from_fn(n, n, |a, b| {
        columns.iter().zip(&modes.omega).map(|(p, omega)| p[a] * p[b] / (omega * omega)).sum()
    })
}

/// The sum over all modes is the static flexibility; few modes miss a good part of it, with residual modes nothing.
#[test]
fn the_static_response_is_that_of_all_modes() {
    let mesh = crooked(2);
    let (all, _) = modes(&mesh, 6 * (mesh.nodes.len() - 1), &[]);
    let exact = flexibility(&mesh, &all);
    let (few, _) = modes(&mesh, 4, &[]);
    let (completed, missed) = modes(&mesh, 4, &POINTS);
    let error = |modes: &Modes| (flexibility(&mesh, modes) - &exact).amax() / exact.amax();
    assert!(error(&few) > 0.02, "4 modes alone: {}", error(&few));
    // Directions of less than 1e-8 of the strain energy of their load are left out.
    assert!(error(&completed) < 1e-8, "with residual modes: {}", error(&completed));
    let part = flexibility(&mesh, &few);
    for (a, missed) in missed.iter().enumerate() {
        let expected = 1.0 - part[(a, a)] / exact[(a, a)];
        assert!((missed - expected).abs() < 1e-9, "load {a}: {missed} {expected}");
    }
}

/// What five modes miss, between any two points, is what all the others give; nothing is missed once there are residual modes.
#[test]
fn what_is_missed_is_in_the_other_modes() {
    let mesh = fmb(10.0, 12, 2);
    let (assembly, at) = (Assembly::new(&mesh), Configuration::drawing(&mesh));
    let (mass, k) = (assembly.mass(&at), assembly.stiffness(&at));
    let body = FreeBody::new(&assembly, &at, &k, &mass).unwrap();
    let (all, _) = modes(&mesh, 6 * (mesh.nodes.len() - 1), &[]);
    let (five, _) = modes(&mesh, 5, &[]);
    let tips = [2, 4];
    let found = missing(&mesh, &assembly, &at, &mass, &body, &five, &tips, Vec::new()).unwrap();
    let node = |point: usize| mesh.points[point].node().expect("points of this mesh are nodes");
    let mut largest = 0.0_f64;
    let work = |node: usize, j: usize| {
        let (phi, a) = (all.at_node(node)[j], all.phi_r[j]);
        let (v, w) = (a.fixed_rows::<3>(0).into_owned(), a.fixed_rows::<3>(3).into_owned());
        let moved = phi.fixed_rows::<3>(0) + v + w.cross(&at.positions[node]);
        let turned = phi.fixed_rows::<3>(3) + w;
        Vector6::from_iterator(moved.iter().chain(turned.iter()).copied())
    };
    for (slot, &loaded) in found.loaded.iter().enumerate() {
        let from = node(loaded as usize);
        let mut expected = Matrix6::zeros();
        for j in 5..all.m() {
            expected += all.phi_r[j] * work(from, j).transpose() / (all.omega[j] * all.omega[j]);
        }
        let block = Matrix6::from_row_slice(&found.rigid[36 * slot..36 * (slot + 1)]);
        assert!((block - expected).amax() <= 1e-6 * expected.amax(), "A, load {slot}: {block} {expected}");
        for point in 0..mesh.points.len() {
            let mut expected = Matrix6::zeros();
            for j in 5..all.m() {
                let squared = all.omega[j] * all.omega[j];
                expected += all.at_node(node(point))[j] * work(from, j).transpose() / squared;
            }
            let start = 36 * (slot * mesh.points.len() + point);
            let block = Matrix6::from_row_slice(&found.flexibility[start..start + 36]);
            largest = largest.max(expected.amax());
            // Digits: the static response is a hundred times what is missed, the sum over all modes has those of the lowest ones.
            assert!((block - expected).amax() <= 1e-6 * largest, "{point}: {block} {expected}");
        }
    }
    assert!(largest > 0.0);
    let every = tips.map(|point| LoadedPoint { point, forces: true, moments: true });
    let (completed, _) = modes(&mesh, 5, &every);
    let none = missing(&mesh, &assembly, &at, &mass, &body, &completed, &tips, Vec::new()).unwrap();
    // Directions of less than 1e-8 of the strain energy of their load are left out: some hundred times what is missed.
    let left = none.flexibility.iter().fold(0.0_f64, |left, x| left.max(x.abs()));
    assert!(left < 1e-5 * largest, "{left} of {largest}");
}

/// They are modes like the others: orthonormal, without momentum, above the frequencies of the kept ones.
#[test]
fn they_are_orthonormal_free_modes() {
    let mesh = fmb(10.0, 60, 2);
    let points = ResidualSelection::Points(vec!["P".into(), "Q".into()]).points(&mesh).unwrap();
    let (modes, _) = modes(&mesh, 5, &points);
    assert!(modes.orthogonality_error < 1e-9, "{}", modes.orthogonality_error);
    assert_eq!((modes.m(), modes.residual), (11, 6), "forces on two tips");
    assert!(modes.omega.windows(2).all(|pair| pair[0] < pair[1]), "{:?}", modes.omega);
}

/// A load that the kept modes follow entirely needs nothing: asking for all of a small structure's modes leaves none to add.
#[test]
fn nothing_is_made_from_round_off() {
    let mesh = crooked(2);
    let count = 6 * (mesh.nodes.len() - 1);
    let (modes, missed) = modes(&mesh, count, &POINTS);
    assert_eq!((modes.m(), modes.residual), (count, 0));
    assert!(missed.iter().all(|share| *share < 1e-9), "{missed:?}");
}

#[test]
fn unknown_points_are_refused_by_name() {
    let mesh = crooked(2);
    let message = ResidualSelection::Points(vec!["tip".into()]).points(&mesh).unwrap_err();
    assert_eq!(message, "there is no point `tip`; the structure has A, P");
    assert_eq!(ResidualSelection::Loaded.points(&mesh), Ok(Vec::new()), "no load case, no loaded point");
}
