//! Whole diagnoses of simulated recordings, and the filter held against its own transposed.

use super::bench::Bench;
use super::diagnosis::Answer;
use super::edges::{Edges, Sensor, place};
use super::effect::{Carrier, Effect, Growth, Site};
use super::filter::{Filter, Noise, State, Whitens};
use super::model::{Board, Model};
use super::pattern::Pattern;
use super::pipeline::diagnose;
use super::plant::{Law, Plant};
use super::record::Record;
use super::rig::Recorded;
use super::{cells, course::Course, declared, judge, lsq::dot};
use crate::diagnose::diagnosis::Verdict;
use crate::mechanism::Mechanism;
use crate::recording::Row;
use crate::sim::Simulation;
use crate::twin::{Encoder, Twin};
use quadcal::edge::Levels;

const PAIR_FAST: &str = include_str!("../../twins/pair-fast.toml");
const WHEEL: &str = include_str!("../../twins/wheel-60-2.toml");
const LOAD: &str = include_str!("../../twins/load-step.toml");

fn twin(text: &str) -> Twin {
    Twin::parse(text, "a.toml").unwrap()
}

fn edges(twin: &Twin) -> Edges {
    let sensor = match &twin.encoder {
        &Encoder::Quadrature { lines, index } => Sensor::Quadrature {
            lines,
            index: index.then_some(Levels(Levels::A)),
        },
        &Encoder::Hall { pole_pairs } => Sensor::Hall { pole_pairs },
        wheel @ Encoder::Wheel { teeth, .. } => Sensor::Wheel {
            present: (0..*teeth).map(|tooth| wheel.is_real(2 * tooth)).collect(),
            both_edges: true,
        },
    };
    let rows: Vec<Row> = Simulation::new(twin)
        .unwrap()
        .map(|event| event.row)
        .collect();
    place(&sensor, twin.timer.clock_hz, &rows).unwrap()
}

/// A recording of one twin beside another.
fn against(real: &str, given: &str) -> Answer {
    let one = Recorded {
        file: "a.csv".to_owned(),
        edges: edges(&twin(real)),
        twin: twin(given),
    };
    diagnose(&[one], &mut |_, _| {}).unwrap()
}

/// The recording of a twin beside itself.
fn board(text: &str) -> Board {
    let twin = twin(text);
    let record = Record::of(&edges(&twin), &twin);
    let errors = crate::sim::true_errors(&twin).unwrap();
    let noise = Noise {
        torque: 1.0,
        stamp_s: record.tick_s,
        ..Noise::default()
    };
    Board::new(vec![Bench::new(record, &twin, &errors, &noise)])
}

/// Findings in words.
fn said(answer: &Answer) -> Vec<&str> {
    let findings = answer.diagnosis.findings.iter();
    findings.map(|one| &*one.text).collect()
}

#[test]
fn a_twin_explains_its_own_recording() {
    for text in [PAIR_FAST, WHEEL, LOAD] {
        let answer = against(text, text);
        assert_eq!(
            answer.diagnosis.verdict,
            Verdict::Complete,
            "{:?}",
            answer.diagnosis.findings
        );
        assert!(answer.diagnosis.fit.whiteness_p.unwrap() > 1e-3);
    }
}

#[test]
fn a_load_that_the_twin_lacks_is_named_with_its_size_and_instants() {
    let begins = LOAD.find("[[load_step]]").unwrap();
    let rest = &LOAD[begins..];
    let ends = rest[1..]
        .find("\n[")
        .map_or(LOAD.len(), |at| begins + 1 + at);
    let given = format!("{}{}", &LOAD[..begins], &LOAD[ends..]);
    let truth = twin(LOAD).load_step[0];
    let answer = against(LOAD, &given);
    let first = &answer.diagnosis.findings[0];
    assert_eq!(first.mechanism, Mechanism::LoadStep);
    let [low, high] = first.parameters["torque_n_m"].ci95.unwrap();
    let wide = high - low;
    assert!(
        (low - wide..high + wide).contains(&truth.torque_n_m),
        "{low} {high} {}",
        truth.torque_n_m
    );
    assert!((first.parameters["from_s"].value - truth.from_s).abs() < 0.01);
}

#[test]
fn a_drive_that_gives_way_is_no_friction_of_a_thin_twin() {
    let thin = "[encoder.quadrature]\nlines = 500\nindex = true\n\n[shaft]\ninertia_kg_m2 = 1e-4\n\n[timer]\nclock_hz = 84_000_000\n";
    let answer = against(LOAD, thin);
    // Eccentricity and friction once were one finding, as a group that turned out to be open was used again.
    assert_eq!(said(&answer), Vec::<&str>::new());
}

#[test]
fn how_stiffly_an_unknown_drive_holds_the_shaft_is_no_torque_beside_a_declared_ripple() {
    // Slow waves of the ripple are damped by friction and drive together: once "a torque that falls with the speed", over 99.9 %.
    let sensor = "[encoder.wheel]\nteeth = 80\n\n[timer]\nclock_hz = 84_000_000\njitter_s = 30e-9\n\n[noise.white]\npsd_n2_m2_s = 1.3e-9\n\n[[ripple]]\norder = 6\ntorque_n_m = 3.5e-3\nphase_rad = 1.0\n\n[shaft]\ninertia_kg_m2 = 5e-3\nviscous_n_m_s = 7e-3\n";
    let drive = "stiffness_n_m_s = 9e-3\n\n[duration]\nturns = 25\n\n[drive.profile]\npoints = [{ t_s = 0, r_min = 66 }, { t_s = 12, r_min = 66 }, { t_s = 16, r_min = 10 }, { t_s = 90, r_min = 10 }]\n";
    let answer = against(&format!("{sensor}{drive}"), sensor);
    assert_eq!(said(&answer), Vec::<&str>::new());
}

#[test]
fn a_tone_at_one_speed_is_named_with_its_look_alike_and_the_residual_falls() {
    let tone = "\n[[torque_tone]]\nf_hz = 37.3\ntorque_n_m = 3e-4\nphase_rad = 0.4\n";
    let answer = against(&format!("{PAIR_FAST}{tone}"), PAIR_FAST);
    let first = &answer.diagnosis.findings[0];
    // At one speed an order is a frequency: 37.3 Hz are order 3.73 of 10 turns a second.
    let mut both = first.look_alikes.clone();
    both.push(first.mechanism);
    assert!(
        both.contains(&Mechanism::TorqueTone) && both.contains(&Mechanism::GearMesh),
        "{both:?}"
    );
    assert_eq!(answer.diagnosis.verdict, Verdict::Ambiguous);
    // Said as a run-out or as a torque; at one speed they are the same.
    if let Some(torque) = first.parameters.get("torque_n_m") {
        assert!((torque.value / 3e-4 - 1.0).abs() < 0.05, "{torque:?}");
    }
    let held = &answer.diagnosis.fit.held_out;
    assert!(held.rms_after_rad < held.rms_before_rad);
    assert!(held.reducible_removed.unwrap() > 0.9);
}

#[test]
fn the_transposed_filter_is_the_filters_adjoint() {
    let twin = twin(PAIR_FAST);
    let record = Record::of(&edges(&twin), &twin);
    let course = Course::new(&record, &vec![0.0; record.len()]);
    let plant = Plant::new(Law::of(&twin), &course);
    let leaps = plant.leaps::<{ State::Held.and_before() }>(&course);
    let noise = Noise {
        torque: 1e-4,
        stamp_s: 1e-8,
        drift: 0.0,
        fade: 0.0,
        angle_rad: 0.0,
    };
    let filter = Filter::new(&leaps, &noise);
    let wave =
        |by: f64| -> Vec<f64> { (0..record.len()).map(|at| (by * at as f64).sin()).collect() };
    let (one, other) = (wave(0.37), wave(0.011));
    let mut there = one.clone();
    filter.whiten(&mut there);
    let mut back = other.clone();
    filter.transposed(&mut back);
    let (a, b) = (dot(&there, &other), dot(&one, &back));
    assert!((a - b).abs() < 1e-9 * a.abs().max(b.abs()), "{a} {b}");
}

#[test]
fn rows_side_by_side_are_filtered_as_each_alone() {
    let board = board(PAIR_FAST);
    let gains = &board.benches[0].gains;
    let row = |by: f64| -> Vec<f64> {
        let each = 0..board.edges();
        each.map(|at| (by * (at * at) as f64).sin()).collect()
    };
    let rows: Vec<Vec<f64>> = [0.3, 0.7, 1.1, 1.9, 2.3].map(row).to_vec();
    let (mut white, mut back) = (rows.clone(), rows.clone());
    gains.whiten_rows(&mut white);
    gains.transposed_rows(&mut back);
    for (at, row) in rows.iter().enumerate() {
        let (mut one, mut other) = (row.clone(), row.clone());
        gains.whiten(&mut one);
        gains.transposed(&mut other);
        assert_eq!((&white[at], &back[at]), (&one, &other), "{at}");
    }
}

#[test]
fn errors_of_a_disc_with_few_edges_solve_its_normal_equations() {
    let board = board(WHEEL);
    let mut pattern = Pattern::known(&board.benches, 1e-8).unwrap();
    let white = board.target();
    let off = |pattern: &Pattern| {
        let errors = pattern.errors(&board.benches, &white);
        let fold = pattern.fold(&board.benches, &white);
        let shown = pattern.fold(&board.benches, &pattern.unfold(&board.benches, &errors));
        let each = fold.iter().zip(&shown).zip(&errors);
        let rest = each.map(|((fold, shown), error)| fold - shown - error / 1e-8);
        rest.map(|rest| rest * rest).sum::<f64>() / dot(&fold, &fold)
    };
    assert!(off(&pattern) < 1e-16, "{}", off(&pattern));
    pattern.weigh(&board.benches);
    assert!(off(&pattern) < 1e-16, "{}", off(&pattern));
}

#[test]
fn no_kind_of_friction_drives_the_shaft_beside_another_one() {
    let board = board(PAIR_FAST);
    let friction = |carrier| Effect::new(Site::Torque, carrier);
    let mut model = Model::default();
    model.add(
        &[
            friction(Carrier::Power(0.0)),
            friction(Carrier::Stribeck(60.0)),
        ],
        0,
    );
    let mut sized = |coulomb: f64, stribeck: f64| {
        model.terms[0].sizes = vec![coulomb];
        model.terms[1].sizes = vec![stribeck];
        board.can_be(&model)
    };
    assert!(sized(1e-2, 1e-2));
    assert!(sized(1e-2, 0.0));
    assert!(!sized(1e-2, -1e-2));
    assert!(!sized(-1e-2, 3e-2));
}

#[test]
fn an_order_beside_a_whole_one_of_changing_size_is_its_sideband_and_a_gear_is_not() {
    let order = |order, growth| Effect {
        growth,
        ..Effect::new(Site::Torque, Carrier::Order(order))
    };
    // The order that is fitted to what a torque makes, and whose sideband it is.
    let fitted = |cos: Effect, sin: Effect, start: f64| {
        let mut board = board(PAIR_FAST);
        let (cos, sin) = (
            board.benches[0].columns(&cos),
            board.benches[0].columns(&sin),
        );
        let each = cos[0].iter().zip(&sin[1]);
        board.benches[0].residual = each.map(|(cos, sin)| 6e-4 * (cos + sin)).collect();
        let mut model = Model::default();
        model.add(&[order(start, Growth::Constant)], 0);
        let fit = board.fit(&model);
        let Carrier::Order(order) = fit.model.terms[0].effect.carrier else {
            unreachable!()
        };
        (order, judge::sideband_of(&board, &fit, 0))
    };
    // It turns its phase along the recording.
    let part = |phase| order(4.0, Growth::Modulated(0.4, 1.0, phase));
    let (beside, whole) = fitted(part(1.6), part(-1.6), 4.0 + 1e-3);
    assert!((beside - 4.0).abs() > 0.01, "{beside}");
    assert_eq!(whole, Some(4.0));
    // A gear is none, though it slips by little more than a turn against the whole order.
    for truth in [4.3, 4.09] {
        let gear = order(truth, Growth::Constant);
        let (gear, whole) = fitted(gear, gear, truth);
        assert!((gear - truth).abs() < 1e-6, "{gear}");
        assert_eq!(whole, None);
    }
}

#[test]
fn a_torque_swings_the_shaft_as_its_transfer_function_says() {
    let mut twin = twin(PAIR_FAST);
    twin.errors = Default::default();
    let record = Record::of(&edges(&twin), &twin);
    let course = Course::new(&record, &vec![0.0; record.len()]);
    let plant = Plant::new(Law::of(&twin), &course);
    let w: f64 = 2.0 * std::f64::consts::PI * 30.0;
    let angles = plant.response_over(
        0..course.len(),
        &course,
        |here| (w * here.time_s).sin(),
        |_| w,
        &[],
    );
    let b = plant.damping[1];
    let expected = 1.0 / (w * w.hypot(b));
    // Over whole periods late in the recording, beside a straight way.
    let half = record.len() / 2;
    let time: Vec<f64> = record.time_s[half..].to_vec();
    let sin: Vec<f64> = time.iter().map(|t| (w * t).sin()).collect();
    let cos: Vec<f64> = time.iter().map(|t| (w * t).cos()).collect();
    let one = vec![1.0; time.len()];
    let solved = super::lsq::solve(&[&one, &time, &sin, &cos], &angles[half..]);
    let swing = solved.sizes[2].hypot(solved.sizes[3]);
    assert!((swing / expected - 1.0).abs() < 1e-3, "{swing} {expected}");
}

#[test]
fn effects_of_a_twin_are_as_many_as_its_sections_say() {
    let twin = twin(include_str!("../../twins/mechanisms.toml"));
    // One gear, two bearings, a tone, a load, a level's ripple and drift, two plays, a drift of the speed.
    assert_eq!(declared::effects(&twin).len(), 10);
}

#[test]
fn late_captures_of_a_noisy_shaft_are_told_from_jitter() {
    // Where the torque noise is the larger part, an innovation has the errors of the edges before with the other sign.
    let given = "seed = 5\nduration = { turns = 300 }\n\n[encoder.hall]\npole_pairs = 3\n\n[errors]\nwidth_a_rad = 1e-6\n\n[drive.constant]\n\
        r_min = 70\n\n[shaft]\ninertia_kg_m2 = 1.1e-5\nviscous_n_m_s = 6e-7\nstiffness_n_m_s = 2.7e-6\n\n[noise.white]\n\
        psd_n2_m2_s = 2.5e-14\n\n[timer]\nclock_hz = 168_000_000\njitter_s = 1.1e-7\n";
    let late = format!("{given}\n[capture_latency]\nmean_s = 5e-6\n");
    let jitter = given.replace("1.1e-7", "5e-6");
    for (real, named) in [
        (late, Mechanism::CaptureLatency),
        (jitter, Mechanism::TimestampJitter),
    ] {
        let answer = against(&real, given);
        let findings = &answer.diagnosis.findings;
        assert_eq!(findings.len(), 1, "{:?}", said(&answer));
        assert_eq!(findings[0].mechanism, named);
    }
}

#[test]
fn friction_is_tried_where_the_speed_changes_alone() {
    let rig = |drive: &str| {
        format!(
            "seed = 3\nduration = {{ turns = 20 }}\n\n[encoder.quadrature]\nlines = 60\n\n[errors]\nwidth_a_rad = 1e-6\n\n{drive}\n[shaft]\n\
             inertia_kg_m2 = 3e-3\nviscous_n_m_s = 6.2e-3\nstiffness_n_m_s = 1.1e-2\n\n[noise.white]\npsd_n2_m2_s = 3e-9\n\n[timer]\n\
             clock_hz = 168_000_000\njitter_s = 8e-8\n"
        )
    };
    let tried = |drive: &str| {
        let groups = cells::steady(&board(&rig(drive)));
        groups.iter().flatten().any(Effect::is_friction)
    };
    // Noise that is not white damps in its own way there.
    assert!(!tried("[drive.constant]\nr_min = 150\n"));
    assert!(tried(
        "[drive.ramp]\nfrom_r_min = 100\nto_r_min = 200\nover_s = 6\n"
    ));
}

#[test]
fn an_edge_that_the_shaft_rocks_about_has_no_speed() {
    let thin = twin(
        "[encoder.quadrature]\nlines = 100\n\n[shaft]\ninertia_kg_m2 = 1e-4\n\n[timer]\nclock_hz = 1_000_000\n",
    );
    let mut edges = edges(&twin(
        "seed = 1\nduration = { turns = 4 }\n\n[encoder.quadrature]\nlines = 100\n\n[errors]\nwidth_a_rad = 1e-6\n\n[drive.constant]\n\
         r_min = 60\n\n[timer]\nclock_hz = 1_000_000\n",
    ));
    let count = edges.place.len();
    for at in count - 6..count {
        edges.place[at] = edges.place[count - 7];
        edges.forward[at] = at % 2 == 0;
        edges.time_s[at] = edges.time_s[at - 1] + 0.5;
    }
    let record = Record::of(&edges, &thin);
    // Something that pushes all the while it stands.
    let pushed = vec![[0.0, 30.0]; record.len()];
    let course = Course::bent(&record, &vec![0.0; record.len()], &pushed);
    let last = &course.speed[record.len() - 5..];
    assert!(last.iter().all(|speed| *speed == 0.0), "{last:?}");
}

/// A rig with more edges than a search begins with.
const MANY: &str = "duration = { turns = 8 }\n[encoder.quadrature]\nlines = 1000\nindex = true\n\
    [errors]\nwidth_a_rad = 1e-4\n[shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-3\n\
    [drive.constant]\nr_min = 300\n[noise.white]\npsd_n2_m2_s = 1e-10\n\
    [timer]\nclock_hz = 84_000_000\njitter_s = 20e-9\n";

#[test]
fn of_many_edges_the_few_that_are_off_are_found() {
    let defect = "[[local_defect]]\nangle_rad = 1.2346\nwidth_rad = 1.6e-3\nerror_rad = 1.5e-5\n";
    let answer = against(&format!("{MANY}{defect}"), MANY);
    let finding = &answer.diagnosis.findings[0];
    assert_eq!(finding.mechanism, Mechanism::LocalDefect);
    let [least, most] = finding.parameters["angle_rad"].ci95.unwrap();
    assert!(least < 1.2346 && 1.2346 < most, "{least} {most}");
    assert_eq!(answer.diagnosis.findings.len(), 1);
}

#[test]
fn of_many_edges_all_bear_on_a_size() {
    let real = MANY.replace("width_a_rad = 1e-4", "width_a_rad = 1.02e-4");
    let answer = against(&real, MANY);
    let [finding] = &answer.diagnosis.findings[..] else {
        panic!("{:?}", said(&answer));
    };
    assert_eq!(finding.mechanism, Mechanism::WidthError);
    let [least, most] = finding.parameters["width_a_rad"].ci95.unwrap();
    assert!(least < 1.02e-4 && 1.02e-4 < most, "{least} {most}");
    // A third of the edges leaves 1.6 times as much, 52 nrad.
    assert!(most - least < 36e-9, "{least} {most}");
}

/// A motor with Hall sensors whose disc is off its centre, running up.
const HALL: &str = "seed = 4\nduration = { turns = 60 }\n[encoder.hall]\npole_pairs = 5\n\
    [errors]\nposition = { normal = { rms_rad = 3e-3 } }\neccentricity = { amplitude_rad = 0.02, phase_rad = 1.0 }\n\
    [shaft]\ninertia_kg_m2 = 4.6e-3\nviscous_n_m_s = 2e-4\n[drive.ramp]\nfrom_r_min = 100\nto_r_min = 230\nover_s = 20\n\
    [noise.white]\npsd_n2_m2_s = 6e-10\n[timer]\nclock_hz = 72_000_000\njitter_s = 4e-8\n";

#[test]
fn a_torque_past_half_of_the_edges_is_told_from_the_lower_one_where_edges_come_unevenly() {
    // 30 edges a turn, all but evenly: an order of 18 looks like one of 12 with sidebands.
    let ripples = "[[ripple]]\norder = 12\nphase_rad = 4.0\ntorque_n_m = 0.048\n\
        [[ripple]]\norder = 18\nphase_rad = 3.6\ntorque_n_m = 0.043\n";
    let thin = "duration = { turns = 60 }\n[encoder.hall]\npole_pairs = 5\n[shaft]\ninertia_kg_m2 = 4.6e-3\n\
        [timer]\nclock_hz = 72_000_000\n";
    let answer = against(&format!("{HALL}{ripples}"), thin);
    let torques = answer.diagnosis.findings.iter();
    let torques = torques.filter(|one| one.mechanism == Mechanism::TorqueRipple);
    let mut orders: Vec<f64> = torques.clone().map(|one| one.place.orders[0]).collect();
    orders.sort_by(f64::total_cmp);
    assert_eq!(orders, [12.0, 18.0], "{:?}", said(&answer));
    for one in torques {
        let truth = if one.place.orders[0] == 12.0 {
            0.048
        } else {
            0.043
        };
        let [least, most] = one.parameters["torque_n_m"].ci95.unwrap();
        let wide = most - least;
        assert!(
            least - wide < truth && truth < most + wide,
            "{truth}: {least} {most}"
        );
    }
}

#[test]
fn torques_that_repeat_every_two_turns_are_one_finding_of_half_orders() {
    let engine = "seed = 9\nduration = { turns = 60 }\n[encoder.wheel]\nteeth = 36\nmissing = 1\n\
        [errors]\nposition = { normal = { rms_rad = 2e-3 } }\n[shaft]\ninertia_kg_m2 = 0.1\nviscous_n_m_s = 0.05\n\
        [drive.constant]\nr_min = 1400\n[noise.white]\npsd_n2_m2_s = 1e-3\n[timer]\nclock_hz = 16e6\n";
    let ripple = |order: f64, torque: f64| {
        format!("[[ripple]]\norder = {order}\nphase_rad = 1.0\ntorque_n_m = {torque}\n")
    };
    let torques = [(0.5, 8.0), (1.5, 6.0), (2.5, 4.0), (3.5, 3.0)].map(|(o, t)| ripple(o, t));
    let thin = "[encoder.wheel]\nteeth = 36\nmissing = 1\n[shaft]\ninertia_kg_m2 = 0.1\n[timer]\nclock_hz = 16e6\n";
    let answer = against(&format!("{engine}{}", torques.concat()), thin);
    let [finding] = &answer.diagnosis.findings[..] else {
        panic!("{:?}", said(&answer))
    };
    assert_eq!(finding.mechanism, Mechanism::TorqueRipple);
    assert_eq!(finding.place.orders, [0.5, 1.5, 2.5, 3.5]);
    // An order that is no half keeps an interval of its own.
    let answer = against(&format!("{engine}{}", ripple(3.47, 8.0)), thin);
    let [finding] = &answer.diagnosis.findings[..] else {
        panic!("{:?}", said(&answer))
    };
    assert_eq!(finding.mechanism, Mechanism::GearMesh);
    let [least, most] = finding.parameters["order"].ci95.unwrap();
    assert!(least < 3.47 && 3.47 < most, "{least} {most}");
}

#[test]
fn a_torque_of_which_even_edges_show_two_orders_is_said_to_have_either() {
    let even = HALL
        .lines()
        .filter(|line| !line.starts_with("position") && !line.starts_with("eccentricity"));
    let even: String = even.map(|line| format!("{line}\n")).collect();
    let ripple = "[[ripple]]\norder = 18\nphase_rad = 3.6\ntorque_n_m = 0.043\n";
    let answer = against(&format!("{even}{ripple}"), &even);
    let [finding] = &answer.diagnosis.findings[..] else {
        panic!("{:?}", said(&answer));
    };
    assert_eq!(finding.place.orders, [12.0]);
    assert_eq!(finding.place.orders_alike, [18.0, 42.0]);
    let summary = &answer.diagnosis.summary;
    assert!(summary.contains("at order 12 or 18 or 42"), "{summary}");
}

#[test]
fn a_family_has_the_orders_that_show_and_no_other() {
    let begins = PAIR_FAST.find("# A torque").unwrap();
    let ends = PAIR_FAST.find("[noise.white]").unwrap();
    let given = format!("{}{}", &PAIR_FAST[..begins], &PAIR_FAST[ends..]);
    let answer = against(PAIR_FAST, &given);
    let orders = answer.diagnosis.findings.iter();
    let mut orders: Vec<f64> = orders.flat_map(|one| one.place.orders.clone()).collect();
    orders.sort_by(f64::total_cmp);
    assert_eq!(orders, [5.0, 10.0], "{:?}", said(&answer));
}

#[test]
fn effects_that_no_recording_tells_apart_are_the_same() {
    let board = board(PAIR_FAST);
    let torque = |order: f64| Effect::new(Site::Torque, Carrier::Order(order));
    // 13 turns tell orders apart by a thirteenth.
    assert!(board.is_same(&torque(5.3), &torque(5.31)));
    assert!(!board.is_same(&torque(5.3), &torque(5.5)));
    let tone = Effect::new(Site::Torque, Carrier::Tone(5.3));
    assert!(!board.is_same(&torque(5.3), &tone));
    assert!(!board.is_same(&torque(5.3), &Effect::new(Site::Drive, Carrier::Order(5.3))));
}

#[test]
fn what_a_fit_has_without_a_finding_is_what_the_others_have_alone() {
    let board = board(PAIR_FAST);
    let mut model = Model::default();
    // Orders that so few turns hardly tell apart take from each other.
    for (group, order) in [5.0, 5.06].into_iter().enumerate() {
        model.add(&[Effect::new(Site::Torque, Carrier::Order(order))], group);
    }
    let fit = board.fit(&model);
    let (without, alone) = (fit.without(1), board.fit(&model.without(1)));
    let sizes = |of: &[f64]| of.iter().fold(0.0_f64, |sum, size| sum.hypot(*size));
    let (here, there) = (&without.model.terms[0].sizes, &alone.model.terms[0].sizes);
    assert!(sizes(&fit.model.terms[0].sizes) > 1.1 * sizes(there));
    let off: Vec<f64> = here.iter().zip(there).map(|(a, b)| a - b).collect();
    assert!(sizes(&off) < 1e-6 * sizes(there), "{here:?} {there:?}");
    assert!((without.rss / alone.rss - 1.0).abs() < 1e-9);
}
