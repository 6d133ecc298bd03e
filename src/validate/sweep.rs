//! Which values a study goes through.

use rom_generator::equilibrium::trim::About;

use crate::text::significant;

/// What is swept.
#[derive(Clone, Debug, PartialEq)]
pub enum Sweep {
    /// The number of elastic modes of the reduced methods.
    Modes(Vec<usize>),
    /// The shape that the linearised methods are about.
    About(Vec<String>),
    /// A parameter of the structure: name and values, numbers or expressions.
    Parameter(String, Vec<String>),
}

/// Most values of one sweep; more is a slip of the keyboard.
const MOST: usize = 10_000;

/// Parses `--sweep`: `name=a,b,c`, or `name=0..20` for whole numbers, ends included, or `name=0..3:7` for so many numbers evenly spaced. The name `modes` is the number of
/// elastic modes, `about` the shape that linearised methods are about, any other a parameter.
///
/// # Errors
/// What was found and what is accepted.
pub fn sweep(text: &str) -> Result<Sweep, String> {
    let expected = || format!("expected name=a,b,c or name=0..20, for example sigma=3,5,10, found {text:?}");
    let (name, values) = text.split_once('=').ok_or_else(expected)?;
    let (name, values) = (name.trim(), values.trim());
    if name.is_empty() || values.is_empty() {
        return Err(expected());
    }
    let values: Vec<String> = match range(values)? {
        Some(values) => values,
        None => values.split(',').map(|v| v.trim().to_owned()).collect(),
    };
    if let Some(i) = (0..values.len()).find(|&i| values[i].is_empty() || values[..i].contains(&values[i])) {
        let what = if values[i].is_empty() { "an empty value" } else { "a value twice" };
        return Err(format!("{what} in {text:?}"));
    }
    if name == "about" {
        values.iter().try_for_each(|v| v.parse::<About>().map(|_| ()))?;
        return Ok(Sweep::About(values));
    }
    if name != "modes" {
        return Ok(Sweep::Parameter(name.to_owned(), values));
    }
    let count = |v: &String| {
        v.parse::<usize>().map_err(|_| format!("expected a number of elastic modes, 0 or more, found {v:?}"))
    };
    values.iter().map(count).collect::<Result<_, _>>().map(Sweep::Modes)
}

/// `a..b` with whole numbers, ends included, or `a..b:n` with n numbers evenly spaced; `None` for anything without two dots.
fn range(text: &str) -> Result<Option<Vec<String>>, String> {
    let Some((first, last)) = text.split_once("..") else { return Ok(None) };
    if let Some((last, count)) = last.split_once(':') {
        return spaced(text, first, last, count).map(Some);
    }
    let number = |part: &str| part.trim().parse::<i64>().ok();
    match (number(first), number(last)) {
        (Some(a), Some(b)) if a <= b && b.abs_diff(a) < MOST as u64 => {
            Ok(Some((a..=b).map(|n| n.to_string()).collect()))
        }
        (Some(a), Some(b)) if a <= b => Err(format!("{text} is more than {MOST} values")),
        _ => Err(format!("expected a range of whole numbers such as 0..20, ends included, found {text:?}")),
    }
}

/// `n` numbers from `a` to `b`, ends included.
fn spaced(text: &str, first: &str, last: &str, count: &str) -> Result<Vec<String>, String> {
    let number = |part: &str| part.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let ends = number(first).zip(number(last)).filter(|(a, b)| a < b);
    let count = count.trim().parse::<usize>().ok().filter(|n| (2..=MOST).contains(n));
    let (Some((a, b)), Some(n)) = (ends, count) else {
        return Err(format!(
            "expected two numbers and how many values from one to the other, such as 0..3:7, found {text:?}"
        ));
    };
    // Rounded so that a tenth is 0.1 and not the sum of its round-off.
    let value = |k: usize| a + (b - a) * k as f64 / (n - 1) as f64;
    Ok((0..n).map(|k| significant(value(k), 12)).collect())
}

/// Every choice of one value per sweep, the last sweep varying fastest: (name, value) in the order of the sweeps.
pub fn combinations(sweeps: &[(String, Vec<String>)]) -> Vec<Vec<(String, String)>> {
    let mut all = vec![Vec::new()];
    for (name, values) in sweeps {
        all = all
            .into_iter()
            .flat_map(|chosen| {
                values.iter().map(move |value| {
                    let mut next: Vec<(String, String)> = chosen.clone();
                    next.push((name.clone(), value.clone()));
                    next
                })
            })
            .collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(values: &[&str]) -> Vec<String> {
        values.iter().map(|v| (*v).to_owned()).collect()
    }

    #[test]
    fn lists_and_ranges() {
        assert_eq!(sweep("sigma=3, 5,10"), Ok(Sweep::Parameter("sigma".into(), texts(&["3", "5", "10"]))));
        assert_eq!(sweep("modes=0..3"), Ok(Sweep::Modes(vec![0, 1, 2, 3])), "ends included");
        assert_eq!(sweep("modes=0,5,10"), Ok(Sweep::Modes(vec![0, 5, 10])));
        assert_eq!(sweep("n = -1..1"), Ok(Sweep::Parameter("n".into(), texts(&["-1", "0", "1"]))));
        let spaced = ["0", "0.5", "1", "1.5", "2", "2.5", "3"];
        assert_eq!(sweep("x=0..3:7"), Ok(Sweep::Parameter("x".into(), texts(&spaced))));
        assert_eq!(sweep("about=drawing"), Ok(Sweep::About(texts(&["drawing"]))));
        assert_eq!(sweep("x=2*3"), Ok(Sweep::Parameter("x".into(), texts(&["2*3"]))));
    }

    #[test]
    fn slips_are_refused_in_words() {
        for (text, part) in [
            ("sigma", "expected name=a,b,c"),
            ("=3", "expected name=a,b,c"),
            ("sigma=", "expected name=a,b,c"),
            ("sigma=1,,2", "an empty value"),
            ("sigma=1,2,1", "a value twice"),
            ("modes=1.5", "found \"1.5\""),
            ("modes=-1..3", "found \"-1\""),
            ("modes=20..0", "a range of whole numbers"),
            ("x=3..0:7", "such as 0..3:7"),
            ("x=0..3:1", "such as 0..3:7"),
            ("x=0..c:4", "such as 0..3:7"),
            ("modes=a..b", "a range of whole numbers"),
            ("about=drawing,sketch", "expected equilibrium or drawing"),
            ("modes=0..99999999", "more than"),
        ] {
            let message = sweep(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
    }

    #[test]
    fn the_product_of_sweeps_in_a_fixed_order() {
        let sweeps = [("a".to_owned(), texts(&["1", "2"])), ("b".to_owned(), texts(&["x", "y"]))];
        let names: Vec<String> = combinations(&sweeps)
            .iter()
            .map(|c| c.iter().map(|(n, v)| format!("{n}{v}")).collect::<Vec<_>>().join(" "))
            .collect();
        assert_eq!(names, ["a1 bx", "a1 by", "a2 bx", "a2 by"]);
        assert_eq!(combinations(&[]), [vec![]]);
    }
}
