//! The examples for boards: packages of a workspace of their own.

use std::path::PathBuf;
use std::process::Command;

use super::image::finish;
use super::{CORTEX_M4, FirmwareError, TARGETS, Target, toolchain, workspace};

/// An example, and the processor of its chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Example {
    /// Its folder and package.
    pub name: &'static str,
    /// What it is built for.
    pub target: Target,
    /// Functions in which its control loop and its edges are.
    pub loops: &'static [&'static str],
}

/// All of them.
pub const EXAMPLES: [Example; 3] = [
    Example {
        name: "bare_stm32f4",
        target: CORTEX_M4,
        loops: &["TIM2", "TIM7"],
    },
    Example {
        name: "embassy_rp2040",
        target: TARGETS[0],
        loops: &["embassy_rp2040::round"],
    },
    Example {
        name: "rtic_stm32g4",
        target: CORTEX_M4,
        loops: &["TIM7"],
    },
];

/// Builds an example, and returns the ELF's path and what Cargo said.
///
/// # Errors
/// No toolchain, or Cargo's own errors.
pub fn build_example(example: &Example) -> Result<(PathBuf, String), FirmwareError> {
    let target = &example.target;
    let folder = workspace().join("target-firmware/examples");
    let mut cargo = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned()));
    cargo
        .current_dir(workspace())
        .args(["build", "--manifest-path", "examples/Cargo.toml"])
        .args(["--package", example.name, "--release"])
        .args(["--target", target.triple, "--target-dir"])
        .arg(&folder);
    toolchain(target)?.apply(target, &mut cargo);
    let log = finish(cargo, example.name)?;
    let elf = folder
        .join(target.triple)
        .join("release")
        .join(example.name);
    Ok((elf, log))
}
