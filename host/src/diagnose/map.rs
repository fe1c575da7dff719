//! The mismatch map: what each site explains of the residual following each carrier, in one table.

use super::diagnosis::Map;
use super::effect::{Carrier, Effect, Site};
use super::scan::Candidate;

const SITES: [&str; 6] = ["torque", "drive", "disc", "level", "stamp", "declared"];
const CARRIERS: [&str; 8] = [
    "edge class",
    "order",
    "frequency",
    "place",
    "instant",
    "slow time",
    "direction",
    "speed",
];

/// Row and column of an effect.
const fn cell(effect: &Effect) -> (usize, usize) {
    let row = match effect.site {
        Site::Torque => 0,
        Site::Drive => 1,
        Site::Disc(_) => 2,
        Site::Level(_) => 3,
        Site::Stamp(_) => 4,
        Site::Declared(_) => 5,
    };
    let column = match effect.carrier {
        Carrier::Steady => 0,
        Carrier::Order(_) => 1,
        Carrier::Tone(_) | Carrier::Chirp(..) => 2,
        Carrier::Bump(..) => 3,
        Carrier::Window(..) => 4,
        Carrier::Settling(..) | Carrier::Time => 5,
        Carrier::Direction => 6,
        Carrier::Power(_) | Carrier::Stribeck(_) => 7,
    };
    (row, column)
}

/// Fall of the sum of squares a number, the best candidate of each cell; none where none was tried.
fn table(candidates: &[Candidate]) -> Vec<Vec<Option<f64>>> {
    let mut table = vec![vec![None; CARRIERS.len()]; SITES.len()];
    for candidate in candidates {
        let Some(first) = candidate.effects.first() else {
            continue;
        };
        let (row, column) = cell(first);
        let here = candidate.gain / candidate.numbers().max(1) as f64;
        let most: &mut Option<f64> = &mut table[row][column];
        *most = Some(most.map_or(here, |most| most.max(here)));
    }
    table
}

/// The map from the candidates beside the twin as given, and beside the findings.
pub fn map(before: &[Candidate], after: &[Candidate]) -> Map {
    Map {
        sites: SITES.to_vec(),
        carriers: CARRIERS.to_vec(),
        before: table(before),
        after: table(after),
    }
}
