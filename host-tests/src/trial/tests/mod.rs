//! The scorer on answers made by hand.

mod interval;

use quadcal_host::diagnose::diagnosis::{
    Diagnosis, Evidence, Finding, Fit, HeldOut, Parameter, Place, Verdict,
};
use quadcal_host::mechanism::Mechanism;
use serde_json::{Value, json};

use super::cell::{Agreement, Cell};
use super::figures::{Figure, figures};
use super::matrix::Matrix;
use super::score::{Answer, Named, Score};
use super::shown::Outcome;
use super::truth::{SizeClass, Truth};

/// A truth of one effect of size 10, unless the case is of another kind.
fn truth(kind: &str, mechanisms: Value) -> Truth {
    let text = json!({
        "version": 1, "kind": kind, "seed": 1, "verdict": "explained", "mechanisms": mechanisms,
        "indistinguishable": [], "disc_known": true, "mask_ratio": null, "recordings": 1, "speeds_rad_s": [1.0],
        "noise": {"known": true, "torque_psd_n2_m2_s": 0.0, "wander_fraction": 0.0, "jitter_s": 3e-7},
    });
    serde_json::from_value(text).unwrap()
}

fn missing(id: &str, parameters: Value) -> Value {
    json!({
        "id": id, "physics": id, "same_physics": [], "parameters": parameters, "times_ideal": 10.0,
        "ideal_size": 1.0, "d_prime": 50.0, "separation_d_prime": null, "recording": null,
    })
}

fn finding(mechanism: Mechanism, parameters: &[(&str, f64, [f64; 2])]) -> Finding {
    let parameters = parameters.iter().map(|&(name, value, ci95)| {
        let parameter = Parameter {
            value,
            unit: "1".to_owned(),
            ci95: Some(ci95),
        };
        (name.to_owned(), parameter)
    });
    Finding {
        mechanism,
        text: String::new(),
        confidence: 1.0,
        parameters: parameters.collect(),
        place: Place::default(),
        evidence: Evidence {
            delta_bic: 30.0,
            p_value: 1e-6,
            held_out_rms_ratio: None,
            lines_beside: None,
            runner_up: None,
        },
        look_alikes: Vec::new(),
        next_recording: None,
    }
}

/// An answer that has gone through the JSON of the command.
fn answer(verdict: Verdict, findings: Vec<Finding>) -> Answer {
    let diagnosis = Diagnosis {
        version: 2,
        verdict,
        summary: String::new(),
        recordings: Vec::new(),
        fit: Fit {
            rms_before_rad: Some(2.0),
            rms_after_rad: Some(1.0),
            floor_rad: Some(1.0),
            whiteness_p_before: Some(0.0),
            whiteness_p: Some(0.5),
            correlated_before: Some(0.42),
            correlated: Some(0.0),
            held_out: HeldOut {
                rms_before_rad: Some(2.0),
                rms_after_rad: Some(1.0),
                floor_rad: Some(1.0),
                reducible_removed: Some(0.95),
            },
        },
        findings,
        next_recording: None,
    };
    let text = serde_json::to_string(&diagnosis).unwrap();
    Answer {
        seconds: 1.0,
        said: Ok(serde_json::from_str(&text).unwrap()),
    }
}

fn named(ids: &[Mechanism]) -> Answer {
    let findings = ids.iter().map(|&id| finding(id, &[])).collect();
    answer(Verdict::Explained, findings)
}

#[test]
fn the_first_name_counts_and_others_of_the_same_physics_do_too() {
    let mut mesh = missing("gear_mesh", json!({}));
    mesh["same_physics"] = json!(["bearing"]);
    let truth = truth("one", json!([mesh]));
    let right = |ids: &[Mechanism]| Score::of("case", &truth, &named(ids)).right;
    assert!(right(&[Mechanism::GearMesh]) && right(&[Mechanism::Bearing]));
    assert!(right(&[Mechanism::Bearing, Mechanism::EdgeDelay]));
    assert!(!right(&[Mechanism::EdgeDelay, Mechanism::GearMesh]));
    assert!(!right(&[]) && !right(&[Mechanism::Unknown]));
}

#[test]
fn look_alikes_count_only_where_no_detector_tells_them_apart() {
    let mut tone = finding(Mechanism::GearMesh, &[]);
    tone.look_alikes = vec![Mechanism::TorqueTone];
    let answer = answer(Verdict::Ambiguous, vec![tone]);
    let right = |apart: Value| {
        let mut missing = missing("torque_tone", json!({}));
        missing["separation_d_prime"] = apart;
        Score::of("case", &truth("one", json!([missing])), &answer).right
    };
    assert!(right(json!(4.9)));
    assert!(!right(json!(5.0)) && !right(json!(null)));
}

#[test]
fn names_for_an_unknown_disc_are_passed_over() {
    let mut truth = truth("masked", json!([missing("gear_mesh", json!({}))]));
    let answer = named(&[
        Mechanism::LineError,
        Mechanism::Eccentricity,
        Mechanism::GearMesh,
    ]);
    assert!(!Score::of("case", &truth, &answer).right);
    truth.disc_known = false;
    let score = Score::of("case", &truth, &answer);
    assert!(score.right && score.extras.is_empty());
    assert_eq!(score.beside, 0);
    assert_eq!(score.first, Named::Mechanism(Mechanism::GearMesh));
    let twice = named(&[
        Mechanism::LineError,
        Mechanism::GearMesh,
        Mechanism::GearMesh,
    ]);
    assert_eq!(Score::of("case", &truth, &twice).beside, 1);
    let other = named(&[Mechanism::LineError, Mechanism::TorqueTone]);
    assert!(!Score::of("case", &truth, &other).right);
}

#[test]
fn several_need_all_and_nothing_else() {
    let both = json!([
        missing("eccentricity", json!({})),
        missing("lost_edges", json!({}))
    ]);
    let truth = truth("several", both);
    let score = |ids: &[Mechanism]| {
        let score = Score::of("case", &truth, &named(ids));
        (score.right, score.found, score.extras.len())
    };
    let (one, other) = (Mechanism::Eccentricity, Mechanism::LostEdges);
    assert_eq!(score(&[other, one]), (true, 2, 0));
    assert_eq!(score(&[one]), (false, 1, 0));
    assert_eq!(score(&[one, other, Mechanism::Unknown]), (false, 2, 1));
}

#[test]
fn nothing_missing_means_complete_and_no_finding() {
    let truth = truth("nothing", json!([]));
    let right = |answer: &Answer| Score::of("case", &truth, answer).right;
    assert!(right(&answer(Verdict::Complete, Vec::new())));
    assert!(!right(&answer(Verdict::Unknown, Vec::new())));
    assert!(!right(&named(&[Mechanism::Unknown])));
}

#[test]
fn physics_in_no_catalogue_must_get_no_known_name_first() {
    let truth = truth("outside", json!([missing("unknown", json!({}))]));
    let right = |ids: &[Mechanism]| Score::of("case", &truth, &named(ids)).right;
    assert!(right(&[]) && right(&[Mechanism::Unknown]));
    assert!(!right(&[Mechanism::GearMesh, Mechanism::Unknown]));
}

#[test]
fn look_alikes_must_all_be_said_and_called_ambiguous() {
    let mut truth = truth("look_alike", json!([missing("torque_tone", json!({}))]));
    truth.indistinguishable = vec![
        Mechanism::TorqueTone,
        Mechanism::GearMesh,
        Mechanism::Bearing,
    ];
    let right = |verdict, alike: &[Mechanism]| {
        let mut found = finding(Mechanism::GearMesh, &[]);
        found.look_alikes = alike.to_vec();
        Score::of("case", &truth, &answer(verdict, vec![found])).right
    };
    let others = [Mechanism::TorqueTone, Mechanism::Bearing];
    assert!(right(Verdict::Ambiguous, &others));
    assert!(!right(Verdict::Explained, &others));
    assert!(!right(Verdict::Ambiguous, &others[..1]));
}

#[test]
fn a_failed_run_is_wrong_and_its_message_is_shown() {
    let truth = truth("nothing", json!([]));
    let failed = Answer {
        seconds: 0.1,
        said: Err("exit code: 2: no such key".to_owned()),
    };
    let score = Score::of("case-0003", &truth, &failed);
    assert_eq!((score.right, score.first), (false, Named::Failed));
    let outcome = Outcome::new("trial".to_owned(), "1".to_owned(), vec![score]);
    assert!(outcome.misses().contains("no such key"));
    assert!(outcome.markdown().contains("no such key"));
    assert!(!outcome.met());
}

#[test]
fn figures_and_matrix_count_cases_by_size() {
    let mut small = missing("eccentricity", json!({"amplitude_rad": 1.0}));
    small["times_ideal"] = json!(5.0);
    let small = truth("one", json!([small]));
    let large = truth(
        "loop",
        json!([missing("eccentricity", json!({"amplitude_rad": 1.0}))]),
    );
    let found = [("amplitude_rad", 1.0, [0.9, 1.1])];
    let right = answer(
        Verdict::Explained,
        vec![finding(Mechanism::Eccentricity, &found)],
    );
    let scores = [
        Score::of("case-0000", &small, &right),
        Score::of("case-0001", &small, &named(&[Mechanism::TorqueRipple])),
        Score::of("case-0002", &large, &right),
    ];
    let figures = figures(&scores);
    let figure = |start: &str| -> &Figure {
        let found = figures.iter().find(|figure| figure.name.starts_with(start));
        found.unwrap_or_else(|| panic!("no figure {start}"))
    };
    let five = figure("right mechanism first, 5 times");
    assert_eq!((five.of, five.met()), ((Some(1), 2), Some(false)));
    let ten = figure("right mechanism first, 10 times");
    assert_eq!((ten.of, ten.met()), ((Some(1), 1), Some(true)));
    assert_eq!(figure("95 % intervals").of, (Some(2), 2));
    assert_eq!(figure("reducible RMS").value, Some(0.95));
    assert_eq!(figure("false finding").met(), None, "no such case");
    let matrices = Matrix::all(&scores);
    let sizes: Vec<SizeClass> = matrices.iter().map(|matrix| matrix.size).collect();
    assert_eq!(sizes, [SizeClass(5), SizeClass(10)]);
    let wrong = (
        Mechanism::Eccentricity,
        Named::Mechanism(Mechanism::TorqueRipple),
    );
    assert_eq!(matrices[0].counts[&wrong], 1);
}

#[test]
fn sizes_fall_into_the_class_that_is_nearest_by_ratio() {
    let classes = [3.0, 3.8, 4.0, 7.0, 7.2, 17.0, 18.0, 400.0].map(|times| SizeClass::of(times).0);
    assert_eq!(classes, [3, 3, 5, 5, 10, 10, 30, 30]);
}

#[test]
fn where_counts_site_and_carrier_whatever_the_name() {
    let mesh = Cell::of(Mechanism::GearMesh, false).unwrap();
    let round = Cell::of(Mechanism::Eccentricity, false).unwrap();
    assert_eq!(Cell::of(Mechanism::TorqueRipple, false), Some(mesh));
    assert_eq!(Cell::of(Mechanism::Bearing, true), Some(round));
    let seen = Agreement::of(&[mesh, mesh, round], &[mesh]);
    assert_eq!((seen.right, seen.named, seen.there), (1, 3, 1));
    let truth = truth("one", json!([missing("gear_mesh", json!({}))]));
    let score = Score::of("case", &truth, &named(&[Mechanism::TorqueRipple]));
    let figures = figures(&[score]);
    let f1 = figures.iter().find(|f| f.name.starts_with("F1")).unwrap();
    assert_eq!(f1.value, Some(1.0));
}

#[test]
fn a_sure_false_name_is_a_false_discovery_and_a_growing_residual_is_a_miss() {
    let truth = truth("one", json!([missing("gear_mesh", json!({}))]));
    let mut answer = named(&[Mechanism::GearMesh, Mechanism::EdgeDelay]);
    let said = answer.said.as_mut().unwrap();
    said.findings[1].confidence = 0.97;
    said.fit.held_out.rms_after_rad = Some(2.1);
    let figures = figures(&[Score::of("case", &truth, &answer)]);
    let of = |start: &str| figures.iter().find(|f| f.name.starts_with(start)).unwrap();
    assert_eq!(of("false discovery rate, confidence 95").of, (Some(1), 2));
    assert_eq!(of("false discovery rate, confidence 99").of, (Some(0), 1));
    assert_eq!(of("held-out residual").met(), Some(false));
}

#[test]
fn a_thin_twin_allows_what_the_rig_has_and_nothing_else() {
    let mut thin = truth("nothing", json!([]));
    thin.family = Some(super::truth::Family::Thin);
    thin.disc_known = false;
    thin.undeclared = vec![Mechanism::TorqueRipple];
    let false_names = |ids: &[Mechanism]| {
        let figures = figures(&[Score::of("case", &thin, &named(ids))]);
        assert!(
            !figures
                .iter()
                .any(|f| f.name.starts_with("right mechanism"))
        );
        let figure = figures.iter().find(|f| f.name.starts_with("thin twin"));
        figure.unwrap().of.0
    };
    let there = [Mechanism::LineError, Mechanism::TorqueRipple];
    assert_eq!(false_names(&there), Some(0));
    assert_eq!(false_names(&[Mechanism::EdgeDelay]), Some(1));
    assert_eq!(false_names(&[Mechanism::Unknown]), Some(1));
}

#[test]
fn an_effect_in_no_catalogue_may_be_called_by_its_own_place() {
    let mut effect = missing("unknown", json!({}));
    effect["near"] = json!(["torque_ripple"]);
    let mut free = truth("outside", json!([effect]));
    free.family = Some(super::truth::Family::CatalogueFree);
    let score = |id| Score::of("case", &free, &named(&[id]));
    assert!(!score(Mechanism::TorqueRipple).said[0].is_false);
    assert!(!score(Mechanism::Unknown).said[0].is_false);
    assert!(score(Mechanism::EdgeDelay).said[0].is_false);
    assert_eq!(score(Mechanism::Unknown).removed, Some(0.95));
}
