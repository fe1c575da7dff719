//! Known delays of the edges: an edge belongs to the time at which its mark passed, and the shaft's real speed, noise and all, went on
//! until it was captured.

use super::classes::change_of;
use super::track::{Mark, Track};
use crate::twin::{RiseFall, Twin};

/// Part of the way between two captures that two marks are apart at the least, whatever the delays.
const LEAST: f64 = 1e-3;

/// How late a twin captures the edges of each class, s.
#[derive(Clone, Debug)]
pub struct Delays {
    forward_s: Vec<f64>,
    reverse_s: Vec<f64>,
}

impl Delays {
    /// Of a twin with so many edge classes.
    #[must_use]
    pub fn of(twin: &Twin, classes: i64) -> Self {
        let delay = twin.edge_delay.unwrap_or_default();
        let skew = twin.channel_skew.unwrap_or_default();
        let channels: [(RiseFall, f64); 3] = [
            (delay.a, skew.a_s),
            (delay.b, skew.b_s),
            (delay.c, skew.c_s),
        ];
        let late_s = |reverse: bool| {
            let each = (0..classes).map(|class| {
                let change = change_of(class as usize, classes);
                let (delay, skew_s) = channels[change.channel];
                // Backwards a rise is passed as a fall.
                let rises = change.rises != reverse;
                skew_s + if rises { delay.rise_s } else { delay.fall_s }
            });
            each.collect()
        };
        Self {
            forward_s: late_s(false),
            reverse_s: late_s(true),
        }
    }

    /// Of the edge at a place, passed in a direction, s.
    #[must_use]
    pub fn late_s(&self, place: i64, direction: i64) -> f64 {
        let way = if direction < 0 {
            &self.reverse_s
        } else {
            &self.forward_s
        };
        let class = place.rem_euclid(way.len() as i64) as usize;
        way.get(class).copied().unwrap_or(0.0)
    }

    /// Marks at the times at which they passed; in their order.
    #[must_use]
    pub fn passed(&self, marks: &[(Mark, i64)]) -> Vec<(Mark, i64)> {
        let mut last: Option<(f64, f64)> = None;
        let each = marks.iter().map(|(mark, direction)| {
            let captured_s = mark.time_s;
            let mut time_s = captured_s - self.late_s(mark.place, *direction);
            if let Some((before_s, captured_before_s)) = last {
                time_s = time_s.max(before_s + LEAST * (captured_s - captured_before_s));
            }
            last = Some((time_s, captured_s));
            let place = mark.place;
            (Mark { time_s, place }, *direction)
        });
        each.collect()
    }

    /// Share of a recording's edges that would have passed before the one before them.
    #[must_use]
    pub fn disordered(&self, track: &Track) -> f64 {
        let pairs = track.stretches.iter().flat_map(|s| {
            let late_s = move |mark: &Mark| self.late_s(mark.place, s.direction);
            let pairs = s.marks.windows(2);
            pairs.map(move |pair| {
                pair[1].time_s - late_s(&pair[1]) <= pair[0].time_s - late_s(&pair[0])
            })
        });
        let (mut all, mut wrong) = (0_usize, 0_usize);
        pairs.for_each(|before| {
            all += 1;
            wrong += usize::from(before);
        });
        wrong as f64 / all.max(1) as f64
    }
}
