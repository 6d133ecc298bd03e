//! Places that move with the structure, as a model file holds them: named points, stations of members for distributed loads, and blocks
//! of stations.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use rom_runtime::data::{LineData, PointData, StationSet, StationsData};
use rom_runtime::loads::LoadCase;

use super::matrix_rows;
use crate::carrier::{Carrier, SharedBeam};
use crate::configuration::Configuration;
use crate::element::shape::gauss;
use crate::math::so3::scalar_first;
use crate::mesh::{Mesh, Station, StationBlock};
use crate::reduce::lagrangian::CarriedPlace;
use crate::reduce::modes::Modes;

/// Every named point, then every station of the lines and of the blocks, by the nodes that carry it.
pub(super) fn carried_places(mesh: &Mesh, at: &Configuration, all: bool) -> Vec<CarriedPlace> {
    let points = Carrier::of_points(mesh).into_iter().map(|carrier| carrier.placed(at));
    let stations = line_carriers(mesh, all).into_iter().flatten();
    let stations = stations.chain(mesh.stations.iter().flat_map(|block| block_carriers(mesh, block)));
    points.chain(stations.map(|carrier| carrier.placed_in_section(at))).collect()
}

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
