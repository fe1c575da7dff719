//! From a fit to what is said: findings with their words, confidence and verdict.

use super::agreement::{self, NOT_WHITE};
use super::alike::Alike;
use super::bench::Bench;
use super::diagnosis::{Answer, Map, Sized};
use super::effect::{Carrier, Site};
use super::judge::{self, Parts};
use super::lsq::dot;
use super::model::{Board, Fit};
use super::noise::Tails;
use super::rig::Recorded;
use super::scan::SURE;
use super::{correct, disc, events, name, search, stamps, task};
use crate::diagnose::diagnosis::{
    Diagnosis, Evidence, Finding, NextRecording, Place, RunnerUp, Verdict,
};
use crate::mechanism::Mechanism;
use crate::report::si;

/// How many times as much correlation as rounding to ticks alone makes is more than that.
const ROUNDED: f64 = 2.0;

/// Share of what is left that has to be foretold by the edges before to be more than noise of which the twins do not say how it is.
const LEFT: f64 = 0.03;

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
    let parts = Parts::blocks(board, fit);
    let [none, early, _] = Parts::held_out(board, fit).judged(fit);
    // Where all findings together make held-out turns worse, none that can be foretold has a name.
    let worse = early > none;
    let total: f64 = fit
        .model
        .groups()
        .iter()
        .map(|group| fit.loss(*group))
        .sum::<f64>()
        .max(f64::MIN_POSITIVE);
    let other_disc = disc::finding(board, fit, (fit.rss / board.edges() as f64).max(1.0).sqrt());
    let total = total + other_disc.as_ref().map_or(0.0, |(_, loss)| *loss);
    let mut findings: Vec<(Finding, Vec<Sized>, Option<f64>)> = Vec::new();
    let spread = (fit.rss / board.edges() as f64).max(1.0).sqrt();
    let inertia = |bench: &Bench| bench.twin.shaft.inertia_kg_m2 != 0.0;
    let known_inertia = board.benches.iter().all(inertia);
    for group in fit.model.groups() {
        let effects = fit.model.effects(group);
        let loss = fit.loss(group);
        let worth = search::evidence(board, loss, fit.model.numbers(group));
        // In noise of any kind it may be worth less.
        let judged = worths.iter().find(|(of, _)| *of == group);
        let worth = judged.map_or(worth, |(_, judged)| worth.min(*judged));
        let foretold = Parts::of_group(board, fit, group).foretold(fit, group);
        // What comes once, or once along the course, can't be foretold from elsewhere.
        let once = effects.iter().any(|effect| {
            matches!(
                effect.carrier,
                Carrier::Window(..)
                    | Carrier::Settling(..)
                    | Carrier::Time
                    | Carrier::Direction
                    | Carrier::Power(_)
                    | Carrier::Stribeck(_)
            )
        });
        let corrected = correct::measured(board, fit, group);
        let once = if corrected.is_empty() {
            once
        } else {
            parts.only_once(fit, group)
        };
        let mut mechanism = board.mechanism(&effects);
        let sideband = judge::sideband_of(board, fit, group);
        if sideband.is_some()
            || !once && (worse || !judge::foretells(foretold.fall, foretold.shown))
        {
            mechanism = Mechanism::Unknown;
        }
        let others: &[(Mechanism, f64)] = alike
            .iter()
            .find(|one| one.group == group)
            .map_or(&[], |one| &one.others);
        let mut numbers = if corrected.is_empty() {
            fit.numbers(group)
        } else {
            corrected.iter().map(|one| one.number.clone()).collect()
        };
        for number in &mut numbers {
            number.error = number.error.map(|error| error * spread);
        }
        let card = mechanism.card();
        let mut look_alikes: Vec<Mechanism> = others.iter().map(|(other, _)| *other).collect();
        for same in card.same_mark.iter().chain(card.told_by_rig) {
            if !look_alikes.contains(same) {
                look_alikes.push(*same);
            }
        }
        if corrected.is_empty() && mechanism == Mechanism::Unknown {
            look_alikes.clear();
        }
        let against: f64 = others
            .iter()
            .map(|(_, apart)| (-0.5 * apart.max(0.0)).exp())
            .sum();
        let confidence = (1.0 - (-0.5 * worth).exp()).max(0.0) / (1.0 + against);
        let next = (!look_alikes.is_empty()).then(|| NextRecording {
            text: card.separated_by.to_owned(),
            expected_delta_bic: None,
            expected: Vec::new(),
        });
        let mut place = name::place(board, &effects);
        if let Some(exponent) = card.speed_exponent.filter(|_| others.is_empty()) {
            place.speed_exponent = Some(f64::from(exponent));
        }
        let finding = Finding {
            mechanism,
            text: match sideband {
                Some(whole) => format!(
                    "{}: beside order {whole}, of a size or phase that changes along the recording",
                    name::text(&effects)
                ),
                None if !corrected.is_empty() => correct::text(&corrected, spread),
                None => name::text(&effects),
            },
            confidence,
            parameters: if !corrected.is_empty() {
                correct::parameters(&corrected, spread)
            } else if mechanism == Mechanism::Unknown {
                std::collections::BTreeMap::new()
            } else {
                name::parameters(mechanism, &numbers, known_inertia)
            },
            place,
            evidence: Evidence {
                delta_bic: worth,
                p_value: (-0.5 * worth).exp().min(1.0),
                held_out_rms_ratio: (!once).then(|| foretold.rms_ratio()),
                runner_up: others.first().map(|(mechanism, apart)| RunnerUp {
                    mechanism: *mechanism,
                    delta_bic: *apart,
                }),
            },
            look_alikes,
            next_recording: next,
        };
        let sized = fit.model.terms.iter().filter(|term| term.group == group);
        let sized = sized
            .map(|term| Sized {
                effect: term.effect,
                sizes: term.sizes.clone(),
            })
            .collect();
        findings.push((finding, sized, Some(loss / total)));
    }
    if let Some((finding, loss)) = other_disc {
        findings.push((finding, Vec::new(), Some(loss / total)));
    }
    let stamps = stamps::find(board, fit);
    // A latency is skewed, and has long tails of its own, declared or found.
    let declares = |bench: &Bench| bench.twin.capture_latency.is_some();
    let late = board.benches.iter().any(declares)
        || stamps
            .as_ref()
            .is_some_and(|found| found.mechanism == Mechanism::CaptureLatency);
    // Of a twin that says nothing of its noise none is another one.
    let declares = |bench: &Bench| bench.twin.noise.is_some();
    let told_noise = board.benches.iter().all(declares);
    let other_noise = told_noise && noise > SURE;
    let other_noise = other_noise.then(|| other_noise_of(board)).flatten();
    let other_noise = other_noise.filter(|_| !late).map(|text| (text, noise));
    let more_noise = || agreement::more_noise(board, fit);
    if let Some((text, worth)) = other_noise.or_else(more_noise) {
        let mut unknown = unknown();
        unknown.text = text;
        unknown.evidence.delta_bic = worth;
        findings.push((unknown, Vec::new(), None));
    } else if let Some(stamps) = stamps {
        findings.push((stamps, Vec::new(), None));
    }
    let tasks = given.benches.iter().enumerate();
    let tasks = tasks.filter_map(|(at, bench)| task::finding(bench, board, fit, at));
    findings.extend(tasks.map(|finding| (finding, Vec::new(), None)));
    findings.extend(
        events::findings(rig)
            .into_iter()
            .map(|finding| (finding, Vec::new(), None)),
    );
    let of_stamps = |finding: &Finding| {
        matches!(
            finding.mechanism,
            Mechanism::TimestampJitter | Mechanism::CaptureLatency
        )
    };
    let noisy = findings.iter().any(|(finding, ..)| of_stamps(finding));
    let fitted = agreement::agreement(given, board, fit);
    // Rounding to ticks hangs together where the course is quiet, and counts as far as it is what is left.
    let (rounded, rests) = (board.rounded(&fit.model), agreement::rests(board, fit));
    let square = |angles: &[Vec<f64>]| {
        let white = board.with_pattern(angles);
        dot(&white, &white).max(f64::MIN_POSITIVE)
    };
    let share = square(&rounded) / square(&rests);
    let spurs = share * share * agreement::correlation(board, &rounded).0;
    let left = agreement::correlation(board, &rests).0;
    let correlated = told_noise || fitted.correlated.unwrap_or(0.0) > LEFT;
    let not_white = correlated && fitted.whiteness_p.is_some_and(|p| p < NOT_WHITE);
    let left_over = not_white && !noisy && left > ROUNDED * spurs;
    if left_over && !findings.iter().any(nameless) {
        let mut unknown = unknown();
        unknown.evidence.delta_bic = left;
        findings.push((unknown, Vec::new(), None));
    }
    merge_unknown(&mut findings);
    // Beside something that no cell explains, a name is no surer than it is the larger: it may be a part of that.
    let without: f64 = findings
        .iter()
        .filter(|one| nameless(one))
        .map(|(finding, ..)| finding.evidence.delta_bic)
        .fold(0.0, f64::max);
    let with_name = findings
        .iter_mut()
        .filter(|one| !nameless(one) && !events::counted(one.0.mechanism));
    for (finding, ..) in with_name {
        let part = without / (without + finding.evidence.delta_bic.max(0.0)).max(f64::MIN_POSITIVE);
        finding.confidence = finding.confidence.min(1.0 - part);
    }
    findings.sort_by(|a, b| b.0.evidence.delta_bic.total_cmp(&a.0.evidence.delta_bic));
    let verdict = verdict(&findings);
    let last = verdict != Verdict::Unknown;
    findings.sort_by_key(|one| nameless(one) == last);
    let (mut said, mut cells, mut shares) = (Vec::new(), Vec::new(), Vec::new());
    for (finding, sized, share) in findings {
        said.push(finding);
        cells.push(sized);
        shares.push(share);
    }
    let next = said
        .iter()
        .find_map(|finding| finding.next_recording.clone());
    let declared: Vec<_> = cells
        .iter()
        .map(|cells| correct::declared(board, cells))
        .collect();
    let corrects: Vec<bool> = declared.iter().map(|some| !some.is_empty()).collect();
    let summary = summary(verdict, &said, &corrects);
    let pattern = disc::learned(board, &fit.model);
    Answer {
        diagnosis: Diagnosis {
            version: 2,
            verdict,
            summary,
            recordings: rig
                .iter()
                .zip(&board.benches)
                .map(|(one, bench)| agreement::facts(one, bench, board))
                .collect(),
            fit: fitted,
            findings: said,
            next_recording: next,
        },
        map: Map::default(),
        declared,
        cells,
        shares,
        learned_disc_rms_rad: pattern
            .as_ref()
            .filter(|_| !board.disc_given)
            .map(|errors| disc::rms(errors)),
        pattern,
        not_identifiable: Vec::new(),
        corrected: board.corrected(&fit.model),
        curves: agreement::curves(rig, given, board, fit),
    }
}

/// How the noise is not as twins declare it, in words: white, normal and the same throughout.
fn other_noise_of(board: &Board) -> Option<String> {
    let noise = board.noise;
    let level = |bench: &Bench| bench.weights.iter().all(|weight| *weight == 1.0);
    let wanders = noise.fade > 0.0 && noise.drift > noise.torque * noise.fade * noise.fade;
    if wanders {
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
fn unknown() -> Finding {
    Finding {
        mechanism: Mechanism::Unknown,
        text: "more than noise is left, and no cell of the map explains it".to_owned(),
        confidence: 0.9,
        parameters: std::collections::BTreeMap::new(),
        place: Place::default(),
        evidence: Evidence {
            delta_bic: 0.0,
            p_value: NOT_WHITE,
            held_out_rms_ratio: None,
            runner_up: None,
        },
        look_alikes: Vec::new(),
        next_recording: None,
    }
}

/// Whether a finding has no name and is no number of drive or shaft either, which no mechanism of the catalogue is of.
fn nameless((finding, cells, _): &(Finding, Vec<Sized>, Option<f64>)) -> bool {
    let declared = |cell: &Sized| matches!(cell.effect.site, Site::Declared(_));
    finding.mechanism == Mechanism::Unknown && !cells.iter().any(declared)
}

/// All that has no name is one finding.
fn merge_unknown(findings: &mut Vec<(Finding, Vec<Sized>, Option<f64>)>) {
    let (nameless, named): (Vec<_>, Vec<_>) = findings.drain(..).partition(nameless);
    *findings = named;
    let mut nameless = nameless.into_iter();
    let Some(mut first) = nameless.next() else {
        return;
    };
    for (finding, cells, share) in nameless {
        first.1.extend(cells);
        first.2 = match (first.2, share) {
            (Some(one), Some(other)) => Some(one + other),
            (one, other) => one.or(other),
        };
        if finding.evidence.delta_bic > first.0.evidence.delta_bic {
            first.0.evidence = finding.evidence;
            first.0.text = finding.text;
            first.0.place = finding.place;
        }
    }
    findings.push(first);
}

fn verdict(findings: &[(Finding, Vec<Sized>, Option<f64>)]) -> Verdict {
    let unknown = findings.iter().filter(|one| nameless(one)).count();
    if findings.is_empty() {
        Verdict::Complete
    } else if unknown == findings.len() {
        Verdict::Unknown
    } else if findings.iter().any(|(finding, ..)| open(finding)) {
        Verdict::Ambiguous
    } else if unknown > 0 {
        // What has no name may be the larger part.
        let strongest = findings
            .iter()
            .max_by(|a, b| a.0.evidence.delta_bic.total_cmp(&b.0.evidence.delta_bic));
        match strongest {
            Some(strongest) if nameless(strongest) => Verdict::Unknown,
            _ => Verdict::Partly,
        }
    } else {
        Verdict::Explained
    }
}

/// Whether a recording would tell more.
fn open(finding: &Finding) -> bool {
    let told_by_rig = finding.mechanism.card().told_by_rig;
    finding
        .look_alikes
        .iter()
        .any(|one| !told_by_rig.contains(one))
}

/// The orders or frequencies that a finding has, in words.
fn rhythms(finding: &Finding) -> Vec<String> {
    let place = &finding.place;
    let orders = place.orders.iter();
    let orders = orders.map(|order| format!("order {}", digits(*order)));
    let tones = place.frequencies_hz.iter();
    orders
        .chain(tones.map(|hz| format!("{} Hz", digits(*hz))))
        .collect()
}

/// A number with as many digits as a headline needs.
fn digits(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The verdict in words; `corrects` says which findings are other values of what the twin declares.
fn summary(verdict: Verdict, findings: &[Finding], corrects: &[bool]) -> String {
    let list = |start: &str, corrected: bool| {
        let mut names: Vec<(&str, Vec<String>)> = Vec::new();
        for (finding, corrects) in findings.iter().zip(corrects) {
            if *corrects != corrected {
                continue;
            }
            let name = match (corrected, finding.mechanism) {
                (true, Mechanism::Unknown) => finding.text.as_str(),
                _ => finding.mechanism.title(),
            };
            match names.iter_mut().find(|(other, _)| *other == name) {
                Some((_, all)) => all.extend(rhythms(finding)),
                None => names.push((name, rhythms(finding))),
            }
        }
        let each = names.iter().map(|(name, rhythms)| match &rhythms[..] {
            [] => (*name).to_owned(),
            [one] => format!("{name} at {one}"),
            [first @ .., last] => format!("{name} at {} and {last}", first.join(", ")),
        });
        let each: Vec<String> = each.collect();
        (!each.is_empty()).then(|| format!("{start}: {}.", each.join("; ")))
    };
    let said = [
        list("The twin has other numbers than the rig", true),
        list("The twin lacks", false),
    ];
    let said = said.into_iter().flatten().collect::<Vec<_>>().join(" ");
    match verdict {
        Verdict::Complete => "The twin explains the recordings; what is left is noise.".to_owned(),
        Verdict::Explained => said,
        Verdict::Partly => format!("{said} More than noise is left."),
        Verdict::Ambiguous => {
            let first = findings.iter().find(|finding| open(finding));
            let others = first.map_or_else(Vec::new, |first| {
                first.look_alikes.iter().map(|one| one.title()).collect()
            });
            format!(
                "{said} These recordings allow as well: {}.",
                others.join("; ")
            )
        }
        Verdict::Unknown => "Something is there that is none of the known mechanisms.".to_owned(),
    }
}
