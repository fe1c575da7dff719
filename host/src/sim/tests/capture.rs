//! Rows, seeds, faults and the timer.

use super::*;

#[test]
fn the_same_seed_gives_the_same_run_and_noise_leaves_the_disc_alone() {
    let quiet = Twin {
        duration: Duration::Turns(0.5),
        ..Twin::paper()
    };
    let noisy = Twin {
        noise: wander(0.01),
        ..quiet.clone()
    };
    let other = Twin {
        seed: 2,
        ..noisy.clone()
    };
    let run = |twin| Simulation::new(twin).unwrap();
    assert!(run(&noisy).eq(run(&noisy)));
    assert!(!run(&noisy).eq(run(&other)));
    assert_eq!(run(&noisy).true_errors(), run(&quiet).true_errors());
    assert_ne!(run(&noisy).true_errors(), run(&other).true_errors());
}

#[test]
fn lost_edges_leave_gaps_and_glitches_add_pairs_of_rows() {
    let clean = plain(15.0, 1.0);
    let all: Vec<Event> = Simulation::new(&clean).unwrap().collect();
    let mut lossy = clean.clone();
    lossy.faults.lost_edges = vec![500, 10];
    let left: Vec<Event> = Simulation::new(&lossy).unwrap().collect();
    assert_eq!(left.len(), all.len() - 2);
    assert!(
        left.iter().all(|event| all.contains(event)),
        "what is left is as it was"
    );

    let mut glitchy = clean.clone();
    glitchy.faults.glitch_probability = 0.01;
    glitchy.faults.glitch_width_s = 1e-6;
    let rows: Vec<Event> = Simulation::new(&glitchy).unwrap().collect();
    let glitches = rows
        .iter()
        .filter(|e| e.truth.class == Class::Glitch)
        .count();
    // 10,000 edges at 1 %, two rows each; 5 standard deviations is 50 glitches.
    assert!(
        (100..=300).contains(&glitches) && glitches % 2 == 0,
        "{glitches} rows"
    );
    assert_eq!(rows.len(), all.len() + glitches);
    assert!(rows.windows(2).all(|w| w[0].row.ticks <= w[1].row.ticks));
    assert_eq!(
        rows.last().unwrap().row.levels,
        all.last().unwrap().row.levels
    );

    let mut deaf = clean;
    deaf.faults.lost_probability = 1.0;
    assert!(
        Simulation::new(&deaf)
            .unwrap()
            .all(|e| e.truth.edge.is_none())
    );
}

#[test]
fn jitter_has_its_rms_and_time_never_falls() {
    let mut twin = plain(15.0, 1.0);
    twin.timer.jitter_s = 2e-6;
    let (mut sum, mut count, mut last) = (0.0, 0.0, 0);
    for event in Simulation::new(&twin).unwrap() {
        assert!(event.row.ticks >= last);
        last = event.row.ticks;
        let late = (event.row.ticks as f64 + 0.5) / 84e6 - event.truth.time_s;
        sum += late * late;
        count += 1.0;
    }
    // 1e4 samples give the RMS to 0.7 %.
    assert!(((sum / count).sqrt() / 2e-6 - 1.0).abs() < 0.04);
}

#[test]
fn raw_captures_wrap_at_the_registers_width() {
    let mut twin = plain(15.0, 0.1);
    let full: Vec<Sample> = Simulation::new(&twin).unwrap().map(|e| e.row).collect();
    twin.timer.bits = 16;
    twin.timer.raw_captures = true;
    let raw: Vec<Sample> = Simulation::new(&twin).unwrap().map(|e| e.row).collect();
    assert!(full.last().unwrap().ticks > 65_536);
    assert!(
        full.iter()
            .zip(&raw)
            .all(|(f, r)| f.ticks & 0xffff == r.ticks && f.levels == r.levels)
    );
}

/// FNV-1a over a run's ticks and levels.
fn fingerprint(twin: &Twin) -> u64 {
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for event in Simulation::new(twin).unwrap() {
        let bytes = event.row.ticks.to_le_bytes().into_iter();
        for byte in bytes.chain([event.row.levels.0]) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    hash
}

#[test]
fn the_bytes_of_a_seed_are_these_on_every_machine() {
    let wandering = Twin {
        noise: wander(0.01),
        duration: Duration::Turns(1.0),
        ..Twin::paper()
    };
    let mut looped = Twin {
        drive: speed_loop(15.0, 100.0),
        ..wandering.clone()
    };
    looped.noise = None;
    looped.timer.jitter_s = 1e-7;
    looped.faults.glitch_probability = 1e-3;
    looped.faults.glitch_width_s = 1e-6;
    looped.faults.lost_probability = 1e-3;
    assert_eq!(fingerprint(&wandering), 14_484_735_683_777_608_739);
    assert_eq!(fingerprint(&looped), 7_359_694_084_519_742_043);
}
