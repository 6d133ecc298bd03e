//! Which mode is which from one load level to the next: by the modal assurance criterion
//! `MAC(a, b) = |a^H b|^2 / (a^H a b^H b)`, one where two shapes are the same up to a factor, zero where they are orthogonal.

use nalgebra::Complex;

use super::shapes::ModeSet;

/// Frequencies and shapes at one load level.
#[derive(Clone, Debug, Default)]
pub struct Spectrum {
    /// Circular frequencies, ascending, rad/s - (m).
    pub omega: Vec<f64>,
    /// Growth rates, 1/s: round-off in a stable state - (m).
    pub growth: Vec<f64>,
    /// Shapes over the displacements and the rotations (times a tenth of the size) of the nodes - (m of 6 n).
    pub shapes: Vec<Vec<Complex<f64>>>,
}

impl From<&ModeSet> for Spectrum {
    fn from(set: &ModeSet) -> Self {
        let size = set.at.positions.iter().map(|r| (r - set.centre_of_mass).norm()).fold(0.0, f64::max);
        let shape = |shape: &super::Shape| {
            let nodes = shape.translations.iter().zip(&shape.rotations);
            nodes
                .flat_map(|(t, r)| [t.x, t.y, t.z, r.x, r.y, r.z].map(|x| x))
                .enumerate()
                .map(|(k, x)| Complex::new(if k % 6 < 3 { x } else { 0.1 * size * x }, 0.0))
                .collect()
        };
        Self {
            omega: set.modes.iter().map(|mode| mode.omega).collect(),
            growth: vec![0.0; set.modes.len()],
            shapes: set.modes.iter().map(shape).collect(),
        }
    }
}

/// Modal assurance criterion of two shapes; zero where they are not of one mesh.
pub fn mac(a: &[Complex<f64>], b: &[Complex<f64>]) -> f64 {
    if a.len() != b.len() {
        return 0.0;
    }
    let product: Complex<f64> = a.iter().zip(b).map(|(a, b)| a.conj() * b).sum();
    let square = |v: &[Complex<f64>]| v.iter().map(Complex::norm_sqr).sum::<f64>();
    let scale = square(a) * square(b);
    if scale > 0.0 { product.norm_sqr() / scale } else { 0.0 }
}

/// For each spectrum, which of its modes carries on each mode of the first one, and how well (MAC): (index, criterion); none where a mode
/// has left the spectrum. The best pairs are taken first. Spectra of different meshes are paired in their order, with a criterion of zero.
pub fn track(spectra: &[Spectrum]) -> Vec<Vec<Option<(usize, f64)>>> {
    let Some(first) = spectra.first() else { return Vec::new() };
    let mut last: Vec<Vec<Complex<f64>>> = first.shapes.clone();
    let mut out = vec![(0..first.omega.len()).map(|k| Some((k, 1.0))).collect::<Vec<_>>()];
    for spectrum in &spectra[1..] {
        let pairs = pair(&last, spectrum);
        for (last, pair) in last.iter_mut().zip(&pairs) {
            if let Some((k, _)) = pair {
                last.clone_from(&spectrum.shapes[*k]);
            }
        }
        out.push(pairs);
    }
    out
}

fn pair(last: &[Vec<Complex<f64>>], spectrum: &Spectrum) -> Vec<Option<(usize, f64)>> {
    let same_mesh = last.iter().zip(&spectrum.shapes).all(|(a, b)| a.len() == b.len());
    if !same_mesh {
        return (0..last.len()).map(|k| (k < spectrum.omega.len()).then_some((k, 0.0))).collect();
    }
    let mut candidates = Vec::new();
    for (i, a) in last.iter().enumerate() {
        candidates.extend(spectrum.shapes.iter().enumerate().map(|(k, b)| (mac(a, b), i, k)));
    }
    // Best first; of equals the lower modes first.
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut out = vec![None; last.len()];
    let mut taken = vec![false; spectrum.shapes.len()];
    for (criterion, i, k) in candidates {
        if out[i].is_none() && !taken[k] && criterion > 0.05 {
            out[i] = Some((k, criterion));
            taken[k] = true;
        }
    }
    out
}
