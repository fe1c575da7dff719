//! Rigs that make starting without an index easy or hard.

use quadcal_host::twin::{Drive, Duration, Encoder, Errors, Harmonic, Noise, Per, Position, Twin};

use super::PATIENCE_TURNS;

/// What is made hard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Case {
    /// The paper's rig with 0.1 % wander.
    Paper,
    /// A 1 MHz clock: 25 ticks an edge at the search's own 240 r/min.
    CoarseClock,
    /// eps ten times smaller.
    WeakPattern,
    /// 60 lines, errors in parts of a step as the paper's.
    FewLines,
    /// No eps but eccentricity and tilt.
    Smooth,
    /// 1 % wander beside cogging of 1 %, twice the paper's higher orders.
    Cogging,
    /// From 15 to 150 r/min within one turn.
    Ramp,
    /// White time noise of the capture half as large as eps.
    HalfJitter,
    /// As large as eps.
    Jitter,
}

impl Case {
    /// Every case.
    pub const ALL: [Self; 9] = [
        Self::Paper,
        Self::CoarseClock,
        Self::WeakPattern,
        Self::FewLines,
        Self::Smooth,
        Self::Cogging,
        Self::Ramp,
        Self::HalfJitter,
        Self::Jitter,
    ];

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper's rig, wander 0.1 %",
            Self::CoarseClock => "25 ticks an edge",
            Self::WeakPattern => "eps 10 times smaller",
            Self::FewLines => "60 lines",
            Self::Smooth => "smooth pattern only",
            Self::Cogging => "wander and cogging 1 %",
            Self::Ramp => "15 to 150 r/min in a turn",
            Self::HalfJitter => "time noise half of eps",
            Self::Jitter => "time noise as large as eps",
        }
    }

    /// The rig that the table is learned on.
    #[must_use]
    pub fn teacher(self, seed: u64) -> Twin {
        let mut twin = Twin::paper();
        twin.seed = seed;
        twin.duration = Duration::Turns(14.1);
        twin.noise = Some(wander(1e-3));
        match self {
            Self::WeakPattern => scale_position(&mut twin, 0.1),
            Self::FewLines => {
                let scale = 2500.0 / 60.0;
                twin.encoder = Encoder::Quadrature {
                    lines: 60,
                    index: true,
                };
                scale_position(&mut twin, scale);
                twin.errors.width_a_rad *= scale;
                twin.errors.width_b_rad *= scale;
                twin.errors.quadrature_rad *= scale;
            }
            Self::Smooth => {
                let harmonic = |amplitude_rad| {
                    Some(Harmonic {
                        amplitude_rad,
                        phase_rad: 0.4,
                    })
                };
                twin.errors = Errors {
                    position: None,
                    eccentricity: harmonic(5e-4),
                    tilt: harmonic(1e-4),
                    ..twin.errors
                };
            }
            _ => {}
        }
        twin
    }

    /// The same disc, another day: other wander, and what makes the case hard.
    pub(super) fn pupil(self, errors: &[f64], seed: u64) -> Twin {
        let mut twin = self.teacher(seed);
        twin.errors = Errors {
            list_rad: errors.to_vec(),
            ..Errors::default()
        };
        twin.duration = Duration::Turns(f64::from(PATIENCE_TURNS) + 1.2);
        match self {
            Self::CoarseClock => {
                twin.timer.clock_hz = 1_000_000;
                twin.drive = Drive::Constant { r_min: 240.0 };
            }
            Self::Cogging => {
                twin.noise = Some(wander(1e-2));
                for ripple in &mut twin.ripple {
                    ripple.speed_fraction = Some(1e-2);
                }
            }
            Self::Ramp => {
                twin.drive = Drive::Ramp {
                    from_r_min: 15.0,
                    to_r_min: 150.0,
                    over_s: 0.73,
                };
            }
            // 3.6e-5 rad at 15 r/min are 2.3e-5 s.
            Self::Jitter => twin.timer.jitter_s = 2.3e-5,
            Self::HalfJitter => twin.timer.jitter_s = 1.15e-5,
            _ => {}
        }
        twin
    }
}

fn wander(rms_fraction: f64) -> Noise {
    Noise::SpeedWander {
        rms_fraction,
        correlation_rad: Some(0.5),
        hold_s: None,
    }
}

fn scale_position(twin: &mut Twin, factor: f64) {
    twin.errors.position = Some(Position::Uniform {
        amplitude_rad: 6.2832e-5 * factor,
        per: Per::Edge,
    });
}
