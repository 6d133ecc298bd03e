//! Members: their axes, elements and section axes, and how they hang together.

use std::collections::{HashMap, HashSet};

use nalgebra::Vector3;

use super::file::{ArcFile, ElementsFile, LinkFile, MemberFile, PointFile, SectionFile};
use super::read::Reader;
use super::values::{Count, List, MOST_ELEMENTS, Named, Text, check_name};
use crate::mesh::course::Course;
use crate::mesh::curve::Piece;
use crate::mesh::plan::{MemberPlan, Orientation};

/// Distances below this fraction of the structure's size are none.
pub(crate) const SAME_PLACE: f64 = 1e-9;

/// `local_y` must make at least this angle with the axis, degrees.
const LEAST_ANGLE: f64 = 1.0;

/// Members and the points they go through.
pub(crate) struct Skeleton {
    /// In input order; only complete if all are right.
    pub members: Vec<MemberPlan>,
    /// Coordinates of the joints, m.
    pub joints: Vec<Vector3<f64>>,
    /// Joint of each named point that is one.
    pub joint_of: HashMap<usize, usize>,
    /// Joints that each rigid link joins.
    pub links: Vec<Vec<usize>>,
    /// Diagonal of the box around the joints, m.
    pub size: f64,
}

/// The names the members use.
struct Names<'a> {
    points: &'a Named<PointFile>,
    sections: &'a Named<SectionFile>,
}

/// A member whose names have been found: indices of its points.
struct Draft<'a> {
    file: &'a MemberFile,
    points: Vec<usize>,
    section: Option<Course<usize>>,
}

/// Checks the members one by one and together. `None` where something is wrong with any.
pub(crate) fn resolve_members(
    members: &List<MemberFile>,
    points: &Named<PointFile>,
    sections: &Named<SectionFile>,
    links: Option<&List<LinkFile>>,
    element_nodes: usize,
    reader: &mut Reader,
) -> Option<Skeleton> {
    if members.items.is_empty() {
        return reader.error(members.span, "a structure needs at least one member");
    }
    let named = check_member_names(members, reader);
    let names = Names { points, sections };
    let drafts: Vec<Option<Draft>> = members.items.iter().map(|m| names.find(m.as_ref()?, reader)).collect();

    let mut joints = Vec::new();
    let mut joint_of = HashMap::new();
    for &point in drafts.iter().flatten().flat_map(|draft| &draft.points) {
        if let Some(PointFile::Position(at)) = &points.items[point].1 {
            joint_of.entry(point).or_insert_with(|| {
                joints.push(at.value);
                joints.len() - 1
            });
        }
    }
    let links = resolve_links(links, points, &joint_of, reader);
    let low = joints.iter().fold(Vector3::repeat(f64::INFINITY), |a, b| a.inf(b));
    let high = joints.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |a, b| a.sup(b));
    let size = (high - low).norm();

    let plan = |draft: &Draft, reader: &mut Reader| {
        let joint_list: Vec<usize> = draft.points.iter().filter_map(|p| joint_of.get(p).copied()).collect();
        if joint_list.len() != draft.points.len() {
            return None;
        }
        resolve_member(draft, joint_list, &joints, size, element_nodes, reader)
    };
    let plans: Vec<Option<MemberPlan>> =
        drafts.iter().map(|draft| draft.as_ref().and_then(|d| plan(d, reader))).collect();
    let members: Vec<MemberPlan> = plans.into_iter().collect::<Option<_>>()?;
    let skeleton = Skeleton { members, joints, joint_of, links: links?, size };
    let drafts: Vec<Draft> = drafts.into_iter().flatten().collect();
    skeleton.check_total(&drafts, reader)?;
    let joined = skeleton.check_joints(points, reader);
    let connected = skeleton.check_connected(&drafts, reader);
    named.and(joined).and(connected).map(|()| skeleton)
}

fn check_member_names(members: &List<MemberFile>, reader: &mut Reader) -> Option<()> {
    let mut seen = HashSet::new();
    let mut fine = Some(());
    for member in members.items.iter().flatten() {
        let name = &member.name;
        fine = fine.and(check_name(name, reader));
        if !seen.insert(name.value.as_str()) {
            let message = format!("there are two members `{}`", name.value.escape_debug());
            fine = reader.error_help(name.span, message, "give each member a name of its own");
        }
    }
    fine
}

impl Names<'_> {
    fn find<'a>(&self, file: &'a MemberFile, reader: &mut Reader) -> Option<Draft<'a>> {
        let section = self.sections_of(file, reader);
        let names: Vec<Option<&Text>> = match (&file.path, &file.arc) {
            (Some(path), None) => path.items.iter().map(Option::as_ref).collect(),
            (None, Some(arc)) => vec![Some(&arc.from), Some(&arc.to)],
            _ => {
                let message = "a member needs either `path` or `arc`";
                return reader.error_help(file.span, message, "path = [\"A\", \"B\"] is a straight member");
            }
        };
        let points: Vec<Option<usize>> = names.iter().map(|name| self.joint((*name)?, reader)).collect();
        if let Some(path) = file.path.as_ref().filter(|path| path.items.len() < 2) {
            return reader
                .error(path.span, format!("a path of {} points, expected two or more", path.items.len()));
        }
        Some(Draft { file, points: points.into_iter().collect::<Option<_>>()?, section })
    }

    fn sections_of(&self, file: &MemberFile, reader: &mut Reader) -> Option<Course<usize>> {
        let find = |(fraction, name): &(f64, Text)| {
            Some((*fraction, self.sections.find(name, "section", "sections", reader)?))
        };
        let found: Vec<Option<(f64, usize)>> = file.section.0.iter().map(find).collect();
        found.into_iter().collect::<Option<_>>().map(Course::new)
    }

    /// A point a member goes through: given by its coordinates.
    fn joint(&self, name: &Text, reader: &mut Reader) -> Option<usize> {
        let index = self.points.find(name, "point", "points", reader)?;
        match &self.points.items[index].1 {
            Some(PointFile::Position(_)) => Some(index),
            None => None,
            Some(_) => {
                let message =
                    format!("members cannot go through point `{}`: it is carried by another", name.value);
                reader.error_help(name.span, message, "give the point by its coordinates [x, y, z]")
            }
        }
    }
}

/// The joints of every rigid link.
fn resolve_links(
    links: Option<&List<LinkFile>>,
    points: &Named<PointFile>,
    joint_of: &HashMap<usize, usize>,
    reader: &mut Reader,
) -> Option<Vec<Vec<usize>>> {
    let joint = |name: &Text, reader: &mut Reader| {
        let index = points.find(name, "point", "points", reader)?;
        if let Some(&joint) = joint_of.get(&index) {
            return Some(joint);
        }
        let message = format!("no member goes through point `{}`: a rigid link joins members", name.value);
        let help = "put the point into the path of a member; loads, masses and results at a distance from a node need \
                    { linked_to = \"...\", offset = [...] }";
        reader.error_help(name.span, message, help)
    };
    let mut resolve = |link: &LinkFile| {
        let found: Vec<Option<usize>> =
            link.points.items.iter().map(|name| joint(name.as_ref()?, reader)).collect();
        let found: Vec<usize> = found.into_iter().collect::<Option<_>>()?;
        let different: HashSet<usize> = found.iter().copied().collect();
        if different.len() < found.len() || found.len() < 2 {
            let message = "a rigid link joins two or more different points";
            return reader.error(link.points.span, message);
        }
        Some(found)
    };
    let all: Vec<Option<Vec<usize>>> =
        links.iter().flat_map(|list| &list.items).map(|link| resolve(link.as_ref()?)).collect();
    all.into_iter().collect()
}

fn resolve_member(
    draft: &Draft,
    joint_list: Vec<usize>,
    joints: &[Vector3<f64>],
    size: f64,
    element_nodes: usize,
    reader: &mut Reader,
) -> Option<MemberPlan> {
    let file = draft.file;
    let corners: Vec<Vector3<f64>> = joint_list.iter().map(|&joint| joints[joint]).collect();
    let pieces = match &file.arc {
        Some(arc) => vec![resolve_arc(arc, corners[0], corners[1], size, reader)?],
        None => resolve_path(file, &corners, size, reader)?,
    };
    let counts = resolve_counts(&file.elements, &pieces, &file.name, reader);
    let local_y = resolve_local_y(file, &pieces, reader);
    let nodes = file.element_nodes.map_or(element_nodes, |n| n.0);
    let twist = match &file.twist {
        Some(course) => course.0.iter().map(|(fraction, angle)| (*fraction, angle.value)).collect(),
        None => vec![(0.0, 0.0)],
    };
    let twist = Course::new(twist);
    let orientation = Orientation { local_y: local_y?, twist };
    Some(MemberPlan::new(
        file.name.value.clone(),
        (pieces, joint_list),
        counts?,
        nodes,
        draft.section.clone()?,
        orientation,
    ))
}

fn resolve_path(
    file: &MemberFile,
    corners: &[Vector3<f64>],
    size: f64,
    reader: &mut Reader,
) -> Option<Vec<Piece>> {
    let names: Vec<&Text> = file.path.iter().flat_map(|path| path.items.iter().flatten()).collect();
    let mut pieces = Vec::new();
    for (index, pair) in corners.windows(2).enumerate() {
        let length = (pair[1] - pair[0]).norm();
        match Piece::line(pair[0], pair[1]) {
            Some(piece) if length > SAME_PLACE * size => pieces.push(piece),
            _ => {
                let (from, to) = (&names[index].value, &names[index + 1].value);
                let message = format!("member `{}` has no length from `{from}` to `{to}`", file.name.value);
                return reader.error(names[index + 1].span, message);
            }
        }
    }
    Some(pieces)
}

fn resolve_arc(
    arc: &ArcFile,
    from: Vector3<f64>,
    to: Vector3<f64>,
    size: f64,
    reader: &mut Reader,
) -> Option<Piece> {
    if (to - from).norm() <= SAME_PLACE * size {
        let message =
            format!("the arc starts and ends at the same place, `{}` and `{}`", arc.from.value, arc.to.value);
        return reader.error_help(arc.to.span, message, "make a closed ring of two arcs");
    }
    match (&arc.through, &arc.center) {
        (Some(through), None) => Piece::arc_through(from, through.value, to).or_else(|| {
            let message =
                "the three points of the arc lie on one line, or two of them coincide: there is no circle";
            reader.error_help(through.span, message, "a straight member is given by `path`")
        }),
        (None, Some(center)) => {
            let [a, b] = [from, to].map(|p| (p - center.value).norm());
            if (a - b).abs() > SAME_PLACE * a.max(b) {
                let message =
                    format!("the arc's start is {a} m from its center, its end {b} m: expected the same");
                return reader.error_help(center.span, message, "`through` a third place needs no center");
            }
            Piece::arc_about(from, center.value, to).or_else(|| {
                let message = "start, center and end of the arc lie on one line: its plane is not known";
                reader.error_help(center.span, message, "give a place on the arc as `through` instead")
            })
        }
        _ => reader.error(arc.span, "an arc needs either `through` or `center`"),
    }
}

fn resolve_counts(
    elements: &ElementsFile,
    pieces: &[Piece],
    member: &Text,
    reader: &mut Reader,
) -> Option<Vec<usize>> {
    match elements {
        ElementsFile::Total(total) if total.value < pieces.len() => {
            let (n, m) = (total.value, pieces.len());
            let message = format!("{n} elements for the {m} straight pieces of member `{}`", member.value);
            reader.error_help(total.span, message, format!("expected at least {m}"))
        }
        ElementsFile::Total(total) => Some(share(total.value, pieces)),
        ElementsFile::Each(list) => {
            let counts: Vec<&Count> = list.items.iter().flatten().collect();
            if list.items.len() != pieces.len() {
                let message = format!("{} element counts for {} pieces", list.items.len(), pieces.len());
                return reader.error(list.span, message);
            }
            (counts.len() == pieces.len()).then(|| counts.iter().map(|c| c.value).collect())
        }
    }
}

/// Shares elements out by length, one at least to each piece, the rest by largest remainder.
fn share(total: usize, pieces: &[Piece]) -> Vec<usize> {
    let length: f64 = pieces.iter().map(Piece::length).sum();
    let ideal: Vec<f64> = pieces.iter().map(|piece| total as f64 * piece.length() / length).collect();
    let mut counts: Vec<usize> = ideal.iter().map(|x| (x.floor() as usize).max(1)).collect();
    let mut given: usize = counts.iter().sum();
    // Largest shortfall first; where pieces were lifted to one element, the least shortfall gives some back.
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_by(|&a, &b| (ideal[b] - counts[b] as f64).total_cmp(&(ideal[a] - counts[a] as f64)));
    while given < total {
        for &index in &order[..order.len().min(total - given)] {
            counts[index] += 1;
            given += 1;
        }
    }
    while given > total {
        let excess = |i: usize| counts[i] as f64 - ideal[i];
        let most =
            (0..counts.len()).filter(|&i| counts[i] > 1).max_by(|&a, &b| excess(a).total_cmp(&excess(b)));
        let Some(most) = most else { break };
        counts[most] -= 1;
        given -= 1;
    }
    counts
}

fn resolve_local_y(file: &MemberFile, pieces: &[Piece], reader: &mut Reader) -> Option<Vector3<f64>> {
    let vector = file.local_y.value;
    let span = file.local_y.span;
    let Some(unit) = vector.try_normalize(1e-30) else {
        return reader.error(span, "local_y is a zero vector, expected a direction");
    };
    let mut before = 0.0;
    for piece in pieces {
        let (cosine, s) = piece.alignment(&unit);
        // The sine from the cross product is accurate where the cosine is not.
        let angle = piece.tangent(s).cross(&unit).norm().atan2(cosine).to_degrees();
        if angle < LEAST_ANGLE {
            let message = format!(
                "local_y is parallel to member `{}` within {angle:.3} degrees at {:.6} m from its start",
                file.name.value,
                before + s
            );
            let help =
                format!("choose a direction at least {LEAST_ANGLE} degree away from the axis everywhere");
            return reader.error_help(span, message, help);
        }
        before += piece.length();
    }
    Some(unit)
}

impl Skeleton {
    fn check_total(&self, drafts: &[Draft], reader: &mut Reader) -> Option<()> {
        let mut total = 0_usize;
        for (member, draft) in self.members.iter().zip(drafts) {
            total += member.element_count();
            if total > MOST_ELEMENTS {
                let message = format!("{total} elements up to member `{}`", member.name);
                return reader
                    .error(draft.file.name.span, format!("{message}, at most {MOST_ELEMENTS} are accepted"));
            }
        }
        Some(())
    }

    /// Joints at one place, or on a member that does not know them, look joined but are not.
    fn check_joints(&self, points: &Named<PointFile>, reader: &mut Reader) -> Option<()> {
        let near = SAME_PLACE * self.size;
        let before = reader.errors.len();
        let mut name_of: Vec<(usize, &Text)> =
            self.joint_of.iter().map(|(&point, &joint)| (joint, &points.items[point].0)).collect();
        name_of.sort_by(|a, b| self.joints[a.0].x.total_cmp(&self.joints[b.0].x).then(a.0.cmp(&b.0)));
        for (i, (a, first)) in name_of.iter().enumerate() {
            let close =
                name_of[i + 1..].iter().take_while(|(b, _)| self.joints[*b].x - self.joints[*a].x <= near);
            for (_, second) in close.filter(|(b, _)| (self.joints[*b] - self.joints[*a]).norm() <= near) {
                let (first, second) =
                    if first.span.start < second.span.start { (first, second) } else { (second, first) };
                let message = format!(
                    "points `{}` and `{}` are at the same place, but members at one are not joined to members at the other",
                    first.value, second.value
                );
                reader.error_help::<()>(
                    second.span,
                    message,
                    format!("use point `{}` for both", first.value),
                );
            }
        }
        for member in &self.members {
            for (joint, name) in &name_of {
                self.check_off(member, *joint, name, near, reader);
            }
        }
        (reader.errors.len() == before).then_some(())
    }

    /// A joint must not lie on a member that does not go through it.
    fn check_off(&self, member: &MemberPlan, joint: usize, name: &Text, near: f64, reader: &mut Reader) {
        let place = &self.joints[joint];
        if member.joints.iter().any(|&own| own == joint || (self.joints[own] - place).norm() <= near) {
            return;
        }
        if member.pieces.iter().any(|piece| piece.nearest(place).1 <= near) {
            let message = format!(
                "point `{}` lies on member `{}`, which does not go through it",
                name.value, member.name
            );
            let help =
                "to join the members there, put the point into the path (an arc is split in two there)";
            reader.error_help::<()>(name.span, message, help);
        }
    }

    fn check_connected(&self, drafts: &[Draft], reader: &mut Reader) -> Option<()> {
        let mut group: Vec<usize> = (0..self.joints.len()).collect();
        fn root(group: &mut [usize], mut joint: usize) -> usize {
            while group[joint] != joint {
                group[joint] = group[group[joint]];
                joint = group[joint];
            }
            joint
        }
        for chain in self.members.iter().map(|member| &member.joints).chain(&self.links) {
            for pair in chain.windows(2) {
                let (a, b) = (root(&mut group, pair[0]), root(&mut group, pair[1]));
                group[a.max(b)] = a.min(b);
            }
        }
        let mut parts: Vec<(usize, Vec<usize>)> = Vec::new();
        for (index, member) in self.members.iter().enumerate() {
            let part = root(&mut group, member.joints[0]);
            match parts.iter_mut().find(|(root, _)| *root == part) {
                Some((_, list)) => list.push(index),
                None => parts.push((part, vec![index])),
            }
        }
        if parts.len() < 2 {
            return Some(());
        }
        let list = |part: &[usize]| {
            let names: Vec<String> =
                part.iter().take(5).map(|&m| format!("`{}`", self.members[m].name)).collect();
            names.join(", ") + if part.len() > 5 { ", ..." } else { "" }
        };
        let described: Vec<String> =
            parts.iter().take(5).map(|(_, part)| format!("({})", list(part))).collect();
        let message = format!(
            "the structure is in {} parts that nothing joins: {}",
            parts.len(),
            described.join(" and ")
        );
        let at = drafts[parts[1].1[0]].file.name.span;
        reader.error_help(at, message, "members are joined where they name the same point, or by [[links]]")
    }
}
