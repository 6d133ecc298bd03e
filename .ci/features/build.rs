//! See the manifest.
fn main() {
    println!("cargo::rerun-if-changed=build.rs");
}
