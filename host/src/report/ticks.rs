//! Where the ticks of an axis stand, and what a logarithmic one says at each.

use super::number::{grouped, si, superscript, takes_prefix};

/// Labelled and unlabelled positions on a logarithmic axis from `lo` to `hi`, both above zero: whole decades where there
/// are three or more, else 1-2-5 steps, else round steps as on a linear axis.
pub(super) fn log_positions(lo: f64, hi: f64, most: usize) -> (Vec<f64>, Vec<f64>) {
    let (first, last) = (lo.log10().floor() as i32, hi.log10().ceil() as i32);
    let inside = |v: &f64| *v >= lo * (1.0 - 1e-9) && *v <= hi * (1.0 + 1e-9);
    let decades: Vec<i32> = (first..=last).filter(|e| inside(&10f64.powi(*e))).collect();
    let digits = |which: &[f64]| -> Vec<f64> {
        (first..=last)
            .flat_map(|e| which.iter().map(move |d| d * 10f64.powi(e)))
            .filter(inside)
            .collect()
    };
    let fine = digits(&[1.0, 2.0, 5.0]);
    let labelled = if decades.len() >= 3 {
        let stride = decades.len().div_ceil(most) as i32;
        let kept = decades.iter().filter(|e| e.rem_euclid(stride) == 0);
        kept.map(|e| 10f64.powi(*e)).collect()
    } else if fine.len() >= 2 {
        fine
    } else {
        round_steps(lo, hi, most.min(4), false)
            .into_iter()
            .map(|s| s.0)
            .collect()
    };
    let minor = if decades.len() <= 7 {
        digits(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
    } else {
        Vec::new()
    };
    (labelled, minor)
}

/// The text of a round value on a logarithmic axis, with its unit where that takes a prefix.
pub(super) fn log_text(v: f64, unit: &str) -> String {
    if takes_prefix(unit) {
        let text = si(v, unit);
        // Ticks are round: 1.00 µrad says no more than 1 µrad.
        match text.split_once('\u{a0}') {
            Some((n, u)) if n.contains('.') => {
                format!("{}\u{a0}{u}", n.trim_end_matches('0').trim_end_matches('.'))
            }
            _ => text,
        }
    } else if (1e-3..1e6).contains(&v) {
        let decimals = (-v.log10().floor()).max(0.0) as usize;
        grouped(v, decimals)
    } else {
        let e = v.log10().floor() as i32;
        let m = (v / 10f64.powi(e)).round();
        let power = format!("10{}", superscript(e));
        if m == 1.0 {
            power
        } else {
            format!("{m}×{power}")
        }
    }
}

/// Round positions within `lo..=hi` and the decimals that show them: steps of 1, 2 or 5 times a power of ten; for a wide
/// span of degrees, parts of a turn.
pub(super) fn round_steps(lo: f64, hi: f64, most: usize, degrees: bool) -> Vec<(f64, usize)> {
    const PARTS_OF_A_TURN: [f64; 6] = [10.0, 15.0, 30.0, 45.0, 90.0, 180.0];
    let raw = (hi - lo) / most as f64;
    if !(raw > 0.0 && raw.is_finite()) {
        return Vec::new();
    }
    let part = PARTS_OF_A_TURN.into_iter().find(|s| *s >= raw);
    let (step, decimals) = match part {
        Some(part) if degrees && raw > 5.0 => (part, 0),
        _ => {
            let exponent = raw.log10().floor() as i32;
            let m = raw / 10f64.powi(exponent);
            let (digit, exponent) = match m {
                m if m <= 1.0 + 1e-9 => (1.0, exponent),
                m if m <= 2.0 => (2.0, exponent),
                m if m <= 5.0 => (5.0, exponent),
                _ => (1.0, exponent + 1),
            };
            (
                digit * 10f64.powi(exponent),
                exponent.min(0).unsigned_abs() as usize,
            )
        }
    };
    let (first, last) = ((lo / step - 1e-6).ceil(), (hi / step + 1e-6).floor());
    let count = (last - first + 1.0).clamp(0.0, 100.0) as usize;
    (0..count)
        .map(|i| ((first + i as f64) * step, decimals))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_one_two_or_five_times_a_power_of_ten() {
        for i in 0..400 {
            let span = 1.37f64.powi(i - 200);
            let steps = round_steps(-span * 0.3, span, 7, false);
            assert!((2..=9).contains(&steps.len()), "{span}: {}", steps.len());
            let step = steps[1].0 - steps[0].0;
            let m = step / 10f64.powf(step.log10().floor());
            let digit = [1.0, 2.0, 5.0, 10.0].iter().any(|d| (m - d).abs() < 1e-6);
            assert!(digit, "{span}: step {step}");
        }
    }

    #[test]
    fn a_tall_log_axis_keeps_every_second_or_third_decade() {
        let (labelled, minor) = log_positions(1e-9, 1.0, 4);
        let exponents: Vec<i32> = labelled.iter().map(|v| v.log10().round() as i32).collect();
        assert_eq!(exponents, [-9, -6, -3, 0]);
        assert!(minor.is_empty());
    }
}
