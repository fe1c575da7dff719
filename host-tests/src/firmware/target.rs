//! The processors that the core is built for.

/// A processor: what Rust calls it, and the machine of QEMU that its images run on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// Rust's name.
    pub triple: &'static str,
    /// What a data sheet calls it.
    pub processor: &'static str,
    /// The machine whose memory `build.rs` gives to the linker; none where nothing is run.
    pub machine: Option<&'static str>,
}

/// An STM32F405: the target of every image.
pub const CORTEX_M4: Target = Target {
    triple: "thumbv7em-none-eabihf",
    processor: "Cortex-M4F",
    machine: Some("netduinoplus2"),
};

/// All of them.
pub const TARGETS: [Target; 5] = [
    Target {
        triple: "thumbv6m-none-eabi",
        processor: "Cortex-M0",
        machine: Some("microbit"),
    },
    Target {
        triple: "thumbv7m-none-eabi",
        processor: "Cortex-M3",
        machine: Some("mps2-an385"),
    },
    CORTEX_M4,
    Target {
        triple: "thumbv8m.main-none-eabihf",
        processor: "Cortex-M33F",
        machine: Some("mps2-an505"),
    },
    Target {
        triple: "riscv32imac-unknown-none-elf",
        processor: "RV32IMAC",
        machine: None,
    },
];

impl Target {
    /// Cargo's variable for the linker.
    pub(super) fn linker_variable(&self) -> String {
        let name = self.triple.to_uppercase().replace(['-', '.'], "_");
        format!("CARGO_TARGET_{name}_LINKER")
    }
}
