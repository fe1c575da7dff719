//! Delays of the capture, simulated: what a table with the true ones makes of the times and angles of a fast shaft.
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    missing_docs
)]

use std::f64::consts::TAU;

use quadcal::corrector::{CorrectedEdge, Corrector};
use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::estimate::Anchor;
use quadcal::hall::HallDecoder;
use quadcal::shape::{CLASSES_MAX, EncoderShape};
use quadcal::slot::{self, Delays, Slot, SlotHeader, Stamp};
use quadcal::step::Flags;
use quadcal::table::ErrorTable;
use quadcal::units::{RAD_PER_TURN32, TickDelta8, Turn32, TurnDelta32};
use quadcal_host::sensor::{SensorKind, SensorPlan};
use quadcal_host::sim::Simulation;
use quadcal_host::twin::{
    ChannelSkew, Drive, Duration, EdgeDelay, Encoder, Errors, Noise, RiseFall, Twin,
};
use quadcal_host::verify::{Verdict, verify};

/// Delays of A rise, B rise, A fall, B fall.
const DELAYS_S: [f64; 4] = [2.0e-6, 1.5e-6, 0.6e-6, 0.9e-6];
const LINES: u32 = 360;
const R_MIN: f64 = 3000.0;
const CLOCK_HZ: f64 = 84e6;

/// A fast encoder without errors whose edges are captured late.
fn fast(r_min: f64) -> Twin {
    let channel = |rise: usize, fall: usize| RiseFall {
        rise_s: DELAYS_S[rise],
        fall_s: DELAYS_S[fall],
    };
    Twin {
        encoder: Encoder::Quadrature {
            lines: LINES,
            index: true,
        },
        errors: Errors::default(),
        ripple: Vec::new(),
        drive: Drive::Constant { r_min },
        duration: Duration::Turns(6.0),
        edge_delay: Some(EdgeDelay {
            a: channel(0, 2),
            b: channel(1, 3),
            ..EdgeDelay::default()
        }),
        ..Twin::paper()
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// As a table has delays: less their mean.
fn class_delays(delays_s: &[f64], clock_hz: f64) -> [TickDelta8; CLASSES_MAX] {
    let middle = mean(delays_s);
    let mut delays = [TickDelta8::ZERO; CLASSES_MAX];
    for (delay, seconds) in delays.iter_mut().zip(delays_s) {
        *delay = TickDelta8(((seconds - middle) * clock_hz * 256.0).round() as i32);
    }
    delays
}

/// RMS and largest error of the angle asked for at times between edges, rad. The mean delay is nobody's to know, so time runs late by it.
fn angle_errors(r_min: f64, delays: [TickDelta8; CLASSES_MAX]) -> (f64, f64) {
    let shape = EncoderShape::new(4 * LINES, 4).unwrap();
    let entries = vec![0_i16; 4 * LINES as usize];
    let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &entries, 0).unwrap();
    let mut corrector = Corrector::new(table.with_delays(delays), Anchor::Index);
    let mut decoder = QuadratureDecoder::new(DecoderConfig::new(LINES)).unwrap();
    let rows: Vec<_> = Simulation::new(&fast(r_min))
        .unwrap()
        .map(|e| e.row)
        .collect();
    let (mut squares, mut largest, mut count) = (0.0, 0.0_f64, 0.0);
    for (i, pair) in rows.windows(2).enumerate() {
        corrector.push(&decoder.push(pair[0]));
        let anchored = |edge: CorrectedEdge| edge.flags.contains(Flags::REFERENCED);
        if !corrector.last().is_some_and(anchored) {
            continue;
        }
        let wait = pair[1].ticks - pair[0].ticks;
        let now = pair[0].ticks + wait * (i as u64 % 7) / 7;
        let time_s = now as f64 / CLOCK_HZ - mean(&DELAYS_S);
        let turns = r_min / 60.0 * time_s;
        let truth = Turn32((turns.fract().rem_euclid(1.0) * 4_294_967_296.0) as u32);
        let error = f64::from(corrector.angle_at(now).unwrap().minus(truth).0) * RAD_PER_TURN32;
        squares += error * error;
        largest = largest.max(error.abs());
        count += 1.0;
    }
    ((squares / count).sqrt(), largest)
}

#[test]
fn between_edges_the_angle_is_right_at_speed_only_with_the_delays_known() {
    for r_min in [R_MIN, -R_MIN] {
        let (before, _) = angle_errors(r_min, [TickDelta8::ZERO; CLASSES_MAX]);
        let (after, largest) = angle_errors(r_min, class_delays(&DELAYS_S, CLOCK_HZ));
        println!(
            "{r_min} r/min: {before:.2e} rad RMS without, {after:.2e} rad with the delays, {largest:.2e} at most"
        );
        // A tick is 3.7e-6 rad at this speed; the delays' RMS of 0.55 us is 1.7e-4 rad.
        assert!(before > 1.5e-4, "{before:e}");
        assert!(after < 5e-6 && largest < 2e-5, "{after:e} {largest:e}");
    }
}

#[test]
fn a_clock_of_33_us_loses_no_fraction_of_a_delay() {
    const COARSE_HZ: f64 = 30_000.0;
    let mut twin = fast(2950.0);
    twin.encoder = Encoder::Hall { pole_pairs: 2 };
    twin.timer.clock_hz = COARSE_HZ as u64;
    twin.duration = Duration::Turns(12_000.0);
    // Keeps the rounding to ticks from being the same in every turn.
    twin.noise = Some(Noise::SpeedWander {
        rms_fraction: 1e-3,
        correlation_rad: Some(20.0),
        hold_s: None,
    });
    twin.edge_delay = None;
    twin.channel_skew = Some(ChannelSkew {
        a_s: 0.0,
        b_s: 9e-6,
        c_s: 21e-6,
    });
    // A falls, B rises, C falls, and so on: 0, 0.27 and 0.63 ticks.
    let delays = class_delays(&[0.0, 9e-6, 21e-6, 0.0, 9e-6, 21e-6], COARSE_HZ);
    let shape = EncoderShape::new(12, 6).unwrap();
    let spread = |delays| {
        let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &[0; 12], 0).unwrap();
        let mut corrector = Corrector::new(table.with_delays(delays), Anchor::FirstEdge);
        let mut decoder = HallDecoder::new(2).unwrap();
        let mut sums = [(0.0, 0.0); 6];
        for event in Simulation::new(&twin).unwrap() {
            let outcome = decoder.push(event.row);
            let (Some(step), Some(edge)) = (outcome.step(), corrector.push(&outcome)) else {
                continue;
            };
            if edge.interval != 0 {
                let sum = &mut sums[step.edge as usize % 6];
                *sum = (sum.0 + edge.interval_q8() as f64 / 256.0, sum.1 + 1.0);
            }
        }
        let means = sums.map(|(sum, count)| sum / count);
        let lowest = means.iter().copied().fold(f64::INFINITY, f64::min);
        means.iter().copied().fold(0.0, f64::max) - lowest
    };
    let (before, after) = (spread([TickDelta8::ZERO; CLASSES_MAX]), spread(delays));
    println!(
        "class means of the interval differ by {before:.3} ticks without, {after:.3} with the delays"
    );
    // 24,000 intervals a class, each rounded by up to a tick.
    assert!(before > 0.8 && after < 0.02, "{before} {after}");
}

#[test]
fn verify_holds_a_table_with_delays_against_compensated_times() {
    let rows: Vec<_> = Simulation::new(&fast(R_MIN))
        .unwrap()
        .map(|e| e.row)
        .collect();
    let scatter = |delays: Delays| {
        let header = SlotHeader {
            shape: EncoderShape::new(4 * LINES, 4).unwrap(),
            shift: 0,
            turns: 11,
            indexed: true,
            standard_error: 0,
            class_standard_error: 0,
            source: 0,
            learned_until: 0,
            class_offsets: [TurnDelta32(0); CLASSES_MAX],
            delays,
            stamp: Stamp::default(),
        };
        let mut bytes = Vec::new();
        slot::write(&header, &vec![0_i16; 4 * LINES as usize], |piece| {
            bytes.extend_from_slice(piece);
            Ok::<(), ()>(())
        })
        .unwrap();
        let plan = SensorPlan {
            kind: SensorKind::Quadrature {
                index_state: Some(quadcal::edge::Levels(1)),
            },
            lines: LINES,
        };
        let slot = Slot::parse(&bytes).unwrap();
        let rows = rows.iter().copied().map(Ok);
        verify(&slot, plan, 1, CLOCK_HZ as u64, rows, None).unwrap()
    };
    // Learned on another device, whose timer runs at half the clock.
    let known = Delays {
        of_class: class_delays(&DELAYS_S, CLOCK_HZ / 2.0),
        standard_error: 1,
        clock_hz: CLOCK_HZ as u64 / 2,
    };
    let check = scatter(known);
    println!(
        "scatter {:.2e} before, {:.2e} after",
        check.scatter.before, check.scatter.after
    );
    assert_eq!(check.verdict(), Verdict::Better);
    assert!(check.scatter.after < 0.02 * check.scatter.before);
    let reversed = Delays {
        of_class: known.of_class.map(|delay| TickDelta8(-delay.0)),
        ..known
    };
    assert_eq!(scatter(reversed).verdict(), Verdict::Worse);
    assert_eq!(scatter(Delays::NONE).verdict(), Verdict::Same);
}

#[test]
fn the_delays_in_angle_grow_with_speed() {
    let rms = |r_min| angle_errors(r_min, [TickDelta8::ZERO; CLASSES_MAX]).0;
    let (slow, fast) = (rms(600.0), rms(R_MIN));
    assert!(
        (fast / slow - R_MIN / 600.0).abs() < 0.2,
        "{slow:e} {fast:e}"
    );
    let delays: Vec<f64> = DELAYS_S
        .iter()
        .map(|delay| delay - mean(&DELAYS_S))
        .collect();
    let expected = (delays.iter().map(|d| d * d).sum::<f64>() / 4.0).sqrt() * R_MIN / 60.0 * TAU;
    assert!(fast > 0.9 * expected, "{fast:e} {expected:e}");
}
