//! Errors of the calls: each has its code and its name, and nothing was done.
#![allow(missing_docs)]

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use quadcal_c::quadcal_status::*;
use quadcal_c::*;

fn encoder() -> quadcal_encoder {
    // SAFETY: an encoder that is all zeros is one that was not initialised.
    unsafe { std::mem::zeroed() }
}

fn started() -> quadcal_encoder {
    let mut encoder = encoder();
    let config = quadcal_usual_config(250, 16, 1_000_000);
    // SAFETY: both are there, here and below.
    assert_eq!(
        unsafe { quadcal_init(&raw mut encoder, &raw const config) },
        QUADCAL_OK
    );
    encoder
}

#[test]
fn every_status_has_its_name() {
    for status in -13..=2 {
        // SAFETY: a constant text.
        let name = unsafe { CStr::from_ptr(quadcal_error_name(status)) };
        let name = name.to_str().unwrap();
        assert_eq!(
            name.starts_with("QUADCAL_ERROR_"),
            status < 0,
            "{status}: {name}"
        );
        assert_ne!(name, "QUADCAL_UNKNOWN");
    }
    // SAFETY: as before.
    let name = unsafe { CStr::from_ptr(quadcal_error_name(-14)) };
    assert_eq!(name, c"QUADCAL_UNKNOWN");
}

#[test]
fn settings_out_of_range_are_refused() {
    let good = quadcal_usual_config(250, 16, 1_000_000);
    for (config, status) in [
        (quadcal_config { lines: 0, ..good }, QUADCAL_ERROR_LINES),
        (
            quadcal_config {
                lines: 16_385,
                ..good
            },
            QUADCAL_ERROR_LINES,
        ),
        (
            quadcal_config {
                lines: u32::MAX,
                ..good
            },
            QUADCAL_ERROR_LINES,
        ),
        (
            quadcal_config {
                timer_bits: 24,
                ..good
            },
            QUADCAL_ERROR_TIMER,
        ),
        (
            quadcal_config {
                glitch_gate: 1,
                ..good
            },
            QUADCAL_ERROR_GATE,
        ),
    ] {
        let mut encoder = encoder();
        // SAFETY: both are there.
        unsafe {
            assert_eq!(quadcal_init(&raw mut encoder, &raw const config), status);
            assert_eq!(
                quadcal_overflow(&raw mut encoder),
                QUADCAL_ERROR_NOT_INITIALISED
            );
        }
    }
}

#[test]
fn null_is_an_error_everywhere() {
    let mut encoder = started();
    let encoder = &raw mut encoder;
    let capture = quadcal_capture {
        raw: 1,
        levels: 1,
        overflow_pending: 0,
    };
    let capture = &raw const capture;
    // SAFETY: null is allowed, and an error.
    let statuses = unsafe {
        [
            quadcal_init(encoder, null()),
            quadcal_init(null_mut(), &raw const QUIET),
            quadcal_edge(encoder, null(), null_mut(), null_mut()),
            quadcal_edge(encoder, capture, null_mut(), null_mut()),
            quadcal_edges(encoder, null(), 1, null_mut(), null_mut()),
            quadcal_edges(encoder, null(), 0, null_mut(), null_mut()),
            quadcal_overflow(null_mut()),
            quadcal_time(encoder, 0, 0, null_mut()),
            quadcal_capture_time(encoder, null(), null_mut()),
            quadcal_speed(encoder, 0, null_mut()),
            quadcal_state(encoder, null_mut()),
            quadcal_set_table(encoder, null(), 8),
            quadcal_learn_slice(null_mut(), null_mut()),
        ]
    };
    assert_eq!(statuses, [QUADCAL_ERROR_POINTER; 13]);
    let mut angle = 0;
    // SAFETY: both are there. Nothing of the above was an edge.
    assert_eq!(
        unsafe { quadcal_angle(encoder, 0, &raw mut angle) },
        QUADCAL_ERROR_NO_ANGLE
    );
}

static QUIET: quadcal_config = quadcal_config {
    clock_hz: 1,
    timeout: 1,
    lines: 4,
    timer_bits: 32,
    glitch_gate: 3,
    index_levels: 1,
    has_index: 1,
};

#[test]
fn a_batch_gives_the_edges_that_single_captures_give() {
    let captures: Vec<quadcal_capture> = (0..60_u32)
        .map(|k| quadcal_capture {
            raw: 1000 * k,
            levels: [1, 3, 2, 0][k as usize % 4],
            overflow_pending: 0,
        })
        .collect();
    let (mut one, mut all) = (started(), started());
    let mut single = vec![quadcal_corrected::default(); captures.len()];
    let mut batch = single.clone();
    let (mut found, mut edges, mut speed) = (0, 0, 0);
    // SAFETY: everything is there, with room for all edges.
    unsafe {
        for capture in &captures {
            let place = single[found..].as_mut_ptr();
            let status = quadcal_edge(&raw mut one, capture, place, &raw mut speed);
            found += usize::from(status == QUADCAL_OK);
        }
        let (from, to) = (captures.as_ptr(), batch.as_mut_ptr());
        assert_eq!(
            quadcal_edges(&raw mut all, from, captures.len(), to, &raw mut edges),
            QUADCAL_OK
        );
    }
    assert_eq!((found, edges), (59, 59));
    assert!(single == batch);
    // A thousandth of a turn in 1000 ticks.
    assert!((speed as f64 / 2_f64.powi(60) * 1e6 - 1.0).abs() < 1e-8);
}

#[test]
fn bytes_that_are_no_table_are_refused() {
    let mut encoder = started();
    let mut bytes = vec![0_u8; 3000];
    // SAFETY: the bytes are there, and the encoder is gone before them.
    assert_eq!(
        unsafe { quadcal_set_table(&raw mut encoder, bytes.as_ptr(), bytes.len()) },
        QUADCAL_ERROR_TABLE
    );
    bytes[..12].copy_from_slice(b"QCTB\x03\0\x04\0\xe8\x03\0\0");
    // SAFETY: as before.
    assert_eq!(
        unsafe { quadcal_set_table(&raw mut encoder, bytes.as_ptr(), bytes.len()) },
        QUADCAL_ERROR_TABLE_CRC
    );
}

#[test]
fn a_learner_refuses_little_memory_and_steps_out_of_order() {
    let config = quadcal_usual_config(90, 16, 1_000_000);
    // SAFETY: all zeros is a learner that was not started.
    let mut learner: Box<quadcal_learner> = Box::new(unsafe { std::mem::zeroed() });
    let learner = &raw mut *learner;
    let mut memory = vec![0_u32; quadcal_learn_bytes(90) / 4];
    assert_eq!(memory.len() * 4, 24 * 90 + 12 * 1024);
    assert_eq!(quadcal_learn_bytes(0), 0);
    let mut table = [0_u8; 884];
    let mut length = 0;
    // SAFETY: everything is there, here and below.
    unsafe {
        let samples = quadcal_learn_samples(learner, null(), 0, null_mut());
        assert_eq!(samples, QUADCAL_ERROR_NOT_INITIALISED);
        let start = |bytes: usize, memory: *mut u32| {
            quadcal_learn_start(learner, &raw const config, memory, bytes)
        };
        assert_eq!(
            start(4 * memory.len() - 4, memory.as_mut_ptr()),
            QUADCAL_ERROR_MEMORY
        );
        assert_eq!(start(4 * memory.len(), memory.as_mut_ptr()), QUADCAL_OK);
        assert_eq!(
            quadcal_learn_samples(learner, null(), 0, null_mut()),
            QUADCAL_OK
        );
        assert_eq!(
            quadcal_learn_slice(learner, null_mut()),
            QUADCAL_ERROR_TOO_FEW_TURNS
        );
        let out = quadcal_learn_table(learner, table.as_mut_ptr(), table.len(), &raw mut length);
        assert_eq!(out, QUADCAL_ERROR_STAGE);
    }
}
