//! Where the shaft's motion crosses the marks of the disc, and what goes off to the timer.

use quadcal::edge::{Direction, Levels};

use super::{Simulation, Truth};

/// A change of level on its way to its row.
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
        let direction = if self.piece_travel > 0.0 {
            Direction::Forward
        } else if self.piece_travel < 0.0 {
            Direction::Reverse
        } else {
            return None;
        };
        loop {
            let place = match direction {
                Direction::Forward => self.place,
                Direction::Reverse => self.place - 1,
            };
            let way = self.shaft.way_to(self.disc.angle_rad(place));
            let past_end = match direction {
                Direction::Forward => way > self.piece_travel,
                Direction::Reverse => way < self.piece_travel,
            };
            if past_end {
                return None;
            }
            if self.travelled.plus(way.abs()) > self.travel_end {
                self.done = true;
                return None;
            }
            self.place += i64::from(direction.sign());
            self.send_crossing(place, direction, way);
            let arrived = self.signals.due();
            if arrived.is_some() {
                return arrived;
            }
        }
    }

    /// Sends off the change of level at a place `way` from the piece's start.
    fn send_crossing(&mut self, place: i64, direction: Direction, way: f64) {
        let time_s = self.segment_start_s + self.within_s.plus(self.piece.time_of(way));
        let mark = *self.disc.mark(place);
        let arrival_s = time_s + self.signals.delay_s(&mark, direction);
        let stamp = self.capture.stamp(arrival_s);
        let taken = mark.edge.is_none() || self.capture.takes_edge(time_s);
        if let (Some(k), Some(speed_loop)) = (mark.edge, &mut self.speed_loop)
            && taken
        {
            speed_loop.edge(stamp, direction, self.disc.steps_into(k, direction));
        }
        let levels = self.disc.levels_after(place, direction);
        let crossing = Crossing {
            truth: Truth {
                time_s,
                angle_rad: self.shaft.angle_after(way),
                edge: mark.edge,
                class: mark.class,
            },
            stamp,
            arrival_s,
            levels,
        };
        self.signals.send(crossing, &mark, direction, levels, taken);
    }
}
