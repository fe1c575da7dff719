//! Ranges of torques and run-out at orders and frequencies.

use std::f64::consts::PI;

use super::{ANGLE_ADVICE, Checker};
use crate::twin::Twin;

impl Twin {
    pub(super) fn check_rotating(&self, c: &mut Checker<'_>) {
        for (i, gear) in self.gear_mesh.iter().enumerate() {
            let key = format!("gear_mesh[{i}]");
            check_order(c, &key, gear.order, gear.phase_rad);
            self.check_size(c, &key, (gear.torque_n_m, gear.speed_fraction));
        }
        for (i, bearing) in self.bearing.iter().enumerate() {
            let key = format!("bearing[{i}]");
            check_order(c, &key, bearing.order, bearing.phase_rad);
            let torque = (bearing.torque_n_m, bearing.speed_fraction);
            match (torque, bearing.runout_rad) {
                ((None, None), Some(runout)) => {
                    c.between(&format!("{key}.runout_rad"), runout, 0.0, PI, ANGLE_ADVICE)
                }
                (_, None) => self.check_size(c, &key, torque),
                (_, Some(_)) => c.require(
                    false,
                    &key,
                    "a torque and a runout_rad",
                    "one of torque_n_m, speed_fraction and runout_rad",
                    "write two entries, one for each",
                ),
            }
        }
    }

    pub(super) fn check_tones(&self, c: &mut Checker<'_>) {
        for (i, tone) in self.torque_tone.iter().enumerate() {
            let key = format!("torque_tone[{i}]");
            c.positive(&format!("{key}.f_hz"), tone.f_hz, 1e6, "give a frequency");
            c.phase(&format!("{key}.phase_rad"), tone.phase_rad);
            self.check_size(c, &key, (tone.torque_n_m, tone.speed_fraction));
        }
    }
}

fn check_order(c: &mut Checker<'_>, key: &str, order: f64, phase_rad: f64) {
    c.positive(&format!("{key}.order"), order, 1e5, "give cycles a turn");
    c.phase(&format!("{key}.phase_rad"), phase_rad);
}
