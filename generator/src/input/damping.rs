//! Structural damping: as written, and as the generator takes it.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use toml::de::DeValue;

use super::read::{Node, Read, Reader, table};
use super::values::{At, Count, Number, limit};
use crate::mesh::{Damping, ModalRatios};

table! {
    /// Structural damping. What is given acts together; a rigid motion is never damped.
    DampingFile {
        /// Critical damping ratio of the elastic modes, from 0 (default) to below 1: one for all; or a list with those of mode 1, 2,
        /// ...; or [[mode, ratio], ...]. Modes that a list does not have get none.
        modal_ratio: Option<RatioFile>,
        /// Rayleigh's damping.
        rayleigh: Option<RayleighFile>,
        /// Retardation time of the strains, s: section forces are stiffness times (strain + time * strain rate). For sections
        /// that have none of their own, nor of their material. Default 0.
        retardation_time: Option<Number>,
    }
}

table! {
    /// Damping alpha M + beta K, given by the two factors, or by the ratios it makes at two frequencies.
    RayleighFile {
        /// Factor alpha on the mass, 1/s; it acts on elastic velocities alone. Default 0.
        mass: Option<Number>,
        /// Factor beta on the stiffness of the sections, s. Default 0.
        stiffness: Option<Number>,
        /// Two circular frequencies, rad/s, instead of the factors.
        omega: Option<[Number; 2]>,
        /// Critical damping ratios at these frequencies.
        ratio: Option<[Number; 2]>,
    }
}

/// Ratios of the modes.
#[derive(Clone, Debug)]
pub(crate) enum RatioFile {
    All(Number),
    Listed(Vec<Number>),
    Numbered(Vec<(Count, Number)>),
}

impl Read for RatioFile {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        let DeValue::Array(list) = node.get_ref() else { return Number::read(node, reader).map(Self::All) };
        limit(list.len(), node.span().into(), reader)?;
        let pairs = list.iter().filter(|item| item.get_ref().is_array()).count();
        if pairs == 0 {
            let read: Vec<Option<Number>> = list.iter().map(|item| Number::read(item, reader)).collect();
            return read.into_iter().collect::<Option<_>>().map(Self::Listed);
        }
        let read: Vec<Option<(Count, Number)>> = list
            .iter()
            .map(|item| match item.get_ref().as_array() {
                Some(pair) if pair.len() == 2 => {
                    let (mode, ratio) = (Count::read(&pair[0], reader), Number::read(&pair[1], reader));
                    Some((mode?, ratio?))
                }
                _ => reader.wrong(item, "[mode, ratio]"),
            })
            .collect();
        read.into_iter().collect::<Option<_>>().map(Self::Numbered)
    }
}

impl JsonSchema for RatioFile {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "ModalRatio".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let (one, mode) = (generator.subschema_for::<Number>(), generator.subschema_for::<Count>());
        let pair = json_schema!({
            "type": "array", "items": { "anyOf": [mode, one] }, "minItems": 2, "maxItems": 2,
        });
        json_schema!({ "anyOf": [one, { "type": "array", "items": one }, { "type": "array", "items": pair }] })
    }
}

/// Damping of the structure, and what its sections add to or take for their retardation time.
pub(crate) struct Resolved {
    pub damping: Damping,
    /// Retardation time of sections without one, s.
    pub retardation: f64,
    /// Rayleigh's factor on the stiffness, s, for every section.
    pub beta: f64,
}

/// Checks the damping; `None` where it is wrong.
pub(crate) fn resolve_damping(file: Option<&DampingFile>, reader: &mut Reader) -> Option<Resolved> {
    let Some(file) = file else {
        return Some(Resolved { damping: Damping::default(), retardation: 0.0, beta: 0.0 });
    };
    let modal = match &file.modal_ratio {
        None => Some(ModalRatios::default()),
        Some(given) => resolve_ratios(given, reader),
    };
    let rayleigh = file.rayleigh.as_ref().map_or(Some([0.0; 2]), |given| resolve_rayleigh(given, reader));
    let retardation = file.retardation_time.as_ref().map_or(Some(0.0), |tau| retardation_time(tau, reader));
    let [alpha, beta] = rayleigh?;
    Some(Resolved { damping: Damping { modal: modal?, alpha }, retardation: retardation?, beta })
}

/// A retardation time, zero or more.
pub(crate) fn retardation_time(tau: &Number, reader: &mut Reader) -> Option<f64> {
    not_negative(tau, "the retardation time", "s", reader)
}

fn not_negative(number: &Number, what: &str, unit: &str, reader: &mut Reader) -> Option<f64> {
    if number.value >= 0.0 {
        return Some(number.value);
    }
    reader.error(number.span, format!("{what} is {} {unit}, expected zero or more", number.value))
}

fn resolve_ratios(given: &RatioFile, reader: &mut Reader) -> Option<ModalRatios> {
    match given {
        RatioFile::All(one) => ratio(one, reader).map(ModalRatios::All),
        RatioFile::Listed(list) => {
            let ratios: Vec<Option<f64>> = list.iter().map(|one| ratio(one, reader)).collect();
            ratios.into_iter().collect::<Option<_>>().map(ModalRatios::Listed)
        }
        RatioFile::Numbered(pairs) => {
            /// Far more modes than a reduced model keeps.
            const MOST: usize = 10_000;
            let mut ratios: Vec<Option<f64>> = Vec::new();
            for (At { value: mode, span }, one) in pairs {
                let value = ratio(one, reader)?;
                if *mode > MOST {
                    return reader.error(*span, format!("mode {mode}, expected at most {MOST}"));
                }
                ratios.resize(ratios.len().max(*mode), None);
                if ratios[mode - 1].replace(value).is_some() {
                    return reader.error(*span, format!("mode {mode} has a ratio already"));
                }
            }
            Some(ModalRatios::Listed(ratios.into_iter().map(|r| r.unwrap_or(0.0)).collect()))
        }
    }
}

fn ratio(ratio: &Number, reader: &mut Reader) -> Option<f64> {
    if (0.0..1.0).contains(&ratio.value) {
        return Some(ratio.value);
    }
    let message = format!("the modal damping ratio is {}, expected 0 to below 1 (critical)", ratio.value);
    reader.error_help(ratio.span, message, "1 percent of critical damping is 0.01")
}

/// `alpha` and `beta`: `zeta = alpha/(2 omega) + beta omega/2`.
fn resolve_rayleigh(file: &RayleighFile, reader: &mut Reader) -> Option<[f64; 2]> {
    let help = "give mass and stiffness, or omega = [a, b] and ratio = [a, b]";
    match (&file.omega, &file.ratio) {
        (None, None) => {
            let factor = |given: &Option<Number>, what, unit, reader: &mut Reader| {
                given.as_ref().map_or(Some(0.0), |given| not_negative(given, what, unit, reader))
            };
            let alpha = factor(&file.mass, "the factor on the mass", "1/s", reader);
            let beta = factor(&file.stiffness, "the factor on the stiffness", "s", reader);
            Some([alpha?, beta?])
        }
        (Some(omega), Some(ratios)) if file.mass.is_none() && file.stiffness.is_none() => {
            let [Some(a), Some(b)] = ratios.each_ref().map(|one| ratio(one, reader)) else { return None };
            let [low, high] = omega.each_ref().map(|w| w.value);
            if !(low > 0.0 && high > low) {
                let message =
                    format!("the frequencies are {low} and {high} rad/s, expected rising positive ones");
                return reader.error(omega[1].span, message);
            }
            let scale = 2.0 / (high * high - low * low);
            let (alpha, beta) = (scale * low * high * (a * high - b * low), scale * (b * high - a * low));
            if alpha < 0.0 || beta < 0.0 {
                let message = format!(
                    "these ratios need factors of {alpha:.3e} 1/s on the mass and {beta:.3e} s on the stiffness, which feed energy in"
                );
                return reader.error_help(
                    file.span,
                    message,
                    "the ratio of the two ratios lies between that of the frequencies and its inverse",
                );
            }
            Some([alpha, beta])
        }
        _ => reader.error_help(file.span, "Rayleigh's damping is given in one of two ways", help),
    }
}
