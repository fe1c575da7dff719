//! The numbers of a starting twin, from recordings whose edges are placed.

use std::f64::consts::TAU;

use super::delays::{self, ClassDelay};
use super::disc::{self, DiscFound};
use super::noise::{self, NoiseFound};
use super::rhythm::Rhythm;
use super::sensor::Found;
use super::torques::{self, OrderTorque};
use super::write::bare_text;
use super::{Estimate, StartingError};
use crate::diagnose::align;
use crate::diagnose::bench::Bench;
use crate::diagnose::edges::Edges;
use crate::diagnose::filter::Noise;
use crate::diagnose::model::{Board, Model};
use crate::diagnose::noise::UNSEEN;
use crate::diagnose::pattern::Pattern;
use crate::diagnose::phases;
use crate::diagnose::pipeline::{self, EDGES_LEAST};
use crate::diagnose::record::Record;
use crate::diagnose::rig::DiagnoseError;
use crate::diagnose::search;
use crate::twin::{Twin, TwinError};

/// Turns that a recording needs to show what repeats.
const TURNS_LEAST: f64 = 3.0;
/// Rounds in which the delays move the course that they are fitted on.
const ROUNDS: usize = 3;
/// Part of a recording's turns, the slowest and the fastest, that are left out of the speed's range.
const OUTERMOST: f64 = 0.01;
/// Fastest speed over slowest from which on torque is told from the disc at all.
const TWO_SPEEDS: f64 = 1.1;
/// Edges that the noise is fitted on at the most: more make its intervals no narrower than its model is true.
const NOISE_EDGES: usize = 60_000;

/// A recording whose edges are placed.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Its file, for messages.
    pub file: String,
    /// Its edges.
    pub edges: Edges,
}

/// What recordings say of a rig.
#[derive(Clone, Debug)]
pub struct Starting {
    /// Its sensor.
    pub found: Found,
    /// Clock of the recordings, Hz.
    pub clock_hz: u64,
    /// Edges, turns and seconds of all recordings.
    pub edges: usize,
    /// Turns.
    pub turns: f64,
    /// Seconds.
    pub seconds: f64,
    /// Slowest and fastest mean speed of a turn, r/min.
    pub speed_r_min: [f64; 2],
    /// Whether places are angles of the disc.
    pub anchored: bool,
    /// RMS of the stamps' errors, s.
    pub stamp_s: Estimate,
    /// The same beside the rounding of a tick, s; none where that is all.
    pub jitter_s: Option<Estimate>,
    /// Density of the torque noise over the inertia, (rad/s^2)^2 s.
    pub torque: Estimate,
    /// Delays of the edge classes; none where none are seen.
    pub delays: Vec<ClassDelay>,
    /// Where none are seen, what one of 95 % would have to be more than, s.
    pub delay_limit_s: Option<f64>,
    /// Torques at whole orders that the speeds tell from the disc.
    pub torques: Vec<OrderTorque>,
    /// What swings at orders that are not whole, and at frequencies.
    pub rhythms: Vec<Rhythm>,
    /// The disc's errors.
    pub disc: Option<DiscFound>,
}

/// A recording's edges beside its twin.
struct Rig {
    record: Record,
    twin: Twin,
}

/// A twin of a sensor and a clock, and of what swings.
///
/// # Errors
/// [`TwinError`] for a sensor or clock that no twin may have.
pub fn bare(found: &Found, clock_hz: u64, rhythms: &[Rhythm]) -> Result<Twin, TwinError> {
    let text = bare_text(found, clock_hz, rhythms);
    Twin::parse(&text, "the recordings' own twin")
}

/// Estimates a starting twin's numbers beside what swings at a rate of its own.
///
/// # Errors
/// [`StartingError`] where a recording is too short.
pub fn estimate(
    found: &Found,
    clock_hz: u64,
    recordings: &[Placed],
    rhythms: Vec<Rhythm>,
    progress: &mut dyn FnMut(f64, &'static str),
) -> Result<Starting, StartingError> {
    let twin = bare(found, clock_hz, &rhythms)?;
    let mut rigs = Vec::new();
    for one in recordings {
        let record = Record::of(&one.edges, &twin);
        if record.len() < EDGES_LEAST || record.turns() < TURNS_LEAST {
            return Err(DiagnoseError::TooShort {
                file: one.file.clone(),
                edges: record.len(),
                turns: record.turns(),
                least: EDGES_LEAST,
            }
            .into());
        }
        let twin = twin.clone();
        rigs.push(Rig { record, twin });
    }
    progress(0.05, "Fitting the noise");
    let speed_r_min = speeds(&rigs);
    let turns = align::turns(&benches(&rigs));
    for (rig, by) in rigs.iter_mut().zip(turns) {
        let places = rig.record.place.iter_mut();
        places.for_each(|place| *place += by);
    }
    let mut beside_all = benches(&rigs);
    for (rig, bench) in rigs.iter_mut().zip(&mut beside_all) {
        phases::settle(bench)?;
        rig.twin.clone_from(&bench.twin);
    }
    let mut board = Board::of(match fewer(&rigs) {
        Some(some) => benches(&some),
        None => beside_all,
    });
    // Of recordings of which nothing is known nothing is missing.
    board.levels = true;
    let mut board = along(board.at_rest(), &rigs, &Model::default());
    settle(&mut board, &rigs);
    renoise(&mut board, &rigs, &Model::default());
    progress(0.3, "Looking for delays");
    let (delays, delay_limit_s) = if changes(speed_r_min) {
        delays_of(&mut board, &mut rigs)
    } else {
        (Vec::new(), None)
    };
    progress(0.5, "Telling torque from the disc");
    let mut fit = board.fit(&search::nuisances(&board));
    if changes(speed_r_min) {
        if let Some(some) = fewer(&rigs) {
            board = along(board, &some, &fit.model);
        }
        fit = torques::find(&mut board, &fit.model);
        board = along(board, &rigs, &fit.model);
    }
    progress(0.7, "Fitting the noise");
    fit = board.fit(&fit.model);
    let NoiseFound {
        stamp_s, torque, ..
    } = renoise(&mut board, &rigs, &fit.model);
    let fit = board.unsure_of_hold(&board.fit(&fit.model));
    progress(0.9, "Fitting the disc");
    let disc = disc::find(&board, &fit);
    let tick2 = (1.0 / clock_hz as f64).powi(2) / 12.0;
    Ok(Starting {
        found: found.clone(),
        clock_hz,
        edges: board.edges(),
        turns: rigs.iter().map(|rig| rig.record.turns()).sum(),
        seconds: rigs.iter().map(|rig| rig.record.seconds()).sum(),
        speed_r_min,
        anchored: rigs.iter().all(|rig| rig.record.anchored),
        stamp_s,
        jitter_s: beside_ticks(stamp_s, tick2),
        torque,
        delays,
        delay_limit_s,
        torques: torques::sized(&fit, board.is_loose()),
        rhythms,
        disc,
    })
}

/// What stamps have beside the rounding of a tick; none where rounding may be all.
fn beside_ticks(stamp_s: Estimate, tick2: f64) -> Option<Estimate> {
    let [low, _] = stamp_s.ci95;
    let beside = stamp_s.map(|stamp| (stamp * stamp - tick2).max(0.0).sqrt());
    (low * low > tick2).then_some(beside)
}

fn benches(rigs: &[Rig]) -> Vec<Bench> {
    let each = rigs.iter().map(|Rig { record, twin }| {
        let noise = Noise {
            torque: 1.0,
            stamp_s: record.tick_s,
            unseen: UNSEEN,
            ..Noise::default()
        };
        Bench::new(record.clone(), twin, &[], &noise)
    });
    each.collect()
}

/// Puts recordings beside other twins, in the noise that a board has.
fn beside(board: &mut Board, rigs: &[Rig]) {
    let before = std::mem::replace(&mut board.benches, benches(rigs));
    for (bench, before) in board.benches.iter_mut().zip(before) {
        bench.weights = before.weights;
        bench.found.hold = before.found.hold;
    }
    if board
        .benches
        .iter()
        .any(|bench| bench.found.hold.stiffness != 0.0)
        && let Some(held) = board.found_anew()
    {
        *board = held;
    }
    board.set_noise(board.noise);
}

/// Some edges of recordings that have more than a search needs.
fn fewer(rigs: &[Rig]) -> Option<Vec<Rig>> {
    let edges = rigs.iter().map(|rig| rig.record.len()).sum();
    let all = rigs.iter().map(|rig| rig.record.edges).min()?;
    let few = pipeline::some_of(all, edges, pipeline::SEARCHED)?;
    let some = rigs.iter().map(|rig| Rig {
        record: rig.record.of_some(few),
        twin: rig.twin.clone(),
    });
    Some(some.collect())
}

/// A board along other edges of its recordings, with what it found.
fn along(board: Board, rigs: &[Rig], model: &Model) -> Board {
    let mut both = board.benches.iter().zip(rigs);
    if both.all(|(bench, rig)| bench.record.len() == rig.record.len()) {
        return board;
    }
    let each = rigs.iter().map(|rig| rig.record.clone());
    let other = board.along(each.collect(), model);
    let mut other = other.unwrap_or_else(|| Board::of(benches(rigs)));
    other.fit_noise(model);
    other
}

/// Finds the delays and puts them into the twins and onto the board. Without any, how large one could be unseen, s.
fn delays_of(board: &mut Board, rigs: &mut [Rig]) -> (Vec<ClassDelay>, Option<f64>) {
    let Some(delays) = delays::find(board) else {
        let limit_s = delays::resolution(board).map(|error| super::NORMAL_95 * error);
        return (Vec::new(), limit_s);
    };
    let (mut late_s, mut covariance) = delays.fit(board);
    let mut told = delays.told(board, &late_s, &covariance);
    for _ in 0..ROUNDS {
        for rig in &mut *rigs {
            (rig.twin.edge_delay, rig.twin.channel_skew) = delays::declared(&told);
        }
        beside(board, rigs);
        resize(board, &Model::default());
        let (more_s, spread) = delays.fit(board);
        let done = more_s.amax() < 0.1 * spread.diagonal().amax().sqrt();
        late_s += more_s;
        covariance = spread;
        told = delays.told(board, &late_s, &covariance);
        if done {
            break;
        }
    }
    (told, None)
}

/// Slowest and fastest mean speed of a turn, r/min, but for a few.
fn speeds(rigs: &[Rig]) -> [f64; 2] {
    let each = rigs.iter().flat_map(|Rig { record, .. }| {
        let turn = (record.len() as f64 / record.turns()).ceil() as usize;
        let pairs = (turn..record.len()).map(move |at| (at - turn, at));
        pairs.filter_map(|(from, until)| {
            let way = (record.place[until] - record.place[from]) as f64 * record.step_rad();
            let seconds = record.time_s[until] - record.time_s[from];
            (seconds > 0.0).then(|| way / seconds * 60.0 / TAU)
        })
    });
    let mut speeds: Vec<f64> = each.collect();
    if speeds.is_empty() {
        return [0.0; 2];
    }
    speeds.sort_by(f64::total_cmp);
    let last = speeds.len() - 1;
    let at = (OUTERMOST * last as f64) as usize;
    [speeds[at], speeds[last - at]]
}

/// Whether the speed changes so much that what goes with it is told from the disc.
pub(super) fn changes([slow, fast]: [f64; 2]) -> bool {
    fast > TWO_SPEEDS * slow && fast >= 0.0 || slow < TWO_SPEEDS * fast && fast < 0.0
}

/// Sets the noise to what edges show against the same edges a turn before, where that is likelier: the disc's errors cancel so, whatever
/// they are, and all noise comes twice. Noise that was fitted with the disc in it may be so large that it hides the disc in turn.
fn settle(board: &mut Board, rigs: &[Rig]) {
    resize(board, &Model::default());
    let parts = rigs.iter().filter_map(|rig| {
        let record = &rig.record;
        let mean_speed = record.turns() * TAU / record.seconds();
        let mut seen: Vec<Option<usize>> = vec![None; record.edges as usize];
        let (mut first, mut changes) = (None, Vec::new());
        for at in 0..record.len() {
            if let Some(before) = seen[record.slot(at)].replace(at) {
                first.get_or_insert(at);
                let way = record.grid_rad(at) - record.grid_rad(before);
                changes.push(way - mean_speed * (record.time_s[at] - record.time_s[before]));
            } else if first.is_some() {
                // An edge that comes for the first time so late goes on from the one before it.
                changes.push(changes.last().copied().unwrap_or(0.0));
            }
        }
        Some((rig.part(first?..record.len()), changes))
    });
    let (parts, changes): (Vec<Rig>, Vec<Vec<f64>>) = parts.unzip();
    if parts.is_empty() {
        return;
    }
    let mut twice = Board {
        benches: benches(&parts),
        pattern: None,
        ..board.clone()
    };
    for (bench, changes) in twice.benches.iter_mut().zip(changes) {
        bench.residual = changes;
    }
    twice.fit_noise(&Model::default());
    let mut other = board.clone();
    for (bench, twice) in other.benches.iter_mut().zip(&twice.benches) {
        let before = bench.weights.len() - twice.weights.len();
        let first = twice.weights.first().copied().unwrap_or(1.0);
        bench.weights[..before].fill(first);
        bench.weights[before..].copy_from_slice(&twice.weights);
    }
    other.set_noise(Noise {
        torque: 0.5 * twice.noise.torque,
        drift: 0.5 * twice.noise.drift,
        stamp_s: twice.noise.stamp_s / std::f64::consts::SQRT_2,
        ..twice.noise
    });
    resize(&mut other, &Model::default());
    if noise::cost(&other) < noise::cost(board) {
        *board = other;
    }
}

/// Sets the disc's pattern to the size of most evidence in the present noise.
fn resize(board: &mut Board, model: &Model) {
    let before = board.pattern.take();
    let Some(mut pattern) = before.or_else(|| Pattern::new(&board.benches)) else {
        return;
    };
    let rest = board.rest(model);
    let white = board.with_pattern(&rest);
    pattern.size_up(&board.benches, &white);
    board.pattern = Some(pattern);
}

/// Fits the noise and the pattern's size in turn, as each bears on the other.
fn renoise(board: &mut Board, rigs: &[Rig], model: &Model) -> NoiseFound {
    let mut found = noise_of(board, rigs, model);
    for _ in 1..ROUNDS {
        board.set_noise(found.noise);
        resize(board, model);
        found = noise_of(board, rigs, model);
    }
    board.set_noise(found.noise);
    resize(board, model);
    found
}

/// The noise beside a model, on the middle of long recordings.
fn noise_of(board: &Board, rigs: &[Rig], model: &Model) -> NoiseFound {
    let edges = board.edges();
    if edges <= NOISE_EDGES {
        return noise::fit(board, model);
    }
    let share = NOISE_EDGES as f64 / edges as f64;
    let parts: Vec<Rig> = { rigs.iter() }
        .map(|rig| rig.part(middle_of(&rig.record, share)))
        .collect();
    let mut part = board.clone();
    for (bench, rig) in part.benches.iter_mut().zip(rigs) {
        bench.weights = bench.weights[middle_of(&rig.record, share)].to_vec();
    }
    beside(&mut part, &parts);
    noise::fit(&part, model)
}

/// Edges of the middle part of a recording.
fn middle_of(record: &Record, share: f64) -> std::ops::Range<usize> {
    let count = record.len();
    let kept = (share * count as f64) as usize;
    let from = (count - kept) / 2;
    from..from + kept
}

impl Rig {
    fn part(&self, range: std::ops::Range<usize>) -> Self {
        let record = &self.record;
        Self {
            record: Record {
                time_s: record.time_s[range.clone()].to_vec(),
                place: record.place[range.clone()].to_vec(),
                way: record.way[range].to_vec(),
                ..record.clone()
            },
            twin: self.twin.clone(),
        }
    }
}
