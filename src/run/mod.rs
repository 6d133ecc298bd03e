//! One run: its settings, what came out, and how that is told. Nothing here knows which method made the results.

mod facts;
mod grid;
mod peaks;
mod report;
mod summary;

pub use facts::{Failure, RunFacts, Timing};
pub use grid::{GridError, TimeGrid};
pub use peaks::{Extreme, Peaks};
pub use report::{report, view};
pub use summary::{PointSummary, Summary};

#[cfg(test)]
mod tests;
