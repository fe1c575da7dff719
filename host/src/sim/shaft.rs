//! The turning shaft: state, Coulomb friction and standstill, one piece of motion after another.

use super::drive::Knot;
use super::effects::Start;
use super::taylor::{DEGREE, Integrator, Piece, Push, bisect};

/// A sum that keeps what rounding drops, so that millions of steps do not drift.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LongSum {
    high: f64,
    low: f64,
}

impl LongSum {
    pub(super) const fn new(high: f64) -> Self {
        Self { high, low: 0.0 }
    }

    pub(super) fn add(&mut self, value: f64) {
        let sum = self.high + value;
        let taken = sum - self.high;
        self.low += (self.high - (sum - taken)) + (value - taken);
        self.high = sum;
    }

    /// The sum plus `value`.
    pub(super) fn plus(self, value: f64) -> f64 {
        self.high + (self.low + value)
    }
}

/// Share of the torques that rounding may leave a pull under friction by when it breaks away. What winds a spring up in the time that
/// is left is lost in rounding too, so the shaft is let go there and then.
pub(super) const ROUNDING: f64 = 4e-15;

/// Everything that pushes the shaft but friction and ripple, over one segment of time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forcing {
    /// Acceleration now, rad/s^2.
    pub(super) level: f64,
    /// Its rate, rad/s^3.
    pub(super) slope: f64,
    /// Viscous friction and drive stiffness, 1/s.
    pub(super) damping: f64,
}

/// State of the shaft.
#[derive(Clone, Debug)]
pub(super) struct Shaft {
    integrator: Integrator,
    /// Coulomb friction as an acceleration, rad/s^2.
    coulomb: f64,
    angle: LongSum,
    speed: LongSum,
    /// Sign of the motion that friction acts against; 0 at standstill.
    motion: f64,
}

impl Shaft {
    pub(super) fn new(integrator: Integrator, coulomb: f64, angle_rad: f64, speed: f64) -> Self {
        Self {
            integrator,
            coulomb,
            angle: LongSum::new(angle_rad),
            speed: LongSum::new(speed),
            motion: sign(speed),
        }
    }

    /// Angle, rad, `travel` from here.
    pub(super) fn angle_after(&self, travel: f64) -> f64 {
        self.angle.plus(travel)
    }

    /// Sign of the motion; 0 at standstill.
    pub(super) const fn motion(&self) -> f64 {
        self.motion
    }

    /// Speed now, rad/s.
    pub(super) fn speed(&self) -> f64 {
        self.speed.plus(0.0)
    }

    /// How far it is to an angle, rad.
    pub(super) fn way_to(&self, angle_rad: f64) -> f64 {
        (angle_rad - self.angle.high) - self.angle.low
    }

    /// Works out pushes that are given in time, for the next piece; false where the profile is a straight line and has no part in that.
    pub(super) fn prepare(
        &mut self,
        knot: &Knot,
        now_s: f64,
        inside_s: f64,
        far_push: f64,
    ) -> bool {
        let start = Start {
            time_s: now_s,
            inside_s,
            angle_rad: self.angle.plus(0.0),
        };
        match self.integrator.extended() {
            Some(extended) => extended.prepare(knot, start, far_push),
            None => return false,
        }
        true
    }

    /// The motion from now on, at most to `rest_s`, the end of a segment `segment_s` long. It turns nowhere within.
    pub(super) fn next_piece(&mut self, forcing: Forcing, rest_s: f64, segment_s: f64) -> Piece {
        let longest = rest_s.min(self.integrator.share_of(segment_s));
        let angle = self.angle.plus(0.0);
        if self.motion == 0.0 {
            let pull = forcing.level + self.integrator.ripple_at(angle);
            if let Some(extended) = self.integrator.extended() {
                match extended.rest(pull, self.coulomb, longest) {
                    Ok(rest) => return rest,
                    Err(motion) => self.motion = motion,
                }
            } else if let Some(rest) = self.standstill(pull, forcing, longest) {
                return rest;
            } else {
                self.motion = if pull == 0.0 {
                    sign(forcing.slope)
                } else {
                    sign(pull)
                };
            }
        }
        let motion = self.motion;
        if let Some(extended) = self.integrator.extended() {
            extended.set_motion(motion);
        }
        let push = Push {
            level: forcing.level - self.coulomb * self.motion,
            slope: forcing.slope,
            damping: forcing.damping,
        };
        let mut piece = self
            .integrator
            .step(angle, self.speed.plus(0.0), push, longest);
        if let Some(stop_s) = first_stop(&piece, self.motion) {
            piece.length_s = stop_s;
        }
        piece
    }

    /// A piece of standing still, where friction holds against `pull`.
    fn standstill(&self, pull: f64, forcing: Forcing, longest: f64) -> Option<Piece> {
        let slope = forcing.slope;
        let towards = if pull == 0.0 { sign(slope) } else { sign(pull) };
        let spare = self.coulomb - pull.abs();
        let rounding = ROUNDING * (self.coulomb + forcing.level.abs());
        if spare < 0.0 || (spare <= rounding && towards * slope > 0.0) {
            return None;
        }
        // The pull grows at a constant rate; it gets loose where it meets friction on the side it moves to.
        let until = if slope == 0.0 {
            longest
        } else {
            (self.coulomb * sign(slope) - pull) / slope
        };
        (until > longest * 1e-12).then(|| Piece::rest(until.min(longest)))
    }

    /// Goes to the end of a piece.
    pub(super) fn finish(&mut self, piece: &Piece) {
        self.angle.add(piece.travel(piece.length_s));
        self.speed.add(piece.speed_gain(piece.length_s));
        let terms = if self.motion == 0.0 {
            DEGREE
        } else {
            piece.terms()
        };
        if let Some(extended) = self.integrator.extended() {
            extended.finish(piece.length_s, terms);
        }
        if self.motion == 0.0 || self.speed.plus(0.0) * self.motion <= 0.0 {
            self.speed = LongSum::new(0.0);
            self.motion = 0.0;
        }
    }
}

/// -1, 0 or 1.
pub(super) fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// The first time within a piece at which motion in the direction `motion` comes to a stop.
fn first_stop(piece: &Piece, motion: f64) -> Option<f64> {
    let end = piece.length_s;
    let against = |tau: f64| piece.speed(tau) * motion < 0.0;
    let mut last = end;
    if !against(end) {
        // The speed may dip through zero and come back within the piece: look at its smallest.
        let slows =
            piece.acceleration(0.0) * motion < 0.0 && piece.acceleration(end) * motion > 0.0;
        if !slows {
            return None;
        }
        last = bisect(0.0, end, -motion, |tau| piece.acceleration(tau));
        if !against(last) {
            return None;
        }
    }
    let stop = bisect(0.0, last, motion, |tau| piece.speed(tau));
    // A shaft just let go that friction stops at once must still get on in time.
    Some(stop.max(end * 1e-9))
}
