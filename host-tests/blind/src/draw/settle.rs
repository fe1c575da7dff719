//! Sizes that hang on the recording itself: a play shows by the edges that the shaft passes after it turned round, and noise says
//! which those are.

use super::case::Drawn;
use super::limits::plausible;
use super::record::run;
use crate::ideal::{DETECTABLE, play, shows_play};
use crate::turning::Course;

/// Recordings tried with one noise.
const TRIES: usize = 10;
/// How close to the d' that was asked for is close enough to stop.
const CLOSE: f64 = 0.02;
/// How close it has to be.
const ALLOWED: std::ops::RangeInclusive<f64> = 0.8..=1.25;

/// Gives every play the size at which the recordings with this noise show it as they should, and says how they do; none where no
/// size does.
pub(super) fn settle(drawn: &mut Drawn, noise: u64) -> Option<()> {
    for at in 0..drawn.effects.len() {
        if shows_play(&drawn.effects[at].effect, &drawn.rigs) {
            settle_one(drawn, at, noise)?;
        }
    }
    Some(())
}

fn settle_one(drawn: &mut Drawn, at: usize, noise: u64) -> Option<()> {
    let asked = DETECTABLE * drawn.effects[at].times;
    let mut best: Option<(f64, f64)> = None;
    for _ in 0..TRIES {
        let effect = drawn.effects[at].effect.clone();
        let courses: Vec<Course> = (0..drawn.rigs.len())
            .map(|number| run(drawn, number, noise).course)
            .collect();
        let distance = play(&drawn.rigs, &courses, std::slice::from_ref(&effect));
        if distance.is_nan() || distance <= 0.0 {
            break;
        }
        let share = distance / asked;
        let off = share.ln().abs();
        if plausible(&effect, &drawn.rigs) && best.is_none_or(|(least, ..)| off < least) {
            best = Some((off, distance));
            let sized = &mut drawn.effects[at];
            sized.distance = distance;
            sized.times = distance / DETECTABLE;
            sized.ideal = effect.size() / sized.times;
        }
        if off < CLOSE {
            break;
        }
        // A larger play shows better until it keeps the next edge from being passed: then a step may lead away again.
        let factor = (1.0 / share).clamp(1e-3, 1e3);
        drawn.effects[at].effect = effect.scaled(factor);
    }
    let (_, distance) = best?;
    let sized = &mut drawn.effects[at];
    let now = sized.effect.size();
    sized.effect = sized.effect.scaled(sized.ideal * sized.times / now);
    ALLOWED.contains(&(distance / asked)).then_some(())
}
