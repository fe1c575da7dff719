//! What a search tries, keeps and bears out.

use super::{PAIR_FAST, board, board_beside, twin};
use crate::diagnose::effect::{Carrier, Effect, Growth, On, Site};
use crate::diagnose::lsq::dot;
use crate::diagnose::model::{Board, Fit, Model};
use crate::diagnose::nearby::Left;
use crate::diagnose::{cells, judge, jury, search};

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

/// What lines beside one explain of the recording of a twin beside another, over what they would of white noise.
fn floor(real: &str, given: &str, order: f64) -> f64 {
    let (real, given) = (twin(real), twin(given));
    let mut board = board_beside(&real, &given);
    let line = Effect::new(Site::Torque, Carrier::Order(order));
    let mut model = Model::default();
    model.add(&[line], 0);
    let mut fit = board.fit_in_noise(&model);
    let basis = fit.basis();
    basis.clear(&mut fit.left);
    Left::of(&board, &fit, &basis).floor(&line).unwrap()
}

#[test]
fn lines_beside_one_that_changes_explain_more_than_noise() {
    let torque = |order: f64| {
        let at = format!("order = {order}\nphase_rad = {}\n", 9.0 * order);
        format!("\n[[effect]]\nsite = \"torque\"\nfollows = \"order\"\n{at}torque_n_m = 4e-5\n")
    };
    let steady = floor(&format!("{PAIR_FAST}{}", torque(7.3)), PAIR_FAST, 7.3);
    assert!(steady < 2.0, "{steady}");
    // What swings about that order in parts of the recording is a band of lines.
    let band: String = (0..30)
        .map(|line| torque(5.9 + 0.1 * f64::from(line)))
        .collect();
    let band = floor(&format!("{PAIR_FAST}{band}"), PAIR_FAST, 7.3);
    assert!(band > 10.0, "{band}");
}

/// A wheel that runs up, pushed three times a turn, and what is known of its sensor.
fn run_up() -> [String; 2] {
    let sensor = "[encoder.wheel]\nteeth = 36\nmissing = 2\n\n[timer]\nclock_hz = 1000000\n";
    let rig = format!(
        "seed = 1008\nduration = {{ turns = 60 }}\n\n{sensor}jitter_s = 5e-7\n\n[shaft]\ninertia_kg_m2 = 0.1\n\n[errors]\n\
        seed = 13\neccentricity = {{ amplitude_rad = 1e-3 }}\nposition = {{ normal = {{ rms_rad = 3e-4, per = \"edge\" }} }}\n\n[drive.ramp]\n\
        from_r_min = 280\nto_r_min = 1060\nover_s = 5.4\n\n[noise.white]\npsd_n2_m2_s = 1e-3\nhold_s = 1e-5\n\n[[ripple]]\norder = 3\n\
        torque_n_m = 2.5\n"
    );
    [rig, format!("duration = {{ turns = 1 }}\n{sensor}")]
}

#[test]
fn lines_beside_a_whole_order_of_an_open_disc_explain_what_noise_does() {
    let [real, given] = run_up();
    let floor = floor(&real, &given, 3.0);
    assert!(floor < 2.0, "{floor}");
}

#[test]
fn a_torque_that_was_taken_for_a_stiff_drive_makes_phases_unsure_until_it_is_found() {
    let [real, given] = run_up();
    let mut board = board_beside(&twin(&real), &twin(&given));
    let mut model = Model::default();
    model.add(&[Effect::new(Site::Torque, Carrier::Order(3.0))], 0);
    let wider = |board: &Board| {
        let fit = board.fit(&model);
        let error = |fit: &Fit| {
            let mut numbers = fit.numbers(0).into_iter();
            numbers.find(|number| number.name == "phase_rad")?.error
        };
        let wide = error(&board.unsure_of_hold(&fit)).zip(error(&fit));
        wide.map(|(one, other)| one / other)
    };
    assert!(board.benches[0].found.hold.stiffness > 0.0);
    assert!(wider(&board) > Some(1.3), "{:?}", wider(&board));
    assert!(board.hold(&model));
    assert_eq!(board.benches[0].found.hold.stiffness, 0.0);
    assert_eq!(wider(&board), Some(1.0));
}

#[test]
fn a_line_that_noise_has_is_not_borne_out_by_other_turns() {
    let real = twin(PAIR_FAST);
    let mut given = real.clone();
    let ripple = given.ripple.pop().unwrap();
    let mut board = board_beside(&real, &given);
    let mut model = Model::default();
    model.add(
        &[Effect::new(Site::Torque, Carrier::Order(ripple.order))],
        1,
    );
    model.add(&[Effect::new(Site::Torque, Carrier::Order(33.7))], 2);
    let mut fit = board.fit(&model);
    let mut worth = vec![(1, f64::INFINITY), (2, f64::INFINITY)];
    assert!(jury::bear_out(&mut board, &mut fit, &mut worth));
    assert_eq!(fit.model.groups(), [1]);
    assert!(worth[0].1.is_finite());
    assert!(!jury::bear_out(&mut board, &mut fit, &mut worth));
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

#[test]
fn torques_that_edges_show_as_less_than_once_a_turn_are_none_beside_an_unknown_drive() {
    let thin = "duration = { turns = 20 }\n[encoder.hall]\npole_pairs = 5\n[shaft]\ninertia_kg_m2 = 1e-3\n[timer]\nclock_hz = 72000000\n";
    let driven = format!("{thin}[drive.constant]\nr_min = 300\n");
    let torque = |order: f64| {
        let effect = Effect::new(Site::Torque, Carrier::Order(order));
        Model::default().with(&[effect], 0)
    };
    let given = [thin, &*driven].map(|given| board_beside(&twin(&driven), &twin(given)));
    for (order, beside_unknown) in [(12.0, true), (18.0, true), (29.4, false), (30.5, false)] {
        let possible = given.each_ref().map(|board| board.can_be(&torque(order)));
        assert_eq!(possible, [beside_unknown, true], "{order}");
    }
}

#[test]
fn a_size_whose_growth_does_not_show_is_constant() {
    let rig = "duration = { turns = 40 }\n[encoder.quadrature]\nlines = 60\nindex = true\n[errors]\nwidth_a_rad = 1e-6\n[shaft]\n\
        inertia_kg_m2 = 1e-4\nviscous_n_m_s = 4e-4\n[drive.ramp]\nfrom_r_min = 100\nto_r_min = 200\nover_s = 16\n[noise.white]\n\
        psd_n2_m2_s = 1e-11\n[timer]\nclock_hz = 84000000\njitter_s = 5e-8\n";
    let ripple = "[[ripple]]\norder = 5\nphase_rad = 1.0\ntorque_n_m = 1e-4\n";
    let board = board_beside(&twin(&format!("{rig}{ripple}")), &twin(rig));
    let grown = Effect {
        growth: Growth::Speed(0.1),
        ..Effect::new(Site::Torque, Carrier::Order(5.0))
    };
    let mut fit = board.fit(&Model::default().with(&[grown], 0));
    assert!(fit.model.terms[0].effect.growth != Growth::Constant);
    search::prune(&board, &mut fit);
    let constant = Effect {
        growth: Growth::Constant,
        ..grown
    };
    assert_eq!(fit.model.effects(0), [constant]);
}

#[test]
fn beside_an_unknown_drive_an_image_is_looked_for_after_the_order_that_it_is_of() {
    // 30 edges a turn: 18 is the image of 12.
    let thin = "[encoder.hall]\npole_pairs = 5\n[errors]\nseed = 3\nposition = { normal = { rms_rad = 1e-4 } }\n\
        [shaft]\ninertia_kg_m2 = 4.6e-3\n[timer]\nclock_hz = 72_000_000\njitter_s = 1e-6\n";
    let drive = "[duration]\nturns = 60\n[drive.constant]\nr_min = 60\n\
        [[ripple]]\norder = 18\nphase_rad = 3.6\ntorque_n_m = 0.043\n";
    let board = board_beside(&twin(&format!("{thin}{drive}")), &twin(thin));
    let tried = search::torque_orders(&board, &board.fit(&Model::default()));
    assert!(tried.contains(&12) && !tried.contains(&18), "{tried:?}");
}

#[test]
fn a_torque_that_comes_and_goes_takes_a_findings_place_as_open_where_nobody_declared_the_drive() {
    let load = Effect::new(Site::Torque, Carrier::Window(0.1, 0.2));
    let thin = "[encoder.quadrature]\nlines = 500\n[shaft]\ninertia_kg_m2 = 1e-4\n[timer]\nclock_hz = 84e6\n";
    let undriven = board_beside(&twin(PAIR_FAST), &twin(thin));
    let model = search::with(&undriven, &Model::default(), &[load], 3);
    assert!(model.groups().is_empty(), "{model:?}");
    let driven = board(PAIR_FAST);
    let model = search::with(&driven, &Model::default(), &[load], 3);
    assert_eq!(model.groups(), [3]);
}

#[test]
fn the_score_of_a_free_disc_tells_what_changes_at_a_place() {
    let given = "duration = { turns = 20 }\n\n[encoder.wheel]\nteeth = 36\nmissing = 2\n\n[shaft]\ninertia_kg_m2 = 0.1\n\n[timer]\n\
                 clock_hz = 1_000_000\njitter_s = 1e-6\n\n[drive.ramp]\nfrom_r_min = 200\nto_r_min = 800\nover_s = 3\n";
    let errors = "[errors]\nposition = { normal = { rms_rad = 2e-3, per = \"edge\" } }\n";
    let board = board_beside(&twin(&format!("{given}\n{errors}")), &twin(given));
    assert!(board.pattern.as_ref().unwrap().size2 > 0.0);
    let fit = board.fit(&Model::default());
    let basis = fit.basis();
    let left = Left::of(&board, &fit, &basis);
    let here = Site::Disc(On::ALL);
    for growth in [1.0, -1.0, 0.5].map(Growth::Speed) {
        let effect = Effect {
            growth,
            ..Effect::new(here, Carrier::Bump(1.0, 0.05))
        };
        let by_score = dot(&board.benches[0].columns(&effect)[0], &left.scores(here)[0]);
        let by_rows = dot(&board.columns(&effect)[0], &fit.left);
        assert!(
            (by_score / by_rows - 1.0).abs() < 1e-3,
            "{by_score} {by_rows}"
        );
    }
}

#[test]
fn what_settles_within_a_few_edges_is_no_drift() {
    let board = board(PAIR_FAST);
    let times = &board.benches[0].record.time_s;
    let [few, many] = [4, 100].map(|edges| {
        let carrier = Carrier::Settling(times[0], times[edges] - times[0]);
        let effect = Effect::new(Site::Level(On::ALL), carrier);
        board.can_be(&Model::default().with(&[effect], 0))
    });
    assert!(!few && many);
}
