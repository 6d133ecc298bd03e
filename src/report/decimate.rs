//! Fewer points without losing a peak.

/// Indices of the points to keep so that at most about `limit` remain: `0..n` is cut into equal bins, and of each
/// bin the first point and the extremes of every series are kept; so are the first and the last point. `None` when
/// there is nothing to drop. Non-finite values count as extremes of nothing but stay where they are kept.
pub fn decimate(n: usize, series: &[&[f64]], limit: usize) -> Option<Vec<usize>> {
    if n <= limit.max(2) {
        return None;
    }
    let kept_per_bin = 1 + 2 * series.len();
    let bins = (limit / kept_per_bin).max(1);
    let mut kept = Vec::with_capacity(bins * kept_per_bin + 1);
    for bin in 0..bins {
        let range = bin * n / bins..(bin + 1) * n / bins;
        kept.push(range.start);
        for values in series {
            kept.extend(range.clone().min_by(|&a, &b| values[a].total_cmp(&values[b])));
            kept.extend(range.clone().max_by(|&a, &b| values[a].total_cmp(&values[b])));
        }
    }
    kept.push(n - 1);
    kept.sort_unstable();
    kept.dedup();
    Some(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_peak_survives_and_the_limit_holds() {
        let n = 100_003;
        let mut a: Vec<f64> = (0..n).map(|i| (i as f64 * 0.01).sin()).collect();
        let mut b = vec![0.0; n];
        (a[31_337], b[77_777], b[77_779]) = (50.0, -9.0, 8.0);
        let kept = decimate(n, &[&a, &b], 2_000).unwrap();
        assert!(kept.len() <= 2_001, "{}", kept.len());
        for peak in [0, 31_337, 77_777, 77_779, n - 1] {
            assert!(kept.binary_search(&peak).is_ok(), "lost point {peak}");
        }
        assert!(kept.is_sorted_by(|x, y| x < y));
    }

    #[test]
    fn short_series_stay_whole() {
        assert_eq!(decimate(100, &[&[0.0; 100]], 100), None);
    }
}
