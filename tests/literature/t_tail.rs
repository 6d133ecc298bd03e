//! T-tails: a fin with a tailplane across its top, where torsion of the one is bending of the other.
//!
//! Statics by unit loads (any textbook of structural analysis). Frequencies by the exact dynamic stiffness of Timoshenko members, the
//! transfer matrix of `d(u, theta, F, M)/dx`, with the count of W. H. Wittrick and F. W. Williams, "A general algorithm for computing
//! natural frequencies of elastic structures", Q. J. Mech. Appl. Math. 24 (1971), on one half of the tail with the symmetric or the
//! antisymmetric motions of the fin. It shares nothing with the program but the 6 x 6 sections and the places of the points.

use nalgebra::{DMatrix, Matrix3, Matrix6, SymmetricEigen, Vector3};
use rom_generator::configuration::Configuration;
use rom_generator::equilibrium::{EquilibriumSettings, solve};
use rom_generator::mesh::Mesh;
use rom_generator::vibration::{Parity, Support, analyse};

use super::{assert_near, mesh, node};

const HEIGHT: f64 = 3.0;
const HALF_SPAN: f64 = 4.0;
/// EA, GAy, GAz, GJ, EIy, EIz: local y of the fin is along the span, its local z against the flight.
const FIN: [f64; 6] = [2e6, 5e5, 4e5, 3e4, 9e4, 2e4];
/// Local y of the tailplane is along the chord, its local z up.
const TAILPLANE: [f64; 6] = [1e6, 3e5, 2e5, 6e3, 8e3, 5e4];
/// rhoA, and rhoJ about the three axes.
const FIN_MASS: [f64; 4] = [6.0, 0.3, 0.18, 0.12];
const TAILPLANE_MASS: [f64; 4] = [3.0, 0.12, 0.02, 0.1];
/// A fairing on top, ahead of the axis of the fin.
const FAIRING: f64 = 5.0;
const AHEAD: f64 = 0.4;
const FAIRING_INERTIA: [f64; 3] = [0.2, 0.6, 0.5];

/// The tail, its tips swept back by `back` and raised by `up`.
fn tail(back: f64, up: f64, fairing: bool) -> Mesh {
    let section = |name: &str, [ea, gay, gaz, gj, eiy, eiz]: [f64; 6], [rho_a, x, y, z]: [f64; 4]| {
        format!(
            "[sections.{name}]\nshape = \"constants\"\nEA = {ea}\nGAy = {gay}\nGAz = {gaz}\nGJ = {gj}\nEIy = {eiy}\nEIz = {eiz}\n\
             rhoA = {rho_a}\nrhoJ = [{x}, {y}, {z}]\n"
        )
    };
    let mass = format!(
        "[[masses]]\npoint = \"top\"\nmass = {FAIRING}\noffset = [{AHEAD}, 0, 0]\ninertia = {FAIRING_INERTIA:?}\n"
    );
    let load = |name: &str, force: [f64; 3]| {
        format!(
            "[load_cases.{name}]\nt_end = 1\ndt = 1\nloads = [{{ point = \"right\", frame = \"dead\", force = {force:?} }}]\n"
        )
    };
    mesh(&format!(
        r#"
        [structure]
        name = "T-tail"
        reference = "root"
        element_nodes = 3
        {}{}
        [points]
        root = [0, 0, 0]
        top = [0, 0, {HEIGHT}]
        left = [{x}, {left}, {z}]
        right = [{x}, {HALF_SPAN}, {z}]
        [[members]]
        name = "fin"
        path = ["root", "top"]
        section = "fin"
        elements = 12
        local_y = [0, 1, 0]
        [[members]]
        name = "tailplane"
        path = ["left", "top", "right"]
        section = "tailplane"
        elements = 32
        local_y = [-1, 0, 0]
        {}{}{}{}
        "#,
        section("fin", FIN, FIN_MASS),
        section("tailplane", TAILPLANE, TAILPLANE_MASS),
        if fairing { &mass } else { "" },
        load("back", [LOAD, 0.0, 0.0]),
        load("out", [0.0, LOAD, 0.0]),
        load("up", [0.0, 0.0, LOAD]),
        x = -back,
        left = -HALF_SPAN,
        z = HEIGHT + up,
    ))
}

/// Small enough for linear answers: it turns the tail by some 1e-8.
const LOAD: f64 = 1e-5;

#[test]
fn a_force_on_a_tip_bends_the_tailplane_and_bends_and_twists_the_fin() {
    let mesh = tail(0.0, 0.0, false);
    let (h, b, p) = (HEIGHT, HALF_SPAN, LOAD);
    let [fin_ea, fin_gay, fin_gaz, fin_gj, fin_eiy, fin_eiz] = FIN;
    let [ea, gay, gaz, _, eiy, eiz] = TAILPLANE;
    // Displacement of the tip and moment about the root, by the forces and moments of a unit load along the members. The fin shears and
    // bends along x in (GAz, EIy), along y in (GAy, EIz).
    let expected = [
        (
            Vector3::new(
                p * (h.powi(3) / (3.0 * fin_eiy)
                    + h / fin_gaz
                    + b * b * h / fin_gj
                    + b.powi(3) / (3.0 * eiz)
                    + b / gay),
                0.0,
                0.0,
            ),
            Vector3::new(0.0, h * p, -b * p),
        ),
        (
            Vector3::new(
                0.0,
                p * (h.powi(3) / (3.0 * fin_eiz) + h / fin_gay + b / ea),
                -p * b * h * h / (2.0 * fin_eiz),
            ),
            Vector3::new(-h * p, 0.0, 0.0),
        ),
        (
            Vector3::new(
                0.0,
                -p * b * h * h / (2.0 * fin_eiz),
                p * (b * b * h / fin_eiz + h / fin_ea + b.powi(3) / (3.0 * eiy) + b / gaz),
            ),
            Vector3::new(b * p, 0.0, 0.0),
        ),
    ];
    for (case, (tip, root)) in mesh.load_cases.iter().zip(expected) {
        let state = solve(&mesh, case, &EquilibriumSettings::default()).unwrap();
        let at = node(&mesh, "right");
        let found = state.configuration.positions[at] - mesh.nodes[at];
        // Quadratic elements are exact under forces at their ends; the rest are second-order displacements and round-off of the places.
        assert_near((found - tip).norm(), 0.0, 1e-6 * tip.norm(), &format!("tip under {}", case.name));
        let (force, moment) = (state.reaction_force, state.reaction_moment);
        assert_near((force + Vector3::from(case.loads[0].force)).norm(), 0.0, 1e-7 * p, "force at the root");
        assert_near((moment + root).norm(), 0.0, 1e-6 * root.norm(), &format!("moment under {}", case.name));
    }
}

/// A straight member between two places: its section in axes of its own and the columns of these axes.
struct Member {
    stiffness: Matrix6<f64>,
    mass: Matrix6<f64>,
    axes: Matrix3<f64>,
    length: f64,
}

impl Member {
    fn new(along: Vector3<f64>, local_y: Vector3<f64>, stiffness: [f64; 6], mass: [f64; 4]) -> Self {
        let x = along.normalize();
        let z = x.cross(&local_y).normalize();
        let [rho_a, jx, jy, jz] = mass;
        Self {
            stiffness: Matrix6::from_diagonal(&stiffness.into()),
            mass: Matrix6::from_diagonal(&[rho_a, rho_a, rho_a, jx, jy, jz].into()),
            axes: Matrix3::from_columns(&[x, z.cross(&x), z]),
            length: along.norm(),
        }
    }

    /// The half of a member that lies in the plane of symmetry.
    fn half(mut self) -> Self {
        self.stiffness *= 0.5;
        self.mass *= 0.5;
        self
    }

    /// Forces and moments on the ends per displacement and rotation of the ends at the frequency, of one of `parts` equal pieces; global
    /// axes - (12 x 12).
    fn dynamic_stiffness(&self, omega: f64, parts: usize) -> DMatrix<f64> {
        let compliance = self.stiffness.try_inverse().unwrap();
        let inertia = self.mass * (omega * omega);
        // Forces in a unit that makes the two blocks alike.
        let unit = (inertia.amax() / compliance.amax()).sqrt();
        let mut lever = Matrix6::zeros();
        lever.fixed_view_mut::<3, 3>(0, 3).copy_from(&-Vector3::x().cross_matrix());
        let mut rates = DMatrix::zeros(12, 12);
        rates.view_mut((0, 0), (6, 6)).copy_from(&lever);
        rates.view_mut((0, 6), (6, 6)).copy_from(&(compliance * unit));
        rates.view_mut((6, 0), (6, 6)).copy_from(&(-inertia / unit));
        rates.view_mut((6, 6), (6, 6)).copy_from(&-lever.transpose());
        let transfer = (rates * (self.length / parts as f64)).exp();
        let block = |i: usize, j: usize| Matrix6::from_fn(|r, c| transfer[(6 * i + r, 6 * j + c)]);
        let inverse = block(0, 1).try_inverse().expect("no frequency of the piece with both ends clamped");
        let (start, end) = (inverse * block(0, 0), block(1, 1) * inverse);
        let mut turn = DMatrix::zeros(12, 12);
        (0..4).for_each(|k| turn.view_mut((3 * k, 3 * k), (3, 3)).copy_from(&self.axes));
        let mut local = DMatrix::zeros(12, 12);
        local.view_mut((0, 0), (6, 6)).copy_from(&start);
        local.view_mut((0, 6), (6, 6)).copy_from(&-inverse);
        local.view_mut((6, 0), (6, 6)).copy_from(&(block(1, 0) - end * block(0, 0)));
        local.view_mut((6, 6), (6, 6)).copy_from(&end);
        &turn * local * turn.transpose() * unit
    }
}

/// One half of the tail.
struct Half {
    fin: Member,
    tailplane: Member,
    /// Half the mass of the fairing at the top.
    fairing: Matrix6<f64>,
    /// Motions of the fin: `u_x, u_z, theta_y`, or the other three.
    motions: [usize; 3],
    clamped: bool,
}

impl Half {
    fn new(back: f64, up: f64, symmetric: bool, clamped: bool) -> Self {
        let arm = Vector3::new(AHEAD, 0.0, 0.0).cross_matrix();
        let inertia = Matrix3::from_diagonal(&FAIRING_INERTIA.into()) - FAIRING * arm * arm;
        let mut fairing = Matrix6::identity() * FAIRING;
        fairing.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-FAIRING * arm));
        fairing.fixed_view_mut::<3, 3>(3, 0).copy_from(&(FAIRING * arm));
        fairing.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
        let tip = Vector3::new(-back, HALF_SPAN, up);
        Half {
            fin: Member::new(Vector3::new(0.0, 0.0, HEIGHT), Vector3::y(), FIN, FIN_MASS).half(),
            tailplane: Member::new(tip, -Vector3::x(), TAILPLANE, TAILPLANE_MASS),
            fairing: fairing * 0.5,
            motions: if symmetric { [0, 2, 4] } else { [1, 3, 5] },
            clamped,
        }
    }

    /// Natural frequencies below `omega`: the negative eigenvalues of the dynamic stiffness. Pieces of members are so short that none has a
    /// frequency of its own with its ends clamped, which twice as many pieces show.
    fn count(&self, omega: f64, parts: usize) -> usize {
        let n = 6 * (2 * parts + 1);
        let mut sum = DMatrix::zeros(n, n);
        for (member, first) in [(&self.fin, 0), (&self.tailplane, 6 * parts)] {
            let k = member.dynamic_stiffness(omega, parts);
            for part in 0..parts {
                let mut place = sum.view_mut((first + 6 * part, first + 6 * part), (12, 12));
                place += &k;
            }
        }
        let mut top = sum.view_mut((6 * parts, 6 * parts), (6, 6));
        top -= self.fairing * (omega * omega);
        let is_free = |row: usize| match row / 6 {
            0 if self.clamped => false,
            place if place <= parts => self.motions.contains(&(row % 6)),
            _ => true,
        };
        let rows: Vec<usize> = (0..n).filter(|row| is_free(*row)).collect();
        let picked = DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
            0.5 * (sum[(rows[i], rows[j])] + sum[(rows[j], rows[i])])
        });
        SymmetricEigen::new(picked).eigenvalues.iter().filter(|x| **x < 0.0).count()
    }

    /// The elastic frequency of this number, from 0, rad/s.
    fn frequency(&self, number: usize) -> f64 {
        let wanted = number + 1 + if self.clamped { 0 } else { 3 };
        let (mut low, mut high) = (1.0, 2.0);
        while self.count(high, PARTS) < wanted {
            (low, high) = (high, 2.0 * high);
        }
        assert_eq!(self.count(high, PARTS), self.count(high, 2 * PARTS), "pieces are short enough");
        for _ in 0..26 {
            let middle = 0.5 * (low + high);
            if self.count(middle, PARTS) < wanted { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

const PARTS: usize = 3;

/// A tail straight across, whose tailplane bends in two planes, and one swept and raised, where everything is coupled.
#[test]
fn frequencies_of_symmetric_and_antisymmetric_motions() {
    for (back, up) in [(0.0, 0.0), (1.5, 0.5)] {
        let mesh = tail(back, up, true);
        for support in [Support::Clamped, Support::Free] {
            let set = analyse(&mesh, Configuration::drawing(&mesh), support, 14).unwrap();
            let plane =
                set.planes.iter().position(|plane| plane.normal == 1).expect("the halves are mirror images");
            for (parity, symmetric) in [(Parity::Symmetric, true), (Parity::Antisymmetric, false)] {
                let half = Half::new(back, up, symmetric, support == Support::Clamped);
                let found: Vec<f64> = set
                    .modes
                    .iter()
                    .filter(|mode| mode.parity[plane] == parity)
                    .map(|mode| mode.omega)
                    .collect();
                assert!(found.len() >= 6, "{found:?}");
                for (k, omega) in found.iter().enumerate() {
                    let expected = half.frequency(k);
                    // Fourth order in the wave number: (b h)^4/1000 is 6e-5 for b = 8/L and 16 elements.
                    let what = format!("{support:?}, {parity:?} mode {} swept by {back}", k + 1);
                    assert_near(*omega, expected, 1e-4 * expected, &what);
                }
            }
        }
    }
}
