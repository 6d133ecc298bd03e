//! The Lagrangian of a reduced model with consistent inertia, and of one on the curved manifold of large deflections
//! (docs/beyond.md).

mod balance;
mod fields;
mod manifold;
mod moments;
mod momentum;
mod monomials;
mod picture;
mod range;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, Matrix6, SymmetricEigen, Vector6};
use rom_runtime::data::{CurveValidityData, LagrangianData, PictureCurveData, PolynomialData};

pub use self::balance::EquilibriumLoads;
use self::balance::Kept;
use self::fields::{Fields, fields};
use self::manifold::{Manifold, modal_stiffness};
use super::modes::Modes;
use crate::assembly::Assembly;
use crate::configuration::Configuration;
use crate::solve::block_ldu::SingularPivot;

/// What is dropped: less than this of the largest linear term, at the range of the amplitudes.
#[derive(Clone, Copy, Debug)]
struct Tolerances {
    fields: f64,
    /// Terms of the second and third order of the coordinates of the fields.
    terms: [f64; 2],
    /// Moments of two fields, over the square of the largest linear term, see [`moments`]; less where a deformed body asks for it.
    moments: f64,
    /// Terms of the second and third order of the displacements of points.
    points: [f64; 2],
}

/// Terms of second order are linear stiffness where a body turns or is loaded in equilibrium, those of third order are felt in large
/// motions alone.
const TOLERANCES: Tolerances =
    Tolerances { fields: 5e-3, terms: [1e-3, 6e-3], moments: 3e-3, points: [1e-3, 6e-3] };
/// Terms that are dropped, but above this part of what is, are kept for the estimate of errors.
const TOLD: f64 = 0.1;
/// Self-stress of less than this in amplitude is dropped.
const STRESS_TOLERANCE: f64 = 3e-3;
/// Modes with terms of third order: the first so many.
const CUBIC_MODES: usize = 10;
/// Largest rotation of a node, rad, and largest displacement over the size of the structure by one mode at its range.
const ROTATION: f64 = 0.4;
const DISPLACEMENT: f64 = 0.2;

/// A Lagrangian could not be had.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LagrangianError {
    /// The material stiffness alone does not hold the structure together.
    #[error("the structure is a mechanism but for its loads ({0}): no manifold of linear strains")]
    Mechanism(#[from] SingularPivot),
    /// The modes move no mass relative to A.
    #[error("the selected modes move no mass relative to the reference node")]
    NoMass,
}

/// A Lagrangian, and what is told of a curved manifold besides.
#[derive(Clone, Debug)]
pub struct Found {
    /// For the model file.
    pub data: LagrangianData,
    /// How the nodes that are drawn bend.
    pub picture: Option<PictureCurveData>,
    /// How far the manifold holds.
    pub validity: Option<CurveValidityData>,
}

/// The Lagrangian about a configuration. `geometric` bends the manifold; without, shapes are linear in the amplitudes and the elastic
/// energy is quadratic. `drawn`: nodes of pictures. `equilibrium`: what acts where the configuration is an equilibrium under loads. `rigid`:
/// `M_RR`. None for a body without modes.
///
/// # Errors
/// See [`LagrangianError`].
#[allow(clippy::too_many_arguments)]
pub fn lagrangian(
    assembly: &Assembly,
    at: &Configuration,
    modes: &Modes,
    places: &[CarriedPlace],
    drawn: &[usize],
    geometric: bool,
    equilibrium: Option<&EquilibriumLoads>,
    rigid: &Matrix6<f64>,
) -> Result<Option<Found>, LagrangianError> {
    if modes.m() == 0 {
        return Ok(None);
    }
    let reduction = Reduction { assembly, at, modes, geometric, equilibrium, rigid, tolerances: TOLERANCES };
    let manifold = reduction.manifold()?;
    let picture = if geometric { picture::picture(&manifold, drawn) } else { None };
    let (data, Told { dropped, points }) = reduction.lagrangian(&manifold, places)?;
    let limits = if geometric { range::limits(&reduction, &manifold, &data, places, rigid) } else { None };
    let validity = limits.map(|limits| CurveValidityData { limits, dropped, points });
    Ok(Some(Found { data, picture, validity }))
}

/// Terms that are dropped and told: of the kinetic coordinates, and of the motion of places.
struct Told {
    dropped: PolynomialData,
    points: Vec<PolynomialData>,
}

/// What a Lagrangian is made from.
struct Reduction<'a> {
    assembly: &'a Assembly,
    at: &'a Configuration,
    modes: &'a Modes,
    geometric: bool,
    equilibrium: Option<&'a EquilibriumLoads>,
    /// `M_RR`.
    rigid: &'a Matrix6<f64>,
    tolerances: Tolerances,
}

impl Reduction<'_> {
    fn manifold(&self) -> Result<Manifold, LagrangianError> {
        let Self { assembly, at, modes, .. } = *self;
        let range = amplitudes(at, modes);
        Ok(if self.geometric {
            Manifold::curved(assembly, at, modes, &range, CUBIC_MODES)?
        } else {
            Manifold::flat(assembly, modes, &range, CUBIC_MODES)
        })
    }

    fn lagrangian(
        &self,
        manifold: &Manifold,
        places: &[CarriedPlace],
    ) -> Result<(LagrangianData, Told), LagrangianError> {
        let Self { assembly, at, modes, geometric, equilibrium, rigid, tolerances } = *self;
        let m = modes.m();
        let range = &manifold.range;
        let fields = fields(assembly, at, manifold, tolerances.fields).ok_or(LagrangianError::NoMass)?;
        let threshold = tolerances.terms.map(|it| it * fields.reference);
        let (curve, dropped) = polynomial(manifold, &fields.coordinates, |_| threshold);
        let dropped_terms = told(manifold, &fields.coordinates.rows(0, m).into_owned(), &|_| threshold);
        let (points, told_of_points) = points(manifold, places, tolerances.points);
        let (fields, curve) = moving(fields, curve, m);
        let n = fields.size.len();
        // Twice the elastic energy of a mode at its range.
        let energy = (modes.omega[0] * range[0]).powi(2);
        let mut stress = self_stress(assembly, at, manifold, energy, geometric);
        let squared: Vec<f64> = modes.omega.iter().map(|w| w * w).collect();
        let mut stiffness = if geometric {
            modal_stiffness(assembly, at, modes)
        } else {
            DMatrix::from_diagonal(&squared.into())
        };
        if let Some(equilibrium) = equilibrium {
            let kept = Kept { places: &points, fields: &fields, coordinates: &curve };
            let work = equilibrium.potential(manifold, places, &kept, &stress.dropped);
            stiffness += work.stiffness(manifold);
            work.add_third_order(manifold, energy, &mut stress);
        }
        let stiffness = rounded(stiffness);
        let linear = (0..m).flat_map(|a| (0..m).map(move |i| (a, i)));
        let mut data = LagrangianData {
            geometric,
            fields: n as u32,
            linear: linear.map(|(a, i)| fields.coordinates[(a, i)] / range[i]).collect(),
            curve,
            first_moment: (0..3).flat_map(|k| fields.first_moment.iter().map(move |s| s[k])).collect(),
            moment_0: fields.moment_0.iter().flatten().copied().collect(),
            moment: moments::all(&fields),
            stiffness: stiffness.transpose().iter().copied().collect(),
            self_stress: stress.constant,
            self_stress_curve: stress.curve,
            points,
            tolerance: tolerances.fields,
            dropped_norm: (fields.left_out + dropped).sqrt() / fields.reference,
            range: range.clone(),
        };
        data.moment = moments::enough(&data, &fields, rigid, tolerances.moments);
        Ok((data, Told { dropped: dropped_terms, points: told_of_points }))
    }
}

/// Of the terms of some rows that are dropped, those that the estimate of errors is told.
fn told(manifold: &Manifold, rows: &DMatrix<f64>, threshold: &dyn Fn(usize) -> [f64; 2]) -> PolynomialData {
    let mut told = polynomial(manifold, rows, |row| threshold(row).map(|it| TOLD * it)).0;
    let kept = polynomial(manifold, rows, threshold).0;
    told.quadratic.retain(|term| !kept.quadratic.contains(term));
    told.cubic.retain(|term| !kept.cubic.contains(term));
    told
}

/// Without the fields whose coordinates have lost all their terms.
fn moving(fields: Fields, mut curve: PolynomialData, linear: usize) -> (Fields, PolynomialData) {
    let moves = |a: u32| {
        (a as usize) < linear
            || curve.quadratic.iter().any(|term| term.0 == a)
            || curve.cubic.iter().any(|term| term.0 == a)
    };
    let kept: Vec<u32> = (0..fields.size.len() as u32).filter(|&a| moves(a)).collect();
    let fields = fields.pick(&kept.iter().map(|&a| a as usize).collect::<Vec<_>>());
    let place = |row: u32| kept.partition_point(|&a| a < row) as u32;
    curve.quadratic.iter_mut().for_each(|term| term.0 = place(term.0));
    curve.cubic.iter_mut().for_each(|term| term.0 = place(term.0));
    (fields, curve)
}

/// Amplitudes of equal elastic energy, at which the first of the modes reaches the limits of rotation or displacement.
fn amplitudes(at: &Configuration, modes: &Modes) -> Vec<f64> {
    let size = at.positions.iter().map(|r| r.norm()).fold(0.0, f64::max);
    let largest = |j: usize| {
        (0..at.positions.len()).fold(0.0_f64, |worst, node| {
            let phi = &modes.at_node(node)[j];
            let (t, theta) = (phi.fixed_rows::<3>(0).norm(), phi.fixed_rows::<3>(3).norm());
            worst.max(t / (DISPLACEMENT * size)).max(theta / ROTATION)
        })
    };
    let energy = (0..modes.m()).map(|j| largest(j) / modes.omega[j]).fold(0.0, f64::max);
    modes.omega.iter().map(|omega| 1.0 / (omega * energy)).collect()
}

/// Terms of second and third order of rows over the scaled monomials, those below the threshold of their row dropped; and the sum of
/// the squares of these.
fn polynomial(
    manifold: &Manifold,
    rows: &DMatrix<f64>,
    threshold: impl Fn(usize) -> [f64; 2],
) -> (PolynomialData, f64) {
    let (mut out, mut dropped) = (PolynomialData::default(), 0.0);
    for row in 0..rows.nrows() {
        for (index, factors) in manifold.monomials.factors.iter().enumerate() {
            let value = rows[(row, index)];
            let [second, third] = threshold(row);
            if factors.len() > 1 && value.abs() < if factors.len() == 2 { second } else { third } {
                dropped += value * value;
                continue;
            }
            let scale: f64 = factors.iter().map(|&i| manifold.range[i]).product();
            match factors[..] {
                [i, j] => out.quadratic.push((row as u32, [i as u32, j as u32], value / scale)),
                [i, j, k] => out.cubic.push((row as u32, [i as u32, j as u32, k as u32], value / scale)),
                _ => {}
            }
        }
    }
    (out, dropped)
}

/// A place by the nodes that carry it, each with the motion `(R, theta)` of the place per motion of the node.
pub type CarriedPlace = Vec<(usize, Matrix6<f64>)>;

/// Second and third order of the motion of places, and what is told of what is dropped of it. Between nodes their rotation vectors are linear in those of the nodes.
fn points(
    manifold: &Manifold,
    places: &[CarriedPlace],
    tolerances: [f64; 2],
) -> (Vec<PolynomialData>, Vec<PolynomialData>) {
    let all = manifold.monomials.len();
    let linear = manifold.monomials.of_order(1);
    let size = |first: usize| {
        let of_place = |place: &CarriedPlace| {
            let motion = linear.clone().map(|index| moved(manifold, place, index));
            motion.map(|x| x.fixed_rows::<3>(first).norm()).fold(0.0, f64::max)
        };
        places.iter().map(of_place).fold(0.0, f64::max)
    };
    let sizes = [size(0), size(3)];
    let of_place = |place: &CarriedPlace| {
        let columns: Vec<Vector6<f64>> = (0..all).map(|index| moved(manifold, place, index)).collect();
        let rows = DMatrix::from_fn(6, all, |row, index| columns[index][row]);
        let threshold = |row: usize| tolerances.map(|it| (it * sizes[row / 3]).max(f64::MIN_POSITIVE));
        (polynomial(manifold, &rows, threshold).0, told(manifold, &rows, &threshold))
    };
    places.iter().map(of_place).unzip()
}

/// Motion of a place in a monomial.
fn moved(manifold: &Manifold, place: &CarriedPlace, index: usize) -> Vector6<f64> {
    place.iter().map(|(node, map)| map * manifold.at_node(*node)[index]).sum()
}

/// Coordinates of the self-stress that the manifold leaves in closed loops.
struct StressCoordinates {
    /// Their constant part, and their polynomials.
    constant: Vec<f64>,
    curve: PolynomialData,
    /// Elastic energy of what is dropped of them beside that of the equilibrium, over the scaled monomials, J.
    dropped: Vec<f64>,
}

/// `energy`: twice the elastic energy of a mode at its range, J.
fn self_stress(
    assembly: &Assembly,
    at: &Configuration,
    manifold: &Manifold,
    energy: f64,
    geometric: bool,
) -> StressCoordinates {
    let all = manifold.monomials.len();
    let none =
        |dropped| StressCoordinates { constant: Vec::new(), curve: PolynomialData::default(), dropped };
    if !geometric {
        return none(vec![0.0; all]);
    }
    let found = manifold.self_stress(assembly, at);
    if found.products.amax() <= STRESS_TOLERANCE * STRESS_TOLERANCE * energy {
        return none(found.with_equilibrium);
    }
    let eigen = SymmetricEigen::new((&found.products + found.products.transpose()) * 0.5);
    let mut kept: Vec<usize> = (0..eigen.eigenvalues.len())
        .filter(|&k| eigen.eigenvalues[k] > STRESS_TOLERANCE * STRESS_TOLERANCE * energy)
        .collect();
    kept.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let vector = |k: usize| {
        let v = eigen.eigenvectors.column(k);
        v * v[v.iamax()].signum()
    };
    let constant = |&k: &usize| {
        let work: f64 = vector(k).iter().zip(&found.with_equilibrium).map(|(v, b)| v * b).sum();
        work / eigen.eigenvalues[k].sqrt()
    };
    let constant: Vec<f64> = kept.iter().map(constant).collect();
    let rows = DMatrix::from_fn(kept.len(), all, |row, index| {
        let k = kept[row];
        eigen.eigenvalues[k].sqrt() * vector(k)[index]
    });
    let (curve, _) = polynomial(manifold, &rows, |_| [1e-3 * STRESS_TOLERANCE * energy.sqrt(); 2]);
    let of_kept = |index: usize| rows.column(index).iter().zip(&constant).map(|(e, c)| e * c).sum::<f64>();
    let dropped = found.with_equilibrium.iter().enumerate().map(|(index, all)| all - of_kept(index));
    StressCoordinates { dropped: dropped.collect(), constant, curve }
}

/// Without what is round-off off the diagonal.
fn rounded(mut k: DMatrix<f64>) -> DMatrix<f64> {
    for i in 0..k.nrows() {
        for j in 0..k.ncols() {
            if i != j && k[(i, j)].abs() < 1e-11 * (k[(i, i)] * k[(j, j)]).sqrt() {
                k[(i, j)] = 0.0;
            }
        }
    }
    k
}
