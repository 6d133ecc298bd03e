//! What is said on standard output, and progress on standard error.

use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Writes to standard output. A reader that has gone (`romgen info ... | head`) is not an error.
///
/// # Errors
/// Others of standard output.
pub fn say(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Writes a value as indented JSON and a line break to standard output.
///
/// # Errors
/// Those of standard output.
pub fn say_json(value: &impl serde::Serialize) -> io::Result<()> {
    say(&(serde_json::to_string_pretty(value)? + "\n"))
}

/// A bar for `length` steps that shows only on a terminal, and only when the work lasts.
pub fn progress(length: u64, quiet: bool) -> ProgressBar {
    let target = if quiet || !io::stderr().is_terminal() {
        ProgressDrawTarget::hidden()
    } else {
        // Ten times a second: short runs end before the first time.
        ProgressDrawTarget::stderr_with_hz(10)
    };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    let style = ProgressStyle::with_template("{msg} [{bar:30}] {percent:>3} %  {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
    bar
}

/// Several lines that are drawn over themselves; show only on a terminal.
pub fn picture() -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(20));
    bar.set_style(ProgressStyle::with_template("{msg}").unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

/// A spinner for stages whose length is not known; shows only on a terminal.
pub fn spinner(quiet: bool) -> ProgressBar {
    let bar =
        if quiet || !io::stderr().is_terminal() { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}
