//! The structure as beams and masses, and its sparse matrices about a configuration.

use std::sync::Arc;

use nalgebra::{Matrix6, Vector3, Vector6};

use super::block_matrix::{BlockMatrix, BlockPattern};
use crate::configuration::Configuration;
use crate::element::beam::{Beam, EndSections, InertiaPoint};
use crate::element::inertia::{ElementMass, mass, mass_at, rigid_map};
use crate::element::internal_force::{ElementMatrix, internal_force, internal_force_and_stiffness};
use crate::element::viscous::viscous_matrix;
use crate::element::weight::{lump_weight, lump_weight_tangent, weight, weight_tangent};
use crate::mesh::{InertiaQuadrature, LumpedMass, Mesh, Support};

/// An element of either kind.
#[derive(Clone, Debug)]
pub enum AnyBeam {
    /// Linear interpolation.
    Two(Beam<2>),
    /// Quadratic interpolation.
    Three(Beam<3>),
}

impl AnyBeam {
    /// Node indices.
    pub fn nodes(&self) -> &[usize] {
        match self {
            Self::Two(b) => &b.nodes,
            Self::Three(b) => &b.nodes,
        }
    }
}

/// Mass matrix with the six rigid columns as a border (theory section 2).
#[derive(Clone, Debug)]
pub struct MassMatrix {
    /// `M_SS` - (6n x 6n, sparse).
    pub ss: BlockMatrix,
    /// `M_SR`: a block per block row - (6n x 6).
    pub sr: Vec<Matrix6<f64>>,
    /// `M_RR` about the origin of A - (6 x 6).
    pub rr: Matrix6<f64>,
}

/// Elements, masses and numbering of a mesh: constant for the life of the structure.
#[derive(Clone, Debug)]
pub struct Assembly {
    /// Beam elements in mesh order.
    pub beams: Vec<AnyBeam>,
    /// Lumped masses.
    pub lumped: Vec<LumpedMass>,
    /// Block row of each node; none for the reference node.
    pub unknown: Vec<Option<usize>>,
    /// How the structure is held.
    pub support: Support,
    /// Pattern of `M_SS` and `K_SS`.
    pub pattern: Arc<BlockPattern>,
    quadrature: InertiaQuadrature,
    sections: Vec<[Matrix6<f64>; 4]>,
}

impl Assembly {
    /// Numbers the unknowns, finds the pattern and prepares the elements.
    pub fn new(mesh: &Mesh) -> Self {
        let mut next = 0;
        let unknown: Vec<_> = (0..mesh.nodes.len())
            .map(|node| {
                (node != mesh.reference).then(|| {
                    next += 1;
                    next - 1
                })
            })
            .collect();
        let groups: Vec<Vec<usize>> = mesh
            .elements
            .iter()
            .map(|e| e.nodes[..e.n_nodes].iter().filter_map(|&n| unknown[n]).collect())
            .collect();
        let pattern = Arc::new(BlockPattern::from_groups(next, groups.iter().map(Vec::as_slice)));
        let beams = beams(mesh);
        let sections = match mesh.inertia_quadrature {
            InertiaQuadrature::Consistent => Vec::new(),
            InertiaQuadrature::ReducedCoupling => mesh.elements.iter().map(|e| ends_of(mesh, e)).collect(),
        };
        Self {
            beams,
            lumped: mesh.lumped.clone(),
            unknown,
            support: mesh.support,
            pattern,
            quadrature: mesh.inertia_quadrature,
            sections,
        }
    }

    /// Number of block rows (nodes with unknowns).
    pub fn n_blocks(&self) -> usize {
        self.pattern.n()
    }

    /// Mass matrix about a configuration.
    pub fn mass(&self, at: &Configuration) -> MassMatrix {
        let mut m = MassMatrix {
            ss: BlockMatrix::zeros(self.pattern.clone()),
            sr: vec![Matrix6::zeros(); self.n_blocks()],
            rr: Matrix6::zeros(),
        };
        for (index, beam) in self.beams.iter().enumerate() {
            match beam {
                AnyBeam::Two(b) => self.add_mass(&mut m, &b.nodes, &self.element_mass(index, b, at)),
                AnyBeam::Three(b) => self.add_mass(&mut m, &b.nodes, &self.element_mass(index, b, at)),
            }
        }
        for lump in &self.lumped {
            let q = at.rotation_matrix(lump.node);
            let a_rc = rigid_map(&q, &at.positions[lump.node]);
            let mut j = Matrix6::identity();
            j.fixed_view_mut::<3, 3>(0, 0).copy_from(&q.transpose());
            let element = ElementMass {
                ss: [[j.transpose() * lump.mass * j]],
                sr: [j.transpose() * lump.mass * a_rc],
                rr: a_rc.transpose() * lump.mass * a_rc,
            };
            self.add_mass(&mut m, &[lump.node], &element);
        }
        m
    }

    /// Elastic stiffness `Kstif`, material and geometric, about a configuration (in `(R, theta)`, symmetric).
    pub fn stiffness(&self, at: &Configuration) -> BlockMatrix {
        let mut k = BlockMatrix::zeros(self.pattern.clone());
        for beam in &self.beams {
            match beam {
                AnyBeam::Two(b) => self.add(&mut k, &b.nodes, &internal_force_and_stiffness(b, &at.of(b)).1),
                AnyBeam::Three(b) => {
                    self.add(&mut k, &b.nodes, &internal_force_and_stiffness(b, &at.of(b)).1)
                }
            }
        }
        k
    }

    /// Damping `D` of the strains about a configuration (in the rates of `(R, theta)`, symmetric); none where nothing is damped.
    pub fn viscosity(&self, at: &Configuration) -> Option<BlockMatrix> {
        let viscous = |beam: &AnyBeam| match beam {
            AnyBeam::Two(b) => b.is_viscous(),
            AnyBeam::Three(b) => b.is_viscous(),
        };
        if !self.beams.iter().any(viscous) {
            return None;
        }
        let mut d = BlockMatrix::zeros(self.pattern.clone());
        for beam in &self.beams {
            match beam {
                AnyBeam::Two(b) => self.add(&mut d, &b.nodes, &viscous_matrix(b, &at.of(b))),
                AnyBeam::Three(b) => self.add(&mut d, &b.nodes, &viscous_matrix(b, &at.of(b))),
            }
        }
        Some(d)
    }

    /// Elastic forces `Qstif` of a configuration on every node: force in A (N), moment in the node frame (N m) - (nodes).
    pub fn elastic_force(&self, at: &Configuration) -> Vec<Vector6<f64>> {
        let mut nodal = vec![Vector6::zeros(); at.positions.len()];
        let mut add = |nodes: &[usize], force: &[Vector6<f64>]| {
            nodes.iter().zip(force).for_each(|(&node, force)| nodal[node] += force);
        };
        for beam in &self.beams {
            match beam {
                AnyBeam::Two(b) => add(&b.nodes, &internal_force(b, &at.of(b)).force),
                AnyBeam::Three(b) => add(&b.nodes, &internal_force(b, &at.of(b)).force),
            }
        }
        nodal
    }

    /// Weight of the structure in a field `g` (axes of the configuration, m/s^2), node by node: force in those axes (N), moment in the
    /// node frame (N m).
    pub fn visit_weight(
        &self,
        at: &Configuration,
        g: &Vector3<f64>,
        visit: &mut impl FnMut(usize, Vector6<f64>),
    ) {
        for beam in &self.beams {
            match beam {
                AnyBeam::Two(b) => {
                    b.nodes.into_iter().zip(weight(b, &at.of(b), g)).for_each(|(n, f)| visit(n, f))
                }
                AnyBeam::Three(b) => {
                    b.nodes.into_iter().zip(weight(b, &at.of(b), g)).for_each(|(n, f)| visit(n, f))
                }
            }
        }
        for lump in &self.lumped {
            visit(lump.node, lump_weight(lump, &at.rotation_matrix(lump.node), g));
        }
    }

    /// Adds the derivative of the weight in the spins of the nodes, times a factor.
    pub fn add_weight_tangent(&self, at: &Configuration, g: &Vector3<f64>, factor: f64, k: &mut BlockMatrix) {
        for beam in &self.beams {
            match beam {
                AnyBeam::Two(b) => {
                    if let Some(t) = weight_tangent(b, &at.of(b), g) {
                        self.add(k, &b.nodes, &t.map(|row| row.map(|block| block * factor)));
                    }
                }
                AnyBeam::Three(b) => {
                    if let Some(t) = weight_tangent(b, &at.of(b), g) {
                        self.add(k, &b.nodes, &t.map(|row| row.map(|block| block * factor)));
                    }
                }
            }
        }
        for lump in &self.lumped {
            if let Some(t) = lump_weight_tangent(lump, &at.rotation_matrix(lump.node), g) {
                self.add(k, &[lump.node], &t.map(|row| row.map(|block| block * factor)));
            }
        }
    }

    /// Centre of mass in A and total mass from `M_RR = [[m I, -m c~], ..]`.
    pub fn centre_of_mass(rr: &Matrix6<f64>) -> (f64, Vector3<f64>) {
        let m = rr.fixed_view::<3, 3>(0, 0).trace() / 3.0;
        (
            m,
            Vector3::new(rr[(2, 4)] - rr[(1, 5)], rr[(0, 5)] - rr[(2, 3)], rr[(1, 3)] - rr[(0, 4)])
                * (-0.5 / m),
        )
    }

    /// Nodal six-vectors of the unknowns from those of all nodes.
    pub fn gather(&self, nodal: &[Vector6<f64>]) -> Vec<Vector6<f64>> {
        let mut out = vec![Vector6::zeros(); self.n_blocks()];
        for (value, unknown) in nodal.iter().zip(&self.unknown) {
            if let Some(i) = unknown {
                out[*i] = *value;
            }
        }
        out
    }

    fn element_mass<const N: usize>(
        &self,
        index: usize,
        beam: &Beam<N>,
        at: &Configuration,
    ) -> ElementMass<N> {
        let state = at.of(beam);
        let full = mass(beam, &state);
        match self.coupling_points(index, beam) {
            None => full,
            Some(points) => ElementMass { ss: full.ss, ..mass_at(beam, &state, &points) },
        }
    }

    /// Inertia points of `M_SR` and `M_RR` of an element where they are not those of `M_SS`.
    pub(crate) fn coupling_points<const N: usize>(
        &self,
        index: usize,
        beam: &Beam<N>,
    ) -> Option<Vec<InertiaPoint<N>>> {
        match self.quadrature {
            InertiaQuadrature::Consistent => None,
            InertiaQuadrature::ReducedCoupling => {
                let [s0, s1, m0, m1] = &self.sections[index];
                Some(beam.reduced_inertia_points(EndSections { stiffness: [s0, s1], mass: [m0, m1] }))
            }
        }
    }

    fn add_mass<const N: usize>(&self, m: &mut MassMatrix, nodes: &[usize; N], element: &ElementMass<N>) {
        self.add(&mut m.ss, nodes, &element.ss);
        for a in 0..N {
            if let Some(i) = self.unknown[nodes[a]] {
                m.sr[i] += element.sr[a];
            }
        }
        // Symmetric to the last bit, which far from the reference node is not round-off of the smallest inertia.
        m.rr += (element.rr + element.rr.transpose()) * 0.5;
    }

    /// Adds the block of a pair of nodes into a matrix; rows and columns of the reference node drop out.
    pub fn add_pair(&self, matrix: &mut BlockMatrix, row: usize, column: usize, block: &Matrix6<f64>) {
        if let (Some(i), Some(j)) = (self.unknown[row], self.unknown[column]) {
            let slot = matrix.pattern.slot(i, j).expect("nodes of an element are coupled in the pattern");
            matrix.values[slot] += block;
        }
    }

    /// Adds element blocks into a matrix; rows and columns of the reference node drop out.
    pub fn add<const N: usize>(
        &self,
        matrix: &mut BlockMatrix,
        nodes: &[usize; N],
        blocks: &ElementMatrix<N>,
    ) {
        for a in 0..N {
            let Some(i) = self.unknown[nodes[a]] else { continue };
            for b in 0..N {
                let Some(j) = self.unknown[nodes[b]] else { continue };
                let slot = matrix.pattern.slot(i, j).expect("nodes of an element are coupled in the pattern");
                matrix.values[slot] += blocks[a][b];
            }
        }
    }
}

fn ends_of(mesh: &Mesh, e: &crate::mesh::Element) -> [Matrix6<f64>; 4] {
    let [s, t] = e.sections.map(|k| &mesh.sections[k]);
    [s.stiffness, t.stiffness, s.mass, t.mass]
}

/// The elements of a mesh, in its order.
pub fn beams(mesh: &Mesh) -> Vec<AnyBeam> {
    mesh.elements.iter().map(|e| make_beam(mesh, e)).collect()
}

/// An element of a mesh by its index.
pub fn beam_of(mesh: &Mesh, element: usize) -> AnyBeam {
    make_beam(mesh, &mesh.elements[element])
}

fn make_beam(mesh: &Mesh, e: &crate::mesh::Element) -> AnyBeam {
    let [s, t] = e.sections.map(|k| &mesh.sections[k]);
    let ends = EndSections { stiffness: [&s.stiffness, &t.stiffness], mass: [&s.mass, &t.mass] };
    fn beam<const N: usize>(mesh: &Mesh, e: &crate::mesh::Element, ends: EndSections<'_>) -> Beam<N> {
        let nodes: [usize; N] = std::array::from_fn(|a| e.nodes[a]);
        let frames = std::array::from_fn(|a| e.frames[a]);
        let levers: [Vector3<f64>; N] = std::array::from_fn(|a| e.levers[a]);
        let positions = std::array::from_fn(|a| mesh.nodes[nodes[a]] + levers[a]);
        let retardation = e.sections.map(|k| mesh.sections[k].retardation);
        Beam::new(nodes, positions, frames, e.length, ends).with_levers(levers).with_retardation(retardation)
    }
    if e.n_nodes == 3 { AnyBeam::Three(beam(mesh, e, ends)) } else { AnyBeam::Two(beam(mesh, e, ends)) }
}
