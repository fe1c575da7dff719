//! Where a ripple that the twin declares shapes the shaft's course, and may send it to and fro.

use std::f64::consts::TAU;

use super::turning::Course;
use crate::twin::{Drive, Twin};

/// What the torques of a twin that go with the angle may do at the most.
#[derive(Clone, Copy, Debug)]
pub struct Pull {
    /// Acceleration, rad/s^2.
    pub hardest: f64,
    /// Square of the speed that their potential gives from its middle to its top, halved, (rad/s)^2.
    pub thrown: f64,
}

impl Pull {
    /// Of a twin.
    #[must_use]
    pub fn of(twin: &Twin) -> Self {
        let ripples = twin.ripple.iter().chain(&twin.gear_mesh);
        let each = ripples.filter_map(|ripple| Some((ripple.order, ripple.torque_n_m?.abs())));
        let nothing = Self {
            hardest: 0.0,
            thrown: 0.0,
        };
        each.fold(nothing, |sum, (order, torque)| {
            let hardest = torque / twin.shaft.inertia_kg_m2;
            Self {
                hardest: sum.hardest + hardest,
                thrown: sum.thrown + hardest / order,
            }
        })
    }

    /// Whether it is so many times stronger than what slows the shaft, so that it may hold it.
    #[must_use]
    pub fn holds(&self, twin: &Twin, times: f64) -> bool {
        let slows = match twin.drive {
            Drive::Ramp {
                from_r_min,
                to_r_min,
                over_s,
            } => (to_r_min - from_r_min).abs() * (TAU / 60.0) / over_s,
            Drive::RunDown { .. } => twin.friction_n_m(0.0).abs() / twin.shaft.inertia_kg_m2,
            _ => return false,
        };
        self.hardest > 0.0 && self.hardest >= times * slows
    }
}

/// Speed below which the twin's ripple shapes the course itself, rad/s. A drive that turns the shaft round against more than the ripple
/// never lets it.
#[must_use]
pub fn too_slow(twin: &Twin, course: &Course) -> f64 {
    /// How much more energy the shaft is to have than a ripple can take.
    const OVER: f64 = 25.0;
    /// How much stronger than friction ripple is to be to hold a shaft for a while that runs down.
    const HOLDS: f64 = 4.0;
    /// Part of the top speed that is never too slow.
    const PART: f64 = 0.3;
    let times = match twin.drive {
        Drive::RunDown { .. } => HOLDS,
        _ => 1.0,
    };
    let pull = Pull::of(twin);
    if !pull.holds(twin, times) {
        return 0.0;
    }
    let speeds = course.iter().flatten().map(|(_, speed, _)| speed.abs());
    let top = speeds.fold(0.0, f64::max);
    (OVER * pull.thrown).sqrt().min(PART * top)
}
