//! How far one run is from another (theory section 5).

use crate::results::Channel;

/// `max over time of |X - X_ref|` divided by the `max over time of |X_ref|`, lengths Euclidean. `None` where the reference
/// never exceeds `floor`: then there is nothing to divide by.
///
/// # Panics
/// When the channels differ in rows or width: runs of one load case have the same instants.
pub fn relative_error(com: &Channel, reference: &Channel, floor: f64) -> Option<f64> {
    assert_eq!((com.rows(), com.width()), (reference.rows(), reference.width()), "{}", com.name);
    let scale = largest(reference);
    if scale <= floor {
        return None;
    }
    let distance =
        |i: usize| com.row(i).iter().zip(reference.row(i)).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    // f64::max would drop NaN: no such number may pass as small, and what follows must not replace it.
    let worst = (0..com.rows()).map(distance).fold(0.0, |m: f64, d| if d > m || d.is_nan() { d } else { m });
    Some(worst / scale)
}

/// `max over time of |X|`.
pub fn largest(channel: &Channel) -> f64 {
    let length = |i: usize| channel.row(i).iter().map(|v| v * v).sum::<f64>().sqrt();
    (0..channel.rows()).map(length).fold(0.0, f64::max)
}

/// `|max over time |x_j| - max over time |x_ref,j|| / max over time |x_ref,j|` of one component: how well an extreme is met,
/// whenever it occurs.
pub fn extreme_error(com: &Channel, reference: &Channel, component: usize) -> Option<f64> {
    let extreme = |c: &Channel| c.column(component).fold(0.0_f64, |m, v| m.max(v.abs()));
    let scale = extreme(reference);
    (scale > 0.0).then(|| (extreme(com) - scale).abs() / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(rows: &[[f64; 3]]) -> Channel {
        Channel {
            name: "X".to_owned(),
            components: ["x", "y", "z"].map(String::from).to_vec(),
            unit: "m".to_owned(),
            description: String::new(),
            data: rows.iter().flatten().copied().collect(),
        }
    }

    /// The two maxima are taken at different instants: |difference| is largest at the second (5), |reference| at the
    /// third (10).
    #[test]
    fn maxima_over_time_and_only_then_the_quotient() {
        let reference = channel(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 6.0, 8.0]]);
        let com = channel(&[[0.0, 0.0, 0.0], [1.0, 3.0, 4.0], [0.0, 6.0, 9.0]]);
        assert_eq!(relative_error(&com, &reference, 0.0), Some(0.5));
        assert_eq!(relative_error(&reference, &reference, 0.0), Some(0.0));
        assert_eq!(largest(&com), 117.0_f64.sqrt());
    }

    /// A sine with an amplitude wrong by a and a phase wrong by p is off by sqrt(a^2 + 2 (1 + a)(1 - cos p)) at most.
    #[test]
    fn amplitude_and_phase() {
        let n = 20_000;
        let wave = |amplitude: f64, phase: f64| {
            let x = |i: usize| amplitude * (std::f64::consts::TAU * i as f64 / n as f64 + phase).sin();
            channel(&(0..n).map(|i| [0.0, x(i), 0.0]).collect::<Vec<_>>())
        };
        let (a, p) = (0.1_f64, 0.2_f64);
        let expected = (a * a + 2.0 * (1.0 + a) * (1.0 - p.cos())).sqrt();
        let found = relative_error(&wave(1.0 + a, p), &wave(1.0, 0.0), 0.0).unwrap();
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        let extreme = extreme_error(&wave(1.0 + a, p), &wave(1.0, 0.0), 1).unwrap();
        assert!((extreme - a).abs() < 1e-6, "{extreme}");
    }

    #[test]
    fn nothing_is_divided_by_zero() {
        let zero = channel(&[[0.0; 3]; 4]);
        let small = channel(&[[1e-14, 0.0, 0.0]; 4]);
        let one = channel(&[[1.0, 0.0, 0.0]; 4]);
        assert_eq!(relative_error(&one, &zero, 0.0), None);
        assert_eq!(relative_error(&one, &small, 1e-12), None);
        assert_eq!(relative_error(&zero, &one, 1e-12), Some(1.0));
        assert_eq!(extreme_error(&one, &zero, 0), None);
    }

    #[test]
    fn what_is_no_number_does_not_pass_as_small() {
        let reference = channel(&[[1.0, 0.0, 0.0]; 3]);
        let com = channel(&[[1.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0], [1.0, 0.0, 0.0]]);
        assert!(relative_error(&com, &reference, 0.0).unwrap().is_nan());
    }
}
