//! Ranges and conflicts of shaft, drive and duration.

use super::{ANGLE_ADVICE, Checker, DAMPING_MAX, TIME_MAX, TORQUE_MAX};
use crate::twin::{Drive, Duration, Twin};

impl Twin {
    pub(super) fn check_shaft(&self, c: &mut Checker<'_>) {
        let s = &self.shaft;
        c.positive(
            "shaft.inertia_kg_m2",
            s.inertia_kg_m2,
            1e9,
            "give the inertia of all that turns",
        );
        c.between(
            "shaft.viscous_n_m_s",
            s.viscous_n_m_s,
            0.0,
            TORQUE_MAX,
            "friction can't be negative",
        );
        c.between(
            "shaft.coulomb_n_m",
            s.coulomb_n_m,
            0.0,
            TORQUE_MAX,
            "friction can't be negative",
        );
        c.between(
            "shaft.stiffness_n_m_s",
            s.stiffness_n_m_s,
            0.0,
            TORQUE_MAX,
            "leave it out for pure torque mode",
        );
        let damping = (s.viscous_n_m_s + s.stiffness_n_m_s) / s.inertia_kg_m2;
        c.require(
            damping <= DAMPING_MAX,
            if s.viscous_n_m_s > s.stiffness_n_m_s {
                "shaft.viscous_n_m_s"
            } else {
                "shaft.stiffness_n_m_s"
            },
            s.viscous_n_m_s.max(s.stiffness_n_m_s),
            &format!(
                "up to {:?} with this inertia",
                DAMPING_MAX * s.inertia_kg_m2
            ),
            "lower it or raise the inertia: the time constant is below a microsecond",
        );
        c.between(
            "shaft.initial_angle_rad",
            s.initial_angle_rad,
            -1e3,
            1e3,
            ANGLE_ADVICE,
        );
        c.require(
            s.stiffness_n_m_s == 0.0 || !matches!(self.drive, Drive::SpeedLoop { .. }),
            "shaft.stiffness_n_m_s",
            s.stiffness_n_m_s,
            "0 with a speed loop",
            "take it out: the loop itself holds the speed",
        );
    }

    pub(super) fn check_friction(&self, c: &mut Checker<'_>) {
        let s = &self.shaft;
        for (key, value) in [
            ("shaft.drag_n_m_s2", s.drag_n_m_s2),
            ("shaft.stribeck_n_m", s.stribeck_n_m),
        ] {
            c.between(key, value, 0.0, TORQUE_MAX, "friction can't be negative");
        }
        c.between(
            "shaft.stribeck_rad_s",
            s.stribeck_rad_s,
            0.0,
            1e6,
            "give the speed over which the friction goes",
        );
        c.require(
            s.stribeck_n_m == 0.0 || s.stribeck_rad_s >= 1e-6,
            "shaft.stribeck_rad_s",
            s.stribeck_rad_s,
            "1e-6 or more with stribeck_n_m",
            "give the speed over which the friction goes",
        );
        let speed = self.drive.nominal_rad_s().abs().max(1.0);
        let most = 0.5 * DAMPING_MAX * s.inertia_kg_m2 / speed;
        c.require(
            s.drag_n_m_s2 <= most,
            "shaft.drag_n_m_s2",
            s.drag_n_m_s2,
            &format!("up to {most:?} with this inertia and speed"),
            "lower it or raise the inertia: the time constant is below a microsecond",
        );
        let most = DAMPING_MAX * s.inertia_kg_m2 * s.stribeck_rad_s;
        c.require(
            s.stribeck_n_m <= most,
            "shaft.stribeck_n_m",
            s.stribeck_n_m,
            &format!("up to {most:?} with this inertia and stribeck_rad_s"),
            "lower it or raise stribeck_rad_s: the time constant is below a microsecond",
        );
    }

    pub(super) fn check_drive(&self, c: &mut Checker<'_>) {
        match &self.drive {
            Drive::Constant { r_min } => c.speed("drive.constant.r_min", *r_min),
            Drive::Ramp {
                from_r_min,
                to_r_min,
                over_s,
            } => {
                c.speed("drive.ramp.from_r_min", *from_r_min);
                c.speed("drive.ramp.to_r_min", *to_r_min);
                c.positive(
                    "drive.ramp.over_s",
                    *over_s,
                    TIME_MAX,
                    "give the ramp a length",
                );
            }
            Drive::Steps(steps) => {
                c.require(
                    !steps.is_empty(),
                    "drive.steps",
                    "[]",
                    "one step or more",
                    "list { t_s, r_min } entries",
                );
                let mut last = 0.0;
                for (i, step) in steps.iter().enumerate() {
                    let key = format!("drive.steps[{i}].t_s");
                    c.between(
                        &key,
                        step.t_s,
                        last,
                        TIME_MAX,
                        "times start at 0 or later and do not fall",
                    );
                    c.speed(&format!("drive.steps[{i}].r_min"), step.r_min);
                    last = step.t_s;
                }
            }
            Drive::RunDown { r_min, off_s } => {
                c.speed("drive.run_down.r_min", *r_min);
                c.between(
                    "drive.run_down.off_s",
                    *off_s,
                    0.0,
                    TIME_MAX,
                    "say when the drive goes off",
                );
            }
            Drive::SpeedLoop { .. } => self.check_loop(c),
        }
        let nominal = self.drive.nominal_rad_s();
        if let Duration::Turns(turns) = self.duration {
            c.positive("duration.turns", turns, 1e9, "say how many turns to record");
            c.require(
                nominal != 0.0,
                "duration.turns",
                turns,
                "seconds for a drive at 0 r/min",
                "use duration.seconds",
            );
        }
        if let Duration::Seconds(seconds) = self.duration {
            c.positive(
                "duration.seconds",
                seconds,
                TIME_MAX,
                "say how many seconds to record",
            );
        }
    }

    fn check_loop(&self, c: &mut Checker<'_>) {
        let Drive::SpeedLoop {
            r_min,
            f_hz,
            bandwidth_hz,
            kp_n_m_s,
            ki_n_m,
            timeout_s,
            limit_n_m,
        } = self.drive
        else {
            return;
        };
        c.speed("drive.speed_loop.r_min", r_min);
        c.require(
            r_min != 0.0,
            "drive.speed_loop.r_min",
            r_min,
            "not 0",
            "give the speed the loop holds",
        );
        c.between(
            "drive.speed_loop.f_hz",
            f_hz,
            1.0,
            1e7,
            "give the loop's sample rate",
        );
        if let Some(bandwidth) = bandwidth_hz {
            c.positive(
                "drive.speed_loop.bandwidth_hz",
                bandwidth,
                f_hz / 6.0,
                "a sampled loop is stable below f_hz / 6",
            );
            c.require(
                kp_n_m_s.is_none() && ki_n_m.is_none(),
                "drive.speed_loop.bandwidth_hz",
                bandwidth,
                "the bandwidth alone, or kp_n_m_s with ki_n_m",
                "take out one of the two ways to set the gains",
            );
        } else {
            for (key, gain) in [
                ("drive.speed_loop.kp_n_m_s", kp_n_m_s),
                ("drive.speed_loop.ki_n_m", ki_n_m),
            ] {
                c.require(
                    gain.is_some(),
                    key,
                    "missing",
                    "both gains, or bandwidth_hz",
                    "give the loop its gains",
                );
                c.between(
                    key,
                    gain.unwrap_or(0.0),
                    0.0,
                    1e9,
                    "give a gain of 0 or more",
                );
            }
        }
        if let Some(timeout) = timeout_s {
            c.positive(
                "drive.speed_loop.timeout_s",
                timeout,
                TIME_MAX,
                "leave it out for 20 intervals",
            );
        }
        if let Some(limit) = limit_n_m {
            c.positive(
                "drive.speed_loop.limit_n_m",
                limit,
                TORQUE_MAX,
                "leave it out for no limit",
            );
        }
    }
}
