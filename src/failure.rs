//! Why a command did not do what it was asked, and the exit code that says so.

use std::fmt::Display;
use std::io;
use std::process::ExitCode;

use rom_generator::input::{self, InputErrors};

use miette::{Diagnostic, LabeledSpan, NamedSource, Report, SourceSpan};

/// Exit codes of both programs.
pub mod exit_code {
    /// Anything that is not the input's fault: a disk that is full, for example.
    pub const OTHER: u8 = 1;
    /// The input is wrong: command line, structure file, load file or model file.
    pub const INPUT: u8 = 2;
    /// The computation failed: no convergence, divergence, a check not passed. Results so far are written.
    pub const NUMERICAL: u8 = 3;
    /// Stopped by Ctrl-C: 128 and the number of the signal, as shells have it. Results so far are written.
    pub const INTERRUPTED: u8 = 130;
}

/// A failure with its exit code and what to print.
#[derive(Debug)]
pub struct Failure {
    code: u8,
    reports: Vec<Report>,
}

/// A message with, if known, the place in a text and what to do.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
struct Message {
    message: String,
    help: Option<String>,
    place: Option<(NamedSource<String>, SourceSpan)>,
}

impl Diagnostic for Message {
    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn Display>)
    }

    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        self.place.as_ref().map(|(source, _)| source as &dyn miette::SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let (_, span) = self.place.as_ref()?;
        Some(Box::new(std::iter::once(LabeledSpan::new_with_span(None, *span))))
    }
}

impl Failure {
    fn new(code: u8, message: impl Into<String>, help: Option<String>) -> Self {
        let report = Report::new(Message { message: message.into(), help, place: None });
        Self { code, reports: vec![report] }
    }

    /// The input is wrong; `help` says what to do.
    pub fn input(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::new(exit_code::INPUT, message, Some(help.into()))
    }

    /// The computation failed; `help` says what to do.
    pub fn numerical(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::new(exit_code::NUMERICAL, message, Some(help.into()))
    }

    /// Stopped by Ctrl-C; `help` says what is left of the work.
    pub fn interrupted(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::new(exit_code::INTERRUPTED, message, Some(help.into()))
    }

    /// Something else went wrong.
    pub fn other(message: impl Into<String>) -> Self {
        Self::new(exit_code::OTHER, message, None)
    }

    /// Both, one after the other, under the code of the first.
    pub fn and(mut self, other: Self) -> Self {
        self.reports.extend(other.reports);
        self
    }

    /// The code the process ends with.
    pub fn code(&self) -> u8 {
        self.code
    }

    /// Prints every message on standard error and returns the exit code.
    pub fn report(&self) -> ExitCode {
        for report in &self.reports {
            eprint!("{report:?}");
        }
        ExitCode::from(self.code)
    }
}

impl From<InputErrors> for Failure {
    fn from(errors: InputErrors) -> Self {
        let report = |d: &input::Diagnostic| {
            let range = d.span();
            let span = SourceSpan::new(range.start.into(), range.len());
            // A file that could not be read has no text to point into.
            let (message, place) = if d.source_text().is_empty() {
                (format!("{}: {}", d.source_name(), d.message()), None)
            } else {
                let source = NamedSource::new(d.source_name(), d.source_text().to_owned());
                (d.message().to_owned(), Some((source, span)))
            };
            Report::new(Message { message, help: d.help().map(str::to_owned), place })
        };
        let mut reports: Vec<Report> = errors.iter().map(report).collect();
        if errors.omitted() > 0 {
            let message = format!("and {} more of the kind", errors.omitted());
            reports.push(Report::new(Message { message, help: None, place: None }));
        }
        Self { code: exit_code::INPUT, reports }
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::other(error.to_string())
    }
}
