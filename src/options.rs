//! Values of command-line options.

use rom_fmu::description::Fmi;
use rom_generator::ResidualSelection;
use rom_generator::build::ModeSelection;
use rom_generator::reference::method::Method;

/// Parses `--modes`: `10` (the lowest ten), `1,2,5` (these; `5,` is mode 5 alone), `60Hz` or `400rad/s` (all below this
/// frequency).
///
/// # Errors
/// What was found and what is accepted.
pub fn modes(text: &str) -> Result<ModeSelection, String> {
    text.parse()
}

/// Parses `--set name=value`: a name and an expression.
///
/// # Errors
/// What was found and what is accepted.
pub fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err(format!("expected name=value, for example sigma=30, found {text:?}")),
    }
}

/// Parses `--residual`: names of points between commas, `all` that carry loads, or `none`.
///
/// # Errors
/// As [`names`].
pub fn residual(text: &str) -> Result<ResidualSelection, String> {
    match text.trim() {
        "all" => Ok(ResidualSelection::Loaded),
        "none" => Ok(ResidualSelection::None),
        list => names(list).map(ResidualSelection::Points),
    }
}

/// Parses a fraction more than zero: `1%` or `0.01`.
///
/// # Errors
/// What was found and what is accepted.
pub fn fraction(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    match number.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value * unit),
        _ => Err(format!("expected a fraction more than zero, 1% or 0.01, found {text:?}")),
    }
}

/// Names between commas.
///
/// # Errors
/// When one of them is empty or listed twice.
pub fn names(text: &str) -> Result<Vec<String>, String> {
    let names: Vec<String> = text.split(',').map(|name| name.trim().to_owned()).collect();
    if names.iter().any(String::is_empty) {
        return Err(format!("expected names between commas, found {text:?}"));
    }
    match (1..names.len()).find(|&i| names[..i].contains(&names[i])) {
        Some(i) => Err(format!("{:?} is listed twice", names[i])),
        None => Ok(names),
    }
}

/// Methods between commas, or `all`.
///
/// # Errors
/// When one of them is unknown or listed twice.
pub fn methods(text: &str) -> Result<Vec<Method>, String> {
    if text.trim() == "all" {
        return Ok(Method::ALL.to_vec());
    }
    names(text)?.iter().map(|name| name.parse()).collect()
}

/// Parses `--fmi`: 2 or 3, with or without `.0`.
///
/// # Errors
/// What was found and what is accepted.
pub fn fmi_version(text: &str) -> Result<Fmi, String> {
    match text.trim() {
        "2" | "2.0" => Ok(Fmi::V2),
        "3" | "3.0" => Ok(Fmi::V3),
        _ => Err(format!("expected 2 or 3, found {text:?}")),
    }
}

/// Parses three components between commas.
///
/// # Errors
/// What was found and what is accepted.
pub fn three(text: &str) -> Result<[f64; 3], String> {
    let parts: Vec<&str> = text.split(',').collect();
    let numbers: Vec<f64> = parts.iter().filter_map(|part| part.trim().parse().ok()).collect();
    match <[f64; 3]>::try_from(numbers) {
        Ok(three) if parts.len() == 3 && three.iter().all(|x| x.is_finite()) => Ok(three),
        _ => Err(format!("expected three finite numbers between commas, such as 0,0,0.5, found {text:?}")),
    }
}

/// The command as it could be typed into a POSIX shell.
pub fn shell_command(program: &str, arguments: impl Iterator<Item = String>) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=:+@%".contains(c);
    let quoted = |argument: String| {
        if !argument.is_empty() && argument.chars().all(plain) {
            argument
        } else {
            format!("'{}'", argument.replace('\'', r"'\''"))
        }
    };
    std::iter::once(program.to_owned()).chain(arguments.map(quoted)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_ways_to_say_which_modes() {
        assert_eq!(modes("10"), Ok(ModeSelection::Count(10)));
        assert_eq!(modes("0"), Ok(ModeSelection::Count(0)));
        assert_eq!(modes(" 5,1, 2"), Ok(ModeSelection::List(vec![1, 2, 5])));
        assert_eq!(modes("5,"), Ok(ModeSelection::List(vec![5])));
        assert_eq!(modes("400 rad/s"), Ok(ModeSelection::Below(400.0)));
        assert_eq!(modes("60Hz"), Ok(ModeSelection::Below(60.0 * std::f64::consts::TAU)));
    }

    #[test]
    fn other_ways_are_refused_in_words() {
        for (text, part) in [
            ("", "a count (10)"),
            ("ten", "found \"ten\""),
            ("-3", "found \"-3\""),
            ("1,1", "mode 1 is listed twice"),
            ("0,1", "no mode 0"),
            ("1,,2", "found \"\""),
            (",", "found \"\""),
            ("-5Hz", "positive frequency"),
            ("NaNHz", "positive frequency"),
            ("infHz", "positive frequency"),
        ] {
            let message = modes(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
    }

    #[test]
    fn assignments() {
        assert_eq!(assignment("sigma = 3*10"), Ok(("sigma".to_owned(), "3*10".to_owned())));
        for text in ["sigma", "=3", "sigma=", "="] {
            assert!(assignment(text).is_err(), "{text}");
        }
    }

    #[test]
    fn name_lists() {
        assert_eq!(names("P, Q"), Ok(vec!["P".to_owned(), "Q".to_owned()]));
        assert!(names("P,,Q").is_err() && names("").is_err());
        assert!(names("P,Q,P").unwrap_err().contains("twice"));
    }

    #[test]
    fn fractions() {
        assert_eq!((fraction("2%"), fraction(" 0.5 "), fraction("50 %")), (Ok(0.02), Ok(0.5), Ok(0.5)));
        for text in ["0", "-1%", "%", "one", "NaN", "inf%"] {
            assert!(fraction(text).unwrap_err().contains("1% or 0.01"), "{text}");
        }
    }

    #[test]
    fn residual_points() {
        assert_eq!(residual("all"), Ok(ResidualSelection::Loaded));
        assert_eq!(residual(" none"), Ok(ResidualSelection::None));
        assert_eq!(residual("P, Q"), Ok(ResidualSelection::Points(vec!["P".to_owned(), "Q".to_owned()])));
        assert!(residual("P,P").unwrap_err().contains("twice") && residual("").is_err());
    }

    #[test]
    fn method_lists() {
        assert_eq!(methods("linear, rom"), Ok(vec![Method::Linear, Method::Rom]));
        assert_eq!(methods("all"), Ok(Method::ALL.to_vec()));
        assert!(methods("rom,rom").unwrap_err().contains("twice"));
        assert!(methods("exact").unwrap_err().contains("mean-axes"));
    }

    #[test]
    fn three_components() {
        assert_eq!(three("1, -2,0.5"), Ok([1.0, -2.0, 0.5]));
        for text in ["", "1,2", "1,2,3,4", "1,x,3", "NaN,0,0", "inf,0,0"] {
            assert!(three(text).unwrap_err().contains("three finite numbers"), "{text}");
        }
    }

    #[test]
    fn commands_can_be_typed_again() {
        let arguments = ["--loads", "my case", "it's", ""].map(String::from);
        assert_eq!(shell_command("romrun", arguments.into_iter()), r"romrun --loads 'my case' 'it'\''s' ''");
    }
}
