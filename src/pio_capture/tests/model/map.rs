//! Where the registers of each chip are, and what they are to hold.

/// Addresses and words of one chip, from its data sheet.
pub struct Map {
    pub resets: u32,
    pub blocks: u32,
    pub abort: u32,
    /// The pad of pin 0; bits that it must have, and must not.
    pub pads: u32,
    pub pad: (u32, u32),
    /// Control words of the two channels, for 256 bytes of memory.
    pub control: [u32; 2],
}

pub const RP2040_MAP: Map = Map {
    resets: 0x4000_C000,
    blocks: 0x0504,
    abort: 0x5000_0444,
    pads: 0x4001_C004,
    pad: (0xCA, 0x04),
    control: [0x0022_0E2B, 0x0022_062B],
};

pub const RP2350_MAP: Map = Map {
    resets: 0x4002_0000,
    blocks: 0x0A04,
    abort: 0x5000_0464,
    pads: 0x4003_8004,
    pad: (0xCA, 0x104),
    control: [0x0088_384B, 0x0088_184B],
};
