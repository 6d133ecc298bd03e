//! From TOML values with their places to the types of the file: every key known, every value of the right shape.

use std::borrow::Cow;
use std::sync::Arc;

use nalgebra::{SMatrix, Vector3};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use toml::Spanned;
use toml::de::{DeArray, DeString, DeTable, DeValue};

use super::diagnostic::{Diagnostic, Source, Span, suggest};
use super::parameters::{Parameters, Place, Written};

/// Most elements a structure may have.
pub(crate) const MOST_ELEMENTS: usize = 1_000_000;

/// Most entries of one table or list.
pub(crate) const MOST_ENTRIES: usize = 10_000;

pub(crate) type Node<'a> = Spanned<DeValue<'a>>;
pub(crate) type Table<'a> = DeTable<'a>;
pub(crate) type Key<'a> = Spanned<DeString<'a>>;

/// What reading needs to know and what it has found wrong.
pub(crate) struct Reader<'a> {
    pub source: Arc<Source>,
    pub parameters: &'a Parameters,
    pub errors: Vec<Diagnostic>,
}

impl Reader<'_> {
    /// Reports an error; returns `None` for use with `?` and as a value.
    pub(crate) fn error<T>(&mut self, span: Span, message: impl Into<String>) -> Option<T> {
        self.errors.push(Diagnostic::new(&self.source, span, message.into(), None));
        None
    }

    /// Reports an error with a hint.
    pub(crate) fn error_help<T>(
        &mut self,
        span: Span,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Option<T> {
        self.errors.push(Diagnostic::new(&self.source, span, message.into(), Some(help.into())));
        None
    }

    /// The value is not of the kind expected.
    fn wrong<T>(&mut self, node: &Node, expected: &str) -> Option<T> {
        self.error(node.span().into(), format!("found {}, expected {expected}", describe(node)))
    }
}

/// A type that can be read from a TOML value. Errors are reported to the reader; `None` means that there were some.
pub(crate) trait Read: Sized {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self>;

    /// The key is not there. `table` is where it was looked for.
    fn absent(key: &str, table: Span, reader: &mut Reader) -> Option<Self> {
        reader.error(table, format!("key `{key}` is missing here"))
    }
}

impl<T: Read> Read for Option<T> {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        T::read(node, reader).map(Some)
    }

    fn absent(_: &str, _: Span, _: &mut Reader) -> Option<Self> {
        Some(None)
    }
}

/// A table read key by key; what is not asked for is refused.
pub(crate) struct Fields<'a, 'b> {
    table: &'b Table<'a>,
    pub span: Span,
    known: Vec<&'static str>,
}

impl<'a, 'b> Fields<'a, 'b> {
    pub(crate) fn new(table: &'b Table<'a>, span: Span) -> Self {
        Self { table, span, known: Vec::new() }
    }

    pub(crate) fn of(node: &'b Node<'a>, reader: &mut Reader) -> Option<Self> {
        match node.get_ref() {
            DeValue::Table(table) => Some(Self::new(table, node.span().into())),
            _ => reader.wrong(node, "a table"),
        }
    }

    /// Whether the key is there.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// Reads one key.
    pub(crate) fn take<T: Read>(&mut self, key: &'static str, reader: &mut Reader) -> Option<T> {
        self.known.push(key);
        match self.table.get(key) {
            Some(node) => T::read(node, reader),
            None => T::absent(key, self.span, reader),
        }
    }

    /// Refuses the keys that nothing asked for. They leave the rest usable.
    pub(crate) fn finish(self, reader: &mut Reader) {
        for (key, _) in entries(self.table) {
            if !self.known.contains(&key.get_ref().as_ref()) {
                let name = key.get_ref().as_ref();
                let help = suggest(name, "keys known here", self.known.iter().copied());
                let message = format!("there is no key `{}` here", name.escape_debug());
                reader.error_help::<()>(key.span().into(), message, help);
            }
        }
    }
}

/// Entries of a table in the order of the text.
pub(crate) fn entries<'a, 'b>(table: &'b Table<'a>) -> Vec<(&'b Key<'a>, &'b Node<'a>)> {
    let mut list: Vec<_> = table.iter().collect();
    list.sort_by_key(|(key, _)| key.span().start);
    list
}

/// A value in words, for messages.
fn describe(node: &Node) -> String {
    match node.get_ref() {
        DeValue::String(s) if s.chars().count() <= 40 => format!("the text {:?}", s.as_ref()),
        DeValue::String(_) => "a text".into(),
        DeValue::Integer(i) => format!("the number {i}"),
        DeValue::Float(x) => format!("the number {x}"),
        DeValue::Boolean(b) => b.to_string(),
        DeValue::Datetime(_) => "a date".into(),
        DeValue::Array(a) => format!("a list of {}", a.len()),
        DeValue::Table(_) => "a table".into(),
    }
}

/// A number as written, if the value is one.
pub(crate) fn written(node: &Node) -> Option<Written> {
    match node.get_ref() {
        DeValue::Integer(i) => {
            i64::from_str_radix(i.as_str(), i.radix()).ok().map(|i| Written::Literal(i as f64))
        }
        DeValue::Float(x) => x.as_str().parse().ok().map(Written::Literal),
        DeValue::String(s) => Some(Written::Expression(s.to_string())),
        _ => None,
    }
}

pub(crate) fn place(node: &Node, source: &Arc<Source>) -> Place {
    let text = node.get_ref().as_str().unwrap_or("");
    Place::new(source, node.span().into(), text)
}

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
            return reader.error(span, message);
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
    pub value: SMatrix<f64, N, N>,
    pub span: Span,
    /// Places of the entries.
    pub entries: Vec<Span>,
}

impl<const N: usize> Read for Square<N> {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let rows = <[[Number; N]; N]>::read(node, reader)?;
        let value = SMatrix::from_fn(|i, j| rows[i][j].value);
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

fn limit(count: usize, span: Span, reader: &mut Reader) -> Option<()> {
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
            items.push((name, T::read(value, reader)));
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

/// Defines a table of the file once: the type, how it is read and its JSON Schema.
macro_rules! table {
    ($(#[$meta:meta])* $name:ident { $($(#[$field_meta:meta])* $field:ident: $type:ty,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Debug, schemars::JsonSchema)]
        #[schemars(deny_unknown_fields)]
        #[allow(non_snake_case, dead_code)]
        pub(crate) struct $name {
            $($(#[$field_meta])* pub $field: $type,)*
            /// Where the table is.
            #[schemars(skip)]
            pub span: $crate::input::diagnostic::Span,
        }

        impl $name {
            #[allow(non_snake_case)]
            pub(crate) fn read_fields(
                mut fields: $crate::input::read::Fields,
                reader: &mut $crate::input::read::Reader,
            ) -> Option<Self> {
                let span = fields.span;
                $(let $field = fields.take::<$type>(stringify!($field), reader);)*
                fields.finish(reader);
                Some(Self { $($field: $field?,)* span })
            }
        }

        impl $crate::input::read::Read for $name {
            fn read(
                node: &$crate::input::read::Node,
                reader: &mut $crate::input::read::Reader,
            ) -> Option<Self> {
                let fields = $crate::input::read::Fields::of(node, reader)?;
                Self::read_fields(fields, reader)
            }
        }
    };
}

/// Defines tables told apart by one key, each variant a table of its own.
macro_rules! tagged {
    ($(#[$meta:meta])* $name:ident by $tag:literal { $($text:literal => $variant:ident,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Debug)]
        pub(crate) enum $name {
            $($variant($variant),)*
        }

        impl $crate::input::read::Read for $name {
            fn read(
                node: &$crate::input::read::Node,
                reader: &mut $crate::input::read::Reader,
            ) -> Option<Self> {
                let mut fields = $crate::input::read::Fields::of(node, reader)?;
                let tag = fields.take::<$crate::input::read::Text>($tag, reader)?;
                match tag.value.as_str() {
                    $($text => $variant::read_fields(fields, reader).map(Self::$variant),)*
                    _ => {
                        let all = [$($text),*];
                        let help = $crate::input::diagnostic::suggest(&tag.value, "possible values", all);
                        let message = format!("`{}` is no {}", tag.value.escape_debug(), $tag);
                        reader.error_help(tag.span, message, help)
                    }
                }
            }
        }

        impl schemars::JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                let variants: Vec<schemars::Schema> = vec![$(
                    $crate::input::read::with_tag($variant::json_schema(generator), $tag, $text)
                ),*];
                schemars::json_schema!({ "oneOf": variants })
            }
        }
    };
}

/// Defines a choice between words.
macro_rules! words {
    ($(#[$meta:meta])* $name:ident { $($(#[$word_meta:meta])* $text:literal => $variant:ident,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, schemars::JsonSchema)]
        pub(crate) enum $name {
            $($(#[$word_meta])* #[schemars(rename = $text)] $variant,)*
        }

        impl $crate::input::read::Read for $name {
            fn read(
                node: &$crate::input::read::Node,
                reader: &mut $crate::input::read::Reader,
            ) -> Option<Self> {
                let word = $crate::input::read::Text::read(node, reader)?;
                match word.value.as_str() {
                    $($text => Some(Self::$variant),)*
                    _ => {
                        let all = [$($text),*];
                        let help = $crate::input::diagnostic::suggest(&word.value, "possible values", all);
                        let message = format!("`{}` is not possible here", word.value.escape_debug());
                        reader.error_help(word.span, message, help)
                    }
                }
            }
        }
    };
}

pub(crate) use {table, tagged, words};

/// Adds the key that tells variants apart to the schema of one.
pub(crate) fn with_tag(mut schema: Schema, tag: &str, text: &str) -> Schema {
    let object = schema.ensure_object();
    let insert = |object: &mut serde_json::Map<String, serde_json::Value>| {
        let properties = object.entry("properties").or_insert_with(|| serde_json::json!({}));
        if let Some(map) = properties.as_object_mut() {
            map.insert(tag.to_owned(), serde_json::json!({ "type": "string", "const": text }));
        }
        let required = object.entry("required").or_insert_with(|| serde_json::json!([]));
        if let Some(list) = required.as_array_mut() {
            list.insert(0, tag.into());
        }
    };
    insert(object);
    schema
}
