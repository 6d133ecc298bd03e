//! How far the curved manifold of a model holds, mode by mode: its inertia, displacements and elastic energy against those of the structure
//! bent to the same strains, at amplitudes up to where they differ by a tenth (docs/validity.md).

use nalgebra::{DMatrix, DVector, Dyn, Matrix6, Vector3, Vector6};
use num_dual::Dual3_64;
use rayon::prelude::*;
use rom_runtime::LIMIT_LEVELS as LEVELS;
use rom_runtime::data::{LagrangianData, PolynomialData};

use super::manifold::{coefficient, material_stiffness};
use super::momentum::Momentum;
use super::{CarriedPlace, Manifold, Reduction};
use crate::assembly::{AnyBeam, Assembly};
use crate::configuration::Configuration;
use crate::element::beam::Beam;
use crate::element::internal_force::{split, stack, strain_maps};
use crate::element::kinematics;
use crate::math::so3::{MatrixFunction, exp_quaternion, log_quaternion};
use crate::solve::block_ldu::{Factor, Symbolic};

/// Amplitudes looked at, over the ranges: the first, and the ratio of each to the one before. The last is five times the range.
const FIRST: f64 = 0.02;
const RATIO: f64 = 1.5;
const MOST: usize = 15;
/// Corrections of the shape until its strains are those that are asked for: each squares the error, and the first shape is right to third
/// order. It is found when a correction frees less than this part of the elastic energy: a thousandth of the displacements.
const CORRECTIONS: usize = 8;
const CLOSE: f64 = 1e-8;

/// Amplitudes at which what a model leaves out reaches each of [`LEVELS`] of what it keeps - (m x 3). `places`: those whose displacements
/// count. `rigid`: `M_RR`.
pub(super) fn limits(
    reduction: &Reduction<'_>,
    manifold: &Manifold,
    data: &LagrangianData,
    places: &[CarriedPlace],
    rigid: &Matrix6<f64>,
) -> Option<Vec<f64>> {
    let m = reduction.modes.m();
    let model = Momentum::new(data, rigid);
    let rest = vec![0.0; m];
    let columns: Vec<DVector<f64>> = (0..m + 6)
        .map(|k| {
            let mut u = DVector::zeros(m + 6);
            u[k] = 1.0;
            model.at(&rest, &u)
        })
        .collect();
    let mass = DMatrix::from_columns(&columns).cholesky()?;
    let symbolic = std::sync::Arc::new(Symbolic::new(reduction.assembly.pattern.clone()));
    let of_mode = |mode: usize| {
        let line = Line::new(reduction, manifold, mode);
        let factor = Factor::new(symbolic.clone());
        Comparison { line, factor, data, places, model: &model, mass: &mass }.limits()
    };
    Some((0..m).into_par_iter().flat_map_iter(of_mode).collect())
}

/// The structure along one amplitude.
struct Line<'a> {
    reduction: &'a Reduction<'a>,
    manifold: &'a Manifold,
    mode: usize,
    /// Strains of the stiffness points of every element, by powers of the amplitude over its range.
    strains: Vec<Vec<[Vector6<f64>; 4]>>,
}

/// The structure bent to the strains of an amplitude.
struct Shape {
    at: Configuration,
    /// Rate per unit of the amplitude over its range - (n).
    tangent: Vec<Vector6<f64>>,
    /// Elastic energy over that of the strains asked for, J.
    energy: f64,
}

impl<'a> Line<'a> {
    fn new(reduction: &'a Reduction<'a>, manifold: &'a Manifold, mode: usize) -> Self {
        fn strains<const N: usize>(line: &Line<'_>, beam: &Beam<N>) -> Vec<[Vector6<f64>; 4]> {
            let state = line.reduction.at.of(beam);
            let path = beam.nodes.map(|node| line.manifold.path(node, &[(line.mode, 1.0)]));
            let at_point = |point| {
                let series: [Dual3_64; 6] = kinematics::strain(beam, &state, &path, point);
                std::array::from_fn(|order| match order {
                    0 => Vector6::from(series.map(|s| s.re)),
                    _ => Vector6::from(series.map(|s| coefficient(&s, order))),
                })
            };
            beam.stiffness_points().iter().map(at_point).collect()
        }
        let mut line = Self { reduction, manifold, mode, strains: Vec::new() };
        line.strains = (reduction.assembly.beams.iter())
            .map(|beam| match beam {
                AnyBeam::Two(b) => strains(&line, b),
                AnyBeam::Three(b) => strains(&line, b),
            })
            .collect();
        line
    }

    /// Motion of a node at an amplitude, and its rate, by the polynomials of the manifold along the mode.
    fn polynomial(&self, node: usize, s: f64) -> Vector6<f64> {
        let path = self.manifold.path(node, &[(self.mode, 1.0)]);
        Vector6::from(path.map(|x| s * (x.v1 + s * (x.v2 / 2.0 + s * x.v3 / 6.0))))
    }

    /// The structure with the strains that the manifold has at `s` times the range, to third order in it: those linear in the amplitude, and
    /// the self-stress of loops. None where it is not found.
    fn shape(&self, s: f64, factor: &mut Factor) -> Option<Shape> {
        let Reduction { assembly, at, .. } = *self.reduction;
        let n = at.positions.len();
        let mut now = at.clone();
        for node in 0..n {
            let (t, theta) = split(&self.polynomial(node, s));
            now.positions[node] += t;
            now.rotations[node] = at.rotations[node] * exp_quaternion(&theta);
        }
        let asked = |e: &[Vector6<f64>; 4]| e[0] + (e[1] + (e[2] + e[3] * s) * s) * s;
        let rate = |e: &[Vector6<f64>; 4]| e[1] + (e[2] * 2.0 + e[3] * (3.0 * s)) * s;
        let energy = self.force(&now, |_, e| e[1] * s).1;
        let mut freed = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            factor.refactor(&material_stiffness(assembly, &now)).ok()?;
            if freed <= CLOSE * energy {
                let mut tangent = self.force(&now, |_, e| rate(e)).0;
                factor.solve(&mut tangent);
                let energies = [self.force(&now, |strain, _| strain).1, self.force(&now, |_, e| asked(e)).1];
                return Some(Shape { at: now, tangent, energy: energies[0] - energies[1] });
            }
            let force = self.force(&now, |strain, e| asked(e) - strain).0;
            let mut x = force.clone();
            factor.solve(&mut x);
            freed = 0.5 * x.iter().zip(&force).map(|(x, f)| x.dot(f)).sum::<f64>();
            if !freed.is_finite() {
                return None;
            }
            for (node, unknown) in assembly.unknown.iter().enumerate() {
                let Some(row) = unknown else { continue };
                let (t, theta) = split(&x[*row]);
                now.positions[node] += t;
                now.rotations[node] *= exp_quaternion(&theta);
            }
        }
        None
    }

    /// `B^t S e` over the unknowns and `1/2 e^t S e` of strains made from those of a configuration and the coefficients.
    fn force(
        &self,
        now: &Configuration,
        strain: impl Fn(Vector6<f64>, &[Vector6<f64>; 4]) -> Vector6<f64>,
    ) -> (Vec<Vector6<f64>>, f64) {
        fn add<const N: usize>(
            assembly: &Assembly,
            beam: &Beam<N>,
            now: &Configuration,
            coefficients: &[[Vector6<f64>; 4]],
            strain: &impl Fn(Vector6<f64>, &[Vector6<f64>; 4]) -> Vector6<f64>,
            out: &mut (Vec<Vector6<f64>>, f64),
        ) {
            let state = now.of(beam);
            let rest = [[0.0; 6]; N];
            let points = beam.stiffness_points().iter().zip(strain_maps(beam, &state));
            for ((point, maps), coefficients) in points.zip(coefficients) {
                let found = Vector6::from(kinematics::strain(beam, &state, &rest, point));
                let e = strain(found, coefficients);
                let stress = point.stiffness * e * point.weight;
                out.1 += 0.5 * e.dot(&stress);
                for (map, node) in maps.iter().zip(beam.nodes) {
                    if let Some(row) = assembly.unknown[node] {
                        out.0[row] += map.tr_mul(&stress);
                    }
                }
            }
        }
        let assembly = self.reduction.assembly;
        let mut out = (vec![Vector6::zeros(); assembly.n_blocks()], 0.0);
        for (beam, coefficients) in assembly.beams.iter().zip(&self.strains) {
            match beam {
                AnyBeam::Two(b) => add(assembly, b, now, coefficients, &strain, &mut out),
                AnyBeam::Three(b) => add(assembly, b, now, coefficients, &strain, &mut out),
            }
        }
        out
    }

    /// Rates of the nodes per unit of amplitude `k` over its range, by the polynomials of the manifold at `s` - (n).
    fn tangent(&self, k: usize, s: f64) -> Vec<Vector6<f64>> {
        let (monomials, assembly) = (&self.manifold.monomials, self.reduction.assembly);
        let line = [(self.mode, 1.0), (k, 1.0)];
        let mut out = vec![Vector6::zeros(); assembly.n_blocks()];
        // Of the products that have k once: with the mode itself none, once, or twice.
        let terms: Vec<(usize, f64)> = (1..=3)
            .flat_map(|order| monomials.along(&line, order))
            .filter(|(index, _)| monomials.factors[*index].iter().filter(|j| **j == k).count() == 1)
            .map(|(index, _)| (index, s.powi(monomials.factors[index].len() as i32 - 1)))
            .collect();
        for (node, unknown) in assembly.unknown.iter().enumerate() {
            let Some(row) = unknown else { continue };
            let coefficients = self.manifold.at_node(node);
            let rate: Vector6<f64> = terms.iter().map(|&(index, factor)| coefficients[index] * factor).sum();
            let ((t, theta_rate), (_, theta)) = (split(&rate), split(&self.polynomial(node, s)));
            out[*row] = stack(&t, &(MatrixFunction::tangential(&theta).matrix() * theta_rate));
        }
        out
    }
}

/// The model beside the structure along one amplitude.
struct Comparison<'a> {
    line: Line<'a>,
    factor: Factor,
    data: &'a LagrangianData,
    places: &'a [CarriedPlace],
    model: &'a Momentum<'a>,
    /// Of the model undeformed, in the amplitudes and the true velocity of A.
    mass: &'a nalgebra::Cholesky<f64, Dyn>,
}

impl Comparison<'_> {
    /// Where the share left out first reaches the levels: between the amplitudes looked at it goes with a power of the amplitude, below the
    /// first with the square. Where the structure is not found beyond some amplitude, or nothing is reached, the last one is the limit.
    fn limits(mut self) -> [f64; 3] {
        let range = self.line.manifold.range[self.line.mode];
        let (mut s, mut found) = (FIRST, Vec::<(f64, f64)>::new());
        for _ in 0..MOST {
            let Some(share) = self.left_out(s).filter(|share| share.is_finite()) else { break };
            found.push((s, share.max(f64::MIN_POSITIVE)));
            if share > LEVELS[2] {
                break;
            }
            s *= RATIO;
        }
        let last = found.last().map_or(FIRST, |it| it.0);
        LEVELS.map(|level| {
            let at = match found.iter().position(|(_, share)| *share >= level) {
                None => last,
                Some(0) => found[0].0 * (level / found[0].1).sqrt(),
                Some(k) => {
                    let ((a, low), (b, high)) = (found[k - 1], found[k]);
                    a * (b / a).powf((level / low).ln() / (high / low).ln())
                }
            };
            range * at
        })
    }

    /// The largest share that the model leaves out at `s` times the range: of the inertia forces as the mode is accelerated, in the mass
    /// matrix; of the displacements of the places; of the elastic energy.
    fn left_out(&mut self, s: f64) -> Option<f64> {
        let shape = self.line.shape(s, &mut self.factor)?;
        let energy = self.line.force(self.line.reduction.at, |_, e| e[1] * s).1;
        let elastic = shape.energy.abs() / energy;
        Some(self.inertia(s, &shape).max(self.displacement(s, &shape)).max(elastic))
    }

    fn inertia(&self, s: f64, shape: &Shape) -> f64 {
        let Line { reduction, manifold, mode, .. } = self.line;
        let Reduction { assembly, modes, .. } = *reduction;
        let (m, range) = (modes.m(), &manifold.range);
        let mass = assembly.mass(&shape.at);
        // The acceleration of the free mode: of the shape relative to A, and of A.
        let beta = modes.phi_r[mode] * range[mode];
        let mut force = vec![Vector6::zeros(); shape.tangent.len()];
        mass.ss.multiply(&shape.tangent, &mut force);
        for (force, sr) in force.iter_mut().zip(&mass.sr) {
            *force += sr * beta;
        }
        let rigid: Vector6<f64> =
            mass.sr.iter().zip(&shape.tangent).map(|(sr, t)| sr.tr_mul(t)).sum::<Vector6<f64>>()
                + mass.rr * beta;
        let work = |t: &[Vector6<f64>]| t.iter().zip(&force).map(|(t, f)| t.dot(f)).sum::<f64>();
        let (mut q, mut u) = (vec![0.0; m], DVector::zeros(m + 6));
        q[mode] = s * range[mode];
        u[mode] = range[mode];
        u.fixed_rows_mut::<6>(m).copy_from(&beta);
        let kept = self.model.at(&q, &u);
        let mut difference = kept.clone();
        for k in 0..m {
            let exact = if k == mode { work(&shape.tangent) } else { work(&self.line.tangent(k, s)) };
            difference[k] -= exact / range[k];
        }
        let mut rows = difference.fixed_rows_mut::<6>(m);
        rows -= rigid;
        let length = |force: &DVector<f64>| force.dot(&self.mass.solve(force)).max(0.0).sqrt();
        length(&difference) / length(&kept)
    }

    /// Worst error of a place over the largest displacement of any.
    fn displacement(&self, s: f64, shape: &Shape) -> f64 {
        let Line { reduction, manifold, mode, .. } = &self.line;
        let (at, range) = (reduction.at, manifold.range[*mode]);
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for (place, curve) in self.places.iter().zip(&self.data.points) {
            let moved = |motion: &dyn Fn(usize) -> Vector6<f64>| -> Vector3<f64> {
                split(&place.iter().map(|(node, map)| map * motion(*node)).sum::<Vector6<f64>>()).0
            };
            let exact = moved(&|node| {
                let turn = at.rotations[node].inverse() * shape.at.rotations[node];
                stack(&(shape.at.positions[node] - at.positions[node]), &log_quaternion(&turn))
            });
            let linear = moved(&|node| manifold.at_node(node)[*mode] * s);
            let kept = linear + along(curve, *mode as u32, s * range);
            worst = worst.max((exact - kept).norm());
            largest = largest.max(exact.norm());
        }
        if largest > 0.0 { worst / largest } else { 0.0 }
    }
}

/// First three rows of a polynomial where one amplitude alone is not zero.
fn along(curve: &PolynomialData, mode: u32, q: f64) -> Vector3<f64> {
    let mut out = Vector3::zeros();
    for (row, factors, value) in &curve.quadratic {
        if *row < 3 && *factors == [mode; 2] {
            out[*row as usize] += value * q.powi(2);
        }
    }
    for (row, factors, value) in &curve.cubic {
        if *row < 3 && *factors == [mode; 3] {
            out[*row as usize] += value * q.powi(3);
        }
    }
    out
}
