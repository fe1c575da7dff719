//! What the drive does in each recording of a rig.

use quadcal_host::twin::Drive;

use super::{FAST_R_MIN, LOOP_HZ, LOOP_SAMPLE_HZ, RAMP_END_R_MIN, SLOW_R_MIN, ramp_s};

/// What the drive does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scenario {
    /// 15 and 600 r/min, a recording each, with cogging.
    TwoSpeeds,
    /// From 15 to 1500 r/min at a constant rate, with cogging.
    Ramp,
    /// 15 r/min without cogging.
    OneSpeed,
    /// 15 r/min with cogging.
    OneSpeedCogging,
    /// 15 and 600 r/min held by a speed loop, a recording each, with cogging. With few lines the edges of the slow speed come too
    /// rarely for the loop to be stable.
    SpeedLoop,
}

impl Scenario {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::TwoSpeeds,
        Self::Ramp,
        Self::OneSpeed,
        Self::OneSpeedCogging,
        Self::SpeedLoop,
    ];

    /// Its name in a table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::TwoSpeeds => "15 and 600 r/min, cogging",
            Self::Ramp => "ramp 15 to 1500 r/min, cogging",
            Self::OneSpeed => "15 r/min",
            Self::OneSpeedCogging => "15 r/min, cogging",
            Self::SpeedLoop => "speed loop, 15 and 600 r/min, cogging",
        }
    }

    /// Whether the cogging is there.
    #[must_use]
    pub const fn has_cogging(self) -> bool {
        !matches!(self, Self::OneSpeed)
    }

    /// What drives each recording.
    pub(super) fn drives(self) -> Vec<Drive> {
        let speeds = |drive: fn(f64) -> Drive| vec![drive(SLOW_R_MIN), drive(FAST_R_MIN)];
        match self {
            Self::TwoSpeeds => speeds(|r_min| Drive::Constant { r_min }),
            Self::Ramp => vec![Drive::Ramp {
                from_r_min: SLOW_R_MIN,
                to_r_min: RAMP_END_R_MIN,
                over_s: ramp_s(),
            }],
            Self::OneSpeed | Self::OneSpeedCogging => vec![Drive::Constant { r_min: SLOW_R_MIN }],
            Self::SpeedLoop => speeds(|r_min| Drive::SpeedLoop {
                r_min,
                f_hz: LOOP_SAMPLE_HZ,
                bandwidth_hz: Some(LOOP_HZ),
                kp_n_m_s: None,
                ki_n_m: None,
                timeout_s: None,
                limit_n_m: None,
            }),
        }
    }
}
