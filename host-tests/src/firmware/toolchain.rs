//! Which compiler builds for the target.
//!
//! In this order: a target that the compiler in use has; one that rustup can add; Debian's pair of compiler and library
//! source, with the library built along with the image. The pair is whatever version Debian has; Cargo refuses it by itself
//! when it is older than the workspace's `rust-version`. `QUADCAL_FIRMWARE_TOOLCHAIN=rustup` or `=debian` admits one alone.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::{FirmwareError, TARGET};

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
pub fn toolchain() -> Result<Toolchain, FirmwareError> {
    let wish = std::env::var("QUADCAL_FIRMWARE_TOOLCHAIN").unwrap_or_default();
    let (rustup, debian) = match wish.as_str() {
        "" => (true, true),
        "rustup" => (true, false),
        "debian" => (false, true),
        _ => return Err(FirmwareError::UnknownToolchain(wish)),
    };
    let mut said = "not asked".to_owned();
    if rustup {
        if target_installed() {
            return Ok(Toolchain::Rustup);
        }
        said = match Command::new("rustup")
            .args(["target", "add", TARGET])
            .output()
        {
            Ok(output) if output.status.success() && target_installed() => {
                return Ok(Toolchain::Rustup);
            }
            Ok(output) => String::from_utf8_lossy(&output.stderr).trim().to_owned(),
            Err(error) => error.to_string(),
        };
    }
    match debian_linker() {
        Some(linker) if debian => Ok(Toolchain::Debian { linker }),
        _ => Err(FirmwareError::NoToolchain { rustup: said }),
    }
}

impl Toolchain {
    /// Makes `cargo` build for the target with this toolchain.
    pub fn apply(&self, cargo: &mut Command) {
        // Flags from the environment would replace the linker arguments of .cargo/config.toml.
        for name in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET"] {
            cargo.env_remove(name);
        }
        if let Self::Debian { linker } = self {
            cargo
                .env("RUSTC", DEBIAN_RUSTC)
                .env("RUSTC_BOOTSTRAP", "1")
                .env("CARGO_UNSTABLE_BUILD_STD", "core")
                .env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", linker);
        }
    }
}

fn target_installed() -> bool {
    print(&rustc(), &["--print", "target-libdir", "--target", TARGET])
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
    let host = print(&rustc(), &["--print", "host-tuple"]).unwrap_or_default();
    let lld = print(&rustc(), &["--print", "sysroot"]).map(|root| {
        Path::new(&root)
            .join("lib/rustlib")
            .join(host)
            .join("bin/rust-lld")
    });
    lld.filter(|lld| lld.is_file()).or_else(|| {
        let ld = Path::new("/usr/bin/arm-none-eabi-ld");
        ld.is_file().then(|| ld.to_owned())
    })
}

fn rustc() -> String {
    std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned())
}

fn print(rustc: &str, args: &[&str]) -> Option<String> {
    let output = Command::new(rustc).args(args).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
