//! Every refusal of the structure file: where it points, what it says, what it suggests.

use rom_generator::equilibrium::trim::{Component, WhenUnbalanced};
use rom_generator::input::{InputErrors, Structure};
use rom_generator::{ModeSelection, ResidualSelection};

/// A sound structure with one of everything.
const BASE: &str = r#"
[structure]
name = "frame"
reference = "A"

[parameters]
n = 12
width = "2 * height"
height = 0.05

[materials.alloy]
E = 70e9
nu = 0.3
rho = 2700

[sections.bar]
shape = "rectangle"
material = "alloy"
width_y = "width"
width_z = "height"

[sections.pipe]
shape = "tube"
material = "alloy"
outer_diameter = 0.1
wall_thickness = 0.01

[sections.blade]
shape = "matrix"
stiffness = [
  [10, 0, 0, 0, 0, 0],
  [0, 20, 0, 1, 0, 0],
  [0, 0, 20, 0, 0, 0],
  [0, 1, 0, 30, 5, 0],
  [0, 0, 0, 5, 40, 0],
  [0, 0, 0, 0, 0, 50],
]
mass = [
  [2, 0, 0, 0, 0, 0.1],
  [0, 2, 0, 0, 0, 0],
  [0, 0, 2, -0.1, 0, 0],
  [0, 0, -0.1, 3, 0, 0],
  [0, 0, 0, 0, 1, 0],
  [0.1, 0, 0, 0, 0, 2],
]

[points]
A = [0, 0, 0]
B = [10, 0, 0]
C = [10, 0, 5]
D = [10, 5, 5]
M = [5, 0, 0]
N = { member = "mast", fraction = 0.5 }
L = { linked_to = "B", offset = [0, 0, 1] }

[[members]]
name = "boom"
path = ["A", "B"]
section = "bar"
elements = "n"
local_y = [0, 1, 0]

[[members]]
name = "mast"
path = ["B", "C"]
section = "pipe"
elements = 4
local_y = [0, 1, 0]

[[members]]
name = "hoop"
arc = { from = "C", through = [10, 2.5, 7.5], to = "D" }
section = "blade"
elements = 6
element_nodes = 3
local_y = [1, 0, 0]
twist = [0, 0.2]

[[masses]]
point = "L"
mass = 5
inertia = [1, 1, 1.5]

[times.push]
shape = "ramp"
rate = 3
end = 2

[load_cases.one]
t_end = 10
dt = 0.01
loads = [
  { point = "B", frame = "follower", member = "boom", force = [0, 0, 1], time = "push" },
  { point = "L", frame = "dead", moment = [0, 0, 1], time = { expression = "n * t - vx" } },
  { point = "M", frame = "body", force = [0, 0, 1], time = { shape = "table", t = [0, 1, 2], value = [0, 1, 0] } },
]

[equilibrium]
attitude = { pitch = 0.1 }
loads = [
  { name = "lift", point="B", frame="body", force=[0, 0, 5] },
  { name = "trim", point="C", frame="dead", moment=[0, 7, 0] },
]
balance = [
  { load = "lift", component = "force-z" },
  { load = "trim", component = "moment-y", axes = "inertial" },
]
load_steps = 3
tolerance = 1e-8
unbalanced = "warn"

[damping]
modal_ratio = 0.02

[options]
inertia_quadrature = "reduced-coupling"
"#;

fn read(text: &str) -> Result<Structure, InputErrors> {
    Structure::from_toml_str(text, "frame.toml", &[])
}

fn edited(edits: &[(&str, &str)]) -> String {
    edits.iter().fold(BASE.to_owned(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{from:?} must occur once");
        text.replace(from, to)
    })
}

#[test]
fn the_base_is_sound() {
    let structure = read(BASE).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(structure.parameters(), [("n".into(), 12.0), ("width".into(), 0.1), ("height".into(), 0.05)]);
    let mesh = structure.mesh();
    assert_eq!((mesh.nodes.len(), mesh.elements.len()), (12 + 4 + 12 + 1, 22));
    assert_eq!(mesh.damping.modal.of(7), 0.02);
    let trim = mesh.trim.unwrap();
    assert_eq!((trim.names, trim.case.loads.len()), (vec!["lift".to_owned(), "trim".to_owned()], 2));
    assert_eq!((trim.settings.load_steps, trim.settings.tolerance), (3, 1e-8));
    assert!((trim.settings.attitude.scaled_axis().y - 0.1).abs() < 1e-15);
    assert_eq!(trim.balance[1].component, Component { index: 4, inertial: true });
    assert_eq!(trim.when_unbalanced, WhenUnbalanced::Warn);
}

/// (text replaced, replacement, what the diagnostic points at, part of its message, part of its hint)
type Case = (&'static str, &'static str, &'static str, &'static str, &'static str);

fn check(cases: &[Case]) {
    for &(from, to, at, message, help) in cases {
        let text = edited(&[(from, to)]);
        let errors = read(&text).err().unwrap_or_else(|| panic!("accepted: {to}"));
        let found = errors.iter().any(|d| {
            &text[d.span()] == at && d.message().contains(message) && d.help().unwrap_or("").contains(help)
        });
        assert!(found, "for {to:?} expected {at:?}: {message:?} ({help:?}), found\n{errors}");
        // One mistake gives one message.
        assert_eq!(errors.iter().count(), 1, "for {to:?}:\n{errors}");
    }
}

#[test]
fn reduction() {
    let (before, table) = ("[options]", |keys: &str| format!("[reduction]\n{keys}\n[options]"));
    for (keys, at, message, help) in [
        ("modes = 2.5", "2.5", "this is 2.5, expected a whole number from 1", ""),
        ("modes = [1, 1]", "[1, 1]", "mode 1 is listed twice", ""),
        ("modes = [0]", "0", "this is 0, expected a whole number from 1", ""),
        ("modes = \"-5Hz\"", "\"-5Hz\"", "expected a positive frequency before the unit, found \"-5\"", ""),
        ("modes = true", "true", "`modes`: found true", ""),
        ("residual = \"some\"", "\"some\"", "`some` is not possible here", "\"all\", \"none\""),
        ("residual = [\"Z\"]", "\"Z\"", "there is no point `Z`", "points: `A`"),
        ("residual = [\"B\", \"B\"]", "\"B\"", "point `B` is listed twice", ""),
        ("inertia = \"consistant\"", "\"consistant\"", "not possible here", "did you mean `consistent`?"),
        ("elastic = \"geometric\"", "[reduction]", "asks for consistent inertia", "inertia = \"consistent\""),
        (
            "inertia = \"consistent\"",
            "[reduction]",
            "does not go with inertia_quadrature",
            "leave that quadrature out",
        ),
        ("order = 3", "order", "no key `order`", "keys known here: `modes`"),
    ] {
        let text = edited(&[(before, &table(keys))]);
        let errors = read(&text).err().unwrap_or_else(|| panic!("accepted: {keys}"));
        let found = errors.iter().any(|d| {
            &text[d.span()] == at && d.message().contains(message) && d.help().unwrap_or("").contains(help)
        });
        assert!(
            found && errors.iter().count() == 1,
            "for {keys:?} expected {at:?}: {message:?}, found\n{errors}"
        );
    }
    let options = |keys: &str| {
        let structure = read(&edited(&[(before, &table(keys))])).unwrap_or_else(|e| panic!("{e}"));
        structure.reduction().clone().options(false)
    };
    assert_eq!(options("").modes, ModeSelection::Count(10));
    assert_eq!(options("modes = \"n + 2\"").modes, ModeSelection::Count(14));
    assert_eq!(options("modes = 0").modes, ModeSelection::Count(0));
    assert_eq!(options("modes = [5, 2]").modes, ModeSelection::List(vec![2, 5]));
    assert_eq!(options("modes = \"400 rad/s\"").modes, ModeSelection::Below(400.0));
    assert_eq!(options("residual = \"all\"").residual, ResidualSelection::Loaded);
    assert_eq!(options("residual = [\"L\"]").residual, ResidualSelection::Points(vec!["L".into()]));
}

#[test]
fn keys_and_shapes() {
    check(&[
        (
            "reference = \"A\"",
            "refrence = \"A\"\nreference = \"A\"",
            "refrence",
            "no key `refrence`",
            "did you mean `reference`?",
        ),
        ("shape = \"tube\"", "shape = \"tbue\"", "\"tbue\"", "`tbue` is no shape", "`tube`"),
        (
            "wall_thickness = 0.01",
            "wall_thickness = 0.01\nwidth_y = 1",
            "width_y",
            "no key `width_y`",
            "keys known here",
        ),
        ("outer_diameter = 0.1\n", "", "[sections.pipe]", "`outer_diameter` is missing", ""),
        (
            "[damping]\n",
            "[dampng]\nx = 1\n[damping]\n",
            "dampng",
            "no key `dampng`",
            "did you mean `damping`?",
        ),
        ("nu = 0.3", "nu = true", "true", "`nu`: found true, expected a number", ""),
        ("nu = 0.3", "nu = [0.3]", "[0.3]", "found a list of 1, expected a number", ""),
        ("nu = 0.3", "nu = 1979-05-27", "1979-05-27", "found a date", ""),
        ("A = [0, 0, 0]", "A = [0, 0]", "[0, 0]", "a list of 2, expected a list of 3", ""),
        ("A = [0, 0, 0]", "A = 5", "5", "a point is given as", ""),
        ("A = [0, 0, 0]", "A = [0, {}, 0]", "{}", "found a table", ""),
        (
            "  [0, 0, 0, 5, 40, 0],\n",
            "",
            "[\n  [10, 0, 0, 0, 0, 0],\n  [0, 20, 0, 1, 0, 0],\n  [0, 0, 20, 0, 0, 0],\n  [0, 1, 0, 30, 5, 0],\n  [0, 0, 0, 0, 0, 50],\n]",
            "a list of 5, expected a list of 6",
            "",
        ),
        (
            "frame = \"dead\"",
            "frame = \"daed\"",
            "\"daed\"",
            "`daed` is not possible",
            "did you mean `dead`?",
        ),
        (
            "\"reduced-coupling\"",
            "\"reduced\"",
            "\"reduced\"",
            "not possible",
            "`consistent`, `reduced-coupling`",
        ),
        ("name = \"frame\"", "name = 5", "5", "expected a text", ""),
        ("element_nodes = 3", "element_nodes = 4", "4", "expected 2 (linear) or 3", ""),
        (
            "time = { expression = \"n * t - vx\" }",
            "time = {}",
            "{}",
            "needs `shape` or `expression`",
            "one-minus-cosine",
        ),
        ("time = { expression = \"n * t - vx\" }", "time = 5", "5", "expected a text", ""),
    ]);
}

#[test]
fn sensors() {
    let at = "[damping]\n";
    check(&[
        (at, "[sensors.imu]\npoint = \"Z\"\n[damping]\n", "\"Z\"", "there is no point `Z`", ""),
        (at, "[sensors.imu]\nframe = \"section\"\n[damping]\n", "[sensors.imu]", "`point` is missing", ""),
        (
            at,
            "[sensors.imu]\npoint = \"A\"\nframe = \"body\"\n[damping]\n",
            "\"body\"",
            "`body`",
            "`drawing`",
        ),
        (
            at,
            "[sensors.imu]\npoint = \"A\"\nmember = \"mast\"\n[damping]\n",
            "\"mast\"",
            "this one is not",
            "frame = \"section\"",
        ),
        (
            at,
            "[sensors.imu]\npoint = \"A\"\ngravity = 9.81\n[damping]\n",
            "9.81",
            "expected true or false",
            "",
        ),
    ]);
}

#[test]
fn numbers_and_expressions() {
    check(&[
        ("rho = 2700", "rho = nan", "nan", "finite", ""),
        ("rho = 2700", "rho = inf", "inf", "this number is inf", ""),
        ("rho = 2700", "rho = 1e300", "1e300", "1e30", ""),
        ("rho = 2700", "rho = \"1/0\"", "\"1/0\"", "this number is inf", ""),
        ("rho = 2700", "rho = \"2 / (n - 12)\"", "\"2 / (n - 12)\"", "this number is inf", "with n = 12"),
        ("rho = 2700", "rho = \"2 * hieght\"", "hieght", "no parameter `hieght`", "did you mean `height`?"),
        ("rho = 2700", "rho = \"2 * (height\"", "(", "not closed", ""),
        ("rho = 2700", "rho = \"t\"", "t", "no parameter `t`", ""),
        ("rho = 2700", "rho = \"\"", "", "ends too early", ""),
        ("n = 12", "n = 12.5", "\"n\"", "this is 12.5, expected a whole number from 1 to 1000000", ""),
        ("n = 12", "n = 0", "\"n\"", "this is 0, expected a whole number", ""),
        ("n = 12", "n = -3", "\"n\"", "this is -3", "with n = -3"),
        ("n = 12", "n = 1e7", "\"n\"", "this is 10000000", ""),
        ("n = 12", "n = 999998", "\"mast\"", "1000002 elements up to member `mast`, at most 1000000", ""),
        (
            "height = 0.05",
            "height = \"width / 2\"",
            "\"2 * height\"",
            "in a circle: width -> height -> width",
            "",
        ),
        ("height = 0.05", "height = 0.05\npi = 3", "pi", "meaning of its own", ""),
        ("height = 0.05", "height = 0.05\nx = 3", "x", "meaning of its own", ""),
        ("height = 0.05", "height = 0.05\n\"a b\" = 3", "\"a b\"", "cannot name a parameter", ""),
        ("height = 0.05", "height = 0.05\nq = []", "[]", "parameter `q` is no number", ""),
        ("height = 0.05", "height = 0.05\nunused = \"1/0\"", "\"1/0\"", "this number is inf", ""),
        ("\"n * t - vx\"", "\"n * t - vw\"", "vw", "no variable or parameter `vw`", "did you mean"),
        ("\"n * t - vx\"", "\"1/t\"", "\"1/t\"", "inf at t = 0", ""),
        ("\"n * t - vx\"", "'n * * t'", "*", "`*` where a number", "^"),
    ]);
}

#[test]
fn sections_and_materials() {
    check(&[
        ("E = 70e9", "E = -70e9", "-70e9", "Young's modulus is -70000000000 Pa", ""),
        ("rho = 2700", "rho = 0", "0", "density is 0 kg/m^3, expected a positive", ""),
        ("nu = 0.3", "nu = 0.5", "0.5", "Poisson's ratio is 0.5", ""),
        ("wall_thickness = 0.01", "wall_thickness = 0.05", "0.05", "expected less than half", "circle"),
        ("outer_diameter = 0.1", "outer_diameter = -0.1", "-0.1", "expected a positive", ""),
        ("width_y = \"width\"", "width_y = 1\nshear_factors = [1, 0]", "0", "shear factor is 0", ""),
        ("width_y = \"width\"", "width_y = 1\ntorsion_constant = -1", "-1", "torsion constant is -1", ""),
        ("height = 0.05", "height = 1e-150", "bar", "too small or too large", ""),
        (
            "[0, 1, 0, 30, 5, 0]",
            "[0, 2, 0, 30, 5, 0]",
            "2",
            "row 4, column 2 is 2, but row 2, column 4 is 1",
            "",
        ),
        ("[10, 0, 0, 0, 0, 0]", "[-10, 0, 0, 0, 0, 0]", "-10", "diagonal entry 1 is -10", ""),
        (
            "[0, 0, 0, 5, 40, 0]",
            "[0, 0, 0, 5, 0.5, 0]",
            "[\n  [10, 0, 0, 0, 0, 0],\n  [0, 20, 0, 1, 0, 0],\n  [0, 0, 20, 0, 0, 0],\n  [0, 1, 0, 30, 5, 0],\n  [0, 0, 0, 5, 0.5, 0],\n  [0, 0, 0, 0, 0, 50],\n]",
            "smallest eigenvalue is -2.",
            "",
        ),
        (
            "[0, 2, 0, 0, 0, 0]",
            "[0, 2.1, 0, 0, 0, 0]",
            "2.1",
            "row 2, column 2 is 2.1, expected 2",
            "[m I, -m c~]",
        ),
        (
            "[0, 0, 0, 0, 1, 0]",
            "[0, 0, 0, 0, 0, 0]",
            "0",
            "mass matrix is not positive definite: diagonal entry 5 is 0",
            "",
        ),
        (
            "shape = \"tube\"\nmaterial = \"alloy\"",
            "shape = \"tube\"\nmaterial = \"aloy\"",
            "\"aloy\"",
            "no material `aloy`",
            "did you mean `alloy`?",
        ),
    ]);
}

#[test]
fn members_and_points() {
    check(&[
        ("path = [\"A\", \"B\"]", "path = [\"A\", \"X\"]", "\"X\"", "no point `X`", "points: `A`, `B`"),
        ("path = [\"A\", \"B\"]", "path = [\"A\", \"A\"]", "\"A\"", "no length from `A` to `A`", ""),
        ("path = [\"A\", \"B\"]", "path = [\"A\"]", "[\"A\"]", "a path of 1 points", ""),
        ("path = [\"A\", \"B\"]", "path = [\"L\", \"B\"]", "\"L\"", "carried by another", "coordinates"),
        ("path = [\"A\", \"B\"]\n", "", "[[members]]", "either `path` or `arc`", ""),
        ("section = \"pipe\"", "section = \"pip\"", "\"pip\"", "no section `pip`", "did you mean `pipe`?"),
        ("elements = 4", "elements = [2, 2]", "[2, 2]", "2 element counts for 1 pieces", ""),
        (
            "elements = 4\nlocal_y = [0, 1, 0]",
            "elements = 4\nlocal_y = [0, 0, 1]",
            "[0, 0, 1]",
            "parallel to member `mast` within 0.000 degrees",
            "",
        ),
        (
            "elements = 4\nlocal_y = [0, 1, 0]",
            "elements = 4\nlocal_y = [0.01, 0, 1]",
            "[0.01, 0, 1]",
            "parallel to member `mast` within 0.573 degrees",
            "",
        ),
        (
            "elements = 4\nlocal_y = [0, 1, 0]",
            "elements = 4\nlocal_y = [0, 0, 0]",
            "[0, 0, 0]",
            "zero vector",
            "",
        ),
        // The arc's top runs along y: parallel only in its middle.
        ("local_y = [1, 0, 0]", "local_y = [0, 1, 0]", "[0, 1, 0]", "parallel to member `hoop`", ""),
        ("through = [10, 2.5, 7.5]", "through = [10, 2.5, 5]", "[10, 2.5, 5]", "lie on one line", "path"),
        ("through = [10, 2.5, 7.5]", "center = [10, 2.5, 5]", "[10, 2.5, 5]", "lie on one line", "through"),
        (
            "through = [10, 2.5, 7.5]",
            "center = [10, 2, 5]",
            "[10, 2, 5]",
            "2 m from its center, its end 3 m",
            "",
        ),
        (
            "through = [10, 2.5, 7.5], ",
            "",
            "{ from = \"C\", to = \"D\" }",
            "either `through` or `center`",
            "",
        ),
        ("to = \"D\"", "to = \"C\"", "\"C\"", "starts and ends at the same place", "two arcs"),
        ("name = \"mast\"", "name = \"boom\"", "\"boom\"", "two members `boom`", ""),
        ("name = \"mast\"", "name = \"a/b\"", "\"a/b\"", "cannot be a name", "letters"),
        (
            "M = [5, 0, 0]",
            "M = [5, 0, 0.1]",
            "M",
            "on no member: the nearest is member `boom` at 0.5 of its length, 1.000e-1 m",
            "link it",
        ),
        ("fraction = 0.5", "fraction = 1.5", "1.5", "expected a number from 0 to 1", ""),
        ("member = \"mast\", fraction", "member = \"mst\", fraction", "\"mst\"", "no member `mst`", "`mast`"),
        ("linked_to = \"B\"", "linked_to = \"Z\"", "\"Z\"", "no point `Z`", ""),
        ("linked_to = \"B\"", "linked_to = \"L\"", "\"L\"", "linked itself", ""),
        ("reference = \"A\"", "reference = \"a\"", "\"a\"", "no point `a`", "did you mean `A`?"),
        ("reference = \"A\"", "reference = \"L\"", "\"L\"", "only linked", "`B`"),
    ]);
}

#[test]
fn parts_that_look_joined_but_are_not() {
    let extra = "\n[[members]]\nname = \"fin\"\npath = [\"E\", \"F\"]\nsection = \"bar\"\nelements = 2\nlocal_y = [1, 0, 0]\n[damping]\n";
    let with = |points: &str| {
        edited(&[("M = [5, 0, 0]", &format!("M = [5, 0, 0]\n{points}")), ("[damping]\n", extra)])
    };
    let messages =
        |text: &str| -> Vec<String> { read(text).unwrap_err().iter().map(|d| d.to_string()).collect() };

    let apart = messages(&with("E = [0, 9, 0]\nF = [0, 9, 4]"));
    assert_eq!(apart.len(), 1, "{apart:?}");
    assert!(
        apart[0].contains("2 parts that nothing joins: (`boom`, `mast`, `hoop`) and (`fin`)"),
        "{apart:?}"
    );

    let coincident = messages(&with("E = [10, 0, 5]\nF = [0, 9, 4]"));
    assert!(
        coincident
            .iter()
            .any(|m| m.contains("points `C` and `E` are at the same place") && m.contains("use point `C`"))
    );

    let on_member = messages(&with("E = [5, 0, 0]\nF = [5, 3, 3]"));
    assert!(on_member.iter().any(|m| m.contains("point `E` lies on member `boom`")), "{on_member:?}");
}

#[test]
fn masses_loads_and_settings() {
    check(&[
        ("mass = 5", "mass = -5", "-5", "the mass is -5 kg", ""),
        ("point = \"L\"\nmass", "point = \"LL\"\nmass", "\"LL\"", "no point `LL`", "`L`"),
        (
            "inertia = [1, 1, 1.5]",
            "inertia = [1, 1, 2.5]",
            "[1, 1, 2.5]",
            "no body has this inertia: its principal moments are 1, 1 and 2.5",
            "sum",
        ),
        ("inertia = [1, 1, 1.5]", "inertia = [-1, 1, 1]", "[-1, 1, 1]", "no body has this inertia", ""),
        (
            "inertia = [1, 1, 1.5]",
            "inertia = [[1, 0, 0.1], [0, 1, 0], [0, 0, 1]]",
            "0",
            "row 3, column 1 is 0, but row 1, column 3 is 0.1",
            "",
        ),
        ("time = \"push\"", "time = \"psuh\"", "\"psuh\"", "no time function `psuh`", "`push`"),
        ("{ point = \"M\"", "{ point = \"m\"", "\"m\"", "no point `m`", "`M`"),
        ("member = \"boom\", ", "", "\"B\"", "different section axes meet at point `B`", "`boom`, `mast`"),
        ("member = \"boom\"", "member = \"hoop\"", "\"hoop\"", "no member `hoop` at point `B`", ""),
        (
            "frame = \"dead\"",
            "frame = \"dead\", member = \"boom\"",
            "\"boom\"",
            "which section a follower load follows",
            "",
        ),
        (
            "moment = [0, 0, 1], ",
            "",
            "{ point = \"L\", frame = \"dead\", time = { expression = \"n * t - vx\" } }",
            "`force`, `moment` or both",
            "",
        ),
        ("dt = 0.01", "dt = -0.01", "-0.01", "time step is -0.01 s", ""),
        ("dt = 0.01", "dt = 20", "20", "longer than the run", ""),
        ("dt = 0.01", "dt = 1e-9", "1e-9", "time steps, at most", ""),
        ("t_end = 10", "t_end = 0", "0", "end of the run is 0 s", ""),
        ("t_end = 10\n", "", "[load_cases.one]", "`t_end` is missing", ""),
        ("dt = 0.01", "dt = 0.01\nnumerical_damping = -0.1", "-0.1", "expected a number from 0 to 1", ""),
        ("dt = 0.01", "dt = 0.01\nnumerical_damping = 1.1", "1.1", "expected a number from 0 to 1", ""),
        ("end = 2\n", "end = -2\n", "-2", "expected one after `start`, 0 s", ""),
        ("t = [0, 1, 2]", "t = [0, 2, 2]", "2", "expected one after", ""),
        ("t = [0, 1, 2]", "t = [0, 1]", "[0, 1, 0]", "3 values for 2 times", ""),
        ("t = [0, 1, 2]", "t = []", "[]", "an empty table", ""),
        ("[load_cases.one]", "[load_cases.all]", "all", "cannot name a load case", ""),
        ("modal_ratio = 0.02", "modal_ratio = 2", "2", "ratio is 2, expected 0 to below 1", "0.01"),
    ]);
}

#[test]
fn all_mistakes_are_reported_at_once() {
    let text = edited(&[
        ("nu = 0.3", "nu = 0.7"),
        ("rho = 2700", "rho = 0\ncolour = 1"),
        ("wall_thickness = 0.01", "wall_thickness = -0.01"),
        ("section = \"pipe\"", "section = \"pip\""),
        ("time = \"push\"", "time = \"psuh\""),
        ("mass = 5", "mass = 0"),
        ("dt = 0.01", "dt = 0"),
    ]);
    let errors = read(&text).unwrap_err();
    let lines: Vec<usize> = errors.iter().map(|d| d.line()).collect();
    assert_eq!(lines.len(), 8, "{errors}");
    assert!(lines.is_sorted());
    let text = errors.to_string();
    assert!(text.starts_with("frame.toml:13:6: Poisson's ratio is 0.7"), "{text}");
}

#[test]
fn set_overrides_parameters() {
    let set = |list: &[(&str, &str)]| {
        let sets: Vec<_> = list.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
        Structure::from_toml_str(BASE, "frame.toml", &sets)
    };
    let structure = set(&[("n", "2 * 4"), ("height", "0.01 * n")]).unwrap();
    assert_eq!(structure.parameters(), [("n".into(), 8.0), ("width".into(), 0.16), ("height".into(), 0.08)]);
    assert_eq!(structure.element_count(), 18);
    for (sets, message) in [
        (
            &[("hieght", "1")][..],
            "--set hieght:1:1: there is no parameter `hieght` to set\n  help: did you mean `height`?",
        ),
        (&[("sigma", "1")], "parameters: `n`, `width`, `height`"),
        (&[("n", "12 +")], "--set n:1:5: this expression ends too early"),
        (&[("n", "7"), ("n", "8")], "`n` is set twice"),
        (&[("n", "width")], "this is 0.1, expected a whole number"),
        (&[("height", "width")], "in a circle"),
        (&[("height", "nan")], "there is no parameter `nan`"),
        (&[("height", "0/0")], "this number is NaN"),
    ] {
        let errors = set(sets).unwrap_err().to_string();
        assert!(errors.contains(message), "{sets:?}: {errors}");
    }
}

#[test]
fn equilibrium() {
    check(&[
        (
            "load = \"trim\"",
            "load = \"trin\"",
            "\"trin\"",
            "no load of the equilibrium is named `trin`",
            "`trim`",
        ),
        (
            "load = \"trim\"",
            "load = \"lift\"",
            "\"lift\"",
            "the factor on `lift` is solved for already",
            "one component",
        ),
        (
            "{ load = \"trim\", component = \"moment-y\", axes = \"inertial\" }",
            "{ load = \"trim\", component = \"force-z\" }",
            "{ load = \"trim\", component = \"force-z\" }",
            "the force along z of A is cancelled by another load already",
            "one load",
        ),
        ("\"moment-y\"", "\"moment\"", "\"moment\"", "`moment` is not possible here", "`moment-"),
        ("tolerance = 1e-8", "tolerance = 0", "0", "the tolerance is 0, expected 1e-14 to 1e-3", ""),
        ("load_steps = 3", "load_steps = 0", "0", "expected a whole number", ""),
        ("\"warn\"", "\"ignore\"", "\"ignore\"", "`ignore` is not possible here", ""),
        ("{ pitch = 0.1 }", "{ picth = 0.1 }", "picth", "there is no key `picth` here", "`pitch`"),
        (
            "[damping]",
            "[gravity]\nacceleration = [0, 0, -9.81]\n\n[damping]",
            "[gravity]",
            "gravity does not go with inertia_quadrature",
            "leave it out",
        ),
        ("[damping]", "[gravity]\nacceleration = 9.81\n\n[damping]", "9.81", "expected a list of 3", ""),
    ]);
}
