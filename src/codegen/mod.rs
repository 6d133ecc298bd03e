//! A model as one self-contained C99 file: constant tables and a step, for targets without a file system or memory to hand out.
//!
//! The mechanics is text that is the same for every model (`kernel.c`, `step.c`, `motion.c`, `sections.c`), steered by macros; what is written here
//! are the tables of the model, its load case and what the head of the file says.

mod loads;
mod number;
mod sections;
mod tables;

use std::fmt::Write;

use rom_runtime::data::{DampingData, GravityData, ModelData, ModesData, RigidData, TrimData};
use rom_runtime::{Integrator, LoadCase, Method, Model};

use number::Scalar;
use tables::Tables;

/// What to write.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// The model of the file.
    pub model: &'a Model,
    /// Method by which it runs.
    pub method: Method,
    /// Time step, s.
    pub dt: f64,
    /// Load case that is written into the file.
    pub case: Option<&'a LoadCase>,
    /// Named points kept, by index; those of loads and sensors are kept anyway.
    pub points: Vec<usize>,
    /// Places of internal loads told, by index.
    pub sections: Vec<usize>,
    /// Single precision.
    pub float: bool,
    /// Begins every name that other files can see.
    pub prefix: &'a str,
    /// Tool and version.
    pub tool: &'a str,
}

/// The C file.
///
/// # Errors
/// What the file cannot hold, and a time step that is too long, in words.
pub fn write(request: &Request) -> Result<String, String> {
    every_part_is_written(request.model.data())?;
    if request.case.is_some_and(|case| case.motion.is_some()) {
        return Err(
            "the load case moves frame A; the generated step is in free flight: take another with --loads"
                .to_owned(),
        );
    }
    let model = request.model.with_method(request.method).map_err(|e| e.to_string())?;
    check_step(&model, request.dt)?;
    let scalar = Scalar { float: request.float };
    let tables = Tables::new(request, &model, scalar)?;
    let mut text = head(request, &model, &tables);
    text += &declarations(request, &tables);
    text += "\n#ifndef ROM_DECLARATIONS_ONLY\n\n/* ---- The model. ---- */\n\n";
    text += &tables.to_text();
    text += "\n";
    text += include_str!("kernel.c");
    text += &loads::function(&tables, scalar)?;
    text += include_str!("step.c");
    text += include_str!("motion.c");
    text += include_str!("sections.c");
    text += "\n#endif /* ROM_DECLARATIONS_ONLY */\n";
    Ok(prefixed(&text, request.prefix))
}

fn check_step(model: &Model, dt: f64) -> Result<(), String> {
    if !(dt > 0.0 && dt.is_finite()) {
        return Err(format!("the time step is {dt} s, expected a finite number of seconds, more than zero"));
    }
    match Integrator::Rk4.stable_dt(model) {
        Some(limit) if dt > limit.dt => Err(format!(
            "time step {dt} s is too long for the explicit RK4 of the generated step: mode {} at {} rad/s needs at most {} s",
            limit.mode, limit.omega, limit.dt
        )),
        _ => Ok(()),
    }
}

/// Every field is here by name: one that changes a step has to be written into the file, or refused.
fn every_part_is_written(data: &ModelData) -> Result<(), String> {
    let ModelData {
        provenance: _,
        rigid,
        modes,
        c: _,
        k: _,
        points: _,
        load_cases: _,
        picture: _,
        picture_curve: _,
        trim,
        sensors: _,
        gravity,
        lines: _,
        lagrangian,
        damping,
        clamped,
        residual: _,
        validity: _,
        selection: _,
        // A block of stations is an interface to a host; the generated step takes loads on points.
        stations: _,
        cuts: _,
        checks: _,
    } = data;
    let RigidData { mass: _, centre_of_mass: _, mass_matrix: _, initial_position: _ } = rigid;
    let ModesData {
        number: _,
        omega: _,
        mass: _,
        damping_ratio: _,
        phi_r: _,
        first_moment: _,
        kinetic_share: _,
        next_omega: _,
    } = modes;
    if let Some(trim) = trim {
        let TrimData {
            loads: _,
            distributed: _,
            elastic_force: _,
            elastic_energy: _,
            attitude: _,
            factors: _,
            load_names: _,
            reaction: _,
            scales: _,
            displacements: _,
            effort: _,
        } = trim;
    }
    if let Some(gravity) = gravity {
        let GravityData { acceleration: _, second_moment: _ } = gravity;
    }
    if let Some(damping) = damping {
        let DampingData { coupling: _ } = damping;
    }
    if clamped.is_some() {
        return Err(
            "C source of clamped structures is not written: the generated step is in free flight".to_owned()
        );
    }
    if lagrangian.is_some() {
        return Err(
            "C source of models with consistent inertia is not written; build it with --inertia constant"
                .to_owned(),
        );
    }
    Ok(())
}

fn head(request: &Request, model: &Model, tables: &Tables) -> String {
    let provenance = &model.data().provenance;
    let mut text = format!(
        "/* {}: reduced-order model with {} elastic modes, method {}, in C99. Written by {}; do not edit.\n *\n",
        comment(&provenance.name),
        model.n_modes(),
        request.method,
        comment(request.tool)
    );
    let _ = writeln!(text, " * SHA-256 of the structure file: {}", comment(&provenance.input_sha256));
    for (name, value) in &provenance.parameters {
        let _ = writeln!(text, " * parameter {} = {value}", comment(name));
    }
    let loads = match request.case {
        Some(case) => format!("load case {}, and those of the host", comment(&case.name)),
        None if model.data().trim.is_some() => "those of the equilibrium, and those of the host".to_owned(),
        None => "those of the host".to_owned(),
    };
    let _ = writeln!(text, " * Loads: {loads}.");
    text += HEAD;
    let _ = writeln!(text, " *\n * Points: {}.", tables.point_names().join(", "));
    let _ = writeln!(text, " * Sensors: {}.", tables.sensor_names().join(", "));
    let _ = writeln!(text, " * Internal loads: {}.\n */\n", tables.section_names().join(", "));
    text
}

/// The same for every file.
const HEAD: &str = "\
 *
 *     static rom_loads loads;                        all zero: no loads of the host
 *     rom_state state;
 *     rom_init(&state);
 *     for (;;) {
 *         loads.point[ROM_POINT_..].body_force[2] = ..;
 *         if (rom_step(&state, &loads) != 0)
 *             ..;                                    not finite any more: the state is the one before
 *         rom_rigid_output(&state, &rigid);
 *     }
 *
 * One time step is ROM_DT, by the explicit Runge-Kutta method of fourth order; loads of the host are held over it. A step allocates
 * nothing, calls nothing but <math.h>, and does the same work whatever the state (but for series or closed forms of rotations
 * beyond one radian, and the branches of time functions). All memory is on the stack and in constant tables; a state is plain data:
 * a copy of it is a snapshot.
 *
 * In another file: #define ROM_DECLARATIONS_ONLY, then include this one. SI units, radians. Frames: G inertial, A on the reference
 * node of the structure. Quaternions are scalar first, components in A to components in G. Contraction to fused multiply-add
 * (-ffp-contract=fast) changes the last digits.
";

fn declarations(request: &Request, tables: &Tables) -> String {
    let scalar = Scalar { float: request.float };
    let mut text = String::from("#ifndef ROM_DECLARED\n#define ROM_DECLARED\n\n#include <math.h>\n\n");
    let _ = writeln!(text, "typedef {} rom_real;", if request.float { "float" } else { "double" });
    let _ = writeln!(text, "#define ROM_MODES {}", tables.n_modes());
    let _ = writeln!(text, "#define ROM_MODES_OR_ONE {}", tables.n_modes().max(1));
    let _ = writeln!(text, "#define ROM_POINTS {}", tables.n_points());
    let _ = writeln!(text, "#define ROM_POINTS_OR_ONE {}", tables.n_points().max(1));
    let _ = writeln!(text, "#define ROM_SENSORS {}", tables.n_sensors());
    let _ = writeln!(text, "#define ROM_SECTIONS {}", tables.sections.len());
    let _ = writeln!(text, "#define ROM_DT {} /* s */", scalar.literal(request.dt));
    let sections = tables.section_names();
    let named = [("POINT", tables.point_names()), ("SENSOR", tables.sensor_names()), ("SECTION", &sections)];
    for (kind, names) in named {
        for (index, name) in identifiers(names).into_iter().enumerate() {
            let _ = writeln!(text, "#define ROM_{kind}_{name} {index}");
        }
    }
    text + include_str!("declarations.c") + "\n#endif /* ROM_DECLARED */\n"
}

/// Names as parts of C identifiers, each once.
fn identifiers(names: &[String]) -> Vec<String> {
    let mut taken: Vec<String> = Vec::new();
    for name in names {
        let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let mut candidate = plain.clone();
        let mut number = 1;
        while taken.contains(&candidate) || candidate.is_empty() {
            number += 1;
            candidate = format!("{plain}_{number}");
        }
        taken.push(candidate);
    }
    taken
}

/// Text that ends no comment.
fn comment(text: &str) -> String {
    text.replace("*/", "* /").replace("/*", "/ *").replace(['\n', '\r'], " ")
}

/// The file with another prefix of its names than `rom`.
fn prefixed(text: &str, prefix: &str) -> String {
    if prefix == "rom" {
        return text.to_owned();
    }
    let upper = prefix.to_ascii_uppercase();
    let mut out = String::with_capacity(text.len());
    let mut before = ' ';
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let begins = !(before.is_ascii_alphanumeric() || before == '_');
        let (known, new) = if begins && rest.starts_with("rom_") {
            ("rom", prefix)
        } else if begins && rest.starts_with("ROM_") {
            ("ROM", upper.as_str())
        } else {
            ("", "")
        };
        if known.is_empty() {
            out.push(c);
            before = c;
            rest = &rest[c.len_utf8()..];
        } else {
            out += new;
            before = 'x';
            rest = &rest[known.len()..];
        }
    }
    out
}

/// Whether `prefix` can begin the names of a C program.
///
/// # Errors
/// What was found and what is accepted.
pub fn check_prefix(prefix: &str) -> Result<String, String> {
    let first = prefix.starts_with(|c: char| c.is_ascii_lowercase());
    if first && prefix.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_') {
        Ok(prefix.to_owned())
    } else {
        Err(format!("expected lower-case letters, digits and underscores, a letter first, found {prefix:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_identifiers_each_once() {
        let names = ["left tip", "left-tip", "", "P"].map(str::to_owned);
        assert_eq!(identifiers(&names), ["left_tip", "left_tip_2", "_2", "P"]);
    }

    #[test]
    fn a_prefix_replaces_whole_beginnings_of_names() {
        assert_eq!(prefixed("rom_step from_x ROM_DT, xROM_Y", "fmb"), "fmb_step from_x FMB_DT, xROM_Y");
        assert!(check_prefix("fmb_2").is_ok());
        for wrong in ["", "2x", "Fmb", "a b"] {
            assert!(check_prefix(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn no_name_ends_a_comment() {
        assert_eq!(comment("a */ b /* c\nd"), "a * / b / * c d");
    }
}
