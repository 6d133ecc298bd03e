//! `romgen modes`.

use std::path::{Path, PathBuf};

use rom_generator::equilibrium::trim::About;
use rom_generator::input::Structure;
use rom_generator::mesh::Mesh;
use rom_generator::vibration::{Support, VibrationError};

use super::VERSION;
use super::structure::StructureArgs;
use crate::failure::Failure;
use crate::modes::{
    Swept, frequencies, frequency_page, frequency_plot, mode_page, mode_rows, of_mesh, picture, table,
    write_npz,
};
use crate::text::{columns, significant, vector};
use crate::validate::{Sweep, sweep};
use crate::{atomic, terminal};

#[derive(Debug, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    #[command(flatten)]
    structure: StructureArgs,
    /// Number of elastic modes, the lowest ones
    #[arg(long, default_value_t = 10, value_name = "N")]
    modes: usize,
    /// Clamp the reference node: ordinary clamped modes with their effective masses
    #[arg(long)]
    clamped: bool,
    /// Shape the modes are about where the structure has an equilibrium: equilibrium or drawing
    #[arg(long, default_value = "equilibrium", value_name = "SHAPE")]
    about: About,
    /// Follow the frequencies: load-factor=0..3:7 (of the equilibrium's loads and gravity), spin=0..20 (rad/s, of the clamped
    /// reference node about --axis), or a parameter of the structure (sigma=1,3,10)
    #[arg(long, value_name = "NAME=VALUES", value_parser = sweep)]
    sweep: Option<Sweep>,
    /// Axis of A that spin is about: x, y, z, or components between commas
    #[arg(long, default_value = "z", value_parser = axis, value_name = "AXIS")]
    axis: Axis,
    /// Folder for table, arrays, pictures and a page, made if missing [default: write nothing]
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print JSON for machines
    #[arg(long)]
    json: bool,
}

const AFTER_HELP: &str = "Examples:
  romgen modes models/fmb.toml --modes 8 --out modes
  romgen modes models/hale.toml --sweep load-factor=0..2:9 --out frequencies
  romgen modes models/ffb.toml --sweep spin=0..10 --axis y";

/// Clap would take a bare array for an option given several times.
type Axis = [f64; 3];

fn axis(text: &str) -> Result<Axis, String> {
    let named = ["x", "y", "z"].iter().position(|name| *name == text.trim());
    if let Some(k) = named {
        let mut axis = [0.0; 3];
        axis[k] = 1.0;
        return Ok(axis);
    }
    let expected = || format!("expected x, y, z or three components such as 0,1,1, found {text:?}");
    let parts: Vec<f64> = text.split(',').map_while(|part| part.trim().parse().ok()).collect();
    let axis: [f64; 3] = parts.try_into().map_err(|_| expected())?;
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(length > 0.0 && length.is_finite() && text.split(',').count() == 3) {
        return Err(expected());
    }
    Ok(axis.map(|x| x / length))
}

pub(super) fn run(args: &Args, command: String) -> Result<(), Failure> {
    let structure = args.structure.read()?;
    let mut mesh = structure.mesh();
    if let Some(trim) = &mut mesh.trim {
        trim.about = args.about;
    }
    match &args.sweep {
        None => shapes(args, &mesh, &command),
        Some(sweep) => follow(args, &structure, &mesh, sweep, &command),
    }
}

fn support(args: &Args, mesh: &Mesh) -> Support {
    let clamped = args.clamped || mesh.support == rom_generator::mesh::Support::Clamped;
    if clamped { Support::Clamped } else { Support::Free }
}

/// The shape that the modes are about, in words.
fn about(args: &Args, mesh: &Mesh) -> &'static str {
    match (&mesh.trim, args.about) {
        (Some(_), About::Equilibrium) => "about the loaded equilibrium of the structure file",
        _ => "about the drawing",
    }
}

fn tool() -> String {
    format!("romgen {VERSION}")
}

fn failed(error: VibrationError) -> Failure {
    match error {
        VibrationError::Equilibrium(_) => {
            Failure::numerical(error.to_string(), "see [equilibrium] in docs/structure-file.md")
        }
        _ => Failure::numerical(error.to_string(), "ask for fewer modes, or refine the mesh"),
    }
}

fn shapes(args: &Args, mesh: &Mesh, command: &str) -> Result<(), Failure> {
    let set = of_mesh(mesh, support(args, mesh), args.modes).map_err(failed)?;
    let rows = mode_rows(&set);
    if let Some(folder) = &args.out {
        atomic::make_folder(folder)?;
        write_json(&folder.join("modes.json"), &rows)?;
        write_npz(&set, &folder.join("modes.npz"))?;
        for k in 0..rows.len() {
            write_text(&folder.join(format!("mode-{:02}.svg", k + 1)), &picture(mesh, &set, k))?;
        }
        mode_page(mesh, &set, about(args, mesh), command, &tool()).write(&folder.join("report.html"))?;
    }
    if args.json {
        return Ok(terminal::say_json(&rows)?);
    }
    let held = if set.support == Support::Clamped { ", clamped at the reference node" } else { "" };
    let mut text = format!("{}: elastic modes {}{held}\n\n", mesh.name, about(args, mesh));
    text += &columns(&table(&set));
    if let Some(next) = set.next_omega {
        text += &format!("  the next one: {} rad/s\n", significant(next, 6));
    }
    text += &format!(
        "\n  mass {} kg, centre of mass in A {} m\n",
        significant(set.mass, 6),
        vector(set.centre_of_mass.as_slice(), 5)
    );
    if let Some(folder) = &args.out {
        text += &format!(
            "  wrote {}: report.html, modes.json, modes.npz, {} pictures\n",
            folder.display(),
            rows.len()
        );
    }
    Ok(terminal::say(&text)?)
}

fn follow(
    args: &Args,
    structure: &Structure,
    mesh: &Mesh,
    sweep: &Sweep,
    command: &str,
) -> Result<(), Failure> {
    let swept = swept(args, structure, sweep)?;
    let vary = |name: &str, value: &str| args.structure.read_with(name, value);
    let found = frequencies(&swept, mesh, args.about, support(args, mesh), args.modes, &vary)?;
    let about = match &swept {
        Swept::Spin(..) => "clamped at the reference node, on a hub that turns",
        Swept::LoadFactor(_) => "about the equilibrium under the loads times the factor",
        Swept::Parameter(..) => about(args, mesh),
    };
    if let Some(folder) = &args.out {
        atomic::make_folder(folder)?;
        write_json(&folder.join("frequencies.json"), &found)?;
        found.write_csv(&folder.join("frequencies.csv"))?;
        write_text(&folder.join("frequencies.svg"), &frequency_plot(&found).to_svg()?)?;
        frequency_page(&mesh.name, &found, about, command, &tool()).write(&folder.join("report.html"))?;
    }
    if args.json {
        return Ok(terminal::say_json(&found)?);
    }
    let mut text = format!("{}: frequencies (rad/s) {about}\n\n{}", mesh.name, columns(&found.table()));
    for remark in found.remarks() {
        text += &format!("  {remark}\n");
    }
    if let Some(folder) = &args.out {
        text += &format!(
            "\n  wrote {}: report.html, frequencies.csv, frequencies.json, frequencies.svg\n",
            folder.display()
        );
    }
    Ok(terminal::say(&text)?)
}

/// A parameter of the structure comes before the names that have a meaning here.
fn swept(args: &Args, structure: &Structure, sweep: &Sweep) -> Result<Swept, Failure> {
    let Sweep::Parameter(name, values) = sweep else {
        return Err(Failure::input(
            "modes and about cannot be swept here",
            "sweep load-factor, spin or a parameter; see --modes and --about",
        ));
    };
    if structure.parameters().iter().any(|(n, _)| n == name) {
        return Ok(Swept::Parameter(name.clone(), values.clone()));
    }
    let numbers = || {
        let number = |v: &String| {
            v.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| {
                Failure::input(
                    format!("expected numbers for {name}, found {v:?}"),
                    "give numbers such as 0..3:7",
                )
            })
        };
        values.iter().map(number).collect::<Result<Vec<f64>, Failure>>()
    };
    match name.as_str() {
        "load-factor" => Ok(Swept::LoadFactor(numbers()?)),
        "spin" => Ok(Swept::Spin(numbers()?, args.axis)),
        _ => {
            let names: Vec<&str> = structure.parameters().iter().map(|(n, _)| n.as_str()).collect();
            let message = format!("the structure has no parameter {name:?}");
            Err(Failure::input(message, format!("sweep load-factor, spin or one of: {}", names.join(", "))))
        }
    }
}

fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(std::io::Error::from)?;
    write_text(path, &(text + "\n"))
}

fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    Ok(atomic::write(path, |sink| sink.write_all(text.as_bytes()))?)
}
