//! The simulator: a twin in, edges with their true angles out.
//!
//! The shaft's equation J dw/dt = drive - b w - coulomb sgn(w) + ripple(theta) + load(t) + noise(t), with tones, springs, drag and
//! Stribeck friction where a twin has them, is integrated by Taylor series of 16 terms between the instants at which the drive, a load, the noise or the loop change, with a step that keeps the truncated
//! rest near 1e-16 rad; edges are roots of the series. Ten times finer steps move no edge by 1e-10 rad.
//!
//! Marks are passed at their angle less e(k); where a level, a play or a run-out shifts them, at the root of the motion less the shift
//! at that very time. Each mark changes its channel once for each passage.
//!
//! Same seed, same bytes: all random numbers are ChaCha8 streams of their own purpose, `sin`, `cos`, `exp` and `log` come from the
//! `libm` crate, and the rest is IEEE 754 addition, multiplication, division and square root, none fused. So the edges do not
//! depend on machine or system, on any target with 64-bit IEEE arithmetic (32-bit x86 without SSE2 is none).
//!
//! An [`Event`] holds the row as a capture unit would give it and, apart from it, the truth. Only the row may go into a recording.

mod capture;
mod crossing;
mod defect;
mod disc;
mod drive;
mod effects;
mod error_list;
mod event;
mod extended;
mod latency;
mod load;
mod plant;
mod profile;
mod random;
mod segment;
mod shaft;
mod shift;
mod signal;
mod spring;
mod start;
mod taylor;
#[cfg(test)]
mod tests;
mod tone;
mod track;

use std::f64::consts::TAU;

use crate::recording::Header;
use crate::twin::{Drive, Duration, Twin, TwinError};

pub use event::{Class, Event, Truth};
pub use plant::Plant;

use capture::Capture;
use crossing::Crossing;
use disc::Disc;
use drive::{Knot, Noise, SpeedLoop};
use extended::Extended;
use load::Loads;
use shaft::{LongSum, Shaft};
use shift::Shifts;
use signal::Signals;
use taylor::{Integrator, Piece};
use track::Tracks;

/// A running simulation: an iterator of events in the order of their capture.
#[derive(Clone, Debug)]
pub struct Simulation {
    name: String,
    header: Header,
    disc: Disc,
    knots: Vec<Knot>,
    knot: usize,
    speed_loop: Option<SpeedLoop>,
    loop_push: f64,
    loads: Loads,
    load_push: f64,
    noise: Option<Noise>,
    noise_push: f64,
    /// Noise on the far side of a torsional spring, and its acceleration there.
    far_noise: Option<(Noise, f64)>,
    shaft: Shaft,
    signals: Signals,
    capture: Capture,
    segment_start_s: f64,
    segment_end_s: f64,
    /// Time since the segment's start, s: small, so that rounding it moves no edge.
    within_s: LongSum,
    piece: Piece,
    piece_travel: f64,
    /// First place above the shaft's angle: the next one going forward.
    place: i64,
    /// In place of it, where marks are shifted.
    tracks: Option<Tracks>,
    travelled: LongSum,
    travel_end: f64,
    end_s: f64,
    /// When effects jump or kink, s, by time.
    instants: Vec<f64>,
    held: Option<Crossing>,
    last_angle: f64,
    done: bool,
    ran_away_s: Option<f64>,
}

impl Simulation {
    /// Sets up the run of a twin.
    ///
    /// # Errors
    /// As [`Twin::check`]; [`TwinError::Lacks`] without a drive or a duration; [`TwinError::ErrorList`] for an unusable `errors.csv`, [`TwinError::EdgesCross`] for errors so large that
    /// edges would change their order.
    pub fn new(twin: &Twin) -> Result<Self, TwinError> {
        Self::with_finer_steps(twin, 1)
    }

    /// As [`Self::new`], with integration steps `finer` times shorter, to check accuracy; drive, noise and loop keep their instants.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_finer_steps(twin: &Twin, finer: u32) -> Result<Self, TwinError> {
        twin.check()?;
        if twin.drive == Drive::Unknown {
            return Err(TwinError::Lacks {
                name: twin.name.clone(),
                key: "[drive]",
                advice: "a simulation needs what turns the shaft: add one, such as [drive.constant] with r_min = 60",
            });
        }
        if twin.duration == Duration::Unknown {
            return Err(TwinError::Lacks {
                name: twin.name.clone(),
                key: "duration",
                advice: "a simulation needs to know how much to record: add one, such as duration.turns = 12",
            });
        }
        let disc = Disc::new(twin)?;
        let plant = Plant::new(twin);
        let knots = drive::knots(twin, &plant);
        let ripples = plant.ripples(twin);
        let mut extended = Extended::new(twin, &plant);
        let start_speed = match &mut extended {
            Some(extended) => start::settled(twin, &plant, &knots[0], &ripples, extended),
            None => plant.start_speed(twin, &knots[0], &ripples),
        };
        let angle = twin.shaft.initial_angle_rad;
        let (travel_end, end_s) = match twin.duration {
            Duration::Turns(turns) => {
                let last_change = knots.last().map_or(0.0, |knot| knot.from_s);
                let way = turns * TAU;
                (way, last_change + 10.0 * way / plant.nominal.abs())
            }
            Duration::Seconds(seconds) => (f64::INFINITY, seconds),
            Duration::Unknown => (0.0, 0.0),
        };
        let tracks = Shifts::new(twin).map(|shifts| Tracks::new(&disc, shifts, angle, start_speed));
        let place = disc.place_above(angle);
        let levels = match &tracks {
            Some(tracks) => tracks.levels(&disc),
            None => disc.levels_before(place),
        };
        Ok(Self {
            name: twin.name.clone(),
            header: event::header_of(twin),
            place,
            knots,
            knot: 0,
            speed_loop: SpeedLoop::new(twin, &plant),
            loop_push: 0.0,
            loads: Loads::new(twin),
            load_push: 0.0,
            noise: plant.noise(twin),
            noise_push: 0.0,
            far_noise: plant.far_noise(twin).map(|noise| (noise, 0.0)),
            shaft: Shaft::new(
                Integrator::new(ripples, extended, finer),
                plant.coulomb,
                angle,
                start_speed,
            ),
            signals: Signals::new(twin, levels),
            tracks,
            capture: Capture::new(twin),
            segment_start_s: 0.0,
            segment_end_s: 0.0,
            within_s: LongSum::default(),
            piece: Piece::rest(0.0),
            piece_travel: 0.0,
            travelled: LongSum::default(),
            travel_end,
            end_s,
            instants: effects::instants(twin),
            held: None,
            last_angle: angle,
            done: false,
            ran_away_s: None,
            disc,
        })
    }

    /// The header of the recording: nothing of the truth is in it.
    #[must_use]
    pub fn header(&self) -> Header {
        self.header.clone()
    }

    /// Whether the run came to its end as it should, once there are no more events.
    ///
    /// # Errors
    /// [`TwinError::RanAway`] where torques drove the shaft past any speed.
    pub fn ended(&self) -> Result<(), TwinError> {
        match self.ran_away_s {
            Some(at_s) => Err(TwinError::RanAway {
                name: self.name.clone(),
                at_s,
            }),
            None => Ok(()),
        }
    }

    /// The encoder's true errors e(k), rad, for every edge of the grid, without what does not repeat each turn; 0 for the edges of missing
    /// teeth. Edge k happens at its grid
    /// angle 2 pi k / N minus e(k).
    #[must_use]
    pub fn true_errors(&self) -> Vec<f64> {
        self.disc.errors().to_vec()
    }
}

/// The true errors e(k) of a twin's encoder, rad, as [`Simulation::true_errors`]; the twin needs no drive.
///
/// # Errors
/// As [`Twin::check`]; [`TwinError::CsvFile`], [`TwinError::ErrorList`] or [`TwinError::EdgesCross`].
pub fn true_errors(twin: &Twin) -> Result<Vec<f64>, TwinError> {
    twin.check()?;
    Ok(Disc::new(twin)?.errors().to_vec())
}

/// RMS of the standard errors with which a twin's list has the errors of its encoder, rad; 0 where it says none.
///
/// # Errors
/// [`TwinError::CsvFile`] or [`TwinError::ErrorList`].
pub fn disc_spread_rad(twin: &Twin) -> Result<f64, TwinError> {
    twin.error_list_path()
        .map_or(Ok(0.0), |path| error_list::spread_rad(&path))
}

impl Iterator for Simulation {
    type Item = Event;

    fn next(&mut self) -> Option<Event> {
        if self.held.is_none() {
            self.held = self.signals.due();
        }
        while self.held.is_none() && !self.done {
            self.held = self.crossing_in_piece();
            if self.held.is_none() && !self.done {
                self.advance();
            }
        }
        if self.held.is_none() {
            self.held = self.signals.rest();
        }
        let until = self
            .held
            .map_or(f64::INFINITY, |crossing| crossing.arrival_s);
        if let Some(glitch) = self.capture.glitch_before(until, self.last_angle) {
            return Some(glitch);
        }
        let Crossing {
            truth,
            stamp,
            levels,
            ..
        } = self.held.take()?;
        self.last_angle = truth.angle_rad;
        Some(Event {
            row: self.capture.row(stamp, levels),
            truth,
        })
    }
}
