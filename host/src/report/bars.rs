//! Named magnitudes beside each other, such as an RMS error before and after.

use maud::{Markup, html};

use super::draw::{Canvas, Px, svg, text_width};
use super::number::{decimal_exponent, power_of_ten, si};
use super::plot::{Axis, Colour};
use super::scale::{Extent, Scale, usable};

const BAR: f64 = 20.0;
const STEP: f64 = 28.0;

/// Level bars, one a line, each with its name and its value.
#[derive(Clone, Debug)]
pub struct Bars {
    axis: Axis,
    bars: Vec<(String, f64, Colour)>,
}

impl Bars {
    /// An empty figure. A logarithmic axis starts at a round value under the smallest bar.
    pub fn new(axis: Axis) -> Self {
        Self {
            axis,
            bars: Vec::new(),
        }
    }

    /// Adds a bar. A value that is not finite, or below zero, has no bar; its text says what it is.
    pub fn bar(mut self, name: impl Into<String>, value: f64, colour: Colour) -> Self {
        self.bars.push((name.into(), value, colour));
        self
    }

    pub(super) fn draw(&self, canvas: Canvas, label: &str) -> Markup {
        let (width, unit) = (canvas.width(), self.axis.unit.as_str());
        let mut extent = Extent::default();
        extent.take(self.bars.iter().map(|b| b.1), self.axis.log);
        let extent = if self.axis.log {
            Extent(
                extent
                    .0
                    .map(|(lo, hi)| (power_of_ten(decimal_exponent(lo / 2.0)), hi)),
            )
        } else {
            Extent(extent.0.map(|(_, hi)| (0.0, hi)))
        };
        let names = self
            .bars
            .iter()
            .map(|b| text_width(&b.0))
            .fold(0.0, f64::max);
        let values = self
            .bars
            .iter()
            // The value is bold, a little wider than plain text.
            .map(|b| 1.2 * text_width(&si(b.1, unit)))
            .fold(0.0, f64::max)
            + 12.0;
        // Where names would take too much of a small canvas they stand above their bars.
        let stacked = names > width * 0.4;
        let left = if stacked { 1.0 } else { names + 10.0 };
        let step = if stacked { STEP + 16.0 } else { STEP };
        let room = (width - left - values).max(40.0);
        let scale = Scale::fit(&self.axis, extent, 0.0, if room > 400.0 { 7 } else { 3 });
        let height = step * self.bars.len() as f64;
        let along = |v: f64| scale.place(v).map_or(0.0, |f| f.clamp(0.0, 1.0) * room);
        let inside = html! {
            g transform={ "translate(" (Px(left)) " 2)" } {
                @for tick in scale.ticks.iter().filter(|t| t.at >= scale.lo) {
                    path.grid d={ "M" (Px(along(tick.at))) " 0v" (Px(height)) } {}
                    text.tick.mid x=(Px(along(tick.at).max(text_width(&tick.text) / 2.0 - left))) y=(Px(height + 15.0)) { (tick.text) }
                }
                @for (i, (name, value, colour)) in self.bars.iter().enumerate() {
                    @let top = step * i as f64 + (step - BAR) / 2.0 + if stacked { 8.0 } else { 0.0 };
                    @let long = if usable(*value) && *value > 0.0 { along(*value).max(1.0) } else { 0.0 };
                    @if stacked {
                        text.bar-name x="0" y=(Px(top - 5.0)) { (name) }
                    } @else {
                        text.bar-name.end x="-8" y=(Px(top + BAR / 2.0 + 4.0)) { (name) }
                    }
                    rect.fill.(colour.class()) x="0" y=(Px(top)) width=(Px(long)) height=(Px(BAR)) rx="2" {}
                    text.bar-value x=(Px(long + 6.0)) y=(Px(top + BAR / 2.0 + 4.0)) { (si(*value, unit)) }
                }
                path.frame d={ "M0 0v" (Px(height)) } {}
                text.axis-label.end x=(Px(width - left)) y=(Px(height + 32.0)) { (scale.label) }
            }
        };
        svg(width, height + 40.0, label, inside)
    }
}
