//! Which compiler builds for the target.
//!
//! In this order: a target that the compiler in use has; one that rustup can add; Debian's pair of compiler and library
//! source, with the library built along with the image. The pair is whatever version Debian has; Cargo refuses it by itself
//! when it is older than the workspace's `rust-version`. `QUADCAL_FIRMWARE_TOOLCHAIN=rustup` or `=debian` admits one alone.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::{FirmwareError, Target};

/// Debian's packages that build the target without rustup's library.
pub const DEBIAN_PACKAGES: [&str; 4] = [
    "rustc-web",
    "cargo-web",
    "rust-web-src",
    "binutils-arm-none-eabi",
];

const DEBIAN_RUSTC: &str = "/usr/bin/rustc";

/// A way to build for the target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Toolchain {
    /// The compiler in use has the target's library.
    Rustup,
    /// Debian's compiler builds the library from source.
    Debian {
        /// The linker: rustup's `rust-lld` where there is one, else binutils'.
        linker: PathBuf,
    },
}

/// Chooses, and if need be has rustup add the target.
///
/// # Errors
/// [`FirmwareError::NoToolchain`], which names what to install.
pub fn toolchain(target: &Target) -> Result<Toolchain, FirmwareError> {
    let wish = std::env::var("QUADCAL_FIRMWARE_TOOLCHAIN").unwrap_or_default();
    let (rustup, debian) = match wish.as_str() {
        "" => (true, true),
        "rustup" => (true, false),
        "debian" => (false, true),
        _ => return Err(FirmwareError::UnknownToolchain(wish)),
    };
    let mut said = "not asked".to_owned();
    if rustup {
        if installed(target) {
            return Ok(Toolchain::Rustup);
        }
        said = match Command::new("rustup")
            .args(["target", "add", target.triple])
            .output()
        {
            Ok(output) if output.status.success() && installed(target) => {
                return Ok(Toolchain::Rustup);
            }
            Ok(output) => String::from_utf8_lossy(&output.stderr).trim().to_owned(),
            Err(error) => error.to_string(),
        };
    }
    match debian_linker() {
        Some(linker) if debian => Ok(Toolchain::Debian { linker }),
        _ => Err(FirmwareError::NoToolchain {
            triple: target.triple,
            rustup: said,
        }),
    }
}

impl Toolchain {
    /// Makes `cargo` build for the target with this toolchain.
    pub fn apply(&self, target: &Target, cargo: &mut Command) {
        // Flags from the environment would replace the linker arguments of .cargo/config.toml.
        for name in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET"] {
            cargo.env_remove(name);
        }
        if let Self::Debian { linker } = self {
            cargo
                .env("RUSTC", DEBIAN_RUSTC)
                .env("RUSTC_BOOTSTRAP", "1")
                .env("CARGO_UNSTABLE_BUILD_STD", "core")
                .env(target.linker_variable(), linker);
        }
    }
}

fn installed(target: &Target) -> bool {
    let folder = ["--print", "target-libdir", "--target", target.triple];
    print(&rustc(), &folder)
        .and_then(|folder| std::fs::read_dir(folder).ok())
        .is_some_and(|entries| {
            entries
                .flatten()
                .any(|entry| entry.file_name().to_string_lossy().starts_with("libcore-"))
        })
}

fn debian_linker() -> Option<PathBuf> {
    let sysroot = print(DEBIAN_RUSTC, &["--print", "sysroot"])?;
    let source = Path::new(&sysroot).join("lib/rustlib/src/rust/library/core");
    if !source.is_dir() {
        return None;
    }
    rust_lld().or_else(|| {
        let ld = Path::new("/usr/bin/arm-none-eabi-ld");
        ld.is_file().then(|| ld.to_owned())
    })
}

/// The linker that comes with rustup's compiler.
fn rust_lld() -> Option<PathBuf> {
    let host = print(&rustc(), &["--print", "host-tuple"]).unwrap_or_default();
    let root = print(&rustc(), &["--print", "sysroot"])?;
    let lld = Path::new(&root)
        .join("lib/rustlib")
        .join(host)
        .join("bin/rust-lld");
    lld.is_file().then_some(lld)
}

/// A linker for every target.
///
/// # Errors
/// [`FirmwareError::NoLinker`], which names what to install.
pub(super) fn lld() -> Result<PathBuf, FirmwareError> {
    let debian = || Some(PathBuf::from("/usr/bin/ld.lld")).filter(|lld| lld.is_file());
    rust_lld().or_else(debian).ok_or(FirmwareError::NoLinker)
}

fn rustc() -> String {
    std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned())
}

fn print(rustc: &str, args: &[&str]) -> Option<String> {
    let output = Command::new(rustc).args(args).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
