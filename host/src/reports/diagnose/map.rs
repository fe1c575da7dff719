//! The mismatch map, before and after, and its strongest cell.

use crate::diagnose::diagnosis::Diagnosis;
use crate::diagnose::diagnosis::{Answer, Map};
use crate::report::plot::Heat;
use crate::report::{Body, si_digits};

/// A cell of the map with its gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Strongest {
    pub(super) site: &'static str,
    pub(super) carrier: &'static str,
    /// Fall of the sum of squares a parameter.
    pub(super) gain: f64,
}

impl Strongest {
    /// The first of the largest values of a map above zero.
    pub(super) fn of(map: &Map, values: &[Vec<Option<f64>>]) -> Option<Self> {
        let mut best: Option<Self> = None;
        for (site, row) in map.sites.iter().zip(values) {
            for (carrier, gain) in map.carriers.iter().zip(row) {
                let least = best.map_or(0.0, |best| best.gain);
                if let Some(gain) = gain.filter(|gain| gain.is_finite() && *gain > least) {
                    best = Some(Self {
                        site,
                        carrier,
                        gain,
                    });
                }
            }
        }
        best
    }

    /// The cell in words, with its gain.
    pub(super) fn words(&self) -> String {
        format!(
            "{} following {} (gain {} a parameter)",
            self.site,
            self.carrier,
            gain(self.gain)
        )
    }
}

/// Three digits without a tail of zeros.
fn gain(gain: f64) -> String {
    let text = si_digits(gain, "", 3).0;
    match text.contains('.') && !text.contains('×') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// Gain from which on a parameter is worth having: Schwarz's criterion, the logarithm of the number of edges.
#[allow(clippy::cast_precision_loss)]
pub(super) fn worth(diagnosis: &Diagnosis) -> Option<f64> {
    let edges: u64 = diagnosis.recordings.iter().map(|facts| facts.edges).sum();
    (edges > 1).then(|| (edges as f64).ln())
}

/// Both maps beside each other; nothing where the engine gave none.
pub(super) fn section(body: &mut Body, answer: &Answer) {
    let map = &answer.map;
    if map.sites.is_empty() || map.carriers.is_empty() {
        return;
    }
    let mut text = "Rows are where a mismatch enters, columns what it follows. A number is the gain: the fall of the sum of squared \
                    innovations for each parameter that the cell would cost. "
        .to_owned();
    let worth = worth(&answer.diagnosis);
    if let Some(worth) = worth {
        text += &format!(
            "Noise alone gives about 1; from {} on (bold) a parameter is worth having by Schwarz's criterion. ",
            gain(worth)
        );
    }
    text += "The strongest cell is outlined; hatched cells cannot be.";
    body.section("Mismatch map", &[&text]);
    // Both have one scale, which goes on beyond what a parameter is worth: noise looks pale in either.
    let all = map.before.iter().chain(&map.after).flatten().flatten();
    let most = all
        .copied()
        .filter(|v| v.is_finite())
        .fold(10.0 * worth.unwrap_or(1.0), f64::max);
    let top = 10f64.powf((most.log10() - 1e-9).ceil());
    let heat = |values: &[Vec<Option<f64>>]| {
        let mut heat = Heat::new("Gain per parameter", &map.carriers).range(1.0, top);
        if let Some(worth) = worth {
            heat = heat.bold_from(worth);
        }
        map.sites
            .iter()
            .zip(values)
            .fold(heat, |heat, (site, row)| heat.row(*site, row))
    };
    let before = caption(map, &map.before, "The twin as given");
    if answer.diagnosis.findings.is_empty() || map.after.is_empty() {
        body.figure(heat(&map.before), before);
        return;
    }
    let after = caption(map, &map.after, "With the findings");
    body.figure_pair((heat(&map.before), &before), (heat(&map.after), &after));
}

fn caption(map: &Map, values: &[Vec<Option<f64>>], name: &str) -> String {
    match Strongest::of(map, values) {
        Some(cell) => format!("{name}. Strongest: {}.", cell.words()),
        None => format!("{name}. No cell explains anything."),
    }
}
