//! External loads on the nodes of a body in motion, with their stiffness.

use nalgebra::{Matrix3, Matrix6, Vector3};
use rom_runtime::expression::Variables;
use rom_runtime::loads::{DistributedFrame, DistributedLoad, Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;

use super::motion::Motion;
use crate::carrier::{AppliedForce, Carrier, SharedBeam};
use crate::element::inside::CarrierForce;
use crate::element::internal_force::stack;
use crate::element::shape::gauss;
use crate::math::so3::skew;
use crate::mesh::Mesh;

/// The loads of one case, on the nodes of one mesh.
#[derive(Clone, Debug)]
pub struct ExternalLoads {
    reference: usize,
    /// Point loads, then the distributed ones station by station.
    loads: Vec<CarriedLoad>,
    /// Functions of time of the point loads, then of the distributed ones.
    times: Vec<TimeFunction>,
}

#[derive(Clone, Debug)]
struct CarriedLoad {
    carrier: Carrier,
    offset: Vector3<f64>,
    /// Index of its function of time: of the load in its case, distributed ones after the others.
    owner: usize,
    frame: LoadFrame,
    force: Vector3<f64>,
    moment: Vector3<f64>,
}

impl ExternalLoads {
    /// The loads of `case` on `mesh`.
    pub fn new(mesh: &Mesh, case: &LoadCase) -> Self {
        let on_point = |(owner, load): (usize, &Load)| {
            let point = &mesh.points[load.point as usize];
            CarriedLoad {
                carrier: Carrier::new(mesh, point.place),
                offset: point.offset,
                owner,
                frame: load.frame,
                force: load.force.into(),
                moment: load.moment.into(),
            }
        };
        let mut loads: Vec<CarriedLoad> = case.loads.iter().enumerate().map(on_point).collect();
        for (k, load) in case.distributed.iter().enumerate() {
            add_stations(&mut loads, mesh, load, case.loads.len() + k);
        }
        let times = case.loads.iter().map(|l| &l.time).chain(case.distributed.iter().map(|l| &l.time));
        Self { reference: mesh.reference, loads, times: times.cloned().collect() }
    }

    /// Pairs of nodes that the loads couple: a body load turns with A wherever it acts.
    pub fn coupled_nodes(&self) -> impl Iterator<Item = [usize; 2]> + Clone + '_ {
        let body = self.loads.iter().filter(|l| l.frame == LoadFrame::Body);
        let nodes = body.flat_map(|l| l.carrier.nodes());
        nodes.filter(|&&node| node != self.reference).map(|&node| [node, self.reference])
    }

    /// All loads at the time and state of `motion`, in G, with their derivatives where asked.
    pub fn at<'a>(
        &'a self,
        motion: &'a Motion,
        with_stiffness: bool,
    ) -> impl Iterator<Item = AppliedForce> + 'a {
        let frame = motion.rotation_matrix(self.reference);
        let variables = Variables {
            t: motion.time,
            v_a: frame.tr_mul(&motion.velocity[self.reference]).into(),
            w_a: motion.spin[self.reference].into(),
            r_g: motion.position[self.reference].into(),
        };
        self.evaluate(variables, frame, with_stiffness, |node| motion.rotation_matrix(node))
    }

    /// All loads for given variables, attitude of A, and rotations of the nodes (node frame to G), in G.
    pub fn evaluate<'a>(
        &'a self,
        variables: Variables,
        frame: Matrix3<f64>,
        with_stiffness: bool,
        rotation: impl Fn(usize) -> Matrix3<f64> + 'a,
    ) -> impl Iterator<Item = AppliedForce> + 'a {
        let factors: Vec<f64> = self.times.iter().map(|time| time.value(&variables)).collect();
        self.loads.iter().map(move |l| {
            let (force, moment) = (l.force * factors[l.owner], l.moment * factors[l.owner]);
            let on_reference = matches!(l.carrier, Carrier::Node(node) if node == self.reference);
            let on = l.on_carrier(&l.carrier.rotation(&rotation), &frame, on_reference, &force, &moment);
            l.carrier.apply(&rotation, &on, with_stiffness)
        })
    }

    /// Which load of its case each of [`Self::evaluate`]'s comes from, distributed ones counted after the others.
    pub fn owners(&self) -> impl Iterator<Item = usize> + '_ {
        self.loads.iter().map(|l| l.owner)
    }
}

/// A distributed load on the stations of its member: three an element.
fn add_stations(loads: &mut Vec<CarriedLoad>, mesh: &Mesh, load: &DistributedLoad, owner: usize) {
    let vector = |list: &[f64], n: usize| match list.get(3 * n..3 * n + 3) {
        Some(v) => Vector3::new(v[0], v[1], v[2]),
        None => Vector3::zeros(),
    };
    for (k, element) in mesh.members[load.member as usize].elements.clone().enumerate() {
        let beam = SharedBeam::new(mesh, element);
        for (g, (x, _)) in gauss(3).iter().enumerate() {
            let (force, moment) = (vector(&load.force, 3 * k + g), vector(&load.moment, 3 * k + g));
            if force == Vector3::zeros() && moment == Vector3::zeros() {
                continue;
            }
            let carrier = Carrier::inside(&beam, *x);
            let frame = match load.frame {
                DistributedFrame::Dead => LoadFrame::Dead,
                DistributedFrame::Body => LoadFrame::Body,
                DistributedFrame::Follower => {
                    let e = carrier.drawing_frame();
                    LoadFrame::Follower { section: [0, 1, 2].map(|i| [0, 1, 2].map(|j| e[(i, j)])) }
                }
            };
            loads.push(CarriedLoad { carrier, offset: Vector3::zeros(), owner, frame, force, moment });
        }
    }
}

impl CarriedLoad {
    /// On its carrier, which is turned by `q` against G.
    fn on_carrier(
        &self,
        q: &Matrix3<f64>,
        frame: &Matrix3<f64>,
        on_reference: bool,
        force: &Vector3<f64>,
        moment: &Vector3<f64>,
    ) -> CarrierForce {
        let arm = skew(&self.offset);
        let zero = Matrix3::zeros();
        let attached = |f: Vector3<f64>, m: Vector3<f64>| CarrierForce {
            // Constant in the carrier's axes: only the direction of the force in G turns.
            force: stack(&(q * f), &(m + arm * f)),
            by_spin: [-(q * skew(&f)), zero],
            by_frame_spin: [zero; 2],
        };
        match &self.frame {
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

    /// Force and moment given in G, whatever the carrier does.
    fn fixed(&self, q: &Matrix3<f64>, force: &Vector3<f64>, moment: &Vector3<f64>) -> CarrierForce {
        let arm = skew(&self.offset);
        let (f, m) = (q.tr_mul(force), q.tr_mul(moment));
        CarrierForce {
            force: stack(force, &(m + arm * f)),
            by_spin: [Matrix3::zeros(), skew(&m) + arm * skew(&f)],
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
