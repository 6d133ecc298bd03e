use super::*;
use proptest::prelude::*;

fn value(text: &str) -> f64 {
    let lookup = |name: &str| match name {
        "a" => 2.0,
        "b" => 3.0,
        "sine" => 5.0,
        "minimum" => 7.0,
        "E" => 11.0,
        "e4" => 13.0,
        "pi" => std::f64::consts::PI,
        other => panic!("{other}"),
    };
    Expression::parse(text).unwrap_or_else(|e| panic!("{text}: {e:?}")).value(lookup)
}

#[test]
fn ordinary_notation() {
    for (text, expected) in [
        ("1", 1.0),
        (" 70e9 ", 70e9),
        ("1.5e-3*2", 3e-3),
        ("1_000", 1000.0),
        (".5 + 2.", 2.5),
        // exmex alone makes 4 of the next.
        ("-a^2", -4.0),
        ("(-a)^2", 4.0),
        ("10^(-3)", 1e-3),
        ("+a", 2.0),
        ("a - b - 1", -2.0),
        ("a / b / 2", 1.0 / 3.0),
        ("a / b * 3", 2.0),
        ("a - b + 1", 0.0),
        ("1 - 2 + 3", 2.0),
        ("2 * 3 ^ 2", 18.0),
        ("-a*b", -6.0),
        ("-a + b", 1.0),
        ("-(a + b)*2", -10.0),
        ("a^(b^2)", 512.0),
        ("(a^b)^2", 64.0),
        ("a^b*a^b", 64.0),
        ("sin(pi/2)^2", 1.0),
        ("-sin(pi/2)", -1.0),
        ("sqrt(a*8) + 1", 5.0),
        ("2*sqrt(sqrt(16))", 4.0),
        ("min(a, b)", 2.0),
        ("max(min(a, b), max(1, -1)) * 2", 4.0),
        ("max(a, min(b, 5)) - min(1, max(a, b))", 2.0),
        ("atan2(-1, 0)*2/pi", -1.0),
        ("max(-a^2, -5)", -4.0),
        ("a^max(1, b)", 8.0),
        ("sign(-a) + sign(0) + sign(b)", 0.0),
        // Names that begin like functions or numbers.
        ("sine + minimum", 12.0),
        ("E*e4", 143.0),
        ("((((a))))", 2.0),
        ("a\n\t+ b", 5.0),
    ] {
        let found = value(text);
        assert!(
            (found - expected).abs() <= 1e-12 * expected.abs().max(1.0),
            "{text}: {found} for {expected}"
        );
    }
}

#[test]
fn broken_text_is_refused_where_it_breaks() {
    for (text, at, message) in [
        ("", 0..0, "ends too early"),
        ("  ", 2..2, "ends too early"),
        ("a +", 3..3, "ends too early"),
        ("a b", 2..3, "operator is missing"),
        ("2 pi", 2..3, "operator is missing"),
        ("2(a)", 1..2, "operator is missing"),
        ("a * -b", 4..5, "right after an operator"),
        ("2^-1", 2..3, "right after an operator"),
        ("--a", 1..2, "right after an operator"),
        ("a ** b", 3..4, "`*` where"),
        ("a^b^2", 3..4, "two ways"),
        ("(a", 0..1, "not closed"),
        ("min(a, (b", 7..8, "not closed"),
        ("a)", 1..2, "no opening"),
        ("()", 1..2, "`)` where"),
        ("sin a", 0..3, "parentheses"),
        ("sin", 0..3, "parentheses"),
        ("sin(a, b)", 5..6, "function of two"),
        ("min(a)", 3..6, "two arguments"),
        ("min(a, b, a)", 8..9, "function of two"),
        ("1,5", 1..2, "function of two"),
        ("log(a)", 0..3, "no function"),
        ("sni(a)", 0..3, "no function"),
        ("1.2.3", 0..5, "not a number"),
        (".", 0..1, "not a number"),
        ("1e999", 0..5, "not a number"),
        ("a & b", 2..3, "no meaning"),
        ("ä", 0..2, "no meaning"),
        ("{a}", 0..1, "no meaning"),
        ("a\u{0}", 1..2, "no meaning"),
        ("a = b", 2..3, "no meaning"),
    ] {
        let error = Expression::parse(text).expect_err(text);
        assert_eq!(error.span, at, "{text}");
        assert!(error.message.contains(message), "{text}: {}", error.message);
    }
    assert_eq!(
        Expression::parse("log(2)").unwrap_err().help.unwrap(),
        "ln is the natural, log10 the decimal logarithm"
    );
    assert_eq!(Expression::parse("sni(2)").unwrap_err().help.unwrap(), "did you mean `sin`?");
    assert!(Expression::parse(&"1+".repeat(LONGEST)).unwrap_err().message.contains("characters"));
}

/// An expression as a tree, evaluated directly.
#[derive(Clone, Debug)]
enum Tree {
    Number(f64),
    Negative(Box<Tree>),
    Infix(Box<Tree>, char, Box<Tree>),
    Call(&'static str, Vec<Tree>),
}

impl Tree {
    fn value(&self) -> f64 {
        match self {
            Self::Number(x) => *x,
            Self::Negative(a) => -a.value(),
            Self::Infix(a, '+', b) => a.value() + b.value(),
            Self::Infix(a, '-', b) => a.value() - b.value(),
            Self::Infix(a, '*', b) => a.value() * b.value(),
            Self::Infix(a, '/', b) => a.value() / b.value(),
            Self::Infix(a, _, b) => Binary::Pow.apply(a.value(), b.value()),
            Self::Call("cos", a) => Unary::Cos.apply(a[0].value()),
            Self::Call("abs", a) => a[0].value().abs(),
            Self::Call("min", a) => a[0].value().min(a[1].value()),
            Self::Call(_, a) => Binary::Atan2.apply(a[0].value(), a[1].value()),
        }
    }

    fn level(&self) -> u8 {
        match self {
            Self::Negative(_) => 0,
            Self::Infix(_, '+' | '-', _) => 1,
            Self::Infix(_, '*' | '/', _) => 2,
            Self::Infix(..) => 3,
            _ => 4,
        }
    }

    /// As people write it: parentheses only where precedence asks for them.
    fn text(&self) -> String {
        let at_least = |tree: &Self, level: u8| {
            if tree.level() < level { format!("({})", tree.text()) } else { tree.text() }
        };
        match self {
            Self::Number(x) => format!("{x:?}"),
            Self::Negative(a) => format!("-{}", at_least(a, 2)),
            Self::Infix(a, c @ ('+' | '-'), b) => format!("{} {c} {}", at_least(a, 1), at_least(b, 2)),
            Self::Infix(a, c @ ('*' | '/'), b) => format!("{}{c}{}", at_least(a, 2), at_least(b, 3)),
            Self::Infix(a, c, b) => format!("{}{c}{}", at_least(a, 4), at_least(b, 4)),
            Self::Call(name, arguments) => {
                format!("{name}({})", arguments.iter().map(Self::text).collect::<Vec<_>>().join(", "))
            }
        }
    }
}

fn tree() -> impl Strategy<Value = Tree> {
    let leaf = (0.1..9.0f64).prop_map(Tree::Number);
    leaf.prop_recursive(6, 60, 2, |inner| {
        let pair = (inner.clone(), inner.clone());
        prop_oneof![
            inner.clone().prop_map(|a| Tree::Negative(Box::new(a))),
            (inner.clone(), prop::sample::select(vec!['+', '-', '*', '/', '^']), inner.clone())
                .prop_map(|(a, c, b)| Tree::Infix(Box::new(a), c, Box::new(b))),
            (prop::sample::select(vec!["cos", "abs"]), inner).prop_map(|(f, a)| Tree::Call(f, vec![a])),
            (prop::sample::select(vec!["min", "atan2"]), pair)
                .prop_map(|(f, (a, b))| Tree::Call(f, vec![a, b])),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn parses_as_it_is_written(tree in tree()) {
        let text = tree.text();
        prop_assume!(text.len() <= LONGEST);
        let found = Expression::parse(&text).map_err(|e| TestCaseError::fail(format!("{text}: {e:?}")))?.value(|_| 0.0);
        let expected = tree.value();
        // The same operations in the same order; a minus may come as a difference from zero, which is exact.
        prop_assert!(found == expected || (found.is_nan() && expected.is_nan()), "{} gives {}, not {}", text, found, expected);
    }

    #[test]
    fn any_text_is_parsed_or_refused(text in "[-+*/^(),. a-e0-9{}]{0,30}") {
        if let Err(e) = Expression::parse(&text) {
            prop_assert!(e.span.end <= text.len() && text.is_char_boundary(e.span.start));
            // Refused by our own grammar, never by exmex.
            prop_assert!(!e.message.contains("cannot be parsed"), "{}", e.message);
        }
    }
}
