//! Figures in the field's units: F1 of "where", false discoveries by confidence, residuals that do not grow.

use super::figures::{Figure, Target, Unit};
use super::score::Score;
use super::truth::Kind;

/// How far the residual may grow on held-out turns by rounding alone, as a ratio.
const ROUNDING: f64 = 1.0001;
/// Confidences from which on false discoveries are counted.
const CONFIDENCES: [f64; 2] = [0.95, 0.99];

/// The figures of scored cases.
#[must_use]
pub fn figures(scores: &[&Score]) -> Vec<Figure> {
    let mut all = vec![where_f1(scores)];
    all.extend(CONFIDENCES.map(|least| false_discoveries(scores, least)));
    all.push(held_out(scores));
    all
}

/// F1 of the sites and carriers named. Look-alikes have no one place, and physics in no catalogue has none of the catalogue's.
fn where_f1(scores: &[&Score]) -> Figure {
    let counted = scores
        .iter()
        .filter(|score| !matches!(score.kind, Kind::LookAlike | Kind::Outside));
    let (mut right, mut all) = (0, 0);
    for score in counted {
        right += 2 * score.places.right;
        all += score.places.named + score.places.there;
    }
    Figure {
        name: "F1 of where: site and carrier of what was named".to_owned(),
        value: (all > 0).then(|| right as f64 / all as f64),
        unit: Unit::Share,
        of: (Some(right), all),
        target: None,
    }
}

/// Share of the findings said with some confidence that are of nothing that is there.
fn false_discoveries(scores: &[&Score], least: f64) -> Figure {
    let said = scores.iter().flat_map(|score| &score.said);
    let sure = said.filter(|said| said.confidence >= least);
    let each: Vec<bool> = sure.map(|said| said.is_false).collect();
    Figure::share(
        format!(
            "false discovery rate, confidence {:.0} % or more",
            100.0 * least
        ),
        Some(Target::AtMost(1.0 - least)),
        &each,
    )
}

/// Share of the runs whose residual on held-out turns is no larger with the findings than without.
fn held_out(scores: &[&Score]) -> Figure {
    let pairs = scores.iter().filter_map(|score| score.held_out_rad);
    let each: Vec<bool> = pairs
        .map(|[before, after]| after <= before * ROUNDING)
        .collect();
    Figure::share(
        "held-out residual after never above before",
        Some(Target::AtLeast(1.0)),
        &each,
    )
}
