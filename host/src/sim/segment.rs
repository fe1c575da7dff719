//! From one instant at which something changes to the next: drive, loads, noise, loop and slips.

use super::Simulation;
use super::shaft::{Forcing, LongSum};
use super::track::Tracks;

/// No shaft turns so fast, rad/s: ten times the fastest speed that a twin may ask for.
const FASTEST_RAD_S: f64 = 1e7 * std::f64::consts::TAU / 60.0;

impl Simulation {
    /// Ends the current piece and starts the next.
    pub(super) fn advance(&mut self) {
        if self.piece.length_s > 0.0 {
            self.shaft.finish(&self.piece);
        }
        self.travelled.add(self.piece_travel.abs());
        self.within_s.add(self.piece.length_s);
        let mut segment_s = self.segment_end_s - self.segment_start_s;
        let mut rest = segment_s - self.within_s.plus(0.0);
        // A rest this short is rounding: the segment is over.
        if rest <= 1e-12 * segment_s {
            self.start_segment();
            segment_s = self.segment_end_s - self.segment_start_s;
            rest = segment_s;
        }
        let now = self.segment_start_s + self.within_s.plus(0.0);
        if now >= self.end_s || self.travelled.plus(0.0) >= self.travel_end {
            self.done = true;
            return;
        }
        let knot = self.knots[self.knot];
        let far_push = self.far_noise.as_ref().map_or(0.0, |far| far.1);
        let inside_s = self.segment_start_s + 0.5 * segment_s;
        let (level, slope) = if self.shaft.prepare(&knot, now, inside_s, far_push) {
            (0.0, 0.0)
        } else {
            (knot.level + knot.slope * (now - knot.from_s), knot.slope)
        };
        let forcing = Forcing {
            level: level + self.load_push + self.noise_push + self.loop_push,
            slope,
            damping: knot.damping,
        };
        self.piece = self.shaft.next_piece(forcing, rest, segment_s);
        self.piece_travel = self.piece.travel(self.piece.length_s);
        if let Some(tracks) = &mut self.tracks {
            tracks.begin();
        }
        // Torques so large that they run away with the shaft end the run.
        let allowed = FASTEST_RAD_S * self.piece.length_s;
        if !self.piece_travel.is_finite() || self.piece_travel.abs() > allowed {
            (self.done, self.ran_away_s) = (true, Some(now));
        }
    }

    /// When the index slips next, s; infinite if it does not.
    fn next_slip_s(&self) -> f64 {
        self.tracks
            .as_ref()
            .map_or(f64::INFINITY, Tracks::next_slip_s)
    }

    /// Takes every change that is due and finds when the next one is.
    fn start_segment(&mut self) {
        let now = self.segment_end_s;
        let next_knot = |at: usize| {
            self.knots
                .get(at + 1)
                .map_or(f64::INFINITY, |knot| knot.from_s)
        };
        while next_knot(self.knot) <= now {
            self.knot += 1;
        }
        let mut end = self.end_s.min(next_knot(self.knot));
        while self.loads.next_s() <= now {
            self.load_push = self.loads.change();
        }
        end = end.min(self.loads.next_s());
        if let Some(noise) = &mut self.noise {
            while noise.next_s() <= now {
                self.noise_push = noise.change();
            }
            end = end.min(noise.next_s());
        }
        if let Some(speed_loop) = &mut self.speed_loop {
            while speed_loop.next_s() <= now {
                self.loop_push = speed_loop.sample();
            }
            end = end.min(speed_loop.next_s());
        }
        if let Some((noise, push)) = &mut self.far_noise {
            while noise.next_s() <= now {
                *push = noise.change();
            }
            end = end.min(noise.next_s());
        }
        let next = self.instants.partition_point(|time| *time <= now);
        end = end.min(self.instants.get(next).copied().unwrap_or(f64::INFINITY));
        self.segment_start_s = now;
        self.within_s = LongSum::default();
        while self.next_slip_s() <= now {
            self.slip();
        }
        self.segment_end_s = end.min(self.next_slip_s());
    }
}
