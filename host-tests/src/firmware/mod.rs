//! Building the firmware images and running them in QEMU.

use std::path::{Path, PathBuf};

mod c_program;
mod code;
mod elf;
mod example;
mod image;
mod qemu;
mod sizes;
mod target;
mod toolchain;

pub use c_program::{C_PACKAGES, c_compiler, c_library, c_program};
pub use code::{Function, Offence, offences, reachable};
pub use elf::{Size, Symbol, loaded, size, symbols, value};
pub use example::{EXAMPLES, Example, build_example};
pub use image::{build, build_core, build_for, images};
pub use qemu::{Output, run_qemu, run_qemu_on, start_qemu, start_qemu_at_port};
pub use sizes::{Flash, Sizes, sizes};
pub use target::{CORTEX_M4, TARGETS, Target};
pub use toolchain::{DEBIAN_PACKAGES, Toolchain, toolchain};

/// Debian's package that holds `qemu-system-arm`.
pub const QEMU_PACKAGE: &str = "qemu-system-arm";

/// Why an image can't be built or run.
#[derive(Debug, thiserror::Error)]
pub enum FirmwareError {
    /// Neither rustup nor Debian offers a compiler for the target.
    #[error(
        "no Rust library for {triple}: `rustup target add {triple}` failed, and Debian's compiler with library source is not \
         there either.\nInstall one of the two:\n  rustup target add {triple}\n  apt-get install -y --no-install-recommends {}\n\
         rustup said: {rustup}",
        DEBIAN_PACKAGES.join(" ")
    )]
    NoToolchain {
        /// The target.
        triple: &'static str,
        /// What rustup answered.
        rustup: String,
    },
    /// `QUADCAL_FIRMWARE_TOOLCHAIN` asks for a toolchain that is not known.
    #[error("QUADCAL_FIRMWARE_TOOLCHAIN is `{0}`, expected `rustup` or `debian`")]
    UnknownToolchain(String),
    /// Cargo refused the image.
    #[error("building image {image} failed:\n{log}")]
    Build {
        /// Name of the image.
        image: String,
        /// Cargo's error output.
        log: String,
    },
    /// There is no linker for every target.
    #[error(
        "no rust-lld and no ld.lld; install one: apt-get install -y --no-install-recommends lld"
    )]
    NoLinker,
    /// There is no C compiler for bare Arm, or no `make`.
    #[error(
        "{program} is not on PATH; install it: apt-get install -y --no-install-recommends {}",
        C_PACKAGES.join(" ")
    )]
    NoCCompiler {
        /// What is not there.
        program: &'static str,
    },
    /// There is no QEMU.
    #[error(
        "qemu-system-arm is not on PATH; install it: apt-get install -y --no-install-recommends {QEMU_PACKAGE}"
    )]
    NoQemu,
    /// QEMU did not end in time and was killed.
    #[error("QEMU was killed after {seconds} s without an end; it had printed:\n{printed}")]
    Hang {
        /// The limit in seconds.
        seconds: u64,
        /// Both output streams up to then.
        printed: String,
    },
    /// A program could not be started, or a file not be handled.
    #[error("{what}: {source}")]
    Io {
        /// What was tried.
        what: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file is not a readable ELF.
    #[error("{}: {source}", path.display())]
    Elf {
        /// The file.
        path: PathBuf,
        /// The reader's reason.
        source: object::Error,
    },
    /// The image's code can't be followed.
    #[error("{}: {reason}", path.display())]
    Code {
        /// The file.
        path: PathBuf,
        /// What was found, and where.
        reason: String,
    },
}

impl FirmwareError {
    fn io(what: impl Into<String>) -> impl FnOnce(std::io::Error) -> Self {
        let what = what.into();
        move |source| Self::Io { what, source }
    }
}

/// Top directory of the workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here)
}
