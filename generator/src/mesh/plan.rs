//! A structure that has passed every check, before it is cut into elements.

use core::ops::Range;
use nalgebra::{Matrix3, Matrix6, Vector3};
use rom_runtime::loads::LoadCase;

use super::course::Course;
use super::curve::Piece;
use super::shape::Profile;
use super::{Damping, InertiaQuadrature, Sensor, Support};
use crate::element::rotation_field::RotationField;
use crate::element::shape::Shape;
use crate::equilibrium::trim::Trim;

/// Everything a mesh is made from. Made by [`crate::input`], which has checked it: meshing cannot fail.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub name: String,
    /// Drawing coordinates of the points at which members start, end, bend or meet, m.
    pub joints: Vec<Vector3<f64>>,
    /// Carries the frame A.
    pub reference: Station,
    /// Sections by the members' indices.
    pub profiles: Vec<Profile>,
    pub members: Vec<MemberPlan>,
    /// Joints that rigid links join.
    pub links: Vec<Vec<usize>>,
    pub masses: Vec<MassPlan>,
    pub points: Vec<PointPlan>,
    pub load_cases: Vec<LoadCase>,
    pub sensors: Vec<Sensor>,
    pub stations: Vec<StationBlockPlan>,
    pub cuts: Vec<(String, StationPlan)>,
    pub gravity: Vector3<f64>,
    pub trim: Option<Trim>,
    pub support: Support,
    pub damping: Damping,
    pub inertia_quadrature: InertiaQuadrature,
}

/// A place on a member that will be a node: its number along the member, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Station {
    pub member: usize,
    pub node: usize,
}

/// A place on a member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PlanPlace {
    /// That will be a node.
    Node(Station),
    /// Inside an element, counted along the member, at a fraction of its length.
    Inside { member: usize, element: usize, x: f64 },
}

/// A block of stations.
#[derive(Clone, Debug)]
pub(crate) struct StationBlockPlan {
    pub name: String,
    pub stations: Vec<StationPlan>,
}

/// A station: on an element counted along its member, at a fraction of the element's length, ends included.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StationPlan {
    pub member: usize,
    /// Of the member's length.
    pub fraction: f64,
    pub element: usize,
    pub x: f64,
    /// From the axis, section axes, m.
    pub offset: Vector3<f64>,
}

/// A named point.
#[derive(Clone, Debug)]
pub(crate) struct PointPlan {
    pub name: String,
    pub place: PlanPlace,
    /// Relative to that place, drawing axes, m.
    pub offset: Vector3<f64>,
    pub sections: Vec<(String, Matrix3<f64>)>,
}

/// A rigid mass: 6x6 about the node, drawing axes.
#[derive(Clone, Debug)]
pub(crate) struct MassPlan {
    pub station: Station,
    pub mass: Matrix6<f64>,
}

/// A member: smooth pieces from joint to joint, each cut into elements of one length.
#[derive(Clone, Debug)]
pub(crate) struct MemberPlan {
    pub name: String,
    pub pieces: Vec<Piece>,
    /// Joints before, between and after the pieces.
    pub joints: Vec<usize>,
    /// Elements of each piece.
    pub counts: Vec<usize>,
    /// 2 or 3.
    pub element_nodes: usize,
    /// Indices of its sections, by fraction of its length.
    pub section: Course<usize>,
    /// Unit vector, not parallel to the axis anywhere.
    pub local_y: Vector3<f64>,
    /// Rotation of the section about the axis, rad.
    pub twist: Course<f64>,
    /// Node at the start of each piece and at the end of the last, numbered along the member.
    first_nodes: Vec<usize>,
    /// Arc length at the same places, m.
    starts: Vec<f64>,
}

/// Places and section frames of up to three nodes.
type ElementNodes = [(Vector3<f64>, Matrix3<f64>); 3];

/// What the section frames of a member are made from.
#[derive(Clone, Debug)]
pub(crate) struct Orientation {
    pub local_y: Vector3<f64>,
    pub twist: Course<f64>,
}

impl MemberPlan {
    /// `joints` has one entry more than `pieces`, `counts` as many.
    pub(crate) fn new(
        name: String,
        (pieces, joints): (Vec<Piece>, Vec<usize>),
        counts: Vec<usize>,
        element_nodes: usize,
        section: Course<usize>,
        orientation: Orientation,
    ) -> Self {
        let mut first_nodes = vec![0];
        let mut starts = vec![0.0];
        for (piece, count) in pieces.iter().zip(&counts) {
            first_nodes.push(first_nodes[first_nodes.len() - 1] + count * (element_nodes - 1));
            starts.push(starts[starts.len() - 1] + piece.length());
        }
        let Orientation { local_y, twist } = orientation;
        Self { name, pieces, joints, counts, element_nodes, section, local_y, twist, first_nodes, starts }
    }

    /// Number of nodes, ends included.
    pub(crate) fn node_count(&self) -> usize {
        self.first_nodes[self.pieces.len()] + 1
    }

    /// Number of elements.
    pub(crate) fn element_count(&self) -> usize {
        self.counts.iter().sum()
    }

    /// Length of the axis, m.
    pub(crate) fn length(&self) -> f64 {
        self.starts[self.pieces.len()]
    }

    /// Nodes of a piece, numbered along the member, both ends included.
    pub(crate) fn piece_nodes(&self, piece: usize) -> Range<usize> {
        self.first_nodes[piece]..self.first_nodes[piece + 1] + 1
    }

    /// Arc length of a node from the start of its piece, m. `node` counts along the member.
    pub(crate) fn arc_length(&self, piece: usize, node: usize) -> f64 {
        let nodes = self.piece_nodes(piece);
        self.pieces[piece].length() * (node - nodes.start) as f64 / (nodes.len() - 1) as f64
    }

    /// Arc length of a node from the start of the member as a fraction of the whole.
    pub(crate) fn fraction(&self, piece: usize, node: usize) -> f64 {
        (self.starts[piece] + self.arc_length(piece, node)) / self.length()
    }

    /// Section frame `E` at a node, seen from one of the pieces it lies on: columns local x, y, z in drawing axes.
    ///
    /// `x` along the axis, `z = x cross local_y` normalised, `y = z cross x`; then both turned about `x` by the twist.
    pub(crate) fn frame(&self, piece: usize, node: usize) -> Matrix3<f64> {
        let s = self.arc_length(piece, node);
        let x = self.pieces[piece].tangent(s);
        let z = x.cross(&self.local_y).normalize();
        let y = z.cross(&x);
        let (sin, cos) = self.twist.at(self.fraction(piece, node)).sin_cos();
        Matrix3::from_columns(&[x, y * cos + z * sin, z * cos - y * sin])
    }

    /// The frames at a node: one, or two where two pieces meet (equal unless the axis has a corner there).
    pub(crate) fn frames(&self, node: usize) -> Vec<Matrix3<f64>> {
        (0..self.pieces.len())
            .filter(|&piece| self.piece_nodes(piece).contains(&node))
            .map(|piece| self.frame(piece, node))
            .collect()
    }

    /// The joint at a node, if it is one.
    pub(crate) fn joint_at(&self, node: usize) -> Option<usize> {
        self.first_nodes.binary_search(&node).ok().map(|at| self.joints[at])
    }

    /// The nodes at which the member goes through a joint.
    pub(crate) fn nodes_at(&self, joint: usize) -> impl Iterator<Item = usize> {
        self.joints.iter().zip(&self.first_nodes).filter(move |(j, _)| **j == joint).map(|(_, node)| *node)
    }

    /// Drawing coordinates of a node, m; joints are met exactly.
    pub(crate) fn position(&self, node: usize, joints: &[Vector3<f64>]) -> Vector3<f64> {
        match self.first_nodes.binary_search(&node) {
            Ok(at) => joints[self.joints[at]],
            Err(after) => self.pieces[after - 1].position(self.arc_length(after - 1, node)),
        }
    }

    /// The node nearest along the axis to an arc length from the start, and its own arc length, m.
    pub(crate) fn node_near(&self, s: f64) -> (usize, f64) {
        let piece = self.starts.partition_point(|&start| start <= s).clamp(1, self.pieces.len()) - 1;
        let nodes = self.piece_nodes(piece);
        let within = (s - self.starts[piece]) / self.pieces[piece].length() * (nodes.len() - 1) as f64;
        let node = (nodes.start + within.round() as usize).min(nodes.end - 1);
        (node, self.starts[piece] + self.arc_length(piece, node))
    }

    /// Ends of the elements as fractions of the length, from 0 to 1.
    pub(crate) fn knots(&self) -> Vec<f64> {
        let step = self.element_nodes - 1;
        let ends = |piece: usize| {
            let first = self.first_nodes[piece];
            (0..self.counts[piece]).map(move |k| self.fraction(piece, first + k * step))
        };
        (0..self.pieces.len()).flat_map(ends).chain([1.0]).collect()
    }

    /// The element at an arc length from the start, counted along the member, and the fraction of its length.
    pub(crate) fn element_at(&self, s: f64) -> (usize, f64) {
        let piece = self.starts.partition_point(|&start| start <= s).clamp(1, self.pieces.len()) - 1;
        let along = (s - self.starts[piece]) / self.pieces[piece].length() * self.counts[piece] as f64;
        let within = (along.max(0.0) as usize).min(self.counts[piece] - 1);
        (self.counts[..piece].iter().sum::<usize>() + within, (along - within as f64).clamp(0.0, 1.0))
    }

    /// Places and section frames at the nodes of an element, counted along the member; only as many as it has nodes.
    pub(crate) fn element_nodes_at(&self, element: usize, joints: &[Vector3<f64>]) -> ElementNodes {
        let mut first = element;
        let mut piece = 0;
        while first >= self.counts[piece] {
            first -= self.counts[piece];
            piece += 1;
        }
        let start = self.first_nodes[piece] + first * (self.element_nodes - 1);
        let node = |a: usize| start + a.min(self.element_nodes - 1);
        [0, 1, 2].map(|a| (self.position(node(a), joints), self.frame(piece, node(a))))
    }

    /// Place and section frame that the interpolation of an element gives inside it.
    pub(crate) fn inside(
        &self,
        element: usize,
        x: f64,
        joints: &[Vector3<f64>],
    ) -> (Vector3<f64>, Matrix3<f64>) {
        fn interpolate<const N: usize>(nodes: &ElementNodes, x: f64) -> (Vector3<f64>, Matrix3<f64>) {
            let shape = Shape::<N>::at(x, 1.0);
            let frames: [Matrix3<f64>; N] = std::array::from_fn(|a| nodes[a].1);
            let position = (0..N).map(|a| nodes[a].0 * shape.n[a]).sum();
            (position, RotationField::new(&frames).at(&shape).triad)
        }
        let nodes = self.element_nodes_at(element, joints);
        if self.element_nodes == 3 { interpolate::<3>(&nodes, x) } else { interpolate::<2>(&nodes, x) }
    }

    /// The arc length nearest to a place, and its distance from the axis, m.
    pub(crate) fn nearest(&self, place: &Vector3<f64>) -> (f64, f64) {
        let on_piece = |(piece, start): (&Piece, &f64)| {
            let (s, distance) = piece.nearest(place);
            (start + s, distance)
        };
        let all = self.pieces.iter().zip(&self.starts).map(on_piece);
        all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0.0, f64::INFINITY))
    }

    /// The node nearest to a place, and its distance, m.
    pub(crate) fn nearest_node(&self, place: &Vector3<f64>, joints: &[Vector3<f64>]) -> (usize, f64) {
        let mut best = (0, f64::INFINITY);
        for (index, piece) in self.pieces.iter().enumerate() {
            let nodes = self.piece_nodes(index);
            let (s, _) = piece.nearest(place);
            let near = nodes.start + (s / piece.length() * (nodes.len() - 1) as f64).round() as usize;
            let near = near.min(nodes.end - 1);
            let distance = (self.position(near, joints) - place).norm();
            if distance < best.1 {
                best = (near, distance);
            }
        }
        best
    }
}
