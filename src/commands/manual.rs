//! `romgen completions`, `romgen man` and `romgen reference`: what is known of the command line, for shells and for people.

use std::path::PathBuf;

use clap::{Command, CommandFactory, ValueEnum};
use clap_complete::Shell;

use super::{Romgen, Romrun};
use crate::failure::Failure;
use crate::{atomic, terminal};

/// Width of the text of the command reference.
const WIDTH: usize = 100;

#[derive(Debug, clap::Args)]
#[command(after_help = COMPLETIONS)]
pub(super) struct CompletionsArgs {
    /// Shell: bash, zsh, fish, powershell, elvish
    #[arg(hide_possible_values = true)]
    shell: Shell,
    /// Program
    #[arg(value_enum, default_value = "romgen")]
    program: Program,
}

const COMPLETIONS: &str = "Examples:
  source <(romgen completions bash); source <(romgen completions bash romrun)
  romgen completions zsh > ~/.zfunc/_romgen
  romgen completions fish romrun > ~/.config/fish/completions/romrun.fish";

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Program {
    Romgen,
    Romrun,
}

impl Program {
    fn command(self) -> Command {
        match self {
            Self::Romgen => Romgen::command(),
            Self::Romrun => Romrun::command(),
        }
    }
}

#[derive(Debug, clap::Args)]
#[command(after_help = MAN)]
pub(super) struct ManArgs {
    /// Folder for the pages, made if missing
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

const MAN: &str = "Examples:
  romgen man ~/.local/share/man/man1
  romgen man man && man man/romgen-build.1";

pub(super) fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut command = args.program.command();
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, name, &mut script);
    terminal::say(&String::from_utf8_lossy(&script))?;
    Ok(())
}

/// One page for each program and one for each command of romgen.
pub(super) fn man(args: &ManArgs) -> Result<(), Failure> {
    atomic::make_folder(&args.folder)?;
    let mut count = 0;
    for command in pages() {
        let name = command.get_name().to_owned();
        let mut page = Vec::new();
        clap_mangen::Man::new(command).render(&mut page)?;
        atomic::write(&args.folder.join(format!("{name}.1")), |sink| sink.write_all(&page))?;
        count += 1;
    }
    terminal::say(&format!("wrote {count} pages to {}\n", args.folder.display()))?;
    Ok(())
}

/// The programs, and the commands of romgen under their full names.
fn pages() -> Vec<Command> {
    let mut romgen = Romgen::command();
    romgen.build();
    let shown = romgen.get_subcommands().filter(|c| !c.is_hide_set() && c.get_name() != "help");
    let commands: Vec<Command> = shown
        .map(|c| {
            let name: &'static str = Box::leak(format!("romgen-{}", c.get_name()).into_boxed_str());
            c.clone().name(name)
        })
        .collect();
    [romgen.clone(), Romrun::command()].into_iter().chain(commands).collect()
}

/// Prints docs/commands.md.
pub(super) fn reference() -> Result<(), Failure> {
    terminal::say(&markdown())?;
    Ok(())
}

/// The help texts of all commands as one Markdown page.
fn markdown() -> String {
    let mut text =
        "# Command reference\n\nMade by `romgen reference`; CI holds it to what the programs say.\n"
            .to_owned();
    let mut push = |name: &str, command: Command| {
        let help = command.term_width(WIDTH).render_long_help().to_string();
        let lines: Vec<&str> = help.trim().lines().map(str::trim_end).collect();
        text += &format!("\n## `{name}`\n\n```text\n{}\n```\n", lines.join("\n"));
    };
    let mut romgen = Romgen::command();
    romgen.build();
    push("romgen", romgen.clone());
    for command in romgen.get_subcommands().filter(|c| !c.is_hide_set() && c.get_name() != "help") {
        push(&format!("romgen {}", command.get_name()), command.clone());
    }
    push("romrun", Romrun::command());
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Clap's own checks: no two options of one name, defaults that parse.
    #[test]
    fn the_command_lines_are_consistent() {
        Romgen::command().debug_assert();
        Romrun::command().debug_assert();
    }

    #[test]
    fn the_programs_and_their_commands_have_pages() {
        let names: Vec<String> = pages().iter().map(|command| command.get_name().to_owned()).collect();
        for name in ["romgen", "romrun", "romgen-build", "romgen-validate"] {
            assert!(names.iter().any(|n| n == name), "{names:?}");
        }
        let text = markdown();
        for part in
            ["## `romgen build`", "## `romrun`", "romgen export fmb.rom --vtk modes.vtu", "130 stopped"]
        {
            assert!(text.contains(part), "{part}");
        }
    }
}
