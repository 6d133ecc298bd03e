//! What a structure file asks to be measured: inertial sensors.

use nalgebra::Matrix3;

use super::PointTable;
use super::loads::section_frame;
use super::read::{Reader, table, words};
use super::values::{Named, Text};
use crate::mesh::Sensor;

table! {
    /// An inertial sensor at a named point: acceleration, angular velocity and angular acceleration in its own axes.
    SensorFile {
        /// Named point that carries it.
        point: Text,
        /// Its axes; they turn with the node that carries the point. Default `"drawing"`.
        frame: Option<SensorFrame>,
        /// For `frame = "section"`: the member whose section it is. Needed where members with different section axes meet.
        member: Option<Text>,
        /// Whether it feels gravity where there is any: it then reads acceleration less that of free fall. Default true.
        gravity: Option<bool>,
    }
}

words! {
    /// Axes of a sensor.
    SensorFrame {
        /// Along those of the drawing while the structure is as drawn.
        "drawing" => Drawing,
        /// The local axes of a section.
        "section" => Section,
    }
}

/// Checks the sensors against the points that carry them. A point without frames is in error itself.
pub(crate) fn resolve_sensors(
    sensors: &Named<SensorFile>,
    points: &PointTable,
    reader: &mut Reader,
) -> Vec<Sensor> {
    let mut list = Vec::with_capacity(sensors.items.len());
    for (name, sensor) in &sensors.items {
        let Some(sensor) = sensor else { continue };
        let Some(point) = points.find(&sensor.point, reader) else { continue };
        let sections = &points.points[point].1;
        let axes = match sensor.frame.unwrap_or(SensorFrame::Drawing) {
            SensorFrame::Drawing => {
                if let Some(member) = &sensor.member {
                    let message = "`member` says which section a sensor is aligned with, but this one is not";
                    let help = "leave `member` out, or write frame = \"section\"";
                    reader.error_help::<()>(member.span, message, help);
                }
                Some(Matrix3::identity())
            }
            SensorFrame::Section if sections.is_empty() => None,
            SensorFrame::Section => section_frame(&sensor.point, sensor.member.as_ref(), sections, reader),
        };
        if let Some(axes) = axes {
            list.push(Sensor {
                name: name.value.clone(),
                point,
                axes,
                gravity: sensor.gravity.unwrap_or(true),
            });
        }
    }
    list
}
