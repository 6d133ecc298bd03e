//! Nothing unused is kept, nothing may be missing, no start-up code.

fn main() {
    for argument in ["-Wl,--gc-sections", "-Wl,--no-undefined", "-nostartfiles", "-lc"] {
        println!("cargo:rustc-cdylib-link-arg={argument}");
    }
}
