//! Few shapes for many snapshots.

/// Error that nobody sees, of the largest value.
const TOLERANCE: f64 = 5e-4;

/// Most shapes: an erratic run is drawn less exactly rather than with a page of many megabytes.
const MOST_SHAPES: usize = 64;

/// Shapes and amplitudes whose products are the snapshots.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Basis {
    /// Orthonormal shapes - (width x k).
    pub(super) shapes: Vec<f64>,
    /// Amplitude of every shape in every snapshot - (snapshots x k).
    pub(super) amplitudes: Vec<f64>,
    /// Largest error of an entry.
    pub(super) error: f64,
}

/// The snapshot that is represented worst becomes the next shape, until none of their entries is further off than the tolerance:
/// a pivoted Gram-Schmidt process (greedy reduced basis), whose error is known and not only estimated.
pub(super) fn basis(snapshots: &[Vec<f64>]) -> Basis {
    let width = snapshots.first().map_or(0, Vec::len);
    let mut rest: Vec<Vec<f64>> = snapshots.to_vec();
    let largest = |rest: &[Vec<f64>]| rest.iter().flatten().fold(0.0_f64, |max, x| max.max(x.abs()));
    let tolerance = TOLERANCE * largest(&rest);
    let (mut shapes, mut amplitudes): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
    let mut error = largest(&rest);
    while error > tolerance && shapes.len() < MOST_SHAPES {
        let norms: Vec<f64> = rest.iter().map(|row| dot(row, row)).collect();
        let Some(worst) = (0..rest.len()).max_by(|&a, &b| norms[a].total_cmp(&norms[b])) else { break };
        let norm = norms[worst].sqrt();
        let shape: Vec<f64> = rest[worst].iter().map(|x| x / norm).collect();
        let amplitude: Vec<f64> = rest
            .iter_mut()
            .map(|row| {
                let a = dot(row, &shape);
                row.iter_mut().zip(&shape).for_each(|(x, s)| *x -= a * s);
                a
            })
            .collect();
        shapes.push(shape);
        amplitudes.push(amplitude);
        error = largest(&rest);
    }
    Basis { shapes: transposed(&shapes, width), amplitudes: transposed(&amplitudes, snapshots.len()), error }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Rows of `width` as columns, row by row.
fn transposed(rows: &[Vec<f64>], width: usize) -> Vec<f64> {
    (0..width).flat_map(|i| rows.iter().map(move |row| row[i])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three shapes that vary with time are found again, however many snapshots there are of them.
    #[test]
    fn as_many_shapes_as_there_are() {
        let shape = |k: usize, x: usize| ((k + 1) as f64 * x as f64 * 0.05).sin();
        let snapshots: Vec<Vec<f64>> = (0..200)
            .map(|i| {
                let t = i as f64 * 0.1;
                let q = [t.sin(), 0.3 * (3.1 * t).cos(), 0.05 * (7.0 * t).sin()];
                (0..90).map(|x| (0..3).map(|k| q[k] * shape(k, x)).sum()).collect()
            })
            .collect();
        let found = basis(&snapshots);
        let k = found.amplitudes.len() / snapshots.len();
        assert_eq!(k, 3);
        let largest = snapshots.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (i, row) in snapshots.iter().enumerate() {
            for (x, &value) in row.iter().enumerate() {
                let sum: f64 = (0..k).map(|j| found.shapes[x * k + j] * found.amplitudes[i * k + j]).sum();
                // The amplitudes carry round-off of the orthogonalisation beside the error that is left.
                assert!((sum - value).abs() <= found.error + 1e-12 * largest, "{sum} {value}");
            }
        }
        assert!(found.error <= TOLERANCE * largest);
    }

    #[test]
    fn nothing_that_moves_needs_no_shape() {
        assert_eq!(basis(&[vec![0.0; 6], vec![0.0; 6]]).shapes.len(), 0);
        assert_eq!(basis(&[]).amplitudes.len(), 0);
    }
}
