//! A quantity along a member as written: one value, `[start, end]`, or `[[fraction, value], ..]`.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use toml::de::DeValue;

use super::read::{Node, Read, Reader};
use super::values::{Number, limit};

/// Values at ascending fractions of the length, from 0 to 1 where there are several.
#[derive(Clone, Debug)]
pub(crate) struct CourseFile<T>(pub Vec<(f64, T)>);

impl<T: Read> Read for CourseFile<T> {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let DeValue::Array(list) = node.get_ref() else {
            return Some(Self(vec![(0.0, T::read(node, reader)?)]));
        };
        limit(list.len(), node.span().into(), reader)?;
        let stations = list.iter().filter(|item| item.get_ref().is_array()).count();
        if stations == 0 && list.len() == 2 {
            let [start, end] = <[T; 2]>::read(node, reader)?;
            return Some(Self(vec![(0.0, start), (1.0, end)]));
        }
        if stations != list.len() || list.len() < 2 {
            return reader.wrong(node, "one value, [start, end], or [[fraction, value], ...] from 0 to 1");
        }
        let read: Vec<Option<(Number, T)>> = list.iter().map(|item| station(item, reader)).collect();
        ascending(read.into_iter().collect::<Option<_>>()?, reader)
    }
}

/// `[fraction, value]`.
fn station<T: Read>(node: &Node, reader: &mut Reader) -> Option<(Number, T)> {
    match node.get_ref().as_array() {
        Some(pair) if pair.len() == 2 => {
            let (fraction, value) = (Number::read(&pair[0], reader), T::read(&pair[1], reader));
            Some((fraction?, value?))
        }
        _ => reader.wrong(node, "[fraction, value]"),
    }
}

fn ascending<T>(stations: Vec<(Number, T)>, reader: &mut Reader) -> Option<CourseFile<T>> {
    let last = stations.len() - 1;
    for (k, (fraction, _)) in stations.iter().enumerate() {
        let (f, span) = (fraction.value, fraction.span);
        if k == 0 && f != 0.0 {
            return reader.error(span, format!("the first fraction is {f}, expected 0: the start"));
        }
        if k == last && f != 1.0 {
            return reader.error(span, format!("the last fraction is {f}, expected 1: the end"));
        }
        if k > 0 && f <= stations[k - 1].0.value {
            let message =
                format!("the fraction {f} follows {}, expected a larger one", stations[k - 1].0.value);
            return reader.error_help(span, message, "a step is made by two members that meet there");
        }
    }
    Some(CourseFile(stations.into_iter().map(|(fraction, value)| (fraction.value, value)).collect()))
}

impl<T: JsonSchema> JsonSchema for CourseFile<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("CourseOf{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let value = generator.subschema_for::<T>();
        let number = generator.subschema_for::<Number>();
        let ends = json_schema!({ "type": "array", "items": value, "minItems": 2, "maxItems": 2 });
        let station = json_schema!({
            "type": "array", "items": { "anyOf": [number, value] }, "minItems": 2, "maxItems": 2,
        });
        let stations = json_schema!({ "type": "array", "items": station, "minItems": 2 });
        json_schema!({ "anyOf": [value, ends, stations] })
    }
}
