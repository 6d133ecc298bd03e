//! The second derivatives `Theta` of the shapes as forms in the amplitudes: what they do to points and momenta, and the forces that work on
//! them (docs/validity.md).

use alloc::{vec, vec::Vec};

use super::defect::{NodeLoad, Sample};
use super::forms::{Entry, Forms};
use crate::data::ValidityData;
use crate::math::{Mat3, Vec3, Vec6, axial, axpy, cross, join, split, sub, turn_second};

/// `1/2 Theta_ij q_i q_j` in what it meets, and what that is at an instant.
#[derive(Clone, Debug)]
pub(super) struct Bending {
    /// By the entries of the field, then the six of the motion of every point, then those of the lines.
    forms: Forms,
    /// First form of the points, and of every line with whether it is of a dead load.
    first_point: usize,
    lines: Vec<(usize, bool)>,
    /// Motion of the nodes - (points).
    points: Vec<Vec6>,
}

/// Entries below this fraction of the largest of their kind are round-off: where symmetry makes zeros, the differences by which `Theta` is
/// found leave up to some 1e-9 of it.
const NOTHING: f64 = 1e-8;
/// Forms of the work of a dead load per length; the moment it gains has as many.
const DEAD: usize = 9;

impl Bending {
    pub(super) fn new(validity: &ValidityData, m: usize) -> Self {
        let modes = validity.modes;
        let pairs: Vec<[u32; 2]> = (0..modes).flat_map(|i| (i..modes).map(move |j| [i, j])).collect();
        let mut entries = Vec::new();
        // A form has every pair once.
        let mut push = |form: usize, pair: usize, value: f64, largest: f64| {
            if let Some(&[i, j]) = pairs.get(pair).filter(|_| value.abs() > NOTHING * largest) {
                entries.push(Entry::quadratic(form, [i, j], if i == j { 0.5 * value } else { value }));
            }
        };
        let largest =
            |values: &mut dyn Iterator<Item = &f64>| values.fold(0.0_f64, |max, x| max.max(x.abs()));
        let width = 13 + m;
        for column in 0..width {
            // Each kind of entry has units of its own: round-off is told within a column.
            let values = || validity.fields.iter().skip(column).step_by(width);
            let most = largest(&mut values());
            values().enumerate().for_each(|(pair, value)| push(column, pair, *value, most));
        }
        for (point, shapes) in validity.points.iter().enumerate() {
            // Translations, then rotations.
            for (kind, shapes) in shapes.chunks((3 * pairs.len()).max(1)).enumerate() {
                let most = largest(&mut shapes.iter());
                for (at, value) in shapes.iter().enumerate() {
                    let (component, pair) = (at / pairs.len(), at % pairs.len());
                    push(width + 6 * point + 3 * kind + component, pair, *value, most);
                }
            }
        }
        let mut first = width + 6 * validity.points.len();
        let mut lines = Vec::new();
        for line in &validity.missing.lines {
            let rows = line.n_curvature();
            for (at, value) in line.curvature.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                push(first + at % rows, at / rows, *value, 0.0);
            }
            lines.push((first, rows == 2 * DEAD));
            first += rows;
        }
        Bending {
            forms: Forms::new(m, first, &entries),
            first_point: width,
            lines,
            points: vec![[0.0; 6]; validity.points.len()],
        }
    }

    /// Takes in a motion.
    pub(super) fn look(&mut self, at: &Sample) {
        self.forms.look(at.q, at.q_dot, at.q_ddot);
        self.forms.values(self.first_point, self.points.as_flattened_mut());
    }

    /// Of the node of a point: translation in A and rotation in the node frame.
    pub(super) fn displacement(&self, point: usize) -> Vec6 {
        self.points.get(point).copied().unwrap_or_default()
    }

    /// Adds to the rows of the shapes the work of the field less that of the loads, to those of A the rate of the momentum and less the moment
    /// of the loads. `lines`: `A` of every declared load per length.
    pub(super) fn add(
        &mut self,
        field: &[f64],
        loads: &[NodeLoad],
        lines: &[Mat3],
        rows: &mut [f64],
        rigid: &mut Vec6,
    ) {
        self.forms.weigh(0, field);
        let mut moment = [0.0; 3];
        for load in loads {
            let wrench = join(load.force, load.moment);
            self.forms.weigh(self.first_point + 6 * load.point, &wrench.map(|x| -x));
            moment = sub(moment, cross(split(&self.displacement(load.point)).0, load.force));
        }
        for (&(first, dead), acting) in self.lines.iter().zip(lines) {
            if *acting == [[0.0; 3]; 3] {
                continue;
            }
            if dead {
                self.forms.weigh(first, acting.map(|row| row.map(|x| -x)).as_flattened());
                let mut lever: Mat3 = [[0.0; 3]; 3];
                self.forms.values(first + DEAD, lever.as_flattened_mut());
                moment = sub(moment, axial(&turn_second(&lever, acting)));
            } else {
                // The factor of a load that is not dead is on the diagonal of `A`.
                let [[factor, ..], ..] = *acting;
                let mut lever: Vec3 = [0.0; 3];
                self.forms.weigh(first, &[-factor]);
                self.forms.values(first + 1, &mut lever);
                moment = axpy(moment, -factor, lever);
            }
        }
        let mut rate = [0.0; 6];
        // Of the field the momenta come second.
        self.forms.seconds(1, &mut rate);
        for (to, value) in rigid.iter_mut().zip(rate) {
            *to += value;
        }
        for (to, value) in rigid.iter_mut().skip(3).zip(moment) {
            *to += value;
        }
        self.forms.pull_back(rows);
    }
}
