use quadcal::edge::Levels;

use super::*;

/// Extends the captures the way a drive must, from the records alone.
fn extend(events: &Events, timer: TimerWidth) -> Vec<Sample> {
    let period = Ticks::from(timer.max()) + 1;
    let mut high = events.base;
    let mut samples = Vec::new();
    for event in &events.events {
        match *event {
            Event::Overflow => high += period,
            Event::Capture {
                raw,
                levels,
                overflow_pending,
            } => {
                let after_wrap = overflow_pending && Ticks::from(raw) < period / 2;
                let ticks = high + Ticks::from(raw) + if after_wrap { period } else { 0 };
                samples.push(Sample { ticks, levels });
            }
        }
    }
    samples
}

fn shaft(count: u64, seed: u64, longest: u64) -> Vec<Sample> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut ticks = 1_000_003;
    (0..count)
        .map(|index| {
            ticks += random.random_range(0..=longest);
            Sample {
                ticks,
                levels: Levels((index % 8) as u8),
            }
        })
        .collect()
}

#[test]
fn samples_come_back_from_the_records_whatever_the_latency() {
    for (timer, longest) in [
        (TimerWidth::Bits16, 300),
        (TimerWidth::Bits16, 40_000),
        (TimerWidth::Bits16, 1_000_000),
        (TimerWidth::Bits32, 3_000_000_000),
    ] {
        for seed in 0..20 {
            let samples = shaft(3000, seed, longest);
            for latency in [
                Latency::NONE,
                Latency { max: 900, seed },
                Latency::longest(timer, seed),
            ] {
                assert_eq!(
                    extend(&events(&samples, timer, latency), timer),
                    samples,
                    "{timer:?} {longest} {latency:?}"
                );
            }
        }
    }
}

#[test]
fn both_sides_of_the_overflow_race_occur() {
    let timer = TimerWidth::Bits16;
    let made = events(&shaft(20_000, 1, 4000), timer, Latency::longest(timer, 1));
    let pending = |above: bool| {
        let raced = |event: &&Event| matches!(event, Event::Capture { raw, overflow_pending: true, .. } if (*raw >= 0x8000) == above);
        made.events.iter().filter(raced).count()
    };
    let wraps = made
        .events
        .iter()
        .filter(|event| **event == Event::Overflow)
        .count();
    assert!(wraps > 500, "{wraps} wraps");
    assert!(
        pending(false) > wraps / 10,
        "{} captures after a wrap not yet served",
        pending(false)
    );
    assert!(
        pending(true) > wraps / 10,
        "{} captures before a wrap, served after it",
        pending(true)
    );
}

#[test]
fn a_stopped_shaft_still_overflows() {
    let timer = TimerWidth::Bits16;
    let at = |ticks| Sample {
        ticks,
        levels: Levels(0),
    };
    let made = events(
        &[at(70_000), at(70_000 + 10 * 65_536)],
        timer,
        Latency::NONE,
    );
    assert_eq!(made.base, 65_536);
    assert_eq!(made.events.len(), 12);
    assert_eq!(
        made.events
            .iter()
            .filter(|event| **event == Event::Overflow)
            .count(),
        10
    );
}

#[test]
fn no_samples_make_no_events() {
    assert_eq!(events(&[], TimerWidth::Bits32, Latency::NONE).events, []);
}
