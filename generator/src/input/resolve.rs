//! From the file as written to the plan of a mesh: names found, everything checked together.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::damping::resolve_damping;
use super::equilibrium::resolve_equilibrium;
use super::file::{MassFile, PointFile, StructureFile};
use super::internal_loads::resolve_internal_loads;
use super::loads::{LoadContext, resolve_load_cases};
use super::members::{SAME_PLACE, Skeleton, resolve_members};
use super::outputs::resolve_sensors;
use super::read::Reader;
use super::reduction::resolve_reduction;
use super::section::{resolve_sections, symmetric};
use super::stations::resolve_stations;
use super::values::{Named, Number, Text, positive};
use super::{Line, PointTable};
use crate::build::Reduction;
use crate::mesh::plan::{MassPlan, MemberPlan, Plan, PlanPlace, PointPlan, Station};
use crate::mesh::{InertiaQuadrature, Support};

/// Where a named point is carried.
#[derive(Clone, Copy, Debug)]
struct Carried {
    place: PlanPlace,
    offset: Vector3<f64>,
}

impl Carried {
    fn at(place: PlanPlace) -> Self {
        Self { place, offset: Vector3::zeros() }
    }
}

/// Checks the structure as a whole. `None` if anything is wrong, which has been reported.
pub(crate) fn resolve(file: &StructureFile, reader: &mut Reader) -> Option<(Plan, Reduction)> {
    let no_materials = Named::default();
    let materials = file.materials.as_ref().unwrap_or(&no_materials);
    let (head, points) = (&file.structure.0, &file.points.0);
    let (section_files, members) = (&file.sections.0, &file.members.0);
    let damping = resolve_damping(file.damping.as_ref(), reader);
    let sections = section_files
        .as_ref()
        .map(|sections| resolve_sections(materials, sections, damping.as_ref(), reader));
    // Without one of the tables everything that refers to it would only repeat that.
    let (Some(head), Some(points), Some(section_files), Some(members)) =
        (head, points, section_files, members)
    else {
        return None;
    };
    let element_nodes = head.element_nodes.map_or(2, |n| n.0);
    let skeleton =
        resolve_members(members, points, section_files, file.links.as_ref(), element_nodes, reader);
    check_links(points, reader);
    let carried = skeleton.as_ref().map(|skeleton| carry_points(points, skeleton, reader));

    let reference = resolve_reference(&head.reference, points, carried.as_deref(), reader);
    let masses: Vec<Option<MassPlan>> = file
        .masses
        .iter()
        .flat_map(|list| &list.items)
        .map(|mass| resolve_mass(mass.as_ref()?, points, carried.as_deref(), reader))
        .collect();
    let plans = plan_points(points, skeleton.as_ref(), carried.as_deref());
    let table = PointTable {
        points: plans
            .iter()
            .map(|(name, plan)| (name.clone(), plan.as_ref().map_or(vec![], |p| p.sections.clone())))
            .collect(),
        lines: skeleton.as_ref().map_or(vec![], |skeleton| lines(&skeleton.members)),
        parameters: Vec::new(),
    };
    let (no_cases, no_times) = (Named::default(), Named::default());
    let context = LoadContext::new(file.times.as_ref().unwrap_or(&no_times), &table, reader);
    let load_cases = resolve_load_cases(file.load_cases.as_ref().unwrap_or(&no_cases), &context, reader);
    let trim =
        file.equilibrium.as_ref().map(|equilibrium| resolve_equilibrium(equilibrium, &context, reader));
    let no_sensors = Named::default();
    let no_stations = Named::default();
    let station_files = file.stations.as_ref().unwrap_or(&no_stations);
    let stations = skeleton.as_ref().map(|s| resolve_stations(station_files, &s.members, reader));
    let no_cuts = Named::default();
    let cut_files = file.internal_loads.as_ref().unwrap_or(&no_cuts);
    let cuts = skeleton.as_ref().map(|s| resolve_internal_loads(cut_files, &s.members, reader));
    let sensors = resolve_sensors(file.sensors.as_ref().unwrap_or(&no_sensors), &table, reader);
    let inertia_quadrature = file.options.as_ref().and_then(|o| o.inertia_quadrature).map(Into::into);
    if let (Some(gravity), Some(InertiaQuadrature::ReducedCoupling)) = (&file.gravity, inertia_quadrature) {
        let message = "gravity does not go with inertia_quadrature = \"reduced-coupling\"";
        let help = "that quadrature is there for the digits of a paper without gravity; leave it out";
        reader.error_help::<()>(gravity.span, message, help);
    }
    let reduction = file.reduction.as_ref();
    let reduction = reduction.map(|file| resolve_reduction(file, &table, inertia_quadrature, reader));

    if !reader.errors.is_empty() {
        return None;
    }
    let Skeleton { members, joints, links, .. } = skeleton?;
    let plan = Plan {
        name: head.name.value.clone(),
        joints,
        reference: reference?,
        profiles: sections?.into_iter().collect::<Option<_>>()?,
        members,
        links,
        masses: masses.into_iter().collect::<Option<_>>()?,
        points: plans.into_iter().map(|(_, plan)| plan).collect::<Option<_>>()?,
        load_cases,
        sensors,
        stations: stations.unwrap_or_default(),
        cuts: cuts.unwrap_or_default(),
        gravity: file.gravity.as_ref().map_or(Vector3::zeros(), |g| g.acceleration.value),
        trim: trim.flatten(),
        support: head.support.map_or(Support::Free, Into::into),
        damping: damping?.damping,
        inertia_quadrature: inertia_quadrature.unwrap_or_default(),
    };
    Some((plan, reduction.unwrap_or_default()))
}

/// Members as lines that carry distributed loads.
pub(crate) fn lines(members: &[MemberPlan]) -> Vec<Line> {
    let line = |member: &MemberPlan| Line {
        name: member.name.clone(),
        length: member.length(),
        knots: member.knots(),
        carries: true,
    };
    members.iter().map(line).collect()
}

/// Links and member points name things that exist, whatever the state of the members.
fn check_links(points: &Named<PointFile>, reader: &mut Reader) {
    for (_, point) in &points.items {
        let Some(PointFile::Linked(link)) = point else { continue };
        let Some(base) = points.find(&link.linked_to, "point", "points", reader) else { continue };
        if let Some(PointFile::Linked(_)) = points.items[base].1 {
            let message = format!("point `{}` is linked itself", link.linked_to.value);
            reader.error_help::<()>(
                link.linked_to.span,
                message,
                "link to the point that is on the structure",
            );
        }
    }
}

/// Finds what carries each point; `None` where there is none, which is reported.
fn carry_points(points: &Named<PointFile>, skeleton: &Skeleton, reader: &mut Reader) -> Vec<Option<Carried>> {
    let mut carried: Vec<Option<Carried>> = Vec::with_capacity(points.items.len());
    for (index, (name, point)) in points.items.iter().enumerate() {
        carried.push(match point {
            None | Some(PointFile::Linked(_)) => None,
            Some(PointFile::Position(at)) => match skeleton.joint_of.get(&index) {
                Some(&joint) => {
                    joint_station(skeleton, joint).map(|station| Carried::at(PlanPlace::Node(station)))
                }
                None => place_at(name, at.value, skeleton, reader),
            },
            Some(PointFile::OnMember(on)) => {
                place_on_member(&on.member, &on.fraction, skeleton, reader).map(Carried::at)
            }
        });
    }
    for (index, (_, point)) in points.items.iter().enumerate() {
        let Some(PointFile::Linked(link)) = point else { continue };
        let base = points.names().position(|n| n == link.linked_to.value).and_then(|base| carried[base]);
        carried[index] =
            base.map(|base| Carried { place: base.place, offset: base.offset + link.offset.value });
    }
    carried
}

fn joint_station(skeleton: &Skeleton, joint: usize) -> Option<Station> {
    skeleton.members.iter().enumerate().find_map(|(member, plan)| {
        let node = plan.nodes_at(joint).next()?;
        Some(Station { member, node })
    })
}

/// What carries a place that no member names: a node, or a section of the member it lies on.
fn place_at(name: &Text, place: Vector3<f64>, skeleton: &Skeleton, reader: &mut Reader) -> Option<Carried> {
    let near = SAME_PLACE * skeleton.size;
    let nodes = skeleton.members.iter().map(|member| member.nearest_node(&place, &skeleton.joints));
    let nearest_node = nodes.enumerate().min_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let (member, (node, distance)) = nearest_node?;
    if distance <= near {
        return Some(Carried::at(PlanPlace::Node(Station { member, node })));
    }
    let axes = skeleton.members.iter().map(|member| member.nearest(&place)).enumerate();
    let (member, (s, distance)) = axes.min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
    let plan = &skeleton.members[member];
    if distance <= near {
        let place_of = place_along(plan, member, s);
        // Between the nodes of an arc the elements cut the corner: the point stays where it was put.
        let PlanPlace::Inside { element, x, .. } = place_of else { return Some(Carried::at(place_of)) };
        let gap = place - plan.inside(element, x, &skeleton.joints).0;
        let offset = if gap.norm() <= near { Vector3::zeros() } else { gap };
        return Some(Carried { place: place_of, offset });
    }
    let message = format!(
        "point `{}` is on no member: the nearest is member `{}` at {} of its length, {distance:.3e} m away",
        name.value,
        plan.name,
        s / plan.length(),
    );
    let help = "move it, let a member go through it, or link it: { linked_to = \"...\", offset = [...] }";
    reader.error_help(name.span, message, help)
}

/// The node or the section at an arc length from the start of a member.
fn place_along(plan: &MemberPlan, member: usize, s: f64) -> PlanPlace {
    let (node, at) = plan.node_near(s);
    if (at - s).abs() <= SAME_PLACE * plan.length() {
        return PlanPlace::Node(Station { member, node });
    }
    let (element, x) = plan.element_at(s);
    PlanPlace::Inside { member, element, x }
}

fn place_on_member(
    name: &Text,
    fraction: &Number,
    skeleton: &Skeleton,
    reader: &mut Reader,
) -> Option<PlanPlace> {
    let f = fraction.value;
    let Some(member) = skeleton.members.iter().position(|m| m.name == name.value) else {
        let names = skeleton.members.iter().map(|m| m.name.as_str());
        let help = super::diagnostic::suggest(&name.value, "members", names);
        return reader.error_help(
            name.span,
            format!("there is no member `{}`", name.value.escape_debug()),
            help,
        );
    };
    if !(0.0..=1.0).contains(&f) {
        return reader.error(fraction.span, format!("the fraction is {f}, expected a number from 0 to 1"));
    }
    let plan = &skeleton.members[member];
    Some(place_along(plan, member, f * plan.length()))
}

fn resolve_reference(
    name: &Text,
    points: &Named<PointFile>,
    carried: Option<&[Option<Carried>]>,
    reader: &mut Reader,
) -> Option<Station> {
    let index = points.find(name, "point", "points", reader)?;
    if let Some(PointFile::Linked(link)) = &points.items[index].1 {
        let message =
            format!("the reference `{}` is only linked to a node, expected a point that is one", name.value);
        return reader.error_help(
            name.span,
            message,
            format!("point `{}` could be it", link.linked_to.value),
        );
    }
    match carried?[index]?.place {
        PlanPlace::Node(station) => Some(station),
        PlanPlace::Inside { .. } => {
            let message =
                format!("the reference `{}` is between nodes, expected a point that is one", name.value);
            reader.error_help(name.span, message, "let a member go through it in its `path`")
        }
    }
}

fn resolve_mass(
    file: &MassFile,
    points: &Named<PointFile>,
    carried: Option<&[Option<Carried>]>,
    reader: &mut Reader,
) -> Option<MassPlan> {
    let point = points.find(&file.point, "point", "points", reader);
    let mass = positive(&file.mass, "the mass", "kg", reader);
    let inertia = match &file.inertia {
        None => Some(Matrix3::zeros()),
        Some(given) => {
            let symmetric = symmetric(&given.0, "the inertia", reader);
            symmetric.and_then(|j| check_inertia(j, given.0.span, reader))
        }
    };
    let offset = file.offset.as_ref().map_or(Vector3::zeros(), |o| o.value);
    let carried = carried?[point?]?;
    let PlanPlace::Node(station) = carried.place else {
        let message = format!("point `{}` is between nodes: a mass needs a node", file.point.value);
        let help = "let the member go through the point in its `path`, or choose the number of elements so that a node is there";
        return reader.error_help(file.point.span, message, help);
    };
    Some(MassPlan { station, mass: rigid_mass(mass?, carried.offset + offset, inertia?) })
}

/// A body has an inertia about its centre of mass whose principal moments are not negative and none larger than the sum
/// of the others.
fn check_inertia(
    j: Matrix3<f64>,
    span: super::diagnostic::Span,
    reader: &mut Reader,
) -> Option<Matrix3<f64>> {
    let mut moments: Vec<f64> = j.symmetric_eigenvalues().iter().copied().collect();
    moments.sort_by(f64::total_cmp);
    let [a, b, c] = [moments[0], moments[1], moments[2]];
    let round_off = 1e-9 * c.abs().max(a.abs());
    if a >= -round_off && c <= a + b + round_off {
        return Some(j);
    }
    let message = format!("no body has this inertia: its principal moments are {a}, {b} and {c} kg m^2");
    let help = "none may be negative or larger than the sum of the other two; products of inertia enter with a minus sign";
    reader.error_help(span, message, help)
}

/// 6x6 mass about the node of a body of mass `m`, centre of mass at `r`, inertia `j` about it: (v, w) with
/// `v_cm = v - r~ w`.
fn rigid_mass(m: f64, r: Vector3<f64>, j: Matrix3<f64>) -> Matrix6<f64> {
    let skew = r.cross_matrix();
    let mut mass = Matrix6::zeros();
    mass.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * m));
    mass.fixed_view_mut::<3, 3>(0, 3).copy_from(&(skew * -m));
    mass.fixed_view_mut::<3, 3>(3, 0).copy_from(&(skew * m));
    mass.fixed_view_mut::<3, 3>(3, 3).copy_from(&(j - skew * skew * m));
    mass
}

/// The points by name, with the section frames of the members at their nodes.
fn plan_points(
    points: &Named<PointFile>,
    skeleton: Option<&Skeleton>,
    carried: Option<&[Option<Carried>]>,
) -> Vec<(String, Option<PointPlan>)> {
    let plan = |index: usize, name: &str| {
        let (skeleton, carried) = (skeleton?, carried?[index]?);
        let Carried { place, offset } = carried;
        let sections = match place {
            PlanPlace::Node(station) => section_frames(skeleton, station),
            PlanPlace::Inside { member, element, x } => {
                let member = &skeleton.members[member];
                vec![(member.name.clone(), member.inside(element, x, &skeleton.joints).1)]
            }
        };
        Some(PointPlan { name: name.to_owned(), place, offset, sections })
    };
    points.names().enumerate().map(|(index, name)| (name.to_owned(), plan(index, name))).collect()
}

/// Frames of all members at a node; a member's own frames once each.
fn section_frames(skeleton: &Skeleton, at: Station) -> Vec<(String, Matrix3<f64>)> {
    let mut list: Vec<(String, Matrix3<f64>)> = Vec::new();
    let mut add = |name: &str, frame: Matrix3<f64>| {
        let known = list.iter().any(|(n, e)| n == name && (e - frame).amax() < 1e-9);
        if !known {
            list.push((name.to_owned(), frame));
        }
    };
    let joint = skeleton.members[at.member].joint_at(at.node);
    for (index, member) in skeleton.members.iter().enumerate() {
        let nodes: Vec<usize> = match joint {
            Some(joint) => member.nodes_at(joint).collect(),
            None if index == at.member => vec![at.node],
            None => vec![],
        };
        for frame in nodes.into_iter().flat_map(|node| member.frames(node)) {
            add(&member.name, frame);
        }
    }
    list
}
