//! The loaded points of a model with their modal shapes: positions of all are one matrix times `q`, generalised loads the transposed
//! matrix times the forces.

use alloc::vec::Vec;

use crate::curve::Curve;
use crate::dense::Dense;
use crate::math::{Mat3, Vec3, split};
use crate::model::Model;
use crate::polynomial::Polynomial;

/// The loaded points of a model and their modal shapes.
#[derive(Clone, Debug)]
pub(crate) struct LoadMap {
    pub(crate) n_modes: usize,
    pub(crate) n_points: usize,
    pub(crate) slots: Vec<Slot>,
    pub(crate) n_dof: usize,
    /// Displacements of all slots per unit modal amplitude - (n_dof x m).
    pub(crate) displacement: Dense,
    /// Elastic generalised loads from the forces on all slots and from their resultant, `(Phi_S^t, Phi_R^t)`
    /// - (m x (n_dof + 6)).
    pub(crate) projection: Dense,
    /// Second and third order of the displacements of all slots - (n_dof rows).
    pub(crate) curve: Curve,
    /// The same by monomials, for the Jacobian.
    pub(crate) polynomial: Polynomial,
}

/// A loaded point. It has three columns in the map, six when its rotation matters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Slot {
    point: usize,
    pub(super) node_position: Vec3,
    pub(super) node_rotation: Mat3,
    pub(super) offset: Vec3,
    /// Where it is without deformation.
    pub(super) position: Vec3,
    pub(super) rotates: bool,
    /// Whether moments act, and loads in node axes.
    pub(super) moments: bool,
    pub(super) follows: bool,
}

/// What acts on a point, as far as it is known when loads are prepared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Loaded {
    pub(crate) point: usize,
    pub(crate) moments: bool,
    pub(crate) follows: bool,
}

impl LoadMap {
    /// The point of each slot.
    pub(crate) fn points(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.slots.iter().map(|slot| slot.point)
    }

    /// `points`: each point once.
    pub(crate) fn new(model: &Model, points: &[Loaded]) -> Self {
        let m = model.n_modes();
        let mut slots = Vec::with_capacity(points.len());
        // Which point and which of its six components every column is.
        let mut dofs: Vec<(usize, usize)> = Vec::new();
        for &Loaded { point: index, moments, follows } in points {
            let Some(point) = model.carrier(index) else { continue };
            let node_turns = point.phi.iter().any(|phi| split(phi).1 != [0.0; 3]);
            let rotates = node_turns && (moments || follows || point.offset != [0.0; 3]);
            dofs.extend((0..if rotates { 6 } else { 3 }).map(|component| (index, component)));
            slots.push(Slot {
                point: index,
                node_position: point.node_position,
                node_rotation: point.node_rotation,
                offset: point.offset,
                position: point.position,
                rotates,
                moments,
                follows,
            });
        }
        let n_dof = dofs.len();
        let shape = |dof: usize, mode: usize| {
            let (point, component) = dofs.get(dof)?;
            model.carrier(*point)?.phi.get(mode)?.get(*component).copied()
        };
        let rigid = |component: usize, mode: usize| model.phi_r.get(mode)?.get(component).copied();
        let displacement = Dense::new(n_dof, m, |dof, mode| shape(dof, mode).unwrap_or(0.0));
        let projection = Dense::new(m, n_dof + 6, |mode, dof| {
            match dof.checked_sub(n_dof) {
                None => shape(dof, mode),
                Some(component) => rigid(component, mode),
            }
            .unwrap_or(0.0)
        });
        let curve = curve(model, dofs.iter().copied());
        let polynomial = polynomial(model, dofs.iter().copied());
        LoadMap {
            n_modes: m,
            n_points: model.n_points(),
            slots,
            n_dof,
            displacement,
            projection,
            curve,
            polynomial,
        }
    }
}

/// Second and third order of displacements: (point, component).
fn curve(model: &Model, dofs: impl Iterator<Item = (usize, usize)> + Clone) -> Curve {
    let Some(lagrangian) = &model.data().lagrangian else { return Curve::default() };
    let rows = dofs.filter_map(|(point, component)| Some((lagrangian.points.get(point)?, component)));
    Curve::gather(model.n_modes(), rows)
}

/// The same by monomials.
pub(crate) fn polynomial(model: &Model, dofs: impl Iterator<Item = (usize, usize)>) -> Polynomial {
    let Some(lagrangian) = &model.data().lagrangian else { return Polynomial::default() };
    Polynomial::gather(dofs.filter_map(|(point, component)| Some((lagrangian.points.get(point)?, component))))
}

/// Displacements of all points and stations.
pub(crate) fn whole_curve(model: &Model) -> Polynomial {
    polynomial(model, (0..model.n_carriers()).flat_map(|point| (0..6).map(move |k| (point, k))))
}
