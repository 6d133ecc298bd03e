//! What the paper says and whether it comes out.

use serde::Serialize;

/// Whether a statement comes out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// It does.
    Agrees,
    /// It does not.
    Disagrees,
    /// It was not found out: a run failed.
    NotComputed,
}

impl Verdict {
    /// For tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::Agrees => "✓ agrees",
            Self::Disagrees => "✗ disagrees",
            Self::NotComputed => "? not computed",
        }
    }
}

/// A statement of the paper, or an exact property of what it computes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statement {
    /// Figure or table it belongs to.
    pub figure: &'static str,
    /// What is stated.
    pub says: String,
    /// What comes out here.
    pub found: String,
    /// Whether that agrees.
    pub verdict: Verdict,
    /// Why it may not, or where the paper contradicts itself; may be empty.
    pub remark: &'static str,
}

impl Statement {
    /// From a check that says what it found and whether this agrees.
    pub fn check(
        figure: &'static str,
        says: impl Into<String>,
        check: impl FnOnce() -> Result<(String, bool), String>,
    ) -> Self {
        let (found, verdict) = match check() {
            Ok((found, true)) => (found, Verdict::Agrees),
            Ok((found, false)) => (found, Verdict::Disagrees),
            Err(reason) => (reason, Verdict::NotComputed),
        };
        Self { figure, says: says.into(), found, verdict, remark: "" }
    }

    /// With a remark.
    pub fn remark(self, remark: &'static str) -> Self {
        Self { remark, ..self }
    }

    /// Cells of a table under the heading.
    pub fn cells(&self) -> Vec<String> {
        let remark = if self.remark.is_empty() { String::new() } else { format!(". {}", self.remark) };
        vec![self.verdict.words().to_owned(), self.says.clone(), format!("{}{remark}", self.found)]
    }
}

/// Column headings of statements.
pub(super) const HEADING: [&str; 3] = ["", "the paper, or an exact property", "here"];

/// `value` within `fraction` of `expected`.
pub(super) fn close(value: f64, expected: f64, fraction: f64) -> bool {
    (value - expected).abs() <= fraction * expected.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_check_that_cannot_be_made_does_not_agree() {
        let made = |result| Statement::check("Fig. 1", "x", || result).verdict;
        assert_eq!(made(Ok(("1".into(), true))), Verdict::Agrees);
        assert_eq!(made(Ok(("2".into(), false))), Verdict::Disagrees);
        assert_eq!(made(Err("stopped".into())), Verdict::NotComputed);
        assert!(close(1.01, 1.0, 0.011) && !close(f64::NAN, 1.0, 1.0));
    }
}
