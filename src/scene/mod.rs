//! What a 3-D view shows: lines along the members that move and deform, with tracks of points and loads as arrows.
//!
//! Whatever the method, the shape at an instant is a sum of constant shapes with varying amplitudes: the modes of a reduced
//! model, or a basis for what the nodes of a finite-element run did ([`film`]). Pages stay small and the deformation can be
//! exaggerated where it is looked at.

mod arrows;
mod basis;
mod drawn;
pub mod film;
mod reduced;

pub(crate) use drawn::Drawn;
pub use reduced::{modes, of_run};

/// Frames kept of a run.
pub const FRAMES: usize = 1_000;

/// Most nodes drawn: finer meshes are thinned.
pub const MOST_NODES: usize = 13_000;

/// One view. Lengths in m, frame A where nothing else is said.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// What it shows.
    pub title: String,
    /// Positions of the nodes in A at the equilibrium, m - (n x 3).
    pub positions: Vec<f64>,
    /// Node indices along each line.
    pub lines: Vec<Vec<u32>>,
    /// What moves: one body per method.
    pub bodies: Vec<Body>,
    /// Mode shapes to look at.
    pub modes: Modes,
}

impl Scene {
    /// The bodies of all scenes of one structure in one view, with the modes of the first that has any.
    pub fn together(scenes: Vec<Self>) -> Option<Self> {
        let bodies = scenes.iter().flat_map(|scene| scene.bodies.clone()).collect();
        let shown = scenes.iter().position(|scene| !scene.modes.names.is_empty()).unwrap_or(0);
        let scene = scenes.into_iter().nth(shown)?;
        Some(Self { bodies, ..scene })
    }
}

/// One moving and deforming body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    /// Name in the legend.
    pub name: String,
    /// Instants of the frames, s - (f).
    pub t: Vec<f64>,
    /// Position of the origin of A in G, m - (f x 3).
    pub origin: Vec<f64>,
    /// Attitude quaternion, scalar first, A to G - (f x 4).
    pub attitude: Vec<f64>,
    /// Displacement of every node in A per unit amplitude - (n x 3 x k).
    pub shapes: Vec<f64>,
    /// Amplitudes - (f x k).
    pub amplitudes: Vec<f64>,
    /// How fast it moves; pages do not show it.
    pub velocity: Velocity,
    /// Points whose tracks are drawn and that loads act on.
    pub points: Vec<Track>,
    /// Loads.
    pub arrows: Vec<Arrow>,
}

/// The way of a point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// Name.
    pub name: String,
    /// Place in A at the equilibrium, m.
    pub rest: [f64; 3],
    /// Displacement in A, m - (f x 3).
    pub displacement: Vec<f64>,
}

/// What is known of the velocities of the nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Velocity {
    /// Nothing.
    #[default]
    Unknown,
    /// Those of the nodes in G, m/s - (f x n x 3).
    OfNodes(Vec<f64>),
    /// By the shapes.
    OfShapes {
        /// Velocity and angular velocity of A in G, m/s and rad/s - (f x 6).
        of_a: Vec<f64>,
        /// Rates of the amplitudes, 1/s - (f x k).
        rates: Vec<f64>,
    },
}

/// A force or a moment on a point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrow {
    /// Whether it is a moment.
    pub is_moment: bool,
    /// Index into the points of the body.
    pub point: usize,
    /// Components in G, N or N m - (f x 3).
    pub vector: Vec<f64>,
}

/// Free-free modes, each with the motion of A that belongs to it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Modes {
    /// Number and frequency of each, in words - (m).
    pub names: Vec<String>,
    /// Displacement of every node in A per unit amplitude - (n x 3 x m).
    pub shapes: Vec<f64>,
    /// `Phi_R`: motion of A per unit amplitude, translation then rotation - (6 x m).
    pub rigid: Vec<f64>,
}

/// Indices of at most `limit` of `n` rows, evenly, the first and the last among them.
pub(crate) fn frames(n: usize, limit: usize) -> Vec<usize> {
    if n <= limit {
        return (0..n).collect();
    }
    (0..limit).map(|k| k * (n - 1) / (limit - 1)).collect()
}

#[cfg(test)]
mod tests;
