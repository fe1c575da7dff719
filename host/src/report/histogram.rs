//! How often a value occurs.

use maud::{Markup, html};

use super::draw::{Canvas, Frame, Px};
use super::plot::{Axis, Colour, Key, Mark};
use super::scale::{Extent, Scale, tip, usable};

/// Most bins drawn.
const MOST_BINS: usize = 80;

/// Distributions of values over shared bins, as shares of each series in percent.
#[derive(Clone, Debug)]
pub struct Histogram {
    x: Axis,
    series: Vec<(String, Vec<f64>, Colour)>,
    bins: Option<usize>,
}

impl Histogram {
    /// An empty figure over `x`. Values outside a range set on the axis are counted in the outermost bins.
    pub fn new(x: Axis) -> Self {
        Self {
            x,
            series: Vec::new(),
            bins: None,
        }
    }

    /// Adds a series of values; those that are not finite are left out.
    pub fn values(mut self, name: impl Into<String>, values: &[f64], colour: Colour) -> Self {
        let values = values.iter().copied().filter(|v| usable(*v)).collect();
        self.series.push((name.into(), values, colour));
        self
    }

    /// Sets the number of bins (1 to 80); without, it follows from the spread (Freedman-Diaconis).
    pub fn bins(mut self, bins: usize) -> Self {
        self.bins = Some(bins.clamp(1, MOST_BINS));
        self
    }

    pub(super) fn keys(&self) -> Vec<Key> {
        let key = |(name, _, colour): &(String, _, Colour)| Key::new(*colour, Mark::Area, name);
        self.series.iter().map(key).collect()
    }

    pub(super) fn draw(&self, canvas: Canvas, label: &str) -> Markup {
        let mut extent = Extent::default();
        extent.take(
            self.series.iter().flat_map(|s| s.1.iter().copied()),
            self.x.log,
        );
        let x = Scale::fit(&self.x, extent, 0.0, canvas.ticks());
        let bins = self
            .bins
            .unwrap_or_else(|| self.bins_by_spread(x.hi - x.lo));
        let shares: Vec<Vec<f64>> = self.series.iter().map(|s| shares(&s.1, &x, bins)).collect();
        let most = shares.iter().flatten().copied().fold(0.0, f64::max);
        let y = Axis::new("Share", "%").range(0.0, if most > 0.0 { most * 1.08 } else { 1.0 });
        let frame = Frame::new(canvas, x, Scale::fit(&y, Extent::default(), 0.0, 5));
        let wide = frame.width / bins as f64;
        let edge = |bin: usize| frame.x.lo + (frame.x.hi - frame.x.lo) * bin as f64 / bins as f64;
        let inside = html! {
            @for ((name, _, colour), shares) in self.series.iter().zip(&shares) {
                g.hist.(colour.class()) {
                    @for (bin, share) in shares.iter().enumerate() {
                        @if let Some(top) = frame.at_y(*share).filter(|_| *share > 0.0) {
                            rect x=(Px(bin as f64 * wide)) y=(Px(top)) width=(Px(wide)) height=(Px(frame.height - top)) {
                                @if bins * self.series.len() <= 200 && !self.x.log {
                                    title { (name) ": " (format!("{share:.1}")) "\u{a0}%, " (tip(&self.x, edge(bin))) " to " (tip(&Axis::new("", self.x.unit.clone()), edge(bin + 1))) }
                                }
                            }
                        }
                    }
                }
            }
        };
        frame.render(label, inside, html! {})
    }

    /// The narrowest series sets the bin width.
    fn bins_by_spread(&self, span: f64) -> usize {
        let width = |values: &Vec<f64>| {
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            let quartile = |q: usize| sorted.get(sorted.len() * q / 4).copied();
            let iqr = quartile(3)? - quartile(1)?;
            Some(2.0 * iqr / (sorted.len() as f64).cbrt()).filter(|w| *w > 0.0)
        };
        let narrowest = self
            .series
            .iter()
            .filter_map(|s| width(&s.1))
            .fold(f64::INFINITY, f64::min);
        ((span / narrowest).ceil() as usize).clamp(12, MOST_BINS)
    }
}

/// Percentage of `values` in each bin.
fn shares(values: &[f64], x: &Scale, bins: usize) -> Vec<f64> {
    let mut out = vec![0.0; bins];
    let each = 100.0 / values.len().max(1) as f64;
    for place in values.iter().filter_map(|v| x.place(*v)) {
        out[((place * bins as f64).max(0.0) as usize).min(bins - 1)] += each;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_and_outliers_fall_into_the_last_bins() {
        let x = Scale::fit(
            &Axis::new("x", "").range(0.0, 4.0),
            Extent::default(),
            0.0,
            5,
        );
        let s = shares(&[-9.0, 0.5, 1.5, 4.0, 99.0], &x, 4);
        assert_eq!(s, [40.0, 20.0, 0.0, 40.0]);
    }
}
