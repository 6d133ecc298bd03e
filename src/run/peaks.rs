//! Extremes of each column, taken at every step whether it is written or not.

/// The smallest and the largest value of a quantity, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// Smallest value and its time, s.
    pub min: (f64, f64),
    /// Largest value and its time, s.
    pub max: (f64, f64),
}

impl Extreme {
    /// The one farther from zero: (value, time).
    pub fn farthest(&self) -> (f64, f64) {
        if self.min.0.abs() > self.max.0.abs() { self.min } else { self.max }
    }
}

/// Extremes of the components and of the length of one vector.
#[derive(Clone, Debug, PartialEq)]
pub struct Peaks {
    /// Of each component - (k).
    pub components: Vec<Extreme>,
    /// Largest Euclidean length, and when.
    pub length: (f64, f64),
    /// The vector then - (k).
    pub at_longest: Vec<f64>,
}

impl Peaks {
    /// Nothing seen yet of a vector with `k` components.
    pub fn new(k: usize) -> Self {
        let nothing = Extreme { min: (f64::INFINITY, 0.0), max: (f64::NEG_INFINITY, 0.0) };
        Self { components: vec![nothing; k], length: (-1.0, 0.0), at_longest: vec![0.0; k] }
    }

    /// Takes in the vector at time `t`.
    pub fn see(&mut self, t: f64, vector: &[f64]) {
        for (extreme, &value) in self.components.iter_mut().zip(vector) {
            if value < extreme.min.0 {
                extreme.min = (value, t);
            }
            if value > extreme.max.0 {
                extreme.max = (value, t);
            }
        }
        let length = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
        if length > self.length.0 {
            self.length = (length, t);
            self.at_longest.copy_from_slice(vector);
        }
    }
}
