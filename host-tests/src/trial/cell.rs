//! Where an effect enters and what it follows: the pair that says "where", whatever its name.

use quadcal_host::diagnose::diagnosis::Finding;
use quadcal_host::mechanism::Mechanism;
use serde::Serialize;

/// Site and carrier of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Cell {
    /// Where it enters: torque, disc, level, stamp, count or noise.
    pub site: &'static str,
    /// What it follows.
    pub carrier: &'static str,
}

impl Cell {
    /// That of a finding; none of `unknown`.
    #[must_use]
    pub fn of_finding(finding: &Finding) -> Option<Self> {
        Self::of(
            finding.mechanism,
            finding.parameters.contains_key("runout_rad"),
        )
    }

    /// That of a mechanism; a bearing may run out, or push.
    #[must_use]
    pub const fn of(mechanism: Mechanism, runs_out: bool) -> Option<Self> {
        let (site, carrier) = match mechanism {
            Mechanism::LineError => ("disc", "pattern"),
            Mechanism::WidthError => ("disc", "class"),
            Mechanism::QuadratureError => ("disc", "channel"),
            Mechanism::Eccentricity | Mechanism::DiscTilt => ("disc", "order"),
            Mechanism::LocalDefect => ("disc", "place"),
            Mechanism::Hysteresis | Mechanism::Backlash => ("disc", "direction"),
            Mechanism::EdgeDelay => ("stamp", "class"),
            Mechanism::ChannelSkew => ("stamp", "channel"),
            Mechanism::CaptureLatency => ("stamp", "frequency"),
            Mechanism::ThresholdRipple => ("level", "frequency"),
            Mechanism::ThresholdDrift => ("level", "instant"),
            Mechanism::TimestampJitter => ("noise", "class"),
            Mechanism::LostEdges | Mechanism::ExtraEdges | Mechanism::IndexSlip => {
                ("count", "instant")
            }
            Mechanism::Bearing if runs_out => ("disc", "order"),
            Mechanism::TorqueRipple | Mechanism::GearMesh | Mechanism::Bearing => {
                ("torque", "order")
            }
            Mechanism::TorqueTone => ("torque", "frequency"),
            Mechanism::TorsionalResonance => ("torque", "band"),
            Mechanism::Friction | Mechanism::StickSlip => ("torque", "speed"),
            Mechanism::LoadStep => ("torque", "instant"),
            Mechanism::SpeedDrift => ("torque", "time"),
            Mechanism::ClosedLoop => ("torque", "measured speed"),
            Mechanism::Unknown => return None,
        };
        Some(Self { site, carrier })
    }
}

/// How well named cells agree with those that are there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Agreement {
    /// Named and there.
    pub right: usize,
    /// Named.
    pub named: usize,
    /// There.
    pub there: usize,
}

impl Agreement {
    /// Of cells named against cells there, each counted as often as it comes.
    #[must_use]
    pub fn of(named: &[Cell], there: &[Cell]) -> Self {
        let mut left = there.to_vec();
        let right = named.iter().filter(|cell| {
            let at = left.iter().position(|one| one == *cell);
            at.map(|at| left.swap_remove(at)).is_some()
        });
        Self {
            right: right.count(),
            named: named.len(),
            there: there.len(),
        }
    }
}
