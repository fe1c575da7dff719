//! Speeds against exact quotients, corrections, stops and withdrawn steps.

use super::*;
use proptest::prelude::*;

const CLOCK: f64 = 84e6;

fn step(ticks: Ticks, interval: u32) -> Step {
    Step {
        ticks,
        edge: 0,
        position: 0,
        interval,
        resync: 0,
        advance: 1,
        flags: Flags::NONE,
        direction: Direction::Forward,
    }
}

fn interval(slots: u32) -> Interval {
    Interval::new(IntervalConfig::new(slots, 84_000_000))
}

#[test]
fn speeds_from_15_to_6000_rpm_come_out_within_the_bound() {
    for rpm in [15.0, 120.0, 1000.0, 6000.0] {
        let ticks = (CLOCK * 60.0 / rpm / 10_000.0f64).round() as u32;
        let exact = CLOCK * 60.0 / 10_000.0 / f64::from(ticks);
        let mut interval = interval(10_000);
        interval.push(&step(1_000_000, ticks), ErrorChange::NONE);
        let next = step(1_000_000 + u64::from(ticks), ticks);
        interval.push(&next, ErrorChange::NONE);
        for speed in [interval.x4(), interval.x2(ErrorChange::NONE)] {
            let error = speed.unwrap().rpm(CLOCK) / exact - 1.0;
            assert!(error.abs() < 1.01 * Recip::ERROR, "{rpm}: {error:e}");
        }
    }
}

#[test]
fn known_edge_errors_leave_the_speed_as_it_is() {
    // Grid step 2^22 in Turn32; the middle edge comes early by an eighth of a step.
    let mut interval = interval(1024);
    let early = ErrorChange::from_to(TurnDelta32(0), TurnDelta32(1 << 19));
    let back = ErrorChange::from_to(early.angle(), TurnDelta32(0));
    interval.push(&step(0, u32::MAX), ErrorChange::NONE);
    assert_eq!(interval.x4(), None);
    interval.push(&step(7000, 7000), early);
    let short = interval.x4();
    assert_eq!(interval.x2(early), None);
    interval.push(&step(16_000, 9000), back);
    let long = interval.x4();
    let exact = (1i64 << 50) / 8000;
    for speed in [short, long, interval.x2(ErrorChange::NONE)] {
        let speed = speed.unwrap().0;
        assert!((speed - exact).abs() <= exact >> 28, "{speed} {exact}");
    }
}

#[test]
fn known_delays_leave_the_speed_as_it_is_at_a_coarse_clock() {
    // 12 edges a turn, 5 ticks apart; every other edge is captured 2 ticks late.
    let exact = (1i64 << 60) / 12 / 5;
    let whole = [(3, -512), (7, 512)];
    let mut interval = interval(12);
    for (k, (ticks, stretch)) in (0_u64..100).zip(whole.into_iter().cycle()) {
        interval.push_delayed(&step(5 * k, ticks), ErrorChange::NONE, TickDelta8(stretch));
        let both = if k == 0 {
            None
        } else {
            interval.x2(ErrorChange::NONE)
        };
        for speed in interval.x4().into_iter().chain(both) {
            assert!(
                (speed.0 - exact).abs() <= exact >> 27,
                "{} {exact}",
                speed.0
            );
        }
    }
    // 4 ticks of which 0.625 are delay: 3.375 ticks.
    interval.push_delayed(&step(504, 4), ErrorChange::NONE, TickDelta8(160));
    let speed = interval.x4().unwrap().0;
    let exact = ((1i64 << 60) / 12 / 27) * 8;
    assert!((speed - exact).abs() <= exact >> 27, "{speed} {exact}");
}

#[test]
fn a_stopped_shaft_slows_down_as_one_over_time_and_then_stands() {
    let mut interval = interval(1000);
    interval.push(&step(1000, u32::MAX), ErrorChange::NONE);
    interval.push(&step(2000, 1000), ErrorChange::NONE);
    let speed = interval.x4().unwrap();
    assert_eq!(interval.speed_at(2900), speed);
    let later = interval.speed_at(2000 + 4000);
    assert!((later.0 * 4 - speed.0).abs() <= speed.0 >> 27);
    assert_eq!(interval.speed_at(2000 + 84_000_000), Speed::ZERO);
}

#[test]
fn a_reversal_has_no_mean_speed_and_reverse_motion_a_negative_one() {
    let mut interval = interval(1000);
    interval.push(&step(1000, 1000), ErrorChange::NONE);
    let back = Step {
        flags: Flags::REVERSED,
        direction: Direction::Reverse,
        ..step(3000, 2000)
    };
    interval.push(&back, ErrorChange::NONE);
    assert_eq!(interval.x4(), Some(Speed::ZERO));
    assert_eq!(interval.x2(ErrorChange::NONE), None);
    let on = Step {
        direction: Direction::Reverse,
        ..step(4000, 1000)
    };
    interval.push(&on, ErrorChange::NONE);
    assert!(interval.x4().unwrap() < Speed::ZERO);
    assert_eq!(interval.x2(ErrorChange::NONE), None);
}

#[test]
fn a_withdrawn_step_leaves_the_speed_before_it() {
    let mut interval = interval(1000);
    interval.push(&step(1000, 1000), ErrorChange::NONE);
    interval.push(&step(2000, 1000), ErrorChange::NONE);
    let before = interval.speed_at(2500);
    interval.push(&step(2100, 100), ErrorChange::NONE);
    interval.withdraw();
    assert_eq!(interval.speed_at(2500), before);
    interval.push(&step(3000, 1000), ErrorChange::NONE);
    assert_eq!(interval.x4(), Some(before));
}

proptest! {
    #[test]
    fn no_step_and_no_time_makes_it_panic(
        steps in prop::collection::vec((any::<u64>(), any::<u32>(), any::<u16>(), any::<u16>(), any::<i32>(), any::<i32>()), 1..50),
        slots: u32
    ) {
        let mut interval = Interval::new(IntervalConfig::new(slots, 1 << 40));
        for (ticks, duration, advance, flags, error, stretch) in steps {
            let direction = if error < 0 { Direction::Reverse } else { Direction::Forward };
            let step = Step { advance, flags: Flags(flags), direction, ..step(ticks, duration) };
            let error = ErrorChange::from_to(TurnDelta32(0), TurnDelta32(error));
            interval.push_delayed(&step, error, TickDelta8(stretch));
            let _ = interval.x4();
            let _ = interval.x2(error);
            let later = ticks.wrapping_add(u64::from(duration));
            let _ = interval.speed_at(later);
            interval.withdraw();
        }
    }
}
