//! The linear-flexible, nonlinear-rigid method: theory (21) with all structural degrees of freedom, and damping.

use std::sync::Arc;

use nalgebra::{Matrix6, Vector3, Vector6};

use super::damping::Damper;
use super::floating::{Forces, Rows};
use super::method::Prepared;
use crate::assembly::{AnyBeam, BlockMatrix};
use crate::element::internal_force::{split, stack};
use crate::element::station::Station;
use crate::section_probe::SectionProbe;
use crate::solve::block_ldu::{Factor, Symbolic};

/// `g = C(beta) (xdot, beta) + K(beta) x + Qstif_S(eta0)`, section by section: no matrix depends on `beta`.
pub struct LinearForces<'a> {
    prepared: &'a Prepared,
    damper: Damper,
    /// Damping of the strains.
    viscosity: Option<BlockMatrix>,
    two: Vec<Group<2>>,
    three: Vec<Group<3>>,
    masses: Vec<Group<1>>,
    sections: Vec<LinearSection>,
}

/// Sections that share nodes.
struct Group<const N: usize> {
    nodes: [Option<usize>; N],
    stations: Vec<Station<N>>,
}

impl<'a> LinearForces<'a> {
    /// About the equilibrium of `prepared`.
    pub fn new(prepared: &'a Prepared) -> Self {
        let Prepared { assembly, at, .. } = prepared;
        let block = |n: usize| assembly.unknown[n];
        let mut out = Self {
            prepared,
            damper: Damper::default(),
            viscosity: assembly.viscosity(at),
            two: Vec::new(),
            three: Vec::new(),
            masses: Vec::new(),
            sections: sections(prepared),
        };
        for beam in &assembly.beams {
            match beam {
                AnyBeam::Two(b) => {
                    out.two.push(Group { nodes: b.nodes.map(block), stations: Station::of_beam(b, at) });
                }
                AnyBeam::Three(b) => {
                    out.three.push(Group { nodes: b.nodes.map(block), stations: Station::of_beam(b, at) });
                }
            }
        }
        for lump in &assembly.lumped {
            out.masses.push(Group { nodes: [block(lump.node)], stations: vec![Station::of_mass(lump, at)] });
        }
        out
    }

    /// With damping in proportion to mass and modes.
    pub fn with_damper(self, damper: Damper) -> Self {
        Self { damper, ..self }
    }

    /// The gyroscopic part of `g` alone.
    pub fn add_gyroscopic(
        &self,
        x: &[Vector6<f64>],
        x_dot: &[Vector6<f64>],
        beta: &Vector6<f64>,
        out: &mut Rows,
    ) {
        self.two.iter().for_each(|g| g.add(x, x_dot, beta, out));
        self.three.iter().for_each(|g| g.add(x, x_dot, beta, out));
        self.masses.iter().for_each(|g| g.add(x, x_dot, beta, out));
    }
}

/// Section forces at a place, linear in the displacements of the block rows and their rates.
struct LinearSection {
    rest: Vector6<f64>,
    /// `S B` and `S tau B` by block row.
    maps: Vec<(usize, [Matrix6<f64>; 2])>,
}

impl LinearSection {
    fn at(&self, x: &[Vector6<f64>], x_dot: &[Vector6<f64>]) -> Vector6<f64> {
        self.maps
            .iter()
            .fold(self.rest, |sum, (i, [elastic, viscous])| sum + elastic * x[*i] + viscous * x_dot[*i])
    }
}

/// The places of the structure file. About the drawing the elastic forces of the equilibrium are imposed: what they take of the linear
/// structure is added to what its strains tell.
fn sections(prepared: &Prepared) -> Vec<LinearSection> {
    let Prepared { assembly, at, probes, .. } = prepared;
    if probes.is_empty() {
        return Vec::new();
    }
    let strained = assembly.gather(&assembly.elastic_force(at));
    let mut imposed: Vec<Vector6<f64>> =
        prepared.elastic_force.iter().zip(&strained).map(|(all, strained)| all - strained).collect();
    let mut factor = Factor::new(Arc::new(Symbolic::new(assembly.pattern.clone())));
    if factor.refactor(&prepared.stiffness).is_ok() {
        factor.solve(&mut imposed);
    }
    let none = vec![Vector6::zeros(); imposed.len()];
    let of = |probe: &SectionProbe| {
        let both =
            probe.stress_maps(&assembly.beams, at).into_iter().zip(probe.viscous_maps(&assembly.beams, at));
        let row = |((node, elastic), (_, viscous))| Some((assembly.unknown[node]?, [elastic, viscous]));
        let mut out =
            LinearSection { rest: probe.stress(&assembly.beams, at), maps: both.filter_map(row).collect() };
        out.rest = out.at(&imposed, &none);
        out
    };
    probes.iter().map(of).collect()
}

impl Forces for LinearForces<'_> {
    fn add(&self, x: &[Vector6<f64>], x_dot: &[Vector6<f64>], beta: &Vector6<f64>, out: &mut Rows) {
        let mut elastic = vec![Vector6::zeros(); x.len()];
        self.prepared.stiffness.multiply(x, &mut elastic);
        for ((row, f), steady) in out.s.iter_mut().zip(elastic).zip(&self.prepared.elastic_force) {
            *row += f + steady;
        }
        if let Some(viscosity) = &self.viscosity {
            let mut force = vec![Vector6::zeros(); x.len()];
            viscosity.multiply(x_dot, &mut force);
            out.s.iter_mut().zip(force).for_each(|(row, f)| *row += f);
        }
        self.damper.add(&self.prepared.mass, x_dot, out);
        self.add_gyroscopic(x, x_dot, beta, out);
    }

    fn tangent(&self, _: &[Vector6<f64>], rate_factor: f64) -> BlockMatrix {
        let stiffness = &self.prepared.stiffness;
        self.viscosity.as_ref().map_or_else(|| stiffness.clone(), |d| stiffness.plus(rate_factor, d))
    }

    fn has_constant_tangent(&self) -> bool {
        true
    }

    fn sections(&self, x: &[Vector6<f64>], x_dot: &[Vector6<f64>]) -> Vec<Vector6<f64>> {
        self.sections.iter().map(|section| section.at(x, x_dot)).collect()
    }

    fn elastic_energy(&self, x: &[Vector6<f64>]) -> f64 {
        let mut force = vec![Vector6::zeros(); x.len()];
        self.prepared.stiffness.multiply(x, &mut force);
        let steady = self.prepared.elastic_force.iter();
        let stored = self.prepared.equilibrium.as_ref().map_or(0.0, |found| found.energy);
        stored
            + x.iter().zip(force).zip(steady).map(|((x, f), steady)| x.dot(&(f * 0.5 + steady))).sum::<f64>()
    }
}

/// `A_VW m` for a section velocity `(v, w)`.
fn a_vw(v: &Vector3<f64>, w: &Vector3<f64>, m: &Vector6<f64>) -> Vector6<f64> {
    let (a, b) = split(m);
    stack(&w.cross(&a), &(v.cross(&a) + w.cross(&b)))
}

/// `-A_VW^t d`: the velocity that a displacement `d` makes of the rigid one.
fn minus_a_vw_t(v: &Vector3<f64>, w: &Vector3<f64>, d: &Vector6<f64>) -> Vector6<f64> {
    let (a, b) = split(d);
    stack(&(w.cross(&a) + v.cross(&b)), &w.cross(&b))
}

/// `A_PH d` for a section momentum `(p, h)`.
fn a_ph(p: &Vector3<f64>, h: &Vector3<f64>, d: &Vector6<f64>) -> Vector6<f64> {
    let (a, b) = split(d);
    stack(&p.cross(&b), &(p.cross(&a) + h.cross(&b)))
}

impl<const N: usize> Group<N> {
    fn add(&self, x: &[Vector6<f64>], x_dot: &[Vector6<f64>], beta: &Vector6<f64>, out: &mut Rows) {
        let zero = Vector6::zeros();
        let local = |all: &[Vector6<f64>]| self.nodes.map(|n| n.map_or(zero, |i| all[i]));
        let (x, x_dot) = (local(x), local(x_dot));
        for station in &self.stations {
            let (on_nodes, on_frame) = station.forces(&x, &x_dot, beta);
            for (node, force) in self.nodes.iter().zip(on_nodes) {
                if let Some(i) = node {
                    out.s[*i] += force;
                }
            }
            out.r += on_frame;
        }
    }
}

impl<const N: usize> Station<N> {
    /// Gyroscopic forces of the section on its nodes and on A (theory section 3, all operators applied at once).
    fn forces(
        &self,
        x: &[Vector6<f64>; N],
        x_dot: &[Vector6<f64>; N],
        beta: &Vector6<f64>,
    ) -> ([Vector6<f64>; N], Vector6<f64>) {
        let (mut s, mut d) = (Vector6::zeros(), Vector6::zeros());
        for a in 0..N {
            s += self.j[a] * x_dot[a];
            d += self.j[a] * x[a];
        }
        let rigid = self.a_rc * beta;
        let (v, w) = split(&rigid);
        let momentum = self.mass * rigid;
        let (p, h) = split(&momentum);
        let e = minus_a_vw_t(&v, &w, &d);
        let steady = a_vw(&v, &w, &momentum);
        // A_VW (P + M (s + e)) + M (-A_VW^t s) - A_PH s, common to both rows.
        let common = steady + a_vw(&v, &w, &(self.mass * (s + e))) + self.mass * minus_a_vw_t(&v, &w, &s)
            - a_ph(&p, &h, &s);
        let (f, _) = split(&steady);
        let turned_force = stack(&-f.cross(&split(&d).1), &Vector3::zeros());
        let structural = common - a_ph(&p, &h, &e) + turned_force;
        let frame = common - a_vw(&v, &w, &a_ph(&p, &h, &d));
        let on_nodes = std::array::from_fn(|a| {
            let mut force = self.j[a].tr_mul(&structural);
            let turned: Vector3<f64> = (0..N).map(|b| self.turning(&steady, a, b) * split(&x[b]).1).sum();
            force += stack(&Vector3::zeros(), &turned);
            force
        });
        (on_nodes, self.a_rc.tr_mul(&frame))
    }
}
