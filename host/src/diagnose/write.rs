//! The twins with the findings in them. A named finding changes the section of its mechanism; what no section can say is an
//! `[[effect]]`; so the new twin does what was fitted, and no more.

use std::f64::consts::TAU;

use super::diagnosis::Finding;
use super::diagnosis::{Answer, Sized};
use super::edges::CountKind;
use super::effect::{Carrier, Effect, Growth, On, Site};
use super::events::ROWS_A_GLITCH;
use super::numbers::{self, Knob};
use super::plant::Law;
use super::rig::Recorded;
use crate::mechanism::Mechanism;
use crate::sim;
use crate::twin::{
    Bearing, CaptureLatency, Channel, DeclaredEffect, EdgeDelay, Encoder, Errors, Flank, Harmonic,
    Hysteresis, IndexSlip, LoadStep, LocalDefect, Ripple, RiseFall, SpeedDrift, ThresholdDrift,
    ThresholdRipple, TorqueTone, Twin, TwinError,
};

/// Part of a cycle by which two rhythms may part over a recording and be one.
const SAME_CYCLES: f64 = 0.1;
/// Length of a glitch over the mean interval of edges, where the recording does not show it.
const GLITCH_SHARE: f64 = 0.1;

/// A twin with findings in it.
#[derive(Clone, Debug)]
pub struct Written {
    /// The twin.
    pub twin: Twin,
    /// Errors of its disc as recorded edges count them, rad, where they were learned: for a list beside it.
    pub errors_rad: Option<Vec<f64>>,
}

/// The twin of each recording with the findings in it.
///
/// # Errors
/// As [`sim::true_errors`].
pub fn twins(rig: &[Recorded], answer: &Answer) -> Result<Vec<Written>, TwinError> {
    let each = rig.iter().zip(&answer.corrected).enumerate();
    each.map(|(at, (one, corrected))| written(at, one, corrected, answer))
        .collect()
}

fn written(
    at: usize,
    one: &Recorded,
    corrected: &[(Knob, Vec<f64>)],
    answer: &Answer,
) -> Result<Written, TwinError> {
    let corrected: Vec<(&Knob, &[f64])> = corrected
        .iter()
        .map(|(knob, values)| (knob, values.as_slice()))
        .collect();
    let taken = numbers::changed(&one.twin, &corrected).filter(|twin| twin.check().is_ok());
    let mut twin = taken.unwrap_or_else(|| one.twin.clone());
    let span = Span::of(one);
    let found = answer.diagnosis.findings.iter().zip(&answer.cells);
    let elsewhere = |cell: &Sized| cell.effect.only.is_some_and(|only| usize::from(only) != at);
    for (finding, cells) in found {
        if cells.iter().any(elsewhere) {
            continue;
        }
        // A section that can't take the numbers leaves them to effects.
        let mut new = twin.clone();
        let took = match cells.is_empty() {
            true => put_counted(&mut new, finding, one),
            false => cells
                .iter()
                .filter(|cell| !matches!(cell.effect.site, Site::Declared(_)))
                .all(|cell| finding.mechanism != Mechanism::Unknown && put(&mut new, cell, &span)),
        };
        if took && new.check().is_ok() {
            twin = new;
            continue;
        }
        for cell in cells {
            let mut new = twin.clone();
            new.effect
                .extend(DeclaredEffect::of(&cell.effect, &cell.sizes));
            if new.check().is_ok() {
                twin = new;
            }
        }
    }
    let errors_rad = match &answer.pattern {
        None => None,
        Some(pattern) => Some(learned(&twin, pattern)?),
    };
    Ok(Written { twin, errors_rad })
}

/// The disc that a twin gives with what was learned beside it. What sections add to a list stays out of it.
fn learned(twin: &Twin, pattern: &[f64]) -> Result<Vec<f64>, TwinError> {
    let plain = Twin {
        local_defect: Vec::new(),
        effect: Vec::new(),
        ..twin.clone()
    };
    let known = sim::true_errors(&plain)?;
    // Of a wheel recorded with one edge of each tooth the other goes along.
    let every = (known.len() / pattern.len().max(1)).max(1);
    let known = known.into_iter().step_by(every);
    Ok(known
        .zip(pattern)
        .map(|(known, more)| known + more)
        .collect())
}

/// How far a recording goes.
struct Span {
    turns: f64,
    seconds: f64,
}

impl Span {
    fn of(one: &Recorded) -> Self {
        let edges = &one.edges;
        let ends = |values: &[i64]| {
            let least = values.iter().min().copied().unwrap_or(0);
            values.iter().max().copied().unwrap_or(0) - least
        };
        let seconds = match (edges.time_s.first(), edges.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        };
        Self {
            turns: ends(&edges.place) as f64 / f64::from(edges.grid_edges.max(1)),
            seconds,
        }
    }

    fn same_order(&self, one: f64, other: f64) -> bool {
        (one - other).abs() * self.turns <= SAME_CYCLES
    }

    fn same_frequency(&self, one: f64, other: f64) -> bool {
        (one - other).abs() * self.seconds <= SAME_CYCLES
    }
}

/// Sizes of cosine and sine; amplitude sin(x + phase) is cos sin(phase) and sin cos(phase) of them.
#[derive(Clone, Copy, Debug)]
struct Phasor {
    cos: f64,
    sin: f64,
}

impl Phasor {
    fn of(sizes: &[f64]) -> Self {
        match sizes {
            [cos, sin] => Self {
                cos: *cos,
                sin: *sin,
            },
            _ => Self { cos: 0.0, sin: 0.0 },
        }
    }

    fn at(amplitude: f64, phase_rad: f64) -> Self {
        let (sin, cos) = phase_rad.sin_cos();
        Self {
            cos: amplitude * sin,
            sin: amplitude * cos,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            cos: self.cos + other.cos,
            sin: self.sin + other.sin,
        }
    }

    fn amplitude(self) -> f64 {
        self.cos.hypot(self.sin)
    }

    fn phase_rad(self) -> f64 {
        self.cos.atan2(self.sin).rem_euclid(TAU)
    }
}

/// Changes the section of an effect; false where none can say it.
fn put(twin: &mut Twin, cell: &Sized, span: &Span) -> bool {
    let Effect {
        site,
        carrier,
        growth,
        ..
    } = cell.effect;
    if growth != Growth::Constant {
        return false;
    }
    let size = cell.sizes[0];
    let wave = Phasor::of(&cell.sizes);
    match (site, carrier) {
        (Site::Disc(on), _) => put_disc(twin, on, carrier, &cell.sizes, span),
        (Site::Level(on), Carrier::Tone(f_hz)) => put_level_tone(twin, on, f_hz, wave, span),
        (Site::Level(on), Carrier::Settling(from_s, tau_s)) => {
            twin.threshold_drift.push(ThresholdDrift {
                angle_rad: size,
                tau_s,
                from_s: from_s.max(0.0),
                channel: on.channel.map(Channel::numbered),
            });
            true
        }
        (Site::Stamp(on), Carrier::Steady) => put_delay(twin, on, size),
        (Site::Torque, Carrier::Order(order)) => put_order(twin, order, wave, span),
        (Site::Torque, Carrier::Tone(f_hz)) => put_tone(twin, f_hz, wave, span),
        (Site::Torque, Carrier::Window(from_s, until_s)) => {
            twin.load_step.push(LoadStep {
                torque_n_m: size,
                from_s: from_s.max(0.0),
                until_s: until_s.is_finite().then_some(until_s),
            });
            true
        }
        (Site::Torque, Carrier::Power(_) | Carrier::Stribeck(_)) => {
            put_friction(twin, carrier, size)
        }
        (Site::Drive, _) => put_drift(twin, carrier, size),
        _ => false,
    }
}

fn put_disc(twin: &mut Twin, on: On, carrier: Carrier, sizes: &[f64], span: &Span) -> bool {
    let (size, wave) = (sizes[0], Phasor::of(sizes));
    let errors = &mut twin.errors;
    // A list is in place of all other parts.
    let listed = errors.csv.is_some() || !errors.list_rad.is_empty();
    let hall = matches!(twin.encoder, Encoder::Hall { .. });
    match carrier {
        Carrier::Steady if listed => false,
        Carrier::Steady if on.rises == Some(false) => {
            let widths = [
                &mut errors.width_a_rad,
                &mut errors.width_b_rad,
                &mut errors.width_c_rad,
            ];
            let count = channels(&twin.encoder);
            for (channel, width) in (0..count).zip(widths) {
                if on.channel.is_none_or(|one| one == channel) {
                    *width += size;
                }
            }
            true
        }
        Carrier::Steady => {
            let shift = match (on.channel, on.rises) {
                (Some(1), None) if hall => &mut errors.shift_b_rad,
                (Some(1), None) => &mut errors.quadrature_rad,
                (Some(2), None) => &mut errors.shift_c_rad,
                _ => return false,
            };
            *shift += size;
            true
        }
        Carrier::Order(order) if on == On::ALL && (order == 1.0 || order == 2.0) => {
            if listed {
                return false;
            }
            let into = if order == 1.0 {
                &mut errors.eccentricity
            } else {
                &mut errors.tilt
            };
            // Their phase counts backwards.
            let there = into.map_or(Phasor::at(0.0, 0.0), |there| {
                Phasor::at(there.amplitude_rad, -there.phase_rad)
            });
            let sum = there.plus(wave);
            *into = Some(Harmonic {
                amplitude_rad: sum.amplitude(),
                phase_rad: (-sum.phase_rad()).rem_euclid(TAU),
            });
            true
        }
        Carrier::Order(order) if on == On::ALL && order.fract() != 0.0 => {
            let there = twin.bearing.iter().position(|bearing| {
                bearing.runout_rad.is_some() && span.same_order(bearing.order, order)
            });
            let before = there.map(|at| twin.bearing.remove(at));
            let sum = before.map_or(wave, |bearing| {
                wave.plus(Phasor::at(
                    bearing.runout_rad.unwrap_or(0.0),
                    bearing.phase_rad,
                ))
            });
            twin.bearing.push(Bearing {
                order,
                phase_rad: sum.phase_rad(),
                torque_n_m: None,
                speed_fraction: None,
                runout_rad: Some(sum.amplitude()),
            });
            true
        }
        Carrier::Bump(angle, width_rad) => {
            twin.local_defect.push(LocalDefect {
                angle_rad: angle.rem_euclid(TAU),
                width_rad,
                error_rad: size,
                channel: on.channel.map(Channel::numbered),
                edge: on
                    .rises
                    .map(|rises| if rises { Flank::Rise } else { Flank::Fall }),
            });
            true
        }
        Carrier::Direction if on.rises.is_none() => {
            let channel = on.channel.map(Channel::numbered);
            let mut play = twin.hysteresis.unwrap_or(Hysteresis {
                angle_rad: 0.0,
                channel,
            });
            play.angle_rad += size;
            let same = play.channel == channel;
            twin.hysteresis = Some(play);
            same
        }
        _ => false,
    }
}

fn put_level_tone(twin: &mut Twin, on: On, f_hz: f64, wave: Phasor, span: &Span) -> bool {
    let channel = on.channel.map(Channel::numbered);
    let there = twin
        .threshold_ripple
        .iter()
        .position(|ripple| ripple.channel == channel && span.same_frequency(ripple.f_hz, f_hz));
    let sum = match there.map(|at| twin.threshold_ripple.remove(at)) {
        Some(before) => wave.plus(Phasor::at(before.angle_rad, before.phase_rad)),
        None => wave,
    };
    twin.threshold_ripple.push(ThresholdRipple {
        f_hz,
        phase_rad: sum.phase_rad(),
        angle_rad: sum.amplitude(),
        channel,
    });
    true
}

/// Channels of an encoder.
const fn channels(encoder: &Encoder) -> u8 {
    match encoder {
        Encoder::Quadrature { .. } => 2,
        Encoder::Hall { .. } => 3,
        Encoder::Wheel { .. } => 1,
    }
}

/// Delays; those of all channels grow together where one would come before its edge, which shows nowhere.
fn put_delay(twin: &mut Twin, on: On, size: f64) -> bool {
    let count = channels(&twin.encoder);
    let is_on = |channel: u8| on.channel.is_none_or(|one| one == channel);
    if on.rises.is_none() {
        let mut skew = twin.channel_skew.unwrap_or_default();
        let mut all = [&mut skew.a_s, &mut skew.b_s, &mut skew.c_s];
        for (channel, delay) in (0..count).zip(&mut all) {
            **delay += if is_on(channel) { size } else { 0.0 };
        }
        let all = &mut all[..usize::from(count)];
        let least = all.iter().fold(0.0, |least: f64, delay| least.min(**delay));
        all.iter_mut().for_each(|delay| **delay -= least);
        twin.channel_skew = Some(skew);
        return true;
    }
    let mut delay = twin.edge_delay.unwrap_or_default();
    let EdgeDelay { a, b, c } = &mut delay;
    let mut all: [&mut RiseFall; 3] = [a, b, c];
    let all = &mut all[..usize::from(count)];
    for (channel, both) in (0..count).zip(all.iter_mut()) {
        match on.rises {
            Some(true) if is_on(channel) => both.rise_s += size,
            Some(false) if is_on(channel) => both.fall_s += size,
            _ => {}
        }
    }
    let least = all.iter().fold(0.0, |least: f64, both| {
        least.min(both.rise_s).min(both.fall_s)
    });
    for both in all.iter_mut() {
        both.rise_s -= least;
        both.fall_s -= least;
    }
    twin.edge_delay = Some(delay);
    true
}

/// How a twin sizes a torque: as such, or without an inertia as the swing of the speed that it makes.
struct Scale {
    inertia: f64,
    damping: f64,
    nominal: f64,
    torques: bool,
}

impl Scale {
    fn of(twin: &Twin) -> Self {
        let law = Law::of(twin);
        Self {
            inertia: law.inertia,
            damping: law.viscous + law.stiffness,
            nominal: twin.drive.nominal_rad_s().abs(),
            torques: twin.shaft.inertia_kg_m2 != 0.0,
        }
    }

    /// Torque of a relative swing of 1 that turns at a rate, rad/s.
    fn of_swing(&self, turning: f64) -> f64 {
        self.nominal * turning.hypot(self.damping) * self.inertia
    }

    fn torque(&self, turning: f64, torque: Option<f64>, fraction: Option<f64>) -> f64 {
        torque.unwrap_or_else(|| fraction.unwrap_or(0.0) * self.of_swing(turning))
    }

    fn sized(&self, turning: f64, torque: f64) -> (Option<f64>, Option<f64>) {
        if self.torques {
            (Some(torque), None)
        } else {
            (None, Some(torque / self.of_swing(turning)))
        }
    }
}

/// Torque at an order: a motor's where it is whole, else a gear's; or more of a section that has that order.
fn put_order(twin: &mut Twin, order: f64, wave: Phasor, span: &Span) -> bool {
    let scale = Scale::of(twin);
    for bearing in &mut twin.bearing {
        if bearing.runout_rad.is_none() && span.same_order(bearing.order, order) {
            let turning = bearing.order * scale.nominal;
            let there = scale.torque(turning, bearing.torque_n_m, bearing.speed_fraction);
            let sum = wave.plus(Phasor::at(there, bearing.phase_rad));
            bearing.phase_rad = sum.phase_rad();
            (bearing.torque_n_m, bearing.speed_fraction) = scale.sized(turning, sum.amplitude());
            return true;
        }
    }
    for ripple in twin.ripple.iter_mut().chain(&mut twin.gear_mesh) {
        if span.same_order(ripple.order, order) {
            let turning = ripple.order * scale.nominal;
            let there = scale.torque(turning, ripple.torque_n_m, ripple.speed_fraction);
            let sum = wave.plus(Phasor::at(there, ripple.phase_rad));
            ripple.phase_rad = sum.phase_rad();
            (ripple.torque_n_m, ripple.speed_fraction) = scale.sized(turning, sum.amplitude());
            return true;
        }
    }
    let (torque_n_m, speed_fraction) = scale.sized(order * scale.nominal, wave.amplitude());
    let new = Ripple {
        order,
        phase_rad: wave.phase_rad(),
        torque_n_m,
        speed_fraction,
    };
    if order.fract() == 0.0 {
        twin.ripple.push(new);
    } else {
        twin.gear_mesh.push(new);
    }
    true
}

fn put_tone(twin: &mut Twin, f_hz: f64, wave: Phasor, span: &Span) -> bool {
    let scale = Scale::of(twin);
    for tone in &mut twin.torque_tone {
        if span.same_frequency(tone.f_hz, f_hz) {
            let turning = TAU * tone.f_hz;
            let there = scale.torque(turning, tone.torque_n_m, tone.speed_fraction);
            let sum = wave.plus(Phasor::at(there, tone.phase_rad));
            tone.phase_rad = sum.phase_rad();
            (tone.torque_n_m, tone.speed_fraction) = scale.sized(turning, sum.amplitude());
            return true;
        }
    }
    let (torque_n_m, speed_fraction) = scale.sized(TAU * f_hz, wave.amplitude());
    twin.torque_tone.push(TorqueTone {
        f_hz,
        phase_rad: wave.phase_rad(),
        torque_n_m,
        speed_fraction,
    });
    true
}

/// Friction of the shaft.
fn put_friction(twin: &mut Twin, carrier: Carrier, size: f64) -> bool {
    let shaft = &mut twin.shaft;
    match carrier {
        Carrier::Power(0.0) => shaft.coulomb_n_m += size,
        Carrier::Power(1.0) => shaft.viscous_n_m_s += size,
        Carrier::Power(2.0) => shaft.drag_n_m_s2 += size,
        Carrier::Stribeck(speed) if shaft.stribeck_n_m == 0.0 => {
            (shaft.stribeck_n_m, shaft.stribeck_rad_s) = (size, speed);
        }
        _ => return false,
    }
    true
}

fn put_drift(twin: &mut Twin, carrier: Carrier, size: f64) -> bool {
    let new = match (carrier, twin.speed_drift) {
        (Carrier::Time, None) => SpeedDrift {
            fraction_per_s: Some(size),
            ..SpeedDrift::default()
        },
        (
            Carrier::Time,
            Some(SpeedDrift {
                fraction_per_s: Some(rate),
                ..
            }),
        ) => SpeedDrift {
            fraction_per_s: Some(rate + size),
            ..SpeedDrift::default()
        },
        (Carrier::Settling(from_s, tau_s), None) if from_s <= 0.0 => SpeedDrift {
            fraction: Some(size),
            tau_s: Some(tau_s),
            ..SpeedDrift::default()
        },
        _ => return false,
    };
    twin.speed_drift = Some(new);
    true
}

/// What is counted, or is noise of the stamps; false where a twin has no key for it.
fn put_counted(twin: &mut Twin, finding: &Finding, one: &Recorded) -> bool {
    let number = |name: &str| finding.parameters.get(name).map(|number| number.value);
    let edges = &one.edges;
    match finding.mechanism {
        Mechanism::TimestampJitter => {
            let Some(jitter_s) = number("jitter_s") else {
                return false;
            };
            twin.timer.jitter_s = jitter_s;
        }
        Mechanism::CaptureLatency => {
            let Some(mean_s) = number("mean_s") else {
                let task = CaptureLatency {
                    mean_s: None,
                    task_hz: number("task_hz"),
                    busy_s: number("busy_s"),
                    phase_s: number("phase_s"),
                };
                twin.capture_latency = Some(task);
                return task.task_hz.is_some();
            };
            // On top of what is declared.
            let there = twin.capture_latency.and_then(|latency| latency.mean_s);
            twin.capture_latency = Some(CaptureLatency {
                mean_s: Some(mean_s.hypot(there.unwrap_or(0.0))),
                ..CaptureLatency::default()
            });
        }
        Mechanism::LostEdges => {
            let mut before = 0;
            let mut lost = Vec::new();
            let events = edges.events.iter();
            for event in events.filter(|event| event.kind == CountKind::Lost) {
                // The first row only says where the levels start.
                let seen = 1 + edges.time_s.partition_point(|time| *time < event.time_s);
                let first = seen as u64 + before;
                let count = u64::from(event.edges.unsigned_abs());
                lost.extend(first..first + count);
                before += count;
            }
            twin.faults.lost_edges = lost;
        }
        Mechanism::ExtraEdges => {
            let extra = edges.events.iter();
            let rows: i32 = extra
                .filter(|event| event.kind == CountKind::Extra)
                .map(|event| event.edges)
                .sum();
            let count = edges.time_s.len().max(1) as f64;
            twin.faults.glitch_probability =
                (f64::from(rows) / (f64::from(ROWS_A_GLITCH) * count)).min(1.0);
            if twin.faults.glitch_width_s == 0.0 {
                twin.faults.glitch_width_s = GLITCH_SHARE * Span::of(one).seconds / count;
            }
        }
        Mechanism::IndexSlip => {
            let (Some(at_s), Some(slipped)) = (number("at_s"), number("edges")) else {
                return false;
            };
            twin.index_slip.push(IndexSlip {
                at_s,
                edges: slipped as i32,
            });
        }
        _ => return false,
    }
    true
}

impl Written {
    /// The twin with its list of errors in it.
    #[must_use]
    pub fn whole(&self) -> Twin {
        let mut twin = self.twin.clone();
        if let Some(errors_rad) = &self.errors_rad {
            let each = (twin.encoder.grid_edges() as usize / errors_rad.len().max(1)).max(1);
            let each = errors_rad.iter().flat_map(|error| vec![*error; each]);
            twin.errors = Errors {
                list_rad: each.collect(),
                ..Errors::default()
            };
        }
        twin
    }
}

#[cfg(test)]
mod tests;
