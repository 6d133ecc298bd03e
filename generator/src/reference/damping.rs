//! Damping of the finite-element methods in proportion to mass and to modes (theory section 10). That of the strains is with the
//! elements ([`crate::element::viscous`]).
//!
//! ```text
//! linear, constant mass    alpha M_eff xdot + sum_i psi_i 2 zeta_i omega_i (psi_i . xdot),   psi_i = M_eff phi_S,i
//! nonlinear                alpha M(eta) (nu - nu_T) on the nodes, nu_T the rigid motion that has the momenta of nu;
//!                          psi_i 2 zeta_i omega_i (psi_i . (Rdot, w)) in frame A, the reference node carrying the opposite
//! ```
//!
//! Neither part has a resultant, and neither feels a rigid motion. For a clamped structure `M_eff` is `M_SS` and `nu_T` the motion of
//! its base, which takes the resultant.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::floating::Rows;
use super::method::Prepared;
use super::motion::Motion;
use crate::assembly::{AnyBeam, Assembly, MassMatrix};
use crate::element::beam::Beam;
use crate::element::inertia::{ElementMass, mass, rigid_map};
use crate::element::internal_force::{split, stack};
use crate::mesh::{LumpedMass, Support};
use crate::reduce::modes::elastic_modes;

/// Damping in proportion to mass and modes about the equilibrium of a structure.
#[derive(Clone, Debug, Default)]
pub struct Damper {
    alpha: f64,
    support: Support,
    modal: Vec<ModalForce>,
}

/// Damping of one mode: `psi factor (psi . xdot)`.
#[derive(Clone, Debug)]
struct ModalForce {
    /// `M_eff phi_S` - (block rows).
    psi: Vec<Vector6<f64>>,
    /// `2 zeta omega`, rad/s.
    factor: f64,
}

/// `M_eff x = (M_SS - M_SR M_RR^{-1} M_RS) x`: momenta of the displacements of a body that is free to follow; `M_SS x` where it is clamped.
pub(crate) fn effective_mass_times(
    mass: &MassMatrix,
    support: Support,
    x: &[Vector6<f64>],
) -> Vec<Vector6<f64>> {
    let mut out = vec![Vector6::zeros(); x.len()];
    mass.ss.multiply(x, &mut out);
    if support == Support::Clamped {
        return out;
    }
    let momentum: Vector6<f64> = mass.sr.iter().zip(x).map(|(sr, x)| sr.tr_mul(x)).sum();
    let rigid = mass.rr.try_inverse().unwrap_or_else(Matrix6::zeros) * momentum;
    for (out, sr) in out.iter_mut().zip(&mass.sr) {
        *out -= sr * rigid;
    }
    out
}

impl Damper {
    /// What the structure asks for.
    ///
    /// # Errors
    /// Modes that cannot be computed, in words.
    pub fn new(prepared: &Prepared) -> Result<Self, String> {
        let damping = &prepared.mesh.damping;
        let Prepared { assembly, at, mass, stiffness, .. } = prepared;
        let count = damping.modal.count().min(6 * assembly.n_blocks());
        let mut modal = Vec::new();
        if count > 0 {
            let modes = elastic_modes(assembly, at, mass, stiffness, count)
                .map_err(|e| format!("the modes that are damped: {e}"))?;
            for (j, omega) in modes.omega.iter().enumerate() {
                let factor = 2.0 * damping.modal.of(j + 1) * omega;
                if factor == 0.0 {
                    continue;
                }
                let nodal: Vec<Vector6<f64>> =
                    (0..at.positions.len()).map(|node| modes.at_node(node)[j]).collect();
                let psi = effective_mass_times(mass, assembly.support, &assembly.gather(&nodal));
                modal.push(ModalForce { psi, factor });
            }
        }
        Ok(Self { alpha: damping.alpha, support: assembly.support, modal })
    }

    /// Whether there is anything to add.
    pub(crate) fn acts(&self) -> bool {
        self.alpha != 0.0 || !self.modal.is_empty()
    }

    /// Adds the forces of rates `xdot` in frame A; they have no resultant on A.
    pub(crate) fn add(&self, mass: &MassMatrix, x_dot: &[Vector6<f64>], out: &mut Rows) {
        if self.alpha != 0.0 {
            for (row, momentum) in out.s.iter_mut().zip(effective_mass_times(mass, self.support, x_dot)) {
                *row += momentum * self.alpha;
            }
        }
        for ModalForce { psi, factor } in &self.modal {
            let rate: f64 = psi.iter().zip(x_dot).map(|(psi, x)| psi.dot(x)).sum();
            for (row, psi) in out.s.iter_mut().zip(psi) {
                *row += psi * (factor * rate);
            }
        }
    }

    /// Adds the forces on the nodes of a body in motion: force in G, moment in the node frame.
    pub(crate) fn add_absolute(
        &self,
        assembly: &Assembly,
        reference: usize,
        motion: &Motion,
        residual: &mut [Vector6<f64>],
    ) {
        if self.alpha != 0.0 {
            MassProportional::new(assembly, reference, motion).add(self.alpha, residual);
        }
        if !self.modal.is_empty() {
            self.add_modal(assembly, reference, motion, residual);
        }
    }

    /// Modal part: the rates relative to frame A in, forces relative to it out, the opposite on the reference node.
    fn add_modal(
        &self,
        assembly: &Assembly,
        reference: usize,
        motion: &Motion,
        residual: &mut [Vector6<f64>],
    ) {
        let frame = motion.rotation[reference];
        let (v, w) = (motion.velocity[reference], motion.spin[reference]);
        let place = |node: usize| frame.inverse() * (motion.position[node] - motion.position[reference]);
        let turn = |node: usize| frame.inverse() * motion.rotation[node];
        let mut rates = vec![Vector6::zeros(); assembly.n_blocks()];
        for (node, unknown) in assembly.unknown.iter().enumerate() {
            let Some(i) = unknown else { continue };
            let moved = frame.inverse() * (motion.velocity[node] - v) - w.cross(&place(node));
            rates[*i] = stack(&moved, &(motion.spin[node] - turn(node).inverse() * w));
        }
        let mut force = vec![Vector6::zeros(); rates.len()];
        for ModalForce { psi, factor } in &self.modal {
            let rate: f64 = psi.iter().zip(&rates).map(|(psi, x)| psi.dot(x)).sum();
            for (force, psi) in force.iter_mut().zip(psi) {
                *force += psi * (factor * rate);
            }
        }
        let (mut sum, mut moment_sum) = (Vector3::zeros(), Vector3::zeros());
        for (node, unknown) in assembly.unknown.iter().enumerate() {
            let Some(i) = unknown else { continue };
            let (f, m) = split(&force[*i]);
            sum += f;
            moment_sum += place(node).cross(&f) + turn(node) * m;
            residual[node] += stack(&(frame * f), &m);
        }
        residual[reference] -= stack(&(frame * sum), &moment_sum);
    }
}

/// Momenta of the nodes about the reference node, and the rigid motion with the same ones.
struct MassProportional<'a> {
    assembly: &'a Assembly,
    origin: Vector3<f64>,
    motion: &'a Motion,
    /// Velocity of the origin and angular velocity, in G.
    rigid: Vector6<f64>,
}

impl<'a> MassProportional<'a> {
    fn new(assembly: &'a Assembly, reference: usize, motion: &'a Motion) -> Self {
        let origin = motion.position[reference];
        let mut out = Self { assembly, origin, motion, rigid: Vector6::zeros() };
        if assembly.support == Support::Clamped {
            // Relative to the base.
            let w = motion.rotation[reference] * motion.spin[reference];
            out.rigid = stack(&motion.velocity[reference], &w);
            return out;
        }
        let (mut rr, mut momentum) = (Matrix6::zeros(), Vector6::zeros());
        out.visit(|nodes, _, sr, inertia| {
            rr += inertia;
            momentum += nodes.iter().zip(sr).map(|(&n, sr)| sr.tr_mul(&out.rates(n))).sum::<Vector6<f64>>();
        });
        out.rigid = rr.try_inverse().unwrap_or_else(Matrix6::zeros) * momentum;
        out
    }

    /// Velocity (in G) and spin (node frame) of a node less those of the rigid motion.
    fn rates(&self, node: usize) -> Vector6<f64> {
        let motion = self.motion;
        let (v, w) = split(&self.rigid);
        let velocity = motion.velocity[node] - v - w.cross(&(motion.position[node] - self.origin));
        stack(&velocity, &(motion.spin[node] - motion.rotation[node].inverse() * w))
    }

    fn add(&self, alpha: f64, residual: &mut [Vector6<f64>]) {
        self.visit(|nodes, ss, _, _| {
            for (a, &node) in nodes.iter().enumerate() {
                for (b, &other) in nodes.iter().enumerate() {
                    residual[node] += ss[a * nodes.len() + b] * self.rates(other) * alpha;
                }
            }
        });
    }

    /// Every element and mass: nodes, mass blocks between them, blocks to the rigid motion, and of it.
    fn visit(&self, mut see: impl FnMut(&[usize], &[Matrix6<f64>], &[Matrix6<f64>], &Matrix6<f64>)) {
        fn flat<const N: usize>(m: &ElementMass<N>) -> Vec<Matrix6<f64>> {
            m.ss.iter().flatten().copied().collect()
        }
        fn of<const N: usize>(this: &MassProportional<'_>, b: &Beam<N>) -> ElementMass<N> {
            let mut state = this.motion.of(b);
            state.positions.iter_mut().for_each(|p| *p -= this.origin);
            mass(b, &state)
        }
        for beam in &self.assembly.beams {
            match beam {
                AnyBeam::Two(b) => {
                    let m = of(self, b);
                    see(&b.nodes, &flat(&m), &m.sr, &m.rr);
                }
                AnyBeam::Three(b) => {
                    let m = of(self, b);
                    see(&b.nodes, &flat(&m), &m.sr, &m.rr);
                }
            }
        }
        for lump in &self.assembly.lumped {
            let m = self.lump(lump);
            see(&[lump.node], &[m.ss[0][0]], &m.sr, &m.rr);
        }
    }

    fn lump(&self, lump: &LumpedMass) -> ElementMass<1> {
        let q = self.motion.rotation_matrix(lump.node);
        let a_rc = rigid_map(&q, &(self.motion.position[lump.node] - self.origin));
        let mut j = Matrix6::identity();
        j.fixed_view_mut::<3, 3>(0, 0).copy_from(&q.transpose());
        ElementMass {
            ss: [[j.transpose() * lump.mass * j]],
            sr: [j.transpose() * lump.mass * a_rc],
            rr: a_rc.transpose() * lump.mass * a_rc,
        }
    }
}
