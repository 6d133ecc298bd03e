//! The program `romgen`; see `romgen --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    rom_cli::commands::romgen()
}
