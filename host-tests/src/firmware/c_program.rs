//! The library for C and the programs of its example.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::image::{built, cargo_build, finish};
use super::{CORTEX_M4, FirmwareError, Target, workspace};

/// Debian's packages that compile C for bare Arm.
pub const C_PACKAGES: [&str; 2] = ["gcc-arm-none-eabi", "make"];

/// Whether a C compiler for the target and `make` are there.
///
/// # Errors
/// [`FirmwareError::NoCCompiler`], which names what to install.
pub fn c_compiler() -> Result<(), FirmwareError> {
    for program in ["arm-none-eabi-gcc", "make"] {
        let mut version = Command::new(program);
        version.arg("--version");
        version.stdout(Stdio::null()).stderr(Stdio::null());
        if !version.status().is_ok_and(|status| status.success()) {
            return Err(FirmwareError::NoCCompiler { program });
        }
    }
    Ok(())
}

/// Builds the static library that C links on the Cortex-M4, and returns its path.
///
/// # Errors
/// No toolchain, or Cargo's own errors.
pub fn c_library() -> Result<PathBuf, FirmwareError> {
    c_library_for(&CORTEX_M4)
}

/// The same for any target.
pub(super) fn c_library_for(target: &Target) -> Result<PathBuf, FirmwareError> {
    // With another kind beside it the library would not be optimised as a whole.
    let library = ["rustc", "-p", "quadcal-c", "--crate-type", "staticlib"];
    cargo_build(target, "libquadcal_c.a", &library)?;
    Ok(built(target, "libquadcal_c.a"))
}

/// Builds a program of `c/example` in `folder` with a library, by its Makefile; functions of the library named in `keep` are linked even
/// where the program does not call them.
///
/// # Errors
/// No compiler, or its own errors.
pub fn c_program(
    name: &str,
    library: &Path,
    folder: &Path,
    keep: &[&str],
) -> Result<PathBuf, FirmwareError> {
    c_compiler()?;
    let elf = folder.join(name);
    let mut make = Command::new("make");
    make.arg("-C").arg(workspace().join("c/example"));
    make.arg(format!("LIBRARY={}", library.display()));
    make.arg(format!("BUILD={}", folder.display()));
    make.arg(format!("KEEP={}", keep.join(" "))).arg(&elf);
    finish(make, name)?;
    Ok(elf)
}
