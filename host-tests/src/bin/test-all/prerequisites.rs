//! What has to be on the machine besides Rust and a C linker. Installed where that is possible: with rustup, and as root on
//! Debian and its kin with apt-get; else named with the command that installs it.

use std::process::{Command, Stdio};

use quadcal_host_tests::firmware::{
    self, C_PACKAGES, DEBIAN_PACKAGES, FirmwareError, QEMU_PACKAGE, TARGETS, Target, Toolchain,
};

use crate::steps::{self, Failure};

/// Checks everything, installs what it can, and names all that is still missing.
pub fn run() -> Result<(), Failure> {
    let others = [
        qemu(),
        c_compiler(),
        component("rustfmt", "fmt"),
        component("clippy", "clippy"),
    ];
    let missing: Vec<String> = others
        .into_iter()
        .chain(TARGETS.iter().map(target))
        .filter_map(Result::err)
        .collect();
    if missing.is_empty() {
        Ok(())
    } else {
        Err(Failure::Missing(missing.join("\n")))
    }
}

fn qemu() -> Result<(), String> {
    let there = || answers("qemu-system-arm", &["--version"]);
    if there() || apt_install(&[QEMU_PACKAGE]) && there() {
        println!("qemu-system-arm: there");
        return Ok(());
    }
    Err(FirmwareError::NoQemu.to_string())
}

fn c_compiler() -> Result<(), String> {
    let found = firmware::c_compiler().or_else(|error| match apt_install(&C_PACKAGES) {
        true => firmware::c_compiler(),
        false => Err(error),
    });
    found.map_err(|error| error.to_string())?;
    println!("arm-none-eabi-gcc and make: there");
    Ok(())
}

fn target(target: &Target) -> Result<(), String> {
    let found = firmware::toolchain(target).or_else(|error| match error {
        FirmwareError::NoToolchain { .. } if apt_install(&DEBIAN_PACKAGES) => {
            firmware::toolchain(target)
        }
        _ => Err(error),
    });
    let triple = target.triple;
    match found.map_err(|error| error.to_string())? {
        Toolchain::Rustup => println!("{triple}: the library of the compiler in use"),
        Toolchain::Debian { linker } => println!(
            "{triple}: Debian's compiler and library source, linker {}",
            linker.display()
        ),
    }
    Ok(())
}

fn component(name: &str, subcommand: &str) -> Result<(), String> {
    let there = || answers("cargo", &[subcommand, "--version"]);
    if there()
        || steps::run(Command::new("rustup").args(["component", "add", name])).is_ok() && there()
    {
        println!("{name}: there");
        return Ok(());
    }
    Err(format!(
        "{name} is not there; install it: rustup component add {name}"
    ))
}

fn answers(program: &str, args: &[&str]) -> bool {
    Command::new(program)
        .args(args)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// Installs packages if this is root on a machine with apt-get; says whether that worked.
fn apt_install(packages: &[&str]) -> bool {
    let root = Command::new("id")
        .arg("-u")
        .output()
        .is_ok_and(|output| output.stdout == b"0\n");
    if !root || !answers("apt-get", &["--version"]) {
        return false;
    }
    let apt = |args: &[&str]| {
        steps::run(
            Command::new("apt-get")
                .args(args)
                .env("DEBIAN_FRONTEND", "noninteractive"),
        )
        .is_ok()
    };
    let install: Vec<&str> = ["install", "-y", "--no-install-recommends"]
        .into_iter()
        .chain(packages.iter().copied())
        .collect();
    apt(&["update"]) && apt(&install)
}
