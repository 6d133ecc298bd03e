//! How drawn nodes leave the straight lines of their modes, as few shapes with amplitudes of their own.

use nalgebra::{DMatrix, SymmetricEigen};
use rom_runtime::data::PictureCurveData;

use super::manifold::Manifold;
use super::polynomial;

/// Error that nobody sees: root of the mean square over all nodes at the range of the amplitudes, over the largest displacement.
const TOLERANCE: f64 = 5e-4;

/// Shapes and amplitudes of the terms of second and third order in the translations of `nodes`: principal fields of the products of
/// amplitudes at their range. None where shapes are linear.
pub(super) fn picture(manifold: &Manifold, nodes: &[usize]) -> Option<PictureCurveData> {
    let (first, all) = (manifold.monomials.of_order(2).start, manifold.monomials.len());
    let block = |node: usize| {
        let terms = &manifold.at_node(node)[first..];
        DMatrix::from_fn(3, all - first, |k, column| terms[column][k])
    };
    let mut gram = DMatrix::<f64>::zeros(all - first, all - first);
    for &node in nodes {
        let x = block(node);
        gram.gemm_tr(1.0, &x, &x, 1.0);
    }
    let linear = |node: usize| manifold.at_node(node)[..first].iter().map(|x| x.fixed_rows::<3>(0).norm());
    let largest = nodes.iter().flat_map(|&node| linear(node)).fold(0.0, f64::max);
    let eigen = SymmetricEigen::new(gram);
    let mut order: Vec<usize> = (0..all - first).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    // The smallest go as long as their sum is not seen.
    let mut left_out = 0.0;
    while let Some(&last) = order.last() {
        left_out += eigen.eigenvalues[last].max(0.0);
        if left_out > (TOLERANCE * largest).powi(2) * nodes.len() as f64 {
            break;
        }
        order.pop();
    }
    if order.is_empty() {
        return None;
    }
    let vector = |&k: &usize| {
        let v = eigen.eigenvectors.column(k);
        // The sign is the solver's: the largest entry is made positive.
        v * v[v.iamax()].signum()
    };
    let vectors = DMatrix::from_columns(&order.iter().map(vector).collect::<Vec<_>>());
    let mut rows = DMatrix::zeros(order.len(), all);
    rows.columns_mut(first, all - first).copy_from(&vectors.transpose());
    let size = |row: usize| eigen.eigenvalues[order[row]].sqrt();
    let shapes = nodes.iter().flat_map(|&node| {
        let shapes = block(node) * &vectors;
        shapes.transpose().iter().copied().collect::<Vec<f64>>()
    });
    Some(PictureCurveData {
        shapes: shapes.collect(),
        curve: polynomial(manifold, &rows, |row| [0.01 * TOLERANCE * largest / size(row); 2]).0,
    })
}
