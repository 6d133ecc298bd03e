//! Runtime.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
extern crate alloc;
pub mod data;
pub mod expression;
pub mod loads;
pub mod time;
