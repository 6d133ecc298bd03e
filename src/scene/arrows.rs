//! Loads as vectors in space.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use rom_runtime::expression::Variables;
use rom_runtime::loads::{Load, LoadFrame};

use super::Arrow;

/// Most arrows of a view; the smallest are left out.
const MOST_ARROWS: usize = 200;

/// What a load depends on at an instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instant {
    /// What the factor of the load is a function of.
    pub(super) variables: Variables,
    /// A to G.
    pub(super) attitude: UnitQuaternion<f64>,
    /// Axes of the node that carries the point, to G.
    pub(super) node: UnitQuaternion<f64>,
}

/// Force (N) and moment (N m) of a load in G.
pub(super) fn wrench(load: &Load, at: &Instant) -> [Vector3<f64>; 2] {
    let factor = load.time.value(&at.variables);
    [load.force, load.moment].map(|components| {
        let vector = factor * Vector3::from(components);
        match &load.frame {
            LoadFrame::Dead => vector,
            LoadFrame::Body => at.attitude * vector,
            LoadFrame::Follower { section } => at.node * (Matrix3::from_fn(|i, j| section[i][j]) * vector),
        }
    })
}

/// The arrows of one load from its wrenches over time; none for what is always zero.
pub(super) fn arrows(point: usize, wrenches: &[[Vector3<f64>; 2]]) -> impl Iterator<Item = Arrow> + '_ {
    [false, true].into_iter().filter_map(move |is_moment| {
        let vector: Vec<f64> = wrenches
            .iter()
            .flat_map(|w| w[usize::from(is_moment)].iter().copied().collect::<Vec<_>>())
            .collect();
        vector.iter().any(|&x| x != 0.0).then_some(Arrow { is_moment, point, vector })
    })
}

/// The largest ones, in the order they came in.
pub(super) fn largest(mut arrows: Vec<Arrow>) -> Vec<Arrow> {
    if arrows.len() > MOST_ARROWS {
        let size = |a: &Arrow| a.vector.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        let mut sizes: Vec<f64> = arrows.iter().map(size).collect();
        sizes.sort_by(|a, b| b.total_cmp(a));
        let least = sizes[MOST_ARROWS - 1];
        arrows.retain(|arrow| size(arrow) >= least);
        arrows.truncate(MOST_ARROWS);
    }
    arrows
}

/// A unit quaternion from its four components, scalar first.
pub(super) fn unit([w, i, j, k]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k))
}
