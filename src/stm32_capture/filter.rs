//! The timer's input filter.

/// Input filter of the three channels, `ICxF` of `CCMRx`: a level counts once it has been the same for so long. All edges are late by
/// that, alike.
///
/// ```
/// use quadcal::stm32_capture::Filter;
///
/// // 0.38 us at 84 MHz.
/// assert_eq!(Filter::of_ticks(30).ticks(), 32);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Filter(u8);

/// Ticks of each code with the sampling clock undivided: number of samples times their distance (`IC1F` of `TIMx_CCMR1` in both
/// manuals).
const TICKS: [u16; 16] = [
    0, 2, 4, 8, 12, 16, 24, 32, 48, 64, 80, 96, 128, 160, 192, 256,
];

impl Filter {
    /// No filter.
    pub const NONE: Self = Self(0);

    /// The shortest filter of at least `ticks` ticks of the timer's clock; the longest, 256, if there is none.
    #[must_use]
    pub const fn of_ticks(ticks: u32) -> Self {
        let mut code = 0;
        while code < TICKS.len() as u8 - 1 && (TICKS[code as usize] as u32) < ticks {
            code += 1;
        }
        Self(code)
    }

    /// How long a level must last, and how late its edge is captured, ticks.
    #[must_use]
    pub const fn ticks(self) -> u32 {
        TICKS[self.0 as usize] as u32
    }

    pub(super) const fn code(self) -> u32 {
        self.0 as u32
    }
}
