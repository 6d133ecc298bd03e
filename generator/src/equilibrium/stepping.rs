//! The path from the drawing to the loaded structure: load steps, chosen by how the iteration fares, and stability on the way.

use nalgebra::Vector6;
use rom_runtime::loads::LoadCase;

use super::balance::Balance;
use super::error::EquilibriumError;
use super::newton::{Failure, Newton, moved};
use super::{Equilibrium, EquilibriumSettings, Stability, WhenUnstable};
use crate::configuration::Configuration;
use crate::element::internal_force::{split, stack};
use crate::mesh::Mesh;
use crate::solve::block_ldu::SingularPivot;

/// Most load steps a caller may ask for.
const MAX_STEPS: usize = 100_000;
/// Steps shorter than this are given up: by then a step changes a smooth path by less than its own predictor does.
const SHORTEST_STEP: f64 = 1e-6;
/// Relative width to which a loss of stability is enclosed.
const BUCKLING_WIDTH: f64 = 1e-4;
/// A step converged in so few iterations is followed by one twice as long.
const EASY: usize = 6;
/// Equilibria of one structure under growing loads, followed from its drawing.
pub struct LoadPath<'a> {
    balance: Balance<'a>,
    newton: Newton,
    settings: EquilibriumSettings,
    at: Configuration,
    factor: f64,
    stability: Stability,
    step: f64,
    load_steps: usize,
    refused_steps: usize,
}

impl<'a> LoadPath<'a> {
    /// Starts at the drawing, unloaded.
    ///
    /// # Errors
    /// Settings out of range, a load that is not a number, a mechanism.
    pub fn new(
        mesh: &'a Mesh,
        case: &LoadCase,
        settings: &EquilibriumSettings,
    ) -> Result<Self, EquilibriumError> {
        check(settings)?;
        let balance = Balance::new(mesh, case, settings)?;
        let mut path = Self {
            newton: Newton::new(&balance, settings.tolerance),
            balance,
            settings: *settings,
            at: Configuration::drawing(mesh),
            factor: 0.0,
            stability: Stability::Stable,
            step: 1.0 / settings.load_steps as f64,
            load_steps: 0,
            refused_steps: 0,
        };
        path.stability = path.judge(&path.at.clone(), 0.0)?;
        Ok(path)
    }

    /// Factor on the loads reached so far.
    pub fn load_factor(&self) -> f64 {
        self.factor
    }

    /// Relative corrections of the last Newton iteration, in order.
    pub fn corrections(&self) -> &[f64] {
        &self.newton.corrections
    }

    /// Follows the path to a load factor, up or down.
    ///
    /// # Errors
    /// No equilibrium within reach, loss of stability unless that is accepted, a mechanism, elements bent too far. The path stays at
    /// the last equilibrium found.
    pub fn advance_to(&mut self, target: f64) -> Result<(), EquilibriumError> {
        if !target.is_finite() {
            return Err(EquilibriumError::Setting {
                what: "the load factor",
                found: target.to_string(),
                expected: "a finite number",
            });
        }
        while self.factor != target {
            let left = target - self.factor;
            // A remainder much shorter than the step is not left over.
            let next =
                if left.abs() <= 1.01 * self.step { target } else { self.factor + self.step.copysign(left) };
            let before = self.newton.iterations;
            match self.newton.solve(&self.balance, &self.at, next) {
                Ok(at) => {
                    self.accept(at, next)?;
                    if self.newton.iterations - before <= EASY {
                        self.step *= 2.0;
                    }
                }
                Err(failure) => {
                    self.refused_steps += 1;
                    self.step = 0.5 * (next - self.factor).abs();
                    if self.step < SHORTEST_STEP {
                        return Err(self.failed(failure, next, target));
                    }
                }
            }
        }
        Ok(())
    }

    /// Reaction at the reference node: force (N) and moment about the origin (N m), in A.
    pub(crate) fn reaction(&self) -> Vector6<f64> {
        self.balance.reaction(&self.at, self.factor)
    }

    /// What the reaction would be on the undeformed body under the full loads.
    pub(crate) fn reaction_as_drawn(&self) -> Vector6<f64> {
        self.balance.reaction(&Configuration::drawing(self.balance.mesh), 1.0)
    }

    /// A force and a moment, given in A, in G.
    pub(crate) fn in_g(&self, wrench: &Vector6<f64>) -> Vector6<f64> {
        let (force, moment) = split(wrench);
        stack(&(self.balance.attitude * force), &(self.balance.attitude * moment))
    }

    /// Sums of the magnitudes of all forces and of all moments under the full loads, never zero.
    pub(crate) fn scales(&self) -> (f64, f64) {
        let (force, moment) = self.balance.scales(&self.at, 1.0);
        (force.max(f64::MIN_POSITIVE), moment.max(f64::MIN_POSITIVE))
    }

    /// Sets the factors on the loads of the case - (loads) - before the path is followed.
    pub(crate) fn set_factors(&mut self, factors: &[f64]) {
        self.balance.factors.copy_from_slice(factors);
    }

    /// Changes the factors on the loads at the load factor reached, and finds the equilibrium from the present one; where that is too
    /// far away, from the drawing.
    pub(crate) fn change_factors(&mut self, factors: &[f64]) -> Result<(), EquilibriumError> {
        self.set_factors(factors);
        if let Ok(at) = self.newton.solve(&self.balance, &self.at, self.factor) {
            return self.accept(at, self.factor);
        }
        let target = self.factor;
        self.refused_steps += 1;
        (self.at, self.factor) = (Configuration::drawing(self.balance.mesh), 0.0);
        self.step = 1.0 / self.settings.load_steps as f64;
        self.advance_to(target)
    }

    /// Derivative of the reaction in a common factor on the loads, each with its `share` of it, along the equilibria.
    pub(crate) fn reaction_slope(&mut self, share: &[f64]) -> Result<Vector6<f64>, EquilibriumError> {
        const DISPLACEMENT: f64 = 1e-5;
        const LARGEST: f64 = 1e-2;
        let (at, load_factor) = (&self.at, self.factor);
        let singular = |pivot: SingularPivot| singular(&self.balance, load_factor, pivot);
        let factor = self.newton.factorise(&self.balance, at, load_factor).map_err(singular)?;
        let mut shift = self.balance.assembly.gather(&self.balance.loads_of(at, share));
        factor.solve(&mut shift);
        // Differences by a displacement small enough to be linear and large enough to be seen.
        let change = (DISPLACEMENT / self.newton.length(&shift)).min(LARGEST);
        let factors = self.balance.factors.clone();
        let mut reaction = |change: f64| {
            for ((factor, share), own) in self.balance.factors.iter_mut().zip(share).zip(&factors) {
                *factor = own + change * share;
            }
            self.balance.reaction(&moved(&self.balance, at, &shift, change * load_factor), load_factor)
        };
        let slope = (reaction(change) - reaction(-change)) / (2.0 * change);
        self.balance.factors = factors;
        Ok(slope)
    }

    /// The equilibrium reached.
    pub fn equilibrium(&self) -> Equilibrium {
        let out = self.balance.residual(&self.at, self.factor);
        let held = self.balance.mesh.reference;
        let (reaction_force, reaction_moment) = split(&out.nodal[held]);
        let (force_scale, moment_scale) = self.balance.scales(&self.at, self.factor);
        Equilibrium {
            configuration: self.at.clone(),
            loads: self.balance.frozen_loads(self.factor),
            attitude: self.settings.attitude,
            factors: Vec::new(),
            beta: self.settings.beta,
            load_factor: self.factor,
            reaction_force,
            reaction_moment,
            force_scale,
            moment_scale,
            residual: out.worst(held).0,
            elastic_force: self.balance.assembly.elastic_force(&self.at),
            energy: out.energy,
            stability: self.stability,
            load_steps: self.load_steps,
            refused_steps: self.refused_steps,
            iterations: self.newton.iterations,
        }
    }

    /// The drawing under the full loads, with elastic forces that would carry them.
    pub(crate) fn as_drawn(&self) -> Equilibrium {
        let at = Configuration::drawing(self.balance.mesh);
        let (reaction_force, reaction_moment) = split(&self.balance.reaction(&at, 1.0));
        let (force_scale, moment_scale) = self.balance.scales(&at, 1.0);
        Equilibrium {
            loads: self.balance.frozen_loads(1.0),
            load_factor: 1.0,
            reaction_force,
            reaction_moment,
            force_scale,
            moment_scale,
            residual: 0.0,
            elastic_force: self.balance.applied(&at),
            energy: 0.0,
            stability: Stability::Stable,
            load_steps: 0,
            refused_steps: 0,
            iterations: 0,
            configuration: at,
            ..self.equilibrium()
        }
    }

    /// Takes an equilibrium over, unless it is the first unstable one: then the loss of stability is enclosed and reported.
    fn accept(&mut self, at: Configuration, factor: f64) -> Result<(), EquilibriumError> {
        let stability = self.judge(&at, factor)?;
        if stability.is_unstable() && self.settings.when_unstable == WhenUnstable::Refuse {
            return Err(self.enclose(stability, factor));
        }
        self.at = at;
        self.factor = factor;
        self.stability = stability;
        self.load_steps += 1;
        Ok(())
    }

    /// Bisects between the last stable equilibrium and an unstable one, and says where stability is lost.
    fn enclose(&mut self, mut stability: Stability, mut unstable_at: f64) -> EquilibriumError {
        while (unstable_at - self.factor).abs() > BUCKLING_WIDTH * unstable_at.abs() {
            let middle = 0.5 * (self.factor + unstable_at);
            let Ok(at) = self.newton.solve(&self.balance, &self.at, middle) else { break };
            let Ok(found) = self.judge(&at, middle) else { break };
            if found.is_unstable() {
                (stability, unstable_at) = (found, middle);
            } else {
                (self.at, self.factor, self.stability) = (at, middle, found);
                self.load_steps += 1;
            }
        }
        let (stable_at, load_factor) = (self.factor, unstable_at);
        match stability {
            Stability::Unstable { negative_eigenvalues } => {
                EquilibriumError::Buckling { stable_at, load_factor, negative_eigenvalues }
            }
            _ => EquilibriumError::Divergence { stable_at, load_factor },
        }
    }

    /// Stability of an equilibrium by the pivots of its tangent.
    fn judge(&mut self, at: &Configuration, factor: f64) -> Result<Stability, EquilibriumError> {
        let balance = &self.balance;
        let pivots =
            self.newton.factorise(balance, at, factor).map_err(|pivot| singular(balance, factor, pivot))?;
        if !balance.have_potential && factor != 0.0 {
            return Ok(Stability::Following { diverged: pivots.determinant_is_negative() == Some(true) });
        }
        // In equilibrium with such loads the tangent is symmetric.
        Ok(match pivots.negative_eigenvalues() {
            0 => Stability::Stable,
            negative_eigenvalues => Stability::Unstable { negative_eigenvalues },
        })
    }

    fn failed(&self, failure: Failure, next: f64, target: f64) -> EquilibriumError {
        let why = match failure {
            Failure::Singular(pivot) => {
                return singular(&self.balance, next, pivot);
            }
            Failure::Bent(bent) => {
                let member = &self.balance.mesh.members[self.balance.mesh.elements[bent.element].member];
                return EquilibriumError::CoarseElement {
                    load_factor: next,
                    member: member.name.clone(),
                    element: bent.element - member.elements.start + 1,
                    degrees: bent.angle.to_degrees(),
                };
            }
            Failure::Far => {
                "The nearest one is far away: the structure snaps through here, or passes a limit load; lower the loads or stiffen the structure"
            }
            Failure::Stalled | Failure::Slow => {
                "The structure may have reached a limit load, or the loads follow it without end; lower the loads, stiffen the structure or refine the mesh"
            }
        };
        let out = self.balance.residual(&self.at, next);
        let (residual, node) = out.worst(self.balance.mesh.reference);
        let place = self.balance.mesh.place(node);
        EquilibriumError::NotConverged { reached: self.factor, target, step: self.step, residual, place, why }
    }
}

fn singular(balance: &Balance<'_>, load_factor: f64, pivot: SingularPivot) -> EquilibriumError {
    let place = balance.mesh.place(balance.node_of(pivot.row));
    EquilibriumError::Singular { load_factor, place }
}

fn check(settings: &EquilibriumSettings) -> Result<(), EquilibriumError> {
    let refuse = |what, found: String, expected| Err(EquilibriumError::Setting { what, found, expected });
    if !settings.time.is_finite() {
        return refuse("the time of the loads", format!("{} s", settings.time), "a finite number");
    }
    if settings.beta.iter().any(|x| !x.is_finite()) {
        return refuse(
            "the steady velocity",
            format!("{:?}", settings.beta.as_slice()),
            "six finite numbers",
        );
    }
    if !(1..=MAX_STEPS).contains(&settings.load_steps) {
        return refuse("the number of load steps", settings.load_steps.to_string(), "1 to 100000");
    }
    if !(1e-14..=1e-3).contains(&settings.tolerance) {
        return refuse("the tolerance", settings.tolerance.to_string(), "1e-14 to 1e-3");
    }
    Ok(())
}
