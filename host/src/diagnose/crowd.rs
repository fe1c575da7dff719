//! Findings side by side: which edges they show on, and which rhythms are too near each other to be mechanisms of their own.

use super::board::Board;
use super::hypothesis::Hypothesis;
use super::locate::Among;
use super::search::Found;
use crate::mechanism::{EdgeClasses, LockedTo};

/// Edges that a finding shows on: alike or against each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// All alike.
    Alike,
    /// Rises against falls.
    Level,
    /// Channel against channel.
    Channel,
    /// Those about one place of the disc.
    Place,
}

/// Edges that a finding shows on.
#[must_use]
pub fn family(found: &Found) -> Family {
    match found.hypothesis.mechanism.card().edge_classes {
        EdgeClasses::RiseAgainstFall => Family::Level,
        EdgeClasses::ChannelAgainstChannel => Family::Channel,
        EdgeClasses::OftenOne => Family::Place,
        EdgeClasses::Alike | EdgeClasses::Own => Family::Alike,
    }
}

/// Edges that some are of.
#[must_use]
pub const fn kin(among: Among) -> Family {
    match among {
        Among::All => Family::Alike,
        Among::Level | Among::LevelOf(_) => Family::Level,
        Among::Channel(_) => Family::Channel,
    }
}

/// Cycles a turn of a hypothesis' rhythm, at the first recording's mean speed where it goes along time.
#[must_use]
pub fn cycles_a_turn(board: &Board, hypothesis: &Hypothesis) -> Option<f64> {
    let rhythm = hypothesis.rhythm()?;
    let turning = board.benches.first()?.seen.mean_speed() / std::f64::consts::TAU;
    let locked_to = hypothesis.mechanism.card().locked_to;
    Some(if locked_to.contains(&LockedTo::Frequency) {
        rhythm / turning
    } else {
        rhythm
    })
}

/// Rhythms that are too near each other to be mechanisms of their own: a rhythm that changes shows so.
#[must_use]
pub fn crowd(board: &Board, found: &[Found]) -> Vec<usize> {
    let turns = board
        .benches
        .iter()
        .map(|b| b.seen.turns())
        .fold(1.0, f64::max);
    let place = |found: &Found| -> Option<(Family, f64, bool)> {
        let cycles = cycles_a_turn(board, &found.hypothesis)?;
        Some((family(found), cycles, found.hypothesis.whole()))
    };
    let rhythms: Vec<Option<(Family, f64, bool)>> = found.iter().map(place).collect();
    let near = |one: &(Family, f64, bool)| {
        let near = rhythms.iter().flatten().filter(|other| {
            let close = (other.1 - one.1).abs() < (15.0 / turns).max(0.06 * one.1);
            other.0 == one.0 && close && !(other.2 && one.2)
        });
        // A whole order is not near itself here.
        near.count() + usize::from(one.2)
    };
    (0..found.len())
        .filter(|number| rhythms[*number].as_ref().is_some_and(|one| near(one) >= 3))
        .collect()
}
