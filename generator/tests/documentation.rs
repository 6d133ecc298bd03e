//! The user's reference of the structure file: its examples are sound and it names every key there is.

use rom_generator::input::{Structure, read_load_cases, schema};
use rom_generator::{Elastic, ModeSelection};
use serde_json::Value;

const TEXT: &str = include_str!("../../docs/structure-file.md");

fn examples() -> Vec<&'static str> {
    TEXT.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

#[test]
fn examples_are_sound() {
    let [t_beam, _link, distributed, starts, stations, internal, reduction, blade, loads] = examples()[..]
    else {
        panic!("nine examples")
    };
    let read = |text| Structure::from_toml_str(text, "example", &[]).unwrap_or_else(|e| panic!("{e}"));
    let structure = read(t_beam);
    let mesh = structure.mesh();
    assert_eq!((mesh.elements.len(), mesh.nodes.len(), mesh.lumped.len()), (50, 51, 1));
    // Lift carries the weight: follower loads at the bent tips have to push a little harder.
    let trim = rom_generator::equilibrium::trim::of_mesh(&mesh).unwrap().unwrap();
    let weight = 9.81 * rom_generator::reference::method::Prepared::new(mesh.clone()).rigid_mass().0;
    let factor = trim.factors[0].1 * 200.0 / weight;
    assert!(factor > 1.0 && factor < 1.02, "{factor}");
    // Follower loads on the spar push up: local z is global z.
    let tip = mesh.points.iter().find(|p| p.name == "right").unwrap();
    assert!((tip.sections[0].1.column(2)[2] - 1.0).abs() < 1e-15);
    assert_eq!(read(blade).mesh().nodes.len(), 37);
    let table = structure.point_table();
    let cases = read_load_cases(loads, "example", &table, &[]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(cases[0].loads.len(), 2);
    let spread = format!("[load_cases.spread]\nt_end = 1\ndt = 0.1\n{distributed}");
    let cases = read_load_cases(&spread, "example", &table, &[]).unwrap_or_else(|e| panic!("{e}"));
    // From 0.2 to 0.4 of 4 m.
    let weight: f64 = cases[0].distributed[1].force.chunks(3).map(|f| f[2]).sum();
    assert!((weight + 5.0 * 0.8).abs() < 1e-13, "{weight}");
    let cases = read_load_cases(starts, "example", &table, &[]).unwrap_or_else(|e| panic!("{e}"));
    assert!(cases[0].motion.is_some() && cases[1].initial.is_some());
    let root = internal.replace("left wing", "spar");
    let wings = stations.replace("\"left wing\", \"right wing\"", "\"spar\"");
    let structure = read(&format!("{t_beam}{wings}{root}{reduction}"));
    let mesh = structure.mesh();
    let options = structure.reduction().clone().options(false);
    assert_eq!((options.modes, options.elastic), (ModeSelection::Count(20), Elastic::Geometric));
    assert_eq!((mesh.cuts[0].name.as_str(), mesh.cuts[0].fraction), ("root", 0.0));
    let y: Vec<f64> = mesh.stations[0].stations.iter().map(|s| s.offset.y).collect();
    assert!(y.len() == 20 && (y[0] - (0.25 - 0.15 * 0.025)).abs() < 1e-12, "{y:?}");
}

#[test]
fn every_key_and_word_is_in_the_reference() {
    fn walk(schema: &Value, words: &mut Vec<String>) {
        for (key, rule) in schema["properties"].as_object().into_iter().flatten() {
            words.push(key.clone());
            words.extend(rule["const"].as_str().map(str::to_owned));
        }
        for rule in schema["oneOf"].as_array().into_iter().flatten() {
            words.extend(rule["const"].as_str().map(str::to_owned));
        }
        match schema {
            Value::Object(map) => map.values().for_each(|inner| walk(inner, words)),
            Value::Array(list) => list.iter().for_each(|inner| walk(inner, words)),
            _ => {}
        }
    }
    let mut words = Vec::new();
    walk(&serde_json::from_str(&schema()).unwrap(), &mut words);
    assert!(words.len() > 80 && words.contains(&"follower".to_owned()), "{words:?}");
    for word in words {
        let forms =
            [format!("`{word}`"), format!("`\"{word}\"`"), format!("`[{word}"), format!("`[[{word}]]`")];
        assert!(forms.iter().any(|form| TEXT.contains(form)), "`{word}` is not in docs/structure-file.md");
    }
}
