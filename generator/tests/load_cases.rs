//! Loads: frames, time functions, expressions, and load-case files of their own.

use nalgebra::Matrix3;
use rom_generator::input::{InputErrors, Line, PointTable, Structure, read_load_cases};
use rom_runtime::expression::{Binary, Instruction, Unary, Variable};
use rom_runtime::loads::{LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;

fn table() -> PointTable {
    let turned = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    PointTable {
        points: vec![
            ("P".into(), vec![("arm".into(), turned)]),
            ("corner".into(), vec![("arm".into(), turned), ("beam".into(), Matrix3::identity())]),
            ("joint".into(), vec![("arm".into(), turned), ("fin".into(), turned)]),
        ],
        lines: [("wing", true), ("boom", false)]
            .map(|(name, carries)| Line {
                name: name.into(),
                length: 4.0,
                knots: vec![0.0, 0.25, 0.5, 1.0],
                carries,
            })
            .to_vec(),
        parameters: vec![("mass".into(), 405.0)],
    }
}

fn read(text: &str, sets: &[(&str, &str)]) -> Result<Vec<LoadCase>, InputErrors> {
    let sets: Vec<_> = sets.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
    read_load_cases(text, "gust.toml", &table(), &sets)
}

fn time(inline: &str) -> TimeFunction {
    let text = format!(
        "[load_cases.one]\nt_end = 1\ndt = 0.1\nloads = [{{ point = \"P\", frame = \"dead\", force = [1, 0, 0], time = {inline} }}]"
    );
    read(&text, &[]).unwrap_or_else(|e| panic!("{inline}: {e}")).remove(0).loads.remove(0).time
}

#[test]
fn every_shape() {
    let forever = f64::MAX;
    for (text, expected) in [
        ("{ shape = \"constant\" }", TimeFunction::Constant { value: 1.0 }),
        ("{ shape = \"constant\", value = 2 }", TimeFunction::Constant { value: 2.0 }),
        ("{ shape = \"step\" }", TimeFunction::Step { value: 1.0, start: 0.0, end: forever }),
        (
            "{ shape = \"step\", value = 3, start = 1, end = 2 }",
            TimeFunction::Step { value: 3.0, start: 1.0, end: 2.0 },
        ),
        ("{ shape = \"ramp\", rate = 3 }", TimeFunction::Ramp { rate: 3.0, start: 0.0, end: forever }),
        (
            "{ shape = \"ramp\", rate = -3, start = 1, end = 2 }",
            TimeFunction::Ramp { rate: -3.0, start: 1.0, end: 2.0 },
        ),
        (
            "{ shape = \"triangle\", at = 1, end = 3 }",
            TimeFunction::Triangle { peak: 1.0, start: 0.0, at: 1.0, end: 3.0 },
        ),
        (
            "{ shape = \"sine\", omega = \"2*pi\" }",
            TimeFunction::Sine {
                amplitude: 1.0,
                omega: std::f64::consts::TAU,
                phase: 0.0,
                start: 0.0,
                end: forever,
            },
        ),
        (
            "{ shape = \"one-minus-cosine\", amplitude = 5, start = 1, duration = 0.5 }",
            TimeFunction::OneMinusCosine { amplitude: 5.0, start: 1.0, duration: 0.5 },
        ),
        (
            "{ shape = \"table\", t = [0, 1], value = [2, \"mass\"] }",
            TimeFunction::Table { t: vec![0.0, 1.0], value: vec![2.0, 405.0] },
        ),
    ] {
        assert_eq!(time(text), expected);
    }
}

#[test]
fn expressions_become_programs_with_the_parameters_as_constants() {
    let code = |text: &str| {
        let TimeFunction::Expression { program } = time(&format!("{{ expression = \"{text}\" }}")) else {
            panic!()
        };
        assert_eq!(program.source, text);
        program.code
    };
    use Instruction::{Binary as B, Constant as C, Unary as U, Variable as V};
    assert_eq!(
        code("mass * t - wx"),
        [C(405.0), V(Variable::T), B(Binary::Mul), V(Variable::Wx), B(Binary::Sub)]
    );
    // Drag: -1/2 rho v |v|.
    assert_eq!(
        code("-0.5*vy*abs(vy)"),
        [
            C(0.0),
            C(0.5),
            V(Variable::Vy),
            B(Binary::Mul),
            V(Variable::Vy),
            U(Unary::Abs),
            B(Binary::Mul),
            B(Binary::Sub)
        ]
    );
    assert_eq!(code("max(z, pi)"), [V(Variable::Z), C(std::f64::consts::PI), B(Binary::Max)]);
    let long = vec!["t"; 200].join(" + ");
    assert_eq!(code(&long).len(), 399);
    let deep = "t + (".repeat(40) + "t" + &")".repeat(40);
    let text = format!(
        "[load_cases.one]\nt_end = 1\ndt = 0.1\nloads = [{{ point = \"P\", frame = \"dead\", force = [1, 0, 0], time = {{ expression = \"{deep}\" }} }}]"
    );
    assert!(read(&text, &[]).unwrap_err().to_string().contains("41 intermediate results, at most 32"));
}

#[test]
fn a_load_file_reads_like_the_structure_file() {
    let cases = "[times.push]\nshape = \"ramp\"\nrate = \"2 * k\"\n\
        [load_cases.a]\ndescription = \"first\"\nt_end = 2\ndt = 0.1\nnumerical_damping = 0\nloads = [\n\
        { point = \"P\", frame = \"follower\", force = [1, 2, 3], time = \"push\" },\n\
        { point = \"corner\", frame = \"body\", moment = [\"mass\", 0, 0] } ]\n\
        [load_cases.b]\nt_end = 1\ndt = 0.5\nloads = []\n";
    let list = read(&format!("[parameters]\nk = \"mass/405\"\n{cases}"), &[]).unwrap();
    assert_eq!(list.len(), 2);
    assert_eq!((list[0].name.as_str(), list[0].description.as_str()), ("a", "first"));
    assert_eq!((list[1].numerical_damping, list[1].loads.len()), (0.01, 0));
    let [follower, body] = &list[0].loads[..] else { panic!() };
    let section = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!((follower.point, follower.frame), (0, LoadFrame::Follower { section }));
    assert_eq!(follower.time, TimeFunction::Ramp { rate: 2.0, start: 0.0, end: f64::MAX });
    assert_eq!((body.point, body.frame, body.moment), (1, LoadFrame::Body, [405.0, 0.0, 0.0]));
    assert_eq!(body.time, TimeFunction::Constant { value: 1.0 });

    let set = read(&format!("[parameters]\nk = 1\n{cases}"), &[("k", "mass / 81")]).unwrap();
    assert_eq!(set[0].loads[0].time, TimeFunction::Ramp { rate: 10.0, start: 0.0, end: f64::MAX });
}

#[test]
fn the_same_text_gives_the_same_load_cases_in_both_files() {
    let text = include_str!("../../models/fmb.toml");
    let structure = Structure::from_toml_str(text, "fmb.toml", &[]).unwrap();
    let mesh = structure.mesh();
    let table = structure.point_table();
    let loads = &text[text.find("[times.F]").unwrap()..];
    assert_eq!(read_load_cases(loads, "loads.toml", &table, &[]).unwrap(), mesh.load_cases);
}

/// A load along the member `wing` of 4 m.
fn along(rest: &str) -> String {
    let rest = if rest.is_empty() { String::new() } else { format!(", {rest}") };
    format!(
        "[load_cases.one]\nt_end = 1\ndt = 0.1\n\
         distributed_loads = [{{ member = \"wing\", frame = \"dead\", force = [0, 0, 2]{rest} }}]"
    )
}

/// Sum over the stations, and sum times their place on the member, m.
fn moments(rest: &str) -> (f64, f64) {
    let load = read(&along(rest), &[]).unwrap_or_else(|e| panic!("{e}")).remove(0).distributed.remove(0);
    assert!(load.member == 0 && load.moment.is_empty() && load.force.len() == 27);
    let gauss = [0.5 - 0.15f64.sqrt(), 0.5, 0.5 + 0.15f64.sqrt()];
    let places = [(0.0, 1.0), (1.0, 1.0), (2.0, 2.0)]
        .into_iter()
        .flat_map(|(start, length)| gauss.map(|x| start + length * x));
    let forces = load.force.chunks(3).map(|f| f[2]);
    forces.zip(places).fold((0.0, 0.0), |(sum, first), (f, s)| (sum + f, first + f * s))
}

/// Stations carry the load and its first moment, corners and ends inside elements included.
#[test]
fn distributed_loads_on_stations() {
    let near = |(a, b): (f64, f64), (c, d): (f64, f64), tolerance: f64| {
        assert!((a - c).abs() < tolerance && (b - d).abs() < tolerance, "{a} {b}, expected {c} {d}");
    };
    near(moments("along = [[0, 1], [1, 1]]"), (8.0, 16.0), 1e-13);
    near(moments("from = 0.1, to = 0.6"), (4.0, 2.0 * (2.4 * 2.4 - 0.4 * 0.4) / 2.0), 1e-13);
    // A triangle of 2 N/m at its peak at 1.2 m, from 0.4 m to 3.2 m; its centroid is the mean of the three.
    near(moments("along = [[0.1, 0], [0.3, 1], [0.8, 0]]"), (2.8, 2.8 * 1.6), 1e-13);
    near(moments("along = \"s^2 * mass / 405\""), (2.0 * 64.0 / 3.0, 2.0 * 64.0), 1e-12);
    // An ellipse has a vertical tangent at the tip: Gauss points over h/4 are off by h^1.5 of a small part.
    near(moments("along = \"sqrt(1 - fraction^2)\""), (2.0 * std::f64::consts::PI, 2.0 * 16.0 / 3.0), 1e-2);
}

#[test]
fn refused_distributed_loads() {
    for (text, message) in [
        (along("").replace("\"wing\"", "\"wng\""), "did you mean `wing`?"),
        (along("").replace("\"wing\"", "\"boom\""), "build it with --all-nodes"),
        (along("from = 0.5, to = 0.5"), "`from` has to be less than `to`"),
        (along("to = 1.5"), "the fraction is 1.5"),
        (along("along = [[0, 1], [0, 2]]"), "follows 0, expected a larger one"),
        (along("along = [[0, 1]]"), "at least two pairs"),
        (along("along = \"1/(fraction - 0.5)^2 * sqrt(-1)\""), "somewhere along member `wing`"),
        (along("along = \"x\""), "there is no variable or parameter `x`"),
        (along("along = 3"), "expression of `fraction` and `s`"),
        (along("").replace(", force = [0, 0, 2]", ""), "needs `force`, `moment` or both"),
        (along("time = \"gust\""), "gust"),
    ] {
        let error = read(&text, &[]).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
}

#[test]
fn refusals() {
    let case = |load: &str| format!("[load_cases.one]\nt_end = 1\ndt = 0.1\nloads = [{load}]");
    let dead = case("{ point = \"P\", frame = \"dead\", force = [1, 0, 0] }");
    assert!(read(&dead, &[]).is_ok());
    assert!(read(&case("{ point = \"joint\", frame = \"follower\", force = [1, 0, 0] }"), &[]).is_ok());
    for (text, sets, message) in [
        (String::new(), &[][..], "the file is empty"),
        ("[load_cases]".into(), &[], "no load case"),
        ("[structure]\nname = \"x\"".into(), &[], "no key `structure`"),
        (dead.replace("\"P\"", "\"p\""), &[], "did you mean `P`?"),
        (dead.replace("dt = 0.1", "dt = \"mas\""), &[], "did you mean `mass`?"),
        (case("{ point = \"corner\", frame = \"follower\", force = [1, 0, 0] }"), &[], "`arm`, `beam`"),
        (dead.clone(), &[("mass", "1")], "was fixed when the model was built"),
        (dead.clone(), &[("k", "1")], "there is no parameter `k` to set"),
        (format!("[parameters]\nmass = 1\n{dead}"), &[], "already has a parameter `mass`"),
    ] {
        let errors = read(&text, sets).unwrap_err().to_string();
        assert!(errors.contains(message), "{text}: {errors}");
    }
}
