//! `romgen reproduce`.

use std::path::PathBuf;
use std::time::Instant;

use serde_json::json;

use super::VERSION;
use crate::failure::Failure;
use crate::reproduce::{self, Account, Plan, Verdict};
use crate::text::significant;
use crate::{atomic, interrupt, terminal};

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    /// Half the elements and fewer sweep points
    #[arg(long)]
    quick: bool,
    /// Folder for report.html and statements.json, made if missing
    #[arg(long, default_value = "reproduction", value_name = "DIR")]
    out: PathBuf,
    /// Write the plots of the report as SVG files for papers too, in plots/
    #[arg(long)]
    svg: bool,
    /// Print the statements as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing but errors (and JSON, if asked for)
    #[arg(long, short)]
    quiet: bool,
}

const EXAMPLES: &str = "Examples:
  romgen reproduce --quick
  romgen reproduce --out paper --json | jq '.statements[] | select(.verdict != \"agrees\")'";

pub(super) fn run(args: &Args, command: String) -> Result<(), Failure> {
    let start = Instant::now();
    let plan = if args.quick { Plan::quick() } else { Plan::full() };
    let tool = format!("romgen {VERSION}");
    let defect =
        |e: String| Failure::other(format!("the published structures are not read, which is a defect: {e}"));
    // A folder that cannot be made should be known before the runs.
    atomic::make_folder(&args.out)?;
    let steps = plan.steps().map_err(defect)?;
    let bar = terminal::progress(steps, args.quiet);
    bar.set_message("running");
    let runs = plan.run(&tool, &|steps| bar.inc(steps)).map_err(defect)?;
    bar.finish_and_clear();
    if interrupt::requested() {
        return Err(Failure::interrupted("interrupted", "nothing was written: the figures need all runs"));
    }
    let figures = reproduce::figures(&runs, &plan);
    let account =
        Account { seconds: start.elapsed().as_secs_f64(), runs: runs.count(), steps, command, tool };
    let document = reproduce::report(&figures, &runs, &plan, &account);
    document.write(&args.out.join("report.html"))?;
    if args.svg {
        document.write_svg(&args.out.join("plots"))?;
    }
    let statements: Vec<_> = reproduce::statements(&figures).collect();
    let json = json!({ "quick": args.quick, "statements": statements });
    let text = serde_json::to_vec_pretty(&json).map_err(std::io::Error::from)?;
    atomic::write(&args.out.join("statements.json"), |sink| sink.write_all(&text))?;
    if args.json {
        terminal::say_json(&json)?;
    } else if !args.quiet {
        terminal::say(&told(&figures, &account, &args.out.display().to_string()))?;
    }
    // A run that stops early may be what there is to say; a statement of which nothing can be said is a failure.
    match reproduce::statements(&figures).find(|s| s.verdict == Verdict::NotComputed) {
        None => Ok(()),
        Some(first) => Err(Failure::numerical(
            format!("{}: {}: {}", first.figure, first.says, first.found),
            "the report shows what could be computed",
        )),
    }
}

fn told(figures: &[reproduce::Figure], account: &Account, folder: &str) -> String {
    let number = |verdict| reproduce::count(figures, verdict);
    let mut text = reproduce::to_text(figures);
    text += &format!(
        "\n  {} statements agree, {} disagree, {} not computed; {} runs in {} s\n  wrote {folder}: report.html, statements.json\n",
        number(Verdict::Agrees),
        number(Verdict::Disagrees),
        number(Verdict::NotComputed),
        account.runs,
        significant(account.seconds, 3)
    );
    text
}
