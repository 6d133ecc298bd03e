//! Contents that make no model are refused, each with an error that names what is wrong.

use crate::common::{Lumped, rotation_rows};
use rom_runtime::data::{GravityData, TrimData};
use rom_runtime::expression::{Binary, Instruction, Program};
use rom_runtime::time::TimeFunction;
use rom_runtime::{FormatError, Load, LoadCase, LoadFrame, LoadSet, Model, ModelData};

fn load(time: TimeFunction) -> Load {
    Load { point: 0, frame: LoadFrame::Dead, force: [1.0, 0.0, 0.0], moment: [0.0; 3], time }
}

fn case(name: &str, loads: Vec<Load>) -> LoadCase {
    LoadCase { dt: 0.01, loads, ..LoadCase::empty(name) }
}

fn good() -> ModelData {
    let mut data = Lumped::random(3, 4).data(4);
    data.load_cases =
        vec![case("pull", vec![load(TimeFunction::Constant { value: 1.0 })]), case("none", vec![])];
    data
}

/// A loaded equilibrium, good in itself.
fn trim(data: &mut ModelData) -> &mut TrimData {
    let loads = vec![load(TimeFunction::Constant { value: 1.0 })];
    let displacements = vec![[0.1, 0.0, 0.2]; data.points.len()];
    data.trim.insert(TrimData {
        distributed: Vec::new(),
        loads,
        elastic_force: vec![0.5; 3],
        elastic_energy: 2.0,
        attitude: [0.6, 0.0, 0.8, 0.0],
        factors: vec![("lift".into(), 1.5)],
        load_names: Vec::new(),
        reaction: [0.0; 6],
        scales: [1.0, 1.0],
        displacements,
        effort: [1, 5],
    })
}

fn gravity(data: &mut ModelData) -> &mut GravityData {
    data.gravity.insert(GravityData { acceleration: [0.0, 0.0, -9.81], second_moment: vec![] })
}

/// Every way to break the data, with words its message must have.
type Break = (&'static str, fn(&mut ModelData));

const BREAKS: &[Break] = &[
    ("mass is 0", |d| d.rigid.mass = 0.0),
    ("mass is -1", |d| d.rigid.mass = -1.0),
    ("mass holds NaN", |d| d.rigid.mass = f64::NAN),
    ("centre_of_mass holds inf at entry 2", |d| d.rigid.centre_of_mass[2] = f64::INFINITY),
    ("initial_position holds NaN", |d| d.rigid.initial_position[0] = f64::NAN),
    ("mass_matrix has 35 entries, expected 36", |d| d.rigid.mass_matrix.truncate(35)),
    ("mass_matrix holds NaN", |d| d.rigid.mass_matrix[7] = f64::NAN),
    ("mass_matrix is", |d| d.rigid.mass *= 1.01),
    ("mass_matrix is", |d| d.rigid.centre_of_mass[1] += 0.01),
    ("not symmetric positive definite", |d| d.rigid.mass_matrix[6 * 4 + 3] += 0.1),
    ("pivot", |d| d.rigid.mass_matrix[35] = 1e-3),
    ("pivot", |d| d.rigid.mass_matrix[35] = -1.0),
    ("number of modes has 4 entries, expected 3", |d| d.modes.number.push(9)),
    ("number of modes is out of order at entry 1", |d| d.modes.number[1] = 1),
    ("omega of modes is -1", |d| d.modes.omega[0] = -1.0),
    ("omega of modes holds NaN", |d| d.modes.omega[0] = f64::NAN),
    ("omega of modes is out of order", |d| d.modes.omega.swap(0, 2)),
    ("generalised mass is 0 at entry 1", |d| d.modes.mass[1] = 0.0),
    ("generalised mass has 2 entries", |d| d.modes.mass.truncate(2)),
    ("damping ratio is -0.1", |d| d.modes.damping_ratio[2] = -0.1),
    ("phi_r has 17 entries, expected 18", |d| d.modes.phi_r.truncate(17)),
    ("phi_r holds inf", |d| d.modes.phi_r[3] = f64::INFINITY),
    ("first_moment has 8 entries, expected 9", |d| d.modes.first_moment.truncate(8)),
    ("next_omega is 0", |d| d.modes.next_omega = Some(0.0)),
    ("elastic_force of the trim has 2 entries, expected 3", |d| trim(d).elastic_force.truncate(2)),
    ("elastic_force of the trim holds NaN at entry 1", |d| trim(d).elastic_force[1] = f64::NAN),
    ("squared length of the attitude of the trim is 1.64", |d| trim(d).attitude[0] = 1.0),
    ("reaction of the trim holds NaN at entry 4", |d| trim(d).reaction[4] = f64::NAN),
    ("displacements of the trim has 7 entries", |d| trim(d).displacements.truncate(7)),
    ("factor on \"lift\" of the trim holds inf", |d| trim(d).factors[0].1 = f64::INFINITY),
    ("acceleration of gravity holds NaN", |d| gravity(d).acceleration[1] = f64::NAN),
    ("second_moment of gravity has 26 entries, expected 27", |d| gravity(d).second_moment = vec![0.0; 26]),
    ("elastic_energy of the trim holds inf", |d| trim(d).elastic_energy = f64::INFINITY),
    ("load 1 of the trim", |d| trim(d).loads[0].point = 99),
    ("load 1 of the trim", |d| trim(d).loads[0].force[2] = f64::NAN),
    ("tensor c, index i has", |d| d.c.i.truncate(1)),
    ("tensor c, index i is 9 at entry", |d| *d.c.i.last_mut().unwrap() = 9),
    ("tensor c, index l is 9 at entry 0", |d| d.c.l[0] = 9),
    ("tensor c, index r is 6", |d| d.c.r[0] = 6),
    ("tensor c holds NaN at entry 5", |d| d.c.value[5] = f64::NAN),
    ("tensor c is out of order at entry 1", |d| {
        d.c.r.swap(0, 1);
        d.c.l.swap(0, 1);
    }),
    ("tensor c is out of order at entry 1", |d| {
        d.c.i[1] = d.c.i[0];
        d.c.l[1] = d.c.l[0];
        d.c.r[1] = d.c.r[0];
    }),
    ("tensor k, index l is 3", |d| d.k.l[0] = 3),
    ("tensor k, index r is 36", |d| d.k.r[0] = 36),
    ("tensor k, index r is 27", |_| ()),
    ("tensor k holds inf", |d| d.k.value[0] = f64::INFINITY),
    ("tensor k is -1", |d| d.k.threshold = -1.0),
    ("tensor c is NaN at entry 1", |d| d.c.dropped_norm = f64::NAN),
    ("point 1 is named \"P0\"", |d| d.points[1].name = "P0".into()),
    ("point 0 is named \"\"", |d| d.points[0].name.clear()),
    ("node_position of point 2 \"P2\" holds NaN", |d| d.points[2].node_position[1] = f64::NAN),
    ("node_rotation of point 0", |d| d.points[0].node_rotation = [1.0, 0.1, 0.0, 0.0]),
    ("node_rotation of point 0", |d| d.points[0].node_rotation = [0.0; 4]),
    ("offset of point 0", |d| d.points[0].offset[0] = f64::NAN),
    ("phi_translation of point 0 \"P0\" has 10 entries, expected 9", |d| {
        d.points[0].phi_translation.push(0.0)
    }),
    ("phi_rotation of point 1", |d| d.points[1].phi_rotation[0] = f64::NEG_INFINITY),
    ("section frame of member \"member\"", |d| d.points[0].sections[0].1[0] = [1.0, 1.0, 0.0]),
    ("section frame of member \"member\"", |d| {
        d.points[0].sections[0].1 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]
    }),
    ("load case 1 is named \"pull\"", |d| d.load_cases[1].name = "pull".into()),
    ("t_end of load case \"pull\" is 0", |d| d.load_cases[0].t_end = 0.0),
    ("dt of load case \"pull\" is -0.1", |d| d.load_cases[0].dt = -0.1),
    ("numerical_damping of load case \"pull\" is 2", |d| d.load_cases[0].numerical_damping = 2.0),
    ("numerical_damping of load case \"pull\" is NaN", |d| d.load_cases[0].numerical_damping = f64::NAN),
    ("point of load 0 of load case \"pull\" is 99", |d| d.load_cases[0].loads[0].point = 99),
    ("force of load 0", |d| d.load_cases[0].loads[0].force[1] = f64::NAN),
    ("moment of load 0", |d| d.load_cases[0].loads[0].moment[1] = f64::NAN),
    ("section frame of load 0", |d| {
        d.load_cases[0].loads[0].frame = LoadFrame::Follower { section: [[0.0; 3]; 3] }
    }),
    ("picture positions has", |d| d.picture.as_mut().unwrap().positions.truncate(4)),
    ("picture phi_translation has", |d| d.picture.as_mut().unwrap().phi_translation.truncate(4)),
    ("picture line 0 is 99", |d| d.picture.as_mut().unwrap().lines[0][1] = 99),
    ("parameter sigma", |d| d.provenance.parameters[0].1 = f64::NAN),
    ("check \"mass\"", |d| d.checks[0].value = f64::NAN),
    ("limit of check \"mass\"", |d| d.checks[0].limit = f64::NAN),
];

#[test]
fn broken_contents_are_named() {
    assert!(Model::new(good()).is_ok());
    for (words, spoil) in BREAKS {
        let mut data = good();
        if *words == "tensor k, index r is 27" {
            // r > s: the pair (4, 3) instead of (3, 4).
            let at = data.k.r.iter().position(|&rs| rs == 22).unwrap();
            data.k.r[at] = 27;
        }
        spoil(&mut data);
        let error = match Model::new(data.clone()) {
            Ok(_) => panic!("accepted although: {words}"),
            Err(error) => error,
        };
        assert!(error.to_string().contains(words), "\"{error}\" should say: {words}");
        // The same through a file whose checksums are right.
        let bytes = data.to_bytes().unwrap();
        assert!(matches!(Model::from_bytes(&bytes), Err(FormatError::Model(_))), "{words}");
    }
}

#[test]
fn broken_time_functions_are_named() {
    let program =
        |code: Vec<Instruction>| TimeFunction::Expression { program: Program { source: "1 +".into(), code } };
    let broken = [
        (TimeFunction::Constant { value: f64::NAN }, "holds NaN"),
        (TimeFunction::Step { value: 1.0, start: 2.0, end: 1.0 }, "start <= end"),
        (TimeFunction::Step { value: 1.0, start: 0.0, end: f64::INFINITY }, "holds inf"),
        (TimeFunction::Ramp { rate: 1.0, start: 2.0, end: 1.0 }, "start <= end"),
        (TimeFunction::Triangle { peak: 1.0, start: 0.0, at: 3.0, end: 2.0 }, "start <= at <= end"),
        (TimeFunction::Triangle { peak: 1.0, start: 1.0, at: 1.0, end: 1.0 }, "start before end"),
        (
            TimeFunction::Sine { amplitude: 1.0, omega: f64::NAN, phase: 0.0, start: 0.0, end: 1.0 },
            "holds NaN",
        ),
        (TimeFunction::OneMinusCosine { amplitude: 1.0, start: 0.0, duration: 0.0 }, "more than zero"),
        (TimeFunction::Table { t: vec![], value: vec![] }, "at least one instant"),
        (TimeFunction::Table { t: vec![0.0, 1.0], value: vec![1.0] }, "has 1 entries, expected 2"),
        (TimeFunction::Table { t: vec![0.0, 0.0], value: vec![1.0, 2.0] }, "strictly increasing"),
        (TimeFunction::Table { t: vec![0.0, f64::NAN], value: vec![1.0, 2.0] }, "holds NaN"),
        (program(vec![]), "empty"),
        (program(vec![Instruction::Constant(1.0), Instruction::Binary(Binary::Add)]), "underflow"),
        (program(vec![Instruction::Constant(1.0); 100]), "nested too deeply"),
        (program(vec![Instruction::Constant(1.0); 2]), "more than one"),
    ];
    let model = Model::new(good()).unwrap();
    for (time, words) in broken {
        let error = model.prepare(&case("mine", vec![load(time.clone())])).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("load 0 of load case \"mine\""), "{error}");
        let mut data = good();
        data.load_cases[0].loads[0].time = time;
        assert!(Model::new(data).is_err(), "{words}");
    }
}

#[test]
fn names_that_are_not_there_list_those_that_are() {
    let model = Model::new(good()).unwrap();
    assert_eq!(model.point("P2"), Ok(2));
    assert_eq!(model.load_case("none").unwrap().loads.len(), 0);
    let error = model.load_case("lc2").unwrap_err().to_string();
    assert!(error.contains("lc2") && error.contains("pull, none"), "{error}");
    assert!(model.point("tip").unwrap_err().to_string().contains("P0, P1"));
    let beyond = LoadSet::new(&model, &[0, 99]).unwrap_err();
    assert!(beyond.to_string().starts_with("the model has no point number 99; it has: P0"), "{beyond}");
    assert!(LoadSet::new(&model, &[1, 1]).is_err());
    assert_eq!(rotation_rows(&nalgebra::Vector3::zeros())[0], [1.0, 0.0, 0.0]);
}

#[test]
fn a_model_is_shared_between_threads() {
    fn shared<T: Send + Sync>() {}
    shared::<Model>();
    shared::<rom_runtime::PreparedLoads>();
    shared::<rom_runtime::Simulation>();
}
