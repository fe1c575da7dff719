//! Where sectors begin (RM0090, "Flash module organization").

/// Bytes of flash.
pub const CAPACITY: u32 = 1 << 20;

/// Number of sectors.
pub const SECTORS: u32 = 12;

const SMALL: u32 = 16 << 10;
const LARGE: u32 = 128 << 10;

/// Offset of a sector's first byte; the capacity for [`SECTORS`] and beyond.
#[must_use]
pub const fn sector_start(sector: u32) -> u32 {
    match sector {
        0..=4 => sector * SMALL,
        5..SECTORS => (sector - 4) * LARGE,
        _ => CAPACITY,
    }
}

/// The sector that an offset is in; [`SECTORS`] beyond the flash.
#[must_use]
pub const fn sector_at(offset: u32) -> u32 {
    match offset {
        0..0x1_0000 => offset / SMALL,
        0x1_0000..0x2_0000 => 4,
        0x2_0000..CAPACITY => 4 + offset / LARGE,
        _ => SECTORS,
    }
}

/// Whether a sector begins at an offset, or the last one ends there.
#[must_use]
pub const fn is_border(offset: u32) -> bool {
    offset == sector_start(sector_at(offset))
}
