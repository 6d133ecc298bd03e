//! Dense symmetric eigenproblems of small size (projected ones, and structures of a few elements).

use faer::{MatRef, Side};
use nalgebra::{Cholesky, Complex, DMatrix};

/// A dense problem could not be solved.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DenseError {
    /// The mass matrix has a non-positive eigenvalue.
    #[error("the mass matrix is not positive definite")]
    MassNotDefinite,
    /// The eigenvalue iteration did not converge.
    #[error("the dense eigenvalue iteration did not converge (size {size})")]
    NoConvergence {
        /// Size of the matrix.
        size: usize,
    },
}

/// Eigenvalues, ascending, and orthonormal eigenvectors of a symmetric matrix (its lower triangle).
pub fn symmetric_eigen(a: &DMatrix<f64>) -> Result<(Vec<f64>, DMatrix<f64>), DenseError> {
    let n = a.nrows();
    let failed = DenseError::NoConvergence { size: n };
    if a.iter().any(|x| !x.is_finite()) {
        return Err(failed);
    }
    // faer's workspace for nothing is a negative size.
    if n == 0 {
        return Ok((Vec::new(), DMatrix::zeros(0, 0)));
    }
    let view = MatRef::from_column_major_slice(a.as_slice(), n, n);
    let eigen = view.self_adjoint_eigen(Side::Lower).map_err(|_| failed)?;
    let mut order: Vec<usize> = (0..n).collect();
    let values: Vec<f64> = (0..n).map(|i| eigen.S()[i]).collect();
    order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
    let u = eigen.U();
    let vectors = DMatrix::from_fn(n, n, |i, j| u[(i, order[j])]);
    Ok((order.iter().map(|&i| values[i]).collect(), vectors))
}

/// Eigenvalues, and eigenvectors as columns.
pub type ComplexEigen = (Vec<Complex<f64>>, DMatrix<Complex<f64>>);

/// Eigenvalues and eigenvectors (columns) of a matrix without symmetry, in no order.
///
/// # Errors
/// When the iteration does not converge, or the matrix is not finite.
pub fn general_eigen(a: &DMatrix<f64>) -> Result<ComplexEigen, DenseError> {
    let n = a.nrows();
    let failed = DenseError::NoConvergence { size: n };
    if a.iter().any(|x| !x.is_finite()) {
        return Err(failed);
    }
    if n == 0 {
        return Ok((Vec::new(), DMatrix::zeros(0, 0)));
    }
    let eigen = MatRef::from_column_major_slice(a.as_slice(), n, n).eigen().map_err(|_| failed)?;
    let (values, u) = (eigen.S(), eigen.U());
    Ok(((0..n).map(|i| values[i]).collect(), DMatrix::from_fn(n, n, |i, j| u[(i, j)])))
}

/// `K x = lambda M x` for symmetric `K` and positive definite `M`: ascending `lambda`, `x^t M x = 1`.
pub fn generalised_eigen(k: &DMatrix<f64>, m: &DMatrix<f64>) -> Result<(Vec<f64>, DMatrix<f64>), DenseError> {
    let l = Cholesky::new(m.clone()).ok_or(DenseError::MassNotDefinite)?.l();
    let left = l.solve_lower_triangular(k).ok_or(DenseError::MassNotDefinite)?;
    let a = l.solve_lower_triangular(&left.transpose()).ok_or(DenseError::MassNotDefinite)?;
    let (values, y) = symmetric_eigen(&((&a + a.transpose()) * 0.5))?;
    let x = l.tr_solve_lower_triangular(&y).ok_or(DenseError::MassNotDefinite)?;
    Ok((values, x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::tests::Random;

    #[test]
    fn generalised_problem_diagonalises_both() {
        let mut random = Random::new(4);
        let n = 40;
        let a = DMatrix::from_fn(n, n, |_, _| random.next());
        let b = DMatrix::from_fn(n, n, |_, _| random.next());
        let k = &a + a.transpose();
        let m = &b * b.transpose() + DMatrix::identity(n, n) * 0.1;
        let (values, x) = generalised_eigen(&k, &m).unwrap();
        assert!((x.transpose() * &m * &x - DMatrix::identity(n, n)).amax() < 1e-11);
        let d = x.transpose() * &k * &x;
        assert!((d - DMatrix::from_diagonal(&values.clone().into())).amax() < 1e-10);
        assert!(values.windows(2).all(|w| w[0] <= w[1]));
    }
}
