//! What is wrong with an input, where, and what to do about it.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// More diagnostics than this are counted, not kept: they would only bury the first ones.
const MOST: usize = 100;

/// A text that was read, and what to call it: a file, or a value given on the command line.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Source {
    pub name: String,
    pub text: String,
}

/// Byte range in the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    pub start: usize,
    pub end: usize,
}

impl From<Range<usize>> for Span {
    fn from(range: Range<usize>) -> Self {
        Self { start: range.start, end: range.end }
    }
}

/// One thing that is wrong: what was found, where, what was expected, and often how to put it right.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    source: Arc<Source>,
    span: Span,
    message: String,
    help: Option<String>,
}

impl Diagnostic {
    pub(crate) fn new(source: &Arc<Source>, span: Span, message: String, help: Option<String>) -> Self {
        // Whatever the span came from, it must be safe to slice with.
        let text = &source.text;
        let boundary = |mut at: usize| {
            at = at.min(text.len());
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let start = boundary(span.start);
        let end = boundary(span.end).max(start);
        Self { source: Arc::clone(source), span: Span { start, end }, message, help }
    }

    /// What was found and what was expected.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What to do about it.
    pub fn help(&self) -> Option<&str> {
        self.help.as_deref()
    }

    /// Byte range in [`Self::source_text`]; on character boundaries.
    pub fn span(&self) -> Range<usize> {
        self.span.start..self.span.end
    }

    /// File name, or the command-line option that holds the text.
    pub fn source_name(&self) -> &str {
        &self.source.name
    }

    /// The whole text the span points into.
    pub fn source_text(&self) -> &str {
        &self.source.text
    }

    /// Line, from 1.
    pub fn line(&self) -> usize {
        self.before().matches('\n').count() + 1
    }

    /// Column in characters, from 1.
    pub fn column(&self) -> usize {
        let before = self.before();
        let line = before.rfind('\n').map_or(before, |at| &before[at + 1..]);
        line.chars().count() + 1
    }

    fn before(&self) -> &str {
        &self.source.text[..self.span.start]
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: {}", self.source_name(), self.line(), self.column(), self.message)?;
        match &self.help {
            Some(help) => write!(f, "\n  help: {help}"),
            None => Ok(()),
        }
    }
}

/// Everything found wrong with an input; never empty.
#[derive(Clone, Debug)]
pub struct InputErrors {
    list: Vec<Diagnostic>,
    omitted: usize,
}

impl InputErrors {
    /// Sorted by place in the text; `list` is not empty.
    pub(crate) fn new(mut list: Vec<Diagnostic>) -> Self {
        list.sort_by_key(|d| d.span.start);
        let omitted = list.len().saturating_sub(MOST);
        list.truncate(MOST);
        Self { list, omitted }
    }

    /// The diagnostics, in the order of the text.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// How many more were found than are listed.
    pub fn omitted(&self) -> usize {
        self.omitted
    }
}

impl<'a> IntoIterator for &'a InputErrors {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl fmt::Display for InputErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, diagnostic) in self.list.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{diagnostic}")?;
        }
        match self.omitted {
            0 => Ok(()),
            n => write!(f, "\nand {n} more"),
        }
    }
}

impl std::error::Error for InputErrors {}

/// The candidate nearest in spelling to `found`, if one is near.
pub(crate) fn nearest<'a>(found: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let found: Vec<char> = found.to_lowercase().chars().take(64).collect();
    // Never so many that no letter is left of what was written.
    let allowed = (found.len() / 3).max(1).min(found.len().saturating_sub(1));
    candidates
        .into_iter()
        .map(|candidate| {
            (distance(&found, &candidate.to_lowercase().chars().take(64).collect::<Vec<_>>()), candidate)
        })
        .filter(|(d, _)| *d <= allowed)
        .min_by_key(|(d, _)| *d)
        .map(|(_, candidate)| candidate)
}

/// "did you mean `x`?" where something is near in spelling, else the list of what there is.
pub(crate) fn suggest<'a>(
    found: &str,
    kind: &str,
    candidates: impl IntoIterator<Item = &'a str> + Clone,
) -> String {
    if let Some(near) = nearest(found, candidates.clone()) {
        return format!("did you mean `{near}`?");
    }
    let list: Vec<String> = candidates.into_iter().map(|c| format!("`{c}`")).collect();
    match list.len() {
        0 => format!("there are no {kind}"),
        n if n > 20 => format!("{kind}: {}, ... ({n} in all)", list[..20].join(", ")),
        _ => format!("{kind}: {}", list.join(", ")),
    }
}

/// Edit distance with neighbouring letters swapped counting as one (optimal string alignment).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut before = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let change = usize::from(a[i - 1] != b[j - 1]);
            row[j] = (last[j] + 1).min(row[j - 1] + 1).min(last[j - 1] + change);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spelling() {
        assert_eq!(nearest("elemnets", ["elements", "element_nodes"]), Some("elements"));
        assert_eq!(nearest("Right arm", ["left arm", "right arm"]), Some("right arm"));
        assert_eq!(nearest("xyz", ["elements"]), None);
        assert_eq!(nearest("X", ["A", "B"]), None);
        assert_eq!(nearest("a", ["A", "B"]), Some("A"));
        assert_eq!(distance(&['a', 'b'], &['b', 'a']), 1);
        assert_eq!(distance(&[], &['b', 'a']), 2);
    }

    #[test]
    fn place_is_counted_in_characters_and_always_safe() {
        let source = Arc::new(Source { name: "f.toml".into(), text: "a\nää = 1".into() });
        let d = Diagnostic::new(&source, Span { start: 6, end: 7 }, "m".into(), Some("h".into()));
        assert_eq!((d.line(), d.column()), (2, 3));
        assert_eq!(d.to_string(), "f.toml:2:3: m\n  help: h");
        let d = Diagnostic::new(&source, Span { start: 3, end: 99 }, "m".into(), None);
        assert_eq!(&d.source_text()[d.span()], "ää = 1");
    }
}
