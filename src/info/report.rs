//! The report on a model file.

use super::text::shares;
use super::{EquilibriumInfo, Info};
use crate::report::{Block, Document, Highlight, Section, Table};
use crate::run::view;
use crate::scene::Scene;
use crate::text::{significant, thousands, vector};

impl Info {
    /// Page on what is in the model, with its modes in space. `command` made it, `input_text` is the structure file.
    pub fn report(&self, scene: Option<Scene>, command: &str, tool: &str, input_text: &str) -> Document {
        let mut sections = Vec::new();
        sections.extend(scene.map(view));
        sections.push(Section { title: "Elastic modes".to_owned(), blocks: self.modes_blocks() });
        sections.extend(self.equilibrium.as_ref().map(equilibrium));
        sections.push(Section { title: "Points and load cases".to_owned(), blocks: self.load_blocks() });
        sections.push(Section { title: "Tensors and couplings".to_owned(), blocks: self.tensor_blocks() });
        sections
            .push(Section { title: "Checks made when it was built".to_owned(), blocks: self.check_blocks() });
        sections.push(Section {
            title: "Where it comes from".to_owned(),
            blocks: vec![
                Block::Verbatim(command.to_owned()),
                Block::Facts(self.origin()),
                Block::Text("The structure file:".to_owned()),
                Block::Verbatim(input_text.to_owned()),
            ],
        });
        Document {
            title: format!("{}, reduced-order model", self.name),
            subtitle: format!(
                "{} elastic modes of {} elements, {} degrees of freedom",
                self.modes.len(),
                thousands(self.provenance.n_elements as f64),
                thousands(self.provenance.n_dof as f64)
            ),
            highlights: self.highlights(),
            sections,
            footer: format!("Written by {tool}. SI units. A is the frame of the reference node."),
        }
    }

    fn highlights(&self) -> Vec<Highlight> {
        let highlight =
            |label: &str, value: String, note: String| Highlight { label: label.to_owned(), value, note };
        let mut out = vec![highlight(
            "mass",
            format!("{} kg", significant(self.rigid.mass, 6)),
            format!("centre in A {} m", vector(&self.rigid.centre_of_mass, 4)),
        )];
        if let (Some(low), Some(high)) = (self.modes.first(), self.modes.last()) {
            let hz = |f: f64| significant(f, 4);
            out.push(highlight(
                "elastic frequencies",
                format!("{} to {} Hz", hz(low.frequency_hz), hz(high.frequency_hz)),
                self.next_omega.map_or_else(String::new, |omega| {
                    format!("the next one, left out, {} Hz", hz(omega / std::f64::consts::TAU))
                }),
            ));
        }
        if let Some(dt) = self.stable_time_step.rk4 {
            let note = "RK4; the implicit integrators are stable at any".to_owned();
            out.push(highlight("longest stable step", format!("{} s", significant(dt, 3)), note));
        }
        let passed = self.checks.iter().filter(|check| check.passed).count();
        let value = format!("{passed} of {}", self.checks.len());
        out.push(highlight("checks passed", value, "made when it was built".to_owned()));
        out
    }

    fn modes_blocks(&self) -> Vec<Block> {
        if self.modes.is_empty() {
            return vec![Block::Text("None: a rigid body.".to_owned())];
        }
        let columns =
            ["mode", "ω (rad/s)", "f (Hz)", "damping ratio", "kinetic energy along and about axes of A"];
        let rows = self.modes.iter().map(|m| {
            vec![
                m.number.to_string(),
                significant(m.omega, 6),
                significant(m.frequency_hz, 6),
                significant(m.damping_ratio, 4),
                shares(&m.kinetic_energy_share),
            ]
        });
        vec![table("", &columns, rows.collect())]
    }

    fn load_blocks(&self) -> Vec<Block> {
        let rows =
            self.points.iter().map(|p| vec![p.name.clone(), vector(&p.position, 6), p.members.join(", ")]);
        let mut blocks =
            vec![table("Named points", &["point", "in A (m)", "members that meet there"], rows.collect())];
        if !self.internal_loads.is_empty() {
            let columns = ["place", "member", "fraction", "F (N)", "M (N m)"];
            let rows = self.internal_loads.iter().map(|p| {
                let cells = [significant(p.fraction, 4), vector(&p.force, 4), vector(&p.moment, 4)];
                [p.name.clone(), p.member.clone()].into_iter().chain(cells).collect()
            });
            let caption = "Internal loads at the equilibrium, on the positive face in section axes";
            blocks.push(table(caption, &columns, rows.collect()));
        }
        for case in &self.load_cases {
            let caption = format!(
                "Load case {}: {} ({} s in steps of {} s)",
                case.name, case.description, case.t_end, case.dt
            );
            let columns = ["point", "frame", "force (N)", "moment (N m)", "function of time"];
            blocks.push(table(&caption, &columns, case.loads.iter().map(|load| load.to_vec()).collect()));
        }
        blocks
    }

    fn tensor_blocks(&self) -> Vec<Block> {
        let row = |(name, t): (&str, &super::TensorInfo)| {
            vec![
                name.to_owned(),
                thousands(t.stored as f64),
                thousands(t.possible as f64),
                significant(t.largest, 4),
                thousands(t.dropped_count as f64),
                significant(t.dropped_norm, 2),
            ]
        };
        let columns = ["tensor", "entries", "of", "largest", "dropped as round-off", "norm of those"];
        let tensors = [("c", &self.tensors.c), ("k", &self.tensors.k)];
        let mut blocks = vec![table("", &columns, tensors.into_iter().map(row).collect())];
        if !self.couplings.is_empty() {
            let rows = self.couplings.iter().map(|c| vec![c.tensor.to_string(), c.text.clone()]);
            let caption = "Largest couplings, scaled by the generalised masses";
            blocks.push(table(caption, &["tensor", "what drives what"], rows.collect()));
        }
        blocks
    }

    fn check_blocks(&self) -> Vec<Block> {
        let failed = self.checks.iter().filter(|check| !check.passed);
        let mut blocks: Vec<Block> =
            failed.map(|check| Block::Warning(format!("Not passed: {}", check.name))).collect();
        let rows = self.checks.iter().map(|c| {
            vec![
                c.name.clone(),
                significant(c.value, 3),
                significant(c.limit, 3),
                if c.passed { "passed" } else { "NOT PASSED" }.to_owned(),
            ]
        });
        blocks.push(table("", &["what was checked", "value", "limit", ""], rows.collect()));
        blocks
    }

    fn origin(&self) -> Vec<(String, String)> {
        let p = &self.provenance;
        let list = |items: Vec<String>| if items.is_empty() { "none".to_owned() } else { items.join(", ") };
        let options = p.options.iter().map(|(n, v)| format!("{n} {v}").trim_end().to_owned()).collect();
        let parameters = p.parameters.iter().map(|(n, v)| format!("{n} = {}", significant(*v, 12))).collect();
        let facts = [
            ("model written by", p.generator.clone()),
            ("build options", list(options)),
            ("parameters", list(parameters)),
            ("SHA-256 of the structure file", p.input_sha256.clone()),
        ];
        facts.map(|(name, value)| (name.to_owned(), value)).to_vec()
    }
}

fn equilibrium(info: &EquilibriumInfo) -> Section {
    let facts = [
        ("attitude quaternion", vector(&info.attitude, 6)),
        ("elastic energy", format!("{} J", significant(info.elastic_energy, 5))),
        (
            "reaction at the reference node",
            format!("{} N, {} N m", vector(&info.reaction_force, 3), vector(&info.reaction_moment, 3)),
        ),
        ("of the loads", significant(info.self_balance, 2)),
        ("effort", format!("{} load steps, {} iterations", info.load_steps, info.iterations)),
    ];
    let mut blocks = vec![Block::Facts(facts.map(|(n, v)| (n.to_owned(), v)).to_vec())];
    if !(info.balanced || info.clamped) {
        let text = "Not in balance: the body moves off when it is let go.";
        blocks.insert(0, Block::Warning(text.to_owned()));
    }
    let pairs = |items: &[(String, String)]| items.iter().map(|(n, v)| vec![n.clone(), v.clone()]).collect();
    if !info.factors.is_empty() {
        let rows: Vec<(String, String)> =
            info.factors.iter().map(|(name, f)| (name.clone(), significant(*f, 8))).collect();
        blocks.push(table("Factors that were solved for", &["loads", "factor"], pairs(&rows)));
    }
    let rows: Vec<(String, String)> =
        info.displacements.iter().map(|(name, d)| (name.clone(), vector(d, 5))).collect();
    blocks.push(table("", &["point", "displacement from the drawing in A (m)"], pairs(&rows)));
    Section { title: "Equilibrium".to_owned(), blocks }
}

fn table(caption: &str, columns: &[&str], rows: Vec<Vec<String>>) -> Block {
    let columns = columns.iter().map(|&c| c.to_owned()).collect();
    Block::Table(Table { caption: caption.to_owned(), columns, rows })
}
