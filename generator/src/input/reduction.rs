//! How the structure is to be reduced where the command does not say otherwise.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use toml::de::DeValue;

use super::PointTable;
use super::read::{Node, Read, Reader, table, words};
use super::values::{At, Count, List, Text};
use crate::build::{Elastic, Inertia, ModeSelection, Reduction};
use crate::mesh::InertiaQuadrature;
use crate::reduce::residual::ResidualSelection;

table! {
    /// How the structure is reduced. Options of the command line come before these.
    ReductionFile {
        /// Elastic modes to keep: the lowest so many (default 10), a list of their numbers, or all up to a frequency (`"60Hz"`).
        modes: Option<ModesFile>,
        /// Points whose static response to loads residual modes complete: a list of names, or `"all"` that carry loads. Default none.
        residual: Option<ResidualFile>,
        /// Mass matrix of the reduced model.
        inertia: Option<InertiaFile>,
        /// Elastic forces of the reduced model.
        elastic: Option<ElasticFile>,
    }
}

words! {
    /// Mass matrix of the reduced model.
    InertiaFile {
        /// That of the equilibrium (default).
        "constant" => Constant,
        /// That of the deformed body.
        "consistent" => Consistent,
    }
}

words! {
    /// Elastic forces of the reduced model.
    ElasticFile {
        /// Linear in the amplitudes of modes of linear shapes (default).
        "linear" => Linear,
        /// Those of large deflections; with consistent inertia.
        "geometric" => Geometric,
    }
}

impl From<InertiaFile> for Inertia {
    fn from(word: InertiaFile) -> Self {
        match word {
            InertiaFile::Constant => Self::Constant,
            InertiaFile::Consistent => Self::Consistent,
        }
    }
}

impl From<ElasticFile> for Elastic {
    fn from(word: ElasticFile) -> Self {
        match word {
            ElasticFile::Linear => Self::Linear,
            ElasticFile::Geometric => Self::Geometric,
        }
    }
}

/// A count, a list of numbers, or a frequency with its unit.
#[derive(Clone, Debug)]
pub(crate) struct ModesFile(ModeSelection);

impl Read for ModesFile {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let span = node.span().into();
        let read = match node.get_ref() {
            DeValue::Array(_) => {
                let list = List::<Count>::read(node, reader)?.items;
                let numbers: Option<Vec<usize>> = list.into_iter().map(|item| Some(item?.value)).collect();
                crate::build::mode_list(numbers?).map(ModeSelection::List)
            }
            DeValue::String(text) => match crate::build::frequency(text) {
                Some(limit) => limit.map(ModeSelection::Below),
                // Any other text is an expression of the parameters.
                None => Ok(ModeSelection::Count(Count::read(node, reader)?.value)),
            },
            // A rigid body.
            DeValue::Integer(number) if number.as_str() == "0" => Ok(ModeSelection::Count(0)),
            _ => Ok(ModeSelection::Count(Count::read(node, reader)?.value)),
        };
        match read {
            Ok(modes) => Some(Self(modes)),
            Err(message) => reader.error(span, message),
        }
    }
}

impl JsonSchema for ModesFile {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Modes".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let count = generator.subschema_for::<Count>();
        json_schema!({ "anyOf": [count, { "const": 0 }, { "type": "array", "items": count }] })
    }
}

/// Names of points, or `"all"`.
#[derive(Clone, Debug)]
pub(crate) enum ResidualFile {
    Word(Text),
    Points(List<Text>),
}

impl Read for ResidualFile {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        match node.get_ref() {
            DeValue::String(_) => Text::read(node, reader).map(Self::Word),
            DeValue::Array(_) => List::read(node, reader).map(Self::Points),
            _ => reader.wrong(node, "a list of points, or \"all\""),
        }
    }
}

impl JsonSchema for ResidualFile {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Residual".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [{ "enum": ["all", "none"] }, { "type": "array", "items": { "type": "string" } }] })
    }
}

/// Checks it against the points and the quadrature; what is wrong has been reported.
pub(crate) fn resolve_reduction(
    file: &ReductionFile,
    points: &PointTable,
    quadrature: Option<InertiaQuadrature>,
    reader: &mut Reader,
) -> Reduction {
    let inertia = file.inertia.map(Inertia::from);
    let elastic = file.elastic.map(Elastic::from);
    let consistent = inertia == Some(Inertia::Consistent);
    if elastic == Some(Elastic::Geometric) && !consistent {
        let message = "elastic = \"geometric\" asks for consistent inertia: on a curved manifold of shapes the mass matrix is not constant";
        reader.error_help::<()>(file.span, message, "add inertia = \"consistent\"");
    }
    if consistent && quadrature == Some(InertiaQuadrature::ReducedCoupling) {
        let message = "inertia = \"consistent\" does not go with inertia_quadrature = \"reduced-coupling\"";
        let help = "consistent inertia is one kinetic energy for all blocks of the mass matrix; leave that quadrature out";
        reader.error_help::<()>(file.span, message, help);
    }
    let modes = file.modes.as_ref().map(|modes| modes.0.clone());
    let residual = file.residual.as_ref().and_then(|given| resolve_residual(given, points, reader));
    Reduction { modes, residual, inertia, elastic }
}

fn resolve_residual(
    given: &ResidualFile,
    points: &PointTable,
    reader: &mut Reader,
) -> Option<ResidualSelection> {
    match given {
        ResidualFile::Word(At { value, span }) => match value.as_str() {
            "all" => Some(ResidualSelection::Loaded),
            "none" => Some(ResidualSelection::None),
            _ => {
                let message = format!("`{}` is not possible here", value.escape_debug());
                reader.error_help(*span, message, "\"all\", \"none\", or a list of points: [\"P\", \"Q\"]")
            }
        },
        ResidualFile::Points(list) => {
            let mut names: Vec<String> = Vec::new();
            for name in list.items.iter().flatten() {
                points.find(name, reader)?;
                if names.contains(&name.value) {
                    let message = format!("point `{}` is listed twice", name.value);
                    return reader.error(name.span, message);
                }
                names.push(name.value.clone());
            }
            Some(ResidualSelection::Points(names))
        }
    }
}
