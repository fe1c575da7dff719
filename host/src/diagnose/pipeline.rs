//! The pipeline: recordings and twins in, an answer out.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::answer::{Answer, Curve, Map, Sized};
use super::bench::Bench;
use super::cells::Bank;
use super::edges::turned;
use super::effect::{Carrier, Effect, Growth, Site};
use super::filter::Noise;
use super::judge::Parts;
use super::model::{Board, Fit};
use super::record::Record;
use super::rig::{DiagnoseError, Recorded};
use super::{correct, events, judge, map, name, search, stamps};
use crate::diagnose::diagnosis::{
    Diagnosis, Evidence, Finding, Fit as Agreement, HeldOut, NextRecording, Place, RecordingFacts,
    RunnerUp, Verdict,
};
use crate::mechanism::Mechanism;
use crate::sim;

/// Edges that a recording needs.
pub const EDGES_LEAST: usize = 200;
/// Turns that it needs.
const TURNS_LEAST: f64 = 3.0;
/// Difference of evidence within which two explanations are alike.
const ALIKE: f64 = 10.0;
/// Part of a finding's evidence that another cell has to have to be fitted in its place, how many are, and by how much a better one is.
const NEAR: f64 = 0.5;
const RIVALS: usize = 4;
const BETTER: f64 = 2.0;
/// Part of what a finding explains that it has to foretell.
const FORETELLS: f64 = 0.6;
/// Probability of whiteness below which something is left.
const NOT_WHITE: f64 = 1e-6;
/// How many times as much correlation as rounding to ticks alone makes is more than that.
const ROUNDED: f64 = 2.0;
/// Lags that whiteness is tested over.
const LAGS: usize = 24;
/// Points of a curve.
const POINTS: usize = 300;

/// Finds what the twins of one rig lack.
///
/// # Errors
/// [`DiagnoseError`] where there is nothing to compare.
pub fn diagnose(
    rig: &[Recorded],
    progress: &mut dyn FnMut(f64, &'static str),
) -> Result<Answer, DiagnoseError> {
    progress(0.05, "Comparing");
    let mut benches = Vec::new();
    for one in rig {
        benches.push(bench(one)?);
    }
    let mut board = Board::new(benches);
    let given = board.clone();
    progress(0.15, "Searching");
    let search::Found {
        mut fit,
        bank,
        not_identifiable,
    } = search::search(&mut board);
    progress(0.6, "Weighing look-alikes");
    let alike = swapped(&mut board, &bank, &mut fit);
    progress(0.85, "Judging");
    let mut answer = answer(rig, &given, &board, &fit, &alike);
    answer.not_identifiable = not_identifiable;
    let nuisances = fit.model.nuisances();
    let before = board.fit(&nuisances);
    answer.map = map::map(
        &search::candidates(&board, &bank, &before),
        &search::candidates(&board, &bank, &fit),
    );
    Ok(answer)
}

/// A recording beside its twin.
fn bench(one: &Recorded) -> Result<Bench, DiagnoseError> {
    let edges = turned(one.edges.clone(), &one.twin).map_err(|why| DiagnoseError::Reversal {
        file: one.file.clone(),
        why,
    })?;
    let record = Record::of(&edges, &one.twin);
    let turns = record.turns();
    if record.len() < EDGES_LEAST || turns < TURNS_LEAST {
        return Err(DiagnoseError::TooShort {
            file: one.file.clone(),
            edges: record.len(),
            turns,
            least: EDGES_LEAST,
        });
    }
    let errors = sim::true_errors(&one.twin)?;
    let noise = Noise {
        torque: 1.0,
        stamp_s: record.tick_s,
        drift: 0.0,
        angle_rad: 0.0,
    };
    let bench = Bench::new(record, &one.twin, &errors, &noise);
    Ok(match whole_turns(&bench) {
        Some(record) => Bench::new(record, &one.twin, &errors, &noise),
        None => bench,
    })
}

/// A recording of one channel whose count is whole turns off after a reversal, which its edges alone do not show: the twin's course does.
fn whole_turns(bench: &Bench) -> Option<Record> {
    const NEAR: usize = 6;
    if bench.record.classes > 2 {
        return None;
    }
    let mut record = bench.record.clone();
    let mut turned = false;
    for at in 1..record.len() {
        if record.way[at] == record.way[at - 1] {
            continue;
        }
        let middle = |range: std::ops::Range<usize>| {
            let mut some: Vec<f64> = bench.residual[range].to_vec();
            some.sort_by(f64::total_cmp);
            some.get(some.len() / 2).copied()
        };
        let (Some(before), Some(after)) = (
            middle(at.saturating_sub(NEAR)..at),
            middle(at..(at + NEAR).min(record.len())),
        ) else {
            continue;
        };
        let turns = ((after - before) / std::f64::consts::TAU).round() as i64;
        if turns != 0 {
            let by = turns * record.edges;
            record.place[at..].iter_mut().for_each(|place| *place -= by);
            turned = true;
        }
    }
    turned.then_some(record)
}

/// What a finding may be as well.
#[derive(Clone, Debug, Default)]
struct Alike {
    group: usize,
    /// Others with how much less evidence they have, least first.
    others: Vec<(Mechanism, f64)>,
}

/// Puts a better explanation in the place of a finding where there is one, and lists those that are as good.
fn swapped(board: &mut Board, bank: &Bank, fit: &mut Fit) -> Vec<Alike> {
    let mut all = Vec::new();
    for group in fit.model.groups() {
        let own = fit.model.effects(group);
        let mechanism = board.mechanism(&own);
        let corrects = own.iter().any(|effect| board.correction(effect).is_some());
        // What the twin declares comes first.
        let better = if corrects { ALIKE } else { BETTER };
        let rest = fit.without(group);
        let basis = rest.basis();
        let worth = search::evidence(board, rest.rss - fit.rss, fit.model.numbers(group));
        // The best of each other name that comes near, fitted with everything else.
        let mut rivals: Vec<(Mechanism, f64, Vec<Effect>)> = Vec::new();
        for candidate in search::candidates(board, bank, &rest) {
            let here = search::evidence(board, candidate.gain, candidate.numbers());
            let named = name::mechanism(&candidate.effects);
            let near = here > NEAR * worth - ALIKE;
            if !near || rivals.len() == RIVALS {
                break;
            }
            if corrects && board.same_columns(fit, group, &candidate.effects) {
                continue;
            }
            if rivals.iter().all(|(other, ..)| *other != named) {
                let (effects, gain) = board.beside(&rest, &basis, &candidate.effects);
                let fitted = search::evidence(board, gain, candidate.numbers());
                rivals.push((named, fitted, effects));
            }
        }
        for effects in grown(board, &own) {
            let (effects, gain) = board.beside(&rest, &basis, &effects);
            let numbers = fit.model.numbers(group) + effects.len();
            let fitted = search::evidence(board, gain, numbers);
            if fitted > worth + search::SURE {
                rivals.push((Mechanism::Unknown, fitted, effects));
            }
        }
        rivals.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut worth = worth;
        let mut named = mechanism;
        if rivals
            .first()
            .is_some_and(|(_, best, _)| *best > worth + better)
        {
            let (other, best, effects) = rivals.swap_remove(0);
            if other != mechanism {
                rivals.push((mechanism, worth, own));
            }
            (named, worth) = (other, best);
            let mut model = rest.model;
            model.add(&effects, group);
            *fit = board.fit(&model);
        }
        let alike = rivals
            .iter()
            .filter(|(other, here, _)| *other != named && worth - here < ALIKE);
        let mut others: Vec<(Mechanism, f64)> = alike
            .map(|(other, here, _)| (*other, worth - here))
            .collect();
        others.retain(|(other, _)| *other != Mechanism::Unknown);
        others.sort_by(|a, b| a.1.total_cmp(&b.1));
        all.push(Alike { group, others });
    }
    board.fit_noise(&fit.model);
    *fit = board.fit(&fit.model);
    all
}

/// The same effect with sizes that go with time or speed, to be fitted in its place.
fn grown(board: &Board, own: &[Effect]) -> Vec<Vec<Effect>> {
    let [effect] = own else { return Vec::new() };
    if effect.sizes() < 2 || effect.growth != Growth::Constant {
        return Vec::new();
    }
    let rate = 1.0 / board.seconds();
    [
        Growth::Even(rate),
        Growth::Even(-0.5 * rate),
        Growth::Speed(1.0),
        Growth::Speed(-1.0),
    ]
    .map(|growth| vec![Effect { growth, ..*effect }])
    .into()
}

fn answer(rig: &[Recorded], given: &Board, board: &Board, fit: &Fit, alike: &[Alike]) -> Answer {
    let parts = Parts::blocks(board, fit);
    let [none, early, _] = Parts::held_out(board, fit).judged(fit);
    // Where all findings together make held-out turns worse, none of them has a name.
    let worse = early > none;
    let total: f64 = fit
        .model
        .groups()
        .iter()
        .map(|group| fit.loss(*group))
        .sum::<f64>()
        .max(f64::MIN_POSITIVE);
    let mut findings: Vec<(Finding, Vec<Sized>, Option<f64>)> = Vec::new();
    let spread = (fit.rss / board.edges() as f64).max(1.0).sqrt();
    let inertia = |bench: &Bench| bench.twin.shaft.inertia_kg_m2 != 0.0;
    let known_inertia = board.benches.iter().all(inertia);
    for group in fit.model.groups() {
        let effects = fit.model.effects(group);
        let loss = fit.loss(group);
        let worth = search::evidence(board, loss, fit.model.numbers(group));
        let foretold = parts.foretold(fit, group);
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
        let sideband = name::sideband_of(board, &effects);
        if worse || sideband.is_some() || !once && foretold < FORETELLS * loss {
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
        let ratio = (1.0 - foretold / (fit.rss + loss)).max(0.0).sqrt();
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
                held_out_rms_ratio: (!once).then_some(ratio),
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
    let stamps = stamps::find(board, fit);
    // A latency is skewed, and has long tails of its own.
    let late = stamps
        .as_ref()
        .is_some_and(|found| found.mechanism == Mechanism::CaptureLatency);
    if !late && heavy_tails(fit) {
        let text =
            "innovations come in bursts or with heavy tails: noise that is not the same throughout";
        findings.push((
            Finding {
                text: text.to_owned(),
                ..unknown()
            },
            Vec::new(),
            None,
        ));
    } else if let Some(stamps) = stamps {
        findings.push((stamps, Vec::new(), None));
    }
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
    let fitted = agreement(given, board, fit);
    // Rounding to ticks hangs together where the course is quiet.
    let spurs = correlation(board, &board.rounded(&fit.model)).0;
    let left = correlation(board, &rests(board, fit)).0;
    let left_over =
        fitted.whiteness_p.is_some_and(|p| p < NOT_WHITE) && !noisy && left > ROUNDED * spurs;
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
    Answer {
        diagnosis: Diagnosis {
            version: 2,
            verdict,
            summary,
            recordings: rig
                .iter()
                .zip(&board.benches)
                .map(|(one, bench)| facts(one, bench, board))
                .collect(),
            fit: fitted,
            findings: said,
            next_recording: next,
        },
        map: Map::default(),
        declared,
        cells,
        shares,
        pattern: learned(board, &board.rest(&fit.model)),
        not_identifiable: Vec::new(),
        corrected: board.corrected(&fit.model),
        curves: curves(rig, given, board, fit),
    }
}

/// Whether innovations are far out more often than normal noise lets them be, and not at one place alone.
fn heavy_tails(fit: &Fit) -> bool {
    // Deviations that are far, the share of normal noise beyond them, and how many times as many are too many.
    const FAR: f64 = 3.5;
    const SHARE: f64 = 4.65e-4;
    const TIMES: f64 = 4.0;
    const LEAST: f64 = 12.0;
    const BLOCKS: usize = 20;
    let count = fit.left.len();
    let mut far = [0.0; BLOCKS];
    for (at, white) in fit.left.iter().enumerate() {
        if white.abs() > FAR {
            far[at * BLOCKS / count] += 1.0;
        }
    }
    let all: f64 = far.iter().sum();
    let most = far.iter().copied().fold(0.0, f64::max);
    all > TIMES * SHARE * count as f64 + LEAST && most < 0.5 * all
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

/// The verdict in words; `corrects` says which findings are other values of what the twin declares.
fn summary(verdict: Verdict, findings: &[Finding], corrects: &[bool]) -> String {
    let list = |start: &str, corrected: bool| {
        let each = findings.iter().zip(corrects);
        let names: Vec<&str> = each
            .filter(|(_, corrects)| **corrects == corrected)
            .map(|(finding, _)| match (corrected, finding.mechanism) {
                (true, Mechanism::Unknown) => finding.text.as_str(),
                _ => finding.mechanism.title(),
            })
            .collect();
        (!names.is_empty()).then(|| format!("{start}: {}.", names.join("; ")))
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

/// Errors of the edges of a disc that the twins do not give, rad, from what a model leaves.
fn learned(board: &Board, rests: &[Vec<f64>]) -> Option<Vec<f64>> {
    let pattern = board.pattern.as_ref()?;
    let each = board.benches.iter().zip(rests);
    let white: Vec<Vec<f64>> = each.map(|(bench, rest)| bench.white(rest)).collect();
    Some(pattern.errors(&board.benches, &white.concat()))
}

/// Residual angles as given and with the model, rad.
fn rests(board: &Board, fit: &Fit) -> Vec<Vec<f64>> {
    let mut rests = board.rest(&fit.model);
    if let Some(errors) = learned(board, &rests) {
        for (bench, rest) in board.benches.iter().zip(&mut rests) {
            rest.iter_mut()
                .enumerate()
                .for_each(|(at, rest)| *rest -= errors[bench.record.slot(at)]);
        }
    }
    for (bench, rest) in board.benches.iter().zip(&mut rests) {
        bench.less_start(rest);
    }
    rests
}

/// How well twins and recordings agree before and after.
fn agreement(given: &Board, board: &Board, fit: &Fit) -> Agreement {
    let before = as_given(given, board);
    let plain = before.fit(&fit.model.nuisances());
    let edges = board.edges() as f64;
    // White innovations count in deviations of the noise; a deviation is so many rad.
    let scales = board.benches.iter().flat_map(|bench| &bench.scales);
    let deviation = rms(scales.copied().filter(|scale| *scale > 0.0)).map(f64::recip);
    let scale = deviation.unwrap_or(0.0);
    let to_rad = |square: f64, count: f64| Some(scale * (square / count.max(1.0)).sqrt());
    let [none, early, late] = Parts::held_out(board, fit).judged(fit);
    let found = !fit.model.groups().is_empty();
    let held = judge::HELD_OUT * edges;
    let reducible = (found && none > late).then(|| {
        // As a root of squares above what the best leaves.
        1.0 - ((early - late).max(0.0) / (none - late)).sqrt().min(1.0)
    });
    Agreement {
        rms_before_rad: to_rad(plain.rss, edges),
        rms_after_rad: to_rad(fit.rss.min(plain.rss), edges),
        floor_rad: deviation,
        whiteness_p_before: Some(whiteness(&before, &rests(&before, &plain))),
        whiteness_p: Some(whiteness(board, &rests(board, fit))),
        held_out: HeldOut {
            rms_before_rad: to_rad(none, held),
            rms_after_rad: to_rad(if found { early.min(none) } else { none }, held),
            floor_rad: to_rad(held, held),
            reducible_removed: reducible,
        },
    }
}

/// Twins as given, in the noise that was found: so that only the model differs.
fn as_given(given: &Board, board: &Board) -> Board {
    let mut before = given.clone();
    before.pattern = None;
    before.set_noise(board.noise);
    before
}

fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| {
        (sum + value * value, count + 1.0)
    });
    (count > 0.0).then(|| (sum / count).sqrt())
}

/// Probability that noise alone leaves innovations that hang together so (G. M. Ljung, G. E. P. Box, Biometrika 65, 1978).
fn whiteness(board: &Board, rests: &[Vec<f64>]) -> f64 {
    let (sum, lags) = correlation(board, rests);
    ChiSquared::new(lags).map_or(1.0, |chi| chi.sf(sum))
}

/// Sum of squares that the innovations before an edge foretell of its own, and over how many lags.
fn correlation(board: &Board, rests: &[Vec<f64>]) -> (f64, f64) {
    let (mut sum, mut lags) = (0.0, 0.0);
    for (bench, rest) in board.benches.iter().zip(rests) {
        let mut white = bench.white(rest);
        white
            .iter_mut()
            .for_each(|white| *white = white.clamp(-4.0, 4.0));
        let count = white.len() as f64;
        let square: f64 = white.iter().map(|white| white * white).sum();
        for lag in 1..=LAGS.min(white.len() / 4) {
            let product: f64 = white.iter().zip(&white[lag..]).map(|(a, b)| a * b).sum();
            sum += count * (count + 2.0) * (product / square).powi(2) / (count - lag as f64);
            lags += 1.0;
        }
    }
    (sum, lags)
}

fn facts(one: &Recorded, bench: &Bench, board: &Board) -> RecordingFacts {
    let r_min = 60.0 / std::f64::consts::TAU;
    let (least, most) = bench
        .course
        .speed
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(*v), b.max(*v))
        });
    RecordingFacts {
        file: one.file.clone(),
        twin: one.twin.name.clone(),
        edges: bench.record.len() as u64,
        turns: bench.record.turns(),
        seconds: bench.record.seconds(),
        speed_r_min: [least * r_min, most * r_min],
        anchored: bench.record.anchored,
        start_rad: one.start_rad(),
        stamp_rms_s: Some(board.noise.stamp_s),
        disturbed_s: one.edges.events.iter().map(|event| event.time_s).collect(),
    }
}

/// RMS of the innovations in windows along each recording, before and after.
fn curves(rig: &[Recorded], given: &Board, board: &Board, fit: &Fit) -> Vec<Curve> {
    let before = as_given(given, board);
    let plain = before.fit(&fit.model.nuisances());
    let (one, other) = (rests(&before, &plain), rests(board, fit));
    let pairs = rig.iter().zip(&board.benches).enumerate();
    pairs
        .map(|(at, (recorded, bench))| {
            let window = bench.record.len().div_ceil(POINTS).max(1);
            let along = |rest: &[f64]| -> Vec<f64> {
                let white = bench.white(rest);
                let scaled = white.iter().zip(&bench.scales);
                let rad: Vec<f64> = scaled
                    .map(|(white, scale)| if *scale > 0.0 { white / scale } else { 0.0 })
                    .collect();
                let windows = rad.chunks(window);
                windows
                    .filter_map(|some| rms(some.iter().copied()))
                    .collect()
            };
            Curve {
                file: recorded.file.clone(),
                time_s: bench
                    .record
                    .time_s
                    .iter()
                    .copied()
                    .step_by(window)
                    .collect(),
                before_rad: along(&one[at]),
                after_rad: along(&other[at]),
            }
        })
        .collect()
}
