//! Loads per length along members: as written, and on the stations that carry them.
//!
//! Within an element a load is carried by three stations at its Gauss points `x_g`. Their shares are the moments of the load with the
//! polynomials `l_g` that are one at a station and zero at the others,
//!
//! ```text
//! P_g = int p l_g ds
//! ```
//!
//! so that the load times any quadratic (shape functions of both kinds of elements) is integrated exactly, whatever the load, as far as
//! the integral of `P_g` itself is: cut at the places where `along` has corners.

use std::borrow::Cow;

use nalgebra::Vector3;
use rom_runtime::loads::{DistributedFrame, DistributedLoad};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::Line;
use super::diagnostic::{Diagnostic, suggest};
use super::expression::Expression;
use super::loads::{Frame, LoadContext, TimeRef};
use super::read::{Node, Read, Reader, place, table};
use super::values::{Number, Text, Triple, limit};
use crate::element::shape::gauss;

/// Parts of an element over which an expression is integrated by three Gauss points each.
const PARTS: usize = 4;

table! {
    /// A force and/or a moment per length along a member, times a function of time.
    DistributedFile {
        /// Name, for people and for the balance of an equilibrium. Several loads may share one.
        name: Option<Text>,
        /// Member that carries it.
        member: Text,
        /// Frame in which its components are constant; a follower load has those of every section.
        frame: Frame,
        /// Force per length, N/m per unit of the time function. Default zero.
        force: Option<Triple>,
        /// Moment per length, N per unit of the time function. Default zero.
        moment: Option<Triple>,
        /// Factor along the member: [[fraction, value], ...], linear between and zero outside, or an expression of `fraction` (0 to 1)
        /// and `s` (arc length from the start, m). Default 1.
        along: Option<Along>,
        /// Fraction of the member's length where it begins. Default 0.
        from: Option<Number>,
        /// Fraction of the member's length where it ends. Default 1.
        to: Option<Number>,
        /// Name of a time function, or one in place. Default: constant 1.
        time: Option<TimeRef>,
    }
}

/// How a load varies along a member.
#[derive(Clone, Debug)]
pub(crate) enum Along {
    /// Values at ascending fractions.
    Table(Vec<[f64; 2]>),
    /// Of `fraction` and `s`, the parameters being known.
    Expression { expression: Expression, parameters: Vec<(String, f64)>, node: super::diagnostic::Span },
}

impl Read for Along {
    fn read(node: &Node, reader: &mut Reader) -> Option<Self> {
        if node.get_ref().is_array() {
            let list = <super::values::List<[Number; 2]>>::read(node, reader)?;
            limit(list.items.len(), node.span().into(), reader)?;
            let pairs = list.items.into_iter().collect::<Option<Vec<_>>>()?;
            return table_of(pairs, node, reader);
        }
        let Some(text) = node.get_ref().as_str() else {
            return reader
                .wrong(node, "[[fraction, value], ...] or an expression of `fraction` and `s` in quotes");
        };
        let at = place(node, &reader.source);
        let expression = match Expression::parse(text) {
            Ok(expression) => expression,
            Err(e) => {
                reader.errors.push(Diagnostic::new(&reader.source, at.part(&e.span), e.message, e.help));
                return None;
            }
        };
        let mut parameters = Vec::new();
        for (name, part) in expression.names().filter(|(name, _)| !VARIABLES.contains(name)) {
            match reader.parameters.get(name) {
                Some(value) => parameters.push((name.to_owned(), value?)),
                None => {
                    let list = reader.parameters.list();
                    let known = VARIABLES.into_iter().chain(list.iter().map(|(n, _)| n.as_str()));
                    let help = suggest(name, "names usable here", known);
                    let message = format!("there is no variable or parameter `{name}`");
                    let span = at.part(&part);
                    return reader.error_help(span, message, help);
                }
            }
        }
        Some(Self::Expression { expression, parameters, node: node.span().into() })
    }
}

/// Variables of an expression along a member.
const VARIABLES: [&str; 2] = ["fraction", "s"];

fn table_of(pairs: Vec<[Number; 2]>, node: &Node, reader: &mut Reader) -> Option<Along> {
    if pairs.len() < 2 {
        return reader.wrong(node, "at least two pairs [fraction, value]");
    }
    for (k, [fraction, _]) in pairs.iter().enumerate() {
        let f = fraction.value;
        if !(0.0..=1.0).contains(&f) {
            return reader
                .error(fraction.span, format!("the fraction is {f}, expected a number from 0 to 1"));
        }
        if k > 0 && f <= pairs[k - 1][0].value {
            let message =
                format!("the fraction {f} follows {}, expected a larger one", pairs[k - 1][0].value);
            return reader.error_help(
                fraction.span,
                message,
                "a step is made by two loads, with `from` and `to`",
            );
        }
    }
    Some(Along::Table(pairs.iter().map(|pair| [pair[0].value, pair[1].value]).collect()))
}

impl JsonSchema for Along {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Along".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let number = generator.subschema_for::<Number>();
        let pair = json_schema!({ "type": "array", "items": number, "minItems": 2, "maxItems": 2 });
        let table = json_schema!({ "type": "array", "items": pair, "minItems": 2 });
        json_schema!({ "anyOf": [table, { "type": "string" }] })
    }
}

impl Along {
    fn value(&self, fraction: f64, length: f64) -> f64 {
        match self {
            Self::Table(list) => {
                let after = list.partition_point(|[f, _]| *f <= fraction);
                match (after.checked_sub(1).map(|k| list[k]), list.get(after)) {
                    (Some([f0, a]), Some([f1, b])) => a + (b - a) * (fraction - f0) / (f1 - f0),
                    (Some([f0, a]), None) if f0 == fraction => a,
                    _ => 0.0,
                }
            }
            Self::Expression { expression, parameters, .. } => expression.value(|name| match name {
                "fraction" => fraction,
                "s" => fraction * length,
                _ => parameters.iter().find(|(n, _)| n == name).map_or(f64::NAN, |(_, value)| *value),
            }),
        }
    }

    /// Fractions at which it has corners or jumps.
    fn corners(&self) -> &[[f64; 2]] {
        match self {
            Self::Table(list) => list,
            Self::Expression { .. } => &[],
        }
    }

    /// Equal parts of an element that it is integrated over.
    fn parts(&self) -> usize {
        match self {
            Self::Table(_) => 1,
            Self::Expression { .. } => PARTS,
        }
    }
}

impl DistributedFile {
    /// On the stations of its member.
    pub(crate) fn resolve(&self, context: &LoadContext<'_>, reader: &mut Reader) -> Option<DistributedLoad> {
        let time = context.time_or_one(self.time.as_ref(), reader);
        if self.force.is_none() && self.moment.is_none() {
            reader.error::<()>(self.span, "a load needs `force`, `moment` or both");
        }
        let range = self.range(reader);
        let lines = context.lines();
        let Some(member) = lines.iter().position(|line| line.name == self.member.value) else {
            if lines.is_empty() {
                return self.not_carried(reader);
            }
            let help = suggest(&self.member.value, "members", lines.iter().map(|line| line.name.as_str()));
            let message = format!("there is no member `{}`", self.member.value.escape_debug());
            return reader.error_help(self.member.span, message, help);
        };
        let (line, range) = (&lines[member], range?);
        if !line.carries {
            return self.not_carried(reader);
        }
        let shares = self.shares(line, range, reader)?;
        let times = |v: &Option<Triple>| match v {
            Some(v) if v.value != Vector3::zeros() => {
                shares.iter().flat_map(|share| <[f64; 3]>::from(v.value * *share)).collect()
            }
            _ => Vec::new(),
        };
        let frame = match self.frame {
            Frame::Dead => DistributedFrame::Dead,
            Frame::Body => DistributedFrame::Body,
            Frame::Follower => DistributedFrame::Follower,
        };
        let (force, moment) = (times(&self.force), times(&self.moment));
        Some(DistributedLoad { member: member as u32, frame, force, moment, time: time? })
    }

    fn not_carried<T>(&self, reader: &mut Reader) -> Option<T> {
        let message = format!(
            "the model does not hold the shapes of member `{}`, which a distributed load needs",
            self.member.value.escape_debug()
        );
        let help = "build it with --all-nodes, or with such a load in its structure file";
        reader.error_help(self.member.span, message, help)
    }

    fn range(&self, reader: &mut Reader) -> Option<[f64; 2]> {
        let range = [self.from.as_ref().map_or(0.0, |f| f.value), self.to.as_ref().map_or(1.0, |f| f.value)];
        for (value, given) in range.iter().zip([&self.from, &self.to]) {
            if let Some(given) = given.as_ref().filter(|_| !(0.0..=1.0).contains(value)) {
                let message = format!("the fraction is {value}, expected a number from 0 to 1");
                return reader.error(given.span, message);
            }
        }
        if range[0] >= range[1] {
            let message = format!("the load begins at {} and ends at {}", range[0], range[1]);
            return reader.error_help(self.span, message, "`from` has to be less than `to`");
        }
        Some(range)
    }

    /// `int along l_g ds` of every station, m.
    fn shares(&self, line: &Line, [from, to]: [f64; 2], reader: &mut Reader) -> Option<Vec<f64>> {
        let one = Along::Table(vec![[0.0, 1.0], [1.0, 1.0]]);
        let along = self.along.as_ref().unwrap_or(&one);
        let mut shares = Vec::with_capacity(3 * line.knots.len());
        for knots in line.knots.windows(2) {
            let (start, width) = (knots[0], knots[1] - knots[0]);
            let parts = along.parts();
            let equal = (1..parts).map(|k| start + width * k as f64 / parts as f64);
            let corners = along.corners().iter().map(|[fraction, _]| *fraction);
            let mut cuts: Vec<f64> = [from, to].into_iter().chain(corners).chain(equal).collect();
            cuts.retain(|cut| *cut > knots[0] && *cut < knots[1]);
            cuts.extend([knots[0], knots[1]]);
            cuts.sort_by(f64::total_cmp);
            let mut sums = [0.0; 3];
            for part in cuts.windows(2).filter(|part| part[0] >= from && part[1] <= to) {
                for (x, weight) in gauss(3) {
                    let fraction = part[0] + (part[1] - part[0]) * x;
                    let value = along.value(fraction, line.length);
                    let ds = weight * (part[1] - part[0]) * line.length;
                    let basis = cardinal((fraction - start) / width);
                    sums.iter_mut().zip(basis).for_each(|(sum, l)| *sum += value * l * ds);
                }
            }
            shares.extend(sums);
        }
        if let Some(bad) = shares.iter().find(|share| !share.is_finite()) {
            let span = match along {
                Along::Expression { node, .. } => *node,
                Along::Table(_) => self.span,
            };
            let message = format!("this expression is {bad} somewhere along member `{}`", line.name);
            return reader.error_help(span, message, "it has to be finite from `from` to `to`");
        }
        Some(shares)
    }
}

/// The quadratics in `x` that are one at a Gauss point of the element and zero at the two others.
fn cardinal(x: f64) -> [f64; 3] {
    let [a, b, c] = [0, 1, 2].map(|k| gauss(3)[k].0);
    [
        (x - b) * (x - c) / ((a - b) * (a - c)),
        (x - a) * (x - c) / ((b - a) * (b - c)),
        (x - a) * (x - b) / ((c - a) * (c - b)),
    ]
}
