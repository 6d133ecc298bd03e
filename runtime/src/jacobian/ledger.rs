//! How centre of mass, momenta and energies change along a direction.

use super::consistent::SIXTH;
use super::{Direction, Jacobian, Parts};
use crate::math::{add, dot, quaternion, quaternion_product};
use crate::output::Ledger;
use crate::state::State;

/// Longest turn of a step of a difference, rad: what the rule leaves out of it, `TURN^6/140`, is as small as round-off is.
const TURN: f64 = 1e-2;

/// What a difference moves: amplitudes, of which the quantities are polynomials of up to sixth degree, or all else, in which they are of
/// third.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Amplitudes,
    Rest,
}

impl Jacobian {
    /// Derivative of centre of mass, momenta and energies, see [`crate::Model::ledger`], along a direction at the state evaluated last.
    /// They are polynomials in the state but for its attitude, for whose degree the rule of differences over +-1, +-2, +-3 steps is
    /// exact; along a turn it is so to round-off. Does not allocate.
    pub fn ledger(&mut self, along: Direction<'_>) -> Ledger {
        let Jacobian { model, parts, .. } = self;
        let mut sum = [0.0; 12];
        for part in [Part::Amplitudes, Part::Rest] {
            let step = parts.step_of(along.state, part);
            let Parts { state, moved, work, .. } = parts;
            for (distance, weight) in SIXTH {
                for sign in [1.0, -1.0] {
                    move_along(state, along.state, part, sign * distance * step, moved);
                    let found = flat(&model.ledger_under(work.gravity, moved));
                    for (sum, found) in sum.iter_mut().zip(found) {
                        *sum += sign * weight / step * found;
                    }
                }
            }
        }
        let [x, y, z, px, py, pz, lx, ly, lz, kinetic_energy, elastic_energy, gravity_energy] = sum;
        Ledger {
            r_cm_g: [x, y, z],
            linear_momentum_g: [px, py, pz],
            angular_momentum_g: [lx, ly, lz],
            kinetic_energy,
            elastic_energy,
            gravity_energy,
        }
    }
}

impl Parts {
    /// Factor on the direction for one step: no farther than the range of a consistent model or a small turn, so that no digits cancel.
    fn step_of(&self, direction: &[f64], part: Part) -> f64 {
        let shortest = |longest: f64, limit: f64, change: f64| longest.min(limit / change.abs());
        match part {
            Part::Amplitudes => {
                let steps = self.consistent.steps().iter().zip(direction);
                steps.fold(1.0, |longest, (limit, change)| shortest(longest, *limit, *change))
            }
            Part::Rest => {
                let first = 2 * self.state.q.len() + 6;
                let theta = direction.get(first..).and_then(<[f64]>::first_chunk::<3>);
                theta.map_or(1.0, |theta| shortest(1.0, TURN, libm::sqrt(dot(*theta, *theta))))
            }
        }
    }
}

/// One part of a state moved along the coordinates of [`Jacobian`], into another with the same lengths.
fn move_along(state: &State, direction: &[f64], part: Part, factor: f64, moved: &mut State) {
    moved.copy_from(state);
    let changes = direction.iter().map(|change| factor * change);
    if part == Part::Amplitudes {
        moved.q.iter_mut().zip(changes).for_each(|(value, change)| *value += change);
        return;
    }
    let mut changes = changes.skip(state.q.len());
    for value in moved.q_dot.iter_mut().chain(&mut moved.beta_star) {
        *value += changes.next().unwrap_or(0.0);
    }
    let mut vector = || [(); 3].map(|()| changes.next().unwrap_or(0.0));
    moved.attitude = quaternion_product(state.attitude, quaternion(vector()));
    moved.position = add(state.position, vector());
}

fn flat(ledger: &Ledger) -> [f64; 12] {
    let Ledger {
        r_cm_g: [x, y, z], linear_momentum_g: [px, py, pz], angular_momentum_g: [lx, ly, lz], ..
    } = *ledger;
    let Ledger { kinetic_energy, elastic_energy, gravity_energy, .. } = *ledger;
    [x, y, z, px, py, pz, lx, ly, lz, kinetic_energy, elastic_energy, gravity_energy]
}
