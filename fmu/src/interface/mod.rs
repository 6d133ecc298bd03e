//! The functions of FMI 2.0 and 3.0. Every one checks its pointers, does its work through an `Instance` (`instance.rs`), and turns errors and
//! panics into a status and a message to the host's logger.
#![allow(unsafe_code)]
#![warn(clippy::undocumented_unsafe_blocks)]
// The standards say what callers promise.
#![allow(clippy::missing_safety_doc, non_snake_case, missing_docs)]

pub mod both;
mod component;
pub mod fmi2;
pub mod fmi3;
mod location;
