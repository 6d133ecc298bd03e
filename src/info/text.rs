//! For the terminal.

use std::fmt::Write;

use super::{Info, ModeInfo, ResidualLoadInfo, TensorInfo};
use crate::text::{columns, significant, thousands, vector};

impl Info {
    /// For people; `loaded` names the points whose participation is shown.
    pub fn to_text(&self, loaded: &[&str]) -> String {
        let p = &self.provenance;
        let mut out = format!(
            "{}: {} elastic modes of {} elements, {} degrees of freedom\n",
            self.name,
            self.modes.len(),
            thousands(p.n_elements as f64),
            thousands(p.n_dof as f64)
        );
        self.push_modes(&mut out);
        self.push_participation(&mut out, loaded);
        self.push_rigid(&mut out);
        if let Some(gravity) = &self.gravity {
            let _ = writeln!(out, "\nGravity\n  {} m/s^2 in G", vector(gravity, 6));
        }
        if let Some(equilibrium) = &self.equilibrium {
            out.push_str("\nEquilibrium\n");
            out.push_str(&equilibrium.to_text());
        }
        if let Some(limits) = &self.limits {
            out.push_str(&limits.to_text());
        }
        if let Some(lagrangian) = &self.lagrangian {
            out.push_str(&lagrangian.to_text());
        }
        self.push_steps(&mut out);
        out.push_str("\nTensors\n");
        push_tensor(&mut out, "c", &self.tensors.c);
        push_tensor(&mut out, "k", &self.tensors.k);
        if !self.couplings.is_empty() {
            out.push_str("\nLargest couplings (scaled by the generalised masses)\n");
            for coupling in &self.couplings {
                let _ = writeln!(out, "  {}: {}", coupling.tensor, coupling.text);
            }
        }
        self.push_points(&mut out);
        self.push_internal_loads(&mut out);
        self.push_load_cases(&mut out);
        if let Some(selection) = &self.selection {
            let _ = write!(
                out,
                "\nSelection for load cases {}\n{}",
                selection.cases.join(", "),
                crate::select::report(selection)
            );
        }
        self.push_provenance(&mut out);
        out
    }

    fn push_modes(&self, out: &mut String) {
        out.push_str("\nElastic modes\n");
        let heading = [
            "mode",
            "omega (rad/s)",
            "f (Hz)",
            "mass (kg m^2)",
            "damping ratio",
            "kinetic energy along and about axes of A",
        ];
        let row = |m: &ModeInfo| {
            vec![
                if m.residual { format!("{} (residual)", m.number) } else { m.number.to_string() },
                significant(m.omega, 6),
                significant(m.frequency_hz, 5),
                significant(m.generalised_mass, 6),
                significant(m.damping_ratio, 4),
                shares(&m.kinetic_energy_share),
            ]
        };
        let rows: Vec<Vec<String>> =
            std::iter::once(heading.map(String::from).to_vec()).chain(self.modes.iter().map(row)).collect();
        out.push_str(&columns(&rows));
        self.push_effective_masses(out);
        if let Some(next) = self.next_omega {
            let _ = writeln!(out, "  the next one, not in the model: {} rad/s", significant(next, 6));
        }
        self.push_residual(out);
    }

    fn push_residual(&self, out: &mut String) {
        if self.residual_loads.is_empty() {
            return;
        }
        out.push_str("\nStatic response that the residual modes complete: share of the strain energy missed without them\n");
        let row = |load: &ResidualLoadInfo| {
            let share = format!("{} %", significant(100.0 * load.missed, 3));
            vec![format!("{} along {} at {}", load.load, load.axis, load.point), share]
        };
        out.push_str(&columns(&self.residual_loads.iter().map(row).collect::<Vec<_>>()));
    }

    /// Of a clamped structure: what of its mass the modes carry.
    fn push_effective_masses(&self, out: &mut String) {
        let effective: Vec<_> =
            self.modes.iter().filter_map(|m| Some((m.number, m.effective_mass?))).collect();
        if effective.is_empty() {
            return;
        }
        out.push_str("\nClamped: effective mass along (kg) and inertia about (kg m^2) x, y, z of A\n");
        let row = |name: String, values: [f64; 6]| {
            let largest = values.iter().fold(0.0, |max: f64, x| max.max(*x));
            let cell = |x: &f64| significant(if *x < 1e-12 * largest { 0.0 } else { *x }, 4);
            std::iter::once(name).chain(values.iter().map(cell)).collect::<Vec<String>>()
        };
        let mut rows = vec![["mode", "m x", "m y", "m z", "J x", "J y", "J z"].map(String::from).to_vec()];
        rows.extend(effective.iter().map(|(number, values)| row(number.to_string(), *values)));
        let sum = |r: usize| effective.iter().map(|(_, values)| values[r]).sum();
        rows.push(row("sum".to_owned(), std::array::from_fn(sum)));
        let matrix = &self.rigid.mass_matrix;
        rows.push(row("structure".to_owned(), std::array::from_fn(|r| matrix[7 * r])));
        out.push_str(&columns(&rows));
    }

    fn push_participation(&self, out: &mut String, loaded: &[&str]) {
        if self.modes.is_empty() || loaded.is_empty() {
            return;
        }
        out.push_str(
            "\nWork of a unit force along x, y, z of A at the load points, per unit modal amplitude\n",
        );
        // What symmetry makes zero is round-off here, and best read as zero.
        let floor = |mode: &ModeInfo| {
            1e-9 * mode.participation.iter().flat_map(|p| p.force).fold(0.0, |max, f| f64::max(max, f.abs()))
        };
        let mut rows =
            vec![std::iter::once("mode".to_owned()).chain(loaded.iter().map(|n| (*n).to_owned())).collect()];
        for mode in &self.modes {
            let cell = |name: &&str| {
                let at = mode.participation.iter().find(|p| p.point == **name);
                let clean = |f: f64| if f.abs() < floor(mode) { 0.0 } else { f };
                at.map_or_else(String::new, |p| vector(&p.force.map(clean), 3))
            };
            rows.push(std::iter::once(mode.number.to_string()).chain(loaded.iter().map(cell)).collect());
        }
        out.push_str(&columns(&rows));
    }

    fn push_rigid(&self, out: &mut String) {
        let rigid = &self.rigid;
        let inertia = rigid.inertia_about_a;
        let _ = write!(
            out,
            "\nRigid body\n  mass {} kg, centre of mass in A {} m\n  inertia about A: xx, yy, zz {} kg m^2, xy, xz, yz {}\n",
            significant(rigid.mass, 6),
            vector(&rigid.centre_of_mass, 6),
            vector(&[inertia[0][0], inertia[1][1], inertia[2][2]], 6),
            vector(
                &relative([inertia[0][1], inertia[0][2], inertia[1][2]], inertia[0][0] + inertia[1][1]),
                6
            )
        );
    }

    fn push_steps(&self, out: &mut String) {
        out.push_str("\nLongest stable time step\n");
        let steps = &self.stable_time_step;
        for (name, step) in [("newmark", steps.newmark), ("gen-alpha", steps.gen_alpha), ("rk4", steps.rk4)] {
            let words = step.map_or_else(
                || "any (implicit; accuracy sets the limit)".to_owned(),
                |dt| format!("{} s", significant(dt, 4)),
            );
            let _ = writeln!(out, "  {name:<9}  {words}");
        }
    }

    fn push_points(&self, out: &mut String) {
        out.push_str("\nNamed points\n");
        let mut rows = vec![["point", "in A (m)", "members"].map(String::from).to_vec()];
        rows.extend(
            self.points.iter().map(|p| vec![p.name.clone(), vector(&p.position, 6), p.members.join(", ")]),
        );
        out.push_str(&columns(&rows));
    }

    fn push_internal_loads(&self, out: &mut String) {
        let Some(first) = self.internal_loads.first() else { return };
        let ways = if first.summation { "summation of forces" } else { "the strains of the modes" };
        let _ = writeln!(
            out,
            "\nInternal loads, by {ways}: at the equilibrium, on the positive face in section axes"
        );
        let heading = ["place", "member", "fraction", "F (N)", "M (N m)"];
        let mut rows = vec![heading.map(String::from).to_vec()];
        rows.extend(self.internal_loads.iter().map(|p| {
            let cells = [significant(p.fraction, 4), vector(&p.force, 4), vector(&p.moment, 4)];
            [p.name.clone(), p.member.clone()].into_iter().chain(cells).collect()
        }));
        out.push_str(&columns(&rows));
    }

    fn push_load_cases(&self, out: &mut String) {
        out.push_str("\nLoad cases\n");
        for case in &self.load_cases {
            let _ = writeln!(
                out,
                "  {}: {} ({} s, dt {} s, numerical damping {})",
                case.name, case.description, case.t_end, case.dt, case.numerical_damping
            );
            for [point, frame, force, moment, time] in &case.loads {
                let mut what = Vec::new();
                for (name, value, unit) in [("force", force, "N"), ("moment", moment, "N m")] {
                    if value != "–" {
                        what.push(format!("{name} {value} {unit}"));
                    }
                }
                let _ = writeln!(out, "    {point}, {frame}: {}, times {time}", what.join(" and "));
            }
        }
    }

    fn push_provenance(&self, out: &mut String) {
        let p = &self.provenance;
        let _ = write!(
            out,
            "\nProvenance\n  written by {}\n  structure file SHA-256 {}\n",
            p.generator, p.input_sha256
        );
        let pairs = |list: Vec<String>| if list.is_empty() { "none".to_owned() } else { list.join(", ") };
        let options =
            p.options.iter().map(|(name, value)| format!("{name} {value}").trim_end().to_owned()).collect();
        let parameters = p.parameters.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        let _ = writeln!(out, "  options: {}\n  parameters: {}", pairs(options), pairs(parameters));
        if !self.checks.is_empty() {
            out.push_str("\nChecks made when it was built\n");
        }
        for check in &self.checks {
            let verdict = if check.passed { "ok" } else { "FAILED" };
            let (value, limit) = (significant(check.value, 3), significant(check.limit, 3));
            let _ = writeln!(out, "  {verdict}: {}: {value} (limit {limit})", check.name);
        }
    }
}

/// Shares of at least one per cent, in words.
pub(crate) fn shares(share: &[f64; 6]) -> String {
    let names = ["x", "y", "z", "rot x", "rot y", "rot z"];
    let told = names.iter().zip(share).filter(|(_, s)| s.abs() >= 0.01);
    told.map(|(name, s)| format!("{name} {:.0} %", 100.0 * s)).collect::<Vec<_>>().join(", ")
}

/// Products of inertia that are round-off against the moments read as zero.
fn relative(products: [f64; 3], scale: f64) -> [f64; 3] {
    products.map(|p| if p.abs() < 1e-12 * scale { 0.0 } else { p })
}

fn push_tensor(out: &mut String, name: &str, t: &TensorInfo) {
    let percent = 100.0 * t.stored as f64 / t.possible.max(1) as f64;
    let _ = writeln!(
        out,
        "  {name}: {} of {} entries ({} %), largest {}\n     dropped as round-off: {} below {} of {}; their norm {}",
        thousands(t.stored as f64),
        thousands(t.possible as f64),
        significant(percent, 3),
        significant(t.largest, 4),
        thousands(t.dropped_count as f64),
        significant(t.threshold, 2),
        t.scale,
        significant(t.dropped_norm, 2),
    );
}
