//! The mass of the body as polynomials of the amplitudes, and its compression into few orthonormal fields (docs/beyond.md).
//!
//! A section of mass matrix `[[m, -m c~], [m c~, J]]` is its position and the three directors of its triad, with the Gram matrix
//! `[[m, m c^t], [m c, E]]`, `E = tr(J)/2 1 - J`: four vectors whose scalar products are the kinetic energy of the section,
//! `2 T = G_ab u_a . u_b`, `u_0 = R_dot + v + w x R`, `u_k = d_k_dot + w x d_k`.

use nalgebra::{DMatrix, Matrix4, Matrix6, SymmetricEigen, Vector3};
use num_dual::Dual3_64;

use super::manifold::{Manifold, coefficient};
use crate::assembly::{AnyBeam, Assembly};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::kinematics::{Quaternion, add, constant, exp, multiply, rotate, section};
use crate::math::so3::scalar_first;

/// Position and directors of a section, as rows of twelve numbers.
const VECTORS: usize = 12;

/// A section's share of the mass: Gram matrix, `X_0`, and the coefficients of `X` - (monomials x 12).
struct Cloud<'a> {
    gram: Matrix4<f64>,
    origin: [f64; VECTORS],
    terms: &'a [f64],
}

/// The fields and what the kinetic energy needs of them.
#[derive(Clone, Debug)]
pub(super) struct Fields {
    /// `y_a` over the scaled monomials - (n x monomials).
    pub(super) coordinates: DMatrix<f64>,
    /// Size of every `y_a` at the range of the amplitudes - (n).
    pub(super) size: Vec<f64>,
    /// Largest rate of every `y_a` by one mode at the range of the amplitudes, each with the same kinetic energy, over that at which the
    /// mode of the largest range moves by its range - (n).
    pub(super) rate: Vec<f64>,
    /// Size of the largest linear term.
    pub(super) reference: f64,
    /// Squared size of the fields left out.
    pub(super) left_out: f64,
    /// `S_a` - (n).
    pub(super) first_moment: Vec<Vector3<f64>>,
    /// First moment of what every scaled monomial moves, whatever fields are kept - (monomials).
    pub(super) first_moment_of: Vec<Vector3<f64>>,
    /// `P_a0`, by rows - (n).
    pub(super) moment_0: Vec<[f64; 9]>,
    /// `P_ab`, by rows - (n x n).
    pub(super) moment: Vec<[f64; 9]>,
}

impl Fields {
    /// Some of them, in ascending order.
    pub(super) fn pick(&self, kept: &[usize]) -> Fields {
        let n = self.size.len();
        Fields {
            coordinates: self.coordinates.select_rows(kept),
            size: kept.iter().map(|&a| self.size[a]).collect(),
            rate: kept.iter().map(|&a| self.rate[a]).collect(),
            reference: self.reference,
            left_out: self.left_out,
            first_moment: kept.iter().map(|&a| self.first_moment[a]).collect(),
            first_moment_of: self.first_moment_of.clone(),
            moment_0: kept.iter().map(|&a| self.moment_0[a]).collect(),
            moment: kept.iter().flat_map(|&a| kept.iter().map(move |&b| self.moment[a * n + b])).collect(),
        }
    }
}

/// Fields that carry all but `tolerance` of what the largest mode moves at the range of the amplitudes. None where the modes have no
/// mass.
pub(super) fn fields(
    assembly: &Assembly,
    at: &Configuration,
    manifold: &Manifold,
    tolerance: f64,
) -> Option<Fields> {
    let all = manifold.monomials.len();
    let mut products = DMatrix::<f64>::zeros(all, all);
    visit(assembly, at, manifold, &mut |cloud| {
        let weighted: Vec<f64> =
            cloud.terms.chunks_exact(VECTORS).flat_map(|x| times(&cloud.gram, x)).collect();
        for (i, x) in cloud.terms.chunks_exact(VECTORS).enumerate() {
            for (j, y) in weighted.chunks_exact(VECTORS).enumerate().skip(i) {
                products[(i, j)] += x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
            }
        }
    });
    products.fill_lower_triangle_with_upper_triangle();
    let Basis { weights, coordinates, size, reference, left_out } =
        basis(&products, manifold.monomials.of_order(1).len(), tolerance)?;
    let n = weights.nrows();
    let mut out = Fields {
        rate: rates(manifold, &coordinates),
        coordinates,
        size,
        reference,
        left_out,
        first_moment: vec![Vector3::zeros(); n],
        first_moment_of: vec![Vector3::zeros(); all],
        moment_0: vec![[0.0; 9]; n],
        moment: vec![[0.0; 9]; n * n],
    };
    visit(assembly, at, manifold, &mut |cloud| {
        let fields = &weights * DMatrix::from_row_slice(all, VECTORS, cloud.terms);
        let fields: Vec<[f64; VECTORS]> =
            fields.row_iter().map(|row| std::array::from_fn(|k| row[k])).collect();
        for (sum, terms) in out.first_moment_of.iter_mut().zip(cloud.terms.chunks_exact(VECTORS)) {
            *sum += Vector3::from_column_slice(&times(&cloud.gram, terms)[..3]);
        }
        let origin = times(&cloud.gram, &cloud.origin);
        let weighted: Vec<[f64; VECTORS]> = fields.iter().map(|f| times(&cloud.gram, f)).collect();
        for (a, field) in fields.iter().enumerate() {
            out.first_moment[a] += Vector3::from_column_slice(&weighted[a][..3]);
            accumulate(&mut out.moment_0[a], field, &origin);
            for (b, other) in weighted.iter().enumerate() {
                accumulate(&mut out.moment[a * n + b], field, other);
            }
        }
    });
    Some(out)
}

/// Largest rates of coordinates, see [`Fields::rate`].
fn rates(manifold: &Manifold, coordinates: &DMatrix<f64>) -> Vec<f64> {
    let largest = manifold.range.iter().fold(0.0_f64, |most, range| most.max(*range));
    // The largest derivative of a scaled monomial by an amplitude.
    let steepest = |factors: &[usize]| {
        let by = |i: &usize| factors.iter().filter(|j| *j == i).count() as f64 * largest / manifold.range[*i];
        factors.iter().map(by).fold(0.0, f64::max)
    };
    let steepest: Vec<f64> = manifold.monomials.factors.iter().map(|factors| steepest(factors)).collect();
    let of_row = |a| {
        let terms = coordinates.row(a).into_iter().zip(&steepest);
        terms.map(|(y, by)| y.abs() * by).fold(0.0, f64::max)
    };
    (0..coordinates.nrows()).map(of_row).collect()
}

/// Orthonormal combinations of the monomials' fields.
struct Basis {
    /// Fields over the monomials - (n x monomials).
    weights: DMatrix<f64>,
    coordinates: DMatrix<f64>,
    size: Vec<f64>,
    reference: f64,
    left_out: f64,
}

/// First the linear fields in order (Gram and Schmidt), then the principal fields of what the others leave.
fn basis(products: &DMatrix<f64>, m: usize, tolerance: f64) -> Option<Basis> {
    let all = products.nrows();
    let linear = products.view((0, 0), (m, m)).into_owned();
    let lower = linear.clone().cholesky()?.l();
    let inverse = lower.clone().try_inverse()?;
    let reference = linear.diagonal().max().sqrt();
    // Coordinates of all monomials in the linear fields, and what is left of the products.
    let projected = &inverse * products.rows(0, m);
    let rest = (all > m).then(|| {
        let coupling = projected.columns(m, all - m);
        products.view((m, m), (all - m, all - m)) - coupling.transpose() * coupling
    });
    let eigen = rest.map(|rest| SymmetricEigen::new((&rest + rest.transpose()) * 0.5));
    let mut kept: Vec<(f64, usize)> = Vec::new();
    let mut left_out = 0.0;
    if let Some(eigen) = &eigen {
        let threshold = (tolerance * reference).powi(2);
        for (index, &value) in eigen.eigenvalues.iter().enumerate() {
            if value > threshold { kept.push((value, index)) } else { left_out += value.max(0.0) }
        }
        kept.sort_by(|a, b| b.0.total_cmp(&a.0));
    }
    let n = m + kept.len();
    let (mut weights, mut coordinates) = (DMatrix::zeros(n, all), DMatrix::zeros(n, all));
    weights.view_mut((0, 0), (m, m)).copy_from(&inverse);
    coordinates.rows_mut(0, m).copy_from(&projected);
    // What is round-off there.
    for a in 0..m {
        coordinates.row_mut(a).columns_mut(0, a).fill(0.0);
    }
    let mut size: Vec<f64> = (0..m).map(|a| coordinates.row(a).columns(0, m).amax()).collect();
    if let Some(eigen) = &eigen {
        for (row, &(value, index)) in kept.iter().enumerate() {
            let vector = eigen.eigenvectors.column(index);
            // The sign is the solver's: the largest entry is made positive.
            let sign = vector[vector.iamax()].signum();
            let root = value.sqrt();
            let unit = vector.transpose() * (sign / root);
            let back = -(&unit * projected.columns(m, all - m).transpose()) * &inverse;
            weights.view_mut((m + row, 0), (1, m)).copy_from(&back);
            weights.view_mut((m + row, m), (1, all - m)).copy_from(&unit);
            coordinates.view_mut((m + row, m), (1, all - m)).copy_from(&(vector.transpose() * (sign * root)));
            size.push(root);
        }
    }
    Some(Basis { weights, coordinates, size, reference, left_out })
}

/// `G X`, vector by vector.
fn times(gram: &Matrix4<f64>, x: &[f64]) -> [f64; VECTORS] {
    std::array::from_fn(|at| (0..4).map(|b| gram[(at / 3, b)] * x[3 * b + at % 3]).sum())
}

/// Adds `sum_c a_c b_c^t`.
fn accumulate(sum: &mut [f64; 9], a: &[f64; VECTORS], b: &[f64; VECTORS]) {
    for (a, b) in a.chunks_exact(3).zip(b.chunks_exact(3)) {
        for (at, sum) in sum.iter_mut().enumerate() {
            *sum += a[at / 3] * b[at % 3];
        }
    }
}

/// Calls `call` for all inertia sections and masses.
fn visit(assembly: &Assembly, at: &Configuration, manifold: &Manifold, call: &mut dyn FnMut(Cloud<'_>)) {
    for beam in &assembly.beams {
        match beam {
            AnyBeam::Two(b) => visit_beam(b, at, manifold, call),
            AnyBeam::Three(b) => visit_beam(b, at, manifold, call),
        }
    }
    for lump in &assembly.lumped {
        let position = at.positions[lump.node];
        let q0 = scalar_first(&at.rotations[lump.node]).map(Dual3_64::from);
        let series = |line: &[(usize, f64)]| {
            let [x, y, z, a, b, c] = manifold.path(lump.node, line);
            vectors(add(constant(&position), [x, y, z]), multiply(q0, exp([a, b, c])))
        };
        emit(manifold, &lump.mass, series, call);
    }
}

fn visit_beam<const N: usize>(
    beam: &Beam<N>,
    at: &Configuration,
    manifold: &Manifold,
    call: &mut dyn FnMut(Cloud<'_>),
) {
    let state = at.of(beam);
    for point in beam.inertia_points() {
        let series = |line: &[(usize, f64)]| {
            let path = beam.nodes.map(|node| manifold.path(node, line));
            let section = section(beam, &state, &path, &point.shape);
            vectors(section.position, section.rotation)
        };
        emit(manifold, &(point.mass * point.weight), series, call);
    }
}

/// Position and directors.
fn vectors(position: [Dual3_64; 3], rotation: Quaternion<Dual3_64>) -> [Dual3_64; VECTORS] {
    let directors = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| rotate(rotation, constant(&axis)));
    std::array::from_fn(|at| if at < 3 { position[at] } else { directors[at / 3 - 1][at % 3] })
}

/// The polynomials of one section from its series along the lines.
fn emit(
    manifold: &Manifold,
    mass: &Matrix6<f64>,
    series: impl Fn(&[(usize, f64)]) -> [Dual3_64; VECTORS],
    call: &mut dyn FnMut(Cloud<'_>),
) {
    let monomials = &manifold.monomials;
    let along: Vec<_> = monomials.lines.iter().map(|line| series(line)).collect();
    let origin = series(&[]).map(|x| x.re);
    let mut terms = vec![0.0; monomials.len() * VECTORS];
    for order in 1..=3 {
        if monomials.of_order(order).is_empty() {
            continue;
        }
        let values: Vec<f64> = along.iter().flatten().map(|x| coefficient(x, order)).collect();
        monomials.polarise(order, VECTORS, &values, &mut terms);
    }
    call(Cloud { gram: gram(mass), origin, terms: &terms });
}

/// `[[m, m c^t], [m c, E]]` from `[[m, -m c~], [m c~, J]]`.
fn gram(mass: &Matrix6<f64>) -> Matrix4<f64> {
    let m = mass[(0, 0)];
    let moment = Vector3::new(mass[(5, 1)], mass[(3, 2)], mass[(4, 0)]);
    let j = mass.fixed_view::<3, 3>(3, 3);
    let mut gram = Matrix4::zeros();
    gram[(0, 0)] = m;
    for i in 0..3 {
        gram[(0, i + 1)] = moment[i];
        gram[(i + 1, 0)] = moment[i];
        for k in 0..3 {
            let trace = if i == k { 0.5 * j.trace() } else { 0.0 };
            gram[(i + 1, k + 1)] = trace - 0.5 * (j[(i, k)] + j[(k, i)]);
        }
    }
    gram
}
