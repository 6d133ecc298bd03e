//! Stumpff functions `C_k(sigma) = sum_j (-sigma)^j / (k + 2j)!`.
//!
//! With `sigma = |phi|^2` every coefficient of the rotation group (exponential, tangential operator and its inverse)
//! and every derivative of one is a combination of these, without a 0/0 at `phi = 0`:
//!
//! - `C_0 = cos t`, `C_1 = sin t / t`, `C_2 = (1 - cos t)/t^2`, `C_3 = (t - sin t)/t^3`
//! - `C_k = 1/k! - sigma C_{k+2}`
//! - `dC_k/dsigma = (k C_{k+2} - C_{k+1}) / 2`

/// Number of functions evaluated together, `C_0 .. C_8`.
pub const N: usize = 9;

/// Reciprocal factorials 1/0! .. 1/8!.
const INVERSE_FACTORIAL: [f64; N] =
    [1.0, 1.0, 0.5, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0, 1.0 / 40320.0];

/// Above this the closed trigonometric forms lose less than a digit; below it the alternating series does.
const SERIES_LIMIT: f64 = 16.0;

/// `C_0 .. C_8` at `sigma >= 0`.
pub fn stumpff(sigma: f64) -> [f64; N] {
    let mut c = [0.0; N];
    if sigma <= SERIES_LIMIT {
        c[7] = tail(7, sigma);
        c[8] = tail(8, sigma);
        for k in (0..7).rev() {
            c[k] = INVERSE_FACTORIAL[k] - sigma * c[k + 2];
        }
    } else {
        let t = sigma.sqrt();
        c[0] = t.cos();
        c[1] = t.sin() / t;
        for k in 2..N {
            c[k] = (INVERSE_FACTORIAL[k - 2] - c[k - 2]) / sigma;
        }
    }
    c
}

/// Series of `C_k`, nested, with as many terms as `sigma` needs for the last to be below 1e-18 of the first.
fn tail(k: usize, sigma: f64) -> f64 {
    let terms = if sigma < 0.3 {
        7
    } else if sigma < 3.0 {
        10
    } else {
        17
    };
    let mut sum = 1.0;
    for j in (1..=terms).rev() {
        let a = (k + 2 * j) as f64;
        sum = 1.0 - sum * sigma / (a * (a - 1.0));
    }
    sum * INVERSE_FACTORIAL[k]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_trigonometric_forms() {
        for &t in &[1e-3_f64, 0.3, 0.6, 1.0, 1.8, 2.5, 3.1, 3.99, 4.01, 6.0] {
            let c = stumpff(t * t);
            assert!((c[0] - t.cos()).abs() < 2e-14, "cos at {t}");
            assert!((c[1] - t.sin() / t).abs() < 2e-15, "sinc at {t}");
            let half = (0.5 * t).sin();
            assert!((c[2] - 2.0 * half * half / (t * t)).abs() < 1e-15, "C2 at {t}");
        }
    }

    #[test]
    fn recursion_and_derivative_hold_across_the_switch() {
        for &s in &[0.0, 0.29, 0.31, 2.9, 3.1, 15.9, 16.1, 30.0] {
            let c = stumpff(s);
            for k in 0..N - 2 {
                assert!((c[k] - (INVERSE_FACTORIAL[k] - s * c[k + 2])).abs() < 1e-15);
            }
            let h = 1e-4;
            for k in 1..6 {
                let numeric = (stumpff(s + h)[k] - stumpff((s - h).max(0.0))[k]) / (h + s.min(h));
                let exact = 0.5 * (k as f64 * c[k + 2] - c[k + 1]);
                assert!((numeric - exact).abs() < 1e-5, "dC{k} at {s}: {numeric} {exact}");
            }
        }
    }
}
