//! One unstructured grid of lines, as VTK's XML format has it.

use std::io::{self, Write};
use std::path::Path;

use crate::{atomic, base64};

/// VTK's number for a cell that is a line between two points. Lines through many points are one cell there too, but not every
/// reader takes them.
const LINE: u8 = 3;

/// A vector on every node, or on every piece of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name, by which the viewer lists it.
    pub name: String,
    /// Components, node after node, or piece after piece along one line after the other - (n x 3). Not a number where there is none.
    pub values: Vec<f64>,
}

/// Points, lines through them, and fields on the points. Cells are the pieces of the lines, numbered by line from 1 (`member`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// Positions, m - (n x 3).
    pub points: Vec<f64>,
    /// Indices of the points along each line.
    pub lines: Vec<Vec<u32>>,
    /// Fields on the points.
    pub fields: Vec<Field>,
    /// Fields on the pieces of the lines.
    pub cell_fields: Vec<Field>,
}

impl Grid {
    /// Writes a `.vtu` file.
    ///
    /// # Errors
    /// Those of the file system, naming the file.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        atomic::write(path, |sink| self.write_xml(sink))
    }

    fn write_xml(&self, out: &mut dyn Write) -> io::Result<()> {
        let cells: Vec<([u32; 2], usize)> = self
            .lines
            .iter()
            .enumerate()
            .flat_map(|(member, line)| line.windows(2).map(move |pair| ([pair[0], pair[1]], member)))
            .collect();
        let connectivity = cells.iter().flat_map(|(ends, _)| ends).flat_map(|&i| i64::from(i).to_le_bytes());
        let offsets = (1..=cells.len() as i64).flat_map(|k| (2 * k).to_le_bytes());
        let members = cells.iter().flat_map(|&(_, member)| (member as i64 + 1).to_le_bytes());
        writeln!(
            out,
            r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<UnstructuredGrid>
<Piece NumberOfPoints="{}" NumberOfCells="{}">"#,
            self.points.len() / 3,
            cells.len()
        )?;
        writeln!(out, "<Points>")?;
        array(out, "Float64", r#"Name="Points" NumberOfComponents="3""#, floats(&self.points))?;
        writeln!(out, "</Points>\n<Cells>")?;
        array(out, "Int64", r#"Name="connectivity""#, connectivity.collect())?;
        array(out, "Int64", r#"Name="offsets""#, offsets.collect())?;
        array(out, "UInt8", r#"Name="types""#, vec![LINE; cells.len()])?;
        writeln!(out, "</Cells>\n<CellData>")?;
        array(out, "Int64", r#"Name="member""#, members.collect())?;
        let vectors = |out: &mut dyn Write, fields: &[Field]| {
            fields.iter().try_for_each(|field| {
                let name = format!(r#"Name="{}" NumberOfComponents="3""#, escape(&field.name));
                array(out, "Float64", &name, floats(&field.values))
            })
        };
        vectors(out, &self.cell_fields)?;
        writeln!(out, "</CellData>\n<PointData>")?;
        vectors(out, &self.fields)?;
        writeln!(out, "</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
    }
}

fn floats(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// One array: the number of its bytes, then the bytes, each in base64.
fn array(out: &mut dyn Write, kind: &str, attributes: &str, bytes: Vec<u8>) -> io::Result<()> {
    let length = base64::encode(&(bytes.len() as u64).to_le_bytes());
    let data = base64::encode(&bytes);
    writeln!(out, r#"<DataArray type="{kind}" {attributes} format="binary">{length}{data}</DataArray>"#)
}

/// Text as it may stand in a quoted attribute.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
