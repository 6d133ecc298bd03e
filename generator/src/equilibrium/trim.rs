//! The equilibrium that a structure file asks for: its loads, and factors on some of them solved for so that the body can fly by
//! itself.
//!
//! Wanted are factors `lambda` on named loads for which components `r` of the reaction at the reference node vanish. Newton on the
//! factors,
//!
//! ```text
//! (dr/dlambda) delta lambda = -r        dr/dlambda_k = r(eta + e K^{-1} Q_k, lambda_k + e) - r(eta - e K^{-1} Q_k, lambda_k - e)  over 2 e
//! ```
//!
//! with the exact tangent `K` of the equilibrium at the present factors, which is followed as they change. It begins with the factors
//! that balance the rigid body as drawn.

use nalgebra::{DMatrix, DVector, Vector6};
use rom_runtime::loads::LoadCase;

use super::error::EquilibriumError;
use super::stepping::LoadPath;
use super::{Equilibrium, EquilibriumSettings, SELF_BALANCED};
use crate::mesh::{Mesh, Support};

/// Most corrections of the factors.
const MAX_CORRECTIONS: usize = 20;
/// Reaction that counts as none, relative to the sum of all forces or moments, where it does not shrink any more.
const BALANCED: f64 = 1e-9;
/// Reaction that is round-off for certain.
const ROUND_OFF: f64 = 1e-15;
/// Smallest singular value of the scaled sensitivities that tells loads apart.
const DEPENDENT: f64 = 1e-8;

/// What to do about an equilibrium in which the reference node has to be held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum WhenUnbalanced {
    /// An error with the reaction.
    #[default]
    Refuse,
    /// Carry on: the model moves off as soon as it is let go.
    Warn,
}

/// A component of the reaction at the reference node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// Of the force along, or the moment (about the origin of A) about, x, y, z: 0 to 5.
    pub index: usize,
    /// Components in G; else in A.
    pub inertial: bool,
}

/// A factor to be solved for.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// Name of the loads that it multiplies.
    pub load: String,
    /// The component of the reaction that it is to cancel, together with the other unknowns.
    pub component: Component,
}

/// The shape that linearised methods are about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum About {
    /// The deformed shape of the equilibrium.
    #[default]
    Equilibrium,
    /// The drawing, taken as if it were in balance with the loads: shape, inertia and stiffness are those of the undeformed structure,
    /// the factors on the loads those that balance it as a rigid body, and the elastic forces those that carry the loads.
    Drawing,
}

impl About {
    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Equilibrium => "equilibrium",
            Self::Drawing => "drawing",
        }
    }
}

impl std::str::FromStr for About {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        [Self::Equilibrium, Self::Drawing]
            .into_iter()
            .find(|about| about.name() == name)
            .ok_or_else(|| format!("expected equilibrium or drawing, found {name:?}"))
    }
}

/// An equilibrium to be found.
#[derive(Clone, Debug)]
pub struct Trim {
    /// Its loads, taken at t = 0.
    pub case: LoadCase,
    /// Name of each load; empty where it has none - (loads).
    pub names: Vec<String>,
    /// Attitude, load steps, tolerance, stability.
    pub settings: EquilibriumSettings,
    /// Factors to be solved for, and the components of the reaction they cancel.
    pub balance: Vec<Unknown>,
    /// Whether a reaction that is left is refused.
    pub when_unbalanced: WhenUnbalanced,
    /// The shape that linearised methods are about.
    pub about: About,
}

/// The equilibrium that a mesh is to be modelled about; none where that is the drawing.
///
/// # Errors
/// As [`Trim::solve`].
pub fn of_mesh(mesh: &Mesh) -> Result<Option<Equilibrium>, EquilibriumError> {
    let of = |trim: &Trim| match trim.about {
        About::Equilibrium => trim.solve(mesh),
        About::Drawing => trim.as_drawn(mesh),
    };
    mesh.trim.as_ref().map(of).transpose()
}

impl Trim {
    /// Finds the equilibrium.
    ///
    /// # Errors
    /// As [`super::solve`]; factors that cannot be found: loads without effect on the reaction, or with the same one; a reaction that is
    /// left, unless that is accepted.
    pub fn solve(&self, mesh: &Mesh) -> Result<Equilibrium, EquilibriumError> {
        self.solve_at(mesh, 1.0)
    }

    /// Finds the equilibrium under `load_factor` times the loads and gravity, with the factors that balance it there.
    ///
    /// # Errors
    /// As [`Trim::solve`].
    pub fn solve_at(&self, mesh: &Mesh, load_factor: f64) -> Result<Equilibrium, EquilibriumError> {
        let mut path = LoadPath::new(mesh, &self.case, &self.settings)?;
        let mut factors = DVector::from_element(self.balance.len(), 1.0);
        if !self.balance.is_empty() {
            if let Some(rigid) = self.rigid_factors(&mut path) {
                factors = rigid;
            }
            path.set_factors(&self.of_loads(&factors));
        }
        path.advance_to(load_factor)?;
        if !self.balance.is_empty() {
            self.correct(&mut path, &mut factors)?;
        }
        self.checked(mesh, path.equilibrium(), &factors)
    }

    /// The drawing as if it were the equilibrium: see [`About::Drawing`].
    ///
    /// # Errors
    /// Settings out of range, factors that the rigid body as drawn cannot tell apart, a reaction that is left, unless that is accepted.
    pub fn as_drawn(&self, mesh: &Mesh) -> Result<Equilibrium, EquilibriumError> {
        let mut path = LoadPath::new(mesh, &self.case, &self.settings)?;
        let mut factors = DVector::zeros(0);
        if !self.balance.is_empty() {
            factors = self.rigid_factors(&mut path).ok_or_else(|| {
                EquilibriumError::Balance(
                    "no factors balance the body as drawn; linearise about the equilibrium".into(),
                )
            })?;
            path.set_factors(&self.of_loads(&factors));
        }
        self.checked(mesh, path.as_drawn(), &factors)
    }

    /// An equilibrium with its factors, refused where the reference node would have to be held.
    fn checked(
        &self,
        mesh: &Mesh,
        found: Equilibrium,
        factors: &DVector<f64>,
    ) -> Result<Equilibrium, EquilibriumError> {
        let names = self.balance.iter().map(|unknown| unknown.load.clone());
        let found = Equilibrium { factors: names.zip(factors.iter().copied()).collect(), ..found };
        let flies = mesh.support == Support::Free;
        if flies
            && self.when_unbalanced == WhenUnbalanced::Refuse
            && !found.self_balance().within(SELF_BALANCED)
        {
            let (force, moment) = (found.reaction_force.norm(), found.reaction_moment.norm());
            return Err(EquilibriumError::Unbalanced { force, moment });
        }
        Ok(found)
    }

    /// Newton on the factors.
    fn correct(&self, path: &mut LoadPath<'_>, factors: &mut DVector<f64>) -> Result<(), EquilibriumError> {
        let mut last = f64::INFINITY;
        for _ in 0..MAX_CORRECTIONS {
            let reaction = self.components(path, &path.reaction(), path.scales());
            let left = reaction.amax();
            if left <= ROUND_OFF || (left <= BALANCED && left > 0.5 * last) {
                return Ok(());
            }
            last = left;
            let step = self.step(path, &reaction)?;
            *factors += step;
            path.change_factors(&self.of_loads(factors))?;
        }
        // It has gone on shrinking, in small steps, all the way through round-off.
        if last <= BALANCED {
            return Ok(());
        }
        let message = format!(
            "the factors do not settle; after {MAX_CORRECTIONS} corrections {last:.1e} of the sum of all loads is out of balance. Start nearer: give the loads that are solved for about the right strength"
        );
        Err(EquilibriumError::Balance(message))
    }

    /// The correction of the factors that cancels a reaction to first order.
    fn step(
        &self,
        path: &mut LoadPath<'_>,
        reaction: &DVector<f64>,
    ) -> Result<DVector<f64>, EquilibriumError> {
        let n = self.balance.len();
        let mut slopes = DMatrix::zeros(n, n);
        for (k, unknown) in self.balance.iter().enumerate() {
            let slope = path.reaction_slope(&self.share(&unknown.load))?;
            slopes.set_column(k, &self.components(path, &slope, path.scales()));
        }
        self.solve_scaled(&slopes, reaction).map_err(EquilibriumError::Balance)
    }

    /// `-slopes^{-1} reaction`, or which loads cannot do it.
    fn solve_scaled(&self, slopes: &DMatrix<f64>, reaction: &DVector<f64>) -> Result<DVector<f64>, String> {
        let lengths: Vec<f64> = slopes.column_iter().map(|c| c.norm()).collect();
        // Rows are relative to the sum of all loads; a load a billion times weaker than that has no effect.
        if let Some(k) = lengths.iter().position(|&l| l <= 1e-9) {
            return Err(format!(
                "the loads `{}` have no effect on {}: choose another component, or another load for it",
                self.balance[k].load,
                self.in_words(|_| true)
            ));
        }
        let mut scaled = slopes.clone();
        for (mut column, length) in scaled.column_iter_mut().zip(&lengths) {
            column /= *length;
        }
        if let Some(row) = scaled.row_iter().position(|r| r.amax() <= DEPENDENT) {
            return Err(format!(
                "none of the loads that are solved for has an effect on {}",
                self.in_words(|k| k == row)
            ));
        }
        let decomposed = scaled.svd(true, true);
        if decomposed.singular_values.min() <= DEPENDENT * decomposed.singular_values.max() {
            let loads: Vec<String> = self.balance.iter().map(|b| format!("`{}`", b.load)).collect();
            return Err(format!(
                "the loads {} have the same effect on {}: their factors cannot be told apart",
                loads.join(", "),
                self.in_words(|_| true)
            ));
        }
        let step = decomposed.solve(&-reaction, 0.0).map_err(str::to_owned)?;
        Ok(DVector::from_iterator(step.len(), step.iter().zip(&lengths).map(|(s, l)| s / l)))
    }

    /// Factors that balance the rigid body as drawn: its reaction is linear in them. None where these cannot.
    fn rigid_factors(&self, path: &mut LoadPath<'_>) -> Option<DVector<f64>> {
        let n = self.balance.len();
        // The scales change with the factors; linear in these is the reaction over fixed ones.
        let scales = path.scales();
        let mut at = |factors: &DVector<f64>| {
            path.set_factors(&self.of_loads(factors));
            self.components(path, &path.reaction_as_drawn(), scales)
        };
        let none = at(&DVector::zeros(n));
        let mut slopes = DMatrix::zeros(n, n);
        for k in 0..n {
            let mut unit = DVector::zeros(n);
            unit[k] = 1.0;
            slopes.set_column(k, &(at(&unit) - &none));
        }
        self.solve_scaled(&slopes, &none).ok()
    }

    /// The components to be cancelled, relative to the sums of all forces and of all moments.
    fn components(
        &self,
        path: &LoadPath<'_>,
        reaction: &Vector6<f64>,
        (force, moment): (f64, f64),
    ) -> DVector<f64> {
        let in_g = path.in_g(reaction);
        DVector::from_iterator(
            self.balance.len(),
            self.balance.iter().map(|unknown| {
                let Component { index, inertial } = unknown.component;
                let value = if inertial { in_g[index] } else { reaction[index] };
                value / if index < 3 { force } else { moment }
            }),
        )
    }

    /// Factor on each load of the case.
    fn of_loads(&self, factors: &DVector<f64>) -> Vec<f64> {
        let factor =
            |name: &String| self.balance.iter().position(|b| b.load == *name).map_or(1.0, |k| factors[k]);
        self.names.iter().map(factor).collect()
    }

    /// 1 for the loads of a name, 0 for the others.
    fn share(&self, name: &str) -> Vec<f64> {
        self.names.iter().map(|n| f64::from(u8::from(n == name))).collect()
    }

    fn in_words(&self, which: impl Fn(usize) -> bool) -> String {
        let named = self.balance.iter().enumerate().filter(|(k, _)| which(*k));
        named.map(|(_, unknown)| unknown.component.to_string()).collect::<Vec<_>>().join(", ")
    }
}

impl std::fmt::Display for Component {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let axis = ["x", "y", "z"][self.index % 3];
        let axes = if self.inertial { "G" } else { "A" };
        match self.index < 3 {
            true => write!(f, "the force along {axis} of {axes}"),
            false => write!(f, "the moment about {axis} of {axes}"),
        }
    }
}
