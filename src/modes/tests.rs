use super::*;
use rom_generator::input::Structure;

fn frame() -> Mesh {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models/fmb.toml");
    let sets = [("elements".to_owned(), "60".to_owned())];
    Structure::from_toml_path(&path, &sets).unwrap_or_else(|e| panic!("{e}")).mesh()
}

#[test]
fn the_table_names_the_symmetries() {
    let set = of_mesh(&frame(), Support::Free, 4).unwrap();
    let rows = mode_rows(&set);
    let found: Vec<&str> = rows.iter().map(|row| row.symmetry.as_str()).collect();
    let expected = [
        "symmetric yz, in xz",
        "antisymmetric yz, out of xz",
        "antisymmetric yz, in xz",
        "symmetric yz, out of xz",
    ];
    assert_eq!(found, expected);
    assert!(rows[0].mass_at_unit_displacement.unwrap() > 0.0 && rows[0].effective_mass.is_none());
    assert_eq!(table(&set).len(), 5);
    let clamped = of_mesh(&frame(), Support::Clamped, 4).unwrap();
    assert!(mode_rows(&clamped)[0].effective_mass.unwrap().iter().all(|m| *m >= 0.0));
}

/// Every coordinate is within the picture, and both shapes are drawn four times.
#[test]
fn pictures_stay_within_their_frame() {
    let mesh = frame();
    let set = of_mesh(&mesh, Support::Free, 3).unwrap();
    for k in 0..3 {
        let svg = picture(&mesh, &set, k);
        assert_eq!((svg.matches("class=\"before\"").count(), svg.matches("class=\"after\"").count()), (4, 4));
        let lines = svg.split("points=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
        for pair in lines.flat_map(str::split_whitespace) {
            let (x, y) = pair.split_once(',').unwrap();
            let (x, y): (f64, f64) = (x.parse().unwrap(), y.parse().unwrap());
            assert!((0.0..=680.0).contains(&x) && (0.0..=460.0).contains(&y), "{pair}");
        }
    }
}
