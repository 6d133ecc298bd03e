//! The constant tensors `c_ilr` and `kgyr_ilrs` (theory (25)): gyroscopic operators projected on the modes.
//!
//! Each Gauss point contributes through the section velocities that the modes give there, `s_l = J phi_S,l` (elastic part)
//! and `a_l = A_RC phi_R,l` (motion of A), and `z_i = s_i + a_i`:
//!
//! ```text
//! c_ilr  += z_i^t (X_r s_l + Y_r a_l)                                  X_r, Y_r: section damping of the unit rate e_r
//! k_ilrs += s_i^t E_rs s_l + theta_i^t Z_rs theta_l + a_i^t R_rs s_l   E, Z, R: section stiffness of the pair e_r, e_s
//! ```
//!
//! No matrix of the size of the structure is formed: chunks of sections are stacked and multiplied, groups of elements at the same time,
//! and summed in a fixed order, so that the threads do not show in the bits.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::{DMatrix, Matrix3, Matrix6, SMatrix, Vector6};
use rayon::prelude::*;
use rom_runtime::data::TensorData;

use super::modes::Modes;
use crate::assembly::{AnyBeam, Assembly};
use crate::configuration::Configuration;
use crate::element::gyroscopic::{SectionStiffness, section_damping, section_stiffness, turning_force};
use crate::element::station::Station;

/// Entries below this fraction of their natural scale are dropped. The modes of a fine mesh carry relative errors of up to
/// 1e-9 from the factorisation; a symmetric structure shows them as entries that should be zero. The smallest entries
/// with a meaning come from the rotary inertia of slender sections, (thickness/length)^2 or about 1e-7.
pub const DROP: f64 = 1e-9;

/// Pairs `r <= s` of velocity components.
const PAIRS: usize = 21;
/// Sections stacked for one product: large enough to be efficient, small enough to stay in cache.
const CHUNK: usize = 64;
/// Elements of a group, and groups summed at a time: enough for many threads, little to keep.
const GROUP: usize = 256;
const GROUPS: usize = 32;

/// Both tensors, dense over modes.
#[derive(Clone, Debug)]
pub struct Tensors {
    m: usize,
    /// `c` by r: rows i, columns l, elastic then rigid - (6 of (m+6) x (m+6)).
    pub c: Vec<DMatrix<f64>>,
    /// `k` by pair (r, s), r <= s in lexical order: both halves added - (21 of (m+6) x m).
    pub k: Vec<DMatrix<f64>>,
}

/// Pairs in the order of [`Tensors::k`].
pub fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|r| (r..6).map(move |s| (r, s)))
}

/// Projects the gyroscopic operators about a configuration on its modes.
pub fn project(assembly: &Assembly, at: &Configuration, modes: &Modes) -> Tensors {
    let mut sum = Accumulator::new(modes);
    let of_group = |beams: &[AnyBeam]| {
        let mut sum = Accumulator::new(modes);
        for beam in beams {
            match beam {
                AnyBeam::Two(b) => sum.add_patch(&b.nodes, &Station::of_beam(b, at)),
                AnyBeam::Three(b) => sum.add_patch(&b.nodes, &Station::of_beam(b, at)),
            }
        }
        sum.flush();
        sum.products
    };
    for beams in assembly.beams.chunks(GROUP * GROUPS) {
        let groups: Vec<Products> = beams.par_chunks(GROUP).map(of_group).collect();
        groups.iter().for_each(|group| sum.products.add(group));
    }
    for lump in &assembly.lumped {
        sum.add_patch(&[lump.node], &[Station::of_mass(lump, at)]);
    }
    sum.finish()
}

/// Sums over sections.
struct Products {
    /// `z^t (X_r s + Y_r a)`, the six r side by side.
    c: DMatrix<f64>,
    /// `s^t E_rs s + theta^t Z_rs theta`, the pairs side by side.
    k_s: DMatrix<f64>,
    /// `A_RC^t R_rs s`.
    k_r: DMatrix<f64>,
}

impl Products {
    fn add(&mut self, other: &Self) {
        self.c += &other.c;
        self.k_s += &other.k_s;
        self.k_r += &other.k_r;
    }
}

/// Rows waiting to be multiplied.
struct Accumulator<'a> {
    modes: &'a Modes,
    m: usize,
    /// Rows of the chunk in use.
    rows: usize,
    turn_rows: usize,
    s: DMatrix<f64>,
    z: DMatrix<f64>,
    /// `X_r s + Y_r a` for the six r side by side.
    damping: DMatrix<f64>,
    /// `E_rs s` for the pairs side by side.
    stiffness: DMatrix<f64>,
    /// Nodal rotations and `Z_rs theta`.
    theta: DMatrix<f64>,
    turning: DMatrix<f64>,
    products: Products,
}

impl<'a> Accumulator<'a> {
    fn new(modes: &'a Modes) -> Self {
        let m = modes.m();
        let rows = 6 * CHUNK;
        Self {
            modes,
            m,
            rows: 0,
            turn_rows: 0,
            s: DMatrix::zeros(rows, m),
            z: DMatrix::zeros(rows, m + 6),
            damping: DMatrix::zeros(rows, 6 * (m + 6)),
            stiffness: DMatrix::zeros(rows, PAIRS * m),
            theta: DMatrix::zeros(rows, m),
            turning: DMatrix::zeros(rows, PAIRS * m),
            products: Products {
                c: DMatrix::zeros(m + 6, 6 * (m + 6)),
                k_s: DMatrix::zeros(m, PAIRS * m),
                k_r: DMatrix::zeros(6, PAIRS * m),
            },
        }
    }

    /// Adds the sections of one element or mass; they share the nodes.
    fn add_patch<const N: usize>(&mut self, nodes: &[usize; N], stations: &[Station<N>]) {
        if self.rows + 6 * stations.len() > self.s.nrows() || self.turn_rows + 3 * N > self.theta.nrows() {
            self.flush();
        }
        let mut turn = [[[Matrix3::zeros(); N]; N]; PAIRS];
        for station in stations {
            let unit_rates: [Vector6<f64>; 6] = std::array::from_fn(|r| station.a_rc.column(r).into_owned());
            self.add_motion(nodes, station);
            self.add_damping(station, &unit_rates);
            self.add_stiffness(station, &unit_rates, &mut turn);
            self.rows += 6;
        }
        self.add_turning(nodes, &turn);
    }

    /// `s` and `z` of one section.
    fn add_motion<const N: usize>(&mut self, nodes: &[usize; N], station: &Station<N>) {
        for l in 0..self.m {
            let s: Vector6<f64> = (0..N).map(|a| station.j[a] * self.modes.at_node(nodes[a])[l]).sum();
            let a = station.a_rc * self.modes.phi_r[l];
            self.s.fixed_view_mut::<6, 1>(self.rows, l).copy_from(&s);
            self.z.fixed_view_mut::<6, 1>(self.rows, l).copy_from(&(s + a));
        }
        self.z.fixed_view_mut::<6, 6>(self.rows, self.m).copy_from(&station.a_rc);
    }

    fn add_damping<const N: usize>(&mut self, station: &Station<N>, rates: &[Vector6<f64>; 6]) {
        let n = self.m + 6;
        for (r, rate) in rates.iter().enumerate() {
            let d = section_damping(&station.mass, rate);
            // X s + Y a = (X - Y) s + Y z, with s = 0 in the rigid columns.
            let x = d.elastic - d.rigid;
            for l in 0..n {
                let z = self.z.fixed_view::<6, 1>(self.rows, l).into_owned();
                let mut force = d.rigid * z;
                if l < self.m {
                    force += x * self.s.fixed_view::<6, 1>(self.rows, l);
                }
                self.damping.fixed_view_mut::<6, 1>(self.rows, r * n + l).copy_from(&force);
            }
        }
    }

    fn add_stiffness<const N: usize>(
        &mut self,
        station: &Station<N>,
        rates: &[Vector6<f64>; 6],
        turn: &mut [[[Matrix3<f64>; N]; N]; PAIRS],
    ) {
        for (p, (r, s)) in pairs().enumerate() {
            let SectionStiffness { elastic, rigid, force } =
                section_stiffness(&station.mass, &rates[r], &rates[s]);
            let (f, _) = crate::element::internal_force::split(&force);
            // Off the diagonal the pair stands for (r, s) and (s, r).
            let both = if r == s { 1.0 } else { 2.0 };
            let elastic = (elastic + turning_force(&f)) * both;
            let rigid = station.a_rc.transpose() * rigid * both;
            for l in 0..self.m {
                let s = self.s.fixed_view::<6, 1>(self.rows, l).into_owned();
                let column = p * self.m + l;
                self.stiffness.fixed_view_mut::<6, 1>(self.rows, column).copy_from(&(elastic * s));
                let mut k_r = self.products.k_r.fixed_view_mut::<6, 1>(0, column);
                k_r += rigid * s;
            }
            for (a, row) in turn[p].iter_mut().enumerate() {
                for (b, block) in row.iter_mut().enumerate() {
                    *block += station.turning(&force, a, b) * both;
                }
            }
        }
    }

    /// Rows of the nodal rotations, once for the sections of a patch.
    fn add_turning<const N: usize>(&mut self, nodes: &[usize; N], turn: &[[[Matrix3<f64>; N]; N]; PAIRS]) {
        for l in 0..self.m {
            let theta: [SMatrix<f64, 3, 1>; N] =
                std::array::from_fn(|a| self.modes.at_node(nodes[a])[l].fixed_rows::<3>(3).into_owned());
            for a in 0..N {
                let row = self.turn_rows + 3 * a;
                self.theta.fixed_view_mut::<3, 1>(row, l).copy_from(&theta[a]);
                for (p, blocks) in turn.iter().enumerate() {
                    let moment: SMatrix<f64, 3, 1> = (0..N).map(|b| blocks[a][b] * theta[b]).sum();
                    self.turning.fixed_view_mut::<3, 1>(row, p * self.m + l).copy_from(&moment);
                }
            }
        }
        self.turn_rows += 3 * N;
    }

    /// Multiplies what is stacked.
    fn flush(&mut self) {
        let (n, t) = (self.rows, self.turn_rows);
        add_product(&mut self.products.c, &self.z, &self.damping, n);
        add_product(&mut self.products.k_s, &self.s, &self.stiffness, n);
        add_product(&mut self.products.k_s, &self.theta, &self.turning, t);
        self.rows = 0;
        self.turn_rows = 0;
    }

    fn finish(mut self) -> Tensors {
        self.flush();
        let m = self.m;
        let Products { c, k_s, k_r } = self.products;
        let c = (0..6).map(|r| c.columns(r * (m + 6), m + 6).into_owned()).collect();
        let k = (0..PAIRS)
            .map(|p| {
                let (k_s, k_r) = (k_s.columns(p * m, m), k_r.columns(p * m, m));
                let mut k = DMatrix::zeros(m + 6, m);
                for (i, phi_r) in self.modes.phi_r.iter().enumerate() {
                    k.row_mut(i).copy_from(&(k_s.row(i) + phi_r.transpose() * k_r));
                }
                k.rows_mut(m, 6).copy_from(&k_r);
                k
            })
            .collect();
        Tensors { m, c, k }
    }
}

/// `sum += a^t b`, over the first `rows` of both.
fn add_product(sum: &mut DMatrix<f64>, a: &DMatrix<f64>, b: &DMatrix<f64>, rows: usize) {
    let (n, m) = sum.shape();
    let a = MatRef::from_column_major_slice(a.as_slice(), a.nrows(), a.ncols()).subrows(0, rows);
    let b = MatRef::from_column_major_slice(b.as_slice(), b.nrows(), b.ncols()).subrows(0, rows);
    let sum = MatMut::from_column_major_slice_mut(sum.as_mut_slice(), n, m);
    matmul(sum, Accum::Add, a.transpose(), b, 1.0, Par::Seq);
}

impl Tensors {
    /// Sparse forms, entries below `drop` of their natural scale left out.
    ///
    /// With modes of unit generalised mass the scale of `c_ilr` is `mu_i mu_l rho_r`: `mu = 1` for an elastic mode, the root
    /// of the diagonal of `M_RR` for a rigid one, `rho = 1` for a rotation and `1/L` for a translation, `L` the radius of
    /// gyration. `k_ilrs` scales with `mu_i rho_r rho_s`. These bound what a Gauss point can contribute, so the quotient
    /// measures cancellation.
    pub fn to_sparse(&self, rr: &Matrix6<f64>, drop: f64) -> (TensorData, TensorData) {
        let m = self.m;
        let mass = rr[(0, 0)].max(f64::MIN_POSITIVE);
        let gyration = (rr.fixed_view::<3, 3>(3, 3).trace() / mass).sqrt();
        let mu = |i: usize| if i < m { 1.0 } else { rr[(i - m, i - m)].sqrt() };
        let rho = |r: usize| if r < 3 { 1.0 / gyration } else { 1.0 };
        let c_entries = (0..m + 6)
            .flat_map(|i| (0..m + 6).flat_map(move |l| (0..6).map(move |r| (i, l, r, self.c[r][(i, l)]))));
        let c = sparse(c_entries, |i, l, r| mu(i) * mu(l) * rho(r), drop, "mu_i mu_l rho_r");
        let k_entries = (0..m + 6).flat_map(|i| {
            (0..m).flat_map(move |l| {
                pairs().enumerate().map(move |(p, (r, s))| (i, l, 6 * r + s, self.k[p][(i, l)]))
            })
        });
        let k = sparse(k_entries, |i, _, rs| mu(i) * rho(rs / 6) * rho(rs % 6), drop, "mu_i rho_r rho_s");
        (c, k)
    }
}

fn sparse(
    entries: impl Iterator<Item = (usize, usize, usize, f64)>,
    scale: impl Fn(usize, usize, usize) -> f64,
    drop: f64,
    scale_name: &str,
) -> TensorData {
    let mut out = TensorData {
        i: Vec::new(),
        l: Vec::new(),
        r: Vec::new(),
        value: Vec::new(),
        threshold: drop,
        scale: format!(
            "{scale_name}: mu = 1 (elastic) or sqrt(M_RR_ii), rho = 1 (rotation) or 1/radius of gyration"
        ),
        dropped_norm: 0.0,
        dropped_count: 0,
    };
    let mut square = 0.0;
    for (i, l, r, value) in entries {
        if value.abs() > drop * scale(i, l, r) {
            out.i.push(i as u32);
            out.l.push(l as u32);
            out.r.push(r as u32);
            out.value.push(value);
        } else if value != 0.0 {
            square += value * value;
            out.dropped_count += 1;
        }
    }
    out.dropped_norm = square.sqrt();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every entry a hundredth above or below what is kept, in turn.
    #[test]
    fn entries_are_kept_by_their_natural_scale() {
        let (m, drop) = (2, 1e-6);
        let (mass, inertia) = (400.0_f64, [2500.0, 3500.0, 4000.0]);
        let rr = Matrix6::from_diagonal(&Vector6::new(mass, mass, mass, inertia[0], inertia[1], inertia[2]));
        // trace of the inertia / mass = 25 m^2
        let gyration = 5.0_f64;
        let root = |i: usize| {
            [1.0, 1.0, 20.0, 20.0, 20.0, 50.0, inertia[1].sqrt(), inertia[2].sqrt()].get(i).copied().unwrap()
        };
        // Lengths in the denominator: one for each translation.
        let translations = |rates: &[usize]| rates.iter().filter(|&&r| r < 3).count() as i32;
        let entry =
            |place: usize, scale: f64| drop * scale * if place.is_multiple_of(2) { 1.01 } else { 0.99 };
        let c = (0..6).map(|r| {
            DMatrix::from_fn(m + 6, m + 6, |i, l| {
                entry(i + l + r, root(i) * root(l) / gyration.powi(translations(&[r])))
            })
        });
        let k = pairs().map(|(r, s)| {
            DMatrix::from_fn(m + 6, m, |i, l| {
                -entry(i + l + r + s, root(i) / gyration.powi(translations(&[r, s])))
            })
        });
        let tensors = Tensors { m, c: c.collect(), k: k.collect() };
        let (c, k) = tensors.to_sparse(&rr, drop);
        let places = |data: &TensorData| -> Vec<[u32; 3]> {
            data.i.iter().zip(&data.l).zip(&data.r).map(|((i, l), r)| [*i, *l, *r]).collect()
        };
        let even = |sum: usize| sum.is_multiple_of(2);
        let all = (0..m + 6).flat_map(|i| (0..m + 6).flat_map(move |l| (0..6).map(move |r| (i, l, r))));
        let kept: Vec<_> =
            all.filter(|(i, l, r)| even(i + l + r)).map(|(i, l, r)| [i as u32, l as u32, r as u32]).collect();
        assert_eq!(places(&c), kept);
        let all = (0..m + 6).flat_map(|i| (0..m).flat_map(move |l| pairs().map(move |(r, s)| (i, l, r, s))));
        let kept: Vec<_> = all
            .filter(|(i, l, r, s)| even(i + l + r + s))
            .map(|(i, l, r, s)| [i as u32, l as u32, (6 * r + s) as u32])
            .collect();
        assert_eq!(places(&k), kept);
        assert_eq!(c.value.len() + c.dropped_count as usize, 8 * 8 * 6);
        assert_eq!(k.value.len() + k.dropped_count as usize, 8 * 2 * 21);
    }
}
