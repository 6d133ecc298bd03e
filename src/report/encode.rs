//! Numbers inside a page: little-endian f32, base64, each distinct array once.

use std::collections::HashMap;

use crate::base64;

/// Arrays of a page, by index.
#[derive(Default)]
pub(super) struct Arrays {
    texts: Vec<String>,
    known: HashMap<Vec<u8>, usize>,
}

impl Arrays {
    /// Stores the values and returns their index. Values beyond the range of f32 become gaps in the curve.
    pub(super) fn add(&mut self, values: impl Iterator<Item = f64>) -> usize {
        let bytes: Vec<u8> = values.flat_map(|v| finite(v).to_le_bytes()).collect();
        if let Some(&index) = self.known.get(&bytes) {
            return index;
        }
        let index = self.texts.len();
        self.texts.push(base64::encode(&bytes));
        self.known.insert(bytes, index);
        index
    }

    /// The encoded arrays, in order of their index.
    pub(super) fn into_texts(self) -> Vec<String> {
        self.texts
    }
}

fn finite(value: f64) -> f32 {
    let value = value as f32;
    if value.is_finite() { value } else { f32::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_arrays_are_stored_once() {
        let mut arrays = Arrays::default();
        assert_eq!(arrays.add([1.0, 2.0].into_iter()), 0);
        assert_eq!(arrays.add([1.0, 3.0].into_iter()), 1);
        assert_eq!(arrays.add([1.0, 2.0].into_iter()), 0);
        assert_eq!(arrays.into_texts().len(), 2);
    }
}
