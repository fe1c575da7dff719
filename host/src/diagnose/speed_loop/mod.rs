//! What a speed loop did, from the very edges that it saw.

mod find;
mod gains;

pub use find::find;

use std::sync::Arc;

use quadcal::edge::Direction;

use super::noise::FAR;
use super::record::Record;
use crate::twin::{Gains, SeenSpeed, SpeedLoop, Twin};

/// What a loop did.
#[derive(Clone, Debug, Default)]
pub struct Along {
    /// Acceleration from each sample on, rad/s^2.
    pub push: Vec<f64>,
    /// Samples that may have come just before or just after an edge.
    pub ties: Vec<Tie>,
}

/// A loop that drives a shaft of which the twin says no drive.
#[derive(Clone, Debug)]
pub struct Unsaid {
    /// It, as far as it is known.
    pub own: SpeedLoop,
    /// Speed asked for less speed seen at each sample, rad/s.
    miss: Arc<[f64]>,
}

impl Unsaid {
    /// Of what a loop saw of a recording.
    pub fn of(own: SpeedLoop, record: &Record, twin: &Twin) -> Self {
        let plain = SpeedLoop {
            gains: Gains { kp: 1.0, ki: 0.0 },
            limit: f64::INFINITY,
            start: 0.0,
            ..own
        };
        let miss = along(&plain, record, twin, 0.0).push.into();
        Self { own, miss }
    }

    /// Acceleration from each sample on with some gains, rad/s^2.
    pub fn push(&self, gains: Gains) -> Vec<f64> {
        let mut integral = self.own.start;
        let each = self.miss.iter().map(|miss| {
            let push = gains.kp * miss + integral;
            integral += gains.ki / self.own.rate_hz * miss;
            push
        });
        each.collect()
    }

    /// The same where some samples were the other way.
    #[must_use]
    pub fn tied(&self, others: &[Tie]) -> Self {
        let mut miss = self.miss.to_vec();
        for tie in others {
            let at = (tie.at_s * self.own.rate_hz).round() as usize;
            if let Some(miss) = miss.get_mut(at) {
                *miss += tie.push / self.own.gains.kp;
            }
        }
        Self {
            miss: miss.into(),
            ..self.clone()
        }
    }
}

/// A sample that may have seen an edge or not.
#[derive(Clone, Copy, Debug)]
pub struct Tie {
    /// When, s.
    pub at_s: f64,
    /// Time to the next sample, s.
    pub step_s: f64,
    /// Change of the acceleration over that time if it was the other way, rad/s^2.
    pub push: f64,
    /// What stays of it in the loop's integral, rad/s^2.
    pub lasting: f64,
}

/// A loop along the edges that it saw, whose stamps have an RMS error.
pub fn along(own: &SpeedLoop, record: &Record, twin: &Twin, stamp_s: f64) -> Along {
    let clock_hz = twin.timer.clock_hz as f64;
    let mut seen = SeenSpeed::new(clock_hz, record.step_rad(), own.timeout_s, Some(0));
    let until = record.time_s.last().copied().unwrap_or(0.0);
    let count = (until * own.rate_hz).floor() as usize + 1;
    // A sample may have missed an edge as long as its stamp is not far out.
    let late_s = FAR * twin.timer.jitter_s.max(stamp_s);
    let mut integral = own.start;
    let mut edge = 0;
    let mut last: Option<i64> = None;
    let mut out = Along::default();
    for sample in 0..count {
        let now_s = sample as f64 / own.rate_hz;
        let now = (now_s * clock_hz).floor();
        let mut before = own.target_rad_s;
        let mut newest = f64::NEG_INFINITY;
        while edge < record.len() && record.time_s[edge] <= now_s {
            let place = record.place[edge];
            let steps = last.map_or(1, |last| place.abs_diff(last).max(1) as u32);
            let way = if record.way[edge] > 0.0 {
                Direction::Forward
            } else {
                Direction::Reverse
            };
            newest = record.time_s[edge];
            before = seen.at(now).unwrap_or(own.target_rad_s);
            seen.edge((newest * clock_hz).round() as u64, way, steps);
            last = Some(place);
            edge += 1;
        }
        let speed = seen.at(now).unwrap_or(own.target_rad_s);
        // A stamp is rounded down: the edge came up to a tick later.
        let missed = now_s - newest < 1.0 / clock_hz + late_s;
        let soon = edge < record.len() && record.time_s[edge] - now_s < late_s;
        if missed || soon {
            let change = if missed {
                speed - before
            } else {
                // To the speed that the next edge shows.
                let from = edge.saturating_sub(1);
                let h = record.time_s[edge] - record.time_s[from];
                let way = (record.place[edge] - record.place[from]) as f64 * record.step_rad();
                if h > 0.0 { way / h - speed } else { -speed }
            };
            // Seen, its speed was taken off; not seen, it was not.
            let sign = if missed { 1.0 } else { -1.0 };
            out.ties.push(Tie {
                at_s: now_s,
                step_s: 1.0 / own.rate_hz,
                push: sign * own.gains.kp * change,
                lasting: sign * own.gains.ki * change / own.rate_hz,
            });
        }
        let miss = own.target_rad_s - speed;
        let asked = own.gains.kp * miss + integral;
        let given = asked.clamp(-own.limit, own.limit);
        if given == asked || miss * asked < 0.0 {
            integral += own.gains.ki / own.rate_hz * miss;
        }
        out.push.push(given);
    }
    out
}
