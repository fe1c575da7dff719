//! Flash that the core takes in a drive, for every target: a program that calls the library for C and nothing else, linked without
//! start-up code.

use std::path::Path;
use std::process::Command;

use object::{Object, ObjectSection};

use super::c_program::c_library_for;
use super::elf::with_elf;
use super::image::finish;
use super::toolchain::lld;
use super::{FirmwareError, Target};

/// What a drive calls that corrects with a table from its flash.
const CORRECT: [&str; 7] = [
    "quadcal_init",
    "quadcal_overflow",
    "quadcal_edge",
    "quadcal_time",
    "quadcal_angle",
    "quadcal_speed",
    "quadcal_set_table",
];

/// What it calls besides to learn one.
const LEARN: [&str; 5] = [
    "quadcal_capture_time",
    "quadcal_learn_start",
    "quadcal_learn_samples",
    "quadcal_learn_slice",
    "quadcal_learn_table",
];

/// Bytes of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flash {
    /// Section `.text`: code.
    pub text: u64,
    /// Section `.rodata`: constants.
    pub rodata: u64,
}

/// Flash that a target's programs take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// To decode and correct.
    pub correct: Flash,
    /// To learn as well.
    pub learn: Flash,
}

/// Builds for a target and measures.
///
/// # Errors
/// No toolchain, no linker, or what they say.
pub fn sizes(target: &Target) -> Result<Sizes, FirmwareError> {
    let library = c_library_for(target)?;
    Ok(Sizes {
        correct: linked(&library, &CORRECT)?,
        learn: linked(&library, &[&CORRECT[..], &LEARN].concat())?,
    })
}

/// Size of a program with these functions of the library, and all that they call.
fn linked(library: &Path, functions: &[&str]) -> Result<Flash, FirmwareError> {
    let folder = tempfile::tempdir().map_err(FirmwareError::io("making a folder to link in"))?;
    let elf = folder.path().join("sizes.elf");
    let mut link = Command::new(lld()?);
    link.args(["-flavor", "gnu", "--gc-sections", "--no-warnings"]);
    // The drive's own: where learning would go if it could panic.
    link.arg("--defsym=quadcal_a_panic_can_be_reached=0");
    link.args(["-e", "quadcal_init"]);
    link.args(functions.iter().flat_map(|name| ["-u", name]));
    link.arg(library).arg("-o").arg(&elf);
    finish(link, "the program that is measured")?;
    with_elf(&elf, |file| {
        let bytes = |name| file.section_by_name(name).map_or(0, |found| found.size());
        Flash {
            text: bytes(".text"),
            rodata: bytes(".rodata"),
        }
    })
}
