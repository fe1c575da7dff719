//! Marks of a class on their own, where shifts may change the order of marks or move them while the shaft turns.
//!
//! A mark is passed when the way to its place and its shift at that very time are covered: a root of the motion less the shift.

use std::f64::consts::TAU;

use quadcal::edge::{Direction, Levels};

use super::Class;
use super::crossing::direction_of;
use super::disc::{Disc, Mark};
use super::shaft::Shaft;
use super::shift::{Passing, Shifts};
use super::taylor::Piece;

/// Newton's last step, rad; its error goes with the square of it.
const CLOSE_RAD: f64 = 1e-11;

/// The marks of one class.
#[derive(Clone, Debug)]
struct Track {
    class: Class,
    marks: Vec<Mark>,
    /// The first place that the shaft has not passed, going forward.
    place: i64,
    /// When the next mark of the current piece is passed, s from its start; not worked out yet.
    next: Option<Option<f64>>,
}

impl Track {
    fn split(&self, place: i64) -> (f64, &Mark) {
        let marks = self.marks.len() as i64;
        let turn = place.div_euclid(marks);
        (turn as f64, &self.marks[(place - turn * marks) as usize])
    }

    /// Angle of a place, rad, through all turns, unshifted.
    fn angle_rad(&self, place: i64, disc: &Disc) -> f64 {
        let (turn, mark) = self.split(place);
        disc.mark_angle_rad(turn, mark)
    }

    /// Place on the grid of a place, rad, through all turns.
    fn grid_rad(&self, place: i64) -> f64 {
        let (turn, mark) = self.split(place);
        Disc::grid_rad(turn, mark)
    }

    fn place_to(&self, direction: Direction) -> i64 {
        match direction {
            Direction::Forward => self.place,
            Direction::Reverse => self.place - 1,
        }
    }
}

/// The shaft's motion over a piece, and when it is.
#[derive(Clone, Copy)]
pub(super) struct Motion<'a> {
    pub(super) disc: &'a Disc,
    pub(super) shaft: &'a Shaft,
    pub(super) piece: &'a Piece,
    /// Time of the piece's start, s.
    pub(super) from_s: f64,
    pub(super) direction: Direction,
}

/// All tracks, and the shifts.
#[derive(Clone, Debug)]
pub(super) struct Tracks {
    tracks: Vec<Track>,
    shifts: Shifts,
    /// Where in the piece the last mark was passed, s.
    last_s: f64,
}

impl Tracks {
    /// Tracks of a disc with the shaft at an angle and a speed.
    pub(super) fn new(disc: &Disc, shifts: Shifts, angle_rad: f64, speed: f64) -> Self {
        let mut tracks: Vec<Track> = Vec::new();
        for mark in disc.marks() {
            match tracks.iter_mut().find(|track| track.class == mark.class) {
                Some(track) => track.marks.push(*mark),
                None => tracks.push(Track {
                    class: mark.class,
                    marks: vec![*mark],
                    place: 0,
                    next: None,
                }),
            }
        }
        let mut all = Self {
            tracks,
            shifts,
            last_s: 0.0,
        };
        let start = Passing {
            time_s: 0.0,
            grid_rad: angle_rad,
            angle_rad,
            speed,
            acceleration: 0.0,
            direction: direction_of(speed),
        };
        all.place(disc, &start, |_| true);
        all
    }

    /// Finds the places of some classes anew.
    fn place(&mut self, disc: &Disc, now: &Passing, which: impl Fn(Class) -> bool) {
        let angle_rad = now.angle_rad;
        for track in self.tracks.iter_mut().filter(|track| which(track.class)) {
            let of = |grid_rad: f64| {
                let passing = Passing { grid_rad, ..*now };
                self.shifts.of(track.class, &passing).value
            };
            let shift = of(angle_rad);
            let beyond = |track: &Track| {
                let shift = of(track.grid_rad(track.place));
                track.angle_rad(track.place, disc) + shift > angle_rad
            };
            // Two turns back is behind any shift and run-out.
            let turn = ((angle_rad - shift) / TAU).floor() as i64 - 2;
            track.place = turn * track.marks.len() as i64;
            while !beyond(track) {
                track.place += 1;
            }
            track.next = None;
        }
    }

    /// Levels of all channels as the places have it.
    pub(super) fn levels(&self, disc: &Disc) -> Levels {
        let mut levels = 0;
        for rise in &self.tracks {
            let (bit, rises) = rise.class.bit_and_rise();
            let index = |class| matches!(class, Class::IndexRise | Class::IndexFall);
            let falls = self.tracks.iter().find(|fall| {
                fall.class.bit_and_rise() == (bit, false) && index(fall.class) == index(rise.class)
            });
            let last = |track: &Track| track.angle_rad(track.place - 1, disc);
            if rises && falls.is_some_and(|fall| last(rise) > last(fall)) {
                levels |= bit;
            }
        }
        Levels(levels)
    }

    /// Time of the next slip of the index, s.
    pub(super) fn next_slip_s(&self) -> f64 {
        self.shifts.next_slip_s()
    }

    /// Lets the index slip; the mark that then changes its level, if one does.
    pub(super) fn slip(&mut self, disc: &Disc, now: &Passing) -> Option<Mark> {
        let before = self.levels(disc);
        self.shifts.slip();
        let index = |class| matches!(class, Class::IndexRise | Class::IndexFall);
        self.place(disc, now, index);
        let after = self.levels(disc);
        let class = match (before == after, after.0 & Levels::Z != 0) {
            (true, _) => return None,
            (_, true) => Class::IndexRise,
            (_, false) => Class::IndexFall,
        };
        disc.marks()
            .iter()
            .find(|mark| mark.class == class)
            .copied()
    }

    /// A new piece of motion begins.
    pub(super) fn begin(&mut self) {
        self.last_s = 0.0;
        for track in &mut self.tracks {
            track.next = None;
        }
    }

    /// The next mark that is passed within the piece and when, s from its start.
    pub(super) fn next(&mut self, motion: Motion<'_>) -> Option<(f64, Mark)> {
        let mut first: Option<(f64, usize)> = None;
        for i in 0..self.tracks.len() {
            let next = match self.tracks[i].next {
                Some(next) => next,
                None => self.passed(i, motion),
            };
            self.tracks[i].next = Some(next);
            if let Some(tau) = next
                && first.is_none_or(|(earliest, _)| tau < earliest)
            {
                first = Some((tau, i));
            }
        }
        let (tau, i) = first?;
        let track = &self.tracks[i];
        Some((tau, *track.split(track.place_to(motion.direction)).1))
    }

    /// Takes the mark that [`Self::next`] gave as passed.
    pub(super) fn pass(&mut self, class: Class, tau: f64, direction: Direction) {
        self.last_s = tau;
        if let Some(track) = self.tracks.iter_mut().find(|track| track.class == class) {
            track.place += i64::from(direction.sign());
            track.next = None;
        }
    }

    /// When the next mark of a track is passed within the piece.
    fn passed(&self, track: usize, motion: Motion<'_>) -> Option<f64> {
        let track = &self.tracks[track];
        let Motion {
            piece, direction, ..
        } = motion;
        let place = track.place_to(direction);
        let way = motion.shaft.way_to(track.angle_rad(place, motion.disc));
        let ahead = f64::from(direction.sign());
        // How far beyond the mark, in the direction of motion, and at which speed.
        let grid_rad = track.grid_rad(place);
        let beyond = |tau: f64| {
            let passing = Passing {
                time_s: motion.from_s + tau,
                grid_rad,
                angle_rad: motion.shaft.angle_after(piece.travel(tau)),
                speed: piece.speed(tau),
                acceleration: piece.acceleration(tau),
                direction: Some(direction),
            };
            let shift = self.shifts.of(track.class, &passing);
            (
                ahead * (piece.travel(tau) - way - shift.value),
                ahead * (piece.speed(tau) - shift.rate),
            )
        };
        let (mut low, mut high) = (self.last_s, piece.length_s);
        if beyond(high).0 < 0.0 {
            return None;
        }
        if beyond(low).0 >= 0.0 {
            return Some(low);
        }
        let mut tau = piece.time_of(way).clamp(low, high);
        for _ in 0..200 {
            let (miss, speed) = beyond(tau);
            if miss < 0.0 {
                low = tau;
            } else {
                high = tau;
            }
            let newton = tau - miss / speed;
            let next = if newton >= low && newton <= high {
                newton
            } else {
                0.5 * (low + high)
            };
            let moved = (next - tau).abs();
            tau = next;
            if (next == newton && moved * speed.abs() <= CLOSE_RAD) || moved == 0.0 {
                break;
            }
        }
        Some(tau)
    }
}
