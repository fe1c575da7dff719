//! Filter, shaft, disc and board by themselves.

use std::f64::consts::TAU;

use super::{PAIR_FAST, WHEEL, board, board_beside, edges, twin};
use crate::diagnose::bench::Bench;
use crate::diagnose::effect::{Carrier, Effect, Growth, On, Site};
use crate::diagnose::filter::{Filter, Noise, State, Whitens};
use crate::diagnose::model::{Board, Model, Term, Wander};
use crate::diagnose::noise::Tails;
use crate::diagnose::pattern::Pattern;
use crate::diagnose::plant::{Law, Plant};
use crate::diagnose::record::Record;
use crate::diagnose::spread::Spread;
use crate::diagnose::{course::Course, declared, disc, lsq, lsq::dot, search};

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
        unseen: 0.0,
        ..Noise::default()
    };
    let filter = Filter::<{ State::Held.and_before() }>::new(&leaps, &noise);
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
    let spread = Spread {
        edge_rad: 1e-4,
        waves_rad: vec![],
    };
    let mut pattern = Pattern::known(&board.benches, &spread).unwrap();
    let off = |pattern: &Pattern| off_normal(&board, pattern, &spread);
    assert!(off(&pattern) < 1e-16, "{}", off(&pattern));
    pattern.weigh(&board.benches);
    assert!(off(&pattern) < 1e-16, "{}", off(&pattern));
}

#[test]
fn slow_waves_of_a_disc_are_as_open_as_its_list_says() {
    for twin in [WHEEL, PAIR_FAST] {
        let board = board(twin);
        let spread = Spread {
            edge_rad: 1e-7,
            waves_rad: vec![2e-3, 0.0, 4e-5],
        };
        let pattern = Pattern::known(&board.benches, &spread).unwrap();
        let off = off_normal(&board, &pattern, &spread);
        assert!(off < 1e-8, "{off}");
    }
}

/// By how much a pattern's errors miss its normal equations, as a part of their right side, squares.
fn off_normal(board: &Board, pattern: &Pattern, spread: &Spread) -> f64 {
    let white = board.target();
    let errors = pattern.closest(&board.benches, &white);
    let fold = pattern.fold(&board.benches, &white);
    let shown = pattern.fold(&board.benches, &pattern.unfold(&board.benches, &errors));
    // Waves by themselves, without a Fourier transform.
    let (count, edge2) = (errors.len() as f64, spread.edge_rad.powi(2));
    let mut over: Vec<f64> = errors.iter().map(|error| error / edge2).collect();
    for (at, wave_rad) in spread.waves_rad.iter().enumerate() {
        let all2 = edge2 + 0.5 * count * wave_rad.powi(2);
        for phase in [0.0, 0.25 * TAU] {
            let turn = |edge: usize| (at + 1) as f64 * edge as f64 * TAU / count + phase;
            let wave = |edge: usize| (2.0 / count).sqrt() * turn(edge).cos();
            let along: f64 = errors.iter().enumerate().map(|(k, e)| e * wave(k)).sum();
            let each = over.iter_mut().enumerate();
            each.for_each(|(k, over)| *over += along * wave(k) * (all2.recip() - edge2.recip()));
        }
    }
    let each = fold.iter().zip(&shown).zip(&over);
    let rest = each.map(|((fold, shown), over)| fold - shown - over);
    rest.map(|rest| rest * rest).sum::<f64>() / dot(&fold, &fold)
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
    let solved = lsq::solve(&[&one, &time, &sin, &cos], &angles[half..]);
    let swing = solved.sizes[2].hypot(solved.sizes[3]);
    assert!((swing / expected - 1.0).abs() < 1e-3, "{swing} {expected}");
}

#[test]
fn effects_of_a_twin_are_as_many_as_its_sections_say() {
    let twin = twin(include_str!("../../../twins/mechanisms.toml"));
    // One gear, two bearings, a tone, a load, a level's ripple and drift, two plays, a drift of the speed.
    assert_eq!(declared::effects(&twin).len(), 10);
}

#[test]
fn torque_that_is_held_for_many_edges_is_no_free_drift_of_an_unknown_drive() {
    let sensor =
        "[encoder.quadrature]\nlines = 250\nindex = true\n\n[shaft]\ninertia_kg_m2 = 1.4e-4\n";
    let timer = "\n[timer]\nclock_hz = 168_000_000\njitter_s = 3e-7\n";
    let drive = "viscous_n_m_s = 1e-4\nstiffness_n_m_s = 1e-3\n\n[drive.constant]\nr_min = 270\n\n[noise.white]\npsd_n2_m2_s = 2e-9\n\
                 hold_s = 2e-3\n";
    let real = twin(&format!(
        "seed = 4\nduration = {{ turns = 12 }}\n\n{sensor}{drive}{timer}"
    ));
    let thin = twin(&format!("{sensor}{timer}"));
    let record = Record::of(&edges(&real), &thin);
    let noise = Noise {
        torque: 1.0,
        stamp_s: record.tick_s,
        ..Noise::default()
    };
    let board = Board::new(vec![Bench::new(record, &thin, &[], &noise)]);
    let any = board.in_any_noise(Tails::Normal, Wander::Quick);
    let (any, ..) = any.at_its_noise(&Model::default());
    let Noise {
        torque,
        drift,
        fade,
        ..
    } = any.noise;
    // What is slow has the density that the rig has.
    let slow = torque + drift / (fade * fade);
    let expected = 2e-9 / 1.4e-4_f64.powi(2);
    assert!((0.5..2.0).contains(&(slow / expected)), "{:?}", any.noise);
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

#[test]
fn a_shaft_that_goes_on_does_not_stop_between_two_edges() {
    let thin = twin(
        "[encoder.quadrature]\nlines = 100\n\n[shaft]\ninertia_kg_m2 = 1e-4\n\n[timer]\nclock_hz = 1_000_000\n",
    );
    let mut edges = edges(&twin(
        "seed = 1\nduration = { turns = 4 }\n\n[encoder.quadrature]\nlines = 100\n\n[drive.constant]\nr_min = 60\n\n\
         [timer]\nclock_hz = 1_000_000\n",
    ));
    let (at, later) = (800, 801);
    edges.time_s[later..]
        .iter_mut()
        .for_each(|time_s| *time_s += 0.1);
    let record = Record::of(&edges, &thin);
    let course = Course::new(&record, &vec![0.0; record.len()]);
    let mean =
        (course.angle[later] - course.angle[at]) / (course.time_s[later] - course.time_s[at]);
    let shares = (1..100).map(|share| course.within(later, f64::from(share) / 100.0));
    let slowest = shares.map(|(_, speed)| speed).fold(f64::INFINITY, f64::min);
    assert!(slowest > 0.2 * mean, "{slowest} of {mean}");
    assert!((course.within(later, 1.0).0 - course.angle[later]).abs() < 1e-12);
    let falls = Effect {
        growth: Growth::Speed(-0.9),
        ..Effect::new(Site::Torque, Carrier::Order(5.2))
    };
    let bench = Bench::new(
        record,
        &thin,
        &[],
        &Noise {
            torque: 1.0,
            stamp_s: 1e-6,
            ..Noise::default()
        },
    );
    let columns = bench.columns(&falls);
    assert!(columns.iter().flatten().all(|angle| angle.is_finite()));
}

#[test]
fn how_a_torque_grows_is_fitted_at_an_exact_order_too() {
    let more = "\n[[effect]]\nsite = \"torque\"\nfollows = \"order\"\norder = 7\ntorque_n_m = 1e-3\ngrowth_per_s = 0.5\n";
    let (real, given) = (twin(&format!("{PAIR_FAST}{more}")), twin(PAIR_FAST));
    let mut board = board_beside(&real, &given);
    let swells = Effect {
        growth: Growth::Even(1.2),
        ..Effect::new(Site::Torque, Carrier::Order(7.0))
    };
    let mut model = Model::default();
    model.add(&[swells], 0);
    let fit = board.fit_in_noise(&model);
    let Growth::Even(rate) = fit.model.terms[0].effect.growth else {
        panic!("{:?}", fit.model.terms[0]);
    };
    assert!((rate - 0.5).abs() < 0.02, "{rate}");
}

#[test]
fn open_places_of_an_unknown_disc_add_up_to_no_angle_that_torques_go_by() {
    // Of a disc with 2,000 edges a search looks at some first: its slow waves are open there as well.
    let begins = PAIR_FAST.find("[errors]").unwrap();
    let ends = PAIR_FAST.find("[shaft]").unwrap();
    let given = format!("{}{}", &PAIR_FAST[..begins], &PAIR_FAST[ends..]);
    let board = board_beside(&twin(PAIR_FAST), &twin(&given));
    let records = board.benches.iter();
    let some = records.map(|bench| bench.record.of_some(127)).collect();
    let board = board.along(some, &Model::default()).unwrap();
    let mut model = search::nuisances(&board);
    let slow = |term: &Term| matches!(term.effect.carrier, Carrier::Order(_));
    assert_eq!(model.terms.iter().filter(|term| slow(term)).count(), 8);
    // Places all round, of one size.
    let places = (0..8).map(|at| Carrier::Bump(f64::from(at) * TAU / 8.0, 0.4));
    let places: Vec<Effect> = places
        .map(|place| Effect::new(Site::Disc(On::ALL), place))
        .collect();
    model.add_open(&places, usize::MAX);
    let round = model.terms.iter_mut().rev().take(8);
    round.for_each(|term| term.sizes[0] = -0.05);
    let shifts = &disc::shifts(&board, &model)[0];
    let mean = shifts.iter().sum::<f64>() / shifts.len() as f64;
    assert!(mean.abs() < 1e-4, "{mean}");
    let learned = disc::learned(&board, &model).unwrap();
    let mean = learned.iter().sum::<f64>() / learned.len() as f64;
    assert!(mean.abs() < 1e-4, "{mean}");
}

#[test]
fn noise_and_disc_are_fitted_as_long_as_that_makes_the_recording_likelier() {
    for (turns, torque, jitter) in [(6, 20.0, 2e-5), (9, 5.0, 1e-6)] {
        let thin = "[encoder.wheel]\nteeth = 36\nmissing = 1\n[timer]\nclock_hz = 1e6\n";
        let rig = format!(
            "seed = 4\n{thin}jitter_s = {jitter}\n[duration]\nturns = {turns}\n[errors]\nposition = {{ normal = {{ rms_rad = 1e-2 }} }}\n\
             [shaft]\ninertia_kg_m2 = 0.1\nviscous_n_m_s = 0.5\n[drive.constant]\nr_min = 160\n[noise.white]\npsd_n2_m2_s = 1e-1\n\
             [[ripple]]\norder = 3\nphase_rad = 1.0\ntorque_n_m = {torque}\n"
        );
        let (mut board, model) = (board_beside(&twin(&rig), &twin(thin)), Model::default());
        assert!(board.pattern.is_some());
        // From a noise that is far off, and on from where that leads.
        for factor in [1e-2, 1e2, 1.0] {
            board.set_noise(Noise {
                torque: factor * board.noise.torque,
                stamp_s: factor * board.noise.stamp_s,
                ..board.noise
            });
            let before = board.lost(&board.fit(&model));
            let fit = board.fit_in_noise(&model);
            assert!(board.lost(&fit) <= before, "{turns} turns, {factor}");
        }
    }
}

#[test]
fn delays_of_falls_are_told_as_the_rises_that_come_earlier() {
    let real =
        format!("{PAIR_FAST}\n[edge_delay]\na = {{ rise_s = 1e-6 }}\nb = {{ rise_s = 1e-6 }}\n");
    let board = board_beside(&twin(&real), &twin(PAIR_FAST));
    for rises in [true, false] {
        let on = On {
            channel: None,
            rises: Some(rises),
        };
        let delay = Effect::new(Site::Stamp(on), Carrier::Steady);
        let numbers = board.fit(&Model::default().with(&[delay], 0)).numbers(0);
        assert_eq!(numbers[0].name, "rise_less_fall_s");
        let value = numbers[0].value;
        assert!((value - 1e-6).abs() < 5e-8, "{rises}: {value}");
    }
}
