//! Pages in the style of the reports.

use rom_generator::mesh::Mesh;
use rom_generator::vibration::{ModeSet, Support};

use super::{Frequencies, mode_rows, picture, table};
use crate::report::{Block, Curves, Document, Highlight, Look, Plot, Section, Table};
use crate::text::{significant, vector};

/// What the pages say about where they come from.
fn origin(command: &str) -> Section {
    Section { title: "Command".to_owned(), blocks: vec![Block::Verbatim(command.to_owned())] }
}

fn highlight(label: &str, value: String, note: &str) -> Highlight {
    Highlight { label: label.to_owned(), value, note: note.to_owned() }
}

/// Table and pictures of the modes.
pub fn mode_page(mesh: &Mesh, set: &ModeSet, about: &str, command: &str, tool: &str) -> Document {
    let rows = mode_rows(set);
    let picture = |k: usize| {
        let row = &rows[k];
        let caption = format!(
            "Mode {}: {} rad/s, {} Hz{}{}",
            row.number,
            significant(row.omega, 5),
            significant(row.frequency_hz, 4),
            if row.symmetry.is_empty() { "" } else { ", " },
            row.symmetry
        );
        Block::Picture { svg: picture(mesh, set, k), caption }
    };
    let mut table = table(set);
    let columns = if table.is_empty() { Vec::new() } else { table.remove(0) };
    let support = match set.support {
        Support::Free => "free-free",
        Support::Clamped => "clamped at the reference node",
    };
    Document {
        title: format!("{}: modes", mesh.name),
        subtitle: format!("{support}, {about}"),
        highlights: vec![
            highlight("mass", format!("{} kg", significant(set.mass, 6)), ""),
            highlight("centre of mass in A", format!("{} m", vector(set.centre_of_mass.as_slice(), 4)), ""),
            highlight(
                "lowest frequency",
                rows.first().map_or_else(|| "–".to_owned(), |row| format!("{} rad/s", significant(row.omega, 5))),
                "",
            ),
        ],
        sections: vec![
            Section {
                title: "Modes".to_owned(),
                blocks: vec![Block::Table(Table { caption: String::new(), columns, rows: table })],
            },
            Section {
                title: "Shapes".to_owned(),
                blocks: std::iter::once(Block::Note(
                    "Deformed over undeformed, at an amplitude that can be seen. The bars lie along local y of the sections."
                        .to_owned(),
                ))
                .chain((0..rows.len()).map(picture))
                .collect(),
            },
            origin(command),
        ],
        footer: tool.to_owned(),
    }
}

/// Frequencies against a load level.
pub fn frequency_plot(found: &Frequencies) -> Plot {
    Plot {
        title: format!("Frequencies against {}", found.label),
        x_label: found.label.clone(),
        y_label: "omega (rad/s)".to_owned(),
        curves: Curves::Over { x: found.levels.clone(), series: found.curves() },
        look: Look { markers: true, ..Look::default() },
        ..Plot::default()
    }
}

/// Table and plot of frequencies against a load level.
pub fn frequency_page(name: &str, found: &Frequencies, about: &str, command: &str, tool: &str) -> Document {
    let mut table = found.table();
    let columns = if table.is_empty() { Vec::new() } else { table.remove(0) };
    let mut blocks: Vec<Block> = found.remarks().into_iter().map(Block::Warning).collect();
    blocks.push(Block::Plot(frequency_plot(found)));
    blocks.push(Block::Table(Table { caption: "omega, rad/s".to_owned(), columns, rows: table }));
    Document {
        title: format!("{name}: frequencies against {}", found.label),
        subtitle: about.to_owned(),
        highlights: Vec::new(),
        sections: vec![Section { title: "Frequencies".to_owned(), blocks }, origin(command)],
        footer: tool.to_owned(),
    }
}
