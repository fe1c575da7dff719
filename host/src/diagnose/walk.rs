//! The count along a recording's mended rows.

use quadcal::edge::{Direction, Levels, Sample};
use quadcal::step::{Flags, Glitch, Outcome, Step};

use super::index::{Moved, Pass, moves};
use super::mend::{Fault, FaultKind, Piece};
use super::track::{Mark, Stretch, Track};
use crate::sensor::Decoder;

/// Follows the count.
pub(super) struct Walker {
    track: Track,
    /// None where every row is one edge on.
    decoder: Option<Decoder>,
    has_z: bool,
    turns: i64,
    last_edge: Option<i64>,
    /// Whether the last stretch goes on, and with which place.
    next: Option<i64>,
    /// Position in edges from the start, whatever edge of the disc that is.
    count: i64,
    /// The last step: when, which way, and how many edges it stood for.
    last: Option<(f64, i64, i64)>,
    referenced: bool,
    /// Whether an edge came since.
    indexed: bool,
    z: Option<bool>,
    passes: Vec<Pass>,
    /// Passes since the last step: their place between edges is not known yet.
    open: Vec<(f64, bool)>,
}

impl Walker {
    pub fn new(track: Track, decoder: Option<Decoder>, has_z: bool) -> Self {
        Self {
            track,
            decoder,
            has_z,
            turns: 0,
            last_edge: None,
            next: None,
            count: 0,
            last: None,
            referenced: false,
            indexed: false,
            z: None,
            passes: Vec::new(),
            open: Vec::new(),
        }
    }

    /// Walks all rows.
    pub fn walk(mut self, pieces: &[Piece]) -> Track {
        for piece in pieces {
            let mut sample = piece.row;
            let z = self.has_z && sample.levels.z();
            // Once it has said where the disc is, the index is watched but not obeyed.
            if self.has_z && self.referenced {
                sample.levels = Levels(sample.levels.0 & !Levels::Z);
            }
            let outcome = match &mut self.decoder {
                Some(decoder) => decoder.push(sample),
                None => self.one_on(sample),
            };
            match outcome {
                Outcome::Step(step) => self.step(&step, piece.captured),
                Outcome::Glitch(glitch) => self.take_back(glitch),
                Outcome::Index(index) => self.referenced |= index.flags.contains(Flags::REFERENCED),
                Outcome::Idle => {}
            }
            if self.z.is_some_and(|before| before != z) {
                self.open.push((self.seconds(sample), z));
            }
            self.z = Some(z);
        }
        let moved = moves(&self.passes, self.track.edges);
        self.sort_out(moved);
        self.track
    }

    /// One edge on: a wheel whose rows are mended. Edges of even number rise.
    fn one_on(&self, sample: Sample) -> Outcome {
        let edge = match self.last_edge {
            Some(last) => (last + 1) % self.track.edges,
            None => i64::from(!sample.levels.a()),
        };
        let edge = u32::try_from(edge).unwrap_or(0);
        Outcome::Step(Step {
            ticks: sample.ticks,
            edge,
            position: edge,
            interval: 0,
            resync: 0,
            advance: 1,
            flags: Flags::NONE,
            direction: Direction::Forward,
        })
    }

    fn seconds(&self, sample: Sample) -> f64 {
        sample.ticks as f64 * self.track.tick_s
    }

    fn step(&mut self, step: &Step, captured: bool) {
        let direction = i64::from(step.direction.sign());
        let time_s = step.ticks as f64 * self.track.tick_s;
        self.place_passes(time_s, direction);
        let advance = i64::from(step.advance);
        self.count += direction * advance;
        self.last = Some((time_s, direction, advance));
        if !self.has_z {
            self.note(step);
        }
        let edge = i64::from(step.edge);
        // Over the turn's end the number jumps back, or forth.
        if let Some(last) = self.last_edge {
            let jump = edge - last;
            if 2 * jump.abs() > self.track.edges {
                self.turns -= jump.signum();
            }
        }
        self.last_edge = Some(edge);
        self.referenced |= step.flags.contains(Flags::REFERENCED);
        if self.track.anchored && !step.flags.contains(Flags::REFERENCED) {
            if captured {
                let place = self.count;
                self.track.early.push(Mark { time_s, place });
            }
            return;
        }
        let place = self.turns * self.track.edges + edge;
        if !self.indexed {
            self.indexed = true;
            let ahead = place - self.count;
            (self.track.early.iter_mut()).for_each(|mark| mark.place += ahead);
        }
        let goes_on = self.next == Some(place)
            && (self.track.stretches.last()).is_some_and(|s| s.direction == direction);
        self.next = Some(place + direction);
        let mark = Mark { time_s, place };
        match self.track.stretches.last_mut() {
            Some(stretch) if goes_on => {
                if captured {
                    stretch.marks.push(mark);
                }
            }
            _ if captured => self.track.stretches.push(Stretch {
                marks: vec![mark],
                direction,
            }),
            _ => self.next = None,
        }
    }

    /// What only the decoder sees: a wheel's pulses lost, and its gap at the wrong place.
    fn note(&mut self, step: &Step) {
        if step.flags.contains(Flags::SPIKE) && step.advance > 1 {
            self.track.faults.push(Fault {
                kind: FaultKind::Lost,
                ticks: step.ticks,
                edges: u32::from(step.advance) - 1,
                number: None,
                channel: 0,
                doubtful: false,
            });
        }
        if step.resync != 0 {
            let lost = (step.resync > 0) == (step.direction.sign() > 0);
            self.track.faults.push(Fault {
                kind: if lost {
                    FaultKind::Lost
                } else {
                    FaultKind::Extra
                },
                ticks: step.ticks,
                edges: step.resync.unsigned_abs(),
                number: None,
                channel: 0,
                doubtful: true,
            });
        }
    }

    /// Takes back a step that the shaft made there and back.
    fn take_back(&mut self, glitch: Glitch) {
        if let Some((time_s, direction, advance)) = self.last {
            self.count -= direction * advance;
            let last = self.track.stretches.last_mut();
            if let Some(stretch) = last
                && stretch
                    .marks
                    .last()
                    .is_some_and(|mark| mark.time_s == time_s)
            {
                stretch.marks.pop();
                if stretch.marks.is_empty() {
                    self.track.stretches.pop();
                }
            }
        }
        self.next = None;
        let edge = i64::from(glitch.edge);
        if let Some(last) = self.last_edge
            && 2 * (edge - last).abs() > self.track.edges
        {
            self.turns -= (edge - last).signum();
        }
        self.last_edge = Some(edge);
    }

    /// Says where the ends of index pulses since the last step are, now that the next has come.
    fn place_passes(&mut self, time_s: f64, direction: i64) {
        let open = std::mem::take(&mut self.open);
        let Some((last_s, way, _)) = self.last else {
            return;
        };
        for (pass_s, rises) in open {
            let part = if way == direction && time_s > last_s {
                (pass_s - last_s) / (time_s - last_s)
            } else {
                0.5
            };
            let forward = way > 0;
            let at = if forward { part } else { 1.0 - part };
            self.passes.push(Pass {
                time_s: pass_s,
                at: self.count as f64 + at,
                upper: rises != forward,
                forward,
            });
        }
    }

    /// An index that came by whole lines elsewhere after the count was in doubt has not moved: the count was wrong since then.
    fn sort_out(&mut self, moved: Vec<Moved>) {
        for moved in moved {
            let [from_s, to_s] = moved.between_s;
            let tick_s = self.track.tick_s;
            let doubt = self.track.faults.iter_mut().find(|fault| {
                let time_s = fault.ticks as f64 * tick_s;
                fault.doubtful && from_s <= time_s && time_s <= to_s
            });
            let whole = i64::from(moved.edges) % self.track.classes == 0;
            let Some(doubt) = doubt.filter(|_| whole) else {
                self.track.moved.push(moved);
                continue;
            };
            doubt.edges += moved.edges.unsigned_abs();
            let since_s = doubt.ticks as f64 * tick_s;
            self.shift(since_s, to_s, -i64::from(moved.edges));
        }
        self.track
            .stretches
            .retain(|stretch| !stretch.marks.is_empty());
    }

    /// Moves places from a time on, and leaves out the edges before the count is known again.
    fn shift(&mut self, since_s: f64, known_s: f64, edges: i64) {
        let mut after = Vec::new();
        for stretch in &mut self.track.stretches {
            let start = stretch.marks.partition_point(|mark| mark.time_s < since_s);
            let mut marks = stretch.marks.split_off(start);
            let known = marks.partition_point(|mark| mark.time_s < known_s);
            marks.drain(..known);
            marks.iter_mut().for_each(|mark| mark.place += edges);
            after.push(Stretch {
                marks,
                direction: stretch.direction,
            });
        }
        self.track.stretches.extend(after);
        self.track
            .stretches
            .retain(|stretch| !stretch.marks.is_empty());
    }
}
