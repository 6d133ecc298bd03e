//! Section forces at places along the members, as functions of the reduced model's state (theory section 15).
//!
//! The fields `y = K_SS^-1 B^t S e_a` are the static response to a unit dislocation of the section, with A held. By reciprocity the
//! section force that a force `f` on the structure makes is `y^t f`:
//!
//! ```text
//! K_SS x = Qext_S - Qstif_S(eta0) - inertia_S - D xdot        =>        S B x = y^t (Qext_S - Qstif_S(eta0) - inertia_S - D xdot)
//! ```
//!
//! Inertia is projected as the tensors are, with `y` in the place of a mode that leaves A where it is.

use nalgebra::{Matrix6, Vector6};
use rom_runtime::data::{CutData, SummationData};

use super::lagrangian::CarriedPlace;
use super::modes::Modes;
use super::tensors::project;
use super::weight::second_moment;
use crate::assembly::{Assembly, BlockMatrix, MassMatrix};
use crate::configuration::Configuration;
use crate::mesh::{Damping, Mesh};
use crate::section_probe::SectionProbe;
use crate::solve::eigen::FreeBody;

/// Fields projected at a time: as many as a model has modes, so that the cost is linear in their number.
const CUTS_AT_ONCE: usize = 4;

/// What the section forces are made from.
pub struct Sections<'a> {
    /// The structure.
    pub mesh: &'a Mesh,
    /// Its elements.
    pub assembly: &'a Assembly,
    /// The equilibrium.
    pub at: &'a Configuration,
    /// Mass about it.
    pub mass: &'a MassMatrix,
    /// Its stiffness, factorised.
    pub body: &'a FreeBody<'a>,
    /// Modes kept.
    pub modes: &'a Modes,
    /// Their numbers.
    pub numbers: &'a [usize],
    /// `Qstif_S(eta0)` node by node; none about the unloaded structure.
    pub elastic_force: Option<&'a [Vector6<f64>]>,
}

impl Sections<'_> {
    /// Section forces at every place of the mesh; with `summation` for loads on `places`, else by the modes alone.
    pub fn cuts(&self, places: &[CarriedPlace], summation: bool) -> Vec<CutData> {
        let mesh = self.mesh;
        if mesh.cuts.is_empty() {
            return Vec::new();
        }
        let viscosity = self.assembly.viscosity(self.at);
        let imposed = self.imposed();
        let mut out = Vec::with_capacity(mesh.cuts.len());
        for some in mesh.cuts.chunks(CUTS_AT_ONCE) {
            let probes: Vec<SectionProbe> = some.iter().map(|cut| SectionProbe::new(mesh, cut)).collect();
            let fields: Vec<Vec<Vector6<f64>>> =
                probes.iter().flat_map(|probe| self.dislocations(probe)).collect();
            let mut found = summation.then(|| self.summed(&fields, places, viscosity.as_ref()).into_iter());
            for ((cut, probe), fields) in some.iter().zip(&probes).zip(fields.chunks_exact(6)) {
                let mut rest = probe.stress(&self.assembly.beams, self.at);
                let mut constant = rest;
                for (a, y) in fields.iter().enumerate() {
                    // About the drawing the elastic forces are imposed: no strains stand for them.
                    rest[a] += dot(y, &imposed.0);
                    constant[a] = rest[a] - dot(y, &imposed.1);
                }
                let (modal, rate) = self.of_modes(probe);
                let mut summation = found.as_mut().and_then(Iterator::next);
                if let Some(summation) = &mut summation {
                    summation.constant = constant.into();
                    // Viscous section forces are in the strains of the modes; what they do elsewhere was summed.
                    summation.damping.iter_mut().zip(&rate).for_each(|(d, own)| *d -= own);
                }
                out.push(CutData {
                    name: cut.name.clone(),
                    member: mesh.members[cut.member].name.clone(),
                    fraction: cut.fraction,
                    rest: rest.into(),
                    modal,
                    modal_rate: if viscosity.is_some() { rate } else { Vec::new() },
                    summation,
                });
            }
        }
        out
    }

    /// `Qstif_S(eta0)` over the block rows: the part that no strains make, and all of it.
    fn imposed(&self) -> (Vec<Vector6<f64>>, Vec<Vector6<f64>>) {
        let Some(all) = self.elastic_force else {
            let zero = vec![Vector6::zeros(); self.assembly.n_blocks()];
            return (zero.clone(), zero);
        };
        let strained = self.assembly.gather(&self.assembly.elastic_force(self.at));
        let all = self.assembly.gather(all);
        (all.iter().zip(&strained).map(|(all, strained)| all - strained).collect(), all)
    }

    /// The six fields of a place, over the block rows.
    fn dislocations(&self, probe: &SectionProbe) -> Vec<Vec<Vector6<f64>>> {
        let maps = probe.stress_maps(&self.assembly.beams, self.at);
        let mut fields: Vec<_> = (0..6)
            .map(|a| {
                let mut field = vec![Vector6::zeros(); self.assembly.n_blocks()];
                for (node, map) in &maps {
                    if let Some(i) = self.assembly.unknown[*node] {
                        field[i] += map.row(a).transpose();
                    }
                }
                field
            })
            .collect();
        self.body.held_responses(&mut fields);
        fields
    }

    /// Section forces per unit amplitude of each mode and per unit rate, where strains are damped - (6 x m).
    fn of_modes(&self, probe: &SectionProbe) -> (Vec<f64>, Vec<f64>) {
        let m = self.modes.m();
        let shapes = |maps: Vec<(usize, Matrix6<f64>)>| {
            let of_mode = |j: usize| maps.iter().map(|(node, map)| map * self.modes.at_node(*node)[j]).sum();
            let columns: Vec<Vector6<f64>> = (0..m).map(of_mode).collect();
            (0..6).flat_map(|a| columns.iter().map(move |s| s[a]).collect::<Vec<_>>()).collect()
        };
        let beams = &self.assembly.beams;
        (shapes(probe.stress_maps(beams, self.at)), shapes(probe.viscous_maps(beams, self.at)))
    }

    /// What loads, weight, inertia and damping make at a few places; the constant part is left to the caller.
    fn summed(
        &self,
        fields: &[Vec<Vector6<f64>>],
        places: &[CarriedPlace],
        viscosity: Option<&BlockMatrix>,
    ) -> Vec<SummationData> {
        let (modes, m) = (self.modes, self.modes.m());
        let with_fields = self.with_fields(fields);
        let tensors = project(self.assembly, self.at, &with_fields);
        let all = with_fields.m();
        let second = second_moment(self.assembly, self.at, &with_fields);
        let of_modes = self.modal_momenta();
        let damped: Vec<Vec<Vector6<f64>>> = match viscosity {
            None => Vec::new(),
            Some(d) => (0..m).map(|l| product(d, &self.shape(l))).collect(),
        };
        let columns = || (0..m).chain(all..all + 6);
        let field_of = |cut: usize, a: usize| 6 * cut + a;
        let rows = |cut: usize| (0..6).map(move |a| field_of(cut, a));
        let Damping { alpha, modal, .. } = &self.mesh.damping;
        (0..fields.len() / 6)
            .map(|cut| {
                let mut out = SummationData::default();
                for field in rows(cut) {
                    let (y, i) = (&fields[field], m + field);
                    let inertia: Vec<f64> = of_modes.iter().map(|p| dot(y, p)).collect();
                    let rigid: Vector6<f64> = y.iter().zip(&self.mass.sr).map(|(y, sr)| sr.tr_mul(y)).sum();
                    for (l, inertia) in inertia.iter().enumerate() {
                        let ratio = alpha + 2.0 * modal.of(self.numbers[l]) * modes.omega[l];
                        let strains = damped.get(l).map_or(0.0, |d| dot(y, d));
                        out.damping.push(strains + ratio * inertia);
                    }
                    out.inertia.extend(inertia.iter().chain(rigid.iter()));
                    out.c.extend(columns().flat_map(|l| tensors.c.iter().map(move |c| c[(i, l)])));
                    out.k.extend((0..m).flat_map(|l| tensors.k.iter().map(move |k| k[(i, l)])));
                    if !second.is_empty() {
                        let h = |k: usize, l: usize| second[(k * all + i) * all + l];
                        out.gravity
                            .extend((0..m).flat_map(|l| (0..3).map(move |k| (k, l))).map(|(k, l)| h(k, l)));
                    }
                }
                for place in places {
                    for field in rows(cut) {
                        out.places.extend(self.moved(&fields[field], place).iter());
                    }
                }
                out
            })
            .collect()
    }

    /// The modes, then the fields as modes in which A stands still.
    fn with_fields(&self, fields: &[Vec<Vector6<f64>>]) -> Modes {
        let mut phi_s = Vec::with_capacity(self.assembly.unknown.len() * (self.modes.m() + fields.len()));
        for (node, unknown) in self.assembly.unknown.iter().enumerate() {
            phi_s.extend_from_slice(self.modes.at_node(node));
            phi_s.extend(fields.iter().map(|y| unknown.map_or(Vector6::zeros(), |i| y[i])));
        }
        Modes {
            omega: [&self.modes.omega[..], &vec![1.0; fields.len()]].concat(),
            phi_r: [&self.modes.phi_r[..], &vec![Vector6::zeros(); fields.len()]].concat(),
            phi_s,
            ..self.modes.clone()
        }
    }

    /// A mode over the block rows.
    fn shape(&self, mode: usize) -> Vec<Vector6<f64>> {
        let mut out = vec![Vector6::zeros(); self.assembly.n_blocks()];
        for (node, unknown) in self.assembly.unknown.iter().enumerate() {
            if let Some(i) = unknown {
                out[*i] = self.modes.at_node(node)[mode];
            }
        }
        out
    }

    /// `M_SS phi_S + M_SR phi_R` of every mode.
    fn modal_momenta(&self) -> Vec<Vec<Vector6<f64>>> {
        let of_mode = |l: usize| {
            let mut p = product(&self.mass.ss, &self.shape(l));
            p.iter_mut().zip(&self.mass.sr).for_each(|(p, sr)| *p += sr * self.modes.phi_r[l]);
            p
        };
        (0..self.modes.m()).map(of_mode).collect()
    }

    /// Motion of a place in a field.
    fn moved(&self, field: &[Vector6<f64>], place: &CarriedPlace) -> Vector6<f64> {
        let each = place.iter().filter_map(|(node, map)| Some(map * field[self.assembly.unknown[*node]?]));
        each.sum()
    }
}

fn product(matrix: &BlockMatrix, x: &[Vector6<f64>]) -> Vec<Vector6<f64>> {
    let mut y = vec![Vector6::zeros(); x.len()];
    matrix.multiply(x, &mut y);
    y
}

fn dot(a: &[Vector6<f64>], b: &[Vector6<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}
