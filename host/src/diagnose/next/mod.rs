//! The recording to make next: what tells a finding from its look-alikes, simulated beforehand with either.

mod candidates;
mod extended;
mod rehearsal;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use super::diagnosis::{Expected, NextRecording};
use super::run::Recorded;
use super::settle::Settled;
use crate::mechanism::Mechanism;
use candidates::{Candidate, candidates};
use rehearsal::Rehearsal;

/// Difference by Schwarz's criterion that decides.
const DECIDES: f64 = 20.0;
/// Difference beyond which there is no need for more.
const ENOUGH: f64 = 1000.0;
/// Findings for which all candidates are tried; a recording that tells so many from others has enough to show, and each takes its time.
const TRIED: usize = 4;
/// Candidates that are looked at closer.
const CLOSER: usize = 2;

/// For each finding with a name, in their order, the recording that tells it from what these recordings allow as well; none where it is
/// not ambiguous.
#[must_use]
pub fn recordings(rig: &[Recorded], settled: &Settled) -> Vec<Option<NextRecording>> {
    let mut best: Option<Candidate> = None;
    let mut tried = 0;
    let named = settled.concluded.named.iter().enumerate();
    let each = named.map(|(number, name)| {
        let own = name.hypothesis.mechanism;
        let next = (!name.alike.is_empty()).then(|| {
            tried += 1;
            match rehearsed(rig, settled, number, best.as_ref(), tried <= TRIED) {
                Some((next, candidate)) => {
                    if next.expected_delta_bic.is_some() {
                        best = best.take().or(Some(candidate));
                    }
                    next
                }
                None => not_simulated(own, &name.alike),
            }
        });
        with_the_rig(next, own, &name.alike)
    });
    each.collect()
}

/// The recording to make next of several: the first that decides something.
#[must_use]
pub fn first<'a>(
    all: impl Iterator<Item = Option<&'a NextRecording>> + Clone,
) -> Option<&'a NextRecording> {
    let mut each = all.clone().flatten();
    let decides = each.find(|next| next.expected_delta_bic.is_some());
    decides.or_else(|| all.flatten().next())
}

/// The candidate that shows most for what it takes, as simulated; one that tells other findings apart is as good where it shows enough,
/// and the only one unless `all` are tried.
fn rehearsed(
    rig: &[Recorded],
    settled: &Settled,
    number: usize,
    other: Option<&Candidate>,
    all: bool,
) -> Option<(NextRecording, Candidate)> {
    if settled.concluded.named.get(number)?.look_alikes.is_empty() {
        return None;
    }
    let rehearsal = Rehearsal::of(rig, settled, number)?;
    let mechanisms: Vec<Mechanism> = rehearsal.mechanisms().collect();
    let bench = settled.given.benches.first()?;
    let expected = |one: &Candidate| -> Option<(Vec<Expected>, f64)> {
        let each = mechanisms.par_iter().enumerate().map(|(truth, mechanism)| {
            Some(Expected {
                mechanism: *mechanism,
                delta_bic: rehearsal.difference(one, truth)?,
            })
        });
        let expected: Vec<Expected> = each.collect::<Option<_>>()?;
        let least = expected.iter().map(|e| e.delta_bic).reduce(f64::min)?;
        Some((expected, least))
    };
    if let Some(other) = other
        && let Some((expected, least)) = expected(other)
        && least > ENOUGH
    {
        return Some((decided(&mechanisms, other, expected, least), other.clone()));
    }
    if !all {
        return None;
    }
    let mut tried: Vec<(Candidate, f64)> = candidates(&rig.first()?.twin, bench)
        .into_par_iter()
        .filter_map(|one| {
            let shows = rehearsal.difference(&one, 0)?;
            Some((one, shows))
        })
        .collect();
    tried.sort_by(|a, b| worth(&b.0, b.1).total_cmp(&worth(&a.0, a.1)));
    // The one that shows most whichever it is.
    tried.truncate(CLOSER);
    let closer: Vec<(Candidate, Vec<Expected>, f64)> = tried
        .into_par_iter()
        .filter_map(|(one, _)| {
            let (expected, least) = expected(&one)?;
            Some((one, expected, least))
        })
        .collect();
    let (best, expected, least) = closer
        .into_iter()
        .max_by(|a, b| worth(&a.0, a.2).total_cmp(&worth(&b.0, b.2)))?;
    let next = if least < DECIDES {
        undecided(mechanisms[0], &mechanisms[1..], &best, least)
    } else {
        decided(&mechanisms, &best, expected, least)
    };
    Some((next, best))
}

/// A recording that tells the first of some mechanisms from the others.
fn decided(
    mechanisms: &[Mechanism],
    best: &Candidate,
    expected: Vec<Expected>,
    least: f64,
) -> NextRecording {
    let differs: Vec<String> = expected
        .iter()
        .map(|e| format!("about {} if it is {}", digits(e.delta_bic), e.mechanism))
        .collect();
    NextRecording {
        text: format!(
            "{} would tell {} from {}: diagnosed together with what there is, Schwarz's criterion (10 is strong) would differ by {}.",
            best.text,
            mechanisms[0],
            listed(&mechanisms[1..]),
            differs.join(", ")
        ),
        expected_delta_bic: Some(least),
        expected,
    }
}

/// The same, with what tells it from mechanisms that leave the same edges in whatever this rig does.
fn with_the_rig(
    next: Option<NextRecording>,
    own: Mechanism,
    alike: &[Mechanism],
) -> Option<NextRecording> {
    let rig = own.card().told_by_rig.iter();
    let others: Vec<Mechanism> = rig.filter(|one| !alike.contains(one)).copied().collect();
    if others.is_empty() {
        return next;
    }
    let other = listed(&others);
    let more = format!(
        "A recording with the gear disconnected would tell {own} from {other}: of the two only what a mesh makes is gone then. Not \
         simulated, as both leave the same edges as long as it is connected; the gear's tooth counts must give this order as well."
    );
    Some(match next {
        Some(next) => NextRecording {
            text: format!("{} {more}", next.text),
            ..next
        },
        None => NextRecording {
            text: more,
            expected_delta_bic: None,
            expected: Vec::new(),
        },
    })
}

/// What a candidate that shows so much is worth for what it takes: what is plain need not be plainer.
fn worth(candidate: &Candidate, shows: f64) -> f64 {
    (shows.min(ENOUGH) + 1e-6 * shows) / candidate.effort
}

/// No other recording of this rig shows it.
fn undecided(own: Mechanism, others: &[Mechanism], best: &Candidate, least: f64) -> NextRecording {
    NextRecording {
        text: format!(
            "{} No other speed or direction would tell {own} from {} here: of those simulated the best, {}, makes a difference of {} by \
             Schwarz's criterion, where 10 is strong.",
            own.separated_by(),
            listed(others),
            best.text,
            // Below nothing is chance.
            digits(least.max(0.0))
        ),
        expected_delta_bic: None,
        expected: Vec::new(),
    }
}

/// What looks alike leaves the very same edges in any simulation of this twin.
fn not_simulated(own: Mechanism, others: &[Mechanism]) -> NextRecording {
    NextRecording {
        text: format!(
            "{} Not simulated: {own} and {} leave the same edges in every recording that this twin can make.",
            own.separated_by(),
            listed(others)
        ),
        expected_delta_bic: None,
        expected: Vec::new(),
    }
}

fn listed(mechanisms: &[Mechanism]) -> String {
    let ids: Vec<&str> = mechanisms.iter().map(|m| m.id()).collect();
    ids.join(" and ")
}

/// To two digits.
fn digits(value: f64) -> String {
    let short: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    short.to_string()
}
