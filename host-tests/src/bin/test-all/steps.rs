//! The steps, cheap ones first.

use std::process::Command;

use quadcal_host_tests::firmware::{self, CORTEX_M4, FirmwareError, Toolchain};

use crate::prerequisites;

/// One step of the whole check.
pub struct Step {
    /// What `--only` calls it.
    pub name: &'static str,
    /// What it does, in a few words.
    pub about: &'static str,
    /// Does it.
    pub run: fn() -> Result<(), Failure>,
}

/// All of them, in order.
pub const STEPS: &[Step] = &[
    Step {
        name: "prerequisites",
        about: "QEMU, compilers of Rust and C for the target, rustfmt and clippy",
        run: prerequisites::run,
    },
    Step {
        name: "fmt",
        about: "formatting",
        run: || {
            cargo(&["fmt", "--all", "--check"])?;
            let examples = ["--manifest-path", "examples/Cargo.toml"];
            cargo(&[&["fmt"][..], &examples, &["--all", "--check"]].concat())
        },
    },
    Step {
        name: "clippy",
        about: "lints of every host target",
        run: || {
            cargo(&[
                "clippy",
                "--workspace",
                "--all-targets",
                "--release",
                "--",
                "-D",
                "warnings",
            ])
        },
    },
    Step {
        name: "doc",
        about: "the documentation, its links included",
        run: || {
            let mut doc = Command::new("cargo");
            doc.args(["doc", "--workspace", "--no-deps", "--lib", "--release"]);
            doc.current_dir(firmware::workspace());
            run(doc.env("RUSTDOCFLAGS", "-D warnings"))
        },
    },
    Step {
        name: "firmware",
        about: "firmware images for the target: lints, build, size",
        run: images,
    },
    Step {
        name: "overflow",
        about: "the core's own tests with every overflow checked",
        run: || {
            cargo(&[
                "test",
                "-p",
                "quadcal",
                "--lib",
                "--features",
                "summary,embedded-hal,device",
            ])
        },
    },
    Step {
        name: "fuzz",
        about: "a device under two million arbitrary inputs",
        run: || {
            cargo(&[
                "run",
                "--release",
                "-p",
                "quadcal-host-tests",
                "--bin",
                "fuzz-device",
                "--",
                "--inputs",
                "2000000",
            ])
        },
    },
    Step {
        name: "test",
        about: "every test, firmware in QEMU included",
        run: || cargo(&["test", "--workspace", "--release", "--no-fail-fast"]),
    },
];

/// Why a step failed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A command ended with an error, which it has printed.
    #[error("failed: {0}")]
    Command(String),
    /// A command is not there.
    #[error("can't start {command}: {source}")]
    Start {
        /// The command line.
        command: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Something is not installed and was not installed now.
    #[error("missing:\n{0}")]
    Missing(String),
    /// An image could not be built.
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
}

/// Runs a command with its output going straight through.
pub fn run(command: &mut Command) -> Result<(), Failure> {
    let words: Vec<_> = std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let line = words.join(" ");
    println!("$ {line}");
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(_) => Err(Failure::Command(line)),
        Err(source) => Err(Failure::Start {
            command: line,
            source,
        }),
    }
}

fn cargo(args: &[&str]) -> Result<(), Failure> {
    run(Command::new("cargo")
        .args(args)
        .current_dir(firmware::workspace()))
}

fn images() -> Result<(), Failure> {
    let toolchain = firmware::toolchain(&CORTEX_M4)?;
    match &toolchain {
        Toolchain::Rustup => {
            let mut clippy = Command::new("cargo");
            clippy.current_dir(firmware::workspace());
            clippy.args([
                "clippy",
                "-p",
                "quadcal",
                "--bins",
                "--features",
                "firmware",
                "--profile",
                "firmware",
            ]);
            let triple = CORTEX_M4.triple;
            clippy.args(["--target", triple, "--target-dir", "target-firmware"]);
            toolchain.apply(&CORTEX_M4, &mut clippy);
            run(clippy.args(["--", "-D", "warnings"]))?;
        }
        Toolchain::Debian { .. } => println!(
            "no lints: clippy needs rustup's library for {}; built with Debian's compiler",
            CORTEX_M4.triple
        ),
    }
    println!("{:<24} {:>8} {:>8} {:>8}", "image", "text", "data", "bss");
    for image in firmware::images()? {
        let size = firmware::size(&firmware::build(&image, &[])?)?;
        println!(
            "{image:<24} {:>8} {:>8} {:>8}",
            size.text, size.data, size.bss
        );
    }
    Ok(())
}
