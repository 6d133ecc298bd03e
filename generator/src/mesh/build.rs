//! From the checked plan to nodes and elements.

use nalgebra::{Matrix3, Vector3};

use super::plan::{MemberPlan, Plan, Station};
use super::{Element, LumpedMass, Member, Mesh, Point};

/// Cuts every member into elements. Cannot fail: the plan has been checked.
pub(crate) fn build(plan: &Plan) -> Mesh {
    let (member_nodes, node_count) = number_nodes(plan);
    let node = |station: Station| member_nodes[station.member][station.node];

    let reference_member = &plan.members[plan.reference.member];
    let origin = reference_member.position(plan.reference.node, &plan.joints);
    let mut nodes = vec![Vector3::zeros(); node_count];
    let mut elements = Vec::new();
    let mut members = Vec::new();
    for (index, (member, numbers)) in plan.members.iter().zip(&member_nodes).enumerate() {
        for (k, &number) in numbers.iter().enumerate() {
            nodes[number] = member.position(k, &plan.joints) - origin;
        }
        let first = elements.len();
        cut(member, index, numbers, &mut elements);
        members.push(Member {
            name: member.name.clone(),
            elements: first..elements.len(),
            nodes: numbers.clone(),
        });
    }

    Mesh {
        name: plan.name.clone(),
        nodes,
        reference: node(plan.reference),
        reference_position: origin,
        sections: plan.sections.clone(),
        elements,
        members,
        lumped: plan.masses.iter().map(|m| LumpedMass { node: node(m.station), mass: m.mass }).collect(),
        points: plan
            .points
            .iter()
            .map(|p| Point {
                name: p.name.clone(),
                node: node(p.station),
                offset: p.offset,
                sections: p.sections.clone(),
            })
            .collect(),
        load_cases: plan.load_cases.clone(),
        gravity: plan.gravity,
        trim: plan.trim.clone(),
        modal_damping: plan.modal_damping,
        inertia_quadrature: plan.inertia_quadrature,
    }
}

/// Node numbers of every member, and their count. Nodes are consecutive along each member, and members are walked one
/// into the next from a free end, so that a chain of members is numbered from end to end and the band stays narrow.
fn number_nodes(plan: &Plan) -> (Vec<Vec<usize>>, usize) {
    const UNSET: usize = usize::MAX;
    let mut at_joint: Vec<Vec<usize>> = vec![Vec::new(); plan.joints.len()];
    for (index, member) in plan.members.iter().enumerate() {
        for &joint in &member.joints {
            if at_joint[joint].last() != Some(&index) {
                at_joint[joint].push(index);
            }
        }
    }

    let mut numbers: Vec<Vec<usize>> = plan.members.iter().map(|m| vec![UNSET; m.node_count()]).collect();
    let mut joint_numbers = vec![UNSET; plan.joints.len()];
    let mut next = 0;
    let free_end = |m: &MemberPlan| {
        [m.joints.first(), m.joints.last()].into_iter().flatten().any(|&j| at_joint[j].len() == 1)
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
            let [first_joint, last_joint] = [member.joints[0], member.joints[member.counts.len()]];
            let known = |j: usize| joint_numbers[j] != UNSET;
            // Walk away from what is numbered; to begin with, from the free end.
            (known(last_joint) && !known(first_joint))
                || (next == 0 && at_joint[first_joint].len() > 1 && at_joint[last_joint].len() == 1)
        };
        for k in 0..=last {
            let k = if backwards { last - k } else { k };
            let slot = match member.joint_at(k) {
                Some(joint) => &mut joint_numbers[joint],
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
        for joint in order {
            stack.extend(at_joint[joint].iter().rev().filter(|&&m| numbers[m][0] == UNSET));
        }
    }
    (numbers, next)
}

/// Elements of one member: nodes in order along it, frames from the exact tangent, length of the true arc.
fn cut(member: &MemberPlan, index: usize, numbers: &[usize], elements: &mut Vec<Element>) {
    let n = member.element_nodes;
    for (piece, &count) in member.counts.iter().enumerate() {
        let first = member.piece_nodes(piece).start;
        let length = member.pieces[piece].length() / count as f64;
        for k in 0..count {
            let start = first + k * (n - 1);
            let mut nodes = [0; 3];
            let mut frames = [Matrix3::identity(); 3];
            for i in 0..n {
                nodes[i] = numbers[start + i];
                frames[i] = member.frame(piece, start + i);
            }
            elements.push(Element {
                member: index,
                nodes,
                n_nodes: n,
                length,
                frames,
                sections: [member.section; 2],
            });
        }
    }
}
