//! The identity of an FMU, by which a description and a library know that they belong together.

use std::fmt;

/// Raised whenever variables, their references or their meaning change.
const INTERFACE_VERSION: u8 = 2;

/// FNV-1a of 128 bits over the model file, the blocks of stations among the variables and the version of these: the same have the same token. It tells
/// files apart that were mixed up; it is no protection against forgery.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Token(pub u128);

impl Token {
    /// Of the bytes of a model file and the indices of blocks of stations.
    pub fn of_model(bytes: &[u8], stations: &[usize]) -> Self {
        let model = hash(&[INTERFACE_VERSION], hash(bytes, OFFSET));
        Token(stations.iter().fold(model, |sum, block| hash(&(*block as u64).to_le_bytes(), sum)))
    }
}

/// In the form of a GUID, as FMI 2.0 asks for.
impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hex = format!("{:032x}", self.0);
        let (a, b, c, d, e) = (&hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..]);
        write!(f, "{{{a}-{b}-{c}-{d}-{e}}}")
    }
}

const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;

fn hash(bytes: &[u8], start: u128) -> u128 {
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    bytes.iter().fold(start, |hash, &byte| (hash ^ u128::from(byte)).wrapping_mul(PRIME))
}

/// Of anything, as a checksum.
pub(crate) fn checksum(bytes: &[u8]) -> u64 {
    hash(bytes, OFFSET) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_published_one() {
        // Test vectors of the reference code of Fowler, Noll and Vo.
        assert_eq!(hash(b"", OFFSET), 0x6c62272e07bb014262b821756295c58d);
        assert_eq!(hash(b"a", OFFSET), 0xd228cb696f1a8caf78912b704e4a8964);
    }

    #[test]
    fn another_byte_is_another_token() {
        let (one, other) = (Token::of_model(b"model", &[]), Token::of_model(b"modem", &[]));
        assert_ne!(one, other);
        assert_ne!(one, Token::of_model(b"model", &[0]));
        assert_eq!(one.to_string().len(), 38);
        assert_eq!(one.to_string(), Token::of_model(b"model", &[]).to_string());
    }
}
