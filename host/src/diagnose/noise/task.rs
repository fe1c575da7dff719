//! `capture_latency` by a task: captures wait while a task runs, f times a second for a time b each.
//!
//! An edge that falls a time x into the busy time is stamped at its end: late by b - x. Where the busy time is long against the noise,
//! single stamps show it ([`period`]), where it is a good part of the period, their sum does ([`folded`]); then f, b and each recording's
//! phase are fitted by the likelihood of each stamp ([`stamps`], [`fit`]).

mod absent;
mod busy;
mod declared;
mod fit;
mod folded;
mod period;
mod refit;
mod stamps;

use super::super::board::{Bench, Board, Column};
use super::super::spectrum::Spectrum;
use super::odds::anywhere;
use super::{NoiseFinding, NoiseParameter};
use crate::mechanism::{Mechanism, TASK_HZ};
use crate::report::si;
use fit::{Fitted, fitted};
use stamps::Stamps;

pub use absent::absent;
pub use busy::Busy;
pub use declared::{account, agrees, confirm};
pub use refit::{Refit, refit};

/// Slowest and fastest rate looked for, Hz.
const SLOWEST_HZ: f64 = TASK_HZ[0];
const FASTEST_HZ: f64 = TASK_HZ[1];
/// Fall of the sum of squares that a finding needs beyond its cost, and over that of a smooth rhythm; the same of twice the logarithm of
/// its likelihood.
const LEAST_GAIN: f64 = 40.0;
const LEAST_OVER_TONE: f64 = 15.0;
/// Edges that must have been held up.
const LEAST_HELD: f64 = 6.0;
/// Mean square that is left, at the most; 1 is noise. Where a shaft turns round what a task does is not all taken off: then times what is
/// left that it explains.
const NOISE: f64 = 2.0;
const LITTLE: f64 = 5.0;

/// Busy times by which stamps that a task held up are in doubt, where the others are to say alone when these edges crossed.
pub const DOUBT: f64 = 30.0;

/// A task that was found.
#[derive(Clone, Debug)]
pub struct Task {
    /// As a finding.
    pub finding: NoiseFinding,
    /// Its pattern, white, as large as it is.
    pub column: Column,
    /// Fall of the sum of squares.
    pub squares: f64,
}

/// Looks for a task in what is left, white.
#[must_use]
pub fn find(board: &Board, left: &[Vec<f64>]) -> Option<Task> {
    // A rate that nobody declared is too easily seen in what stamps do while a shaft comes to a stand.
    if board.benches.iter().any(stands) {
        return None;
    }
    let pairs = || board.benches.iter().zip(left);
    let rows: Vec<Stamps<'_>> = pairs()
        .map(|(bench, left)| Stamps::of(bench, left))
        .collect();
    let spectra: Vec<Spectrum> = pairs()
        .map(|(bench, left)| folded::spectrum(bench, left))
        .collect();
    let first = period::by_stamps(&rows).into_iter();
    let tried = first
        .chain(folded::by_rhythm(&rows, &spectra))
        .filter_map(|task| {
            let mut rows = rows.clone();
            Some((fitted(&mut rows, task)?, rows))
        });
    let (best, rows) = tried.max_by(|a, b| a.0.gain.total_cmp(&b.0.gain))?;
    told(board, &best, &rows, folded::tone(&spectra, best.task.f_hz))
}

/// Whether a recording's shaft comes to a stand slowly. One that turns round at once says enough before and after.
fn stands(bench: &Bench) -> bool {
    /// Parts of the highest speed: what is a stand, and what is slow; share of slow edges that is no turning round.
    const STAND: f64 = 0.1;
    const SLOW: f64 = 0.7;
    const MANY: f64 = 0.1;
    let speeds = || bench.seen.speeds.iter().map(|speed| speed.abs());
    let high = speeds().fold(0.0, f64::max);
    let slow = speeds().filter(|w| *w < SLOW * high).count();
    speeds().any(|w| w < STAND * high) && slow as f64 > MANY * bench.seen.len() as f64
}

/// A task as a finding, if it is sure; `tone` is what a smooth rhythm of its rate explains.
fn told(board: &Board, found: &Fitted, rows: &[Stamps<'_>], tone: f64) -> Option<Task> {
    let edges = board.edges() as f64;
    let task = &found.task;
    let (squares, left) = rows.iter().fold((0.0, 0.0), |(squares, left), row| {
        let (fall, rest) = row.squares();
        (squares + fall, left + rest)
    });
    let cost = (2 + rows.len()) as f64 * edges.ln();
    // Rates, phases and busy times that are told apart.
    let longest = rows
        .iter()
        .map(|row| row.bench.seen.seconds())
        .fold(0.0, f64::max);
    let jitter = rows
        .iter()
        .map(|row| row.jitter_s)
        .fold(f64::INFINITY, f64::min);
    let phases = (1.0 / (task.f_hz * jitter.max(f64::MIN_POSITIVE))).max(1.0);
    let places = (FASTEST_HZ * longest).max(1.0) * phases * phases;
    let p_value = anywhere((-found.gain).exp(), places);
    let likely = 2.0 * found.gain - cost > LEAST_GAIN && p_value < 1e-6;
    // With the task taken off there is noise or little else, or it stands in for something larger.
    let noise = left < NOISE * edges || squares > LITTLE * left;
    let large = squares - cost > LEAST_GAIN && squares > tone + LEAST_OVER_TONE;
    let real = (SLOWEST_HZ..FASTEST_HZ).contains(&task.f_hz) && found.held > LEAST_HELD;
    if !noise || !likely || !large || !real {
        return None;
    }
    let mut finding = NoiseFinding {
        mechanism: Mechanism::CaptureLatency,
        parameters: Vec::new(),
        delta_bic: squares - cost,
        p_value,
        text: String::new(),
        frequencies_hz: vec![task.f_hz],
        times_s: Vec::new(),
        edge_classes: Vec::new(),
        runner_up: Some((Mechanism::TorqueTone, squares - tone)),
        busy: Some(task.clone()),
    };
    number(&mut finding, found);
    let column = rows.iter().map(|row| Some(row.pattern()));
    Some(Task {
        finding,
        column: Column::of(column),
        squares,
    })
}

/// Puts the numbers of a task into a finding.
fn number(finding: &mut NoiseFinding, found: &Fitted) {
    let task = &found.task;
    let [rate_error, busy_error, end_error] = found.errors;
    let end_s = task.ends_s.first().copied().unwrap_or(0.0);
    let phase_s = (end_s - task.busy_s).rem_euclid(1.0 / task.f_hz);
    let parameter = |name, value, standard_error| NoiseParameter {
        name,
        value,
        standard_error,
    };
    finding.parameters = vec![
        parameter("task_hz", task.f_hz, rate_error),
        parameter("busy_s", task.busy_s, busy_error),
        parameter("phase_s", phase_s, end_error.hypot(busy_error)),
    ];
    finding.text = format!(
        "a task holds up captures {:.3} times a second for {} each: {:.0} edges within came at its end",
        task.f_hz,
        si(task.busy_s, "s"),
        found.held
    );
    finding.frequencies_hz = vec![task.f_hz];
    finding.busy = Some(task.clone());
}
