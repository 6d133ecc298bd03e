//! Draft.
use super::method::{Output, Prepared, Run};
use super::scheme::Scheme;
use rom_runtime::loads::LoadCase;

/// Linear method.
pub struct Linear<'a> {
    _prepared: &'a Prepared,
}

impl<'a> Linear<'a> {
    /// Starts at rest.
    pub fn new(
        prepared: &'a Prepared,
        _case: &LoadCase,
        _scheme: Scheme,
        _constant_mass: bool,
    ) -> Result<Self, String> {
        Ok(Self { _prepared: prepared })
    }
}

impl Run for Linear<'_> {
    fn step(&mut self) -> Result<(), String> {
        Err("in work".into())
    }
    fn output(&self) -> Output {
        unimplemented!()
    }
}
