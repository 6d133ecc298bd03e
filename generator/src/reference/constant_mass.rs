//! The nonlinear method with the mass matrix of the equilibrium kept constant (dashed curves of the paper's Fig. 11).
//!
//! Elastic and gyroscopic forces are the full nonlinear ones of theory section 2. They come from the forces on the absolute
//! motion of the nodes, at the accelerations the nodes have when `(xddot, betadot) = 0`:
//! `Rddot = 2 w x Rdot + w x (v + w x R)`, and for spins `Tdot thetadot - Om x Q^t w`.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::damping::Damper;
use super::floating::{Forces, Rows};
use super::method::Prepared;
use crate::assembly::{AnyBeam, BlockMatrix};
use crate::configuration::Configuration;
use crate::element::beam::{Beam, BeamState};
use crate::element::inertia_force::{BeamRates, SectionMotion, inertia_force};
use crate::element::internal_force::{force_of_stresses, internal_force, spin_tangent, split, stack};
use crate::element::viscous::viscous_stresses;
use crate::math::so3::MatrixFunction;
use crate::section_probe::SectionProbe;

/// Full nonlinear forces about the equilibrium of `prepared`.
pub struct NonlinearForces<'a> {
    prepared: &'a Prepared,
    damper: Damper,
}

/// Motion of a node in A's axes at an instant, and the derivative of its rotation in `theta`.
#[derive(Clone, Copy)]
struct NodeMotion {
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    spin: Vector3<f64>,
    spin_rate: Vector3<f64>,
    tangential: nalgebra::Matrix3<f64>,
}

impl<'a> NonlinearForces<'a> {
    /// About the equilibrium of `prepared`.
    pub fn new(prepared: &'a Prepared) -> Self {
        Self { prepared, damper: Damper::default() }
    }

    /// With damping in proportion to mass and modes.
    pub fn with_damper(self, damper: Damper) -> Self {
        Self { damper, ..self }
    }

    fn node_motion(
        &self,
        node: usize,
        now: &Configuration,
        x: &[Vector6<f64>],
        x_dot: &[Vector6<f64>],
        beta: &Vector6<f64>,
    ) -> NodeMotion {
        let (v, w) = split(beta);
        let zero = Vector3::zeros();
        let (theta, r_dot, theta_dot) =
            self.prepared.assembly.unknown[node].map_or((zero, zero, zero), |i| {
                let (r_dot, theta_dot) = split(&x_dot[i]);
                (split(&x[i]).1, r_dot, theta_dot)
            });
        let t = MatrixFunction::tangential(&theta);
        let (relative, w_node) = (t.matrix() * theta_dot, now.rotations[node].inverse() * w);
        let carried = v + w.cross(&now.positions[node]);
        NodeMotion {
            velocity: r_dot + carried,
            acceleration: w.cross(&r_dot) * 2.0 + w.cross(&carried),
            spin: relative + w_node,
            spin_rate: t.rate(&theta_dot) * theta_dot - relative.cross(&w_node),
            tangential: t.matrix(),
        }
    }

    fn add_beam<const N: usize>(
        &self,
        beam: &Beam<N>,
        now: &Configuration,
        motion: &[NodeMotion],
        out: &mut Rows,
    ) {
        let state: BeamState<N> = now.of(beam);
        let of = |f: fn(&NodeMotion) -> Vector3<f64>| beam.nodes.map(|n| f(&motion[n]));
        let nodal = BeamRates {
            velocity: of(|m| m.velocity),
            spin: of(|m| m.spin),
            acceleration: of(|m| m.acceleration),
            spin_rate: of(|m| m.spin_rate),
        };
        let rates = beam.end_rates(&state, nodal);
        let mut elastic = internal_force(beam, &state).force;
        if beam.is_viscous() {
            let origin = motion[beam.nodes[0]].velocity;
            let nodal = beam.nodes.map(|n| stack(&(motion[n].velocity - origin), &motion[n].spin));
            let viscous = force_of_stresses(beam, &state, &viscous_stresses(beam, &state, &nodal));
            elastic.iter_mut().zip(viscous).for_each(|(f, v)| *f += v);
        }
        let inertia = inertia_force(beam, &state, &rates);
        for a in 0..N {
            self.add_node(beam.nodes[a], now, motion, &elastic[a], &inertia[a], out);
        }
    }

    /// Elastic and inertia force on a node; elastic forces have no resultant on A.
    fn add_node(
        &self,
        node: usize,
        now: &Configuration,
        motion: &[NodeMotion],
        elastic: &Vector6<f64>,
        inertia: &Vector6<f64>,
        out: &mut Rows,
    ) {
        if let Some(i) = self.prepared.assembly.unknown[node] {
            let (f, m) = split(&(elastic + inertia));
            out.s[i] += stack(&f, &motion[node].tangential.tr_mul(&m));
        }
        let (f, m) = split(inertia);
        out.r += stack(&f, &(now.positions[node].cross(&f) + now.rotations[node] * m));
    }
}

impl Forces for NonlinearForces<'_> {
    fn add(&self, x: &[Vector6<f64>], x_dot: &[Vector6<f64>], beta: &Vector6<f64>, out: &mut Rows) {
        let now = self.prepared.displaced(x);
        let motion: Vec<NodeMotion> =
            (0..now.positions.len()).map(|n| self.node_motion(n, &now, x, x_dot, beta)).collect();
        for beam in &self.prepared.assembly.beams {
            match beam {
                AnyBeam::Two(b) => self.add_beam(b, &now, &motion, out),
                AnyBeam::Three(b) => self.add_beam(b, &now, &motion, out),
            }
        }
        for lump in &self.prepared.assembly.lumped {
            let (q, m) = (now.rotation_matrix(lump.node), &motion[lump.node]);
            let section =
                SectionMotion::new(&q, &lump.mass, &m.velocity, &m.acceleration, &m.spin, &m.spin_rate);
            let inertia = stack(&(q * section.force), &section.moment);
            self.add_node(lump.node, &now, &motion, &Vector6::zeros(), &inertia, out);
        }
        self.damper.add(&self.prepared.mass, x_dot, out);
    }

    /// Tangent of the elastic forces in spins; the difference to that in `theta` is of the order of the forces times `theta`
    /// and only slows the iteration.
    fn tangent(&self, x: &[Vector6<f64>], rate_factor: f64) -> BlockMatrix {
        let now = self.prepared.displaced(x);
        let one = nalgebra::Matrix3::identity();
        let assembly = &self.prepared.assembly;
        let mut k = BlockMatrix::zeros(self.prepared.stiffness.pattern.clone());
        for beam in &assembly.beams {
            match beam {
                AnyBeam::Two(b) => assembly.add(&mut k, &b.nodes, &spin_tangent(b, &now.of(b), &[one; 2]).1),
                AnyBeam::Three(b) => {
                    assembly.add(&mut k, &b.nodes, &spin_tangent(b, &now.of(b), &[one; 3]).1)
                }
            }
        }
        if let Some(viscosity) = assembly.viscosity(&now) {
            k = k.plus(rate_factor, &viscosity);
        }
        for (i, x) in x.iter().enumerate() {
            let mut t = Matrix6::identity();
            let tangential = MatrixFunction::tangential(&split(x).1).matrix();
            t.fixed_view_mut::<3, 3>(3, 3).copy_from(&tangential);
            turn_rows_and_columns(&mut k, i, &t);
        }
        k
    }

    fn has_constant_tangent(&self) -> bool {
        false
    }

    fn sections(&self, x: &[Vector6<f64>], x_dot: &[Vector6<f64>]) -> Vec<Vector6<f64>> {
        if self.prepared.probes.is_empty() {
            return Vec::new();
        }
        let now = self.prepared.displaced(x);
        // A stands still: a rigid motion strains nothing.
        let rate = |node: usize| {
            self.prepared.assembly.unknown[node].map_or(Vector6::zeros(), |i| {
                let ((_, theta), (r_dot, theta_dot)) = (split(&x[i]), split(&x_dot[i]));
                stack(&r_dot, &(MatrixFunction::tangential(&theta).matrix() * theta_dot))
            })
        };
        let beams = &self.prepared.assembly.beams;
        let of = |probe: &SectionProbe| {
            probe.stress_moving(beams, |n| now.positions[n], |n| now.rotation_matrix(n), rate)
        };
        self.prepared.probes.iter().map(of).collect()
    }

    fn elastic_energy(&self, x: &[Vector6<f64>]) -> f64 {
        let now = self.prepared.displaced(x);
        self.prepared
            .assembly
            .beams
            .iter()
            .map(|beam| match beam {
                AnyBeam::Two(b) => internal_force(b, &now.of(b)).energy,
                AnyBeam::Three(b) => internal_force(b, &now.of(b)).energy,
            })
            .sum()
    }
}

/// `T^t K` on block row `i` and `K T` on block column `i`.
fn turn_rows_and_columns(k: &mut BlockMatrix, i: usize, t: &Matrix6<f64>) {
    let pattern = k.pattern.clone();
    for (j, slot) in pattern.row(i) {
        k.values[slot] = t.tr_mul(&k.values[slot]);
        if let Some(mirrored) = pattern.slot(j, i) {
            k.values[mirrored] *= t;
        }
    }
}
