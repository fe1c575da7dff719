//! The whole encoder: what a capture costs, and what its readers take.

use core::hint::black_box;

use quadcal::edge::Sample;
use quadcal::encoder::{Capture, Encoder, EncoderConfig};
use quadcal::table::ErrorTable;

use super::counter::InstructionCounter;
use super::rig::{BLOCK, LINES, Rig, SLOTS};
use super::stage::{Stage, idle};

type Wide<'a> = Encoder<'a, i16, 32>;

/// Prints everything; `None` if the rig does not fit the core.
pub fn measure(
    counter: &InstructionCounter,
    samples: &mut [Sample; BLOCK],
    table: ErrorTable<'_>,
) -> Option<()> {
    let config = EncoderConfig::new(LINES, 84_000_000);
    let new = || Wide::new(config, Some(table)).ok();
    let [mut angles, mut speeds] = [new()?, new()?];
    let mut rig = Rig::new();
    rig.fill(samples);
    // The rig's clock does not begin at 0, and does not wrap meanwhile.
    while angles.time(0, false) >> 32 < samples[0].ticks >> 32 {
        angles.overflow();
        speeds.overflow();
    }
    let [
        mut empty,
        mut empty_captures,
        mut edge,
        mut edge_speed,
        mut now,
        mut speed_at,
    ] = core::array::from_fn(|_| Stage::default());
    let mut times = *samples;
    let mut captures = [Capture::default(); BLOCK];
    // Two turns, so that the index is seen, and three to count.
    let turn = SLOTS as usize / BLOCK;
    for block in 0..5 * turn {
        if block == 2 * turn {
            [empty, empty_captures, edge, edge_speed, now, speed_at] =
                core::array::from_fn(|_| Stage::default());
        }
        empty.count(counter, || idle(samples));
        let newest = angles.last().map_or(0, |last| last.edge.ticks);
        for (time, later) in times.iter_mut().zip(0..) {
            *time = Sample {
                ticks: newest + later,
                ..samples[0]
            };
        }
        now.count(counter, || now_block(&angles, &times));
        speed_at.count(counter, || speed_block(&angles, &times));
        for (capture, sample) in captures.iter_mut().zip(samples.iter()) {
            *capture = Capture {
                raw: sample.ticks as u32,
                overflow_pending: false,
                levels: sample.levels,
            };
        }
        empty_captures.count(counter, || idle_captures(&captures));
        edge.count(counter, || edge_block(&mut angles, &captures));
        edge_speed.count(counter, || edge_speed_block(&mut speeds, &captures));
        rig.fill(samples);
    }
    edge.print("encoder_edge", &empty_captures);
    edge_speed.print("encoder_edge_with_speed", &empty_captures);
    now.print("encoder_now", &empty);
    speed_at.print("encoder_speed_at", &empty);
    (angles.faults().total() == 0 && angles.decoder().is_referenced()).then_some(())
}

#[inline(never)]
fn idle_captures(captures: &[Capture]) {
    for capture in captures {
        black_box(black_box(capture));
    }
}

#[inline(never)]
fn edge_block(encoder: &mut Wide<'_>, captures: &[Capture]) {
    for capture in captures {
        if let Some(seen) = encoder.edge(*black_box(capture)) {
            black_box((seen.edge.angle, seen.edge.interval));
        }
    }
}

#[inline(never)]
fn edge_speed_block(encoder: &mut Wide<'_>, captures: &[Capture]) {
    for capture in captures {
        if let Some(seen) = encoder.edge(*black_box(capture)) {
            black_box((seen.edge.angle, seen.speed()));
        }
    }
}

/// A control loop's question, once an edge.
#[inline(never)]
fn now_block(encoder: &Wide<'_>, samples: &[Sample]) {
    for sample in samples {
        black_box(black_box(encoder).now(black_box(sample).ticks));
    }
}

#[inline(never)]
fn speed_block(encoder: &Wide<'_>, samples: &[Sample]) {
    for sample in samples {
        black_box(black_box(encoder).speed_at(black_box(sample).ticks));
    }
}
