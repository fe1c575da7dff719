//! Shifts of marks that are not part of the disc: they depend on time, direction, or slips of the index.

use std::f64::consts::TAU;

use quadcal::edge::{Direction, Levels};

use super::Class;
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
        };
        let any = !shifts.ripples.is_empty()
            || !shifts.drifts.is_empty()
            || !shifts.plays.is_empty()
            || !shifts.slips.is_empty()
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

    /// The shift of a class at a time in the direction of motion, rad; a standing shaft has no direction.
    pub(super) fn of(&self, class: Class, time_s: f64, direction: Option<Direction>) -> Moving {
        let channel = channel_of(class);
        let on = |asked: Option<Channel>| asked.is_none() || asked == channel;
        let ahead = direction.map_or(0.0, |direction| f64::from(direction.sign()));
        let plays = self.plays.iter().filter(|play| on(play.1));
        let mut shift = Moving {
            value: plays.map(|play| ahead * play.0).sum(),
            rate: 0.0,
        };
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
