//! What an engineer knows of a rig: encoder, shaft, drive, timer, noise and the errors already measured.

use std::f64::consts::TAU;

use crate::encoder::Encoder;
use crate::pieces::Pieces;

/// A torque locked to the shaft: torque sin(order theta + phase).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Cycles a turn.
    pub order: f64,
    /// Phase, rad.
    pub phase_rad: f64,
    /// Amplitude, N m.
    pub torque_n_m: f64,
}

/// What speed the drive asks for; speeds in rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Profile {
    /// One speed.
    Constant {
        /// The speed.
        speed: f64,
    },
    /// From one speed to another, then held; through zero it is a reversal.
    Ramp {
        /// Speed at time 0.
        from: f64,
        /// Speed at its end.
        to: f64,
        /// Its length, s.
        over_s: f64,
    },
    /// The drive holds a speed and goes off.
    RunDown {
        /// The speed before.
        speed: f64,
        /// When it goes off, s.
        off_s: f64,
    },
    /// Ramps, holds, dwells and reversals.
    Free(Pieces),
    /// A sampled PI loop that sees the way from edge to edge over the last interval.
    Loop {
        /// The speed asked for.
        speed: f64,
        /// Samples a second.
        f_hz: f64,
        /// Proportional gain, N m s.
        kp_n_m_s: f64,
        /// Integral gain, N m.
        ki_n_m: f64,
    },
}

impl Profile {
    /// The largest speed asked for, rad/s.
    #[must_use]
    pub fn top(&self) -> f64 {
        match *self {
            Self::Constant { speed } | Self::RunDown { speed, .. } | Self::Loop { speed, .. } => {
                speed.abs()
            }
            Self::Ramp { from, to, .. } => from.abs().max(to.abs()),
            Self::Free(pieces) => pieces.top(),
        }
    }

    /// Speed asked for at time 0, rad/s.
    #[must_use]
    pub fn start(&self) -> f64 {
        match *self {
            Self::Constant { speed } | Self::RunDown { speed, .. } | Self::Loop { speed, .. } => {
                speed
            }
            Self::Ramp { from, .. } => from,
            Self::Free(pieces) => pieces.start(),
        }
    }

    /// Whether the speed asked for goes both ways.
    #[must_use]
    pub fn reverses(&self) -> bool {
        match *self {
            Self::Ramp { from, to, .. } => from * to < 0.0,
            Self::Free(pieces) => pieces.reverses(),
            Self::Constant { .. } | Self::RunDown { .. } | Self::Loop { .. } => false,
        }
    }
}

/// What the twin gives of shaft and drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// All of it.
    Whole,
    /// The shaft, without the drive.
    NoDrive,
    /// The inertia, and nothing else.
    InertiaOnly,
}

/// What the noise of a rig is like; sizes are the rig's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoiseShape {
    /// Torque noise white up to the edges' rate, stamps normal.
    White,
    /// Errors of stamps by Student's t with 3 degrees of freedom, of the same RMS.
    StudentStamps,
    /// Torque noise that is so many times as dense below a corner.
    TwoSlopes {
        /// The corner.
        corner_hz: f64,
        /// Density far below it over that far above it, less 1.
        excess: f64,
    },
    /// Torque noise that goes with the square of the speed.
    BySpeed {
        /// Where it has its size, rad/s.
        at_rad_s: f64,
    },
}

/// A rig on which one recording is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// The encoder.
    pub encoder: Encoder,
    /// Errors of the disc e(k), rad: edge k lies at its grid angle minus e(k).
    pub disc_rad: Vec<f64>,
    /// Whether the twin gives them.
    pub disc_known: bool,
    /// Inertia, kg m^2.
    pub inertia: f64,
    /// Viscous friction, N m s.
    pub viscous: f64,
    /// Coulomb friction, N m.
    pub coulomb: f64,
    /// How strongly the drive pulls towards its speed, N m s.
    pub stiffness: f64,
    /// Angle at time 0, rad.
    pub start_rad: f64,
    /// Torques locked to the shaft that the twin gives.
    pub ripples: Vec<Order>,
    /// Two-sided density of the torque noise, N^2 m^2 s.
    pub noise_psd: f64,
    /// RMS of the white error of every stamp, s.
    pub jitter_s: f64,
    /// Whether the twin gives torque noise and jitter.
    pub noise_known: bool,
    /// What the noise is like.
    pub noise_shape: NoiseShape,
    /// What the twin gives of shaft and drive.
    pub told: Told,
    /// Ticks a second.
    pub clock_hz: u64,
    /// Speed profile.
    pub profile: Profile,
    /// Turns travelled, either way.
    pub turns: f64,
    /// Longest time recorded, s.
    pub longest_s: f64,
}

impl Rig {
    /// Damping while the drive is on or off, 1/s.
    #[must_use]
    pub fn damping(&self, driven: bool) -> f64 {
        let drive = if driven { self.stiffness } else { 0.0 };
        (self.viscous + drive) / self.inertia
    }

    /// Whether an open-loop drive pulls at a time.
    #[must_use]
    pub fn driven(&self, time_s: f64) -> bool {
        match self.profile {
            Profile::RunDown { off_s, .. } => time_s < off_s,
            Profile::Loop { .. } => false,
            _ => true,
        }
    }

    /// Damping that the speed's noise sees at a time, 1/s: a speed loop damps by its proportional gain.
    #[must_use]
    pub fn noise_damping(&self, time_s: f64) -> f64 {
        match self.profile {
            Profile::Loop { kp_n_m_s, .. } => (self.viscous + kp_n_m_s) / self.inertia,
            _ => self.damping(self.driven(time_s)),
        }
    }

    /// Time for which a value of the torque noise is held, s: one grid step at the highest speed.
    #[must_use]
    pub fn hold_s(&self) -> f64 {
        self.encoder.step_rad() / self.profile.top()
    }

    /// RMS of all white errors of a stamp, the clock's rounding included, s.
    #[must_use]
    pub fn stamp_rms_s(&self) -> f64 {
        let tick = 1.0 / self.clock_hz as f64;
        (self.jitter_s * self.jitter_s + tick * tick / 12.0).sqrt()
    }

    /// Relative wander of the speed that the torque noise makes at a speed, RMS.
    #[must_use]
    pub fn wander(&self, speed: f64) -> f64 {
        let rate = self.noise_psd / (self.inertia * self.inertia);
        (rate / (2.0 * self.noise_damping(0.0))).sqrt() / speed.abs()
    }

    /// Grid angle of an edge, rad.
    #[must_use]
    pub fn grid_rad(&self, k: usize) -> f64 {
        TAU * k as f64 / self.encoder.edges() as f64
    }
}
