//! The nodes that are drawn of a reduced model, with the shapes that they move in.

use rom_generator::picture;
use rom_runtime::PictureCurve;
use rom_runtime::data::{ModelData, PictureData};

use crate::results::Results;

/// Nodes, lines and shapes: those of the modes, and what a curved manifold adds.
#[derive(Clone, Debug)]
pub(crate) struct Drawn {
    /// Positions in A at the equilibrium, m - (n x 3).
    pub(crate) positions: Vec<f64>,
    /// Node indices along each line.
    pub(crate) lines: Vec<Vec<u32>>,
    /// Displacement of every node in A per unit amplitude - (n x 3 x width).
    pub(crate) shapes: Vec<f64>,
    modes: usize,
    curve: Option<PictureCurve>,
}

impl Drawn {
    /// The modes alone, of at most so many nodes; none when the model file holds no picture.
    pub(crate) fn modes(data: &ModelData, limit: usize) -> Option<Self> {
        let (picture, modes) = (data.picture.as_ref()?, data.modes.omega.len());
        let n = picture.positions.len() / 3;
        let Some(kept) = thinned(picture, limit) else {
            let PictureData { positions, phi_translation, lines } = picture.clone();
            return Some(Self { positions, lines, shapes: phi_translation, modes, curve: None });
        };
        let rows = |values: &[f64]| picked(values, &kept.nodes, n);
        let (positions, shapes) = (rows(&picture.positions), rows(&picture.phi_translation));
        Some(Self { positions, lines: kept.lines, shapes, modes, curve: None })
    }

    /// As a run of the model moved them. `data` is that of the reduced model itself; simpler methods do not bend its shapes.
    pub(crate) fn of_run(data: &ModelData, results: &Results, limit: usize) -> Option<Self> {
        let mut drawn = Self::modes(data, limit)?;
        let reduced = results.metadata.get("method").is_some_and(|method| method == "rom");
        if let (Some(curve), Some(picture), true) = (&data.picture_curve, &data.picture, reduced) {
            let n = picture.positions.len() / 3;
            let added = match thinned(picture, limit) {
                Some(kept) => picked(&curve.shapes, &kept.nodes, n),
                None => curve.shapes.clone(),
            };
            let rows = drawn.positions.len();
            drawn.shapes = side_by_side(&drawn.shapes, &added, rows);
            drawn.curve = Some(PictureCurve::new(curve, n));
        }
        Some(drawn)
    }

    /// Amplitudes of the shapes and their rates, at those of the modes; none for a run without modes.
    pub(crate) fn amplitudes(&mut self, q: &[f64], q_dot: &[f64]) -> [Vec<f64>; 2] {
        if q.len() != self.modes {
            return [Vec::new(), Vec::new()];
        }
        // Where rates are not recorded.
        let q_dot = if q_dot.len() == q.len() { q_dot.to_vec() } else { vec![0.0; q.len()] };
        let (mut amplitudes, mut rates) = (q.to_vec(), q_dot.clone());
        if let Some(curve) = &mut self.curve {
            let (more, their_rates) = curve.at(q, &q_dot);
            amplitudes.extend(more);
            rates.extend(their_rates);
        }
        [amplitudes, rates]
    }
}

/// Fewer nodes than there are; none where all may stay.
fn thinned(picture: &PictureData, limit: usize) -> Option<picture::Outline> {
    let n = picture.positions.len() / 3;
    if n <= limit {
        return None;
    }
    let lines: Vec<Vec<usize>> =
        picture.lines.iter().map(|line| line.iter().map(|&node| node as usize).collect()).collect();
    let lines: Vec<&[usize]> = lines.iter().map(Vec::as_slice).collect();
    Some(picture::thin(&lines, &vec![false; n], limit))
}

/// The rows of some of `n` nodes.
fn picked(values: &[f64], nodes: &[usize], n: usize) -> Vec<f64> {
    let width = values.len() / n.max(1);
    nodes.iter().flat_map(|&node| values[node * width..(node + 1) * width].to_vec()).collect()
}

/// Matrices of the same number of rows, row by row.
fn side_by_side(a: &[f64], b: &[f64], rows: usize) -> Vec<f64> {
    let widths = [a, b].map(|x| x.len() / rows.max(1));
    let of = |x: &[f64], width: usize, row: usize| x[row * width..(row + 1) * width].to_vec();
    (0..rows).flat_map(|row| [of(a, widths[0], row), of(b, widths[1], row)].concat()).collect()
}
