//! Ranges of what moves edges between disc and timer.

use std::f64::consts::{PI, TAU};

use super::{ANGLE_ADVICE, Checker, TIME_MAX};
use crate::twin::{CaptureLatency, Twin};

impl Twin {
    pub(super) fn check_defects(&self, c: &mut Checker<'_>) {
        for (i, defect) in self.local_defect.iter().enumerate() {
            let key = |name: &str| format!("local_defect[{i}].{name}");
            c.between(&key("angle_rad"), defect.angle_rad, -1e3, 1e3, ANGLE_ADVICE);
            c.positive(
                &key("width_rad"),
                defect.width_rad,
                PI,
                "give the bump's sigma",
            );
            c.between(&key("error_rad"), defect.error_rad, -PI, PI, ANGLE_ADVICE);
            c.channel(&key("channel"), defect.channel, &self.encoder);
        }
    }

    pub(super) fn check_thresholds(&self, c: &mut Checker<'_>) {
        let line_rad = TAU * f64::from(self.encoder.edges_per_line())
            / f64::from(self.encoder.grid_edges().max(1));
        // Half of what would bring the two edges of a pulse together.
        let largest = line_rad / 8.0;
        let advice = "lower it: the level leaves the signal";
        let mut left = largest;
        for (i, ripple) in self.threshold_ripple.iter().enumerate() {
            let key = |name: &str| format!("threshold_ripple[{i}].{name}");
            c.positive(&key("f_hz"), ripple.f_hz, 1e6, "give a frequency");
            c.phase(&key("phase_rad"), ripple.phase_rad);
            c.between(&key("angle_rad"), ripple.angle_rad, 0.0, left, advice);
            c.channel(&key("channel"), ripple.channel, &self.encoder);
            left -= ripple.angle_rad;
        }
        for (i, drift) in self.threshold_drift.iter().enumerate() {
            let key = |name: &str| format!("threshold_drift[{i}].{name}");
            c.between(&key("angle_rad"), drift.angle_rad, -left, left, advice);
            c.positive(
                &key("tau_s"),
                drift.tau_s,
                TIME_MAX,
                "give its time constant",
            );
            c.between(
                &key("from_s"),
                drift.from_s,
                0.0,
                TIME_MAX,
                "say when it begins",
            );
            c.channel(&key("channel"), drift.channel, &self.encoder);
            left -= drift.angle_rad.abs();
        }
    }

    pub(super) fn check_play(&self, c: &mut Checker<'_>) {
        if let Some(hysteresis) = &self.hysteresis {
            let key = "hysteresis.angle_rad";
            c.between(key, hysteresis.angle_rad, 0.0, 1.0, ANGLE_ADVICE);
            c.channel("hysteresis.channel", hysteresis.channel, &self.encoder);
        }
        if let Some(backlash) = &self.backlash {
            c.between("backlash.gap_rad", backlash.gap_rad, 0.0, PI, ANGLE_ADVICE);
        }
    }

    pub(super) fn check_slips(&self, c: &mut Checker<'_>) {
        let edges = self.encoder.grid_edges();
        for (i, slip) in self.index_slip.iter().enumerate() {
            let key = format!("index_slip[{i}].at_s");
            c.between(&key, slip.at_s, 0.0, TIME_MAX, "say when it slips");
            c.require(
                slip.edges != 0 && slip.edges.unsigned_abs() < edges,
                &format!("index_slip[{i}].edges"),
                slip.edges,
                &format!("within plus and minus {}, not 0", edges.saturating_sub(1)),
                "give steps of the grid, forward positive",
            );
            c.require(
                self.encoder.has_index(),
                &format!("index_slip[{i}]"),
                slip.edges,
                "only with an index",
                "give the encoder index = true, or take the slip out",
            );
        }
    }

    pub(super) fn check_latency(&self, c: &mut Checker<'_>) {
        let Some(CaptureLatency {
            mean_s,
            task_hz,
            busy_s,
            phase_s,
        }) = self.capture_latency
        else {
            return;
        };
        let key = "capture_latency";
        match (mean_s, task_hz, busy_s) {
            (Some(mean), None, None) if phase_s.is_none() => {
                c.between(
                    "capture_latency.mean_s",
                    mean,
                    0.0,
                    1.0,
                    "give a mean in seconds",
                );
            }
            (None, Some(rate), Some(busy)) => {
                c.between(
                    "capture_latency.task_hz",
                    rate,
                    1e-3,
                    1e7,
                    "give the task's rate",
                );
                c.require(
                    busy >= 0.0 && busy < 1.0 / rate,
                    "capture_latency.busy_s",
                    busy,
                    &format!("0 up to, not including, the period of {:?} s", 1.0 / rate),
                    "give how long the task blocks",
                );
                let phase = phase_s.unwrap_or(0.0);
                let advice = "give the time at which the task first blocks";
                c.between(
                    "capture_latency.phase_s",
                    phase,
                    -TIME_MAX,
                    TIME_MAX,
                    advice,
                );
            }
            _ => c.require(
                false,
                key,
                "these keys",
                "mean_s alone, or task_hz with busy_s and phase_s",
                "take one of the two kinds",
            ),
        }
    }
}
