//! What the two state machines run.
//!
//! ```text
#![doc = include_str!("program.pio")]
//! ```
//!
//! Both turn once in [`CYCLES`] cycles, or twice as long with two counts where there is something to say, so that counts stay in step with
//! the clock whatever happens. A jump that counts goes to the same place whether it is taken or not.

/// Cycles of the system clock in a tick.
pub const CYCLES: u32 = 6;

/// Bits of a count: the other three of a word are the levels.
pub const BITS: u32 = 29;

/// The words of `program.pio`, as an assembler gives them with address 0 for the first.
pub const WORDS: [u16; 19] = [
    0xA041, //  0 changed: mov y, x
    0xA026, //  1          mov x, isr
    0x4043, //  2          in y, 3
    0x8200, //  3          push noblock [2]
    0x0045, //  4          jmp x-- tick
    0x0046, //  5 tick:    jmp x-- count
    0xA0C1, //  6 count:   mov isr, x
    0xA0E0, //  7 sample:  mov osr, pins
    0x6023, //  8          out x, 3
    0x00A0, //  9          jmp x!=y changed
    0xA026, // 10          mov x, isr
    0x0046, // 11          jmp x-- count
    0x8080, // 12 answer:  pull noblock
    0xA0C1, // 13          mov isr, x
    0x8200, // 14          push noblock [2]
    0x0050, // 15          jmp x-- pass
    0x0351, // 16 pass:    jmp x-- asked [3]
    0xA045, // 17 asked:   mov y, status
    0x006C, // 18          jmp !y answer
];

/// First and last instruction of the loop, and where it is entered.
pub(super) struct Course {
    pub bottom: u32,
    pub top: u32,
    pub entry: u32,
}

/// Of the machine that captures.
pub(super) const CAPTURES: Course = Course {
    bottom: 6,
    top: 11,
    entry: 7,
};

/// Of the machine that tells the time.
pub(super) const TELLS: Course = Course {
    bottom: 16,
    top: 18,
    entry: 16,
};

/// `mov isr, ~null`, `mov x, ~null` and `mov y, ~null`, for the time before the machines run. Counts begin at all ones and go down;
/// no levels are all ones, so that the first look is a change.
pub(super) const ISR_ONES: u32 = 0xA0CB;
pub(super) const X_ONES: u32 = 0xA02B;
pub(super) const Y_ONES: u32 = 0xA04B;

/// All bits of a count.
pub(super) const MASK: u32 = u32::MAX >> (32 - BITS);

/// A count from a machine's register, which goes down, ticks.
pub(super) const fn count(register: u32) -> u32 {
    !register & MASK
}
