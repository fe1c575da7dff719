//! The image that logs through defmt needs defmt's linker script; no other image has a logger, which that script asks for.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let target = std::env::var("CARGO_CFG_TARGET_OS");
    if target.as_deref() == Ok("none") && std::env::var_os("CARGO_FEATURE_FIRMWARE").is_some() {
        println!("cargo::rustc-link-arg-bin=drive_f405=-Tdefmt.x");
    }
}
