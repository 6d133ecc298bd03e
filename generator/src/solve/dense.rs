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

/// Sweeps of [`graded_eigen`]; it converges quadratically, in two or three where the matrices are nearly diagonal.
const SWEEPS: usize = 40;

/// `K x = lambda M x` for positive definite `K` and `M` that are nearly diagonal, with entries of any size along the diagonal:
/// ascending `lambda`, `x^t M x = 1`.
///
/// Jacobi's rotations, each as small as the entry it removes is against its own two diagonal entries, keep the digits of the smallest
/// `lambda` beside one 1e16 times as large (Demmel and Veselic 1992); methods that reduce to tridiagonal form first do not.
pub fn graded_eigen(k: &DMatrix<f64>, m: &DMatrix<f64>) -> Result<(Vec<f64>, DMatrix<f64>), DenseError> {
    let size = k.nrows();
    let l = Cholesky::new(m.clone()).ok_or(DenseError::MassNotDefinite)?.l();
    let left = l.solve_lower_triangular(k).ok_or(DenseError::MassNotDefinite)?;
    let a = l.solve_lower_triangular(&left.transpose()).ok_or(DenseError::MassNotDefinite)?;
    let mut a = (&a + a.transpose()) * 0.5;
    if a.iter().any(|x| !x.is_finite()) {
        return Err(DenseError::NoConvergence { size });
    }
    let mut v = DMatrix::identity(size, size);
    let converged = (0..SWEEPS).any(|_| !sweep(&mut a, &mut v));
    if !converged {
        return Err(DenseError::NoConvergence { size });
    }
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|&i, &j| a[(i, i)].total_cmp(&a[(j, j)]));
    let y = DMatrix::from_fn(size, size, |i, j| v[(i, order[j])]);
    let x = l.tr_solve_lower_triangular(&y).ok_or(DenseError::MassNotDefinite)?;
    Ok((order.iter().map(|&i| a[(i, i)]).collect(), x))
}

/// Rotates every pair once, in rows; true where any entry was worth it.
fn sweep(a: &mut DMatrix<f64>, v: &mut DMatrix<f64>) -> bool {
    let mut rotated = false;
    for p in 0..a.nrows() {
        for q in p + 1..a.nrows() {
            let (app, aqq, apq) = (a[(p, p)], a[(q, q)], a[(p, q)]);
            if apq.abs() <= f64::EPSILON * (app.abs() * aqq.abs()).sqrt() || apq == 0.0 {
                continue;
            }
            rotated = true;
            let cot = (aqq - app) / (2.0 * apq);
            let tan = cot.signum() / (cot.abs() + cot.hypot(1.0));
            let cos = 1.0 / tan.hypot(1.0);
            let sin = tan * cos;
            for matrix in [&mut *a, &mut *v] {
                for row in 0..matrix.nrows() {
                    let (x, y) = (matrix[(row, p)], matrix[(row, q)]);
                    matrix[(row, p)] = cos * x - sin * y;
                    matrix[(row, q)] = sin * x + cos * y;
                }
            }
            for column in 0..a.ncols() {
                if column != p && column != q {
                    a[(p, column)] = a[(column, p)];
                    a[(q, column)] = a[(column, q)];
                }
            }
            // Both diagonal entries from the rotation itself: no difference of large numbers.
            a[(p, p)] = app - tan * apq;
            a[(q, q)] = aqq + tan * apq;
            a[(p, q)] = 0.0;
            a[(q, p)] = 0.0;
        }
    }
    rotated
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

    /// Over 24 decades, coupled by 1e-9 of the two diagonal entries: relatively, eigenvalues differ from the diagonal by the square of that.
    #[test]
    fn small_eigenvalues_keep_their_digits_beside_large_ones() {
        let n = 24;
        let exact = |i: usize| 10.0_f64.powi(i as i32 - 4);
        // S = D (I + E) D: eigenvalues of graded matrices are those of the diagonal, relatively, to second order in E.
        let mut random = Random::new(9);
        let mut e = DMatrix::from_fn(n, n, |_, _| 1e-9 * random.next());
        e = &e + e.transpose();
        let k = DMatrix::from_fn(n, n, |i, j| {
            (f64::from(u8::from(i == j)) + if i == j { 0.0 } else { e[(i, j)] })
                * (exact(i) * exact(j)).sqrt()
        });
        let (values, x) = graded_eigen(&k, &DMatrix::identity(n, n)).unwrap();
        for (i, value) in values.iter().enumerate() {
            assert!((value / exact(i) - 1.0).abs() < 1e-14, "{i}: {value}");
        }
        assert!((x.transpose() * &x - DMatrix::identity(n, n)).amax() < 1e-13);
    }

    #[test]
    fn far_from_diagonal_it_agrees_with_the_other_method() {
        let mut random = Random::new(5);
        let n = 30;
        let [a, b] = [0, 0].map(|_| DMatrix::from_fn(n, n, |_, _| random.next()));
        let shift = DMatrix::identity(n, n) * 0.1;
        let (k, m) = (&a * a.transpose() + &shift, &b * b.transpose() + &shift);
        let (expected, _) = generalised_eigen(&k, &m).unwrap();
        let (values, x) = graded_eigen(&k, &m).unwrap();
        for (value, expected) in values.iter().zip(&expected) {
            assert!((value / expected - 1.0).abs() < 1e-9, "{value} {expected}");
        }
        let d = x.transpose() * &k * &x;
        assert!((d - DMatrix::from_diagonal(&values.into())).amax() < 1e-9);
    }
}
