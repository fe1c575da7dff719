//! What changes at an edge of each class, and patterns that are made edge by edge.

use super::seen::Seen;

/// Channel and kind of change of a class, seen forward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// 0 is A.
    pub channel: usize,
    /// Whether the level rises.
    pub rises: bool,
}

impl Change {
    /// Whether it is on a channel; none is all of them.
    #[must_use]
    pub fn on(self, channel: Option<usize>) -> bool {
        channel.is_none_or(|channel| channel == self.channel)
    }
}

/// What changes at an edge of a class, of so many.
#[must_use]
pub fn change_of(class: usize, classes: i64) -> Change {
    let (channel, rises) = match classes {
        4 => (class % 2, class < 2),
        // A fall, B rise, C fall, A rise, B fall, C rise.
        6 => (class % 3, class % 2 == 1),
        2 => (0, class == 0),
        _ => (0, true),
    };
    Change { channel, rises }
}

/// Channels of a sensor with so many classes.
#[must_use]
pub fn channels(classes: i64) -> usize {
    match classes {
        4 => 2,
        6 => 3,
        _ => 1,
    }
}

/// A pattern of one column, edge by edge.
#[must_use]
pub fn by_edge(seen: &Seen, value: impl Fn(usize, Change) -> f64) -> Vec<Vec<f64>> {
    let each = (0..seen.len()).map(|at| value(at, change_of(seen.class(at), seen.classes)));
    vec![each.collect()]
}

/// Columns of cos and sin of a phase that is given edge by edge.
#[must_use]
pub fn round(seen: &Seen, phase_rad: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
    let (mut cos, mut sin) = (vec![0.0; seen.len()], vec![0.0; seen.len()]);
    for at in 0..seen.len() {
        (sin[at], cos[at]) = phase_rad(at).sin_cos();
    }
    vec![cos, sin]
}
