//! Finds the library that goes into FMUs, so that `romgen` can carry it.
//!
//! `rom-fmu` is a dependency whose crate types have a shared library among them. Cargo builds that before it compiles this package
//! and puts it into the folder of all dependencies, which is where this looks: no cargo inside cargo, the same flags, and it
//! works offline. Where Cargo lays things out otherwise, or for a ready-made library, set ROM_FMU_LIBRARY to a file.

use std::env::{var, var_os};
use std::fs;
use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=ROM_FMU_LIBRARY");
    let out = PathBuf::from(var_os("OUT_DIR").unwrap_or_default());
    let library = var_os("ROM_FMU_LIBRARY").map_or_else(|| built(&out), PathBuf::from);
    println!("cargo::rustc-env=ROM_FMU_LIBRARY={}", library.display());
    println!("cargo::rustc-env=ROM_FMU_PLATFORM={}", platform());
}

/// Where the library is going to be: `deps` beside `build/romgen-HASH/out`.
fn built(out: &Path) -> PathBuf {
    let windows = var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "windows");
    let macos = var("CARGO_CFG_TARGET_VENDOR").is_ok_and(|vendor| vendor == "apple");
    let name = match (windows, macos) {
        (true, _) => "rom_fmu.dll",
        (_, true) => "librom_fmu.dylib",
        _ => "librom_fmu.so",
    };
    let expected = out.ancestors().nth(3).map(|folder| folder.join("deps"));
    let place = expected.filter(|folder| folder.is_dir()).unwrap_or_else(|| out.to_owned()).join(name);
    // `cargo check` builds no libraries, but includes files. An empty one stands for none.
    if !place.exists() {
        let _ = fs::write(&place, []);
    }
    place
}

/// As FMI 3.0 names it: architecture and system.
fn platform() -> String {
    let get = |key: &str| var(key).unwrap_or_default();
    let (architecture, os) = (get("CARGO_CFG_TARGET_ARCH"), get("CARGO_CFG_TARGET_OS"));
    let os = if os == "macos" { "darwin".to_owned() } else { os };
    format!("{architecture}-{os}")
}
