//! The program `romrun`; see `romrun --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    rom_cli::commands::romrun()
}
