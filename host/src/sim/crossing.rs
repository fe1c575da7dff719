//! Where the shaft's motion crosses the marks of the disc, and what goes off to the timer.

use quadcal::edge::{Direction, Levels};

use super::disc::Mark;
use super::shift::Passing;
use super::track::Motion;
use super::{Simulation, Truth};

/// A mark that was passed: what goes off to the timer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passed {
    pub(super) truth: Truth,
    pub(super) stamp: u64,
    pub(super) arrival_s: f64,
}

/// A change of level that has arrived.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub(super) truth: Truth,
    pub(super) stamp: u64,
    pub(super) arrival_s: f64,
    pub(super) levels: Levels,
}

impl Simulation {
    /// Sends off changes of level within the current piece of motion until one has arrived; none if that takes longer.
    pub(super) fn crossing_in_piece(&mut self) -> Option<Crossing> {
        let direction = direction_of(self.piece_travel)?;
        loop {
            if self.tracks.is_some() {
                self.pass_shifted(direction)?;
            } else {
                self.pass(direction)?;
            }
            let arrived = self.signals.due();
            if arrived.is_some() {
                return arrived;
            }
        }
    }

    /// Passes the next mark; none if the piece or the run is over before.
    fn pass(&mut self, direction: Direction) -> Option<()> {
        let place = match direction {
            Direction::Forward => self.place,
            Direction::Reverse => self.place - 1,
        };
        let way = self.shaft.way_to(self.disc.angle_rad(place));
        let past_end = match direction {
            Direction::Forward => way > self.piece_travel,
            Direction::Reverse => way < self.piece_travel,
        };
        if past_end || self.beyond_end(way) {
            return None;
        }
        self.place += i64::from(direction.sign());
        let mark = *self.disc.mark(place);
        self.send_crossing(mark, direction, self.piece.time_of(way), way);
        Some(())
    }

    /// As [`Self::pass`], where marks are shifted.
    fn pass_shifted(&mut self, direction: Direction) -> Option<()> {
        let motion = Motion {
            disc: &self.disc,
            shaft: &self.shaft,
            piece: &self.piece,
            from_s: self.segment_start_s + self.within_s.plus(0.0),
            direction,
        };
        let (tau, mark) = self.tracks.as_mut()?.next(motion)?;
        let way = self.piece.travel(tau);
        if self.beyond_end(way) {
            return None;
        }
        self.tracks.as_mut()?.pass(mark.class, tau, direction);
        self.send_crossing(mark, direction, tau, way);
        Some(())
    }

    /// Whether the run's travel ends before a mark; if so, the run does.
    fn beyond_end(&mut self, way: f64) -> bool {
        let beyond = self.travelled.plus(way.abs()) > self.travel_end;
        self.done |= beyond;
        beyond
    }

    /// Lets the index slip at the start of a segment.
    pub(super) fn slip(&mut self) {
        let now = self.segment_start_s;
        let angle = self.shaft.angle_after(0.0);
        let Some(tracks) = &mut self.tracks else {
            return;
        };
        let now = Passing {
            time_s: now,
            grid_rad: angle,
            angle_rad: angle,
            speed: self.shaft.speed(),
            acceleration: 0.0,
            direction: direction_of(self.shaft.motion()),
        };
        if let Some(mark) = tracks.slip(&self.disc, &now) {
            self.send_crossing(mark, Direction::Forward, 0.0, 0.0);
        }
    }

    /// Sends off the change of level of a mark that is passed `tau` s after the piece's start, `way` from there.
    fn send_crossing(&mut self, mark: Mark, direction: Direction, tau: f64, way: f64) {
        let time_s = self.segment_start_s + self.within_s.plus(tau);
        let passing = Passing {
            time_s,
            grid_rad: self.shaft.angle_after(way),
            angle_rad: self.shaft.angle_after(way),
            speed: self.piece.speed(tau),
            acceleration: self.piece.acceleration(tau),
            direction: Some(direction),
        };
        let arrival_s = time_s + self.signals.delay_s(&mark, &passing);
        let (captured_s, stamp) = self.capture.stamp(arrival_s);
        let taken = mark.edge.is_none() || self.capture.takes_edge(time_s);
        if let (Some(k), Some(speed_loop)) = (mark.edge, &mut self.speed_loop)
            && taken
        {
            let steps = self.disc.steps_into(k, direction);
            speed_loop.edge(captured_s, stamp, direction, steps);
        }
        let passed = Passed {
            truth: Truth {
                time_s,
                angle_rad: self.shaft.angle_after(way),
                edge: mark.edge,
                class: mark.class,
            },
            stamp,
            arrival_s,
        };
        self.signals.send(passed, &mark, direction, taken);
    }
}

/// Direction of a way or speed; none at standstill.
pub(super) fn direction_of(way: f64) -> Option<Direction> {
    if way > 0.0 {
        Some(Direction::Forward)
    } else if way < 0.0 {
        Some(Direction::Reverse)
    } else {
        None
    }
}
