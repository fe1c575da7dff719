//! From a fit to what is said: findings with their words, confidence and verdict.

use super::agreement::{self, LEFT, NOT_WHITE};
use super::alike::Alike;
use super::bench::Bench;
use super::diagnosis::{
    self, Answer, Diagnosis, Evidence, Finding, LearnedDisc, Map, NextRecording, RecordingFacts,
    RunnerUp, Sized, Verdict,
};
use super::effect::{Effect, Site};
use super::judge::{self, Foretold, Parts};
use super::lsq::dot;
use super::model::{Board, Fit};
use super::name::Number;
use super::nearby::Left;
use super::noise::Tails;
use super::rig::Recorded;
use super::said::{Said, merged};
use super::scan::SURE;
use super::{correct, disc, events, headline, name, search, stamps, task};
use crate::effect::words::words;
use crate::mechanism::Mechanism;
use crate::report::si;

/// How far what is said by a name has to stand out of the lines beside it: less would be a name that is hardly ever right.
const NAMED: f64 = 0.1;
/// How many times as much correlation as rounding to ticks alone makes is more than that.
const ROUNDED: f64 = 2.0;

/// The answer of a fit; its map is still empty.
#[must_use]
pub fn answer(
    rig: &[Recorded],
    given: &Board,
    board: &Board,
    fit: &Fit,
    alike: &[Alike],
    worths: &[(usize, f64)],
    noise: f64,
) -> Answer {
    let mut all = effects(board, fit, alike, worths);
    let other_disc = disc::finding(board, fit, (fit.rss / board.edges() as f64).max(1.0).sqrt());
    all.extend(other_disc.map(|(finding, loss)| Said {
        loss: Some(loss),
        ..Said::alone(finding)
    }));
    let stamps = stamps::find(board, fit);
    let other_noise = other_noise(board, fit, stamps.as_ref(), noise);
    let tasks = given.benches.iter().enumerate();
    let tasks = tasks.filter_map(|(at, bench)| task::finding(bench, board, fit, at));
    let told = other_noise.or(stamps).into_iter();
    let told = told.chain(tasks).chain(events::findings(rig));
    all.extend(told.map(Said::alone));
    let (fitted, curves) = agreement::agreement(rig, given, board, fit);
    if let Some(left) = left_over(board, fit, &all, &fitted) {
        all.push(Said::alone(left));
    }
    // What is not larger than something without a name may be a part of that.
    let nameless: Vec<Said> = all.iter().filter(|one| !one.named).cloned().collect();
    for one in &mut all {
        if !one.named || events::counted(one.finding.mechanism) {
            continue;
        }
        let near = nameless.iter().filter(|other| !one.is_apart(other));
        let without = near.map(Said::strength).fold(0.0, f64::max);
        let part = without / (without + one.strength()).max(f64::MIN_POSITIVE);
        one.finding.confidence = one.finding.confidence.min(1.0 - part);
        if part > 0.5 {
            one.named = false;
            let declared = |cell: &Sized| matches!(cell.effect.site, Site::Declared(_));
            one.cells.retain(|cell| !declared(cell));
            one.finding = Finding {
                evidence: one.finding.evidence.clone(),
                ..unknown(one.finding.text.clone(), 0.0)
            };
        }
    }
    let all = merged(all);
    let verdict = headline::verdict(&all);
    let total: f64 = all.iter().filter_map(|one| one.loss).sum();
    let share = |one: &Said| one.loss.map(|loss| loss / total.max(f64::MIN_POSITIVE));
    let mut summary = headline::summary(verdict, &all);
    if let (Verdict::Complete, Some(open)) = (verdict, board.not_given()) {
        let rest = "the twin explains the recordings; what is left is noise.";
        summary = format!("Beside {open}, which it does not give, {rest}");
    }
    let findings: Vec<Finding> = all.iter().map(|one| one.finding.clone()).collect();
    let facts = rig.iter().zip(&board.benches);
    let facts: Vec<RecordingFacts> = facts
        .map(|(one, bench)| agreement::facts(one, bench, board))
        .collect();
    if verdict == Verdict::Complete
        && let Some(other) = facts.iter().find_map(RecordingFacts::other_speed)
    {
        summary = format!("But for its speed the twin explains the recordings: {other}.");
    }
    let errors = disc::learned(board, &fit.model);
    let errors = errors.zip(disc::spread(board, fit));
    let pattern = errors.map(|(errors_rad, spread)| LearnedDisc { errors_rad, spread });
    Answer {
        diagnosis: Diagnosis {
            version: 2,
            verdict,
            summary,
            recordings: facts,
            fit: fitted,
            next_recording: findings.iter().find_map(|one| one.next_recording.clone()),
            findings,
        },
        map: Map::default(),
        declared: all
            .iter()
            .map(|one| correct::declared(board, &one.cells))
            .collect(),
        shares: all.iter().map(share).collect(),
        cells: all.into_iter().map(|one| one.cells).collect(),
        inertia_known: inertia_known(board),
        learned_speed_loop: board.learned_loop(),
        learned_ringing: board.learned_ringing(),
        learned_disc_rms_rad: pattern
            .as_ref()
            .filter(|_| !board.disc_given)
            .map(|learned| disc::rms(&learned.errors_rad)),
        pattern,
        not_identifiable: Vec::new(),
        corrected: board.corrected(&fit.model),
        curves,
    }
}

/// Effects of the fit, as far as other turns foretell them with a name.
fn effects(board: &Board, fit: &Fit, alike: &[Alike], worths: &[(usize, f64)]) -> Vec<Said> {
    // Where all findings together make held-out turns worse, none that can be foretold has a name.
    let worse = Parts::held_out(board, fit).worse(fit);
    let spread = (fit.rss / board.edges() as f64).max(1.0).sqrt();
    let floors = floors(board, fit);
    let sized = board
        .unsure_of_hold(fit)
        .widened(|at| spread * floors[at].unwrap_or(1.0).sqrt());
    let inertia_known = inertia_known(board);
    let each = fit.model.groups().into_iter().map(|group| {
        let effects = fit.model.effects(group);
        let loss = fit.loss(group);
        let worth = search::evidence(board, loss, fit.model.numbers(group));
        // In noise of any kind it may be worth less.
        let judged = worths.iter().find(|(of, _)| *of == group);
        let worth = judged.map_or(worth, |(_, judged)| worth.min(*judged));
        let foretold = judge::foretold(board, fit, group);
        let corrected = correct::measured(board, &sized, group);
        let mut mechanism = board.mechanism(&effects);
        // What is left beside it may have such lines by chance: of so many the largest is so large.
        let own = fit.model.terms.iter().zip(&floors);
        let own = own.filter(|(term, _)| term.group == group);
        let floor = own.filter_map(|(_, floor)| *floor).min_by(f64::total_cmp);
        let chance = (floor.unwrap_or(1.0) - 1.0) * 2.0 * (board.edges() as f64).ln();
        let shown = foretold.as_ref().map_or(loss, |it| it.fall.min(loss));
        let stands_out = shown / (shown + chance);
        let sideband = judge::sideband_of(board, fit, group);
        let recurs = |it: &Foretold| !worse && judge::foretells(it.fall, it.shown);
        let hidden = stands_out < NAMED;
        if sideband.is_some() || hidden || !foretold.as_ref().is_none_or(recurs) {
            mechanism = Mechanism::Unknown;
        }
        let alike = alike.iter().find(|one| one.group == group);
        let others: &[(Mechanism, f64)] = alike.map_or(&[], |one| &one.others);
        let images: &[Effect] = alike.map_or(&[], |one| &one.images);
        let numbers = if corrected.is_empty() {
            sized.numbers(group)
        } else {
            corrected.iter().map(|one| one.number.clone()).collect()
        };
        let plausible = |one: &Number| mechanism.card().allows(&one.name, one.value);
        if corrected.is_empty() && !numbers.iter().all(plausible) {
            mechanism = Mechanism::Unknown;
        }
        let card = mechanism.card();
        let mut look_alikes: Vec<Mechanism> = Vec::new();
        let measured = others.iter().map(|(other, _)| other);
        for other in measured.chain(&card.same_mark).chain(&card.told_by_rig) {
            if !look_alikes.contains(other) {
                look_alikes.push(*other);
            }
        }
        let named = mechanism != Mechanism::Unknown || !corrected.is_empty();
        if !named {
            look_alikes.clear();
        }
        let against: f64 = others
            .iter()
            .map(|(_, apart)| (-0.5 * apart.max(0.0)).exp())
            .sum();
        let told = |one: &Mechanism| card.told_by_rig.contains(one);
        // A number of the shaft or its drive has no card of its own.
        let telling = look_alikes
            .first()
            .filter(|_| mechanism == Mechanism::Unknown);
        let telling = telling.map_or(card, |other| other.card());
        let next = (!look_alikes.iter().all(told)).then(|| NextRecording {
            text: telling.separated_by.clone(),
        });
        let mut place = name::place(board, &effects);
        place.orders_alike = name::place(board, images).orders;
        let edges = fit.model.finding(group);
        place.edges = edges
            .flat_map(|(at, _)| sized.edges_off(at, board))
            .collect();
        if let Some(exponent) = card.speed_exponent.filter(|_| others.is_empty()) {
            place.speed_exponent = Some(f64::from(exponent));
        }
        let cell = effects.first().map_or_else(String::new, words);
        let text = match sideband {
            Some(whole) => format!(
                "{cell}: beside order {whole}, of a size or phase that changes along the recording"
            ),
            None if !corrected.is_empty() => correct::text(&corrected),
            None => cell,
        };
        let plain = Finding::of(mechanism, text, worth);
        let units = corrected.iter().map(|one| one.unit.to_owned());
        let of_name = |number: &Number| name::unit(mechanism, &number.name, inertia_known);
        let units = units.chain(numbers.iter().map(of_name));
        let parameters = numbers.iter().zip(units).filter(|_| named);
        let parameters =
            parameters.map(|(number, unit)| (number.name.clone(), number.parameter(&unit)));
        let finding = Finding {
            confidence: plain.confidence / (1.0 + against) * stands_out,
            parameters: parameters.collect(),
            place,
            evidence: Evidence {
                held_out_rms_ratio: foretold.map(|foretold| foretold.rms_ratio()),
                lines_beside: floor,
                runner_up: others.first().map(|(mechanism, apart)| RunnerUp {
                    mechanism: *mechanism,
                    delta_bic: *apart,
                }),
                ..plain.evidence
            },
            look_alikes,
            next_recording: next,
            ..plain
        };
        let cells = fit.model.finding(group).map(|(at, term)| Sized {
            effect: term.effect,
            sizes: term.sizes.clone(),
            ci95: sized.intervals(at),
            at_speed: sized.at_speed(at, board.mean_speed()),
        });
        Said {
            named,
            finding,
            cells: cells.collect(),
            loss: Some(loss),
        }
    });
    each.collect()
}

/// How many times as much as in white noise the lines beside each term of a fit explain.
fn floors(board: &Board, fit: &Fit) -> Vec<Option<f64>> {
    let basis = fit.basis();
    let mut cleared = fit.clone();
    basis.clear(&mut cleared.left);
    let left = Left::of(board, &cleared, &basis);
    let terms = fit.model.terms.iter();
    terms.map(|term| left.floor(&term.effect)).collect()
}

/// Whether the twins declare an inertia.
fn inertia_known(board: &Board) -> bool {
    let declared = |bench: &Bench| bench.twin.shaft.inertia_kg_m2 != 0.0;
    board.benches.iter().all(declared)
}

/// Noise of another kind or another density than the twins declare.
fn other_noise(board: &Board, fit: &Fit, stamps: Option<&Finding>, worth: f64) -> Option<Finding> {
    // A latency is skewed, and has long tails of its own, declared or found.
    let declares = |bench: &Bench| bench.twin.capture_latency.is_some();
    let late = board.benches.iter().any(declares)
        || stamps.is_some_and(|found| found.mechanism == Mechanism::CaptureLatency);
    let of_a_kind = (tells_noise(board) && worth > SURE && !late).then(|| kind_of_noise(board));
    let of_a_kind = of_a_kind.flatten().map(|text| (text, worth));
    let (text, worth) = of_a_kind.or_else(|| agreement::more_noise(board, fit))?;
    Some(unknown(text, worth))
}

/// Whether the twins say how noisy the shaft is: of one that doesn't no noise is another one.
fn tells_noise(board: &Board) -> bool {
    board.benches.iter().all(|bench| bench.twin.noise.is_some())
}

/// That innovations still hang together, where neither noise nor rounding makes them do so.
fn left_over(board: &Board, fit: &Fit, said: &[Said], fitted: &diagnosis::Fit) -> Option<Finding> {
    let noisy = |one: &Said| {
        matches!(
            one.finding.mechanism,
            Mechanism::TimestampJitter | Mechanism::CaptureLatency
        )
    };
    let told = tells_noise(board) && !board.undriven;
    let correlated = told || fitted.correlated.unwrap_or(0.0) > LEFT;
    let white = fitted.whiteness_p.is_none_or(|p| p >= NOT_WHITE);
    if white || !correlated || said.iter().any(|one| noisy(one) || !one.named) {
        return None;
    }
    // Rounding to ticks hangs together where the course is quiet, and counts as far as it is what is left.
    let (rounded, rests) = (board.rounded(&fit.model), disc::rests(board, &fit.model));
    let square = |angles: &[Vec<f64>]| {
        let white = board.with_pattern(angles);
        dot(&white, &white).max(f64::MIN_POSITIVE)
    };
    let share = square(&rounded) / square(&rests);
    let spurs = share * share * agreement::correlation(board, &rounded).0;
    let left = agreement::correlation(board, &rests).0;
    let text = "more than noise is left, and no cell of the map explains it".to_owned();
    (left > ROUNDED * spurs).then(|| unknown(text, left))
}

/// How the noise is not as twins declare it, in words: white, normal and the same throughout.
fn kind_of_noise(board: &Board) -> Option<String> {
    let noise = board.noise;
    let level = |bench: &Bench| bench.weights.iter().all(|weight| *weight == 1.0);
    let wanders = noise.drift > noise.torque * noise.fade * noise.fade;
    // How a drive that nobody declared wanders and rings is its own.
    if noise.ring.density > 0.0 && !board.undriven {
        return Some(format!(
            "a swing at about {} that noise keeps up",
            si(noise.ring.rate / std::f64::consts::TAU, "Hz")
        ));
    }
    // A corner that is slower than the recording shows nowhere.
    if wanders && !board.undriven && noise.fade * board.seconds() > 1.0 {
        let hz = noise.fade / std::f64::consts::TAU;
        return Some(format!(
            "a torque that wanders more slowly than {}, and follows no carrier",
            si(hz, "Hz")
        ));
    }
    if !board.benches.iter().all(level) {
        return Some("noise whose level changes along the recording".to_owned());
    }
    (board.free.tails == Tails::Student)
        .then(|| "innovations that are far out more often than normal noise has them".to_owned())
}

/// Something that is none of the cells.
fn unknown(text: String, worth: f64) -> Finding {
    let plain = Finding::of(Mechanism::Unknown, text, worth);
    Finding {
        confidence: 0.9,
        evidence: Evidence {
            p_value: NOT_WHITE,
            ..plain.evidence
        },
        ..plain
    }
}
