//! What one calibration is asked for, and what a device is set up with.

use serde::{Deserialize, Serialize};

/// What one calibration is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Options {
    /// Turns to learn from at the most; fewer than [`TURNS_LEAST`] count as so many.
    pub turns: u16,
    /// Error RMS that is good enough, 2^-32 turn; 0: as good as it gets.
    pub goal: u32,
    /// Fresh turns to prove the table on; fewer than [`PROOF_TURNS_LEAST`] count as so many.
    pub proof_turns: u8,
    /// Torque locked to the shaft is at multiples of this order only; 0: not known.
    pub torque_base: u16,
    /// Orders up to this one are left alone: a speed loop may hide them.
    pub hidden_up_to: u16,
    /// Speeds to learn at.
    pub window: SpeedWindow,
    /// When it is, seconds since 1970, for the table; 0: not given.
    pub date: u64,
}

/// Fewest turns that a table is learned from.
pub const TURNS_LEAST: u16 = 6;

/// Fewest fresh turns that a table is judged by.
pub const PROOF_TURNS_LEAST: u8 = 4;

impl Default for Options {
    fn default() -> Self {
        Self {
            turns: 32,
            goal: 0,
            proof_turns: 8,
            torque_base: 0,
            hidden_up_to: 0,
            window: SpeedWindow::ANY,
            date: 0,
        }
    }
}

/// Speeds from and up to, either direction, thousandths of a revolution a minute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SpeedWindow {
    /// Slowest.
    pub from: u32,
    /// Fastest.
    pub to: u32,
}

impl SpeedWindow {
    /// Any speed but none.
    pub const ANY: Self = Self {
        from: 1,
        to: u32::MAX,
    };

    /// Whether a speed is within.
    #[must_use]
    pub const fn contains(self, speed: u32) -> bool {
        self.from <= speed && speed <= self.to
    }

    /// Speeds that are in both windows.
    #[must_use]
    pub fn within(self, other: Self) -> Self {
        Self {
            from: self.from.max(other.from),
            to: self.to.min(other.to),
        }
    }

    /// Whether no speed is within.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.from > self.to
    }
}

/// How long each stage may wait, milliseconds, and the speeds that are allowed at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// For the shaft to turn.
    pub motion_ms: u32,
    /// For a speed that stays in the window.
    pub speed_ms: u32,
    /// That the speed has to stay in the window before learning begins.
    pub steady_ms: u32,
    /// From one turn that is taken to the next.
    pub turn_ms: u32,
    /// For the solver.
    pub solve_ms: u32,
    /// From one fresh turn to the next.
    pub proof_ms: u32,
    /// For the command to commit.
    pub commit_ms: u32,
    /// From the start until the table is solved for.
    pub whole_ms: u32,
    /// Speeds to learn at.
    pub window: SpeedWindow,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            motion_ms: 60_000,
            speed_ms: 60_000,
            steady_ms: 500,
            turn_ms: 60_000,
            solve_ms: 120_000,
            proof_ms: 60_000,
            commit_ms: 900_000,
            whole_ms: 3_600_000,
            window: SpeedWindow::ANY,
        }
    }
}
