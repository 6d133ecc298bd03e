//! The structure file: TOML text to a validated structure, and from there to a [`Mesh`].
//!
//! Reading goes in four steps: syntax, parameters (`parameters`), keys and shapes of values (`read`, `file`), and what they
//! mean together (`resolve`). All that can be found wrong is reported at once. Only then is anything meshed, which cannot
//! fail. `docs/structure-file.md` is the reference for users.

mod case;
mod course;
mod damping;
mod diagnostic;
mod distributed;
mod equilibrium;
mod expression;
mod file;
mod internal_loads;
mod loads;
mod members;
mod outputs;
mod parameters;
mod program;
mod read;
mod reduction;
mod resolve;
mod section;
mod stations;
mod times;
mod values;

use std::path::Path;
use std::sync::Arc;

use nalgebra::Matrix3;
use rom_runtime::data::{LineData, PointData};
use rom_runtime::loads::LoadCase;
use toml::de::{DeTable, DeValue};

pub use diagnostic::{Diagnostic, InputErrors};

use crate::build::Reduction;
use crate::mesh::plan::Plan;
use crate::mesh::{self, Mesh};
use diagnostic::{Source, Span};
use parameters::Parameters;
use read::{Fields, Reader, table};
use values::Named;

/// What to say where a table is missing.
const TABLES: &str = "a structure file has tables [structure], [sections], [points] and [[members]]";

/// Largest file read, bytes.
const LARGEST_FILE: usize = 16 << 20;

/// A structure that has passed every check.
#[derive(Clone, Debug)]
pub struct Structure {
    source: Arc<Source>,
    description: String,
    parameters: Vec<(String, f64)>,
    sets: Vec<(String, String)>,
    reduction: Reduction,
    plan: Plan,
}

impl Structure {
    /// Reads a structure file. `sets` are the `--set name=expression` of the command line.
    pub fn from_toml_path(path: &Path, sets: &[(String, String)]) -> Result<Self, InputErrors> {
        Self::from_toml_str(&read_text(path)?, &path.display().to_string(), sets)
    }

    /// Reads the text of a structure file; `file_name` is only used in messages.
    pub fn from_toml_str(
        text: &str,
        file_name: &str,
        sets: &[(String, String)],
    ) -> Result<Self, InputErrors> {
        let source = Arc::new(Source { name: file_name.to_owned(), text: text.to_owned() });
        let table = parse(&source, TABLES)?;
        let mut errors = Vec::new();
        let parameters = read_parameters(&table, &source, sets, &Parameters::default(), &mut errors);
        let mut reader = Reader::new(&source, &parameters, errors);
        let whole = Span { start: 0, end: 0 };
        let file = file::StructureFile::read_fields(Fields::new(&table, whole), &mut reader);
        let plan = file.as_ref().and_then(|file| resolve::resolve(file, &mut reader));
        let description = file.and_then(|f| f.structure.0).and_then(|head| head.description);
        match plan {
            Some((plan, reduction)) if reader.errors.is_empty() => Ok(Self {
                source,
                description: description.map_or(String::new(), |d| d.value),
                parameters: parameters.list(),
                sets: sets.to_vec(),
                reduction,
                plan,
            }),
            _ => Err(errors_of(reader)),
        }
    }

    /// Nodes, elements, masses, points and load cases.
    pub fn mesh(&self) -> Mesh {
        mesh::build(&self.plan)
    }

    /// Name of the structure.
    pub fn name(&self) -> &str {
        &self.plan.name
    }

    /// What its author says about it; may be empty.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The file, verbatim.
    pub fn text(&self) -> &str {
        &self.source.text
    }

    /// The name given to the file.
    pub fn file_name(&self) -> &str {
        &self.source.name
    }

    /// Names and values of the parameters, `--set` applied, in the order of the file.
    pub fn parameters(&self) -> &[(String, f64)] {
        &self.parameters
    }

    /// The `--set` names and expressions it was read with.
    pub fn sets(&self) -> &[(String, String)] {
        &self.sets
    }

    /// What the file says about its reduction.
    pub fn reduction(&self) -> &Reduction {
        &self.reduction
    }

    /// What a file of load cases refers to in this structure.
    pub fn point_table(&self) -> PointTable {
        let points = self.plan.points.iter().map(|p| (p.name.clone(), p.sections.clone())).collect();
        let lines = resolve::lines(&self.plan.members);
        PointTable { points, lines, parameters: self.parameters.clone() }
    }

    /// Number of elements its mesh has.
    pub fn element_count(&self) -> usize {
        self.plan.members.iter().map(mesh::plan::MemberPlan::element_count).sum()
    }
}

/// Section frames `E` at a node, by the name of the member.
pub type SectionFrames = Vec<(String, Matrix3<f64>)>;

/// What a load-case file of its own refers to in a model.
#[derive(Clone, Debug, Default)]
pub struct PointTable {
    /// Named points in the model's order, each with the members that meet at its node.
    pub points: Vec<(String, SectionFrames)>,
    /// Members in the model's order, for distributed loads.
    pub lines: Vec<Line>,
    /// The model's parameters: name, value.
    pub parameters: Vec<(String, f64)>,
}

/// The axis of a member that a distributed load refers to.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name of the member.
    pub name: String,
    /// Length, m.
    pub length: f64,
    /// Ends of its elements as fractions of the length, ascending from 0 to 1.
    pub knots: Vec<f64>,
    /// Whether the model can carry loads along it.
    pub carries: bool,
}

impl PointTable {
    /// From what a model file holds.
    pub fn new(points: &[PointData], lines: &[LineData], parameters: &[(String, f64)]) -> Self {
        let frame = |e: &[[f64; 3]; 3]| Matrix3::from_fn(|i, j| e[i][j]);
        let sections =
            |p: &PointData| p.sections.iter().map(|(member, e)| (member.clone(), frame(e))).collect();
        Self {
            points: points.iter().map(|p| (p.name.clone(), sections(p))).collect(),
            lines: lines
                .iter()
                .map(|line| Line {
                    name: line.name.clone(),
                    length: line.length,
                    knots: line.knots.clone(),
                    carries: !line.stations.is_empty(),
                })
                .collect(),
            parameters: parameters.to_vec(),
        }
    }

    /// Index of a point that another place refers to.
    fn find(&self, name: &values::Text, reader: &mut Reader) -> Option<usize> {
        let found = self.points.iter().position(|(n, _)| *n == name.value);
        if found.is_none() {
            let help =
                diagnostic::suggest(&name.value, "points", self.points.iter().map(|(n, _)| n.as_str()));
            let message = format!("there is no point `{}`", name.value.escape_debug());
            return reader.error_help(name.span, message, help);
        }
        found
    }
}

table! {
    /// A file of load cases for a model that has been built.
    LoadCasesFile {
        /// Numbers by name for use in expressions; the parameters of the model are known too.
        parameters: Option<file::ParametersFile>,
        /// Time functions by name.
        times: Option<Named<times::TimeFile>>,
        /// Load cases by name.
        load_cases: Named<loads::LoadCaseFile>,
    }
}

/// Reads a file of load cases for a model. `sets` override the parameters of this file; those of the model are fixed.
pub fn read_load_cases(
    text: &str,
    file_name: &str,
    points: &PointTable,
    sets: &[(String, String)],
) -> Result<Vec<LoadCase>, InputErrors> {
    let source = Arc::new(Source { name: file_name.to_owned(), text: text.to_owned() });
    let table = parse(&source, "a file of load cases has tables like [load_cases.gust]")?;
    let mut errors = Vec::new();
    let given = Parameters::known(&points.parameters);
    let parameters = read_parameters(&table, &source, sets, &given, &mut errors);
    let mut reader = Reader::new(&source, &parameters, errors);
    let whole = Span { start: 0, end: 0 };
    let file = LoadCasesFile::read_fields(Fields::new(&table, whole), &mut reader);
    let cases = file.map(|file| {
        let no_times = Named::default();
        let times = file.times.as_ref().unwrap_or(&no_times);
        if file.load_cases.items.is_empty() {
            reader.error::<()>(whole, "this file has no load case");
        }
        let context = loads::LoadContext::new(times, points, &mut reader);
        loads::resolve_load_cases(&file.load_cases, &context, &mut reader)
    });
    match cases {
        Some(cases) if reader.errors.is_empty() => Ok(cases),
        _ => Err(errors_of(reader)),
    }
}

/// Reads a text file of either kind, with the limits of an input.
pub fn read_text(path: &Path) -> Result<String, InputErrors> {
    let fail = |message: String, help: Option<String>| {
        let source = Arc::new(Source { name: path.display().to_string(), text: String::new() });
        InputErrors::new(vec![Diagnostic::new(&source, Span { start: 0, end: 0 }, message, help)])
    };
    let bytes = read_limited(path).map_err(|e| fail(format!("the file cannot be read: {e}"), None))?;
    if bytes.len() > LARGEST_FILE {
        let message = format!("the file is larger than {} MiB, the most that is read", LARGEST_FILE >> 20);
        return Err(fail(message, None));
    }
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let help =
            "a structure file is TOML text; a model file is read by romrun and `romgen info`".to_owned();
        fail(format!("the file is not UTF-8 text: byte {at} starts no character"), Some(help))
    })
}

/// One byte more than the limit tells that it is exceeded; also for devices and pipes, which have no length.
fn read_limited(path: &Path) -> std::io::Result<Vec<u8>> {
    use std::io::Read as _;
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(LARGEST_FILE as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The TOML tree with places, or what is wrong with the syntax.
fn parse<'a>(source: &'a Arc<Source>, expected: &str) -> Result<DeTable<'a>, InputErrors> {
    /// After a few, further syntax errors only follow from the first.
    const MOST: usize = 5;
    let text = &source.text;
    let error =
        |span: Span, message: String, help: Option<String>| Diagnostic::new(source, span, message, help);
    let whole = Span { start: 0, end: 0 };
    if text.len() > LARGEST_FILE {
        let message = format!("the text is larger than {} MiB, the most that is read", LARGEST_FILE >> 20);
        return Err(InputErrors::new(vec![error(whole, message, None)]));
    }
    if text.trim().is_empty() {
        return Err(InputErrors::new(vec![error(
            whole,
            "the file is empty".into(),
            Some(expected.to_owned()),
        )]));
    }
    let describe = |e: toml::de::Error| {
        let span = e.span().map_or(whole, Span::from);
        // What TOML says about a word without quotes does not lead there.
        let word = e.message().starts_with("invalid boolean");
        let help = word.then(|| "a text or an expression is written in quotes".to_owned());
        error(span, format!("not valid TOML: {}", e.message()), help)
    };
    match DeTable::parse(text) {
        Ok(table) => Ok(table.into_inner()),
        Err(first) if text.len() > 1 << 20 => Err(InputErrors::new(vec![describe(first)])),
        Err(_) => {
            let (_, all) = DeTable::parse_recoverable(text);
            Err(InputErrors::new(all.into_iter().take(MOST).map(describe).collect()))
        }
    }
}

fn errors_of(mut reader: Reader) -> InputErrors {
    if reader.errors.is_empty() {
        // Every failure reports itself; should one not, the input is refused all the same.
        reader.error::<()>(Span { start: 0, end: 0 }, "this input could not be read");
    }
    InputErrors::new(reader.errors)
}

fn read_parameters(
    table: &DeTable,
    source: &Arc<Source>,
    sets: &[(String, String)],
    given: &Parameters,
    errors: &mut Vec<Diagnostic>,
) -> Parameters {
    let mut list = Vec::new();
    match table.get("parameters").map(|node| (node, node.get_ref())) {
        None => {}
        Some((_, DeValue::Table(entries))) => {
            for (key, node) in read::entries(entries) {
                match read::written(node) {
                    Some(written) => {
                        let place = read::place(node, source);
                        list.push((key.get_ref().to_string(), key.span().into(), written, place));
                    }
                    None => {
                        let message = format!(
                            "parameter `{}` is no number: expected {}",
                            key.get_ref().escape_debug(),
                            values::NUMBER
                        );
                        errors.push(Diagnostic::new(source, node.span().into(), message, None));
                    }
                }
            }
        }
        Some((node, _)) => {
            let message = "`parameters` is no table".to_owned();
            let help = "[parameters] then lines like sigma = 10".to_owned();
            errors.push(Diagnostic::new(source, node.span().into(), message, Some(help)));
        }
    }
    Parameters::resolve(list, sets, given, errors)
}

/// JSON Schema (draft 2020-12) of the structure file, for editors.
pub fn schema() -> String {
    let settings = schemars::generate::SchemaSettings::draft2020_12()
        .with_transform(schemars::transform::RecursiveTransform(without_null));
    let mut schema = settings.into_generator().into_root_schema_for::<file::StructureFile>();
    schema.insert("title".into(), "Structure file".into());
    serde_json::to_string_pretty(&schema).unwrap_or_default()
}

/// TOML has no null: an optional key is there or not.
fn without_null(schema: &mut schemars::Schema) {
    let null = serde_json::json!({ "type": "null" });
    if let Some(choices) = schema.get_mut("anyOf").and_then(|v| v.as_array_mut()) {
        choices.retain(|choice| *choice != null);
        if let [serde_json::Value::Object(only)] = &choices[..] {
            let only = only.clone();
            schema.remove("anyOf");
            for (key, value) in only {
                // What is said about the key comes before what is said about its type.
                if schema.get(&key).is_none() {
                    schema.insert(key, value);
                }
            }
        }
    }
    if let Some(types) = schema.get_mut("type").and_then(|v| v.as_array_mut()) {
        types.retain(|name| name != "null");
        if let [only] = &types[..] {
            let only = only.clone();
            schema.insert("type".into(), only);
        }
    }
}
