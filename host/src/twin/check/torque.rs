//! Ranges and conflicts of ripple, loads and noise.

use super::{Checker, TIME_MAX, TORQUE_MAX};
use crate::twin::{Drive, Noise, Twin};

impl Twin {
    pub(super) fn check_ripple(&self, c: &mut Checker<'_>) {
        for (i, ripple) in self.ripple.iter().enumerate() {
            c.positive(
                &format!("ripple[{i}].order"),
                ripple.order,
                1e5,
                "give cycles a turn",
            );
            c.between(
                &format!("ripple[{i}].phase_rad"),
                ripple.phase_rad,
                -1e3,
                1e3,
                "give radians",
            );
            let sizes = (ripple.torque_n_m, ripple.speed_fraction);
            self.check_size(c, &format!("ripple[{i}]"), sizes);
        }
    }

    /// One of a torque and a relative speed swing.
    pub(super) fn check_size(
        &self,
        c: &mut Checker<'_>,
        key: &str,
        sizes: (Option<f64>, Option<f64>),
    ) {
        match sizes {
            (Some(torque), None) => {
                c.between(
                    &format!("{key}.torque_n_m"),
                    torque,
                    0.0,
                    TORQUE_MAX,
                    "turn the sign by the phase",
                );
            }
            (None, Some(fraction)) => {
                let key = format!("{key}.speed_fraction");
                c.between(
                    &key,
                    fraction,
                    0.0,
                    0.9,
                    "give the swing over the nominal speed",
                );
                let turning = self.may_turn();
                c.require(
                    turning,
                    &key,
                    fraction,
                    "torque_n_m for a drive at 0 r/min",
                    "use torque_n_m",
                );
            }
            (torque, _) => c.require(
                false,
                key,
                if torque.is_some() {
                    "both sizes"
                } else {
                    "no size"
                },
                "one of torque_n_m and speed_fraction",
                "give it one size",
            ),
        }
    }

    /// Whether the drive has a speed that sizes may be relative to; nothing is said against it where the drive is not known.
    fn may_turn(&self) -> bool {
        self.drive.nominal_rad_s() != 0.0 || self.drive == Drive::Unknown
    }

    pub(super) fn check_loads(&self, c: &mut Checker<'_>) {
        for (i, load) in self.load_step.iter().enumerate() {
            let key = |name: &str| format!("load_step[{i}].{name}");
            c.between(
                &key("torque_n_m"),
                load.torque_n_m,
                -TORQUE_MAX,
                TORQUE_MAX,
                "give the torque on the shaft, negative to brake a shaft turning forward",
            );
            c.between(
                &key("from_s"),
                load.from_s,
                0.0,
                TIME_MAX,
                "say when the load comes",
            );
            if let Some(until) = load.until_s {
                c.require(
                    until > load.from_s && until <= TIME_MAX,
                    &key("until_s"),
                    until,
                    &format!("after from_s and up to {TIME_MAX:?}"),
                    "leave it out for a load that stays",
                );
            }
        }
    }

    pub(super) fn check_noise(&self, c: &mut Checker<'_>) {
        match self.noise {
            None => {}
            Some(Noise::White {
                psd_n2_m2_s,
                hold_s,
            }) => {
                c.between(
                    "noise.white.psd_n2_m2_s",
                    psd_n2_m2_s,
                    0.0,
                    1e12,
                    "a density can't be negative",
                );
                self.check_hold(c, "noise.white.hold_s", hold_s);
            }
            Some(Noise::SpeedWander {
                rms_fraction,
                correlation_rad,
                hold_s,
            }) => {
                c.between(
                    "noise.speed_wander.rms_fraction",
                    rms_fraction,
                    0.0,
                    0.3,
                    "give the RMS over the nominal speed",
                );
                self.check_hold(c, "noise.speed_wander.hold_s", hold_s);
                self.check_wander(c, rms_fraction, correlation_rad);
            }
        }
    }

    fn check_hold(&self, c: &mut Checker<'_>, key: &str, hold_s: Option<f64>) {
        match hold_s {
            Some(hold) => c.between(
                key,
                hold,
                1e-9,
                TIME_MAX,
                "leave it out for one nominal interval",
            ),
            None => c.require(
                self.may_turn(),
                key,
                "missing",
                "a time, as this drive has no nominal interval",
                "give the step of the noise's grid",
            ),
        }
    }

    fn check_wander(&self, c: &mut Checker<'_>, rms_fraction: f64, correlation_rad: Option<f64>) {
        let nominal = self.drive.nominal_rad_s().abs();
        let (key, s) = ("noise.speed_wander", &self.shaft);
        c.require(
            self.may_turn(),
            key,
            rms_fraction,
            "a drive that turns",
            "use noise.white",
        );
        c.require(
            self.follows_a_speed(),
            key,
            rms_fraction,
            "a drive that follows a speed in open loop",
            "use noise.white: here the drive shapes the wander itself",
        );
        match correlation_rad {
            Some(correlation) => {
                let key = "noise.speed_wander.correlation_rad";
                c.positive(
                    key,
                    correlation,
                    1e6,
                    "give the angle over which the speed forgets",
                );
                let longest = s.inertia_or_one() * nominal / s.viscous_n_m_s;
                c.require(
                    correlation <= longest
                        || self.drive == Drive::Unknown
                        || s.viscous_n_m_s == 0.0,
                    key,
                    correlation,
                    &format!("up to J w / viscous = {longest:?}"),
                    "lower it or the viscous friction, or raise the inertia",
                );
                c.require(
                    s.stiffness_n_m_s == 0.0,
                    key,
                    correlation,
                    "only where shaft.stiffness_n_m_s is left out",
                    "take out one: the correlation sets the stiffness",
                );
            }
            None => c.require(
                s.viscous_n_m_s + s.stiffness_n_m_s > 0.0,
                key,
                rms_fraction,
                "a shaft with viscous_n_m_s or stiffness_n_m_s, or a correlation_rad",
                "give correlation_rad: without friction a wander grows for ever",
            ),
        }
    }
}
