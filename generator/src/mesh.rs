//! The validated structure as finite elements: what every later stage reads.

mod build;
pub(crate) mod course;
pub(crate) mod curve;
mod damping;
pub(crate) mod plan;
pub(crate) mod shape;

pub(crate) use build::build;
pub use damping::{Damping, ModalRatios};

use nalgebra::{Matrix3, Matrix6, Vector3};
use rom_runtime::loads::LoadCase;

use crate::equilibrium::trim::Trim;

/// Nodes, elements, masses and named points of one structure. Immutable once built.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Name of the structure.
    pub name: String,
    /// Node positions in A, m: drawing coordinates minus those of the reference node.
    pub nodes: Vec<Vector3<f64>>,
    /// Index of the reference node, at the origin of A.
    pub reference: usize,
    /// Drawing coordinates of the reference node, m: `r_G` at t = 0.
    pub reference_position: Vector3<f64>,
    /// Section properties, shared by elements.
    pub sections: Vec<Section>,
    /// Beam elements, grouped by member.
    pub elements: Vec<Element>,
    /// Members in input order.
    pub members: Vec<Member>,
    /// Lumped masses.
    pub lumped: Vec<LumpedMass>,
    /// Named points, in input order.
    pub points: Vec<Point>,
    /// Load cases, in input order; their loads index `points`.
    pub load_cases: Vec<LoadCase>,
    /// Inertial sensors, in input order.
    pub sensors: Vec<Sensor>,
    /// Blocks of stations for aerodynamic codes, in input order.
    pub stations: Vec<StationBlock>,
    /// Places where section forces are told, in input order.
    pub cuts: Vec<Cut>,
    /// Acceleration of free fall in G, m/s^2; zero in weightlessness.
    pub gravity: Vector3<f64>,
    /// The equilibrium that the structure is to be modelled about; none: as drawn.
    pub trim: Option<Trim>,
    /// How the structure is held.
    pub support: Support,
    /// Structural damping but for that of the sections.
    pub damping: Damping,
    /// Quadrature of the inertia blocks.
    pub inertia_quadrature: InertiaQuadrature,
}

impl Mesh {
    /// The nodes that carry a place.
    pub fn nodes_of(&self, place: Place) -> Vec<usize> {
        match place {
            Place::Node(node) => vec![node],
            Place::Inside { element, .. } => {
                let element = &self.elements[element];
                element.nodes[..element.n_nodes].to_vec()
            }
        }
    }

    /// A node in words: a named point where there is one, else member and number along it.
    pub fn place(&self, node: usize) -> String {
        if let Some(point) = self.points.iter().find(|p| p.place == Place::Node(node)) {
            return format!("point `{}`", point.name);
        }
        let on = |m: &Member| {
            m.nodes.iter().position(|&n| n == node).map(|k| format!("member `{}`, node {}", m.name, k + 1))
        };
        self.members.iter().find_map(on).unwrap_or_else(|| format!("node {node}"))
    }
}

/// How a structure is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Support {
    /// It flies; a load case may move its reference node.
    #[default]
    Free,
    /// Clamped at the reference node, which is at rest unless a load case moves it.
    Clamped,
}

/// Cross-section: 6x6 matrices over (gamma, kappa) and (V, W), local x along the beam.
#[derive(Clone, Debug)]
pub struct Section {
    /// Name in the input.
    pub name: String,
    /// Stiffness `S`, N and N m^2 (and N m off the diagonal blocks).
    pub stiffness: Matrix6<f64>,
    /// Mass `Mcs`, kg/m, kg and kg m.
    pub mass: Matrix6<f64>,
    /// Retardation time `tau` of its strains, s: section forces are `S (eps + tau eps_dot)`.
    pub retardation: f64,
}

/// A 2- or 3-node beam element.
#[derive(Clone, Debug)]
pub struct Element {
    /// Index of its member.
    pub member: usize,
    /// Node indices along the member; only the first `n_nodes` count. Three nodes: start, middle, end.
    pub nodes: [usize; 3],
    /// 2 or 3.
    pub n_nodes: usize,
    /// Arc length, m.
    pub length: f64,
    /// Section frames `E` at its nodes (columns: local x, y, z in drawing axes).
    pub frames: [Matrix3<f64>; 3],
    /// From its nodes to the places on the member's axis, drawing axes, m: zero but at the ends of rigid links.
    pub levers: [Vector3<f64>; 3],
    /// Section index at its start and end; properties vary linearly between.
    pub sections: [usize; 2],
}

/// A member of the input and the elements made from it.
#[derive(Clone, Debug)]
pub struct Member {
    /// Name in the input.
    pub name: String,
    /// Its elements.
    pub elements: core::ops::Range<usize>,
    /// Its nodes from start to end.
    pub nodes: Vec<usize>,
}

/// A rigid mass on a node.
#[derive(Clone, Debug)]
pub struct LumpedMass {
    /// Node index.
    pub node: usize,
    /// 6x6 mass about the node, node frame (drawing axes): [[m I, -m r~], [m r~, J]] with J about the node.
    pub mass: Matrix6<f64>,
}

/// A named point, rigidly linked to a node or to a section between nodes.
#[derive(Clone, Debug)]
pub struct Point {
    /// Name in the input.
    pub name: String,
    /// What carries it: [`crate::carrier::Carrier`].
    pub place: Place,
    /// Position relative to its carrier, in the carrier's axes (those of the drawing), m; zero when the point is the carrier itself.
    pub offset: Vector3<f64>,
    /// Section frames of the members that meet at the node, or of the one it is on: (member name, `E`).
    pub sections: Vec<(String, Matrix3<f64>)>,
}

impl Point {
    /// The node that carries it; none between nodes.
    pub fn node(&self) -> Option<usize> {
        match self.place {
            Place::Node(node) => Some(node),
            Place::Inside { .. } => None,
        }
    }
}

/// A place on the structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// A node.
    Node(usize),
    /// Inside an element, where its interpolation has the axis.
    Inside {
        /// Index of the element.
        element: usize,
        /// Fraction of the element's length, above 0 and below 1.
        x: f64,
    },
}

/// A block of stations that a host reads and loads all at once.
#[derive(Clone, Debug)]
pub struct StationBlock {
    /// Name in the input.
    pub name: String,
    /// Member by member.
    pub stations: Vec<Station>,
}

/// A section of an element, or a place beside it.
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// Index of its member.
    pub member: usize,
    /// Fraction of the member's length.
    pub fraction: f64,
    /// Index of its element.
    pub element: usize,
    /// Fraction of the element's length, 0 to 1.
    pub x: f64,
    /// From the axis, section axes, m.
    pub offset: Vector3<f64>,
}

/// A place along a member where section forces are told.
#[derive(Clone, Debug)]
pub struct Cut {
    /// Name: that of the input, with a number where there are several.
    pub name: String,
    /// Index of its member.
    pub member: usize,
    /// Fraction of the member's length.
    pub fraction: f64,
    /// Index of its element.
    pub element: usize,
    /// Fraction of the element's length, 0 to 1.
    pub x: f64,
}

/// An inertial sensor on a named point.
#[derive(Clone, Debug)]
pub struct Sensor {
    /// Name in the input.
    pub name: String,
    /// Index of its point.
    pub point: usize,
    /// Its axes in the node frame of the point (columns).
    pub axes: Matrix3<f64>,
    /// Whether it feels gravity.
    pub gravity: bool,
}

/// How the blocks of the inertia terms are integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum InertiaQuadrature {
    /// One Gauss point more than the stiffness, everywhere.
    #[default]
    Consistent,
    /// The paper's digits: blocks M_SR and M_RR with one Gauss point fewer than M_SS.
    ReducedCoupling,
}
