//! The JSON Schema says what the reader does: published models conform, what the reader refuses for its shape does not.

use rom_generator::input::{Structure, schema};
use serde_json::{Map, Value, json};

/// The part of JSON Schema 2020-12 that the structure file's uses; anything else in it is an error.
fn conforms(value: &Value, schema: &Value, root: &Value) -> bool {
    schema.as_object().unwrap().iter().all(|(key, rule)| match key.as_str() {
        "$schema" | "$defs" | "title" | "description" => true,
        "$ref" => {
            let name = rule.as_str().unwrap().strip_prefix("#/$defs/").unwrap();
            conforms(value, &root["$defs"][name], root)
        }
        "type" => match rule {
            Value::Array(names) => names.iter().any(|name| is(value, name.as_str().unwrap())),
            name => is(value, name.as_str().unwrap()),
        },
        "const" => value == rule,
        "enum" => rule.as_array().unwrap().contains(value),
        "minimum" => value.as_f64().is_none_or(|x| x >= rule.as_f64().unwrap()),
        "maximum" => value.as_f64().is_none_or(|x| x <= rule.as_f64().unwrap()),
        "anyOf" => rule.as_array().unwrap().iter().any(|s| conforms(value, s, root)),
        "oneOf" => rule.as_array().unwrap().iter().filter(|s| conforms(value, s, root)).count() == 1,
        "items" => value.as_array().is_none_or(|list| list.iter().all(|item| conforms(item, rule, root))),
        "minItems" => value.as_array().is_none_or(|list| list.len() as u64 >= rule.as_u64().unwrap()),
        "maxItems" => value.as_array().is_none_or(|list| list.len() as u64 <= rule.as_u64().unwrap()),
        "required" => value
            .as_object()
            .is_none_or(|o| rule.as_array().unwrap().iter().all(|k| o.contains_key(k.as_str().unwrap()))),
        "properties" => value.as_object().is_none_or(|o| {
            o.iter().all(|(key, item)| rule.get(key).is_none_or(|rule| conforms(item, rule, root)))
        }),
        "additionalProperties" => value.as_object().is_none_or(|o| {
            let known = schema.get("properties").and_then(Value::as_object).cloned().unwrap_or(Map::new());
            o.iter().filter(|(key, _)| !known.contains_key(*key)).all(|(_, item)| match rule {
                Value::Bool(allowed) => *allowed,
                rule => conforms(item, rule, root),
            })
        }),
        other => panic!("the schema uses {other}"),
    })
}

fn is(value: &Value, name: &str) -> bool {
    match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        other => panic!("the schema uses type {other}"),
    }
}

fn json_of(toml: &str) -> Value {
    serde_json::to_value(toml::from_str::<toml::Table>(toml).unwrap()).unwrap()
}

#[test]
fn every_key_is_described() {
    fn walk(schema: &Value, path: &str) {
        for (key, rule) in schema["properties"].as_object().into_iter().flatten() {
            let described = rule.get("description").is_some() || rule.get("const").is_some();
            assert!(described, "{path}/{key} has no description");
        }
        for (key, inner) in schema.as_object().into_iter().flatten() {
            walk(inner, &format!("{path}/{key}"));
        }
        for (index, inner) in schema.as_array().into_iter().flatten().enumerate() {
            walk(inner, &format!("{path}/{index}"));
        }
    }
    let schema: Value = serde_json::from_str(&schema()).unwrap();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    assert!(!schema.to_string().contains("null"));
    walk(&schema, "");
}

#[test]
fn published_models_conform() {
    let schema: Value = serde_json::from_str(&schema()).unwrap();
    for text in [include_str!("../../models/fmb.toml"), include_str!("../../models/ffb.toml")] {
        assert!(conforms(&json_of(text), &schema, &schema));
    }
}

/// One change at a time to a sound structure: schema and reader agree on whether it has the right shape.
#[test]
fn schema_and_reader_agree() {
    let schema: Value = serde_json::from_str(&schema()).unwrap();
    let base = include_str!("../../models/fmb.toml");
    for (from, to, sound) in [
        ("reference = \"A\"", "reference = \"A\"\nx = 1", false),
        ("reference = \"A\"\n", "", false),
        ("nu = 0.3", "nu = \"3/10\"", true),
        ("nu = 0.3", "nu = true", false),
        ("shape = \"rectangle\"", "shape = \"rect\"", false),
        ("shape = \"rectangle\"\n", "", false),
        ("width_y = \"b\"", "diameter = \"b\"", false),
        ("shear_factors = [\"5/6\", \"5/6\"]\n", "", true),
        ("shear_factors = [\"5/6\", \"5/6\"]", "shear_factors = [1]", false),
        ("element_nodes = 2", "element_nodes = 3", true),
        ("element_nodes = 2", "element_nodes = 4", false),
        ("P = [10, 0, 5]", "P = [10, 0]", false),
        ("P = [10, 0, 5]", "P = \"A\"", false),
        ("{ linked_to = \"A\", offset", "{ linked_to = \"A\", x = 1, offset", false),
        (
            "{ linked_to = \"A\", offset = [0, 0, \"5/6\"] }",
            "{ member = \"right arm\", fraction = 0.5 }",
            true,
        ),
        ("[times.F]\nshape = \"ramp\"", "[times.F]\nshape = \"step\"", false),
        ("[times.F]\nshape = \"ramp\"\nrate = \"rate\"\nend = 10 # s", "[times.F]\nexpression = \"t\"", true),
        ("[times.F]\nshape = \"ramp\"", "[times.F]\nexpression = \"t\"\nshape = \"ramp\"", false),
        ("t_end = 80", "t_end = []", false),
        ("[times.F]", "[reduction]\nmodes = [1, 3]\nresidual = \"all\"\n[times.F]", true),
        ("[times.F]", "[reduction]\nmodes = 0\nresidual = [\"P\"]\n[times.F]", true),
        ("[times.F]", "[reduction]\nmodes = \"60Hz\"\ninertia = \"consistent\"\n[times.F]", true),
        ("[times.F]", "[reduction]\nmodes = true\n[times.F]", false),
        ("[times.F]", "[reduction]\nelastic = \"cubic\"\n[times.F]", false),
        ("description = \"Dead couples at tips and corners\"", "description = 5", false),
    ] {
        assert_eq!(base.matches(from).count(), 1, "{from:?}");
        let text = base.replace(from, to);
        assert_eq!(Structure::from_toml_str(&text, "fmb.toml", &[]).is_ok(), sound, "reader: {to:?}");
        assert_eq!(conforms(&json_of(&text), &schema, &schema), sound, "schema: {to:?}");
    }
    assert!(!conforms(&json!({}), &schema, &schema));
}
