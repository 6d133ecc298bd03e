//! Numbers as C literals.

/// Double or single precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scalar {
    pub(super) float: bool,
}

impl Scalar {
    /// The shortest literal that reads back to the same bits; of the nearest single-precision number where that is asked for.
    pub(super) fn literal(self, x: f64) -> String {
        if !self.float {
            return format!("{x:?}");
        }
        // What is too large for single precision is as good as the largest; validation of a model leaves no such numbers.
        let nearest = (x as f32).clamp(f32::MIN, f32::MAX);
        format!("{nearest:?}f")
    }

    /// `{a, b, ..}`, lines of a fair length.
    pub(super) fn list(self, values: &[f64]) -> String {
        let mut text = String::from("{");
        let mut column = 0;
        for (index, value) in values.iter().enumerate() {
            let literal = self.literal(*value);
            if index > 0 {
                text.push(',');
            }
            column += literal.len() + 2;
            if column > 110 {
                text += "\n   ";
                column = literal.len();
            }
            text.push(' ');
            text += &literal;
        }
        text + " }"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_read_back() {
        let double = Scalar { float: false };
        assert_eq!([0.1, 1.0, -2e-300].map(|x| double.literal(x)), ["0.1", "1.0", "-2e-300"]);
        let single = Scalar { float: true };
        assert_eq!([0.1, 1.0, 1e300].map(|x| single.literal(x)), ["0.1f", "1.0f", "3.4028235e38f"]);
        assert_eq!(double.list(&[1.0, 2.5]), "{ 1.0, 2.5 }");
    }
}
