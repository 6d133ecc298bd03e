//! Modes and tensors of whole structures.

use nalgebra::{DVector, Vector3, Vector6};
use num_dual::HyperDual64;

use super::modes::{Modes, elastic_modes};
use super::tensors::{DROP, Tensors, pairs, project};
use crate::assembly::{AnyBeam, Assembly};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::dual_reference::{Motion, kinetic_energy, lumped_kinetic_energy};
use crate::element::tests::Random;
use crate::math::so3::exp_quaternion;
use crate::mesh::{InertiaQuadrature, Mesh};
use crate::test_structures::{crooked, fmb};

fn frequencies(mesh: &crate::mesh::Mesh, count: usize) -> Vec<f64> {
    let assembly = Assembly::new(mesh);
    let at = Configuration::drawing(mesh);
    let (mass, k) = (assembly.mass(&at), assembly.stiffness(&at));
    let modes = elastic_modes(&assembly, &at, &mass, &k, count).unwrap();
    assert!(modes.orthogonality_error < 1e-9, "{}", modes.orthogonality_error);
    modes.omega
}

/// Table 3 of the paper: sigma = 10, 120 two-node elements, to the printed digits.
#[test]
fn published_frequencies() {
    let mut mesh = fmb(10.0, 120, 2);
    let consistent = frequencies(&mesh, 8);
    let expected = [6.919, 15.319, 16.377, 21.576, 23.126, 40.263, 61.515, 67.911];
    for (ours, theirs) in consistent.iter().zip(expected) {
        assert!((ours / theirs - 1.0).abs() < 2e-4, "{ours} {theirs}");
    }
    mesh.inertia_quadrature = InertiaQuadrature::ReducedCoupling;
    let paper = [6.92, 15.32, 16.37, 21.58, 23.13, 40.23, 61.46, 67.91];
    for (ours, theirs) in frequencies(&mesh, 8).iter().zip(paper) {
        assert!((ours - theirs).abs() < 0.005 + 1e-6, "{ours} {theirs}");
    }
}

/// `omega^2` of the iteration is that of the strain energy however fine the mesh. The assembled matrix alone keeps
/// `eps (L/h)^2.5`, here 1e-8 and more.
#[test]
fn a_fine_mesh_keeps_the_digits_of_the_lowest_frequencies() {
    let mesh = fmb(10.0, 3000, 2);
    let (assembly, at) = (Assembly::new(&mesh), Configuration::drawing(&mesh));
    let (mass, k) = (assembly.mass(&at), assembly.stiffness(&at));
    let modes = elastic_modes(&assembly, &at, &mass, &k, 3).unwrap();
    assert!(modes.frequency_error < 1e-10, "{}", modes.frequency_error);
}

/// Table A of the paper, block c_SS: sigma = 10, three elastic modes scaled to phi^t M phi = 2, rounded, up to one sign per
/// mode.
#[test]
fn published_tensor() {
    let mesh = fmb(10.0, 120, 2);
    let assembly = Assembly::new(&mesh);
    let at = Configuration::drawing(&mesh);
    let (mass, k) = (assembly.mass(&at), assembly.stiffness(&at));
    let modes = elastic_modes(&assembly, &at, &mass, &k, 3).unwrap();
    let tensors = project(&assembly, &at, &modes);
    #[rustfmt::skip]
    let table = [
        [[0, 0, 1], [0, 0, 0], [0, 0, 0]], [[0, 0, 0], [0, 0, 3], [0, 0, 0]], [[0, 0, 0], [0, -1, 0], [0, 0, 0]],
        [[0, 0, 0], [0, 0, -5], [0, 1, 0]], [[0, 0, -2], [0, 0, 0], [3, 0, 0]], [[0, -3, 0], [-8, 0, 0], [0, 0, 0]],
    ];
    let agrees = |sign: [f64; 3]| {
        (0..54).all(|n| {
            let (r, i, l) = (n / 9, n / 3 % 3, n % 3);
            (2.0 * sign[i] * sign[l] * tensors.c[r][(i, l)]).round() == f64::from(table[r][i][l])
        })
    };
    let signs = (0..8).map(|n| [0, 1, 2].map(|b| if n >> b & 1 == 0 { 1.0 } else { -1.0 }));
    assert!(signs.into_iter().any(agrees), "no choice of signs gives Table A: {:?}", tensors.c);
}

/// Directional derivatives of the kinetic energy of a whole structure: increments, rates and velocity of A.
#[derive(Clone)]
struct Direction {
    x: Vec<Vector6<f64>>,
    x_dot: Vec<Vector6<f64>>,
    beta: Vector6<f64>,
}

struct Whole<'a> {
    mesh: &'a Mesh,
    assembly: &'a Assembly,
    at: &'a Configuration,
    beta: Vector6<f64>,
}

impl Whole<'_> {
    fn kinetic(&self, one: &Direction, two: &Direction) -> HyperDual64 {
        let dual = |re: f64, a: f64, b: f64| HyperDual64::new(re, a, b, 0.0);
        let motion = |node: usize| -> Motion<HyperDual64, 1> {
            let mut m = Motion::rest();
            for k in 0..6 {
                m.x[0][k] = dual(0.0, one.x[node][k], two.x[node][k]);
                m.x_dot[0][k] = dual(0.0, one.x_dot[node][k], two.x_dot[node][k]);
                m.beta[k] = dual(self.beta[k], one.beta[k], two.beta[k]);
            }
            m
        };
        let mut sum = HyperDual64::from(0.0);
        for beam in &self.assembly.beams {
            sum += match beam {
                AnyBeam::Two(b) => self.beam(b, motion),
                AnyBeam::Three(b) => self.beam(b, motion),
            };
        }
        for lump in &self.mesh.lumped {
            let (r, q) = (&self.at.positions[lump.node], &self.at.rotations[lump.node]);
            sum += lumped_kinetic_energy(&lump.mass, r, q, &motion(lump.node));
        }
        sum
    }

    fn beam<const N: usize>(
        &self,
        beam: &Beam<N>,
        motion: impl Fn(usize) -> Motion<HyperDual64, 1>,
    ) -> HyperDual64 {
        let nodal = beam.nodes.map(motion);
        let all = Motion {
            x: std::array::from_fn(|a| nodal[a].x[0]),
            x_dot: std::array::from_fn(|a| nodal[a].x_dot[0]),
            beta: nodal[0].beta,
        };
        kinetic_energy(beam, &self.at.of(beam), &all)
    }
}

fn transport(beta: &Vector6<f64>, p: &Vector6<f64>) -> Vector6<f64> {
    let part = |v: &Vector6<f64>, k: usize| Vector3::from(v.fixed_rows::<3>(k));
    let (v, w, pv, pw) = (part(beta, 0), part(beta, 3), part(p, 0), part(p, 3));
    let (f, m) = (w.cross(&pv), w.cross(&pw) + v.cross(&pv));
    Vector6::new(f.x, f.y, f.z, m.x, m.y, m.z)
}

/// Gyroscopic forces on the modes for amplitudes `q`, rates `u = (qdot, beta*)`, from derivatives of the kinetic energy.
fn exact_forces(whole: &mut Whole<'_>, modes: &Modes, q: &DVector<f64>, u: &DVector<f64>) -> DVector<f64> {
    let (m, n) = (modes.m(), whole.mesh.nodes.len());
    let shape = |a: &DVector<f64>| -> Vec<Vector6<f64>> {
        (0..n).map(|node| (0..m).map(|l| modes.at_node(node)[l] * a[l]).sum()).collect()
    };
    let elastic: Vector6<f64> = (0..m).map(|l| modes.phi_r[l] * u[l]).sum();
    whole.beta = elastic + u.fixed_rows::<6>(m);
    let zero =
        Direction { x: vec![Vector6::zeros(); n], x_dot: vec![Vector6::zeros(); n], beta: Vector6::zeros() };
    let moved = |x: Vec<Vector6<f64>>| Direction { x, ..zero.clone() };
    let rated = |x_dot: Vec<Vector6<f64>>| Direction { x_dot, ..zero.clone() };
    let unit = |r: usize| Direction { beta: Vector6::ith(r, 1.0), ..zero.clone() };
    let (x, x_dot) = (shape(q), shape(&u.rows(0, m).into_owned()));

    let rigid_along = |d: &Direction| {
        let t: Vec<HyperDual64> = (0..6).map(|r| whole.kinetic(&unit(r), d)).collect();
        (Vector6::from_fn(|r, _| t[r].eps1), Vector6::from_fn(|r, _| t[r].eps1eps2))
    };
    let (momentum, momentum_x) = rigid_along(&moved(x.clone()));
    let (_, momentum_moving) = rigid_along(&moved(x_dot.clone()));
    let (_, momentum_rate) = rigid_along(&rated(x_dot.clone()));
    let rigid_rows = momentum_moving + transport(&whole.beta, &(momentum + momentum_x + momentum_rate));
    DVector::from_fn(m + 6, |i, _| {
        if i >= m {
            return rigid_rows[i - m];
        }
        let y: Vec<Vector6<f64>> = (0..n).map(|node| modes.at_node(node)[i]).collect();
        let c_ss = whole.kinetic(&moved(x_dot.clone()), &rated(y.clone())).eps1eps2
            - whole.kinetic(&moved(y.clone()), &rated(x_dot.clone())).eps1eps2;
        let t = whole.kinetic(&moved(y), &moved(x.clone()));
        c_ss - t.eps1 - t.eps1eps2 + modes.phi_r[i].dot(&rigid_rows)
    })
}

fn contracted(tensors: &Tensors, modes: &Modes, q: &DVector<f64>, u: &DVector<f64>) -> DVector<f64> {
    let m = modes.m();
    let elastic: Vector6<f64> = (0..m).map(|l| modes.phi_r[l] * u[l]).sum();
    let beta = elastic + u.fixed_rows::<6>(m);
    let mut f = DVector::zeros(m + 6);
    for r in 0..6 {
        f += &tensors.c[r] * u * beta[r];
    }
    for (p, (r, s)) in pairs().enumerate() {
        f += &tensors.k[p] * q * (beta[r] * beta[s]);
    }
    f
}

/// Both tensors, contracted, are the derivative of the nonlinear gyroscopic forces of the same discretisation, also about a
/// strongly deformed configuration, with curved tapered beams, full section matrices and eccentric masses.
#[test]
fn tensors_are_derivatives_of_the_nonlinear_forces() {
    for (n_nodes, deform) in [(2, 0.0), (2, 0.4), (3, 0.4)] {
        let mesh = crooked(n_nodes);
        let assembly = Assembly::new(&mesh);
        let drawing = Configuration::drawing(&mesh);
        let (mass, k) = (assembly.mass(&drawing), assembly.stiffness(&drawing));
        let mut modes = elastic_modes(&assembly, &drawing, &mass, &k, 5).unwrap();
        let mut random = Random::new(5);
        let mut at = drawing.clone();
        for node in (0..mesh.nodes.len()).filter(|&n| n != mesh.reference) {
            at.positions[node] += random.vector3(deform);
            at.rotations[node] = exp_quaternion(&random.vector3(deform));
        }
        // Any basis will do for the identity; perturb the shapes so that nothing cancels by orthogonality.
        for phi in modes.phi_r.iter_mut() {
            *phi += random.vector6() * 0.1;
        }
        let tensors = project(&assembly, &at, &modes);
        let mut whole = Whole { mesh: &mesh, assembly: &assembly, at: &at, beta: Vector6::zeros() };
        for _ in 0..3 {
            let q = DVector::from_fn(5, |_, _| random.next());
            let u = DVector::from_fn(11, |_, _| random.next());
            let exact = exact_forces(&mut whole, &modes, &q, &u);
            let ours = contracted(&tensors, &modes, &q, &u);
            assert!((&exact - &ours).amax() < 1e-11 * exact.amax(), "{exact} {ours}");
        }
    }
}

#[test]
fn dropped_entries_are_round_off() {
    let mesh = fmb(10.0, 120, 2);
    let assembly = Assembly::new(&mesh);
    let at = Configuration::drawing(&mesh);
    let (mass, k) = (assembly.mass(&at), assembly.stiffness(&at));
    let modes = elastic_modes(&assembly, &at, &mass, &k, 10).unwrap();
    let tensors = project(&assembly, &at, &modes);
    let (c, k) = tensors.to_sparse(&mass.rr, DROP);
    let (c_loose, k_loose) = tensors.to_sparse(&mass.rr, 10.0 * DROP);
    // A clear gap: nothing lies between round-off and what is kept.
    assert_eq!(c.value.len(), c_loose.value.len());
    assert_eq!(k.value.len(), k_loose.value.len());
    assert!(c.value.len() < 16 * 16 * 6 / 3, "{}", c.value.len());
    assert!(c.dropped_norm < 1e-6 && k.dropped_norm < 1e-6, "{} {}", c.dropped_norm, k.dropped_norm);
    println!("c {} k {} dropped {} {}", c.value.len(), k.value.len(), c.dropped_norm, k.dropped_norm);
}

/// A straight beam of circular section bends alike in two planes: each pair of equal frequencies must come out as one mode in
/// either plane, not as a mixture that depends on the solver's start vectors.
#[test]
fn equal_frequencies_give_plane_modes() {
    let mut mesh = fmb(1.0, 24, 2);
    // Only the main beam, isotropic in bending.
    mesh.elements.retain(|e| e.member == 0 || e.member == 2);
    for (k, e) in mesh.elements.iter_mut().enumerate() {
        e.member = k / 8;
    }
    mesh.points.clear();
    let section = &mut mesh.sections[0];
    section.stiffness[(4, 4)] = section.stiffness[(5, 5)];
    section.mass[(4, 4)] = section.mass[(5, 5)];
    let used: Vec<usize> = (0..mesh.nodes.len())
        .filter(|n| mesh.elements.iter().any(|e| e.nodes[..e.n_nodes].contains(n)))
        .collect();
    for e in &mut mesh.elements {
        for node in &mut e.nodes {
            *node = used.iter().position(|n| n == node).unwrap();
        }
    }
    mesh.nodes = used.iter().map(|&n| mesh.nodes[n]).collect();
    let assembly = Assembly::new(&mesh);
    let at = Configuration::drawing(&mesh);
    let (mass, k) = (assembly.mass(&at), assembly.stiffness(&at));
    let modes = elastic_modes(&assembly, &at, &mass, &k, 6).unwrap();
    for pair in [0, 2, 4] {
        assert!((modes.omega[pair] / modes.omega[pair + 1] - 1.0).abs() < 1e-8, "{:?}", modes.omega);
        for l in [pair, pair + 1] {
            let size = |axis: usize| {
                (0..mesh.nodes.len()).map(|n| modes.at_node(n)[l][axis].abs()).fold(0.0, f64::max)
            };
            let (y, z) = (size(1), size(2));
            assert!(y.min(z) < 1e-6 * y.max(z), "mode {l} moves {y} along y and {z} along z");
        }
    }
    // Also where the last mode that is asked for is the first of a pair.
    for count in [1, 3, 5] {
        let fewer = elastic_modes(&assembly, &at, &mass, &k, count).unwrap();
        assert_eq!((fewer.m(), fewer.phi_r.len()), (count, count));
        assert!((fewer.next_omega.unwrap() / modes.omega[count] - 1.0).abs() < 1e-8);
        for node in 0..mesh.nodes.len() {
            let (all, own) = (&modes.at_node(node)[count - 1], &fewer.at_node(node)[count - 1]);
            assert!((all - own).amax() < 1e-6 * modes.at_node(0)[count - 1].amax().max(1e-3), "{count}");
        }
    }
}
