//! Whether recordings of two discs are told from two recordings of one, at equal and near speeds, disturbed or not, on seeds that
//! nothing was tuned to.
#![allow(clippy::cast_precision_loss, missing_docs)]

use quadcal_host::calibrate::{CalibrateError, CalibrateOptions, Learner, plan};
use quadcal_host::recording::{Header, Row};
use quadcal_host::survey::Survey;
use quadcal_host::twin::{Drive, EdgeDelay, Per, Position, RiseFall, Twin};
use quadcal_host_tests::anywhere::{Disturbance, Disturbed, Rig, Run, Scenario};

/// What came of learning from two recordings together.
#[derive(Debug, PartialEq, Eq)]
enum Verdict {
    Taken,
    Refused,
    TooFewTurns,
}

fn together(recordings: &[(Header, Vec<Row>)]) -> Verdict {
    let options = CalibrateOptions::default();
    let mut learner: Option<Learner> = None;
    for (header, rows) in recordings {
        let open = || rows.iter().copied().map(Ok);
        let survey = Survey::of(header.clone(), open()).unwrap();
        let plan = plan(&survey, &options).unwrap();
        let learner = learner.get_or_insert_with(|| {
            let new = Learner::new(plan, header.clock_hz, options.drive).unwrap();
            new.comparing_discs()
        });
        match learner.add(survey, open(), &options) {
            Ok(()) => {}
            Err(CalibrateError::OtherDisc { other: 0, .. }) => return Verdict::Refused,
            Err(CalibrateError::TooFewTurns(_)) => return Verdict::TooFewTurns,
            Err(error) => panic!("{error}"),
        }
    }
    Verdict::Taken
}

fn recordings(twins: &[Twin]) -> Vec<(Header, Vec<Row>)> {
    Run::of(twins).unwrap().into_recordings()
}

/// The same run of `pair`'s second twin with another disc on the shaft.
fn other_disc(pair: &[Twin]) -> Vec<Twin> {
    let mut pair = pair.to_vec();
    let seed = pair[1].errors.seed.unwrap();
    pair[1].errors.seed = Some(seed + 1_000_000);
    pair
}

fn at(mut twin: Twin, r_min: f64, part: u64) -> Twin {
    twin.drive = Drive::Constant { r_min };
    twin.seed += 1_000 * part;
    twin
}

/// Pairs of recordings by name: as the rigs of `--bin anywhere` are driven, and at one speed or near ones.
fn pairs(lines: u32, seed: u64) -> Vec<(String, Vec<Twin>)> {
    let rig = |scenario| Rig { scenario, lines };
    let mut pairs = vec![("two speeds".into(), rig(Scenario::TwoSpeeds).twins(seed))];
    for by in Disturbance::ALL {
        let twins = Disturbed { by, lines }.twins(seed);
        // One speed twice, each with noise of its own; and the slow one faster by a twentieth.
        let [first, last] = [&twins[0], &twins[twins.len() - 1]].map(Clone::clone);
        let mut again = first.clone();
        again.seed += 1_000;
        pairs.push((format!("{}, twice", by.name()), vec![first.clone(), again]));
        if by != Disturbance::Ramp {
            pairs.push((
                format!("{}, near", by.name()),
                vec![first.clone(), at(first.clone(), 15.8, 2)],
            ));
            pairs.push((
                format!("{}, near, fast", by.name()),
                vec![last.clone(), at(last.clone(), 640.0, 3)],
            ));
            pairs.push((by.name().into(), twins));
        }
    }
    pairs
}

fn check(lines: u32, seeds: std::ops::Range<u64>, change: impl Fn(&mut Twin)) -> [usize; 2] {
    let (mut cases, mut refused) = (0, 0);
    for seed in seeds {
        for (name, mut pair) in pairs(lines, seed) {
            pair.iter_mut().for_each(&change);
            let verdict = together(&recordings(&pair));
            assert_eq!(verdict, Verdict::Taken, "{lines} lines, {seed}: {name}");
            cases += 1;
            refused += usize::from(together(&recordings(&other_disc(&pair))) == Verdict::Refused);
        }
    }
    [cases, refused]
}

#[test]
fn one_disc_is_taken_and_another_refused_however_the_shaft_runs() {
    for (lines, seeds) in [(60, 9_300..9_303), (360, 9_303..9_304)] {
        let [cases, refused] = check(lines, seeds, |_| ());
        assert_eq!(refused, cases, "{lines} lines");
    }
}

/// Where the pattern is weak against the noise there is nothing to go by, and nothing is refused for it.
#[test]
fn one_disc_is_taken_however_weak_its_pattern() {
    for share in [0.0, 0.01, 0.03] {
        check(60, 9_304..9_305, |twin| {
            twin.errors.position = Some(Position::Uniform {
                amplitude_rad: 6.2832e-5 * 2500.0 / 60.0 * share,
                per: Per::Edge,
            });
        });
    }
}

/// Delays are in the classes' means, which are not compared.
#[test]
fn delays_that_grow_with_speed_make_no_other_disc() {
    let pair = Rig {
        scenario: Scenario::TwoSpeeds,
        lines: 60,
    }
    .twins(9_305);
    let late = |mut twin: Twin| {
        twin.edge_delay = Some(EdgeDelay {
            a: RiseFall {
                rise_s: 4e-5,
                fall_s: 0.0,
            },
            ..EdgeDelay::default()
        });
        twin
    };
    let pair: Vec<Twin> = pair.into_iter().map(late).collect();
    assert_eq!(together(&recordings(&pair)), Verdict::Taken);
    assert_eq!(together(&recordings(&other_disc(&pair))), Verdict::Refused);
}
