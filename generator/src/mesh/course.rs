//! A quantity given at fractions of a member's length.

/// Values at ascending fractions from 0 to 1; one alone holds everywhere.
#[derive(Clone, Debug)]
pub(crate) struct Course<T>(Vec<(f64, T)>);

impl<T: Copy> Course<T> {
    /// `stations` are ascending, from 0 to 1 where there are several, and at least one.
    pub(crate) fn new(stations: Vec<(f64, T)>) -> Self {
        Self(stations)
    }

    /// The values on both sides of a fraction, and the weight of the second.
    pub(crate) fn around(&self, fraction: f64) -> (T, T, f64) {
        let (last, stations) = (self.0.len() - 1, &self.0);
        if last == 0 {
            return (stations[0].1, stations[0].1, 0.0);
        }
        let after = stations.partition_point(|(at, _)| *at <= fraction).clamp(1, last);
        let ((x0, a), (x1, b)) = (stations[after - 1], stations[after]);
        (a, b, ((fraction - x0) / (x1 - x0)).clamp(0.0, 1.0))
    }
}

impl Course<f64> {
    /// Linear between the stations.
    pub(crate) fn at(&self, fraction: f64) -> f64 {
        let (a, b, x) = self.around(fraction);
        a + (b - a) * x
    }
}
