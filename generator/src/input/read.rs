//! From TOML values with their places to the types of the file: every key known, every value of the right shape.

use std::sync::Arc;

use schemars::Schema;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::diagnostic::{Diagnostic, Source, Span, suggest};
use super::parameters::{Parameters, Place, Written};

pub(crate) type Node<'a> = Spanned<DeValue<'a>>;
pub(crate) type Table<'a> = DeTable<'a>;
pub(crate) type Key<'a> = Spanned<DeString<'a>>;

/// What reading needs to know and what it has found wrong.
pub(crate) struct Reader<'a> {
    pub source: Arc<Source>,
    pub parameters: &'a Parameters,
    pub errors: Vec<Diagnostic>,
    /// The key being read, for messages.
    key: String,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(source: &Arc<Source>, parameters: &'a Parameters, errors: Vec<Diagnostic>) -> Self {
        Self { source: Arc::clone(source), parameters, errors, key: String::new() }
    }

    /// Reads a value that belongs to a key.
    pub(crate) fn read<T: Read>(&mut self, key: &str, node: &Node) -> Option<T> {
        let outer = std::mem::replace(&mut self.key, key.to_owned());
        let value = T::read(node, self);
        self.key = outer;
        value
    }

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
    pub(crate) fn wrong<T>(&mut self, node: &Node, expected: &str) -> Option<T> {
        let message = format!("`{}`: found {}, expected {expected}", self.key.escape_debug(), describe(node));
        self.error(node.span().into(), message)
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
    pub table: &'b Table<'a>,
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
            Some(node) => reader.read(key, node),
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
                let tag = fields.take::<$crate::input::values::Text>($tag, reader)?;
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
                let word = $crate::input::values::Text::read(node, reader)?;
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
