//! What the two binaries are made of: command line, result files, reports. No numerics: those are in
//! `rom-generator` (offline) and `rom-runtime` (time marching).
//!
//! - [`results`]: named time histories of one run and the files they are written to,
//! - [`report`]: self-contained HTML pages made of sections, tables and plots,
//! - [`scene`]: what the 3-D view of a report shows,
//! - [`run`]: settings, summary and report of one run, the same for every method,
//! - [`validate`]: methods side by side and how far they are from each other,
//! - [`select`]: modes and options that meet an error,
//! - [`modes`]: natural modes: tables, pictures, frequencies against a load level,
//! - [`linearise`]: linear models: files, poles,
//! - [`serve`]: a model behind a UDP socket,
//! - [`reproduce`]: the published results, figure by figure,
//! - [`codegen`]: a model as one C file,
//! - [`sweep`]: many cases of one model,
//! - [`vtk`]: runs and modes for ParaView,
//! - [`live`]: a run in work, in the terminal,
//! - [`interrupt`]: what Ctrl-C does,
//! - [`text`]: numbers and tables for people,
//! - [`atomic`]: files that appear complete or not at all.
#![forbid(unsafe_code)]

pub mod atomic;
pub mod base64;
pub mod codegen;
pub mod commands;
pub mod describe;
pub mod export;
pub mod failure;
pub mod files;
pub mod fmu;
pub mod info;
pub mod interrupt;
pub mod linearise;
pub mod live;
pub mod march;
pub mod modes;
pub mod options;
pub mod parallel;
pub mod published;
pub mod report;
pub mod reproduce;
pub mod results;
pub mod run;
pub mod scene;
pub mod select;
pub mod serve;
pub mod sweep;
pub mod terminal;
pub mod text;
pub mod validate;
pub mod vtk;
