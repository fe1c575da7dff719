//! Constant pushes from edge to edge.

use crate::diagnose::shaft::Leap;

/// Edges, and what a constant push does from each to the next.
#[derive(Clone, Debug)]
pub struct Spans {
    /// The edges.
    pub edges: Vec<usize>,
    /// From the one before each; the first has none before it.
    pub(super) held: Vec<Held>,
}

/// What a constant push does over a time: angles from speed and push, and what stays of the speed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    reach: f64,
    stays: f64,
    far: f64,
}

impl Held {
    pub(super) fn over(after_s: f64, damping: f64) -> Self {
        let leap = Leap {
            after_s,
            damping,
            spring: None,
        };
        let (reach, stays) = leap.reach(after_s);
        let x = damping * after_s;
        let far = if x < 0.01 {
            0.5 * after_s * after_s * (1.0 - x / 3.0 + x * x / 12.0)
        } else {
            (after_s - reach) / damping
        };
        Self { reach, stays, far }
    }

    /// Angle and speed after a push.
    pub(super) fn pushed(self, [angle, speed]: [f64; 2], push: f64) -> [f64; 2] {
        [
            angle + self.reach * speed + self.far * push,
            self.stays * speed + self.reach * push,
        ]
    }
}
