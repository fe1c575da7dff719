//! The signals between head and timer: each change of level arrives after its own delay, in the order of arrival.

use std::collections::VecDeque;

use quadcal::edge::{Direction, Levels};

use super::Truth;
use super::crossing::{Crossing, Passed};
use super::disc::Mark;
use super::effects::{Sized, at};
use super::shift::Passing;
use crate::effect::number::{Number, Series};
use crate::effect::{self, Here, Site};
use crate::twin::Twin;

/// A change of one channel on its way.
#[derive(Clone, Copy, Debug)]
struct Change {
    truth: Truth,
    stamp: u64,
    arrival_s: f64,
    bit: u8,
    high: bool,
    /// Whether the capture takes it.
    taken: bool,
}

/// All channels, with what is on its way.
#[derive(Clone, Debug)]
pub(super) struct Signals {
    /// Delay of the fall and the rise of A, B and C, s.
    delays_s: [[f64; 2]; 3],
    /// Z shares its bit with C, and has no delay.
    third: bool,
    /// By arrival; of one channel, rises and falls take turns.
    coming: VecDeque<Change>,
    /// Levels as they arrived.
    levels: Levels,
    /// What happens later arrives later than this, s.
    horizon_s: f64,
    /// Effects on the time of stamps.
    effects: Vec<Sized>,
    /// How far stamps may be ahead of their changes, s.
    lead_s: f64,
}

impl Signals {
    /// Signals of a twin whose levels at time 0 are these.
    pub(super) fn new(twin: &Twin, levels: Levels) -> Self {
        let edge = twin.edge_delay.unwrap_or_default();
        let skew = twin.channel_skew.unwrap_or_default();
        let channels = [(edge.a, skew.a_s), (edge.b, skew.b_s), (edge.c, skew.c_s)];
        Self {
            delays_s: channels.map(|(edge, skew_s)| [edge.fall_s + skew_s, edge.rise_s + skew_s]),
            third: matches!(twin.encoder, crate::twin::Encoder::Hall { .. }),
            coming: VecDeque::new(),
            levels,
            horizon_s: 0.0,
            effects: at(twin, |site| matches!(site, Site::Stamp(_))),
            lead_s: 0.0,
        }
    }

    /// Delay of the change that a mark makes when it is passed, s.
    pub(super) fn delay_s(&mut self, mark: &Mark, passing: &Passing) -> f64 {
        let Some(direction) = passing.direction else {
            return 0.0;
        };
        let (bit, high) = change_at(mark, direction);
        let channel = match bit {
            Levels::A => 0,
            Levels::B => 1,
            _ if self.third => 2,
            _ => return 0.0,
        };
        let mut delay_s = self.delays_s[channel][usize::from(high)];
        if self.effects.is_empty() {
            return delay_s;
        }
        let captured = effect::Change {
            channel: channel as u8,
            rises: high,
        };
        let here = Here {
            time_s: Series::new(&[passing.time_s]),
            inside_s: passing.time_s,
            angle: Series::new(&[passing.angle_rad]),
            speed: Series::new(&[passing.speed]),
            way: f64::from(direction.sign()),
        };
        for (effect, sizes) in &self.effects {
            if matches!(effect.site, Site::Stamp(on) if on.has(captured)) {
                delay_s += effect.sized(sizes, here).value();
            }
        }
        // What grows so is seen coming: twice what was, for what is next.
        self.lead_s = self.lead_s.max(-2.0 * delay_s);
        delay_s
    }

    /// Sends the change that a mark makes. Changes are sent in order of time.
    ///
    /// Where the change before on the same channel would arrive later than this one, the pulse between them is too short to be
    /// seen: neither arrives.
    pub(super) fn send(&mut self, passed: Passed, mark: &Mark, direction: Direction, taken: bool) {
        let (bit, high) = change_at(mark, direction);
        self.horizon_s = passed.truth.time_s;
        let before = self.coming.iter().rposition(|change| change.bit == bit);
        if let Some(before) = before.filter(|&i| self.coming[i].arrival_s > passed.arrival_s) {
            self.coming.remove(before);
            return;
        }
        let at = self
            .coming
            .partition_point(|change| change.arrival_s <= passed.arrival_s);
        let change = Change {
            truth: passed.truth,
            stamp: passed.stamp,
            arrival_s: passed.arrival_s,
            bit,
            high,
            taken,
        };
        self.coming.insert(at, change);
    }

    /// The next captured change, if nothing can come before it any more.
    pub(super) fn due(&mut self) -> Option<Crossing> {
        self.arrived_by(self.horizon_s - self.lead_s)
    }

    /// The next captured change when no more are sent.
    pub(super) fn rest(&mut self) -> Option<Crossing> {
        self.arrived_by(f64::INFINITY)
    }

    fn arrived_by(&mut self, time_s: f64) -> Option<Crossing> {
        while self.coming.front()?.arrival_s <= time_s {
            let change = self.coming.pop_front()?;
            let before = self.levels.0;
            self.levels.0 = if change.high {
                before | change.bit
            } else {
                before & !change.bit
            };
            // A slip may bring an index to where its level is that already.
            if change.taken && self.levels.0 != before {
                return Some(Crossing {
                    truth: change.truth,
                    stamp: change.stamp,
                    arrival_s: change.arrival_s,
                    levels: self.levels,
                });
            }
        }
        None
    }
}

/// Which bit changes where a mark is passed in a direction, and whether it goes high.
fn change_at(mark: &Mark, direction: Direction) -> (u8, bool) {
    let (bit, rises) = mark.class.bit_and_rise();
    (bit, rises == (direction == Direction::Forward))
}
