//! Axes: extents, linear and logarithmic mapping, round ticks, and numbers with SI prefixes.

use super::number::{
    MINUS, decimal_exponent, grouped, power_of_ten, prefixed_unit, si, superscript, takes_prefix,
};

/// Values beyond this are no measurement; they are drawn as gaps, like NaN.
const LARGEST: f64 = 1e100;
/// Spans below this are treated as a single value.
const SMALLEST: f64 = 1e-100;

/// What one axis of a plot shows. Values are handed over in `unit`; the prefix is chosen when drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    pub(super) label: String,
    pub(super) unit: String,
    pub(super) log: bool,
    pub(super) range: Option<(f64, f64)>,
}

impl Axis {
    /// A linear axis fitted to its data. `unit` is the plain unit (`rad`, `rad/s`, `s`, `deg`, or empty).
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            unit: unit.into(),
            log: false,
            range: None,
        }
    }

    /// The shaft angle over one turn, in degrees from 0 to 360.
    pub fn turn() -> Self {
        Self::new("Shaft angle", "deg").range(0.0, 360.0)
    }

    /// Makes the axis logarithmic; values at or below zero become gaps.
    pub fn log(mut self) -> Self {
        self.log = true;
        self
    }

    /// Fixes the ends, in `unit`. Ends that are not finite or not rising are ignored.
    pub fn range(mut self, lo: f64, hi: f64) -> Self {
        self.range = (usable(lo) && usable(hi) && lo < hi).then_some((lo, hi));
        self
    }
}

/// Smallest and largest drawable value seen.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Extent(pub(super) Option<(f64, f64)>);

impl Extent {
    /// Takes in every value that an axis (logarithmic or not) can show.
    pub(super) fn take(&mut self, values: impl IntoIterator<Item = f64>, log: bool) {
        for v in values {
            if usable(v) && (!log || v > SMALLEST) {
                self.0 = Some(self.0.map_or((v, v), |(lo, hi)| (lo.min(v), hi.max(v))));
            }
        }
    }
}

/// Whether a value can be drawn at all.
pub(super) fn usable(v: f64) -> bool {
    v.is_finite() && v.abs() < LARGEST
}

/// A labelled position on an axis, in the axis' plain unit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub(super) at: f64,
    pub(super) text: String,
}

/// An axis fitted to its data.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    pub(super) lo: f64,
    pub(super) hi: f64,
    log: bool,
    pub(super) ticks: Vec<Tick>,
    /// Unlabelled grid positions of a logarithmic axis.
    pub(super) minor: Vec<f64>,
    /// Axis label with the unit in use.
    pub(super) label: String,
}

impl Scale {
    /// Fits `axis` to `extent`, widened by `pad` of its span at both ends, with at most about `most` labelled ticks.
    pub(super) fn fit(axis: &Axis, extent: Extent, pad: f64, most: usize) -> Self {
        let range = axis.range.filter(|r| !axis.log || r.0 > SMALLEST);
        let (lo, hi) = match (range, extent.0) {
            (Some(range), _) => range,
            (None, Some((lo, hi))) if axis.log => padded_log(lo, hi, pad),
            (None, Some((lo, hi))) => padded(lo, hi, pad),
            (None, None) if axis.log => (1.0, 10.0),
            (None, None) => (0.0, 1.0),
        };
        if axis.log {
            Self::log(axis, lo, hi, most.max(2))
        } else {
            Self::linear(axis, lo, hi, most.max(2))
        }
    }

    fn linear(axis: &Axis, lo: f64, hi: f64, most: usize) -> Self {
        let (exponent, unit) = prefixed_unit(lo.abs().max(hi.abs()), &axis.unit);
        let factor = power_of_ten(-exponent);
        let degrees = axis.unit == "deg";
        let ticks = round_steps(lo * factor, hi * factor, most, degrees)
            .into_iter()
            .map(|(v, decimals)| Tick {
                at: v / factor,
                text: grouped(v, decimals),
            })
            .collect();
        Self {
            lo,
            hi,
            log: false,
            ticks,
            minor: Vec::new(),
            label: labelled(&axis.label, &unit),
        }
    }

    fn log(axis: &Axis, lo: f64, hi: f64, most: usize) -> Self {
        let (first, last) = (decimal_exponent(lo), decimal_exponent(hi) + 1);
        let inside = |v: &f64| usable(*v) && *v >= lo * (1.0 - 1e-9) && *v <= hi * (1.0 + 1e-9);
        let decades: Vec<i32> = (first..=last)
            .filter(|e| inside(&power_of_ten(*e)))
            .collect();
        let digits = |which: &[f64]| -> Vec<f64> {
            (first..=last)
                .flat_map(|e| which.iter().map(move |d| d * power_of_ten(e)))
                .filter(inside)
                .collect()
        };
        let at: Vec<f64> = if decades.len() >= 3 {
            let stride = decades.len().div_ceil(most);
            decades
                .iter()
                .step_by(stride)
                .map(|e| power_of_ten(*e))
                .collect()
        } else {
            let fine = digits(&[1.0, 2.0, 5.0]);
            if fine.len() >= 2 {
                fine
            } else {
                let steps = round_steps(lo, hi, most.min(4), false);
                steps.into_iter().map(|s| s.0).filter(inside).collect()
            }
        };
        let minor = if decades.len() <= 7 {
            digits(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
        } else {
            Vec::new()
        };
        let prefixed = takes_prefix(&axis.unit);
        let ticks = at
            .into_iter()
            .map(|v| Tick {
                at: v,
                text: log_text(v, &axis.unit),
            })
            .collect();
        let unit = if prefixed { "" } else { axis.unit.as_str() };
        Self {
            lo,
            hi,
            log: true,
            ticks,
            minor,
            label: labelled(&axis.label, unit),
        }
    }

    /// Where `v` falls, 0 at the low end and 1 at the high end; beyond the ends too. `None` where it cannot be drawn.
    pub(super) fn place(&self, v: f64) -> Option<f64> {
        if !usable(v) {
            return None;
        }
        if self.log {
            (v > 0.0).then(|| (v / self.lo).log10() / (self.hi / self.lo).log10())
        } else {
            Some((v - self.lo) / (self.hi - self.lo))
        }
    }

    /// Moves the high end up so that what reached it before now reaches `fraction` of the axis.
    pub(super) fn headroom(axis: &Axis, extent: Extent, fraction: f64) -> Extent {
        let fraction = fraction.clamp(0.2, 1.0);
        Extent(extent.0.map(|(lo, hi)| {
            if axis.log {
                (lo, lo * (hi / lo).powf(1.0 / fraction).min(1e30))
            } else {
                (lo, lo + (hi - lo) / fraction)
            }
        }))
    }
}

fn labelled(label: &str, unit: &str) -> String {
    match (label.is_empty(), unit.is_empty()) {
        (_, true) => label.to_owned(),
        (true, false) => unit.to_owned(),
        (false, false) => format!("{label} ({unit})"),
    }
}

fn padded(lo: f64, hi: f64, pad: f64) -> (f64, f64) {
    let size = lo.abs().max(hi.abs());
    let span = hi - lo;
    if span > SMALLEST && span > size * 1e-12 {
        (lo - span * pad, hi + span * pad)
    } else if size > SMALLEST {
        (lo - size * 0.1, hi + size * 0.1)
    } else {
        (-1.0, 1.0)
    }
}

fn padded_log(lo: f64, hi: f64, pad: f64) -> (f64, f64) {
    let decades = (hi / lo).log10();
    if decades < 1e-6 {
        return (lo / 3.0, hi * 3.0);
    }
    let by = 10f64.powf(decades * pad);
    (lo / by, hi * by)
}

fn log_text(v: f64, unit: &str) -> String {
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
        let decimals = (-decimal_exponent(v)).max(0) as usize;
        grouped(v, decimals)
    } else {
        let e = decimal_exponent(v);
        let m = (v / power_of_ten(e)).round();
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
fn round_steps(lo: f64, hi: f64, most: usize, degrees: bool) -> Vec<(f64, usize)> {
    const PARTS_OF_A_TURN: [f64; 6] = [10.0, 15.0, 30.0, 45.0, 90.0, 180.0];
    let raw = (hi - lo) / most as f64;
    if !(raw > 0.0 && raw.is_finite()) {
        return Vec::new();
    }
    let part = PARTS_OF_A_TURN.into_iter().find(|s| *s >= raw);
    let (step, decimals) = match part {
        Some(part) if degrees && raw > 5.0 => (part, 0),
        _ => {
            let exponent = decimal_exponent(raw);
            let m = raw / power_of_ten(exponent);
            let (digit, exponent) = match m {
                m if m <= 1.0 + 1e-9 => (1.0, exponent),
                m if m <= 2.0 => (2.0, exponent),
                m if m <= 5.0 => (5.0, exponent),
                _ => (1.0, exponent + 1),
            };
            (
                digit * power_of_ten(exponent),
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

/// A plain-text form for a signed axis value, used by tool tips.
pub(super) fn tip(axis: &Axis, v: f64) -> String {
    let text = si(v, &axis.unit);
    if axis.label.is_empty() {
        text
    } else {
        format!("{} {}", axis.label, text.replace('-', MINUS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(axis: Axis, lo: f64, hi: f64) -> Scale {
        Scale::fit(&axis, Extent(Some((lo, hi))), 0.05, 6)
    }

    fn texts(scale: &Scale) -> Vec<&str> {
        scale.ticks.iter().map(|t| t.text.as_str()).collect()
    }

    #[test]
    fn ticks_carry_the_prefix_of_the_axis() {
        let s = fit(Axis::new("Error", "rad"), -1.9e-4, 2.1e-4);
        assert_eq!(s.label, "Error (µrad)");
        assert_eq!(texts(&s), ["−200", "−100", "0", "100", "200"]);
        assert!((s.ticks[4].at - 2e-4).abs() < 1e-18);
    }

    #[test]
    fn steps_are_one_two_or_five_times_a_power_of_ten() {
        for i in 0..400 {
            let span = 1.37f64.powi(i - 200);
            let steps = round_steps(-span * 0.3, span, 7, false);
            assert!((2..=9).contains(&steps.len()), "{span}: {}", steps.len());
            let step = steps[1].0 - steps[0].0;
            let m = step / power_of_ten(decimal_exponent(step));
            let digit = [1.0, 2.0, 5.0, 10.0].iter().any(|d| (m - d).abs() < 1e-6);
            assert!(digit, "{span}: step {step}");
        }
    }

    #[test]
    fn a_turn_is_divided_into_parts_of_a_turn() {
        let s = Scale::fit(&Axis::turn(), Extent::default(), 0.0, 8);
        assert_eq!(
            texts(&s),
            ["0", "45", "90", "135", "180", "225", "270", "315", "360"]
        );
    }

    #[test]
    fn log_ticks_name_decades_with_their_prefix() {
        let s = fit(Axis::new("Amplitude", "rad").log(), 1e-9, 3e-4);
        assert_eq!(s.label, "Amplitude");
        assert_eq!(
            texts(&s)[..3],
            ["1\u{a0}nrad", "10\u{a0}nrad", "100\u{a0}nrad"]
        );
        let s = fit(Axis::new("Order", "").log(), 1.0, 5000.0);
        assert_eq!(texts(&s), ["1", "10", "100", "1000"]);
    }

    #[test]
    fn every_extent_gives_a_usable_scale() {
        let extents = [
            None,
            Some((0.0, 0.0)),
            Some((5.0, 5.0)),
            Some((-1e-99, 1e-99)),
            Some((1e99, 9e99)),
            Some((1.0, 1.0 + 1e-15)),
            Some((-9e99, 9e99)),
            Some((1e-90, 1e90)),
        ];
        for extent in extents {
            for axis in [Axis::new("x", "s"), Axis::new("x", "").log(), Axis::turn()] {
                let mut e = Extent::default();
                e.take(extent.iter().flat_map(|(a, b)| [*a, *b]), axis.log);
                let s = Scale::fit(&axis, e, 0.05, 6);
                assert!(s.lo < s.hi, "{extent:?}");
                assert!(s.ticks.len() < 60, "{extent:?}: {}", s.ticks.len());
                assert!(s.ticks.iter().all(|t| s.place(t.at).is_some()));
            }
        }
        let log = fit(Axis::new("x", "").log(), 1.0, 10.0);
        assert_eq!(log.place(-1.0), None);
        assert_eq!(log.place(f64::NAN), None);
    }
}
