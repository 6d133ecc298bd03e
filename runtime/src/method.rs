//! The simpler methods of theory section 5, made from the same model file: mean axes and the rigid body.
//!
//! Both are again a [`Model`] and run behind the same calls. The mean-axes method is the reduced model with the origin
//! moved to the centre of mass, the absolute shapes of the free-free modes instead of those relative to frame A, and no
//! gyroscopic coupling but the rigid body's own:
//!
//! ```text
//! p_ddot_i + 2 zeta omega p_dot_i + omega_i^2 p_i = phi_i^t Q        M_RR beta_dot + C_RR(beta) beta = Q_R   about the CM
//! ```
//!
//! What is read from it is still about frame A on the reference node: the translation and rotation of that node in the
//! modes are taken off the displacements, `r_G` and `v_G` are those of the node, `w_G` that of the rigid body.

use alloc::{string::String, sync::Arc, vec, vec::Vec};
use core::fmt;
use core::str::FromStr;

use crate::data::{
    ClampedData, CutData, GravityData, LineData, ModelData, ModesData, PictureData, PointData, StationSet,
    StationsData, SummationData, TensorData, TrimData,
};
use crate::error::ModelError;
use crate::math::{Vec3, Vec6, add, cross, matrix, mul, mul_t, split, sub};
use crate::model::Model;

/// How the equations of a model are simplified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// The reduced model: all couplings of theory section 4.
    #[default]
    Rom,
    /// Oscillators and a rigid body, coupled only by the loads.
    MeanAxes,
    /// The rigid body alone.
    Rigid,
}

impl Method {
    /// All of them.
    pub const ALL: [Method; 3] = [Method::Rom, Method::MeanAxes, Method::Rigid];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Method::Rom => "rom",
            Method::MeanAxes => "mean-axes",
            Method::Rigid => "rigid",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL.into_iter().find(|method| method.name() == name).ok_or(UnknownMethod)
    }
}

/// The name is not one of a method of the runtime.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of: rom, mean-axes, rigid")]
pub struct UnknownMethod;

/// What a mean-axes model needs to speak of frame A.
#[derive(Clone, Debug)]
pub(crate) struct Relative {
    /// Origin of A from the centre of mass at the equilibrium, m.
    pub(crate) origin: Vec3,
    /// Motion of the reference node in the modes - (m).
    pub(crate) phi_r: Vec<Vec6>,
    /// Shapes of the points relative to A - (points of m).
    pub(crate) phi: Vec<Vec<Vec6>>,
}

impl Model {
    /// The same body by a simpler method.
    ///
    /// # Errors
    /// [`ModelError::Method`] when this model is itself a simplified one: what was left out cannot be had back.
    pub fn with_method(&self, method: Method) -> Result<Model, ModelError> {
        if method == self.method {
            return Ok(self.clone());
        }
        let mut model = match method {
            Method::Rom => return Err(ModelError::Method { from: self.method.name(), to: method.name() }),
            Method::Rigid if self.method == Method::MeanAxes => {
                return Err(ModelError::Method { from: self.method.name(), to: method.name() });
            }
            Method::Rigid => Model::new(rigid(self.data()))?,
            Method::MeanAxes if self.is_clamped() => return Err(ModelError::Clamped { to: method.name() }),
            Method::MeanAxes => {
                let mut model = Model::new(mean_axes(self))?;
                model.relative = Some(Relative {
                    origin: self.centre_of_mass.map(|x| -x),
                    phi_r: self.phi_r.clone(),
                    phi: self.points.iter().map(|point| point.phi.clone()).collect(),
                });
                model
            }
        };
        model.method = method;
        model.full = Some(Arc::new(self.clone()));
        Ok(model)
    }
}

/// The rigid rows of a model.
fn rigid(data: &ModelData) -> ModelData {
    let m = data.modes.omega.len() as u32;
    let rigid_entry = |e: usize| data.c.i[e] >= m && data.c.l[e] >= m;
    let kept: Vec<usize> = (0..data.c.value.len()).filter(|&e| rigid_entry(e)).collect();
    let c = TensorData {
        i: kept.iter().map(|&e| data.c.i[e] - m).collect(),
        l: kept.iter().map(|&e| data.c.l[e] - m).collect(),
        r: kept.iter().map(|&e| data.c.r[e]).collect(),
        value: kept.iter().map(|&e| data.c.value[e]).collect(),
        ..empty_tensor(&data.c)
    };
    let points = data.points.iter().map(|point| PointData {
        phi_translation: vec![],
        phi_rotation: vec![],
        ..point.clone()
    });
    ModelData {
        modes: ModesData {
            number: vec![],
            omega: vec![],
            mass: vec![],
            damping_ratio: vec![],
            phi_r: vec![],
            first_moment: vec![],
            kinetic_share: vec![],
            next_omega: data.modes.omega.first().copied(),
        },
        c,
        k: empty_tensor(&data.k),
        points: points.collect(),
        lines: data.lines.iter().map(rigid_line).collect(),
        stations: data.stations.iter().map(rigid_block).collect(),
        cuts: data.cuts.iter().map(|cut| rigid_cut(cut, data.modes.omega.len())).collect(),
        trim: data.trim.as_ref().map(|trim| TrimData { elastic_force: vec![], ..trim.clone() }),
        gravity: of_rigid_parts(data),
        residual: None,
        validity: None,
        selection: None,
        lagrangian: None,
        picture_curve: None,
        damping: None,
        clamped: data.clamped.as_ref().map(|_| ClampedData { participation: vec![] }),
        picture: data.picture.as_ref().map(|p| PictureData { phi_translation: vec![], ..p.clone() }),
        ..data.clone()
    }
}

/// The mean-axes equations as data: origin on the centre of mass, absolute shapes, no coupling.
fn mean_axes(model: &Model) -> ModelData {
    let data = model.data();
    let m = data.modes.omega.len();
    let centre = model.centre_of_mass;
    let mut rigid = data.rigid.clone();
    let mass = about_centre(&model.rigid_mass, centre);
    rigid.mass_matrix = mass.iter().flatten().copied().collect();
    rigid.centre_of_mass = [0.0; 3];
    rigid.initial_position = add(rigid.initial_position, mul(&matrix(model.initial_attitude()), centre));
    let points = data.points.iter().zip(&model.points).map(|(data, point)| {
        let shapes: Vec<Vec6> = point
            .phi
            .iter()
            .zip(&model.phi_r)
            .map(|(phi, phi_r)| absolute(phi, phi_r, point.node_position, &point.node_rotation))
            .collect();
        let rows = |first: usize| {
            (first..first + 3).flat_map(|k| shapes.iter().map(move |phi| phi[k])).collect::<Vec<f64>>()
        };
        PointData {
            node_position: sub(data.node_position, centre),
            phi_translation: rows(0),
            phi_rotation: rows(3),
            ..data.clone()
        }
    });
    ModelData {
        points: points.collect(),
        lines: data.lines.iter().map(|line| absolute_line(line, model)).collect(),
        stations: data.stations.iter().map(|block| absolute_block(block, model)).collect(),
        cuts: data.cuts.iter().map(|cut| CutData { summation: None, ..cut.clone() }).collect(),
        modes: ModesData { phi_r: vec![0.0; 6 * m], first_moment: vec![0.0; 3 * m], ..data.modes.clone() },
        c: rigid_gyroscopic(&mass, m as u32, &data.c),
        k: empty_tensor(&data.k),
        gravity: of_rigid_parts(data),
        validity: None,
        selection: None,
        lagrangian: None,
        picture_curve: None,
        rigid,
        ..data.clone()
    }
}

/// Loads, weight and inertia of the rigid body alone, summed.
fn rigid_cut(cut: &CutData, m: usize) -> CutData {
    let columns = |values: &[f64], width: usize| -> Vec<f64> {
        values.chunks_exact((m + 6) * width).flat_map(|row| &row[m * width..]).copied().collect()
    };
    let summation = cut.summation.as_ref().map(|sum| SummationData {
        inertia: columns(&sum.inertia, 1),
        c: columns(&sum.c, 6),
        damping: vec![],
        k: vec![],
        gravity: vec![],
        ..sum.clone()
    });
    CutData { modal: vec![], modal_rate: vec![], summation, ..cut.clone() }
}

fn rigid_line(line: &LineData) -> LineData {
    LineData { stations: rigid_stations(&line.stations), ..line.clone() }
}

fn rigid_block(block: &StationsData) -> StationsData {
    StationsData { sections: rigid_stations(&block.sections), ..block.clone() }
}

fn rigid_stations(set: &StationSet) -> StationSet {
    let (position, rotation) = (set.position.clone(), set.rotation.clone());
    StationSet { position, rotation, ..StationSet::default() }
}

fn absolute_block(block: &StationsData, model: &Model) -> StationsData {
    StationsData { sections: absolute_stations(&block.sections, model), ..block.clone() }
}

/// A line about the centre of mass, with absolute shapes.
fn absolute_line(line: &LineData, model: &Model) -> LineData {
    LineData { stations: absolute_stations(&line.stations, model), ..line.clone() }
}

fn absolute_stations(set: &StationSet, model: &Model) -> StationSet {
    let m = model.n_modes();
    let mut out = set.clone();
    let each = set.position.as_chunks::<3>().0.iter().zip(set.rotation.as_chunks::<4>().0);
    for (n, (position, rotation)) in each.enumerate() {
        let turn = matrix(*rotation);
        for (j, phi_r) in model.phi_r.iter().enumerate() {
            let at = |k: usize| (3 * n + k) * m + j;
            let shape = |values: &[f64]| [0, 1, 2].map(|k| values[at(k)]);
            let phi = crate::math::join(shape(&set.phi_translation), shape(&set.phi_rotation));
            let (t, theta) = split(&absolute(&phi, phi_r, *position, &turn));
            for k in 0..3 {
                out.phi_translation[at(k)] = t[k];
                out.phi_rotation[at(k)] = theta[k];
            }
        }
        let moved = sub(*position, model.centre_of_mass);
        out.position[3 * n..3 * n + 3].copy_from_slice(&moved);
    }
    out
}

/// Gravity on the centre of mass alone: it does no work in modes of no momentum, but for the turning of masses beside the axes.
fn of_rigid_parts(data: &ModelData) -> Option<GravityData> {
    data.gravity.as_ref().map(|gravity| GravityData { second_moment: vec![], ..gravity.clone() })
}

/// Shape of a node in space: relative to A plus the motion of A; rotation in the node frame.
fn absolute(phi: &Vec6, phi_r: &Vec6, position: Vec3, node_rotation: &crate::math::Mat3) -> Vec6 {
    let ((t, theta), (v, w)) = (split(phi), split(phi_r));
    crate::math::join(add(t, add(v, cross(w, position))), add(theta, mul_t(node_rotation, w)))
}

/// `M_RR` about the centre of mass: `T^t M T` with `v_A = v_C + c x w`.
fn about_centre(mass: &[Vec6; 6], centre: Vec3) -> [Vec6; 6] {
    let column = |k: usize| -> Vec6 {
        let unit = core::array::from_fn(|i| f64::from(u8::from(i == k)));
        let (v, w) = split(&unit);
        let beta_a = crate::math::join(add(v, cross(centre, w)), w);
        let (p, h) = split(&crate::math::mul6_symmetric(mass, &beta_a));
        // Momenta about the centre: h_C = h_A - c x p.
        crate::math::join(p, sub(h, cross(centre, p)))
    };
    let columns: [Vec6; 6] = core::array::from_fn(column);
    core::array::from_fn(|i| core::array::from_fn(|j| 0.5 * (columns[j][i] + columns[i][j])))
}

/// `C_RR` of a rigid body as entries of c: rows `w x p_v` and `w x p_w + v x p_v`, `p = M beta`.
fn rigid_gyroscopic(mass: &[Vec6; 6], m: u32, like: &TensorData) -> TensorData {
    let mut out = empty_tensor(like);
    for i in 0..6 {
        for l in 0..6 {
            let momentum: Vec6 = core::array::from_fn(|row| mass[row][l]);
            let (p, h) = split(&momentum);
            for r in 0..6 {
                let axis = core::array::from_fn(|k| f64::from(u8::from(k == r % 3)));
                let (force, moment) =
                    if r < 3 { ([0.0; 3], cross(axis, p)) } else { (cross(axis, p), cross(axis, h)) };
                let value = crate::math::join(force, moment)[i];
                if value != 0.0 {
                    out.i.push(m + i as u32);
                    out.l.push(m + l as u32);
                    out.r.push(r as u32);
                    out.value.push(value);
                }
            }
        }
    }
    out
}

fn empty_tensor(like: &TensorData) -> TensorData {
    TensorData {
        i: vec![],
        l: vec![],
        r: vec![],
        value: vec![],
        threshold: like.threshold,
        scale: String::clone(&like.scale),
        dropped_norm: 0.0,
        dropped_count: 0,
    }
}
