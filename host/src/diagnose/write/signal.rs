//! Sections of what turns the shaft's angle into stamps: the disc, the comparator's level, delays.

use std::f64::consts::TAU;

use super::rhythm::{Span, add_to, same_or, wave};
use crate::diagnose::diagnosis::Sized;
use crate::diagnose::effect::{Carrier, On};
use crate::diagnose::record::Change;
use crate::twin::{
    Bearing, Channel, EdgeDelay, Encoder, Flank, Hysteresis, LocalDefect, ThresholdDrift,
    ThresholdRipple, Twin,
};

/// Channels of a twin's encoder, each with a rise and a fall a line.
const fn channels(twin: &Twin) -> usize {
    twin.encoder.edges_per_line() as usize / 2
}

/// The disc's errors, its run-out, defects and play.
pub fn put_disc(twin: &mut Twin, on: On, cell: &Sized, span: &Span) -> bool {
    let (size, wave) = (cell.sizes[0], wave(&cell.sizes));
    let channels = channels(twin);
    let errors = &mut twin.errors;
    let listed = errors.csv.is_some() || !errors.list_rad.is_empty();
    let channel = on.channel.map(Channel::numbered);
    match cell.effect.carrier {
        // A list is in place of all other parts.
        Carrier::Steady | Carrier::Order(1.0 | 2.0) if listed => return false,
        Carrier::Steady if on.rises == Some(false) => {
            let widths = [
                &mut errors.width_a_rad,
                &mut errors.width_b_rad,
                &mut errors.width_c_rad,
            ];
            for (channel, width) in (0..).zip(widths).take(channels) {
                if on.channel.is_none_or(|one| one == channel) {
                    *width += size;
                }
            }
        }
        Carrier::Steady => match (on.channel, on.rises, &twin.encoder) {
            (Some(1), None, Encoder::Hall { .. }) => errors.shift_b_rad += size,
            (Some(1), None, _) => errors.quadrature_rad += size,
            (Some(2), None, _) => errors.shift_c_rad += size,
            _ => return false,
        },
        Carrier::Order(order @ (1.0 | 2.0)) if on == On::ALL => {
            let into = if order == 1.0 {
                &mut errors.eccentricity
            } else {
                &mut errors.tilt
            };
            let into = into.get_or_insert_default();
            // Its phase counts backwards: amplitude sin(x - phase).
            let wave = wave.conj();
            add_to(wave, &mut into.amplitude_rad, &mut into.phase_rad);
        }
        Carrier::Order(order) if on == On::ALL && order.fract() != 0.0 => {
            let new = Bearing {
                order,
                runout_rad: Some(0.0),
                ..Bearing::default()
            };
            let same =
                |there: &Bearing| there.runout_rad.is_some() && span.same_order(there.order, order);
            let there = same_or(&mut twin.bearing, same, new);
            there.order = order;
            let runout_rad = there.runout_rad.get_or_insert(0.0);
            add_to(wave, runout_rad, &mut there.phase_rad);
        }
        Carrier::Bump(angle, width_rad) => {
            let flank = |rises| if rises { Flank::Rise } else { Flank::Fall };
            twin.local_defect.push(LocalDefect {
                angle_rad: angle.rem_euclid(TAU),
                width_rad,
                error_rad: size,
                channel,
                edge: on.rises.map(flank),
            });
        }
        Carrier::Direction if on.rises.is_none() => {
            let play = twin.hysteresis.get_or_insert(Hysteresis {
                angle_rad: 0.0,
                channel,
            });
            play.angle_rad += size;
            return play.channel == channel;
        }
        _ => return false,
    }
    true
}

/// The comparator's level.
pub fn put_level(twin: &mut Twin, on: On, cell: &Sized, span: &Span) -> bool {
    let channel = on.channel.map(Channel::numbered);
    match cell.effect.carrier {
        Carrier::Tone(f_hz) => {
            let new = ThresholdRipple {
                f_hz,
                channel,
                ..ThresholdRipple::default()
            };
            let same = |there: &ThresholdRipple| {
                there.channel == channel && span.same_frequency(there.f_hz, f_hz)
            };
            let there = same_or(&mut twin.threshold_ripple, same, new);
            there.f_hz = f_hz;
            let wave = wave(&cell.sizes);
            add_to(wave, &mut there.angle_rad, &mut there.phase_rad);
        }
        Carrier::Settling(from_s, tau_s) => twin.threshold_drift.push(ThresholdDrift {
            angle_rad: cell.sizes[0],
            tau_s,
            from_s: from_s.max(0.0),
            channel,
        }),
        _ => return false,
    }
    true
}

/// Delays; those of all channels grow together where one would come before its edge, which shows nowhere.
pub fn put_delay(twin: &mut Twin, on: On, size: f64) -> bool {
    let channels = channels(twin);
    let mut all = if on.rises.is_none() {
        let skew = twin.channel_skew.get_or_insert_default();
        [&mut skew.a_s, &mut skew.b_s, &mut skew.c_s].map(|delay| vec![(true, delay)])
    } else {
        let EdgeDelay { a, b, c } = twin.edge_delay.get_or_insert_default();
        [a, b, c].map(|both| vec![(true, &mut both.rise_s), (false, &mut both.fall_s)])
    };
    let mut least: f64 = 0.0;
    let all = &mut all[..channels];
    for (channel, each) in (0..).zip(&mut *all) {
        for (rises, delay) in each {
            let change = Change {
                channel,
                rises: *rises,
            };
            **delay += if on.has(change) { size } else { 0.0 };
            least = least.min(**delay);
        }
    }
    all.iter_mut()
        .flatten()
        .for_each(|(_, delay)| **delay -= least);
    true
}
