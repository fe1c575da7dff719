//! One recording as the engine sees it: edges with their time, their angle on the grid, and how the level changed.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::edges::Edges;
use super::held_up::{Held, Task};
pub use crate::effect::Change;
use crate::effect::{Effect, Here};
use crate::mechanism::Mechanism;
use crate::twin::Twin;

/// Places along a recording at which something is looked at that is much the same from one to the next.
pub const PLACES: usize = 32;

/// A recording.
#[derive(Clone, Debug)]
pub struct Record {
    /// Time of each edge, s on the recording's clock.
    pub time_s: Vec<f64>,
    /// Place on the grid, edges, turns counted through.
    pub place: Vec<i64>,
    /// 1 forward, -1 in reverse.
    pub way: Vec<f64>,
    /// Edges a turn, N.
    pub edges: i64,
    /// Edge classes.
    pub classes: i64,
    /// RMS error of each stamp beside the others', s.
    pub doubt_s: Vec<f64>,
    /// Those that a declared task held up.
    pub held: Vec<Held>,
    /// Length of a tick, s.
    pub tick_s: f64,
    /// Whether places are angles of the disc.
    pub anchored: bool,
    /// The sensor's edges a turn, of which these N are looked at.
    pub of_edges: i64,
    /// Which of the sensor's edges they are, in order; empty where all are looked at.
    pub looked_at: Arc<[i64]>,
}

impl Record {
    /// The edges of a recording, their turns counted from the one in which its twin starts; without an index or a gap, from the angle at
    /// which it does.
    pub fn of(edges: &Edges, twin: &Twin) -> Self {
        let (grid, classes) = (i64::from(edges.grid_edges), i64::from(edges.classes));
        let way = |forward: bool| if forward { 1.0 } else { -1.0 };
        let first = edges.place.first().map_or(0, |place| *place);
        let start_turns = twin.shaft.initial_angle_rad / TAU;
        let shift = if edges.anchored {
            // A disc that runs out may have it behind that angle.
            let [_, run_out] = Mechanism::Bearing.card().range("runout_rad");
            let lead = first as f64 / grid as f64 - start_turns + run_out / TAU;
            -(lead.floor() as i64) * grid
        } else {
            // The shaft starts between the first edge and the one before it; the edge's class says which of those nearby it is.
            let starts = match (edges.time_s.as_slice(), edges.forward.first()) {
                ([first_s, second_s, ..], Some(forward)) => {
                    // The first row, if it is an edge, is an interval earlier.
                    let earlier = (first_s - edges.begins_s) / (second_s - first_s);
                    (0.5 + earlier.clamp(0.0, 1.0)) * way(*forward)
                }
                _ => 0.0,
            };
            let before = first as f64 - starts;
            ((start_turns * grid as f64 - before) / classes as f64).round() as i64 * classes
        };
        let time_s = &edges.time_s;
        let held = Task::of(twin).map(|task| {
            let near_s = twin.timer.jitter_s.hypot(edges.tick_s);
            task.held(time_s, near_s)
        });
        Self {
            time_s: time_s.clone(),
            doubt_s: vec![0.0; time_s.len()],
            held: held.unwrap_or_default(),
            place: edges.place.iter().map(|place| place + shift).collect(),
            way: edges.forward.iter().map(|forward| way(*forward)).collect(),
            edges: grid,
            classes,
            tick_s: edges.tick_s,
            anchored: edges.anchored,
            of_edges: grid,
            looked_at: Arc::default(),
        }
    }

    /// Some of the edges, about evenly along the disc and of all classes alike: as a disc with fewer lines would give them. So many a turn, or
    /// a few less.
    #[must_use]
    pub fn of_some(&self, edges: i64) -> Self {
        let apart = |edges: &i64| edges % 2 == 1 && gcd(*edges, self.edges) == 1;
        let edges = (1..=edges).rev().find(apart).unwrap_or(1);
        let slots = (0..edges).map(|at| (at * self.edges / edges) as usize);
        let looked_at: Vec<i64> = slots.clone().map(|slot| self.edge_of(slot)).collect();
        let mut numbers = vec![None; self.edges as usize];
        for (number, slot) in slots.enumerate() {
            numbers[slot] = Some(number as i64);
        }
        let mut some = Self {
            time_s: Vec::new(),
            place: Vec::new(),
            way: Vec::new(),
            doubt_s: Vec::new(),
            edges,
            looked_at: looked_at.into(),
            ..self.clone()
        };
        for at in 0..self.len() {
            if let Some(number) = numbers[self.slot(at)] {
                some.time_s.push(self.time_s[at]);
                some.place
                    .push(self.place[at].div_euclid(self.edges) * edges + number);
                some.way.push(self.way[at]);
                some.doubt_s.push(self.doubt_s[at]);
            }
        }
        some
    }

    /// Errors of a disc's edges, of those that are looked at.
    pub fn pick(&self, errors: &[f64]) -> Vec<f64> {
        if errors.len() == self.edges as usize {
            return errors.to_vec();
        }
        // Of a pulse a tooth only the rise is seen.
        let every = (errors.len() / self.of_edges.max(1) as usize).max(1);
        let errors: Vec<f64> = errors.iter().copied().step_by(every).collect();
        if self.looked_at.is_empty() {
            return errors;
        }
        let each = self.looked_at.iter();
        each.map(|slot| errors.get(*slot as usize).copied().unwrap_or(0.0))
            .collect()
    }

    /// Errors of a disc's edges as each edge shows them.
    pub fn shown(&self, errors: &[f64]) -> Vec<f64> {
        let each = (0..self.len()).map(|at| errors.get(self.slot(at)).copied());
        each.map(Option::unwrap_or_default).collect()
    }

    /// Edges.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Angle of an edge on the grid, rad, turns counted through.
    pub fn grid_rad(&self, at: usize) -> f64 {
        let turns = self.place[at].div_euclid(self.edges) as f64;
        turns * TAU + self.angle_of(self.slot(at))
    }

    /// Angle of an edge of the disc on the grid, rad.
    pub fn angle_of(&self, slot: usize) -> f64 {
        self.edge_of(slot) as f64 * (TAU / self.of_edges as f64)
    }

    /// A step of the grid, rad.
    pub fn step_rad(&self) -> f64 {
        TAU / self.edges as f64
    }

    /// The edge of the disc, 0 to N - 1.
    pub fn slot(&self, at: usize) -> usize {
        self.place[at].rem_euclid(self.edges) as usize
    }

    /// Edge of the sensor's disc that an edge of this one is.
    pub fn edge_of(&self, slot: usize) -> i64 {
        self.looked_at.get(slot).map_or(slot as i64, |edge| *edge)
    }

    /// By how much an effect that is part of the disc has an edge of it off its place, rad.
    pub fn error_of(&self, slot: usize, effect: &Effect, sizes: &[f64]) -> f64 {
        let here = Here {
            time_s: 0.0,
            inside_s: 0.0,
            angle: self.angle_of(slot),
            speed: 1.0,
            way: 1.0,
        };
        effect.sized(sizes, here) * effect.ahead(self.change_of(slot))
    }

    /// What changes at an edge of the disc, as passed forward.
    pub fn change_of(&self, slot: usize) -> Change {
        let class = self.edge_of(slot).rem_euclid(self.classes);
        change(class as usize, self.classes)
    }

    /// What changes at an edge, as passed forward.
    pub fn change(&self, at: usize) -> Change {
        self.change_of(self.slot(at))
    }

    /// What changes at an edge, as it was captured: in reverse a rise is a fall.
    pub fn captured(&self, at: usize) -> Change {
        let change = self.change(at);
        Change {
            rises: change.rises == (self.way[at] > 0.0),
            ..change
        }
    }

    /// Channels.
    pub const fn channels(&self) -> u8 {
        match self.classes {
            4 => 2,
            6 => 3,
            _ => 1,
        }
    }

    /// Time from the first edge to the last, s.
    pub fn seconds(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Turns travelled, either way.
    pub fn turns(&self) -> f64 {
        let ways = self.place.windows(2).map(|pair| pair[1].abs_diff(pair[0]));
        ways.sum::<u64>() as f64 / self.edges as f64
    }
}

fn gcd(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// What changes at an edge of a class, as passed forward.
pub fn change(class: usize, classes: i64) -> Change {
    let (channel, rises) = match classes {
        4 => (class % 2, class < 2),
        // B rise, C fall, A rise, B fall, C rise, A fall: edge 0 is the step from 001 to 011.
        6 => ([1, 2, 0][class % 3], class.is_multiple_of(2)),
        2 => (0, class == 0),
        _ => (0, true),
    };
    Change {
        channel: channel as u8,
        rises,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three turns of a disc with 400 edges, the last one back.
    fn record() -> Record {
        let place: Vec<i64> = (-150..650).chain((250..650).rev()).collect();
        let count = place.len();
        Record {
            time_s: (0..count).map(|at| at as f64).collect(),
            way: (0..count)
                .map(|at| if at < 800 { 1.0 } else { -1.0 })
                .collect(),
            place,
            edges: 400,
            classes: 4,
            doubt_s: vec![0.0; count],
            held: Vec::new(),
            tick_s: 1e-8,
            anchored: true,
            of_edges: 400,
            looked_at: Arc::default(),
        }
    }

    #[test]
    fn some_edges_keep_their_angle_class_and_error() {
        let all = record();
        let some = all.of_some(58);
        assert_eq!(some.edges, 57);
        assert_eq!(some.len(), 3 * 57);
        let errors: Vec<f64> = (0..400).map(f64::from).collect();
        let picked = some.pick(&errors);
        assert_eq!(some.pick(&picked), picked);
        for at in 0..some.len() {
            let same = some.time_s[at] as usize;
            assert!((some.grid_rad(at) - all.grid_rad(same)).abs() < 1e-12);
            assert_eq!(some.change(at), all.change(same));
            assert_eq!(picked[some.slot(at)], errors[all.slot(same)]);
            assert_eq!(some.way[at], all.way[same]);
        }
    }

    #[test]
    fn some_of_some_edges_are_edges_of_the_same_disc() {
        let all = record();
        let few = all.of_some(301).of_some(58);
        for at in 0..few.len() {
            let same = few.time_s[at] as usize;
            assert!((few.grid_rad(at) - all.grid_rad(same)).abs() < 1e-12);
            assert_eq!(few.change(at), all.change(same));
        }
    }

    #[test]
    fn some_edges_are_evenly_spaced_and_of_all_classes() {
        // Numbers of edges with which every so manieth one would be of one class.
        for edges in [128, 200, 256, 399] {
            let some = record().of_some(edges);
            assert!(some.edges > edges - 6, "{} of {edges}", some.edges);
            let even = TAU / some.edges as f64;
            let mut of_class = [0; 4];
            for slot in 0..some.edges as usize {
                let off = some.angle_of(slot) - slot as f64 * even;
                assert!(off.abs() < TAU / 400.0);
                let change = some.change_of(slot);
                of_class[usize::from(change.channel) * 2 + usize::from(change.rises)] += 1;
            }
            let mean = some.edges / 4;
            assert!(
                of_class.iter().all(|count| (count - mean).abs() <= 1),
                "{of_class:?}"
            );
        }
    }
}
