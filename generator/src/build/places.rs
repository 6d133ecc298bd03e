//! Places that move with the structure, as a model file holds them: named points, stations of members for distributed loads, and blocks
//! of stations.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3, Vector6};
use rom_runtime::data::{LineData, PointData, StationSet, StationsData};
use rom_runtime::expression::Variables;
use rom_runtime::loads::{DistributedFrame, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;

use super::matrix_rows;
use crate::carrier::{Carrier, SharedBeam};
use crate::configuration::Configuration;
use crate::element::internal_force::stack;
use crate::element::shape::gauss;
use crate::equilibrium::Equilibrium;
use crate::math::so3::scalar_first;
use crate::mesh::{Mesh, Station, StationBlock};
use crate::reduce::lagrangian::{CarriedPlace, EquilibriumLoads};
use crate::reduce::modes::Modes;

/// Every named point, then every station of the lines and of the blocks, by the nodes that carry it.
pub(super) fn carried_places(mesh: &Mesh, at: &Configuration, all: bool) -> Vec<CarriedPlace> {
    let points = Carrier::of_points(mesh).into_iter().map(|carrier| carrier.placed(at));
    let stations = line_carriers(mesh, all).into_iter().flatten();
    let stations = stations.chain(mesh.stations.iter().flat_map(|block| block_carriers(mesh, block)));
    points.chain(stations.map(|carrier| carrier.placed_in_section(at))).collect()
}

/// What acts on these places in an equilibrium.
pub(super) fn equilibrium_loads(mesh: &Mesh, equilibrium: &Equilibrium, all: bool) -> EquilibriumLoads {
    let at = &equilibrium.configuration;
    let into_a = equilibrium.attitude.inverse();
    // Force in A, moment in the axes that the place has in A.
    let on_place =
        |frame: &LoadFrame, axes: &Matrix3<f64>, offset: &Vector3<f64>, load: [Vector3<f64>; 2]| {
            let [force, moment] = load.map(|x| match frame {
                LoadFrame::Dead => axes.tr_mul(&(into_a * x)),
                LoadFrame::Body => axes.tr_mul(&x),
                LoadFrame::Follower { section } => Matrix3::from_fn(|i, j| section[i][j]) * x,
            });
            stack(&(axes * force), &(moment + offset.cross(&force)))
        };
    let factor = |time: &TimeFunction| time.value(&Variables::default());
    let mut places = vec![Vector6::zeros(); mesh.points.len()];
    for load in &equilibrium.loads {
        let point = &mesh.points[load.point as usize];
        let axes = Carrier::new(mesh, point.place).rotation(|node| at.rotation_matrix(node));
        let vectors = [load.force, load.moment].map(|x| Vector3::from(x) * factor(&load.time));
        places[load.point as usize] += on_place(&load.frame, &axes, &point.offset, vectors);
    }
    for (member, carriers) in line_carriers(mesh, all).iter().enumerate() {
        for (station, carrier) in carriers.iter().enumerate() {
            let axes = carrier.rotation(|node| at.rotation_matrix(node)) * carrier.drawing_frame();
            let mut sum = Vector6::zeros();
            for load in equilibrium.distributed.iter().filter(|load| load.member as usize == member) {
                let frame = match load.frame {
                    DistributedFrame::Dead => LoadFrame::Dead,
                    DistributedFrame::Body => LoadFrame::Body,
                    DistributedFrame::Follower => LoadFrame::Follower { section: SECTION_AXES },
                };
                let vectors = [&load.force, &load.moment].map(|list| {
                    let vector = list.get(3 * station..3 * station + 3);
                    vector.map_or_else(Vector3::zeros, Vector3::from_column_slice) * factor(&load.time)
                });
                sum += on_place(&frame, &axes, &Vector3::zeros(), vectors);
            }
            places.push(sum);
        }
    }
    // Blocks of stations carry nothing that a file gives them.
    let stations: usize = mesh.stations.iter().map(|block| block.stations.len()).sum();
    places.extend(std::iter::repeat_n(Vector6::zeros(), stations));
    EquilibriumLoads { places, gravity: into_a * mesh.gravity }
}

/// Axes of a station, in which its load is given already.
const SECTION_AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A named point.
pub(super) fn point_data(
    mesh: &Mesh,
    point: &crate::mesh::Point,
    at: &Configuration,
    modes: &Modes,
) -> PointData {
    let carrier = Carrier::new(mesh, point.place);
    let phi = carrier.shapes(at, |node| modes.at_node(node));
    let (position, rotation) = carrier.at(at);
    let rows = |first: usize| (first..first + 3).flat_map(|k| phi.iter().map(move |v| v[k])).collect();
    PointData {
        name: point.name.clone(),
        node_position: position.into(),
        node_rotation: scalar_first(&rotation),
        offset: point.offset.into(),
        phi_translation: rows(0),
        phi_rotation: rows(3),
        sections: point.sections.iter().map(|(name, e)| (name.clone(), matrix_rows(e))).collect(),
    }
}

/// Stations of every member: of those that distributed loads act on, or of all; no members where there are none at all.
fn line_carriers(mesh: &Mesh, all: bool) -> Vec<Vec<Carrier>> {
    let cases = mesh.load_cases.iter().chain(mesh.trim.as_ref().map(|trim| &trim.case));
    let spread = |case: &'_ LoadCase| {
        let shape = case.initial.iter().flat_map(|start| &start.shape_distributed);
        case.distributed.iter().chain(shape).map(|load| load.member as usize).collect::<Vec<_>>()
    };
    let loaded: Vec<usize> = cases.flat_map(spread).collect();
    if loaded.is_empty() && !all {
        return Vec::new();
    }
    let stations = |(index, member): (usize, &crate::mesh::Member)| {
        let wanted = all || loaded.contains(&index);
        let of_element = |element| {
            let beam = SharedBeam::new(mesh, element);
            gauss(3).iter().map(move |(x, _)| Carrier::inside(&beam, *x))
        };
        member.elements.clone().filter(|_| wanted).flat_map(of_element).collect()
    };
    mesh.members.iter().enumerate().map(stations).collect()
}

/// The axes of all members, with their stations.
pub(super) fn lines(mesh: &Mesh, at: &Configuration, modes: &Modes, all: bool) -> Vec<LineData> {
    let line = |(member, carriers): (&crate::mesh::Member, Vec<Carrier>)| {
        let ends: Vec<f64> = mesh.elements[member.elements.clone()]
            .iter()
            .scan(0.0, |end, element| {
                *end += element.length;
                Some(*end)
            })
            .collect();
        let length = ends.last().copied().unwrap_or_default();
        let inner = ends[..ends.len() - 1].iter().map(|end| end / length);
        let knots = std::iter::once(0.0).chain(inner).chain([1.0]).collect();
        let stations = station_set(carriers.into_iter(), at, modes);
        LineData { name: member.name.clone(), length, knots, stations }
    };
    mesh.members.iter().zip(line_carriers(mesh, all)).map(line).collect()
}

/// The sections of the stations of a block.
fn block_carriers(mesh: &Mesh, block: &StationBlock) -> Vec<Carrier> {
    let inside = |s: &Station| Carrier::inside(&SharedBeam::new(mesh, s.element), s.x);
    block.stations.iter().map(inside).collect()
}

/// A block of stations, with the members it goes along.
pub(super) fn block_data(
    mesh: &Mesh,
    block: &StationBlock,
    at: &Configuration,
    modes: &Modes,
) -> StationsData {
    let mut members: Vec<(String, u32)> = Vec::new();
    let mut last = None;
    for station in &block.stations {
        if last != Some(station.member) {
            members.push((mesh.members[station.member].name.clone(), 0));
            last = Some(station.member);
        }
        if let Some((_, count)) = members.last_mut() {
            *count += 1;
        }
    }
    StationsData {
        name: block.name.clone(),
        members,
        fraction: block.stations.iter().map(|s| s.fraction).collect(),
        offset: block.stations.iter().flat_map(|s| <[f64; 3]>::from(s.offset)).collect(),
        sections: station_set(block_carriers(mesh, block).into_iter(), at, modes),
    }
}

/// Sections in their own axes.
fn station_set(carriers: impl Iterator<Item = Carrier>, at: &Configuration, modes: &Modes) -> StationSet {
    let mut set = StationSet::default();
    for carrier in carriers {
        let (position, rotation) = carrier.at(at);
        let e = carrier.drawing_frame();
        let frame = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(e));
        set.position.extend(position.iter());
        set.rotation.extend(scalar_first(&(rotation * frame)));
        let phi = carrier.shapes(at, |node| modes.at_node(node));
        for k in 0..3 {
            set.phi_translation.extend(phi.iter().map(|v| v[k]));
        }
        let turns: Vec<Vector3<f64>> = phi.iter().map(|v| e.tr_mul(&v.fixed_rows::<3>(3))).collect();
        for k in 0..3 {
            set.phi_rotation.extend(turns.iter().map(|v| v[k]));
        }
    }
    set
}
