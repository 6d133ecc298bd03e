//! The immutable model.

use alloc::{string::String, sync::Arc, vec::Vec};

use crate::data::{ModelData, PointData, PolynomialData, StationSet};
use crate::dense::Dense;
use crate::error::ModelError;
use crate::four::Four;
use crate::gravity::Weight;
use crate::lagrangian::Lagrangian;
use crate::loads::LoadCase;
use crate::math::{Mat3, Vec3, Vec6, add, matrix, mul, normalised};
use crate::method::{Method, Relative};
use crate::polynomial::Polynomial;
use crate::prescribed::Held;
use crate::tensor::Contraction;
use crate::validate;

/// A reduced model ready to be marched: the data of the file, checked, and the constants derived from it.
///
/// Immutable; share it between simulations and threads with [`alloc::sync::Arc`].
#[derive(Clone, Debug)]
pub struct Model {
    pub(crate) data: ModelData,
    pub(crate) contraction: Contraction,
    pub(crate) elastic: Vec<ElasticMode>,
    /// The same by fours, without those left over.
    pub(crate) elastic_fours: Vec<ElasticMode<Four>>,
    /// `Phi_R`, a column per elastic mode - (m).
    pub(crate) phi_r: Vec<Vec6>,
    /// `M_RR` - (6 x 6), symmetric.
    pub(crate) rigid_mass: [Vec6; 6],
    /// `M_RR^-1` - (6 x 6), symmetric.
    pub(crate) rigid_mass_inverse: [Vec6; 6],
    pub(crate) centre_of_mass: Vec3,
    pub(crate) points: Vec<Point>,
    /// Sections of members in their own axes: line after line, then block of stations after block.
    pub(crate) stations: Vec<Point>,
    /// Shapes relative to frame A of a mean-axes model; none where the equations are written in A themselves.
    pub(crate) relative: Option<Relative>,
    pub(crate) method: Method,
    pub(crate) weight: Weight,
    /// Damping off the diagonal, where there is any - (m x m).
    pub(crate) damping: Option<Dense>,
    /// `L = M_RS Phi_S` of a clamped structure, a column per mode; empty where it flies, whose modes carry no momentum - (m).
    pub(crate) participation: Vec<Vec6>,
    /// Elastic rows with frame A held.
    pub(crate) held: Option<Held>,
    /// The model with all couplings, where this one is a simplification of it.
    pub(crate) full: Option<Arc<Model>>,
    /// Consistent inertia; none where mass matrix and elastic force are the paper's.
    pub(crate) lagrangian: Option<Lagrangian>,
}

/// Constants of the uncoupled oscillator of one mode, or of four.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ElasticMode<T = f64> {
    pub(crate) mass: T,
    pub(crate) inverse_mass: T,
    /// `2 zeta omega m`.
    pub(crate) damping: T,
    /// `omega^2 m`.
    pub(crate) stiffness: T,
}

impl ElasticMode<Four> {
    /// Of modes side by side.
    fn of(modes: &[ElasticMode; 4]) -> Self {
        ElasticMode {
            mass: modes.map(|mode| mode.mass),
            inverse_mass: modes.map(|mode| mode.inverse_mass),
            damping: modes.map(|mode| mode.damping),
            stiffness: modes.map(|mode| mode.stiffness),
        }
    }
}

/// A named point.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    pub(crate) node_position: Vec3,
    /// `Q0`, node frame to A, as a unit quaternion and as a matrix.
    pub(crate) node_quaternion: [f64; 4],
    pub(crate) node_rotation: Mat3,
    pub(crate) offset: Vec3,
    /// Position in A without deformation, m.
    pub(crate) position: Vec3,
    /// Translation and rotation of the node per unit modal amplitude - (m).
    pub(crate) phi: Vec<Vec6>,
    /// Second and third order of the same - (6 rows).
    pub(crate) curve: Polynomial,
}

impl Model {
    /// Checks the data and derives the constants of the step.
    ///
    /// # Errors
    /// The first thing found wrong: shapes, indices, order, ranges, non-finite numbers, an indefinite mass matrix.
    pub fn new(data: ModelData) -> Result<Self, ModelError> {
        validate::model(&data)?;
        let m = data.modes.omega.len();
        let rigid_mass = symmetric_matrix(&data.rigid.mass_matrix)?;
        let rigid_mass_inverse = invert_positive_definite(&rigid_mass)?;
        let phi_r = columns(&data.modes.phi_r, m);
        let elastic = elastic_modes(&data);
        Ok(Model {
            contraction: Contraction::new(m, &data.c, &data.k),
            elastic_fours: elastic.as_chunks::<4>().0.iter().map(ElasticMode::of).collect(),
            elastic,
            weight: Weight::new(&data, &phi_r),
            damping: data.damping.as_ref().map(|damping| {
                Dense::new(m, m, |i, j| damping.coupling.get(i * m + j).copied().unwrap_or(0.0))
            }),
            held: Held::new(&phi_r, &rigid_mass_inverse, &data.modes.mass),
            phi_r,
            rigid_mass_inverse,
            rigid_mass,
            centre_of_mass: data.rigid.centre_of_mass,
            points: points(&data),
            stations: stations(&data),
            participation: data
                .clamped
                .as_ref()
                .map_or(Vec::new(), |clamped| columns(&clamped.participation, m)),
            lagrangian: Lagrangian::new(&data),
            relative: None,
            full: None,
            method: Method::Rom,
            data,
        })
    }

    /// The contents of the model file.
    pub fn data(&self) -> &ModelData {
        &self.data
    }

    /// Whether the structure is clamped at the reference node: frame A is held, or moved, in every run.
    pub fn is_clamped(&self) -> bool {
        self.data.clamped.is_some()
    }

    /// How the equations are simplified; [`Method::Rom`] unless made by [`Model::with_method`].
    pub fn method(&self) -> Method {
        self.method
    }

    /// Acceleration of free fall in G, m/s^2, under which the model is marched; zero in weightlessness.
    pub fn gravity(&self) -> [f64; 3] {
        self.data.gravity.as_ref().map_or([0.0; 3], |gravity| gravity.acceleration)
    }

    /// Attitude of A at the equilibrium: unit quaternion, scalar first, components in A to components in G.
    pub fn initial_attitude(&self) -> [f64; 4] {
        self.data.trim.as_ref().map_or([1.0, 0.0, 0.0, 0.0], |trim| normalised(trim.attitude))
    }

    /// Whether the mass matrix follows the deformation and, with it, whether the elastic energy is that of large deflections:
    /// `(inertia, elastic)`, (false, false) being the paper's model.
    pub fn consistent(&self) -> (bool, bool) {
        self.data.lagrangian.as_ref().map_or((false, false), |it| (true, it.geometric))
    }

    /// Kinetic coordinates of a model with consistent inertia, terms of second and third order in them, and entries of their
    /// moments; none without.
    pub fn lagrangian_size(&self) -> Option<[usize; 3]> {
        self.lagrangian.as_ref().map(Lagrangian::size)
    }

    /// Number of elastic modes `m`. The reduced model has `m + 6` degrees of freedom.
    pub fn n_modes(&self) -> usize {
        self.elastic.len()
    }

    /// Number of named points.
    pub fn n_points(&self) -> usize {
        self.points.len()
    }

    /// Number of named points and stations.
    pub(crate) fn n_carriers(&self) -> usize {
        self.points.len() + self.stations.len()
    }

    /// A named point, or a station counted on from there.
    pub(crate) fn carrier(&self, index: usize) -> Option<&Point> {
        self.points.get(index).or_else(|| self.stations.get(index.checked_sub(self.points.len())?))
    }

    /// Index for [`Model::carrier`] of the first station of a line.
    pub(crate) fn first_station(&self, line: usize) -> usize {
        let before = self.data.lines.iter().take(line).map(|line| line.stations.len());
        self.points.len() + before.sum::<usize>()
    }

    /// Index for [`Model::carrier`] of the first station of a block.
    pub(crate) fn first_of_block(&self, block: usize) -> usize {
        let before = self.data.stations.iter().take(block).map(|block| block.sections.len());
        self.first_station(usize::MAX) + before.sum::<usize>()
    }

    /// A station of a block.
    pub(crate) fn station(&self, block: usize, station: usize) -> Option<&Point> {
        let n = self.data.stations.get(block)?.sections.len();
        if station < n { self.carrier(self.first_of_block(block) + station) } else { None }
    }

    /// Index of a block of stations.
    ///
    /// # Errors
    /// [`ModelError::Unknown`], which lists the names there are.
    pub fn station_block(&self, name: &str) -> Result<usize, ModelError> {
        let blocks = &self.data.stations;
        let found = blocks.iter().position(|block| block.name == name);
        found.ok_or_else(|| unknown("block of stations", name, blocks.iter().map(|block| &block.name)))
    }

    /// Index of a named point.
    ///
    /// # Errors
    /// [`ModelError::Unknown`], which lists the names there are.
    pub fn point(&self, name: &str) -> Result<usize, ModelError> {
        self.data
            .points
            .iter()
            .position(|point| point.name == name)
            .ok_or_else(|| unknown("point", name, self.data.points.iter().map(|point| &point.name)))
    }

    /// A load case of the structure file.
    ///
    /// # Errors
    /// [`ModelError::Unknown`], which lists the names there are.
    pub fn load_case(&self, name: &str) -> Result<&LoadCase, ModelError> {
        self.data
            .load_cases
            .iter()
            .find(|case| case.name == name)
            .ok_or_else(|| unknown("load case", name, self.data.load_cases.iter().map(|case| &case.name)))
    }

    /// `M_RR^-1` about the origin of A: 1/kg, 1/(kg m), 1/(kg m^2) - (6 x 6), rows and columns v then w.
    pub fn rigid_mass_inverse(&self) -> &[[f64; 6]; 6] {
        &self.rigid_mass_inverse
    }

    /// Linear momentum of every mode per unit modal rate, in A, kg m - (m): what is round-off in a free-free mode is zero.
    pub fn modal_momentum(&self) -> &[[f64; 3]] {
        self.weight.momentum()
    }

    /// Tensor entries stored in the file, and values held for the step (padding of the row blocks included).
    pub fn tensor_fill(&self) -> (usize, usize) {
        self.contraction.fill()
    }
}

impl Point {
    /// Stations in their section axes, at offsets from the axis where there are any.
    fn of_stations<'a>(set: &'a StationSet, offset: &'a [f64], m: usize) -> impl Iterator<Item = Point> + 'a {
        let each = set.position.as_chunks::<3>().0.iter().zip(set.rotation.as_chunks::<4>().0);
        each.enumerate().map(move |(n, (&position, &rotation))| {
            let shapes = |of: &[f64]| columns::<3>(of.get(3 * m * n..).unwrap_or(&[]), m);
            let (translation, rotations) = (shapes(&set.phi_translation), shapes(&set.phi_rotation));
            let node_quaternion = normalised(rotation);
            let node_rotation = matrix(node_quaternion);
            let offset = offset.as_chunks::<3>().0.get(n).copied().unwrap_or([0.0; 3]);
            Point {
                node_position: position,
                node_quaternion,
                node_rotation,
                offset,
                position: add(position, mul(&node_rotation, offset)),
                phi: translation.iter().zip(&rotations).map(|(&t, &r)| crate::math::join(t, r)).collect(),
                curve: Polynomial::default(),
            }
        })
    }

    fn new(data: &PointData, curve: Option<&PolynomialData>, m: usize) -> Self {
        let translation = columns::<3>(&data.phi_translation, m);
        let rotation = columns::<3>(&data.phi_rotation, m);
        let node_quaternion = normalised(data.node_rotation);
        let node_rotation = matrix(node_quaternion);
        Point {
            node_position: data.node_position,
            node_quaternion,
            node_rotation,
            offset: data.offset,
            position: add(data.node_position, mul(&node_rotation, data.offset)),
            phi: translation.iter().zip(&rotation).map(|(&t, &r)| crate::math::join(t, r)).collect(),
            curve: curve_of(curve),
        }
    }
}

fn curve_of(data: Option<&PolynomialData>) -> Polynomial {
    data.map_or_else(Polynomial::default, |curve| Polynomial::new(6, curve))
}

fn points(data: &ModelData) -> Vec<Point> {
    let m = data.modes.omega.len();
    let curve = |index: usize| data.lagrangian.as_ref().and_then(|it| it.points.get(index));
    data.points.iter().enumerate().map(|(index, point)| Point::new(point, curve(index), m)).collect()
}

/// Stations of the lines, then those of the blocks, one after another.
fn stations(data: &ModelData) -> Vec<Point> {
    let m = data.modes.omega.len();
    let lines = data.lines.iter().map(|line| (&line.stations, &[][..]));
    let blocks = data.stations.iter().map(|block| (&block.sections, block.offset.as_slice()));
    let all = lines.chain(blocks).flat_map(|(set, offset)| Point::of_stations(set, offset, m)).enumerate();
    let curves = data.lagrangian.as_ref().map_or(&[][..], |it| &it.points);
    let curve = |index: usize| curves.get(data.points.len() + index);
    all.map(|(index, point)| Point { curve: curve_of(curve(index)), ..point }).collect()
}

fn elastic_modes(data: &ModelData) -> Vec<ElasticMode> {
    let modes = &data.modes;
    modes
        .omega
        .iter()
        .zip(&modes.mass)
        .zip(&modes.damping_ratio)
        .map(|((omega, &mass), ratio)| ElasticMode {
            mass,
            inverse_mass: 1.0 / mass,
            damping: 2.0 * ratio * omega * mass,
            stiffness: omega * omega * mass,
        })
        .collect()
}

/// Columns of a row-major (ROWS x m) array.
fn columns<const ROWS: usize>(row_major: &[f64], m: usize) -> Vec<[f64; ROWS]> {
    (0..m)
        .map(|column| core::array::from_fn(|row| row_major.get(row * m + column).copied().unwrap_or(0.0)))
        .collect()
}

pub(crate) fn unknown<'a>(
    what: &'static str,
    name: &str,
    available: impl Iterator<Item = &'a String>,
) -> ModelError {
    ModelError::Unknown { what, name: name.into(), available: list(available) }
}

/// Names in a row, or that there are none.
pub(crate) fn list<S: AsRef<str>>(names: impl Iterator<Item = S>) -> String {
    let mut list = String::new();
    for name in names {
        if !list.is_empty() {
            list.push_str(", ");
        }
        list.push_str(name.as_ref());
    }
    if list.is_empty() {
        list.push_str("none");
    }
    list
}

/// `M_RR` from its row-major form; refused unless symmetric to 1e-9 of its diagonal.
fn symmetric_matrix(row_major: &[f64]) -> Result<[Vec6; 6], ModelError> {
    let at = |i: usize, j: usize| row_major.get(6 * i + j).copied().unwrap_or(0.0);
    for row in 0..6 {
        for column in 0..row {
            let scale = libm::sqrt((at(row, row) * at(column, column)).abs());
            if (at(row, column) - at(column, row)).abs() > 1e-9 * scale {
                return Err(ModelError::NotPositiveDefinite {
                    what: "mass_matrix",
                    problem: "its two triangles differ",
                    row,
                });
            }
        }
    }
    Ok(core::array::from_fn(|i| core::array::from_fn(|j| 0.5 * (at(i, j) + at(j, i)))))
}

/// Inverse by Cholesky factors of the matrix scaled to unit diagonal (its entries are kg, kg m and kg m^2).
#[allow(clippy::needless_range_loop)] // triangular index ranges
pub(crate) fn invert_positive_definite(a: &[Vec6; 6]) -> Result<[Vec6; 6], ModelError> {
    let indefinite = |row| ModelError::NotPositiveDefinite {
        what: "mass_matrix",
        problem: "a pivot is not positive (a body needs mass, and inertia about every axis)",
        row,
    };
    let mut scale = [0.0; 6];
    for row in 0..6 {
        // Spelt so that a NaN fails too.
        let positive = a[row][row] > 0.0;
        if !positive {
            return Err(indefinite(row));
        }
        scale[row] = 1.0 / libm::sqrt(a[row][row]);
    }
    // L and then W = L^-1, lower triangular: (S A S)^-1 = W^t W.
    let mut l = [[0.0; 6]; 6];
    let mut w = [[0.0; 6]; 6];
    for j in 0..6 {
        for i in j..6 {
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = scale[i] * a[i][j] * scale[j] - known;
            if i == j {
                let positive = rest > 1e-13;
                if !positive {
                    return Err(indefinite(j));
                }
                l[j][j] = libm::sqrt(rest);
            } else {
                l[i][j] = rest / l[j][j];
            }
        }
    }
    for i in 0..6 {
        w[i][i] = 1.0 / l[i][i];
        for j in 0..i {
            let sum: f64 = (j..i).map(|k| l[i][k] * w[k][j]).sum();
            w[i][j] = -sum / l[i][i];
        }
    }
    let entry = |i: usize, j: usize| -> f64 {
        let product: f64 = (i.max(j)..6).map(|k| w[k][i] * w[k][j]).sum();
        scale[i] * product * scale[j]
    };
    Ok(core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j))))
}
