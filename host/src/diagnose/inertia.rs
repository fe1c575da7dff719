//! An inertia in a wrong unit: the shaft wanders as another, far lighter or heavier one would.
//!
//! Torque noise of a known density S on an inertia J, damped by c, wanders with the density S / J^2 of its acceleration and forgets at
//! c / J. Where a shaft wanders a hundred times as much as its twin's would, or a hundredth, the whole time alike and to no rhythm,
//! that is no missing physics: the twin's numbers are those of another shaft.

use std::ops::Range;

use super::bench::Bench;
use super::board::Board;
use super::every_turn::EveryTurn;
use super::kalman::{ShaftNoise, Whitener};
use super::locate::{Along, Among, peaks};
use super::noise_fit::{self, Free};
use super::run::{DiagnoseError, Recorded};

/// Variance of the white residual, either way, up to which the twin's inertia will do.
const EXPLAINED: f64 = 1.5;
/// The same of what another inertia has to leave.
const WHITE: f64 = 1.3;
/// Times the inertia, either way, from which on it is a matter of units.
const APART: f64 = 100.0;
/// Powers of ten that a unit may be off.
const DECADES: i32 = 8;
/// Steps a decade.
const STEPS: i32 = 2;
/// Edges that are enough for a first look.
const EDGES: usize = 4000;
/// Parts of a recording that have to show it alike, and how nearly.
const PARTS: usize = 4;
const ALIKE: f64 = 4.0;
/// Part of what is left that a few rhythms make at the most: what else is missing may be there too.
const RHYTHM: f64 = 0.3;
/// Evidence against it, as twice a difference of logarithms of likelihood, that noise of any kind may have.
const SURELY: f64 = 500.0;
/// Probability that noise alone makes a rhythm stand out.
const FALSE_ALARM: f64 = 1e-3;

/// Whether the shafts of a rig may be their twins', which no loop drives.
///
/// # Errors
/// [`DiagnoseError::OtherRig`] where a recording's shaft is another by far.
pub fn checked(rig: &[Recorded], board: &Board) -> Result<(), DiagnoseError> {
    for (one, bench) in rig.iter().zip(&board.benches) {
        let Some(times) = times_too_large(bench).filter(|_| one.twin.speed_loop().is_none()) else {
            continue;
        };
        let given = one.twin.shaft.inertia_kg_m2;
        return Err(DiagnoseError::OtherRig {
            file: one.file.clone(),
            twin: one.twin.name.clone(),
            why: format!(
                "its shaft of {given:?} kg m^2 would wander otherwise, as here one of about {:.1e} kg m^2 does; correct \
                 inertia_kg_m2 (1 g cm^2 is 1e-7 kg m^2), or the torque noise's density",
                given / times
            ),
        });
    }
    Ok(())
}

/// How many times the twin's inertia is that of the recording's shaft, where it is another by far; none where the twin's will do, or
/// something else may be wrong.
#[must_use]
fn times_too_large(bench: &Bench) -> Option<f64> {
    let declared = bench.declared?;
    if (EXPLAINED.recip()..EXPLAINED).contains(&mean_square(&bench.white)) {
        return None;
    }
    let seen = &bench.seen;
    let before = seen.len().saturating_sub(EDGES) / 2;
    let middle = before..seen.len().min(before + EDGES);
    // A disc that the twin does not know may be larger than all wander.
    let mut all = vec![(seen.angles.clone(), 0)];
    all.extend(EveryTurn::of(seen).into_iter().flat_map(|e| e.off(seen)));
    let judged = all.into_iter().filter_map(|(angles, numbers)| {
        let told = Told {
            bench,
            angles,
            declared,
        };
        let times = told.best(&middle)?;
        let likely = noise_fit::cost(&seen.readings, &told.angles, told.noise(times));
        let cost = likely + numbers as f64 * (seen.len() as f64).ln();
        Some((cost, times, told))
    });
    let (_, times, told) = judged.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let apart = times > APART || times < APART.recip();
    let times = (apart && told.stays(times)).then(|| told.likely(times))??;
    told.is_white(times).then_some(times)
}

/// A residual with what its twin tells of the noise.
struct Told<'a> {
    bench: &'a Bench,
    angles: Vec<f64>,
    declared: ShaftNoise,
}

impl Told<'_> {
    /// With how many times the shaft's inertia some edges are most likely.
    fn best(&self, edges: &Range<usize>) -> Option<f64> {
        let readings = &self.bench.seen.readings[edges.clone()];
        let grid = (-DECADES * STEPS..=DECADES * STEPS).map(|n| f64::from(n) / f64::from(STEPS));
        let each = grid.map(|decades| {
            let times = 10_f64.powf(decades);
            let noise = self.noise(times);
            let cost = noise_fit::cost(readings, &self.angles[edges.clone()], noise);
            (cost, times)
        });
        each.min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, times)| times)
    }

    /// The noise of a shaft whose twin has so many times its inertia.
    fn noise(&self, times: f64) -> ShaftNoise {
        let damping = self.bench.law.damping(0.0, self.bench.mean_speed);
        ShaftNoise {
            acceleration: self.declared.acceleration * times * times,
            load: self.declared.load * times * times,
            forgets_per_s: damping * (times - 1.0),
            ..self.declared
        }
    }

    /// Whether every part of the recording shows the same.
    fn stays(&self, times: f64) -> bool {
        let at = |part: usize| part * self.angles.len() / PARTS;
        (0..PARTS).all(|part| {
            let there = self.best(&(at(part)..at(part + 1)));
            there.is_some_and(|there| alike(there, times))
        })
    }

    /// Whether what it leaves is noise for the most part, as large as it should be.
    fn is_white(&self, times: f64) -> bool {
        let mut white = self.angles.clone();
        Whitener::new(&self.bench.seen.readings, self.noise(times)).whiten(&mut white);
        let peaks = peaks(self.bench, 0, &white, FALSE_ALARM).into_iter();
        let own = peaks.filter(|peak| (peak.among, peak.along) == (Among::All, Along::Turn));
        // Of a row that is one rhythm the line has half of its numbers.
        let share = 2.0 * own.map(|peak| peak.power).sum::<f64>() / white.len() as f64;
        (WHITE.recip()..WHITE).contains(&mean_square(&white)) && share < RHYTHM
    }

    /// The inertia by the most likely noise of torque and stamps of any size; none where stamps that are worse than the twin's are more
    /// likely than another inertia.
    fn likely(&self, times: f64) -> Option<f64> {
        let readings = &self.bench.seen.readings;
        let least_s = self.bench.least_stamp_s;
        let held = self.noise(times);
        let fitted = [self.declared.acceleration, held.acceleration].map(|acceleration| {
            let start = ShaftNoise {
                acceleration,
                ..held
            };
            let noise = noise_fit::fit(readings, &self.angles, least_s, start, Free::Sizes);
            (noise_fit::cost(readings, &self.angles, noise), noise)
        });
        let (cost, noise) = fitted.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let there = (noise.acceleration / self.declared.acceleration).sqrt();
        // A shaft that something holds otherwise than friction does has noise of its own.
        let any = noise_fit::fit(readings, &self.angles, least_s, noise, Free::All);
        let any = noise_fit::cost(readings, &self.angles, any);
        (alike(there, times) && cost < any + SURELY).then_some(there)
    }
}

fn alike(there: f64, times: f64) -> bool {
    (ALIKE.recip()..=ALIKE).contains(&(there / times))
}

fn mean_square(white: &[f64]) -> f64 {
    white.iter().map(|w| w * w).sum::<f64>() / white.len().max(1) as f64
}
