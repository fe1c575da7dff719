//! From changes of level to rows: ticks, jitter, lost edges and glitches.

use std::collections::VecDeque;

use quadcal::edge::Levels;

use super::latency::Latency;
use super::random::{Purpose, Stream};
use super::{Class, Event, Truth};
use crate::recording::Row;
use crate::twin::{Encoder, Faults, Twin};

/// The start or end of a glitch that is still to come.
#[derive(Clone, Copy, Debug)]
struct Toggle {
    time_s: f64,
    bit: u8,
}

/// The capture unit and its faults.
#[derive(Clone, Debug)]
pub(super) struct Capture {
    clock_hz: f64,
    mask: u64,
    jitter_s: f64,
    jitter: Stream,
    latency: Latency,
    faults: Faults,
    lost: Stream,
    glitch: Stream,
    channels: u8,
    edges: u64,
    last_row: u64,
    last_edge_s: f64,
    last_levels: Levels,
    inverted: u8,
    toggles: VecDeque<Toggle>,
}

impl Capture {
    pub(super) fn new(twin: &Twin) -> Self {
        let mut faults = twin.faults.clone();
        faults.lost_edges.sort_unstable();
        Self {
            clock_hz: twin.timer.clock_hz as f64,
            mask: match (twin.timer.raw_captures, twin.timer.bits) {
                (true, bits @ 1..64) => (1 << bits) - 1,
                _ => u64::MAX,
            },
            jitter_s: twin.timer.jitter_s,
            jitter: Stream::new(twin.seed, Purpose::Jitter),
            latency: Latency::new(twin),
            faults,
            lost: Stream::new(twin.seed, Purpose::LostEdge),
            glitch: Stream::new(twin.seed, Purpose::Glitch),
            channels: match twin.encoder {
                Encoder::Quadrature { .. } => 2,
                Encoder::Hall { .. } => 3,
                Encoder::Wheel { .. } => 1,
            },
            edges: 0,
            last_row: 0,
            last_edge_s: 0.0,
            last_levels: Levels(0),
            inverted: 0,
            toggles: VecDeque::new(),
        }
    }

    fn ticks(&self, time_s: f64) -> u64 {
        // `as` holds negative times at 0.
        (time_s * self.clock_hz).floor() as u64
    }

    /// When a change that arrives at a time is captured, s, and its time stamp, in full-width ticks.
    pub(super) fn stamp(&mut self, time_s: f64) -> (f64, u64) {
        let error = if self.jitter_s > 0.0 {
            self.jitter_s * self.jitter.normal()
        } else {
            0.0
        };
        let captured_s = self.latency.captured_s(time_s);
        (captured_s, self.ticks(captured_s + error))
    }

    /// Whether the edge that just came gets through; draws its faults.
    pub(super) fn takes_edge(&mut self, time_s: f64) -> bool {
        let number = self.edges;
        self.edges += 1;
        if self.faults.glitch_probability > 0.0 {
            let (hit, place, channel) =
                (self.glitch.unit(), self.glitch.unit(), self.glitch.unit());
            if hit < self.faults.glitch_probability {
                let start = time_s + place * (time_s - self.last_edge_s);
                let bit = 1 << (channel * f64::from(self.channels)) as u8;
                self.plan(start, bit);
                self.plan(start + self.faults.glitch_width_s, bit);
            }
        }
        self.last_edge_s = time_s;
        let by_chance =
            self.faults.lost_probability > 0.0 && self.lost.unit() < self.faults.lost_probability;
        !by_chance && self.faults.lost_edges.binary_search(&number).is_err()
    }

    fn plan(&mut self, time_s: f64, bit: u8) {
        let at = self
            .toggles
            .partition_point(|toggle| toggle.time_s <= time_s);
        self.toggles.insert(at, Toggle { time_s, bit });
    }

    /// The row of a change that got through.
    pub(super) fn row(&mut self, stamp: u64, levels: Levels) -> Row {
        self.last_levels = levels;
        self.last_row = self.last_row.max(stamp);
        Row {
            ticks: self.last_row & self.mask,
            levels: Levels(levels.0 ^ self.inverted),
        }
    }

    /// The next start or end of a glitch up to a time; `angle_rad` is about where the shaft is.
    pub(super) fn glitch_before(&mut self, time_s: f64, angle_rad: f64) -> Option<Event> {
        let toggle = *self
            .toggles
            .front()
            .filter(|toggle| toggle.time_s <= time_s)?;
        self.toggles.pop_front();
        self.inverted ^= toggle.bit;
        let stamp = self.ticks(toggle.time_s);
        Some(Event {
            row: self.row(stamp, self.last_levels),
            truth: Truth {
                time_s: toggle.time_s,
                angle_rad,
                edge: None,
                class: Class::Glitch,
            },
        })
    }
}
