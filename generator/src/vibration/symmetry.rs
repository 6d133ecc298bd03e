//! Mirror symmetry of structures and of their modes.
//!
//! A plane is taken for a plane of symmetry when the nodes are mirror images of each other. Whether stiffness and mass are so too is left to
//! the modes: those of an unsymmetric structure are neither symmetric nor antisymmetric.

use std::collections::HashMap;

use nalgebra::Vector3;

/// Distance, relative to the size of the structure, within which a node is the mirror image of another: equilibria are found to
/// 1e-9, and drawings are rounded by their authors.
const SAME_PLACE: f64 = 1e-6;
/// Part of a mode that may be of the other parity.
const PURE: f64 = 1e-3;

/// A plane through the centre of mass.
#[derive(Clone, Debug)]
pub struct MirrorPlane {
    /// Axis of A that it is normal to: 0, 1, 2.
    pub normal: usize,
    /// Mirror image of each node - (nodes).
    pub partner: Vec<usize>,
    /// Whether all nodes lie in the plane.
    pub flat: bool,
}

impl MirrorPlane {
    /// The two axes that span it.
    pub fn name(&self) -> &'static str {
        ["yz", "xz", "xy"][self.normal % 3]
    }
}

/// How a mode looks in a mirror.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// The same; motion within the plane of a flat structure.
    Symmetric,
    /// The same with the opposite sign; motion out of the plane of a flat structure.
    Antisymmetric,
    /// Neither.
    Mixed,
}

/// The mirror planes of a cloud of nodes.
pub(super) fn mirror_planes(positions: &[Vector3<f64>], centre: &Vector3<f64>) -> Vec<MirrorPlane> {
    let size = positions.iter().map(|r| (r - centre).norm()).fold(0.0, f64::max);
    let tolerance = SAME_PLACE * size;
    if tolerance <= 0.0 {
        return Vec::new();
    }
    let places: Vec<Vector3<f64>> = positions.iter().map(|r| r - centre).collect();
    let grid = Grid::new(&places, tolerance);
    let plane = |normal: usize| {
        let image = |r: &Vector3<f64>| {
            let mut image = *r;
            image[normal] = -image[normal];
            grid.nearest(&places, &image)
        };
        let partner: Vec<usize> = places.iter().map(image).collect::<Option<_>>()?;
        let flat = places.iter().all(|r| r[normal].abs() <= tolerance);
        Some(MirrorPlane { normal, partner, flat })
    };
    (0..3).filter_map(plane).collect()
}

/// Parity of a field of displacements and rotations; rotations count times `length`.
pub(super) fn parity(
    plane: &MirrorPlane,
    translations: &[Vector3<f64>],
    rotations: &[Vector3<f64>],
    length: f64,
) -> Parity {
    // A mirror turns vectors of rotation over: those along its normal stay.
    let mirrored = |v: &Vector3<f64>, sign: f64| {
        let mut out = v * sign;
        out[plane.normal] = -out[plane.normal];
        out
    };
    let (mut same, mut all) = (0.0, 0.0);
    for (node, partner) in plane.partner.iter().enumerate() {
        same += translations[*partner].dot(&mirrored(&translations[node], 1.0));
        same += length * length * rotations[*partner].dot(&mirrored(&rotations[node], -1.0));
        all += translations[node].norm_squared() + length * length * rotations[node].norm_squared();
    }
    match same / all {
        s if s > 1.0 - PURE => Parity::Symmetric,
        s if s < PURE - 1.0 => Parity::Antisymmetric,
        _ => Parity::Mixed,
    }
}

/// Nodes by the cell of a grid that they are in.
struct Grid {
    cell: f64,
    tolerance: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
}

impl Grid {
    fn new(places: &[Vector3<f64>], tolerance: f64) -> Self {
        let mut grid = Self { cell: 4.0 * tolerance, tolerance, cells: HashMap::new() };
        for (node, place) in places.iter().enumerate() {
            grid.cells.entry(grid.key(place)).or_default().push(node);
        }
        grid
    }

    fn key(&self, place: &Vector3<f64>) -> [i64; 3] {
        [0, 1, 2].map(|k| (place[k] / self.cell).round() as i64)
    }

    /// The node nearest to a place within the tolerance, of equally near ones the first.
    fn nearest(&self, places: &[Vector3<f64>], wanted: &Vector3<f64>) -> Option<usize> {
        let [x, y, z] = self.key(wanted);
        let around =
            (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])));
        let near = around.filter_map(|key| self.cells.get(&key)).flatten().copied();
        let distance = |node: &usize| (places[*node] - wanted).norm();
        near.filter(|node| distance(node) <= self.tolerance)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)))
    }
}
