//! Numbers inside a page: little-endian f32, base64, each distinct array once.

use std::collections::HashMap;

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
        self.texts.push(base64(&bytes));
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

/// RFC 4648 base64 with padding.
fn base64(bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word =
            chunk.iter().fold(0_u32, |word, &byte| word << 8 | u32::from(byte)) << (8 * (3 - chunk.len()));
        for position in 0..4 {
            let digit = word >> (18 - 6 * position) & 63;
            text.push(if position <= chunk.len() { char::from(ALPHABET[digit as usize]) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The test vectors of RFC 4648, section 10.
    #[test]
    fn base64_of_the_rfc() {
        let vectors = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (plain, coded) in vectors {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn equal_arrays_are_stored_once() {
        let mut arrays = Arrays::default();
        assert_eq!(arrays.add([1.0, 2.0].into_iter()), 0);
        assert_eq!(arrays.add([1.0, 3.0].into_iter()), 1);
        assert_eq!(arrays.add([1.0, 2.0].into_iter()), 0);
        assert_eq!(arrays.into_texts().len(), 2);
    }
}
