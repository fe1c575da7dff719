//! Figures of the families of cases beside the kinds.

use super::figures::{Figure, Target, Unit};
use super::score::Score;
use super::truth::{Family, Kind};

/// Confidence above which no false name may be said.
const SURE: f64 = 0.99;

/// The figures of one family's cases.
#[must_use]
pub fn figures(family: Family, scores: &[&Score]) -> Vec<Figure> {
    let each = |pick: &dyn Fn(&Score) -> bool, is: &dyn Fn(&Score) -> bool| -> Vec<bool> {
        let picked = scores.iter().filter(|score| pick(score));
        picked.map(|score| is(score)).collect()
    };
    let name = |what: &str| format!("{}: {what}", family.name());
    // A run that fails says nothing false, and is no better for it.
    let false_name = |score: &Score| {
        let mut said = score.said.iter();
        score.failure.is_some() || said.any(|said| said.is_false && said.confidence > SURE)
    };
    let mut all = vec![Figure::share(
        name("cases with a false name over 99 %, or no answer"),
        Some(Target::AtMost(0.01)),
        &each(&|_| true, &false_name),
    )];
    match family {
        Family::Thin => {}
        Family::FreeDrive | Family::Heavy => {
            all.push(Figure::share(
                name("the same, nothing missing"),
                None,
                &each(&|score| score.kind == Kind::Nothing, &false_name),
            ));
            all.push(Figure::share(
                name("right mechanism first, identifiable"),
                Some(Target::AtLeast(0.95)),
                &each(&|s| s.kind == Kind::One && s.identifiable, &|s| s.right),
            ));
            let parameters = scores.iter().flat_map(|score| &score.parameters);
            let held: Vec<bool> = parameters.filter_map(|one| one.holds).collect();
            all.push(Figure::share(
                name("95 % intervals that hold the true value"),
                Some(Target::Between(0.92, 0.98)),
                &held,
            ));
        }
        Family::CatalogueFree => {
            let removed = scores.iter().filter_map(|score| score.removed).collect();
            all.push(Figure::middle(
                &name("reducible RMS removed on held-out turns, median"),
                Unit::Share,
                Some(Target::AtLeast(0.9)),
                removed,
            ));
            all.push(Figure::share(
                name("cases with any name of the catalogue over 99 %"),
                None,
                &each(&|_| true, &|score| {
                    let mut said = score.said.iter();
                    said.any(|said| said.named() && said.confidence > SURE)
                }),
            ));
        }
    }
    all
}
