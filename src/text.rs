//! Numbers and tables for people.

use std::fmt::Write;

/// `value` with `digits` significant digits, in plain notation where that is short and with an exponent otherwise.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    // Rounding may carry into the next power of ten, so the exponent is read after rounding.
    let scientific = format!("{value:.*e}", digits.saturating_sub(1));
    let Some((mantissa, exponent)) = scientific.split_once('e') else { return scientific };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..digits.max(6) as i32).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        trimmed(&format!("{value:.decimals$}")).to_owned()
    } else {
        format!("{}e{exponent}", trimmed(mantissa))
    }
}

/// Without zeros that say nothing.
fn trimmed(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

/// `(x, y, z)` with `digits` significant digits relative to the largest component.
pub fn vector(values: &[f64], digits: usize) -> String {
    let scale = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let floor = scale * 10_f64.powi(-(digits as i32));
    let parts: Vec<String> =
        values.iter().map(|&v| significant(if v.abs() < floor { 0.0 } else { v }, digits)).collect();
    format!("({})", parts.join(", "))
}

/// A large number with its thousands set apart.
pub fn thousands(value: f64) -> String {
    let digits = format!("{:.0}", value.abs());
    let mut out = String::from(if value < 0.0 { "-" } else { "" });
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i) % 3 == 0 {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// Rows as aligned columns, two blanks apart, indented by two; the first row is the heading. Columns in which every
/// cell but the heading starts like a number are set flush right.
pub fn columns(rows: &[Vec<String>]) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |j: usize| rows.iter().filter_map(|r| r.get(j)).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(width).collect();
    let right: Vec<bool> =
        (0..count).map(|j| rows.iter().skip(1).filter_map(|r| r.get(j)).all(|c| looks_numeric(c))).collect();
    let mut out = String::new();
    for row in rows {
        let mut line = String::from("  ");
        for (j, cell) in row.iter().enumerate() {
            let pad = " ".repeat(widths[j] - cell.chars().count());
            let (before, after) = if right[j] { (pad.as_str(), "") } else { ("", pad.as_str()) };
            let _ = write!(line, "{before}{cell}{after}  ");
        }
        out.push_str(line.trim_end());
        out.push('\n');
    }
    out
}

/// Whether a cell starts like a number, or is empty or a dash.
pub fn looks_numeric(cell: &str) -> bool {
    let first = cell.trim_start_matches(['-', '+', '<', '(', '≥']).trim_start().chars().next();
    first.is_none_or(|c| c.is_ascii_digit() || c == '–')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits() {
        for (value, digits, text) in [
            (0.0, 4, "0"),
            (1.0, 4, "1"),
            (0.123_456, 3, "0.123"),
            (-9.9996, 4, "-10"),
            (12_345.6, 3, "12346"),
            (1.5e-7, 3, "1.5e-7"),
            (6.02e23, 3, "6.02e23"),
            (f64::NAN, 3, "NaN"),
        ] {
            assert_eq!(significant(value, digits), text, "{value}");
        }
    }

    #[test]
    fn small_components_do_not_get_digits_they_have_not() {
        assert_eq!(vector(&[1.0, 1e-17, -0.25], 3), "(1, 0, -0.25)");
    }

    #[test]
    fn thousands_are_set_apart() {
        assert_eq!(thousands(1_234_567.4), "1,234,567");
        assert_eq!(thousands(12.0), "12");
        assert_eq!(thousands(-1234.0), "-1,234");
    }

    #[test]
    fn numbers_align_right_and_names_left() {
        let rows = [["point", "peak"], ["P", "1"], ["long", "-10.5"]].map(|r| r.map(String::from).to_vec());
        assert_eq!(columns(&rows), "  point   peak\n  P          1\n  long   -10.5\n");
    }
}
