//! External loads on the nodes of a body in motion, with their stiffness.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use rom_runtime::expression::Variables;
use rom_runtime::loads::{Load, LoadCase, LoadFrame};

use super::motion::Motion;
use crate::element::internal_force::stack;
use crate::math::so3::skew;
use crate::mesh::Mesh;

/// The loads of one case, on the nodes of one mesh.
#[derive(Clone, Debug)]
pub struct ExternalLoads {
    reference: usize,
    loads: Vec<NodalLoad>,
}

#[derive(Clone, Debug)]
struct NodalLoad {
    node: usize,
    offset: Vector3<f64>,
    load: Load,
}

/// A load at an instant: force in G and moment in the node frame, and their derivatives in spins.
#[derive(Clone, Copy, Debug)]
pub struct NodalForce {
    /// Node it acts on.
    pub node: usize,
    /// Force in G (N), moment about the node in the node frame (N m).
    pub force: Vector6<f64>,
    /// Derivative in the spin of the node (node frame).
    pub by_node_spin: [Matrix3<f64>; 2],
    /// Derivative in the spin of frame A; zero unless the load is constant in A.
    pub by_frame_spin: [Matrix3<f64>; 2],
}

impl NodalForce {
    /// With the force seen in axes turned by `to_axes` against G, and everything times a factor.
    pub fn seen(mut self, to_axes: &Matrix3<f64>, factor: f64) -> Self {
        let force = to_axes * self.force.fixed_rows::<3>(0);
        self.force.fixed_rows_mut::<3>(0).copy_from(&force);
        self.force *= factor;
        for pair in [&mut self.by_node_spin, &mut self.by_frame_spin] {
            *pair = [to_axes * pair[0] * factor, pair[1] * factor];
        }
        self
    }
}

impl ExternalLoads {
    /// The loads of `case` on `mesh`.
    pub fn new(mesh: &Mesh, case: &LoadCase) -> Self {
        let nodal = |load: &Load| {
            let point = &mesh.points[load.point as usize];
            NodalLoad { node: point.node, offset: point.offset, load: load.clone() }
        };
        Self { reference: mesh.reference, loads: case.loads.iter().map(nodal).collect() }
    }

    /// Pairs of nodes that the loads couple: a body load turns with A wherever it acts.
    pub fn coupled_nodes(&self) -> impl Iterator<Item = [usize; 2]> + Clone + '_ {
        self.loads
            .iter()
            .filter(|l| l.load.frame == LoadFrame::Body && l.node != self.reference)
            .map(|l| [l.node, self.reference])
    }

    /// All loads at the time and state of `motion`.
    pub fn at<'a>(&'a self, motion: &'a Motion) -> impl Iterator<Item = NodalForce> + 'a {
        let frame = motion.rotation_matrix(self.reference);
        let variables = Variables {
            t: motion.time,
            v_a: frame.tr_mul(&motion.velocity[self.reference]).into(),
            w_a: motion.spin[self.reference].into(),
            r_g: motion.position[self.reference].into(),
        };
        self.evaluate(variables, frame, |node| motion.rotation_matrix(node))
    }

    /// All loads for given variables, attitude of A, and rotations of the nodes (node frame to G).
    pub fn evaluate<'a>(
        &'a self,
        variables: Variables,
        frame: Matrix3<f64>,
        rotation: impl Fn(usize) -> Matrix3<f64> + 'a,
    ) -> impl Iterator<Item = NodalForce> + 'a {
        self.loads.iter().map(move |l| {
            let factor = l.load.time.value(&variables);
            let force = Vector3::from(l.load.force) * factor;
            let moment = Vector3::from(l.load.moment) * factor;
            l.at(&rotation(l.node), &frame, l.node == self.reference, &force, &moment)
        })
    }
}

impl NodalLoad {
    fn at(
        &self,
        q: &Matrix3<f64>,
        frame: &Matrix3<f64>,
        on_reference: bool,
        force: &Vector3<f64>,
        moment: &Vector3<f64>,
    ) -> NodalForce {
        let arm = skew(&self.offset);
        let zero = Matrix3::zeros();
        let attached = |f: Vector3<f64>, m: Vector3<f64>| NodalForce {
            // Constant in the node frame: only the direction of the force in G turns.
            node: self.node,
            force: stack(&(q * f), &(m + arm * f)),
            by_node_spin: [-(q * skew(&f)), zero],
            by_frame_spin: [zero; 2],
        };
        match &self.load.frame {
            LoadFrame::Follower { section } => {
                let e = Matrix3::from_fn(|i, j| section[i][j]);
                attached(e * force, e * moment)
            }
            LoadFrame::Body if on_reference => attached(*force, *moment),
            LoadFrame::Dead => self.fixed(q, force, moment),
            LoadFrame::Body => {
                let mut out = self.fixed(q, &(frame * force), &(frame * moment));
                let turn = q.transpose() * frame;
                out.by_frame_spin =
                    [-(frame * skew(force)), -(turn * skew(moment)) - arm * turn * skew(force)];
                out
            }
        }
    }

    /// Force and moment given in G, whatever the node does.
    fn fixed(&self, q: &Matrix3<f64>, force: &Vector3<f64>, moment: &Vector3<f64>) -> NodalForce {
        let arm = skew(&self.offset);
        let (f, m) = (q.tr_mul(force), q.tr_mul(moment));
        NodalForce {
            node: self.node,
            force: stack(force, &(m + arm * f)),
            by_node_spin: [Matrix3::zeros(), skew(&m) + arm * skew(&f)],
            by_frame_spin: [Matrix3::zeros(); 2],
        }
    }
}

/// A pair of derivatives as a 6 x 6 block whose columns are (position, rotation).
pub fn spin_block(by_spin: &[Matrix3<f64>; 2], tangential: &Matrix3<f64>) -> Matrix6<f64> {
    let mut block = Matrix6::zeros();
    block.fixed_view_mut::<3, 3>(0, 3).copy_from(&(by_spin[0] * tangential));
    block.fixed_view_mut::<3, 3>(3, 3).copy_from(&(by_spin[1] * tangential));
    block
}
