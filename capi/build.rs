//! Names the shared library's interface for the loader: below 1.0 a minor version may break it.

use std::env::var;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let (major, minor) = (var("CARGO_PKG_VERSION_MAJOR"), var("CARGO_PKG_VERSION_MINOR"));
    if let (Ok(major), Ok(minor), Ok("linux")) = (major, minor, var("CARGO_CFG_TARGET_OS").as_deref()) {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,librom.so.{major}.{minor}");
    }
}
