//! Sections `LAGR` and `PCUR` that make no model are refused, each with an error that names what is wrong.

use rom_runtime::data::{CurveValidityData, LagrangianData, PictureCurveData, PolynomialData, ValidityData};
use rom_runtime::{FormatError, Model, ModelData};

use crate::common::lagrangian::bent;

fn good() -> ModelData {
    bent(false).1
}

/// A way to break something, with words that the message must have.
type Break<T> = (&'static str, fn(&mut T));

/// Every way to break the Lagrangian.
const BREAKS: &[Break<LagrangianData>] = &[
    ("number of kinetic coordinates is 2 at entry 0, expected at least the number of modes", |l| {
        l.fields = 2
    }),
    ("number of kinetic coordinates is 513", |l| l.fields = 513),
    ("number of kinetic coordinates is 4294967295", |l| l.fields = u32::MAX),
    // One field more or less than the arrays are for.
    ("first_moment of the fields has 15 entries, expected 18", |l| l.fields = 6),
    ("row of cubic terms of kinetic coordinates is 4", |l| l.fields = 4),
    ("linear part of the kinetic coordinates has 8 entries, expected 9", |l| l.linear.truncate(8)),
    ("linear part of the kinetic coordinates holds NaN at entry 2", |l| l.linear[2] = f64::NAN),
    ("linear part of the kinetic coordinates is 0.5 at entry 3, expected an upper", |l| l.linear[3] = 0.5),
    ("linear part of the kinetic coordinates is 0 at entry 4, expected an upper", |l| l.linear[4] = 0.0),
    ("linear part of the kinetic coordinates is -1 at entry 8", |l| l.linear[8] = -1.0),
    ("row of quadratic terms of kinetic coordinates is 5", |l| l.curve.quadratic[3].0 = 5),
    ("factors of quadratic terms of kinetic coordinates is 3", |l| l.curve.quadratic[0].1 = [0, 3]),
    ("quadratic terms of kinetic coordinates holds inf at entry 1", |l| {
        l.curve.quadratic[1].2 = f64::INFINITY
    }),
    ("quadratic terms of kinetic coordinates is out of order at entry 2: ascending", |l| {
        l.curve.quadratic[2].1 = [1, 0]
    }),
    ("quadratic terms of kinetic coordinates is out of order at entry 1: terms", |l| {
        l.curve.quadratic.swap(0, 1)
    }),
    ("quadratic terms of kinetic coordinates is out of order at entry 1", |l| {
        l.curve.quadratic[1] = l.curve.quadratic[0]
    }),
    ("row of cubic terms of kinetic coordinates is 9", |l| l.curve.cubic[4].0 = 9),
    ("factors of cubic terms of kinetic coordinates is 7", |l| l.curve.cubic[0].1[2] = 7),
    ("cubic terms of kinetic coordinates holds NaN at entry 0", |l| l.curve.cubic[0].2 = f64::NAN),
    ("cubic terms of kinetic coordinates is out of order at entry 1: ascending", |l| {
        l.curve.cubic[1].1 = [0, 2, 1]
    }),
    ("cubic terms of kinetic coordinates is out of order at entry 4: terms", |l| l.curve.cubic.swap(3, 4)),
    ("first_moment of the fields has 14 entries, expected 15", |l| l.first_moment.truncate(14)),
    ("first_moment of the fields holds NaN at entry 7", |l| l.first_moment[7] = f64::NAN),
    ("moment_0 of the fields has 46 entries, expected 45", |l| l.moment_0.push(0.0)),
    ("moment_0 of the fields holds -inf at entry 0", |l| l.moment_0[0] = f64::NEG_INFINITY),
    ("moments of the fields, index i has 224 entries, expected 225", |l| l.moment.i.truncate(224)),
    ("moments of the fields, index i is 5 at entry 224", |l| l.moment.i[224] = 5),
    ("moments of the fields, index l is 6 at entry 0", |l| l.moment.l[0] = 6),
    ("moments of the fields, index l has 224", |l| l.moment.l.truncate(224)),
    ("moments of the fields, index r is 9 at entry 8, expected 3 row + column below 9", |l| {
        l.moment.r[8] = 9
    }),
    ("moments of the fields, index r has 226", |l| l.moment.r.push(0)),
    ("moments of the fields holds NaN at entry 5", |l| l.moment.value[5] = f64::NAN),
    ("moments of the fields, index i has 225 entries, expected 224", |l| l.moment.value.truncate(224)),
    ("moments of the fields is out of order at entry 1", |l| l.moment.r.swap(0, 1)),
    ("moments of the fields is NaN at entry 0, expected zero or more", |l| l.moment.threshold = f64::NAN),
    ("moments of the fields is -1 at entry 1, expected zero or more", |l| l.moment.dropped_norm = -1.0),
    // Entry (0, 1, 2), and an entry whose mirror image is not there.
    ("expected the same as its mirror image", |l| l.moment.value[11] += 1e-12),
    ("expected the same as its mirror image", |l| {
        l.moment.i.remove(11);
        l.moment.l.remove(11);
        l.moment.r.remove(11);
        l.moment.value.remove(11);
    }),
    ("stiffness of the Lagrangian has 10 entries, expected 9", |l| l.stiffness.push(1.0)),
    ("stiffness of the Lagrangian holds inf at entry 8", |l| l.stiffness[8] = f64::INFINITY),
    ("stiffness of the Lagrangian is 0 at entry 3, expected a symmetric matrix", |l| l.stiffness[1] = 1.0),
    ("self_stress holds NaN at entry 0", |l| l.self_stress[0] = f64::NAN),
    ("row of quadratic terms of self-stress coordinates is 0", |l| l.self_stress.clear()),
    ("row of cubic terms of self-stress coordinates is 1", |l| l.self_stress_curve.cubic[0].0 = 1),
    ("number of self-stress coordinates is 513", |l| l.self_stress = vec![0.0; 513]),
    ("curves of points has 7 entries, expected 8", |l| drop(l.points.pop())),
    ("row of quadratic terms of curve of point 2 is 6", |l| l.points[2].quadratic[2].0 = 6),
    ("factors of cubic terms of curve of point 0 is 3", |l| l.points[0].cubic[1].1 = [0, 0, 3]),
    ("cubic terms of curve of point 1 holds NaN", |l| l.points[1].cubic[0].2 = f64::NAN),
    ("range of the amplitudes has 2 entries, expected 3", |l| l.range.truncate(2)),
    ("range of the amplitudes is 0 at entry 1, expected more than zero", |l| l.range[1] = 0.0),
    ("range of the amplitudes is -1 at entry 2", |l| l.range[2] = -1.0),
    ("range of the amplitudes holds inf at entry 0", |l| l.range[0] = f64::INFINITY),
    ("tolerance of the Lagrangian is -1 at entry 0", |l| l.tolerance = -1.0),
    ("tolerance of the Lagrangian is NaN at entry 1", |l| l.dropped_norm = f64::NAN),
];

/// The same for what bends pictures: two shapes of eight nodes.
const PICTURE_BREAKS: &[Break<PictureCurveData>] = &[
    ("shapes of the picture curve has 47 entries, expected 24", |p| p.shapes.truncate(47)),
    ("shapes of the picture curve holds NaN at entry 47", |p| p.shapes[47] = f64::NAN),
    ("row of cubic terms of picture curve is 1", |p| p.shapes.truncate(24)),
    ("row of quadratic terms of picture curve is 2", |p| p.curve.quadratic[0].0 = 2),
    ("factors of quadratic terms of picture curve is 3", |p| p.curve.quadratic[0].1 = [1, 3]),
    ("cubic terms of picture curve holds NaN", |p| p.curve.cubic[0].2 = f64::NAN),
    ("cubic terms of picture curve is out of order at entry 0", |p| p.curve.cubic[0].1 = [2, 0, 0]),
];

/// The model, and a file of it whose checksums are right.
fn assert_refused(data: &ModelData, words: &str) {
    let error = match Model::new(data.clone()) {
        Ok(_) => panic!("accepted although: {words}"),
        Err(error) => error.to_string(),
    };
    assert!(error.contains(words), "\"{error}\" should say: {words}");
    assert!(matches!(Model::from_bytes(&data.to_bytes().unwrap()), Err(FormatError::Model(_))), "{words}");
}

#[test]
fn broken_lagrangians_are_named() {
    let bytes = good().to_bytes().unwrap();
    assert_eq!(Model::from_bytes(&bytes).unwrap().data(), &good());
    for (words, spoil) in BREAKS {
        let mut data = good();
        spoil(data.lagrangian.as_mut().unwrap());
        assert_refused(&data, words);
    }
}

#[test]
fn broken_picture_curves_are_named() {
    for (words, spoil) in PICTURE_BREAKS {
        let mut data = good();
        spoil(data.picture_curve.as_mut().unwrap());
        assert_refused(&data, words);
    }
    // Without a picture there is nothing that it could bend.
    let mut data = good();
    data.picture = None;
    assert_refused(&data, "shapes of the picture curve has 48 entries, expected 0");
}

/// Limits of amplitudes and terms that were dropped are told of every mode.
#[test]
fn broken_limits_of_a_curved_manifold_are_named() {
    let curve = || CurveValidityData {
        limits: vec![0.1, 0.2, 0.3, 0.1, 0.1, 0.1, 1.0, 2.0, 3.0],
        dropped: PolynomialData { quadratic: vec![], cubic: vec![(1, [0, 1, 2], 0.5)] },
        points: vec![
            PolynomialData { quadratic: vec![(5, [0, 1], 0.1)], cubic: vec![] };
            good().points.len()
        ],
    };
    let with = |curve: CurveValidityData| {
        let mut data = good();
        data.validity = Some(ValidityData {
            modes: 0,
            fields: vec![],
            points: vec![vec![]; data.points.len()],
            amplitude: vec![0.1; 6],
            stiffening: vec![0.0; 9],
            curve: Some(curve),
            missing: Default::default(),
        });
        data
    };
    let bytes = with(curve()).to_bytes().unwrap();
    assert_eq!(Model::from_bytes(&bytes).unwrap().data(), &with(curve()));
    let breaks: &[Break<CurveValidityData>] = &[
        ("limits of the amplitudes has 8 entries, expected 9", |c| c.limits.truncate(8)),
        ("limits of the amplitudes is 0 at entry 2, expected more than zero", |c| c.limits[2] = 0.0),
        ("limits of the amplitudes holds NaN at entry 0", |c| c.limits[0] = f64::NAN),
        ("limits of the amplitudes is out of order at entry 6", |c| c.limits[8] = 1.5),
        ("row of cubic terms of dropped terms of the kinetic coordinates is 3", |c| c.dropped.cubic[0].0 = 3),
        ("factors of cubic terms of dropped terms of the kinetic coordinates is 3", |c| {
            c.dropped.cubic[0].1 = [0, 1, 3]
        }),
        ("dropped terms of points has 7 entries, expected 8", |c| drop(c.points.pop())),
        ("row of quadratic terms of dropped terms of point 2 is 6", |c| c.points[2].quadratic[0].0 = 6),
    ];
    for (words, spoil) in breaks {
        let mut broken = curve();
        spoil(&mut broken);
        assert_refused(&with(broken), words);
    }
}

/// Shapes move A in free flight alone.
#[test]
fn a_clamped_model_has_shapes_that_leave_a_where_it_is() {
    let mut data = bent(true).1;
    assert!(Model::new(data.clone()).is_ok());
    data.modes.phi_r[2] = 0.1;
    assert_refused(&data, "phi_r of a clamped structure");
}
