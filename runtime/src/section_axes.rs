//! Axes of the sections that meet at a named point, for loads that follow them.

use alloc::{format, string::String, string::ToString};

use crate::data::PointData;
use crate::error::ModelError;
use crate::model::{Model, list, unknown};

impl Model {
    /// Axes of a member's section at a named point: rotation from section to node axes, which are those of the drawing at rest, as
    /// [`crate::LoadFrame::Follower`] takes it - rows. No member need be named where all sections at the point have the same axes; a
    /// member that bends there has several, `wing[1]`, `wing[2]` along its path.
    ///
    /// # Errors
    /// [`ModelError::Unknown`] for a point or a member that is not there, which lists those that are; [`ModelError::Ambiguous`] where
    /// the axes differ and the name leaves open which.
    pub fn section_axes(&self, point: usize, member: Option<&str>) -> Result<[[f64; 3]; 3], ModelError> {
        let points = &self.data().points;
        let Some(point) = points.get(point) else {
            return Err(unknown("point number", &point.to_string(), points.iter().map(|point| &point.name)));
        };
        let labels = || (0..point.sections.len()).map(|section| label(point, section));
        let of_name = |&(index, (name, _)): &(usize, &(String, _))| {
            member.is_none_or(|member| name == member || label(point, index) == member)
        };
        let mut found = point.sections.iter().enumerate().filter(of_name).map(|(_, (_, axes))| *axes);
        let Some(first) = found.next() else {
            let name = format!("{} at point {}", member.unwrap_or("to follow"), point.name);
            return Err(ModelError::Unknown { what: "member", name, available: list(labels()) });
        };
        if found.all(|axes| axes == first) {
            return Ok(first);
        }
        Err(ModelError::Ambiguous { point: point.name.clone(), members: list(labels()) })
    }
}

/// The name of a section's member, and which of its sections at the point it is where it bends there.
fn label(point: &PointData, section: usize) -> String {
    let Some((name, _)) = point.sections.get(section) else { return String::new() };
    let of_member = |upto: usize| point.sections.iter().take(upto).filter(|(other, _)| other == name).count();
    match of_member(point.sections.len()) {
        1 => name.clone(),
        _ => format!("{name}[{}]", of_member(section + 1)),
    }
}
