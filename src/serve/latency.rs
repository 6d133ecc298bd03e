//! How long packets take, without keeping each: counts in bins of 1/16 of a power of two.

use std::time::Duration;

/// Bins per power of two.
const FINE: u32 = 16;
const BINS: usize = 64 * FINE as usize;

/// A histogram of durations.
#[derive(Clone, Debug)]
pub struct Latency {
    bins: Vec<u64>,
    count: u64,
    most: u64,
}

impl Default for Latency {
    fn default() -> Self {
        Self { bins: vec![0; BINS], count: 0, most: 0 }
    }
}

impl Latency {
    /// Takes in one. Does not allocate.
    pub fn add(&mut self, duration: Duration) {
        let nanoseconds = u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
        if let Some(bin) = self.bins.get_mut(bin(nanoseconds)) {
            *bin += 1;
        }
        self.count += 1;
        self.most = self.most.max(nanoseconds);
    }

    /// The duration that this share of all stay below, to 1/16; none where there are none. Microseconds.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let wanted = (share * self.count as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        for (index, count) in self.bins.iter().enumerate() {
            seen += count;
            if seen >= wanted && self.count > 0 {
                return Some(upper(index).min(self.most as f64) * 1e-3);
            }
        }
        None
    }

    /// The longest, microseconds.
    pub fn longest(&self) -> Option<f64> {
        (self.count > 0).then_some(self.most as f64 * 1e-3)
    }
}

fn bin(nanoseconds: u64) -> usize {
    let value = nanoseconds.max(1);
    let power = value.ilog2();
    // The four bits after the first.
    let fine = if power >= 4 { value >> (power - 4) } else { value << (4 - power) } & u64::from(FINE - 1);
    (power * FINE) as usize + fine as usize
}

/// Upper end of a bin, ns.
fn upper(index: usize) -> f64 {
    let (power, fine) = (index as u32 / FINE, index as u32 % FINE);
    2f64.powi(power as i32) * (1.0 + f64::from(fine + 1) / f64::from(FINE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_right_to_a_sixteenth() {
        let mut latency = Latency::default();
        assert_eq!((latency.quantile(0.5), latency.longest()), (None, None));
        (1..=10_000u64).for_each(|n| latency.add(Duration::from_nanos(100 * n)));
        for share in [0.01, 0.5, 0.9, 0.999] {
            let (found, exact) = (latency.quantile(share).unwrap(), 1000.0 * share);
            assert!(found >= exact && found <= exact * (1.0 + 1.0 / 16.0) + 0.1, "{share}: {found} {exact}");
        }
        assert_eq!(latency.longest(), Some(1000.0));
        latency.add(Duration::MAX);
        assert!(latency.quantile(1.0).is_some());
    }
}
