//! Tables of internal loads.

use rom_runtime::data::{CutData, SummationData};

use super::tables::Tables;

/// Constants of the sections asked for, a row for each of their six components; nothing where none is.
pub(super) fn tables(tables: &Tables) -> String {
    let cuts: Vec<&CutData> = tables.sections.iter().map(|&index| &tables.data().cuts[index]).collect();
    let mut text = String::new();
    if cuts.is_empty() {
        return text;
    }
    let m = tables.n_modes();
    let summed: Option<Vec<&SummationData>> = cuts.iter().map(|cut| cut.summation.as_ref()).collect();
    text += &format!("\n#define ROM_SUMS_FORCES {}\n", i32::from(summed.is_some()));
    let mut write = |name: &str, width: usize, rows: &mut dyn Iterator<Item = &[f64]>| {
        // C has no empty arrays; what a model does not have is nothing.
        let width = width.max(1);
        let padded = rows.flat_map(|row| {
            let missing = (6 * width).saturating_sub(row.len());
            row.iter().copied().chain(std::iter::repeat_n(0.0, missing))
        });
        let values: Vec<f64> = padded.collect();
        tables.matrix(&mut text, name, &format!("[6 * ROM_SECTIONS][{width}]"), &values, width);
    };
    let Some(summed) = summed else {
        write("SECTION_REST", 1, &mut cuts.iter().map(|cut| &cut.rest[..]));
        write("SECTION_MODAL", m, &mut cuts.iter().map(|cut| &cut.modal[..]));
        write("SECTION_MODAL_RATE", m, &mut cuts.iter().map(|cut| &cut.modal_rate[..]));
        return text;
    };
    write("SECTION_REST", 1, &mut summed.iter().map(|sum| &sum.constant[..]));
    write("SECTION_INERTIA", m + 6, &mut summed.iter().map(|sum| &sum.inertia[..]));
    write("SECTION_DAMPING", m, &mut summed.iter().map(|sum| &sum.damping[..]));
    write("SECTION_C", 6 * (m + 6), &mut summed.iter().map(|sum| &sum.c[..]));
    write("SECTION_K", 21 * m, &mut summed.iter().map(|sum| &sum.k[..]));
    write("SECTION_WEIGHT", 3 * m, &mut summed.iter().map(|sum| &sum.gravity[..]));
    // Of the points and stations in the file, rows of the section next to one another.
    let carriers: Vec<usize> = tables.carriers().collect();
    let influence = |sum: &SummationData| -> Vec<f64> {
        let at = |row: usize, place: usize| sum.places.get(36 * place + 6 * row..36 * place + 6 * row + 6);
        let each = (0..6).flat_map(|row| carriers.iter().map(move |&place| (row, place)));
        each.flat_map(|(row, place)| at(row, place).unwrap_or(&[0.0; 6]).to_vec()).collect()
    };
    let influences: Vec<Vec<f64>> = summed.iter().map(|sum| influence(sum)).collect();
    write("SECTION_PLACE", 6 * carriers.len(), &mut influences.iter().map(|rows| &rows[..]));
    text
}
