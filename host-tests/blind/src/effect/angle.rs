//! Effects on the angle at which an edge happens.

use std::f64::consts::{PI, TAU};

use super::{Effect, Site};
use crate::encoder::{Class, Encoder};
use crate::random::Dice;

/// Where and when a mark of the disc may be crossed.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Time, s.
    pub time_s: f64,
    /// A time that lies on the same side of every sudden change, s.
    pub inside_s: f64,
    /// Shaft angle through all turns, rad.
    pub theta: f64,
    /// Shaft speed, rad/s.
    pub speed: f64,
    /// The edge's class; none for an index mark.
    pub class: Option<Class>,
}

impl Effect {
    /// What it adds to e(k) of the disc, rad.
    #[must_use]
    pub fn disc(&self, encoder: Encoder) -> Option<Vec<f64>> {
        let edges = encoder.edges();
        let each = |f: &dyn Fn(f64, Class) -> f64| {
            (0..edges)
                .map(|k| f(TAU * k as f64 / edges as f64, encoder.class(k)))
                .collect()
        };
        let list = match self {
            Self::Eccentricity {
                amplitude_rad,
                phase_rad,
            } => each(&|grid, _| amplitude_rad * libm::sin(grid - phase_rad)),
            Self::DiscTilt {
                amplitude_rad,
                phase_rad,
            } => each(&|grid, _| amplitude_rad * libm::sin(2.0 * grid - phase_rad)),
            Self::LocalDefect {
                angle_rad,
                width_rad,
                error_rad,
                channel,
                rises,
            } => each(&|grid, class| {
                let touched = channel.is_none_or(|c| c == class.channel)
                    && rises.is_none_or(|r| r == class.rises);
                let away = (grid - angle_rad + PI).rem_euclid(TAU) - PI;
                let bump = libm::exp(-0.5 * (away / width_rad) * (away / width_rad));
                if touched { error_rad * bump } else { 0.0 }
            }),
            Self::LineError { rms_rad, seed } => {
                let mut dice = Dice::new(*seed, 0);
                (0..edges).map(|_| rms_rad * dice.normal()).collect()
            }
            Self::WidthError { rad } => each(&|_, class| {
                if class.rises { 0.0 } else { rad[class.channel] }
            }),
            Self::QuadratureError { rad } => {
                each(&|_, class| if class.channel == 1 { *rad } else { 0.0 })
            }
            _ => return None,
        };
        Some(list)
    }

    /// Whether [`Self::late_rad`] is ever anything but 0.
    #[must_use]
    pub const fn moves_marks(&self) -> bool {
        if let Self::Cell(cell) = self {
            return cell.moves_marks();
        }
        matches!(
            self,
            Self::ThresholdRipple { .. }
                | Self::ThresholdDrift { .. }
                | Self::BearingRunout { .. }
                | Self::Whirl { .. }
                | Self::Telegraph { .. }
                | Self::Creep { .. }
        )
    }

    /// How much further along the shaft's angle a mark lies at a time, rad.
    #[must_use]
    pub fn late_rad(&self, at: &Place, jumps: &[f64]) -> f64 {
        // A higher level is met later by a rise and earlier by a fall, seen forward.
        let by_level = |channel: Option<usize>| match at.class {
            Some(class) if channel.is_none_or(|c| c == class.channel) => {
                if class.rises {
                    1.0
                } else {
                    -1.0
                }
            }
            _ => 0.0,
        };
        match self {
            Self::ThresholdRipple {
                f_hz,
                phase_rad,
                angle_rad,
                channel,
            } => by_level(*channel) * angle_rad * libm::sin(TAU * f_hz * at.time_s + phase_rad),
            Self::ThresholdDrift {
                angle_rad,
                tau_s,
                from_s,
            } => {
                let since = (at.time_s - from_s).max(0.0);
                by_level(None) * angle_rad * -libm::expm1(-since / tau_s)
            }
            Self::BearingRunout {
                order,
                phase_rad,
                runout_rad,
            } => -runout_rad * libm::sin(order * at.theta + phase_rad),
            Self::Whirl {
                amplitude_rad,
                phase_rad,
                critical_rad_s,
                damping_ratio,
            } => {
                // Response of a rotor to its imbalance, which goes as speed squared.
                let r = at.speed / critical_rad_s;
                let (re, im) = (1.0 - r * r, 2.0 * damping_ratio * r);
                let gain = 2.0 * damping_ratio * r * r / (re * re + im * im).sqrt();
                let lag = libm::atan2(im, re);
                -amplitude_rad * gain * libm::sin(at.theta - phase_rad - lag)
            }
            Self::Telegraph { angle_rad, .. } => {
                let jumped = jumps.partition_point(|&jump| jump <= at.inside_s);
                let side = if jumped % 2 == 0 { 1.0 } else { -1.0 };
                by_level(None) * angle_rad * side
            }
            Self::Creep { per_turn_rad, .. } => {
                let turn = at.theta / TAU;
                let snaps = jumps.partition_point(|&jump| jump <= turn);
                let from = snaps.checked_sub(1).map_or(0.0, |last| jumps[last]);
                -per_turn_rad * (turn - from)
            }
            Self::Cell(cell) if cell.touches(at.class) => {
                let value = cell.value(at.time_s, at.inside_s, at.theta, at.speed);
                match cell.site {
                    Site::Disc => -value,
                    Site::Level => by_level(None) * value,
                    Site::Torque | Site::Stamp => 0.0,
                }
            }
            _ => 0.0,
        }
    }

    /// Places of random jumps: times, s, or turns for what is locked to the angle; up to a last one.
    #[must_use]
    pub fn jumps(&self, until_s: f64, until_turns: f64) -> Vec<f64> {
        let (rate, seed, until) = match self {
            Self::Telegraph { rate_hz, seed, .. } => (*rate_hz, *seed, until_s),
            Self::Creep { snaps, seed, .. } => (*snaps, *seed, until_turns),
            _ => return Vec::new(),
        };
        let mut dice = Dice::new(seed, 0);
        let mut at = 0.0;
        let mut jumps = Vec::new();
        loop {
            at += dice.exponential() / rate;
            if at >= until {
                return jumps;
            }
            jumps.push(at);
        }
    }

    /// By how much marks lie further along in forward motion than in reverse, rad.
    #[must_use]
    pub const fn play_rad(&self) -> f64 {
        match self {
            Self::Hysteresis { angle_rad } => *angle_rad,
            Self::Backlash { gap_rad } => *gap_rad,
            _ => 0.0,
        }
    }

    /// Delay with which a change of a channel arrives, s.
    #[must_use]
    pub const fn delay_s(&self, channel: usize, rises: bool) -> f64 {
        match self {
            Self::EdgeDelay { rise_s, .. } if rises => rise_s[channel],
            Self::EdgeDelay { fall_s, .. } => fall_s[channel],
            Self::ChannelSkew { channel_s } => channel_s[channel],
            _ => 0.0,
        }
    }
}
