//! The smoother against least squares in f64 and against its own direct form.

use super::*;
use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

/// Middle value of the least-squares polynomial through `x`, by modified Gram-Schmidt on scaled powers.
fn least_squares(x: &[f64], order: usize) -> f64 {
    let half = (x.len() / 2) as f64;
    let at = |u: usize| (u as f64 - half) / half;
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut value = 0.0;
    for degree in 0..=order {
        let mut column: Vec<f64> = (0..x.len()).map(|u| at(u).powi(degree as i32)).collect();
        for _ in 0..2 {
            for unit in &basis {
                let dot: f64 = unit.iter().zip(&column).map(|(a, b)| a * b).sum();
                column.iter_mut().zip(unit).for_each(|(c, u)| *c -= dot * u);
            }
        }
        let norm = column.iter().map(|c| c * c).sum::<f64>().sqrt();
        column.iter_mut().for_each(|c| *c /= norm);
        let part: f64 = column.iter().zip(x).map(|(a, b)| a * b).sum();
        value += part * column[x.len() / 2];
        basis.push(column);
    }
    value
}

fn outputs<const W: usize, const O: usize>(input: &[i32]) -> Vec<i32> {
    let mut filter = SavGol::<W, O>::new();
    input.iter().filter_map(|&x| filter.push(x)).collect()
}

fn agrees_with_least_squares<const W: usize, const O: usize>(input: &[i32]) {
    let outputs = outputs::<W, O>(input);
    assert_eq!(outputs.len(), input.len() - W + 1);
    for (window, output) in input.windows(W).zip(outputs) {
        let window: Vec<f64> = window.iter().map(|&x| f64::from(x)).collect();
        let exact = least_squares(&window, O);
        assert!(
            (f64::from(output) - exact).abs() <= 0.5 + 1e-4,
            "{W}/{O}: {output} for {exact}"
        );
    }
}

/// The numerator as a plain sum over the window.
fn direct<const W: usize, const O: usize>(filter: &SavGol<W, O>, taps: &[i64]) -> i64 {
    let (newer, older) = filter.ring.split_at(filter.oldest);
    let samples = older.iter().chain(newer);
    samples.zip(taps).map(|(&x, c)| c * i64::from(x)).sum()
}

fn forms_agree<const W: usize, const O: usize>(input: &[i32]) {
    let mut filter = SavGol::<W, O>::new();
    let taps: Vec<i64> = (0..W).map(SavGol::<W, O>::coefficient).collect();
    for &x in input {
        let x = x.clamp(-SavGol::<W, O>::INPUT_MAX, SavGol::<W, O>::INPUT_MAX);
        let leaving = filter.replace_oldest(x);
        filter.slide(leaving, x);
        assert_eq!(filter.numerator(), direct(&filter, &taps), "{W}/{O}");
    }
}

fn input(size: i32) -> impl Strategy<Value = Vec<i32>> {
    prop::collection::vec(-size..=size, 320..500)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn output_is_the_rounded_least_squares_value(input in input(1 << 26)) {
        agrees_with_least_squares::<5, 3>(&input);
        agrees_with_least_squares::<7, 5>(&input);
        agrees_with_least_squares::<31, 3>(&input);
        agrees_with_least_squares::<31, 5>(&input);
        agrees_with_least_squares::<31, 7>(&input);
        agrees_with_least_squares::<101, 5>(&input);
        agrees_with_least_squares::<301, 5>(&input);
    }

    #[test]
    fn recursive_and_direct_form_agree_to_the_bit(input in input(i32::MAX)) {
        forms_agree::<5, 3>(&input);
        forms_agree::<31, 5>(&input);
        forms_agree::<31, 7>(&input);
        forms_agree::<101, 5>(&input);
        forms_agree::<301, 5>(&input);
    }

    #[test]
    fn division_rounds_to_nearest_halves_up(value: i32, part in 0u64..9889, whole in 0i64..2) {
        let plan = SavGol::<31, 5>::PLAN;
        let numerator = (i64::from(value) + whole) * 9889 + part as i64;
        let exact = (numerator + 9889 / 2).div_euclid(9889);
        prop_assert_eq!(i64::from(plan.divide(numerator)), exact.clamp(i32::MIN.into(), i32::MAX.into()));
    }
}

#[test]
fn polynomials_up_to_the_order_pass_unchanged() {
    let cubic = |x: i64| (x * x * x * x * x - 700 * x * x * x + 31 * x * x - 5) as i32;
    let input: Vec<i32> = (-50..50).map(cubic).collect();
    let expected: Vec<i32> = input[15..85].to_vec();
    assert_eq!(outputs::<31, 5>(&input), expected);
    let line: Vec<i32> = (0..100).map(|x| 3 * x - 40).collect();
    assert_eq!(outputs::<31, 3>(&line), line[15..85]);
    assert_eq!(outputs::<5, 1>(&line), line[2..98]);
}

#[test]
fn an_impulse_gives_the_coefficients() {
    let denominator = SavGol::<31, 5>::DENOMINATOR;
    assert_eq!(denominator, 9889);
    let mut input = vec![0; 91];
    input[45] = denominator as i32;
    let taps: Vec<i64> = outputs::<31, 5>(&input)[15..46]
        .iter()
        .map(|&y| i64::from(y))
        .collect();
    let coefficients: Vec<i64> = (0..31).map(SavGol::<31, 5>::coefficient).collect();
    assert_eq!(taps, coefficients);
    assert_eq!(coefficients.iter().sum::<i64>(), 9889);
    assert!((0..31).all(|u| coefficients[u] == coefficients[30 - u]));
}

#[test]
fn the_alternating_frequency_passes_with_the_known_gain() {
    let input: Vec<i32> = (0..200)
        .map(|k| if k % 2 == 0 { 1_000_000 } else { -1_000_000 })
        .collect();
    // Output n belongs to sample n + 15, which is odd for even n.
    let first = outputs::<31, 5>(&input)[0];
    assert_eq!(f64::from(first) / -1e6, -0.061381);
}

#[test]
fn an_impulse_leaves_nothing_behind_after_a_million_samples() {
    let mut filter = SavGol::<31, 5>::new();
    filter.push(i32::MAX);
    filter.push(i32::MIN);
    let last = (0..1_000_000).map(|_| filter.push(0)).last();
    assert_eq!(last, Some(Some(0)));
    assert_eq!(filter.moments, [0; MAX_ORDER + 1]);
}

#[test]
fn overshoot_saturates() {
    let input: Vec<i32> = (0..31)
        .map(|u| {
            if SavGol::<31, 5>::coefficient(u) > 0 {
                i32::MAX
            } else {
                -i32::MAX
            }
        })
        .collect();
    assert_eq!(outputs::<31, 5>(&input), [i32::MAX]);
    assert_eq!(SavGol::<31, 5>::INPUT_MAX, i32::MAX);
    assert_eq!(SavGol::<101, 5>::INPUT_MAX, i32::MAX);
}
