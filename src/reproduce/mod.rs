//! The results of C. Hesse and R. Palacios, Computers & Structures 110-111 (2012), figure by figure, with what the paper
//! states about each and whether it comes out.

mod beam;
mod figure;
mod frame;
mod linearisation;
mod mean_axes;
mod modes;
mod runs;
mod spiral;
mod statement;

pub use figure::Figure;
pub use runs::{Plan, Runs};
pub use statement::{Statement, Verdict};

use crate::report::{Block, Document, Highlight, Section, Table};
use crate::text::significant;

/// All figures and tables, in the order of the paper.
pub fn figures(runs: &Runs, plan: &Plan) -> Vec<Figure> {
    let mut figures = beam::figures(runs);
    figures.extend(frame::figures(runs, plan));
    figures.extend(linearisation::figures(runs, plan));
    let mut modes = modes::figures(runs, plan);
    let table_a = modes.pop();
    figures.extend(modes);
    figures.extend(mean_axes::figures(runs, plan));
    figures.extend(spiral::figures(runs, plan));
    figures.extend(table_a);
    figures
}

/// All statements for the terminal: two lines each, what is stated and what was found.
pub fn to_text(figures: &[Figure]) -> String {
    let line = |s: &Statement| {
        let [verdict, says, found] = <[String; 3]>::try_from(s.cells()).unwrap_or_default();
        format!("{:<13} {:<8} {says}\n{:23}{found}\n", verdict, s.figure, "")
    };
    statements(figures).map(line).collect()
}

/// Statements for which `keep` says so, with their figures.
fn table(figures: &[Figure], keep: impl Fn(&Statement) -> bool) -> Table {
    let row = |s: &Statement| std::iter::once(s.figure.to_owned()).chain(s.cells()).collect();
    Table {
        caption: String::new(),
        columns: std::iter::once("").chain(statement::HEADING).map(String::from).collect(),
        rows: statements(figures).filter(|s| keep(s)).map(row).collect(),
    }
}

/// All statements.
pub fn statements(figures: &[Figure]) -> impl Iterator<Item = &Statement> {
    figures.iter().flat_map(|figure| &figure.statements)
}

/// Number of statements with this verdict.
pub fn count(figures: &[Figure], verdict: Verdict) -> usize {
    statements(figures).filter(|s| s.verdict == verdict).count()
}

/// What to say of the computation: how much of it, how long, by which command and tool.
#[derive(Clone, Debug)]
pub struct Account {
    /// Time on the clock, s.
    pub seconds: f64,
    /// Number of runs.
    pub runs: usize,
    /// Number of time steps.
    pub steps: u64,
    /// The command, as it would be typed.
    pub command: String,
    /// Tool and version.
    pub tool: String,
}

/// The report.
pub fn report(figures: &[Figure], runs: &Runs, plan: &Plan, account: &Account) -> Document {
    let mut sections = vec![disagreements(figures)];
    let failures = runs.failures();
    if !failures.is_empty() {
        let blocks = failures.into_iter().map(Block::Warning).collect();
        sections.push(Section { title: "Runs that stopped early".to_owned(), blocks });
    }
    sections.extend(figures.iter().map(Figure::section));
    let all = Block::Table(table(figures, |_| true));
    sections.push(Section { title: "All statements".to_owned(), blocks: vec![all] });
    sections.push(made(plan, account));
    let number = |label: &str, verdict| Highlight {
        label: label.to_owned(),
        value: count(figures, verdict).to_string(),
        note: format!("of {} statements", statements(figures).count()),
    };
    let mut highlights = vec![number("agree", Verdict::Agrees), number("disagree", Verdict::Disagrees)];
    if count(figures, Verdict::NotComputed) > 0 {
        highlights.push(number("not computed", Verdict::NotComputed));
    }
    highlights.push(Highlight {
        label: "computed in".to_owned(),
        value: format!("{} s", significant(account.seconds, 3)),
        note: format!("{} runs, {} time steps", account.runs, account.steps),
    });
    Document {
        title: "Hesse & Palacios (2012), reproduced".to_owned(),
        subtitle: "Consistent structural linearisation in flexible-body dynamics with large rigid-body motion, Computers & Structures \
            110-111"
            .to_owned(),
        highlights,
        sections,
        footer: format!("Written by {}. SI units.", account.tool),
    }
}

/// What does not come out, first.
fn disagreements(figures: &[Figure]) -> Section {
    let table = table(figures, |s| s.verdict != Verdict::Agrees);
    let blocks = if table.rows.is_empty() {
        vec![Block::Text("Every statement agrees.".to_owned())]
    } else {
        vec![Block::Table(table)]
    };
    Section { title: "What does not come out".to_owned(), blocks }
}

fn made(plan: &Plan, account: &Account) -> Section {
    let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    let facts = [
        ("elements of the frame, load cases 1 and 2", plan.elements.to_string()),
        ("elements of the frame, modes and Table A", "120".to_owned()),
        ("elements of the frame, spiral", plan.spiral_elements.to_string()),
        ("sigma, load case 2", list(&plan.sigmas)),
        ("sigma, spiral", list(&plan.spiral_sigmas)),
        ("time on the clock", format!("{} s", significant(account.seconds, 3))),
    ];
    let facts = facts.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let text = "The figures of the paper did not survive in the text this was made from; only what it says in words and in tables is \
        compared, with the numbers of an independent computation where it says nothing.";
    Section {
        title: "How this was made".to_owned(),
        blocks: vec![
            Block::Text(text.to_owned()),
            Block::Verbatim(account.command.clone()),
            Block::Facts(facts),
        ],
    }
}
