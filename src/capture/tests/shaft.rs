//! Edges of a shaft that turns this way and that.

use std::vec::Vec;

use crate::capture::Channel;
use crate::edge::{Levels, Sample};

/// Lines of the encoder.
pub const LINES: u32 = 8;

/// Levels after edge 0, 1, 2, 3.
const STATES: [u8; 4] = [1, 3, 2, 0];

/// A change of one channel's level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    pub ticks: u64,
    pub channel: Channel,
    /// Levels after it.
    pub levels: Levels,
}

impl Edge {
    pub fn sample(&self) -> Sample {
        Sample {
            ticks: self.ticks,
            levels: self.levels,
        }
    }
}

/// A linear congruential generator.
pub struct Random(pub u64);

impl Random {
    /// A number from `from` on and below `to`.
    pub fn within(&mut self, from: u64, to: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        from + (self.0 >> 33) % (to - from)
    }
}

/// The shaft.
pub struct Shaft {
    pub ticks: u64,
    position: i64,
    levels: u8,
    pub edges: Vec<Edge>,
}

impl Shaft {
    pub const START: Levels = Levels(0);

    pub fn new(ticks: u64) -> Self {
        Self {
            ticks,
            position: -1,
            levels: Self::START.0,
            edges: Vec::new(),
        }
    }

    fn change(&mut self, channel: Channel, ticks: u64) {
        self.levels ^= channel.bit();
        self.edges.push(Edge {
            ticks,
            channel,
            levels: Levels(self.levels),
        });
    }

    /// One edge further, `interval` ticks after the last one; Z changes between edges, and is high in position 0.
    pub fn step(&mut self, forward: bool, interval: u64) {
        let turn = i64::from(4 * LINES);
        let before = self.position;
        self.position += if forward { 1 } else { -1 };
        let at_index = |position: i64| position.rem_euclid(turn) == 0;
        if at_index(before) {
            self.change(Channel::Z, self.ticks + interval / 2);
        }
        self.ticks += interval;
        let state = STATES[self.position.rem_euclid(4) as usize];
        let channel = if (state ^ self.levels) & Levels::A != 0 {
            Channel::A
        } else {
            Channel::B
        };
        self.change(channel, self.ticks);
        if at_index(self.position) {
            self.change(Channel::Z, self.ticks + interval / 8);
        }
    }

    /// Turns for `edges` edges at intervals around `interval`, and turns round now and then.
    pub fn wander(&mut self, random: &mut Random, edges: u32, interval: u64) {
        let mut forward = true;
        for _ in 0..edges {
            if random.within(0, 90) == 0 {
                forward = !forward;
            }
            let spread = random.within(interval / 2, interval * 3 / 2);
            self.step(forward, spread);
        }
    }

    /// Steady motion for `edges` edges.
    pub fn cruise(&mut self, edges: u32, interval: u64) {
        for _ in 0..edges {
            self.step(true, interval);
        }
    }
}
