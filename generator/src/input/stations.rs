//! Blocks of stations for aerodynamic codes: as written, and as places on the members.

use std::borrow::Cow;

use nalgebra::Vector3;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::diagnostic::{Span, suggest};
use super::read::{Node, Read, Reader, table};
use super::values::{Count, List, Named, Number, Text, Triple};
use crate::mesh::plan::{MemberPlan, StationBlockPlan, StationPlan};

/// Most stations of a block.
const MOST_STATIONS: usize = 100_000;

table! {
    /// Stations along members that a host reads and loads all at once.
    StationsFile {
        /// Members they are on, in this order.
        members: List<Text>,
        /// Number on each member: in the middles of so many parts of equal length.
        count: Option<Count>,
        /// Instead of `count`: their fractions of the length of each member, ascending from 0 to 1.
        fractions: Option<List<Number>>,
        /// From the axis to the station in section axes, m: [x, y, z], or [start, end] of each member and linear between. Default zero.
        offset: Option<OffsetFile>,
    }
}

/// Offset at the start and at the end of a member.
#[derive(Clone, Debug)]
pub(crate) struct OffsetFile([Vector3<f64>; 2]);

impl Read for OffsetFile {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let nested = node
            .get_ref()
            .as_array()
            .and_then(|list| list.first())
            .is_some_and(|item| item.get_ref().is_array());
        if nested {
            return <[Triple; 2]>::read(node, reader).map(|ends| Self(ends.map(|end| end.value)));
        }
        Triple::read(node, reader).map(|offset| Self([offset.value; 2]))
    }
}

impl JsonSchema for OffsetFile {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "StationOffset".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let triple = generator.subschema_for::<Triple>();
        json_schema!({ "anyOf": [triple, { "type": "array", "items": triple, "minItems": 2, "maxItems": 2 }] })
    }
}

/// Checks the blocks against the members.
pub(crate) fn resolve_stations(
    blocks: &Named<StationsFile>,
    members: &[MemberPlan],
    reader: &mut Reader,
) -> Vec<StationBlockPlan> {
    let mut list = Vec::new();
    for (name, block) in &blocks.items {
        let Some(block) = block else { continue };
        if let Some(stations) = block.resolve(members, reader) {
            list.push(StationBlockPlan { name: name.value.clone(), stations });
        }
    }
    list
}

impl StationsFile {
    fn resolve(&self, members: &[MemberPlan], reader: &mut Reader) -> Option<Vec<StationPlan>> {
        let what = "stations";
        let fractions = fractions(what, self.count.as_ref(), self.fractions.as_ref(), self.span, reader);
        let named: Vec<Option<usize>> =
            self.members.items.iter().map(|name| find(name.as_ref()?, members, reader)).collect();
        if self.members.items.is_empty() {
            return reader.error(self.members.span, "stations on no member, expected one or more");
        }
        let (fractions, named) = (fractions?, named.into_iter().collect::<Option<Vec<_>>>()?);
        if fractions.len() * named.len() > MOST_STATIONS {
            let message =
                format!("{} stations, at most {MOST_STATIONS} are accepted", fractions.len() * named.len());
            return reader.error(self.span, message);
        }
        let ends = self.offset.as_ref().map_or([Vector3::zeros(); 2], |offset| offset.0);
        let station = |member: usize, fraction: f64| {
            let (element, x) = members[member].element_at(fraction * members[member].length());
            StationPlan {
                member,
                fraction,
                element,
                x,
                offset: ends[0] * (1.0 - fraction) + ends[1] * fraction,
            }
        };
        Some(
            named
                .iter()
                .flat_map(|&m| fractions.iter().map(move |&f| (m, f)))
                .map(|(m, f)| station(m, f))
                .collect(),
        )
    }
}

/// Fractions of the length of a member: given, or the middles of so many parts.
pub(super) fn fractions(
    what: &str,
    count: Option<&Count>,
    fractions: Option<&List<Number>>,
    span: Span,
    reader: &mut Reader,
) -> Option<Vec<f64>> {
    match (count, fractions) {
        (Some(count), None) => {
            let n = count.value;
            Some((0..n).map(|k| (k as f64 + 0.5) / n as f64).collect())
        }
        (None, Some(list)) => {
            let given = list.items.iter().map(Option::as_ref).collect::<Option<Vec<_>>>()?;
            for (k, fraction) in given.iter().enumerate() {
                let f = fraction.value;
                if !(0.0..=1.0).contains(&f) {
                    let message = format!("the fraction is {f}, expected a number from 0 to 1");
                    return reader.error(fraction.span, message);
                }
                if k > 0 && f <= given[k - 1].value {
                    let message =
                        format!("the fraction {f} follows {}, expected a larger one", given[k - 1].value);
                    return reader.error(fraction.span, message);
                }
            }
            if given.is_empty() {
                return reader.error(list.span, "no fractions, expected one or more");
            }
            Some(given.iter().map(|fraction| fraction.value).collect())
        }
        _ => reader.error(span, format!("{what} need either `count` or `fractions`")),
    }
}

pub(super) fn find(name: &Text, members: &[MemberPlan], reader: &mut Reader) -> Option<usize> {
    let found = members.iter().position(|member| member.name == name.value);
    if found.is_none() {
        let help = suggest(&name.value, "members", members.iter().map(|member| member.name.as_str()));
        let message = format!("there is no member `{}`", name.value.escape_debug());
        return reader.error_help(name.span, message, help);
    }
    found
}
