//! Energies of reduced models against those of the finite elements at finite amplitudes, by the hand-written operators.

use nalgebra::{Vector3, Vector6};
use rom_runtime::data::ModelData;
use rom_runtime::{Model, State};

use super::manifold::Manifold;
use super::momentum::Momentum;
use super::range::limits;
use super::{Reduction, TOLERANCES, Tolerances};
use crate::assembly::{AnyBeam, Assembly};
use crate::build::{BuildOptions, ModeSelection, build_mesh};
use crate::carrier::Carrier;
use crate::configuration::Configuration;
use crate::element::internal_force::{internal_force, split, stack};
use crate::element::tests::Random;
use crate::math::so3::{MatrixFunction, exp_quaternion};
use crate::mesh::Mesh;
use crate::reduce::modes::elastic_modes;
use crate::test_structures::{crooked_body, fmb, provenance};

/// Nothing is dropped but round-off.
const FINE: Tolerances = Tolerances { fields: 1e-9, terms: [1e-9; 2], moments: 1e-10, points: [1e-9; 2] };

struct Case {
    assembly: Assembly,
    at: Configuration,
    manifold: Manifold,
    model: Model,
}

fn case(mesh: &Mesh, at: Configuration, modes: usize, geometric: bool) -> Case {
    let options =
        BuildOptions { modes: ModeSelection::Count(modes), all_nodes: false, ..BuildOptions::default() };
    let assembly = Assembly::new(mesh);
    let (mass, stiffness) = (assembly.mass(&at), assembly.stiffness(&at));
    let shapes = elastic_modes(&assembly, &at, &mass, &stiffness, modes).unwrap();
    let reduction = Reduction {
        assembly: &assembly,
        at: &at,
        modes: &shapes,
        geometric,
        equilibrium: None,
        rigid: &mass.rr,
        tolerances: FINE,
    };
    let places: Vec<_> = Carrier::of_points(mesh).iter().map(|c| c.placed(&at)).collect();
    let manifold = reduction.manifold().unwrap();
    let lagrangian = Some(reduction.lagrangian(&manifold, &places).unwrap().0);
    let built = build_mesh(mesh, provenance(), &options, &mut |_| ()).unwrap();
    let model = Model::new(ModelData { lagrangian, ..built }).unwrap();
    Case { assembly, at, manifold, model }
}

impl Case {
    /// Node by node: motion from the configuration and its rate.
    fn motion(&self, q: &[f64], q_dot: &[f64]) -> Vec<(Vector6<f64>, Vector6<f64>)> {
        let range = &self.manifold.range;
        let scaled = |x: &[f64], i: usize| x[i] / range[i];
        (0..self.at.positions.len())
            .map(|node| {
                let (mut x, mut rate) = (Vector6::zeros(), Vector6::zeros());
                for (factors, c) in self.manifold.monomials.factors.iter().zip(self.manifold.at_node(node)) {
                    let value: f64 = factors.iter().map(|&i| scaled(q, i)).product();
                    x += c * value;
                    for k in 0..factors.len() {
                        let rest = factors.iter().enumerate().filter(|(l, _)| *l != k);
                        let others: f64 = rest.map(|(_, &i)| scaled(q, i)).product();
                        rate += c * (others * scaled(q_dot, factors[k]));
                    }
                }
                (x, rate)
            })
            .collect()
    }

    fn configuration(&self, motion: &[(Vector6<f64>, Vector6<f64>)]) -> Configuration {
        let moved = |node: usize| split(&motion[node].0);
        let nodes = 0..self.at.positions.len();
        Configuration {
            positions: nodes.clone().map(|n| self.at.positions[n] + moved(n).0).collect(),
            rotations: nodes.map(|n| self.at.rotations[n] * exp_quaternion(&moved(n).1)).collect(),
        }
    }

    /// `1/2 nu^t M(eta) nu`, by the hand-written mass matrix.
    fn kinetic(&self, q: &[f64], q_dot: &[f64], beta: &Vector6<f64>) -> f64 {
        let motion = self.motion(q, q_dot);
        let mass = self.assembly.mass(&self.configuration(&motion));
        let velocities: Vec<Vector6<f64>> = motion
            .iter()
            .map(|(x, rate)| {
                let ((_, theta), (v, theta_dot)) = (split(x), split(rate));
                stack(&v, &(MatrixFunction::tangential(&theta).matrix() * theta_dot))
            })
            .collect();
        let nodal = self.assembly.gather(&velocities);
        let mut momenta = vec![Vector6::zeros(); nodal.len()];
        mass.ss.multiply(&nodal, &mut momenta);
        let of_nodes: f64 = nodal.iter().zip(&momenta).map(|(v, p)| v.dot(p)).sum();
        let coupling: f64 = nodal.iter().zip(&mass.sr).map(|(v, m)| v.dot(&(m * beta))).sum();
        0.5 * of_nodes + coupling + 0.5 * beta.dot(&(mass.rr * beta))
    }

    fn elastic(&self, q: &[f64]) -> f64 {
        let at = self.configuration(&self.motion(q, q));
        let energy = |beam: &AnyBeam| match beam {
            AnyBeam::Two(b) => internal_force(b, &at.of(b)).energy,
            AnyBeam::Three(b) => internal_force(b, &at.of(b)).energy,
        };
        self.assembly.beams.iter().map(energy).sum()
    }

    /// Kinetic and elastic energy of the reduced model.
    fn reduced(&self, q: &[f64], q_dot: &[f64], beta: &Vector6<f64>) -> (f64, f64) {
        let mut state = State::at_rest(&self.model);
        (state.q, state.q_dot) = (q.to_vec(), q_dot.to_vec());
        state.beta_star = [0.0; 6];
        let moved = self.model.velocity(&state);
        state.beta_star = std::array::from_fn(|i| beta[i] - moved[i]);
        let ledger = self.model.ledger(&state);
        (ledger.kinetic_energy, ledger.elastic_energy)
    }
}

/// Errors of both energies at `size` times the range of the amplitudes and at half of it, relative to the energies: root mean
/// squares over random states, in which terms of different orders cannot cancel.
fn errors(case: &Case, size: f64) -> [(f64, f64); 2] {
    let mut random = Random::new(5);
    let m = case.model.n_modes();
    let rest = case.elastic(&vec![0.0; m]);
    let mut sums = [(0.0, 0.0); 2];
    for _ in 0..12 {
        let mut scaled = || -> Vec<f64> { case.manifold.range.iter().map(|r| r * random.next()).collect() };
        let (q, q_dot) = (scaled(), scaled());
        let beta = random.vector6();
        for (sum, size) in sums.iter_mut().zip([size, 0.5 * size]) {
            let q: Vec<f64> = q.iter().map(|q| size * q).collect();
            let (kinetic, elastic) = case.reduced(&q, &q_dot, &beta);
            let exact = (case.kinetic(&q, &q_dot, &beta), case.elastic(&q) - rest);
            sum.0 += (kinetic / exact.0 - 1.0).powi(2) / 12.0;
            sum.1 += (elastic / exact.1 - 1.0).powi(2) / 12.0;
        }
    }
    sums.map(|(kinetic, elastic)| (kinetic.sqrt(), elastic.sqrt()))
}

/// A structure of closed loops.
fn looped() -> Mesh {
    let mut mesh = crooked_body(2);
    crate::test_structures::add_line(&mut mesh, 2, 3, 3, 2, Vector3::new(0.1, 0.3, 1.0));
    mesh
}

#[test]
fn kinetic_energy_is_exact_to_second_order_in_the_amplitudes() {
    let meshes = [crooked_body(2), crooked_body(3), looped(), fmb(10.0, 12, 2)];
    for (index, mesh) in meshes.iter().enumerate() {
        for geometric in [false, true] {
            let case = case(mesh, Configuration::drawing(mesh), 4, geometric);
            let [(coarse, _), (fine, _)] = errors(&case, 0.5);
            // The fields are exact to third order, their derivatives to second: the error is of third order, 8 with a margin for
            // the next (4 would be second order), as far as it is above what was dropped (some 1e-8).
            assert!(coarse > 5.5 * fine || coarse < 1e-7, "{index} {geometric}: {coarse:e} {fine:e}");
            assert!(coarse < 5e-2, "{index} {geometric}: {coarse:e}");
            let [(none, _), _] = errors(&case, 0.0);
            assert!(none < 1e-11, "{index} {geometric}: {none:e}");
        }
    }
}

#[test]
fn elastic_energy_is_exact_to_fourth_order_on_the_curved_manifold() {
    for (index, mesh) in [crooked_body(2), crooked_body(3), looped(), fmb(10.0, 12, 2)].iter().enumerate() {
        let case = case(mesh, Configuration::drawing(mesh), 4, true);
        let [(_, coarse), (_, fine)] = errors(&case, 0.4);
        // Strains linear but for terms of fourth order, which meet linear ones: relative error of third order.
        assert!(coarse > 5.5 * fine || coarse < 1e-9, "{index}: {coarse:e} {fine:e}");
        assert!(coarse < 2e-2, "{index}: {coarse:e}");
    }
}

#[test]
fn only_closed_loops_keep_a_self_stress() {
    let size = |mesh: &Mesh| {
        let case = case(mesh, Configuration::drawing(mesh), 4, true);
        case.model.data().lagrangian.as_ref().map(|it| it.self_stress.len())
    };
    assert_eq!(size(&crooked_body(3)), Some(0));
    // Six redundant forces in one loop.
    let looped = size(&looped()).unwrap();
    assert!((1..=6).contains(&looped), "{looped}");
}

/// The momenta that limits are learned from are those of the runtime: `u . M u` is twice its kinetic energy.
#[test]
fn momenta_of_the_file_are_those_of_its_energy() {
    let mesh = crooked_body(2);
    let case = case(&mesh, Configuration::drawing(&mesh), 4, true);
    let mut random = Random::new(9);
    let rigid = case.assembly.mass(&case.at).rr;
    let momentum = Momentum::new(case.model.data().lagrangian.as_ref().unwrap(), &rigid);
    for _ in 0..4 {
        let mut scaled = || -> Vec<f64> { case.manifold.range.iter().map(|r| r * random.next()).collect() };
        let (q, q_dot) = (scaled(), scaled());
        let beta = random.vector6();
        let u = nalgebra::DVector::from_iterator(10, q_dot.iter().chain(beta.iter()).copied());
        let (twice, kinetic) = (u.dot(&momentum.at(&q, &u)), case.reduced(&q, &q_dot, &beta).0);
        assert!((twice / (2.0 * kinetic) - 1.0).abs() < 1e-12, "{twice} {kinetic}");
    }
}

/// With all terms the polynomials lack what is of fourth order and higher: shares that go with the third power of the amplitude or a higher
/// one. What is dropped goes with the second, and the limits are nearer. Of loops too, whose strains are not those asked for.
#[test]
fn limits_go_with_the_order_of_what_is_left_out() {
    for (index, mesh) in [fmb(10.0, 24, 2), looped()].iter().enumerate() {
        let at = Configuration::drawing(mesh);
        let assembly = Assembly::new(mesh);
        let (mass, stiffness) = (assembly.mass(&at), assembly.stiffness(&at));
        let modes = elastic_modes(&assembly, &at, &mass, &stiffness, 4).unwrap();
        let places: Vec<_> = Carrier::of_points(mesh).iter().map(|c| c.placed(&at)).collect();
        let found = |tolerances: Tolerances| {
            let reduction = Reduction {
                assembly: &assembly,
                at: &at,
                modes: &modes,
                geometric: true,
                equilibrium: None,
                rigid: &mass.rr,
                tolerances,
            };
            let manifold = reduction.manifold().unwrap();
            let (data, _) = reduction.lagrangian(&manifold, &places).unwrap();
            limits(&reduction, &manifold, &data, &places, &mass.rr).unwrap()
        };
        let (fine, coarse) = (found(FINE), found(TOLERANCES));
        for (mode, (fine, coarse)) in fine.chunks_exact(3).zip(coarse.chunks_exact(3)).enumerate() {
            let order = 10_f64.ln() / (fine[2] / fine[0]).ln();
            assert!(order > 2.7, "{index}, mode {mode}: order {order}, {fine:?}");
            assert!(coarse[0] < fine[0], "{index}, mode {mode}: {coarse:?} {fine:?}");
            assert!(coarse.is_sorted() && fine.is_sorted());
        }
    }
}
