//! Building one image.

use std::path::PathBuf;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use super::{CORTEX_M4, FirmwareError, Target, toolchain, workspace};

/// Names of all images, in order: the folders of `src/bin`.
///
/// # Errors
/// The folder can't be read.
pub fn images() -> Result<Vec<String>, FirmwareError> {
    let folder = workspace().join("src/bin");
    let entries =
        std::fs::read_dir(&folder).map_err(FirmwareError::io(folder.display().to_string()))?;
    let mut names: Vec<String> = entries
        .flatten()
        .filter(|entry| entry.path().join("main.rs").is_file())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    Ok(names)
}

/// Where Cargo leaves what it built for a target.
pub(super) fn built(target: &Target, name: &str) -> PathBuf {
    let folder = workspace().join("target-firmware");
    folder.join(target.triple).join("firmware").join(name)
}

/// Has Cargo build for a target by `args`; `what` is named in messages.
pub(super) fn cargo_build(target: &Target, what: &str, args: &[&str]) -> Result<(), FirmwareError> {
    let mut cargo = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned()));
    cargo
        .current_dir(workspace())
        .args(args)
        .args(["--profile", "firmware", "--target", target.triple])
        .args(["--target-dir", "target-firmware"]);
    // Machine code is looked into on the Cortex-M4 alone; without debug information a build takes a quarter less.
    if *target != CORTEX_M4 {
        cargo.env("CARGO_PROFILE_FIRMWARE_DEBUG", "0");
    }
    toolchain(target)?.apply(target, &mut cargo);
    finish(cargo, what).map(drop)
}

/// Runs a command that builds, and returns its error output; that is the reason where it fails.
pub(super) fn finish(mut command: Command, what: &str) -> Result<String, FirmwareError> {
    let output = command.output().map_err(FirmwareError::io(format!(
        "starting {:?}",
        command.get_program()
    )))?;
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() {
        return Ok(log);
    }
    Err(FirmwareError::Build {
        image: what.to_owned(),
        log,
    })
}

/// Builds the core for a target with every feature that a library user may set.
///
/// # Errors
/// No toolchain, or Cargo's own errors.
pub fn build_core(target: &Target) -> Result<(), FirmwareError> {
    let features = "defmt,device,embedded-hal,pio_capture,stm32_capture,stm32f405,summary";
    let core = ["build", "-p", "quadcal", "--lib", "--features", features];
    cargo_build(target, "the core", &core)
}

/// Builds image `image` (a `[[bin]]` of the core package) for the Cortex-M4 with the features given besides `firmware`, and returns the
/// ELF's path. The file stays as it is while other tests build the same image with other features.
///
/// # Errors
/// No toolchain, or Cargo's own errors.
pub fn build(image: &str, features: &[&str]) -> Result<PathBuf, FirmwareError> {
    build_for(&CORTEX_M4, image, features)
}

/// Builds an image as [`build`] does, for a target that images run on.
///
/// # Errors
/// No toolchain, or Cargo's own errors.
pub fn build_for(
    target: &Target,
    image: &str,
    features: &[&str],
) -> Result<PathBuf, FirmwareError> {
    // One build at a time: between Cargo's end and the copy another would replace the file.
    static BUILDING: Mutex<()> = Mutex::new(());
    let _building = BUILDING.lock().unwrap_or_else(PoisonError::into_inner);

    let folder = workspace().join("target-firmware");
    let all: Vec<&str> = std::iter::once("firmware")
        .chain(features.iter().copied())
        .collect();
    let joined = all.join(",");
    let package = ["build", "-p", "quadcal", "--bin", image];
    cargo_build(
        target,
        image,
        &[&package[..], &["--features", &joined]].concat(),
    )?;
    let built = built(target, image);
    let images = folder.join("images").join(target.triple);
    let name = std::iter::once(image)
        .chain(features.iter().copied())
        .collect::<Vec<_>>()
        .join("+");
    let kept = images.join(format!("{name}.elf"));
    let fresh = images.join(format!("{name}.{}.new", std::process::id()));
    // Renamed into place, so that a QEMU that is loading the same name never sees half a file.
    std::fs::create_dir_all(&images)
        .and_then(|()| std::fs::copy(&built, &fresh))
        .and_then(|_| std::fs::rename(&fresh, &kept))
        .map_err(FirmwareError::io(format!("keeping {}", kept.display())))?;
    Ok(kept)
}
