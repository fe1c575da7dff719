extern crate std;

use std::vec::Vec;

use proptest::prelude::*;

use super::*;

/// Weights of the least-squares fit at the centre by modified Gram-Schmidt on the powers of `j / half`, orthogonalised twice.
fn reference(window: usize, order: usize) -> Vec<f64> {
    let half = (window / 2) as f64;
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for power in 0..=order {
        let mut column: Vec<f64> = (0..window)
            .map(|i| ((i as f64 - half) / half).powi(power as i32))
            .collect();
        for _ in 0..2 {
            for unit in &basis {
                let along: f64 = unit.iter().zip(&column).map(|(u, c)| u * c).sum();
                column
                    .iter_mut()
                    .zip(unit)
                    .for_each(|(c, u)| *c -= along * u);
            }
        }
        let length = column.iter().map(|c| c * c).sum::<f64>().sqrt();
        column.iter_mut().for_each(|c| *c /= length);
        basis.push(column);
    }
    (0..window)
        .map(|i| basis.iter().map(|unit| unit[window / 2] * unit[i]).sum())
        .collect()
}

/// A stretch of pseudo-random samples, arithmetic-shifted right by `shift`.
fn noise(seed: u64, length: usize, shift: u32) -> impl Iterator<Item = i32> {
    let mut state = seed | 1;
    (0..length).map(move |_| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        ((state >> 32) as i32) >> shift
    })
}

fn agrees_with_the_fit<const W: usize, const O: usize>() {
    let weights = reference(W, O);
    for seed in 1..4 {
        let samples: Vec<i32> = noise(seed, 3 * W, 2).collect();
        let mut filter = SavGol::<W, O>::new();
        for (i, &sample) in samples.iter().enumerate() {
            let smoothed = filter.push(sample);
            assert_eq!(smoothed.is_some(), i + 1 >= W);
            let Some(smoothed) = smoothed else { continue };
            let window = &samples[i + 1 - W..=i];
            let fit: f64 = weights
                .iter()
                .zip(window)
                .map(|(w, &x)| w * f64::from(x))
                .sum();
            assert!((f64::from(smoothed) - fit).abs() < 0.501, "{W}/{O} at {i}");
        }
    }
}

#[test]
fn output_is_within_half_a_digit_of_the_f64_least_squares_fit() {
    agrees_with_the_fit::<3, 0>();
    agrees_with_the_fit::<5, 2>();
    agrees_with_the_fit::<5, 4>();
    agrees_with_the_fit::<7, 3>();
    agrees_with_the_fit::<31, 5>();
    agrees_with_the_fit::<101, 5>();
    agrees_with_the_fit::<301, 5>();
    agrees_with_the_fit::<701, 5>();
}

fn reproduces<const W: usize, const O: usize>(scale: i64) {
    let mut filter = SavGol::<W, O>::new();
    let half = (W / 2) as i64;
    // Binomials are integers of degree k; alternating signs keep every order in play.
    let polynomial = |i: i64| {
        let x = i - half;
        let mut binomial = 1;
        let mut value = 7;
        for k in 1..=O as i64 {
            binomial = binomial * (x - k + 1) / k;
            value += if k % 2 == 0 { binomial } else { -binomial };
        }
        i32::try_from(value * scale).unwrap()
    };
    for i in 0..2 * W as i64 {
        if let Some(smoothed) = filter.push(polynomial(i)) {
            assert_eq!(smoothed, polynomial(i - half), "{W}/{O} at {i}");
        }
    }
}

#[test]
fn polynomials_up_to_the_order_pass_exactly() {
    reproduces::<5, 2>(1000);
    reproduces::<7, 3>(1000);
    reproduces::<31, 5>(100);
    reproduces::<101, 4>(1);
    reproduces::<301, 3>(1);
}

#[test]
fn odd_order_is_the_even_one_below() {
    let (mut odd, mut even) = (SavGol::<31, 5>::new(), SavGol::<31, 4>::new());
    for sample in noise(5, 500, 0) {
        assert_eq!(odd.push(sample), even.push(sample));
    }
}

#[test]
fn default_turns_the_alternating_frequency_round_at_six_percent() {
    let mut filter = DefaultSavGol::new();
    let amplitude = 1 << 24;
    for i in 0..100 {
        let at = |i: usize| {
            if i.is_multiple_of(2) {
                amplitude
            } else {
                -amplitude
            }
        };
        if let Some(smoothed) = filter.push(at(i)) {
            let response = f64::from(smoothed) / f64::from(at(i - DefaultSavGol::delay()));
            assert!((response + 0.0614).abs() < 1e-4, "{response}");
        }
    }
}

fn holds_a_constant<const W: usize, const O: usize>() {
    for constant in [i32::MIN, -1, 0, 1, 123_456_789, i32::MAX] {
        let mut filter = SavGol::<W, O>::new();
        let last = (0..2 * W)
            .filter_map(|_| filter.push(constant))
            .collect::<Vec<_>>();
        assert_eq!(last.len(), W + 1);
        assert!(last.iter().all(|&smoothed| smoothed == constant));
    }
}

#[test]
fn constant_comes_out_exactly() {
    holds_a_constant::<5, 2>();
    holds_a_constant::<31, 5>();
    holds_a_constant::<101, 5>();
    holds_a_constant::<301, 5>();
}

#[test]
fn million_samples_leave_no_drift() {
    let mut used = SavGol::<301, 5>::new();
    let mut narrow = SavGol::<101, 5>::new();
    for sample in noise(11, 1_000_000, 0) {
        used.push_recursive(sample);
        narrow.push_recursive(sample);
    }
    let (mut fresh, mut fresh_narrow) = (SavGol::<301, 5>::new(), SavGol::<101, 5>::new());
    for sample in noise(12, 1000, 0) {
        let smoothed = (used.push_recursive(sample), narrow.push_recursive(sample));
        if let Some(expected) = fresh.push_direct(sample) {
            assert_eq!(smoothed.0, Some(expected));
        }
        if let Some(expected) = fresh_narrow.push_direct(sample) {
            assert_eq!(smoothed.1, Some(expected));
        }
    }
}

#[test]
fn reset_forgets_everything() {
    let mut filter = DefaultSavGol::new();
    noise(3, 100, 0).for_each(|sample| {
        filter.push(sample);
    });
    filter.reset();
    let outputs: Vec<_> = (0..31).map(|_| filter.push(-9)).collect();
    assert!(outputs[..30].iter().all(Option::is_none));
    assert_eq!(outputs[30], Some(-9));
}

/// Both forms give the same, which is the exact rational sum rounded, or saturated beyond `i32`.
fn forms_agree<const W: usize, const O: usize>(samples: &[i32]) -> Result<(), TestCaseError> {
    let weights = Weights::new(W, O);
    let numerators: Vec<i128> = (0..W as i128).map(|age| weights.at(age)).collect();
    let (mut recursive, mut direct) = (SavGol::<W, O>::new(), SavGol::<W, O>::new());
    for (i, &sample) in samples.iter().enumerate() {
        let smoothed = recursive.push_recursive(sample);
        prop_assert_eq!(smoothed, direct.push_direct(sample));
        let Some(smoothed) = smoothed else { continue };
        let window = samples[i + 1 - W..=i].iter().rev();
        let sum: i128 = numerators
            .iter()
            .zip(window)
            .map(|(n, &x)| n * i128::from(x))
            .sum();
        let limit = |end: i32| i128::from(end) * weights.denominator;
        let off = i128::from(smoothed) * weights.denominator
            - sum.clamp(limit(i32::MIN), limit(i32::MAX));
        // 0.5 + 2^-25 of the denominator.
        prop_assert!(off.abs() << 25 <= weights.denominator * ((1 << 24) + 1));
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn recursive_and_direct_are_bit_equal_over_all_of_i32(
        samples in prop::collection::vec(
            prop_oneof![any::<i32>(), Just(i32::MIN), Just(i32::MAX)],
            700,
        ),
    ) {
        forms_agree::<3, 2>(&samples)?;
        forms_agree::<5, 2>(&samples)?;
        forms_agree::<7, 3>(&samples)?;
        forms_agree::<31, 5>(&samples)?;
        forms_agree::<101, 5>(&samples)?;
        forms_agree::<301, 5>(&samples)?;
    }
}

/// Samples at the ends of `i32` with the signs of the weights make the largest sum there can be.
#[test]
fn worst_signs_saturate_in_both_forms() {
    fn worst<const W: usize, const O: usize>() {
        let weights = Weights::new(W, O);
        let (mut recursive, mut direct) = (SavGol::<W, O>::new(), SavGol::<W, O>::new());
        for sign in [1, -1] {
            let mut last = (None, None);
            for age in (0..W as i128).rev() {
                let up = weights.at(age) * sign > 0;
                let sample = if up { i32::MAX } else { i32::MIN };
                last = (recursive.push_recursive(sample), direct.push_direct(sample));
            }
            let expected = if sign > 0 { i32::MAX } else { i32::MIN };
            assert_eq!(last, (Some(expected), Some(expected)));
        }
    }
    worst::<31, 5>();
    worst::<101, 5>();
    worst::<301, 5>();
}
