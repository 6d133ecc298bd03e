//! Checks of the places where section forces are told.

use alloc::{format, string::String};

use super::{Check, array, every};
use crate::data::CutData;

pub(super) fn cut(cut: &CutData, m: usize, places: usize) -> Check {
    let what = |part: &str| -> String { format!("{part} of internal loads \"{}\"", cut.name) };
    let optional = |values: &[f64], n: usize| if values.is_empty() { 0 } else { n };
    every(&what("fraction"), &[cut.fraction], |f| (0.0..=1.0).contains(&f), "from 0 to 1")?;
    array(&what("rest"), &cut.rest, 6)?;
    array(&what("modal"), &cut.modal, 6 * m)?;
    array(&what("modal_rate"), &cut.modal_rate, optional(&cut.modal_rate, 6 * m))?;
    let Some(sum) = &cut.summation else { return Ok(()) };
    array(&what("constant"), &sum.constant, 6)?;
    array(&what("inertia"), &sum.inertia, 6 * (m + 6))?;
    array(&what("damping"), &sum.damping, 6 * m)?;
    array(&what("c"), &sum.c, 36 * (m + 6))?;
    array(&what("k"), &sum.k, 126 * m)?;
    array(&what("gravity"), &sum.gravity, optional(&sum.gravity, 18 * m))?;
    array(&what("places"), &sum.places, 36 * places)
}
