use super::*;
use crate::estimate::cursor::whole;
use crate::estimate::locked::NoiseShares;
use crate::estimate::speeds::Place;

const TURN: u64 = 1_000_000;

/// Turns as they come, noise of their own.
struct Run {
    agreement: Agreement,
    speeds: Speeds,
    random: u32,
}

impl Run {
    /// Before the first turn.
    const NEW: Self = Self {
        agreement: Agreement::NONE,
        speeds: Speeds::NONE,
        random: 1,
    };

    /// After some turns that agree.
    fn settled() -> Self {
        let mut run = Self::NEW;
        run.speeds.place(TURN).unwrap();
        for _ in 0..6 {
            assert!(run.take(TURN, 1000, [0; LOW_ORDERS]));
        }
        run
    }

    fn noise(&mut self, size: i32) -> i32 {
        self.random = self
            .random
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        ((self.random >> 8) % (2 * size as u32)) as i32 - size
    }

    /// Hands on a turn with noise of a size at order 1 and accordingly less above, and a pattern of its own; whether it was taken.
    fn take(&mut self, duration: u64, noise: i32, pattern: [i32; LOW_ORDERS]) -> bool {
        let Place { bin, ratio_q32 } = self.speeds.place(duration).unwrap();
        let low = core::array::from_fn(|index| {
            let size = noise / (index as i32 + 1).pow(2);
            LowOrder {
                re: 40_000 + pattern[index] + self.noise(size),
                im: self.noise(size),
            }
        });
        let turn = Seen {
            duration,
            ratio_q32,
            direction: Direction::Forward,
            bin,
            low,
        };
        let agrees = !self.agreement.off(&turn, &self.speeds).far;
        if !agrees && self.agreement.reject(turn, &self.speeds) {
            return false;
        }
        self.agreement.take(turn, agrees, &mut self.speeds);
        true
    }

    fn pairs(&self) -> u16 {
        self.speeds.bins.iter().map(|bin| bin.pairs).sum()
    }
}

const STEP_UP: [i32; LOW_ORDERS] = [30_000, 4000, -900, 500, 300, 200];
const STEP_DOWN: [i32; LOW_ORDERS] = [-30_000, 4000, 900, 500, -300, 200];

#[test]
fn every_turn_of_a_load_that_comes_and_goes_is_rejected_and_those_beside_it_are_not() {
    let mut run = Run::settled();
    for pattern in [STEP_UP, STEP_DOWN] {
        assert!(!run.take(TURN, 1000, pattern));
    }
    let pairs = run.pairs();
    assert!(run.take(TURN, 1000, [0; LOW_ORDERS]));
    assert_eq!(run.pairs(), pairs + 1, "paired with the one taken last");
}

#[test]
fn a_turn_slower_by_a_ninth_is_compared_too_and_may_have_more_torque() {
    let mut run = Run::settled();
    let slower = TURN + TURN / 9;
    assert!(!run.take(slower, 1000, STEP_UP));
    // All of the pattern torque: 23 % more of it.
    assert!(run.take(slower, 1000, [9000; LOW_ORDERS]));
}

#[test]
fn where_the_scatter_of_a_speed_is_not_known_that_of_the_speed_before_counts() {
    let mut run = Run::settled();
    let slower = TURN + TURN / 4;
    let bins = [TURN, slower].map(|duration| run.speeds.place(duration).unwrap().bin);
    assert_ne!(bins[0], bins[1]);
    assert!(!run.take(slower, 1000, STEP_UP.map(|part| 2 * part)));
    assert!(run.take(slower, 2000, [0; LOW_ORDERS]));
}

#[test]
fn a_pattern_that_stays_is_taken_the_fourth_time_and_is_no_scatter() {
    let mut run = Run::settled();
    let before = run.speeds.bins.map(|bin| bin.scatter);
    let taken: [bool; 6] = core::array::from_fn(|_| run.take(TURN, 1000, STEP_UP));
    assert_eq!(taken, [false, false, false, true, true, true]);
    let after = run.speeds.bins.map(|bin| bin.scatter);
    let sum = |bins: &[[u64; LOW_ORDERS]]| bins.iter().map(weighed).sum::<u128>();
    assert!(sum(&after) < 3 * sum(&before));
}

#[test]
fn turns_that_stay_rough_are_taken_in_the_end_and_said_to_scatter() {
    let mut run = Run::settled();
    let level_before = run.speeds.bins.map(|bin| weighed(&bin.scatter));
    let taken: [bool; 40] = core::array::from_fn(|_| run.take(TURN, 30_000, [0; LOW_ORDERS]));
    assert!(taken[..4].iter().all(|taken| !taken));
    assert!(taken[20..].iter().all(|&taken| taken), "{taken:?}");
    let level_after = run.speeds.bins.map(|bin| weighed(&bin.scatter));
    let grown = level_after.iter().sum::<u128>() / level_before.iter().sum::<u128>();
    assert!(grown > 300, "{grown}");
}

#[test]
fn coarse_time_stamps_that_scatter_for_hundreds_of_turns_reject_none() {
    // A clock of 375 ticks a turn: a tick is 2^36 / 375 at each order.
    let mut run = Run::NEW;
    for _ in 0..400 {
        let tick = core::array::from_fn(|_| run.noise(45_000_000));
        assert!(run.take(375, 1000, tick));
    }
    assert_eq!(run.pairs(), 399);
}

#[test]
fn torque_that_grows_as_the_shaft_slows_is_no_scatter() {
    let mut run = Run::NEW;
    run.speeds.place(TURN).unwrap();
    for turn in 0..30 {
        let duration = TURN + turn * TURN / 100;
        // 30 million at the first turn's speed: 600,000 more in each turn, of which noise is a six-hundredth.
        let square = (duration as f64 / TURN as f64).powi(2);
        let locked = (3e7 * square) as i32;
        assert!(run.take(duration, 1000, [locked; LOW_ORDERS]), "{turn}");
    }
    assert!(run.pairs() > 24, "{}", run.pairs());
    let scatter: u64 = run.speeds.bins.iter().map(|bin| bin.scatter[0]).sum();
    let mut shares = NoiseShares::START;
    whole(|| shares.slice(&run.speeds.locked));
    let [noise, ..] = shares.of(&[scatter; LOW_ORDERS]);
    let of_pair = noise / u64::from(run.pairs());
    // Twice two parts of a uniform noise of 1000.
    assert!(scatter / u64::from(run.pairs()) > 1 << 38);
    assert!((600_000..3_000_000).contains(&of_pair), "{of_pair}");
}
