//! Shifts of marks that are not part of the disc: they depend on time, direction, or slips of the index.

use std::f64::consts::TAU;

use quadcal::edge::{Direction, Levels};

use super::Class;
use super::effects::{self, Sized};
use crate::effect::number::{Number, Series};
use crate::effect::{Carrier, Change, Here, On, Site};
use crate::twin::{Channel, ThresholdDrift, ThresholdRipple, Twin};

/// A number and its rate of change, 1/s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moving {
    pub(super) value: f64,
    pub(super) rate: f64,
}

/// How far along the disc marks of a class are passed beyond their place.
#[derive(Clone, Debug)]
pub(super) struct Shifts {
    ripples: Vec<ThresholdRipple>,
    drifts: Vec<ThresholdDrift>,
    /// Half the angle and channel of each play.
    plays: Vec<(f64, Option<Channel>)>,
    step_rad: f64,
    /// Instants, s, and steps, by time.
    slips: Vec<(f64, i32)>,
    next_slip: usize,
    index_rad: f64,
    /// Effects of disc and level that no disc of its own has.
    effects: Vec<Sized>,
}

/// The shaft as it passes a mark.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passing {
    /// Time, s.
    pub(super) time_s: f64,
    /// The mark's place on the grid, through all turns, rad.
    pub(super) grid_rad: f64,
    /// Angle of the shaft, rad.
    pub(super) angle_rad: f64,
    /// Speed, rad/s.
    pub(super) speed: f64,
    /// Acceleration, rad/s^2.
    pub(super) acceleration: f64,
    /// Direction of motion; a standing shaft has none.
    pub(super) direction: Option<Direction>,
}

impl Shifts {
    /// The shifts of a twin; none if nothing moves a mark.
    pub(super) fn new(twin: &Twin) -> Option<Self> {
        let hysteresis = twin.hysteresis.map(|h| (0.5 * h.angle_rad, h.channel));
        let backlash = twin.backlash.map(|b| (0.5 * b.gap_rad, None));
        let mut slips: Vec<(f64, i32)> = twin
            .index_slip
            .iter()
            .map(|slip| (slip.at_s, slip.edges))
            .collect();
        slips.sort_by(|a, b| a.0.total_cmp(&b.0));
        let shifts = Self {
            ripples: twin.threshold_ripple.clone(),
            drifts: twin.threshold_drift.clone(),
            plays: hysteresis.into_iter().chain(backlash).collect(),
            step_rad: TAU / f64::from(twin.encoder.grid_edges()),
            slips,
            next_slip: 0,
            index_rad: 0.0,
            effects: effects::at(twin, |site| matches!(site, Site::Disc(_) | Site::Level(_)))
                .into_iter()
                .filter(|(effect, _)| !effect.is_of_disc())
                .collect(),
        };
        let any = !shifts.ripples.is_empty()
            || !shifts.drifts.is_empty()
            || !shifts.plays.is_empty()
            || !shifts.slips.is_empty()
            || !shifts.effects.is_empty()
            || twin.bearing.iter().any(|b| b.runout_rad.is_some());
        any.then_some(shifts)
    }

    /// Time of the next slip of the index, s; infinite after the last.
    pub(super) fn next_slip_s(&self) -> f64 {
        self.slips
            .get(self.next_slip)
            .map_or(f64::INFINITY, |slip| slip.0)
    }

    /// Lets the index slip.
    pub(super) fn slip(&mut self) {
        let steps = self.slips.get(self.next_slip).map_or(0, |slip| slip.1);
        self.index_rad += f64::from(steps) * self.step_rad;
        self.next_slip += 1;
    }

    /// The shift of a class as it is passed, rad.
    pub(super) fn of(&self, class: Class, passing: &Passing) -> Moving {
        let Passing {
            time_s, direction, ..
        } = *passing;
        let channel = channel_of(class);
        let on = |asked: Option<Channel>| asked.is_none() || asked == channel;
        let ahead = direction.map_or(0.0, |direction| f64::from(direction.sign()));
        let plays = self.plays.iter().filter(|play| on(play.1));
        let mut shift = Moving {
            value: plays.map(|play| ahead * play.0).sum(),
            rate: 0.0,
        };
        self.add_effects(&mut shift, class, passing);
        if channel.is_none() {
            shift.value += self.index_rad;
            return shift;
        }
        let (_, rises) = class.bit_and_rise();
        let later = if rises { 1.0 } else { -1.0 };
        for ripple in self.ripples.iter().filter(|ripple| on(ripple.channel)) {
            let turning = TAU * ripple.f_hz;
            let (sin, cos) = libm::sincos(turning * time_s + ripple.phase_rad);
            shift.value += later * ripple.angle_rad * sin;
            shift.rate += later * ripple.angle_rad * turning * cos;
        }
        for drift in self.drifts.iter().filter(|drift| on(drift.channel)) {
            let since = (time_s - drift.from_s).max(0.0) / drift.tau_s;
            shift.value -= later * drift.angle_rad * libm::expm1(-since);
            if since > 0.0 {
                shift.rate += later * drift.angle_rad * libm::exp(-since) / drift.tau_s;
            }
        }
        shift
    }

    fn add_effects(&self, shift: &mut Moving, class: Class, passing: &Passing) {
        if self.effects.is_empty() {
            return;
        }
        for (effect, sizes) in &self.effects {
            // An index is moved by what moves all marks of the disc alike.
            let ahead = match (change_of(class), effect.site) {
                (Some(change), _) => effect.ahead(change),
                (None, Site::Disc(On::ALL)) if effect.carrier == Carrier::Direction => -1.0,
                (None, Site::Disc(On::ALL)) => 1.0,
                _ => 0.0,
            };
            let angle = match effect.site {
                Site::Disc(_) => Series::new(&[passing.grid_rad, 0.0]),
                _ => Series::new(&[passing.angle_rad, passing.speed]),
            };
            let here = Here {
                time_s: Series::new(&[passing.time_s, 1.0]),
                inside_s: passing.time_s,
                angle,
                speed: Series::new(&[passing.speed, passing.acceleration]),
                way: passing
                    .direction
                    .map_or(0.0, |direction| f64::from(direction.sign())),
            };
            let value = effect.sized(sizes, here);
            shift.value -= ahead * value.value();
            shift.rate -= ahead * value.terms[1];
        }
    }
}

/// What changes at an edge of a class; none for the index.
pub(super) fn change_of(class: Class) -> Option<Change> {
    let channel = channel_of(class)? as u8;
    let (_, rises) = class.bit_and_rise();
    Some(Change { channel, rises })
}

/// The channel of a class; none for the index.
pub(super) const fn channel_of(class: Class) -> Option<Channel> {
    let (bit, _) = class.bit_and_rise();
    match (class, bit) {
        (Class::IndexRise | Class::IndexFall | Class::Glitch, _) => None,
        (_, Levels::A) => Some(Channel::A),
        (_, Levels::B) => Some(Channel::B),
        _ => Some(Channel::C),
    }
}
