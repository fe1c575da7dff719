//! What the linker needs for the images: the memory of the machine that they run on, and for the one that logs through defmt that
//! crate's linker script. No other image has a logger, which that script asks for.

use std::path::Path;

/// The machine that the images for a target run on; its memory is in `memory`.
fn machine(target: &str) -> Option<&str> {
    Some(match target {
        "thumbv6m-none-eabi" => "microbit",
        "thumbv7m-none-eabi" => "mps2_an385",
        "thumbv7em-none-eabihf" => "stm32f405",
        "thumbv8m.main-none-eabihf" => "mps2_an505",
        _ => return None,
    })
}

fn main() -> std::io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=memory");
    let variable = |name| std::env::var(name).unwrap_or_default();
    if std::env::var_os("CARGO_FEATURE_FIRMWARE").is_none() {
        return Ok(());
    }
    if let Some(machine) = machine(&variable("TARGET")) {
        let folder = variable("OUT_DIR");
        std::fs::copy(
            format!("memory/{machine}.x"),
            Path::new(&folder).join("memory.x"),
        )?;
        println!("cargo::rustc-link-search={folder}");
        println!("cargo::rustc-link-arg-bin=drive_f405=-Tdefmt.x");
    }
    Ok(())
}
