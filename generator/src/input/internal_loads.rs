//! Places along the members where section forces are told.

use nalgebra::Vector3;

use super::read::{Reader, table};
use super::stations::{find, fractions};
use super::values::{Count, List, Named, Number, Text};
use crate::mesh::plan::{MemberPlan, StationPlan};

/// Most places of a structure: each takes six solutions of the structure, and arrays in the model.
const MOST_PLACES: usize = 1000;

table! {
    /// Places along a member where section forces and moments are told.
    InternalLoadsFile {
        /// Member they are on.
        member: Text,
        /// Number of places: in the middles of so many parts of equal length.
        count: Option<Count>,
        /// Instead of `count`: their fractions of the length of the member, ascending from 0 to 1.
        fractions: Option<List<Number>>,
    }
}

/// Checks the places against the members.
pub(crate) fn resolve_internal_loads(
    blocks: &Named<InternalLoadsFile>,
    members: &[MemberPlan],
    reader: &mut Reader,
) -> Vec<(String, StationPlan)> {
    let mut list: Vec<(String, StationPlan)> = Vec::new();
    for (name, block) in &blocks.items {
        let Some(block) = block else { continue };
        let (count, given) = (block.count.as_ref(), block.fractions.as_ref());
        let places = fractions("internal loads", count, given, block.span, reader);
        let (Some(places), Some(member)) = (places, find(&block.member, members, reader)) else { continue };
        if list.len() + places.len() > MOST_PLACES {
            let message = format!("more than {MOST_PLACES} places of internal loads in all");
            reader.error::<()>(block.span, message);
            continue;
        }
        let single = places.len() == 1;
        for (k, fraction) in places.into_iter().enumerate() {
            let (element, x) = members[member].element_at(fraction * members[member].length());
            let own = if single { name.value.clone() } else { format!("{} {}", name.value, k + 1) };
            if list.iter().any(|(other, _)| *other == own) {
                let message =
                    format!("two places of internal loads are named `{own}`; give the block another name");
                reader.error::<()>(name.span, message);
            }
            list.push((own, StationPlan { member, fraction, element, x, offset: Vector3::zeros() }));
        }
    }
    list
}
