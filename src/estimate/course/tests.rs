//! Motions whose crossings are known exactly.

use super::*;

const PLACE: Place = Place {
    bin: crate::estimate::speeds::BINS / 2,
    ratio_q32: 1 << 32,
};
const FINE: Fine = Fine { bits: 10 };
/// 2^-32 turn in one of those fine angles.
const TURN: f64 = 4_398_046_511_104.0;

/// A motion: the time of an angle in turns, ticks, and the angle of a time.
struct Motion {
    time: fn(f64) -> f64,
    angle: fn(f64) -> f64,
}

/// The speed falls with the angle: 1.5 % a turn at first.
const VISCOUS: Motion = Motion {
    time: |angle| -1e12 * (-0.015 * angle).ln_1p(),
    angle: |time| -(-time / 1e12).exp_m1() / 0.015,
};

/// The speed falls with the time, by as much.
const COULOMB: Motion = Motion {
    time: |angle| 1e12 * (1.0 - (1.0 - 0.03 * angle).sqrt()),
    angle: |time| (2.0 * time / 1e12 - (time / 1e12).powi(2)) / 0.03,
};

const STEADY: Motion = Motion {
    time: |angle| 1e10 * angle,
    angle: |time| time / 1e10,
};

const FOLDED: core::ops::Range<i32> = 1..21;

fn duration(motion: &Motion, turn: i32) -> u64 {
    let time = |turn: i32| (motion.time)(turn.into()) as u64;
    time(turn + 1) - time(turn)
}

fn bend(motion: &Motion, turn: i32) -> i32 {
    crate::estimate::fold::Motion::bend_q32(duration(motion, turn - 1), duration(motion, turn))
}

/// What the course says of all turns' plain mean.
fn curve(motion: &Motion, direction: Direction) -> Curve {
    let weighing = Weighing::NEW;
    let mut course = Course::NONE;
    for turn in FOLDED {
        let of_turn = (duration(motion, turn), direction, PLACE);
        let before = duration(motion, turn - 1);
        course.take(of_turn, Some(before), bend(motion, turn), &weighing);
    }
    course.end(&weighing);
    let count = FOLDED.len() as u32;
    let weight = weighing.weight_q16(PLACE.bin) * u64::from(count);
    let [weighed, plain] = course.curves(weight, count, FINE);
    assert!(
        weighed
            .0
            .iter()
            .zip(plain.0)
            .all(|(w, p)| w.abs_diff(p) < 1000)
    );
    plain
}

/// What the turns, folded with their bends, are off at a place on the way, mean over all of them, turns.
fn off(motion: &Motion, place: f64) -> f64 {
    let offs = FOLDED.map(|turn| {
        let start = (motion.time)(turn.into());
        let length = (motion.time)(f64::from(turn + 1)) - start;
        let bend = f64::from(bend(motion, turn)) / 4_294_967_296.0;
        // The time at which the fold has the shaft at the place.
        let time = (0..60).fold(place, |t, _| place + bend * t * (1.0 - t));
        (motion.angle)(start + time * length) - f64::from(turn) - place
    });
    offs.sum::<f64>() / f64::from(FOLDED.len() as u32)
}

#[test]
fn what_viscous_friction_bends_is_told_to_a_thousandth() {
    let curve = curve(&VISCOUS, Direction::Forward);
    let largest = off(&VISCOUS, 0.58).abs();
    assert!(largest > 2e-5, "{largest}");
    for part in 0..16_u32 {
        let exact = off(&VISCOUS, f64::from(part) / 16.0);
        let told = curve.at(Turn32(part << 28)) as f64 / TURN;
        assert!(
            (told - exact).abs() < 1e-3 * largest,
            "{part}: {told:e} {exact:e}"
        );
    }
}

#[test]
fn constant_speed_and_constant_acceleration_are_nothing() {
    for motion in [STEADY, COULOMB] {
        let curve = curve(&motion, Direction::Forward);
        for part in 0..16_u32 {
            let told = curve.at(Turn32(part << 28)) as f64 / TURN;
            assert!(told.abs() < 2e-9, "{part}: {told:e}");
        }
    }
}

#[test]
fn a_turn_backward_is_passed_from_its_other_end() {
    let [ahead, back] = [Direction::Forward, Direction::Reverse].map(|way| curve(&VISCOUS, way));
    for part in 1..16_u32 {
        let there = ahead.at(Turn32(part << 28));
        let told = back.at(Turn32(0_u32.wrapping_sub(part << 28)));
        assert!((there + told).abs() < 1 << 10, "{part}: {there} {told}");
    }
}

#[test]
fn turns_that_stand_alone_say_nothing() {
    let weighing = Weighing::NEW;
    let mut course = Course::NONE;
    for turn in FOLDED {
        course.take(
            (duration(&VISCOUS, turn), Direction::Forward, PLACE),
            None,
            0,
            &weighing,
        );
        course.end(&weighing);
    }
    assert_eq!(course.curves(1 << 16, 20, FINE), [Curve::NONE; 2]);
}
