//! Strings of the model data, decoded so that a hostile length cannot allocate.
//!
//! `String`'s own implementation lets bincode reserve whatever length the file claims before it looks for the bytes.
//! Asking for `str` makes it hand out a slice of the section, which must be there, and only that is copied.

use alloc::{borrow::ToOwned, string::String, vec::Vec};
use core::fmt;
use serde::{Deserialize, Deserializer, de};

struct TextVisitor;

impl de::Visitor<'_> for TextVisitor {
    type Value = String;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a string")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<String, E> {
        Ok(text.to_owned())
    }

    fn visit_string<E: de::Error>(self, text: String) -> Result<String, E> {
        Ok(text)
    }
}

/// For `#[serde(deserialize_with)]` on a `String`.
pub(crate) fn string<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    deserializer.deserialize_str(TextVisitor)
}

/// For `#[serde(deserialize_with)]` on a `Vec<String>`.
pub(crate) fn strings<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<String>, D::Error> {
    Ok(Vec::<Text>::deserialize(deserializer)?.into_iter().map(|text| text.0).collect())
}

/// For `#[serde(deserialize_with)]` on a `Vec<(String, String)>`.
pub(crate) fn string_pairs<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<(String, String)>, D::Error> {
    let pairs = Vec::<(Text, Text)>::deserialize(deserializer)?;
    Ok(pairs.into_iter().map(|(name, value)| (name.0, value.0)).collect())
}

/// For `#[serde(deserialize_with)]` on a `Vec<(String, T)>`.
pub(crate) fn named<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Vec<(String, T)>, D::Error> {
    let pairs = Vec::<(Text, T)>::deserialize(deserializer)?;
    Ok(pairs.into_iter().map(|(name, value)| (name.0, value)).collect())
}

struct Text(String);

impl<'de> Deserialize<'de> for Text {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        string(deserializer).map(Text)
    }
}
