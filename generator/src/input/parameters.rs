//! `[parameters]`: named numbers that may refer to each other in any order, overridden by `--set name=expression`.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::diagnostic::{Diagnostic, Source, Span, suggest};
use super::expression::{BINARY, CONSTANTS, Expression, UNARY};
use super::program::VARIABLES;

/// Most parameters accepted.
const MOST: usize = 1000;

/// Largest magnitude of a number: products of the few that are multiplied stay far from overflow.
pub(crate) const LARGEST: f64 = 1e30;

/// Where a value stands: the text it is in and its place there.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub source: Arc<Source>,
    pub span: Span,
    /// Byte offset of the expression's first character, where the text holds it literally.
    pub inside: Option<usize>,
}

impl Place {
    /// A TOML value at `span`; expressions are looked for between its quotes.
    pub(crate) fn new(source: &Arc<Source>, span: Span, expression: &str) -> Self {
        let literal = source.text.get(span.start..span.end).unwrap_or("");
        let quoted =
            literal.len() == expression.len() + 2 && literal.get(1..literal.len() - 1) == Some(expression);
        Self { source: Arc::clone(source), span, inside: quoted.then_some(span.start + 1) }
    }

    /// Place of a part of the expression.
    pub(crate) fn part(&self, range: &std::ops::Range<usize>) -> Span {
        match self.inside {
            Some(offset) => Span { start: offset + range.start, end: offset + range.end },
            None => self.span,
        }
    }
}

/// A number as written: literally or as an expression.
#[derive(Clone, Debug)]
pub(crate) enum Written {
    Literal(f64),
    Expression(String),
}

/// Parameters with their values, in the order of the input.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parameters {
    names: Vec<String>,
    /// `None` where the parameter itself is wrong: reported once, not at every use.
    values: HashMap<String, Option<f64>>,
}

impl Parameters {
    /// Given values, all right.
    pub(crate) fn known(list: &[(String, f64)]) -> Self {
        Self {
            names: list.iter().map(|(name, _)| name.clone()).collect(),
            values: list.iter().map(|(name, value)| (name.clone(), Some(*value))).collect(),
        }
    }

    /// Names and values.
    pub(crate) fn list(&self) -> Vec<(String, f64)> {
        let value = |name: &String| self.values.get(name).copied().flatten().unwrap_or(f64::NAN);
        self.names.iter().map(|name| (name.clone(), value(name))).collect()
    }

    fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.names.iter().map(String::as_str)
    }

    /// Value of a name in expressions; `None` if there is no such name, `Some(None)` if it has no value.
    pub(crate) fn get(&self, name: &str) -> Option<Option<f64>> {
        let constant = CONSTANTS.iter().find(|(n, _)| *n == name).map(|(_, value)| Some(*value));
        constant.or_else(|| self.values.get(name).copied())
    }

    /// Evaluates a number; what is wrong with it is reported.
    pub(crate) fn evaluate(
        &self,
        written: &Written,
        place: &Place,
        errors: &mut Vec<Diagnostic>,
    ) -> Option<f64> {
        match written {
            Written::Literal(value) => check_range(*value, String::new, place, errors),
            Written::Expression(text) => {
                let expression = parse(text, place, errors)?;
                self.evaluate_parsed(&expression, place, errors)
            }
        }
    }

    fn evaluate_parsed(&self, e: &Expression, place: &Place, errors: &mut Vec<Diagnostic>) -> Option<f64> {
        let mut complete = true;
        for (name, at) in e.names() {
            match self.get(name) {
                Some(Some(_)) => {}
                Some(None) => complete = false,
                None => {
                    complete = false;
                    errors.push(self.unknown(name, place, place.part(&at)));
                }
            }
        }
        if !complete {
            return None;
        }
        let lookup = |name: &str| self.get(name).flatten().unwrap_or(f64::NAN);
        check_range(e.value(lookup), || self.used(e), place, errors)
    }

    /// The names an expression uses, with their values, for messages; empty if there are none.
    fn used(&self, e: &Expression) -> String {
        let value = |name: &str| self.get(name).flatten().unwrap_or(f64::NAN);
        let used: BTreeMap<&str, f64> = e.names().map(|(name, _)| (name, value(name))).collect();
        let list: Vec<String> = used.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        if list.is_empty() { String::new() } else { format!("with {}", list.join(", ")) }
    }

    /// Where a number comes from: the parameters in its expression, for messages.
    pub(crate) fn origin(&self, written: &Written) -> Option<String> {
        let Written::Expression(text) = written else { return None };
        let origin = self.used(&Expression::parse(text).ok()?);
        (!origin.is_empty()).then_some(origin)
    }

    pub(crate) fn unknown(&self, name: &str, place: &Place, span: Span) -> Diagnostic {
        let message = format!("there is no parameter `{name}`");
        let help = suggest(name, "parameters", self.names());
        Diagnostic::new(&place.source, span, message, Some(help))
    }

    /// Resolves the parameters of a file, `sets` taking the place of what the file says. `given` are known beforehand
    /// and can be used but not set.
    pub(crate) fn resolve(
        mut file: Vec<(String, Span, Written, Place)>,
        sets: &[(String, String)],
        given: &Self,
        errors: &mut Vec<Diagnostic>,
    ) -> Self {
        if let Some((_, span, _, place)) = file.get(MOST) {
            let message = format!("{} parameters, at most {MOST} are accepted", file.len());
            errors.push(Diagnostic::new(&place.source, *span, message, None));
            file.truncate(MOST);
        }
        for (name, span, _, place) in &file {
            if let Some(why) = reserved(name) {
                errors.push(Diagnostic::new(&place.source, *span, why, None));
            } else if given.values.contains_key(name) {
                let message = format!("the model already has a parameter `{name}`");
                errors.push(Diagnostic::new(
                    &place.source,
                    *span,
                    message,
                    Some("choose another name".into()),
                ));
            }
        }
        apply_sets(&mut file, sets, given, errors);
        let mut resolved = given.clone();
        resolved.names.extend(file.iter().map(|(name, ..)| name.clone()));
        let mut resolver = Resolver { file: &file, resolved, path: Vec::new(), errors };
        for index in 0..file.len() {
            resolver.resolve(index);
        }
        resolver.resolved
    }
}

fn parse(text: &str, place: &Place, errors: &mut Vec<Diagnostic>) -> Option<Expression> {
    Expression::parse(text)
        .map_err(|e| errors.push(Diagnostic::new(&place.source, place.part(&e.span), e.message, e.help)))
        .ok()
}

fn check_range(
    value: f64,
    used: impl Fn() -> String,
    place: &Place,
    errors: &mut Vec<Diagnostic>,
) -> Option<f64> {
    if value.abs() <= LARGEST {
        return Some(value);
    }
    let found = if value.is_finite() { format!("{value:e}") } else { value.to_string() };
    let used = Some(used()).filter(|text| !text.is_empty());
    let message = format!("this number is {found}, expected a finite one of magnitude up to {LARGEST:e}");
    errors.push(Diagnostic::new(&place.source, place.span, message, used));
    None
}

/// Why a parameter cannot have this name.
fn reserved(name: &str) -> Option<String> {
    let mut characters = name.chars();
    let starts = characters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_');
    if !starts || !characters.all(|c| c.is_ascii_alphanumeric() || c == '_') || name.len() > 64 {
        let expected = "expected a letter, then letters, digits and _, at most 64";
        return Some(format!("`{}` cannot name a parameter: {expected}", name.escape_debug()));
    }
    let functions = UNARY.iter().map(|f| f.0).chain(BINARY.iter().map(|f| f.0));
    let mut taken = functions.chain(CONSTANTS.iter().map(|c| c.0)).chain(VARIABLES.iter().map(|v| v.0));
    taken
        .any(|t| t == name)
        .then(|| format!("`{name}` has a meaning of its own in expressions and cannot name a parameter"))
}

fn apply_sets(
    file: &mut [(String, Span, Written, Place)],
    sets: &[(String, String)],
    given: &Parameters,
    errors: &mut Vec<Diagnostic>,
) {
    let mut seen: Vec<&str> = Vec::new();
    for (name, value) in sets {
        let source = Arc::new(Source { name: format!("--set {name}"), text: value.clone() });
        let span = Span { start: 0, end: value.len() };
        let place = Place { source, span, inside: Some(0) };
        let mut refuse = |message: String, help: String| {
            errors.push(Diagnostic::new(&place.source, span, message, Some(help)));
        };
        if seen.contains(&name.as_str()) {
            refuse(format!("`{name}` is set twice"), "give each parameter once".into());
            continue;
        }
        seen.push(name);
        if let Some(entry) = file.iter_mut().find(|entry| entry.0 == *name) {
            entry.2 = Written::Expression(value.clone());
            entry.3 = place;
        } else if given.values.contains_key(name) {
            let help = "build the model again with this --set".to_owned();
            refuse(format!("parameter `{name}` was fixed when the model was built"), help);
        } else {
            let names: Vec<&str> = file.iter().map(|entry| entry.0.as_str()).collect();
            let help = suggest(name, "parameters", names.iter().copied());
            refuse(format!("there is no parameter `{name}` to set"), help);
        }
    }
}

/// Depth-first evaluation, with the path walked so far to name a cycle.
struct Resolver<'a> {
    file: &'a [(String, Span, Written, Place)],
    resolved: Parameters,
    path: Vec<usize>,
    errors: &'a mut Vec<Diagnostic>,
}

impl Resolver<'_> {
    fn resolve(&mut self, index: usize) {
        let (name, _, written, place) = &self.file[index];
        if self.resolved.values.contains_key(name) {
            return;
        }
        if let Some(start) = self.path.iter().position(|&i| i == index) {
            let cycle: Vec<&str> =
                self.path[start..].iter().chain([&index]).map(|&i| self.file[i].0.as_str()).collect();
            let message = format!("parameters refer to each other in a circle: {}", cycle.join(" -> "));
            self.errors.push(Diagnostic::new(&place.source, place.span, message, None));
            for &i in &self.path[start..] {
                self.resolved.values.insert(self.file[i].0.clone(), None);
            }
            return;
        }
        let value = match written {
            Written::Literal(_) => self.resolved.evaluate(written, place, self.errors),
            Written::Expression(text) => parse(text, place, self.errors).and_then(|expression| {
                self.path.push(index);
                for (used, _) in expression.names() {
                    if let Some(next) = self.file.iter().position(|entry| entry.0 == used) {
                        self.resolve(next);
                    }
                }
                self.path.pop();
                // Part of a circle: reported.
                if self.resolved.values.contains_key(name) {
                    return None;
                }
                self.resolved.evaluate_parsed(&expression, place, self.errors)
            }),
        };
        self.resolved.values.entry(name.clone()).or_insert(value);
    }
}
