//! Methods side by side: the same load case by each of them, and how far they are from the first (theory section 5).

pub mod norms;
mod report;
mod rows;
mod setup;
mod study;
mod sweep;

pub use report::{overlay, report};
pub use rows::{Row, error_text, rows, table};
pub use setup::Setup;
pub use study::{Finished, Outcome, Output, Setting, Study, Unit, floors, modes_in_words};
pub use sweep::{Sweep, combinations, sweep};
