//! Ranges and conflicts of springs and of the drive's drift.

use super::{Checker, TIME_MAX, TORQUE_MAX};
use crate::twin::{SpeedDrift, Twin};

impl Twin {
    pub(super) fn check_drift(&self, c: &mut Checker<'_>) {
        let Some(SpeedDrift {
            fraction_per_s,
            fraction,
            tau_s,
        }) = self.speed_drift
        else {
            return;
        };
        let key = "speed_drift";
        match (fraction_per_s, fraction, tau_s) {
            (Some(rate), None, None) => {
                let key = "speed_drift.fraction_per_s";
                c.between(
                    key,
                    rate,
                    -1e3,
                    1e3,
                    "give the change over the speed and second",
                );
            }
            (None, Some(fraction), Some(tau)) => {
                let key = "speed_drift.fraction";
                c.between(key, fraction, -0.9, 1.0, "give the change over the speed");
                let key = "speed_drift.tau_s";
                c.between(key, tau, 1e-3, TIME_MAX, "give its time constant");
            }
            _ => c.require(
                false,
                key,
                "these keys",
                "fraction_per_s alone, or fraction with tau_s",
                "take one of the two kinds",
            ),
        }
        self.check_open_loop(c, key);
    }

    pub(super) fn check_elastic(&self, c: &mut Checker<'_>) {
        if let Some(stick_slip) = &self.stick_slip {
            let stiffness = stick_slip.stiffness_n_m_rad;
            let key = "stick_slip.stiffness_n_m_rad";
            c.positive(key, stiffness, TORQUE_MAX, "give the spring's stiffness");
            c.require(
                stiffness <= 1e12 * self.shaft.inertia_or_one(),
                key,
                stiffness,
                &format!(
                    "up to {:?} with this inertia",
                    1e12 * self.shaft.inertia_or_one()
                ),
                "lower it or raise the inertia: the shaft swings above 160 kHz",
            );
            self.check_open_loop(c, "stick_slip");
        }
        let Some(resonance) = &self.torsional_resonance else {
            return;
        };
        let key = "torsional_resonance.f_hz";
        c.between(key, resonance.f_hz, 1e-3, 1e6, "give the mode's frequency");
        let key = "torsional_resonance.damping_ratio";
        c.between(
            key,
            resonance.damping_ratio,
            0.0,
            1.0,
            "1 is critical damping",
        );
        let share = resonance.inertia_share;
        let key = "torsional_resonance.inertia_share";
        c.between(
            key,
            share,
            1e-6,
            0.999,
            "give the far side's part of the inertia",
        );
        if let Some(psd) = resonance.load_psd_n2_m2_s {
            let key = "torsional_resonance.load_psd_n2_m2_s";
            c.between(key, psd, 0.0, 1e12, "a density can't be negative");
        }
        if let Some(hold) = resonance.load_hold_s {
            let key = "torsional_resonance.load_hold_s";
            c.between(
                key,
                hold,
                1e-9,
                TIME_MAX,
                "leave it out for a 50th of the period",
            );
        }
    }

    fn check_open_loop(&self, c: &mut Checker<'_>, key: &str) {
        c.require(
            self.follows_a_speed(),
            key,
            "with this drive",
            "a drive that follows a speed in open loop",
            "take it out, or change the drive",
        );
    }
}
