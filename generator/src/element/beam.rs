//! One beam element: what does not change while it moves.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::rotation_field::{RotationField, SectionRotation};
use super::shape::{Shape, gauss};

/// Section stiffness and stress-free strains at a Gauss point.
#[derive(Clone, Copy, Debug)]
pub struct StiffnessPoint<const N: usize> {
    /// Shape functions.
    pub shape: Shape<N>,
    /// Integration weight times length, m.
    pub weight: f64,
    /// Section stiffness `S` - (6 x 6).
    pub stiffness: Matrix6<f64>,
    /// `C0 R0'` of the drawing, subtracted from the force strain, 1.
    pub gamma0: Vector3<f64>,
    /// Curvature of the drawing, subtracted from the moment strain, 1/m.
    pub kappa0: Vector3<f64>,
    /// Retardation time `tau` of the strains, s.
    pub retardation: f64,
}

/// Section mass at a Gauss point.
#[derive(Clone, Copy, Debug)]
pub struct InertiaPoint<const N: usize> {
    /// Shape functions.
    pub shape: Shape<N>,
    /// Integration weight times length for the block `M_SS`, m.
    pub weight: f64,
    /// Section mass `Mcs` - (6 x 6).
    pub mass: Matrix6<f64>,
}

/// An element with `N` nodes (2 or 3).
#[derive(Clone, Debug)]
pub struct Beam<const N: usize> {
    /// Node indices.
    pub nodes: [usize; N],
    /// Section frames `E` at the nodes (node frame from section frame).
    pub frames: [Matrix3<f64>; N],
    /// From the nodes to the element's ends, node frame, m, where rigid links join them.
    pub levers: Option<[Vector3<f64>; N]>,
    /// Arc length, m.
    pub length: f64,
    stiffness_points: [StiffnessPoint<N>; 2],
    inertia_points: [InertiaPoint<N>; 3],
}

/// Positions of an element's ends in A (its nodes, but for levers) and its section triads `C^{AB} = Q E` there.
#[derive(Clone, Copy, Debug)]
pub struct BeamState<const N: usize> {
    /// Positions in A, m.
    pub positions: [Vector3<f64>; N],
    /// Section triads in A.
    pub triads: [Matrix3<f64>; N],
}

/// Section properties at the two ends of an element: linear between.
#[derive(Clone, Copy, Debug)]
pub struct EndSections<'a> {
    /// Stiffness at start and end.
    pub stiffness: [&'a Matrix6<f64>; 2],
    /// Mass at start and end.
    pub mass: [&'a Matrix6<f64>; 2],
}

impl<const N: usize> Beam<N> {
    /// Stiffness points: one fewer than nodes (no shear locking). Inertia points: one more than that.
    const STIFFNESS_POINTS: usize = N - 1;
    const INERTIA_POINTS: usize = N;

    /// From its drawing: positions of its ends, which are its nodes, section frames, arc length and end sections.
    pub fn new(
        nodes: [usize; N],
        positions: [Vector3<f64>; N],
        frames: [Matrix3<f64>; N],
        length: f64,
        sections: EndSections<'_>,
    ) -> Self {
        let drawing = BeamState { positions, triads: frames };
        let field = RotationField::new(&frames);
        let between = |ends: [&Matrix6<f64>; 2], x: f64| ends[0] * (1.0 - x) + ends[1] * x;
        let stiffness_at = |k: usize| {
            let (x, w) = gauss(Self::STIFFNESS_POINTS)[k.min(Self::STIFFNESS_POINTS - 1)];
            let shape = Shape::at(x, length);
            let section = field.at(&shape);
            StiffnessPoint {
                shape,
                weight: w * length,
                stiffness: between(sections.stiffness, x),
                gamma0: section.triad.transpose() * drawing.slope(&shape),
                kappa0: section.curvature,
                retardation: 0.0,
            }
        };
        let inertia_at = |k: usize| {
            let (x, w) = gauss(Self::INERTIA_POINTS)[k.min(Self::INERTIA_POINTS - 1)];
            InertiaPoint { shape: Shape::at(x, length), weight: w * length, mass: between(sections.mass, x) }
        };
        Self {
            nodes,
            frames,
            levers: None,
            length,
            stiffness_points: [stiffness_at(0), stiffness_at(1)],
            inertia_points: [inertia_at(0), inertia_at(1), inertia_at(2)],
        }
    }

    /// With its ends at levers from its nodes; without any where all are zero.
    pub fn with_levers(self, levers: [Vector3<f64>; N]) -> Self {
        Self { levers: levers.iter().any(|r| *r != Vector3::zeros()).then_some(levers), ..self }
    }

    /// With the retardation times of its strains at start and end, linear between, s.
    pub fn with_retardation(mut self, [start, end]: [f64; 2]) -> Self {
        for (point, (x, _)) in self.stiffness_points.iter_mut().zip(gauss(Self::STIFFNESS_POINTS)) {
            point.retardation = start * (1.0 - x) + end * x;
        }
        self
    }

    /// Gauss points of the elastic terms.
    pub fn stiffness_points(&self) -> &[StiffnessPoint<N>] {
        &self.stiffness_points[..Self::STIFFNESS_POINTS]
    }

    /// Gauss points of the inertia terms.
    pub fn inertia_points(&self) -> &[InertiaPoint<N>] {
        &self.inertia_points[..Self::INERTIA_POINTS]
    }

    /// Inertia points with one Gauss point fewer, for [`crate::mesh::InertiaQuadrature::ReducedCoupling`].
    pub fn reduced_inertia_points(&self, sections: EndSections<'_>) -> Vec<InertiaPoint<N>> {
        gauss(Self::INERTIA_POINTS - 1)
            .iter()
            .map(|&(x, w)| InertiaPoint {
                shape: Shape::at(x, self.length),
                weight: w * self.length,
                mass: sections.mass[0] * (1.0 - x) + sections.mass[1] * x,
            })
            .collect()
    }
}

impl<const N: usize> BeamState<N> {
    /// Position of a section in A, m.
    pub fn position(&self, shape: &Shape<N>) -> Vector3<f64> {
        (0..N).map(|a| self.positions[a] * shape.n[a]).sum()
    }

    /// `R'` in A, 1.
    pub fn slope(&self, shape: &Shape<N>) -> Vector3<f64> {
        (0..N).map(|a| self.positions[a] * shape.dn[a]).sum()
    }
}

/// A section in motion: rotation operators and position at one Gauss point.
#[derive(Clone, Copy, Debug)]
pub struct SectionState<const N: usize> {
    /// Rotation and spin operators.
    pub rotation: SectionRotation<N>,
    /// Position in A, m.
    pub position: Vector3<f64>,
}

impl<const N: usize> SectionState<N> {
    /// At a point of an element.
    pub fn new(state: &BeamState<N>, field: &RotationField<N>, shape: &Shape<N>) -> Self {
        Self { rotation: field.at(shape), position: state.position(shape) }
    }
}
