//! `romgen check` and `romgen schema`, and the arguments of every command that reads a structure file.

use std::path::PathBuf;

use rom_generator::input::{self, Structure};
use rom_generator::mesh::Mesh;
use serde_json::json;

use crate::failure::Failure;
use crate::text::{columns, significant, thousands};
use crate::{describe, options, terminal};

/// A structure file and what is changed in it.
#[derive(Debug, clap::Args)]
pub(super) struct StructureArgs {
    /// Structure file
    #[arg(value_name = "STRUCTURE.toml")]
    structure: PathBuf,
    /// Give a parameter of the file another value; repeatable
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = options::assignment)]
    sets: Vec<(String, String)>,
}

impl StructureArgs {
    /// Reads and checks the file.
    pub(super) fn read(&self) -> Result<Structure, Failure> {
        Ok(Structure::from_toml_path(&self.structure, &self.sets)?)
    }

    /// The file with one parameter more changed.
    pub(super) fn read_with(&self, name: &str, value: &str) -> Result<Structure, Failure> {
        let mut sets: Vec<_> = self.sets.iter().filter(|(n, _)| n != name).cloned().collect();
        sets.push((name.to_owned(), value.to_owned()));
        Ok(Structure::from_toml_path(&self.structure, &sets)?)
    }

    /// The file, for names derived from it.
    pub(super) fn path(&self) -> &std::path::Path {
        &self.structure
    }
}

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct CheckArgs {
    #[command(flatten)]
    structure: StructureArgs,
    /// Print what is in it as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing but errors (and JSON, if asked for)
    #[arg(long, short)]
    quiet: bool,
}

const EXAMPLES: &str = "Examples:
  romgen check models/fmb.toml
  romgen check models/fmb.toml --set sigma=30 --quiet && echo sound";

pub(super) fn check(args: &CheckArgs) -> Result<(), Failure> {
    let structure = args.structure.read()?;
    let mesh = structure.mesh();
    if args.json {
        terminal::say_json(&summary(&structure, &mesh))?;
        return Ok(());
    }
    if args.quiet {
        return Ok(());
    }
    let mut text = format!("{} is sound: {}\n", structure.file_name(), structure.name());
    if !structure.description().is_empty() {
        text.push_str(&format!("{}\n", structure.description()));
    }
    text.push_str(&format!(
        "  {} members, {} elements, {} nodes, {} lumped masses, {} named points\n",
        thousands(mesh.members.len() as f64),
        thousands(mesh.elements.len() as f64),
        thousands(mesh.nodes.len() as f64),
        thousands(mesh.lumped.len() as f64),
        thousands(mesh.points.len() as f64)
    ));
    let parameters: Vec<String> = structure
        .parameters()
        .iter()
        .map(|(name, value)| format!("{name} = {}", significant(*value, 12)))
        .collect();
    if !parameters.is_empty() {
        text.push_str(&format!("  parameters: {}\n", parameters.join(", ")));
    }
    if !mesh.load_cases.is_empty() {
        text.push('\n');
        text.push_str(&columns(&describe::load_case_rows(&mesh.load_cases)));
    }
    terminal::say(&text)?;
    Ok(())
}

/// What `--json` prints.
fn summary(structure: &Structure, mesh: &Mesh) -> serde_json::Value {
    json!({
        "file": structure.file_name(),
        "name": structure.name(),
        "description": structure.description(),
        "members": mesh.members.len(),
        "elements": mesh.elements.len(),
        "nodes": mesh.nodes.len(),
        "lumped_masses": mesh.lumped.len(),
        "points": mesh.points.iter().map(|p| &p.name).collect::<Vec<_>>(),
        "parameters": structure.parameters(),
        "load_cases": mesh.load_cases.iter().map(|c| &c.name).collect::<Vec<_>>(),
    })
}

pub(super) fn schema() -> Result<(), Failure> {
    terminal::say(&(input::schema() + "\n"))?;
    Ok(())
}
