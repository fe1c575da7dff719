//! Spectrum of what is left along time, in bands, and the share of it that torque noise makes.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use super::super::board::Bench;
use super::super::locate::{Along, Among, spectrum};
use super::super::spectrum::Spectrum;

/// Width of a band over its frequency.
pub const BAND: f64 = 2e-3;
/// Power of a line that no noise reaches, over that of its surroundings.
const LINE: f64 = 22.0;
/// Largest change of speed, over it, at which noise has one spectrum.
const HELD: f64 = 0.05;
/// Part of a recording in which its speed is to be held.
const PART: f64 = 0.3;
/// Fastest frequency over the rate of edges.
const FASTEST: f64 = 0.2;

/// What a line sees of its neighbours and itself: Hann's window.
pub const SEEN: [f64; 2] = [1.0 / 6.0, 2.0 / 3.0];
/// Lines that say something of their own, of those there are, under Hann's window: neighbours share 4/9 and 1/36 of their scatter.
const OWN: f64 = 1.0 / (1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0));

/// Lines of a spectrum next to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Frequency, Hz.
    pub f_hz: f64,
    /// Lines that say something of their own.
    pub lines: f64,
    /// Distance of two lines, Hz, where there are so few that what is beside counts.
    pub line_hz: Option<f64>,
    /// Their mean power; 1 is the noise of the filter.
    pub power: f64,
    /// Share of torque noise in the filter's noise there.
    pub torque: f64,
    /// Damping of the shaft, 1/s.
    pub damping: f64,
}

/// Bands of what is left of a recording while its speed is held; none where it is not.
#[must_use]
pub fn bands(bench: &Bench, white: &[f64]) -> Vec<Band> {
    held(bench).map_or_else(Vec::new, |edges| {
        within(bench, white, edges, &rhythms(bench, white))
    })
}

/// The same of stretches of equal length, one after another.
#[must_use]
pub fn stretches(bench: &Bench, white: &[f64], count: usize) -> Vec<Vec<Band>> {
    let Some(edges) = held(bench) else {
        return Vec::new();
    };
    let orders = rhythms(bench, white);
    let at = |part: usize| edges.start + part * edges.len() / count.max(1);
    (0..count)
        .map(|part| within(bench, white, at(part)..at(part + 1), &orders))
        .collect()
}

/// For how long a recording's speed is held, s.
#[must_use]
pub fn held_s(bench: &Bench) -> f64 {
    let times_s = &bench.seen.times_s;
    held(bench).map_or(0.0, |edges| times_s[edges.end - 1] - times_s[edges.start])
}

/// The longest run of edges at one speed, where that is a good part of a recording.
fn held(bench: &Bench) -> Option<Range<usize>> {
    let speeds = &bench.seen.speeds;
    let alike =
        |low: f64, high: f64| low * high > 0.0 && high - low < HELD * high.abs().max(low.abs());
    let [low, high] = bench.seen.speed_range();
    if alike(low, high) {
        return Some(0..speeds.len());
    }
    // From each edge on as far as it goes, then on from where it ended: a run that is held all along is found whole.
    let (mut longest, mut from) = (0..0, 0);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (at, speed) in speeds.iter().enumerate() {
        (low, high) = (low.min(*speed), high.max(*speed));
        if !alike(low, high) {
            (from, low, high) = (at, *speed, *speed);
        }
        if at + 1 - from > longest.len() {
            longest = from..at + 1;
        }
    }
    (longest.len() as f64 > PART * speeds.len() as f64).then_some(longest)
}

/// Bands of some edges, without the rhythms of these orders.
fn within(bench: &Bench, white: &[f64], edges: Range<usize>, orders: &[f64]) -> Vec<Band> {
    let seen = &bench.seen;
    let (times_s, white) = (&seen.times_s[edges.clone()], &white[edges.clone()]);
    let (Some(first), Some(last)) = (times_s.first().copied(), times_s.last()) else {
        return Vec::new();
    };
    let (length, count) = (last - first, times_s.len() as f64);
    if length <= 0.0 {
        return Vec::new();
    }
    let rate = count / length;
    let most = FASTEST * rate;
    let cell = 1.0 / (6.0 * most);
    // Faded in and out, so that a sharp peak does not leak into the dip beside it; of the same mean square.
    let faded = |time: f64| (2.0_f64 / 3.0).sqrt() * (1.0 - (TAU * time / length).cos());
    let numbers = times_s
        .iter()
        .zip(white)
        .map(|(time, white)| (time - first, faded(time - first) * white));
    let variance = numbers.clone().map(|(_, w)| w * w).sum::<f64>() / count;
    let spectrum = Spectrum::of(numbers, length, cell, most);
    let speed2 = seen.speeds[edges].iter().map(|w| w * w).sum::<f64>() / count;
    let floor = bench.noise.stamp_s * bench.noise.stamp_s * speed2 / rate;
    let damping = bench.law.damping(first, speed2.sqrt()) + bench.noise.forgets_per_s;
    // Every other entry: the spectrum is twice as fine as the recording is long.
    let lines: Vec<(f64, f64)> = (2..spectrum.powers.len())
        .step_by(2)
        .map(|at| {
            let f_hz = at as f64 * spectrum.step;
            // Sharing between cells weakens what is fast.
            let x = PI * f_hz * cell;
            let shared = (x.sin() / x).powi(4);
            (f_hz, spectrum.powers[at] * variance / shared)
        })
        .collect();
    let mut lines = without_tones(&lines);
    // Rhythms of the turn, as ripple that a mode answers more than a stiff shaft, are smeared as the speed wanders.
    let turns_a_second = speed2.sqrt() / TAU;
    let wander = (bench.noise.acceleration / (2.0 * damping.max(1e-9))).sqrt() / speed2.sqrt();
    let smeared = (3.0 * wander).clamp(6e-3, 0.03);
    for order in orders {
        let middle = order * turns_a_second;
        let reach = (6.0 * spectrum.step).max(smeared * middle);
        let from = lines.partition_point(|line| line.0 < middle - reach);
        let until = lines.partition_point(|line| line.0 <= middle + reach);
        lines[from..until.max(from)]
            .iter_mut()
            .for_each(|line| line.1 = None);
    }
    let lowest = 4.0 / length;
    let mut bands: Vec<Band> = Vec::new();
    let mut at = 0;
    while at < lines.len() {
        let from = lines[at].0;
        let mut end = at + 1;
        while end < lines.len() && lines[end].0 < from * (1.0 + BAND) {
            end += 1;
        }
        let part = &lines[at..end];
        let there = part.iter().filter_map(|line| line.1);
        let (sum, lines): (f64, f64) =
            there.fold((0.0, 0.0), |(sum, lines), power| (sum + power, lines + 1.0));
        at = end;
        if lines == 0.0 || from < lowest {
            continue;
        }
        let f_hz = 0.5 * (from + part[part.len() - 1].0);
        let w2 = (TAU * f_hz).powi(2);
        let pushed = bench.noise.acceleration / (w2 * (w2 + damping * damping));
        bands.push(Band {
            f_hz,
            lines: OWN * lines,
            line_hz: (lines < 8.0).then_some(2.0 * spectrum.step),
            power: sum / lines,
            torque: pushed / (pushed + floor),
            damping,
        });
    }
    bands
}

/// Whole orders that stand out of what is around them.
fn rhythms(bench: &Bench, white: &[f64]) -> Vec<f64> {
    let spectrum = spectrum(bench, white, Among::All, Along::Turn);
    let at = |order: f64| (order / spectrum.step + 0.5) as usize;
    let last = (spectrum.powers.len() as f64 * spectrum.step - 1.0).max(0.0) as usize;
    let whole = (1..=last).map(|order| order as f64);
    whole
        .filter(|order| {
            let here = &spectrum.powers[at(*order).saturating_sub(1)..at(*order) + 2];
            let power = here.iter().copied().fold(0.0, f64::max);
            if power < LINE {
                return false;
            }
            let sides = [(order - 0.45, order - 0.12), (order + 0.12, order + 0.45)];
            let mut around: Vec<f64> = sides
                .iter()
                .flat_map(|(from, until)| &spectrum.powers[at(*from)..at(*until)])
                .copied()
                .collect();
            around.sort_by(f64::total_cmp);
            around
                .get(around.len() / 2)
                .is_some_and(|usual| power > LINE * usual)
        })
        .collect()
}

/// Lines without those that stand alone: they are tones, not noise.
fn without_tones(lines: &[(f64, f64)]) -> Vec<(f64, Option<f64>)> {
    const NEAR: usize = 2;
    const FAR: usize = 10;
    let mut kept: Vec<(f64, Option<f64>)> = lines.iter().map(|(f, p)| (*f, Some(*p))).collect();
    for at in 0..lines.len() {
        if lines[at].1 < LINE {
            continue;
        }
        let sides =
            (at.saturating_sub(FAR)..at.saturating_sub(NEAR)).chain(at + NEAR + 1..at + FAR + 1);
        let mut around: Vec<f64> = sides
            .filter_map(|i| lines.get(i).map(|line| line.1))
            .collect();
        around.sort_by(f64::total_cmp);
        // Upper quartile: a narrow mode has strong neighbours on one side at least.
        let usual = around.get(around.len() * 3 / 4).copied().unwrap_or(0.0);
        if lines[at].1 > LINE * usual.max(1.0) {
            for line in &mut kept[at.saturating_sub(NEAR)..(at + NEAR + 1).min(lines.len())] {
                line.1 = None;
            }
        }
    }
    kept
}
