//! From the checked plan to nodes and elements.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::plan::{MemberPlan, Plan, PlanPlace, Station as PlanStation, StationBlockPlan, StationPlan};
use super::shape::Profile;
use super::{Cut, Element, LumpedMass, Member, Mesh, Place, Point, Section, Station, StationBlock};

/// A place nearer to a station of a course than this fraction of the way to the next is at the station.
const AT_STATION: f64 = 1e-9;

/// Cuts every member into elements. Cannot fail: the plan has been checked.
pub(crate) fn build(plan: &Plan) -> Mesh {
    let carriers = Carriers::new(plan);
    let (member_nodes, node_count) = number_nodes(plan, &carriers);
    let node = |station: PlanStation| member_nodes[station.member][station.node];
    let lever = |station: PlanStation| carriers.lever(&plan.members[station.member], station.node);

    let reference_member = &plan.members[plan.reference.member];
    let origin = reference_member.position(plan.reference.node, &plan.joints);
    let mut nodes = vec![Vector3::zeros(); node_count];
    let mut cutter = Cutter::new(plan, &carriers);
    let mut members = Vec::new();
    for (index, (member, numbers)) in plan.members.iter().zip(&member_nodes).enumerate() {
        for (k, &number) in numbers.iter().enumerate() {
            let carrier = member.joint_at(k).map(|joint| plan.joints[carriers.of[joint]]);
            nodes[number] = carrier.unwrap_or_else(|| member.position(k, &plan.joints)) - origin;
        }
        let first = cutter.elements.len();
        cutter.cut(member, index, numbers);
        members.push(Member {
            name: member.name.clone(),
            elements: first..cutter.elements.len(),
            nodes: numbers.clone(),
        });
    }
    let Cutter { elements, sections, .. } = cutter;
    let station = |s: &StationPlan| Station {
        member: s.member,
        fraction: s.fraction,
        element: members[s.member].elements.start + s.element,
        x: s.x,
        offset: s.offset,
    };
    let block = |b: &StationBlockPlan| {
        let stations = b.stations.iter().map(station).collect();
        StationBlock { name: b.name.clone(), stations }
    };
    let stations = plan.stations.iter().map(block).collect();
    let cut = |(name, plan): &(String, StationPlan)| {
        let Station { member, fraction, element, x, .. } = station(plan);
        Cut { name: name.clone(), member, fraction, element, x }
    };
    let cuts = plan.cuts.iter().map(cut).collect();

    Mesh {
        name: plan.name.clone(),
        nodes,
        reference: node(plan.reference),
        reference_position: origin,
        sections,
        elements,
        lumped: plan
            .masses
            .iter()
            .map(|m| LumpedMass { node: node(m.station), mass: carried_mass(&m.mass, &lever(m.station)) })
            .collect(),
        points: plan
            .points
            .iter()
            .map(|p| {
                let (place, lever) = match p.place {
                    PlanPlace::Node(station) => (Place::Node(node(station)), lever(station)),
                    PlanPlace::Inside { member, element, x } => {
                        let element = members[member].elements.start + element;
                        (Place::Inside { element, x }, Vector3::zeros())
                    }
                };
                let sections = p.sections.clone();
                Point { name: p.name.clone(), place, offset: lever + p.offset, sections }
            })
            .collect(),
        members,
        load_cases: plan.load_cases.clone(),
        sensors: plan.sensors.clone(),
        stations,
        cuts,
        gravity: plan.gravity,
        trim: plan.trim.clone(),
        support: plan.support,
        damping: plan.damping.clone(),
        inertia_quadrature: plan.inertia_quadrature,
    }
}

/// Rigid links: one node carries all joints of a rigid body.
struct Carriers<'a> {
    plan: &'a Plan,
    /// The joint whose node carries each joint: itself, where nothing is linked.
    of: Vec<usize>,
}

impl<'a> Carriers<'a> {
    /// The first joint of a rigid body carries it, the reference joint its own: frame A is on that node.
    fn new(plan: &'a Plan) -> Self {
        let mut of: Vec<usize> = (0..plan.joints.len()).collect();
        for link in &plan.links {
            // Links are few; joints of a body know their first one at any time.
            let bodies: Vec<usize> = link.iter().map(|&joint| of[joint]).collect();
            let first = bodies.iter().copied().min().unwrap_or_default();
            of.iter_mut().filter(|body| bodies.contains(body)).for_each(|body| *body = first);
        }
        let reference = plan.members[plan.reference.member].joint_at(plan.reference.node);
        if let Some(joint) = reference {
            let body = of[joint];
            of.iter_mut().filter(|b| **b == body).for_each(|b| *b = joint);
        }
        Self { plan, of }
    }

    /// From the node that carries a node of a member to that node's place, drawing axes, m: zero without a link.
    fn lever(&self, member: &MemberPlan, node: usize) -> Vector3<f64> {
        let joints = &self.plan.joints;
        member.joint_at(node).map_or_else(Vector3::zeros, |joint| joints[joint] - joints[self.of[joint]])
    }
}

/// 6x6 mass about the carrying node of one given about a place at `lever` from it: `v = v_node - lever~ w`.
fn carried_mass(mass: &Matrix6<f64>, lever: &Vector3<f64>) -> Matrix6<f64> {
    if *lever == Vector3::zeros() {
        return *mass;
    }
    let mut map = Matrix6::identity();
    map.fixed_view_mut::<3, 3>(0, 3).copy_from(&-lever.cross_matrix());
    map.tr_mul(&(mass * map))
}

/// Node numbers of every member, and their count. Nodes are consecutive along each member, and members are walked one
/// into the next from a free end, so that a chain of members is numbered from end to end and the band stays narrow.
fn number_nodes(plan: &Plan, carriers: &Carriers<'_>) -> (Vec<Vec<usize>>, usize) {
    const UNSET: usize = usize::MAX;
    let carrier = |joint: usize| carriers.of[joint];
    let mut at_joint: Vec<Vec<usize>> = vec![Vec::new(); plan.joints.len()];
    for (index, member) in plan.members.iter().enumerate() {
        for joint in member.joints.iter().map(|&j| carrier(j)) {
            if at_joint[joint].last() != Some(&index) {
                at_joint[joint].push(index);
            }
        }
    }

    let mut numbers: Vec<Vec<usize>> = plan.members.iter().map(|m| vec![UNSET; m.node_count()]).collect();
    let mut joint_numbers = vec![UNSET; plan.joints.len()];
    let mut next = 0;
    let free_end = |m: &MemberPlan| {
        [m.joints.first(), m.joints.last()].into_iter().flatten().any(|&j| at_joint[carrier(j)].len() == 1)
    };
    let start = plan.members.iter().position(free_end).unwrap_or(0);
    let mut stack = vec![start];
    while let Some(index) = stack.pop() {
        let member = &plan.members[index];
        if numbers[index][0] != UNSET {
            continue;
        }
        let last = member.node_count() - 1;
        let backwards = {
            let [first_joint, last_joint] =
                [member.joints[0], member.joints[member.counts.len()]].map(carrier);
            let known = |j: usize| joint_numbers[j] != UNSET;
            // Walk away from what is numbered; to begin with, from the free end.
            (known(last_joint) && !known(first_joint))
                || (next == 0 && at_joint[first_joint].len() > 1 && at_joint[last_joint].len() == 1)
        };
        for k in 0..=last {
            let k = if backwards { last - k } else { k };
            let slot = match member.joint_at(k) {
                Some(joint) => &mut joint_numbers[carrier(joint)],
                None => &mut numbers[index][k],
            };
            if *slot == UNSET {
                *slot = next;
                next += 1;
            }
            numbers[index][k] = *slot;
        }
        // The member reached last goes on top of the stack, so that a chain is followed.
        let order: Vec<usize> =
            if backwards { member.joints.iter().rev().copied().collect() } else { member.joints.clone() };
        for joint in order.into_iter().map(carrier) {
            stack.extend(at_joint[joint].iter().rev().filter(|&&m| numbers[m][0] == UNSET));
        }
    }
    (numbers, next)
}

/// Makes the elements, and the sections between the given ones.
struct Cutter<'a> {
    profiles: &'a [Profile],
    carriers: &'a Carriers<'a>,
    elements: Vec<Element>,
    sections: Vec<Section>,
}

impl<'a> Cutter<'a> {
    fn new(plan: &'a Plan, carriers: &'a Carriers<'a>) -> Self {
        let sections = plan.profiles.iter().map(|p| p.section.clone()).collect();
        Self { profiles: &plan.profiles, carriers, elements: Vec::new(), sections }
    }

    /// Elements of one member: nodes in order along it, frames from the exact tangent, length of the true arc.
    fn cut(&mut self, member: &MemberPlan, index: usize, numbers: &[usize]) {
        let n = member.element_nodes;
        for (piece, &count) in member.counts.iter().enumerate() {
            let first = member.piece_nodes(piece).start;
            let length = member.pieces[piece].length() / count as f64;
            let mut end = self.section(member, member.fraction(piece, first));
            for k in 0..count {
                let start = first + k * (n - 1);
                let mut nodes = [0; 3];
                let mut frames = [Matrix3::identity(); 3];
                let mut levers = [Vector3::zeros(); 3];
                for i in 0..n {
                    nodes[i] = numbers[start + i];
                    frames[i] = member.frame(piece, start + i);
                    levers[i] = self.carriers.lever(member, start + i);
                }
                let begin =
                    std::mem::replace(&mut end, self.section(member, member.fraction(piece, start + n - 1)));
                self.elements.push(Element {
                    member: index,
                    nodes,
                    n_nodes: n,
                    length,
                    frames,
                    levers,
                    sections: [begin, end],
                });
            }
        }
    }

    /// Index of the section at a fraction of a member's length.
    fn section(&mut self, member: &MemberPlan, fraction: f64) -> usize {
        let (a, b, x) = member.section.around(fraction);
        if a == b || x < AT_STATION {
            return a;
        }
        if x > 1.0 - AT_STATION {
            return b;
        }
        self.sections.push(self.profiles[a].between(&self.profiles[b], x));
        self.sections.len() - 1
    }
}
