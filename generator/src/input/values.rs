//! Values of the file: numbers, texts, vectors, matrices, lists and tables by name.

use std::borrow::Cow;

use nalgebra::{SMatrix, Vector3};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use toml::de::{DeArray, DeValue};

use super::diagnostic::{Diagnostic, Span, suggest};
use super::read::{Fields, Node, Read, Reader, entries, place, written};

/// Most elements a structure may have.
pub(crate) const MOST_ELEMENTS: usize = 1_000_000;

/// Most entries of one table or list.
const MOST_ENTRIES: usize = 10_000;

/// A value with its place.
#[derive(Clone, Debug)]
pub(crate) struct At<T> {
    pub value: T,
    pub span: Span,
}

/// A finite number, given literally or as an expression of the parameters.
pub(crate) type Number = At<f64>;
/// A text.
pub(crate) type Text = At<String>;
/// A whole number from 1.
pub(crate) type Count = At<usize>;
/// Three numbers.
pub(crate) type Triple = At<Vector3<f64>>;

pub(crate) const NUMBER: &str = "a number or an expression in quotes";

impl Read for Number {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let Some(written) = written(node) else { return reader.wrong(node, NUMBER) };
        let place = place(node, &reader.source);
        let value = reader.parameters.evaluate(&written, &place, &mut reader.errors)?;
        Some(At { value, span: node.span().into() })
    }
}

impl JsonSchema for Number {
    fn schema_name() -> Cow<'static, str> {
        "Number".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number, or an expression of the parameters in quotes: \"sigma * 70e9\".",
            "type": ["number", "string"],
        })
    }
}

impl Read for Count {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let At { value, span } = Number::read(node, reader)?;
        // An expression like 120 * (1/3) may miss the integer by round-off.
        let count = value.round();
        if (value - count).abs() > 1e-9 * count.abs() || !(1.0..=MOST_ELEMENTS as f64).contains(&count) {
            let message = format!("this is {value}, expected a whole number from 1 to {MOST_ELEMENTS}");
            let origin = written(node).and_then(|w| reader.parameters.origin(&w));
            reader.errors.push(Diagnostic::new(&reader.source, span, message, origin));
            return None;
        }
        Some(At { value: count as usize, span })
    }
}

impl JsonSchema for Count {
    fn schema_name() -> Cow<'static, str> {
        "Count".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A whole number from 1, or an expression of the parameters that gives one.",
            "type": ["integer", "string"],
            "minimum": 1,
            "maximum": MOST_ELEMENTS,
        })
    }
}

impl Read for Text {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        match node.get_ref() {
            DeValue::String(s) => Some(At { value: s.to_string(), span: node.span().into() }),
            _ => reader.wrong(node, "a text in quotes"),
        }
    }
}

impl JsonSchema for Text {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Text".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string" })
    }
}

fn array<'a, 'b>(node: &'b Node<'a>, expected: &str, reader: &mut Reader) -> Option<&'b DeArray<'a>> {
    match node.get_ref() {
        DeValue::Array(list) => Some(list),
        _ => reader.wrong(node, expected),
    }
}

impl<T: Read, const N: usize> Read for [T; N] {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let expected = format!("a list of {N}");
        let list = array(node, &expected, reader)?;
        if list.len() != N {
            return reader.wrong(node, &expected);
        }
        let read: Vec<Option<T>> = list.iter().map(|item| T::read(item, reader)).collect();
        read.into_iter().collect::<Option<Vec<T>>>()?.try_into().ok()
    }
}

impl Read for Triple {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let list = <[Number; 3]>::read(node, reader)?;
        Some(At { value: Vector3::from(list.map(|n| n.value)), span: node.span().into() })
    }
}

impl JsonSchema for Triple {
    fn schema_name() -> Cow<'static, str> {
        "Triple".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let number = generator.subschema_for::<Number>();
        json_schema!({ "description": "Components x, y, z.", "type": "array", "items": number, "minItems": 3, "maxItems": 3 })
    }
}

/// A square matrix, row by row.
#[derive(Clone, Debug)]
pub(crate) struct Square<const N: usize> {
    pub value: Box<SMatrix<f64, N, N>>,
    pub span: Span,
    /// Places of the entries.
    pub entries: Vec<Span>,
}

impl<const N: usize> Read for Square<N> {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let rows = <[[Number; N]; N]>::read(node, reader)?;
        let value = Box::new(SMatrix::from_fn(|i, j| rows[i][j].value));
        let entries = rows.iter().flatten().map(|n| n.span).collect();
        Some(Self { value, span: node.span().into(), entries })
    }
}

impl<const N: usize> JsonSchema for Square<N> {
    fn schema_name() -> Cow<'static, str> {
        format!("Matrix{N}x{N}").into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let number = generator.subschema_for::<Number>();
        let row = json_schema!({ "type": "array", "items": number, "minItems": N, "maxItems": N });
        json_schema!({ "description": "A matrix, row by row.", "type": "array", "items": row, "minItems": N, "maxItems": N })
    }
}

/// A list; entries that are wrong are `None`.
#[derive(Clone, Debug)]
pub(crate) struct List<T> {
    pub items: Vec<Option<T>>,
    pub span: Span,
}

impl<T: Read> Read for List<T> {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let list = array(node, "a list", reader)?;
        limit(list.len(), node.span().into(), reader)?;
        let items = list.iter().map(|item| T::read(item, reader)).collect();
        Some(Self { items, span: node.span().into() })
    }
}

impl<T: JsonSchema> JsonSchema for List<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("ListOf{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let item = generator.subschema_for::<T>();
        json_schema!({ "type": "array", "items": item })
    }
}

pub(crate) fn limit(count: usize, span: Span, reader: &mut Reader) -> Option<()> {
    if count > MOST_ENTRIES {
        return reader.error(span, format!("{count} entries, at most {MOST_ENTRIES} are accepted"));
    }
    Some(())
}

/// A table of things by name, in the order of the text; entries that are wrong are `None`.
#[derive(Clone, Debug)]
pub(crate) struct Named<T> {
    pub items: Vec<(Text, Option<T>)>,
}

impl<T> Default for Named<T> {
    fn default() -> Self {
        Self { items: Vec::new() }
    }
}

impl<T> Named<T> {
    /// Names in order.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.items.iter().map(|(name, _)| name.value.as_str())
    }

    /// Index of a name that another place refers to.
    pub(crate) fn find(&self, name: &Text, one: &str, all: &str, reader: &mut Reader) -> Option<usize> {
        let found = self.names().position(|n| n == name.value);
        if found.is_none() {
            let help = suggest(&name.value, all, self.names());
            let message = format!("there is no {one} `{}`", name.value.escape_debug());
            return reader.error_help(name.span, message, help);
        }
        found
    }
}

impl<T: Read> Read for Named<T> {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let fields = Fields::of(node, reader)?;
        limit(fields.table.len(), fields.span, reader)?;
        let mut items = Vec::new();
        for (key, value) in entries(fields.table) {
            let name = At { value: key.get_ref().to_string(), span: key.span().into() };
            check_name(&name, reader);
            let item = reader.read(&name.value, value);
            items.push((name, item));
        }
        Some(Self { items })
    }
}

impl<T: JsonSchema> JsonSchema for Named<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("NamedTableOf{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let item = generator.subschema_for::<T>();
        json_schema!({ "type": "object", "additionalProperties": item })
    }
}

/// Names end up in file names and in comma-separated options: letters, digits, blanks and `_ - +` only.
pub(crate) fn check_name(name: &Text, reader: &mut Reader) -> Option<()> {
    let text = &name.value;
    let fine = |c: char| c.is_alphanumeric() || matches!(c, ' ' | '_' | '-' | '+');
    if text.is_empty() || text.len() > 64 || !text.chars().all(fine) || text.trim() != text {
        let message = format!("`{}` cannot be a name", text.escape_debug());
        let help = "a name has 1 to 64 letters, digits, inner blanks, and _ - +";
        return reader.error_help(name.span, message, help);
    }
    Some(())
}

pub(crate) fn positive(number: &Number, what: &str, unit: &str, reader: &mut Reader) -> Option<f64> {
    if number.value > 0.0 {
        return Some(number.value);
    }
    reader.error(number.span, format!("{what} is {} {unit}, expected a positive number", number.value))
}
