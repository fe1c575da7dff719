//! An error around the shaft, exaggerated radially: the zero circle, rings at round values, spokes by angle.

use maud::{Markup, html};

use super::decimate::polyline;
use super::draw::{Px, path, svg, text_width};
use super::plot::{Axis, Colour, Key, Mark};
use super::scale::{Extent, Scale, usable};

const SIZE: f64 = 430.0;
/// Radius of the outermost ring in pixels; the degrees stand outside it.
const OUTER: f64 = 178.0;
/// Directions drawn, enough that a neighbour is under two pixels away on the outer ring.
const SECTORS: f64 = 720.0;

/// Name, points (degrees, value) and colour.
type Trace = (String, Vec<(f64, f64)>, Colour);

/// A quantity by shaft angle, drawn around a circle.
#[derive(Clone, Debug)]
pub struct Polar {
    axis: Axis,
    series: Vec<Trace>,
}

impl Polar {
    /// An empty figure; `radial` names the quantity and its unit.
    pub fn new(radial: Axis) -> Self {
        Self {
            axis: radial,
            series: Vec::new(),
        }
    }

    /// Adds values at shaft angles in degrees. Where many fall into half a degree, the lowest and highest are drawn.
    pub fn series(
        mut self,
        name: impl Into<String>,
        angles_deg: &[f64],
        values: &[f64],
        colour: Colour,
    ) -> Self {
        let points = angles_deg
            .iter()
            .copied()
            .zip(values.iter().copied())
            .collect();
        self.series.push((name.into(), points, colour));
        self
    }

    pub(super) fn keys(&self) -> Vec<Key> {
        let key = |(name, _, colour): &(String, _, Colour)| Key::new(*colour, Mark::Line, name);
        self.series.iter().map(key).collect()
    }

    pub(super) fn draw(&self, label: &str) -> Markup {
        let mut extent = Extent::default();
        extent.take(
            self.series.iter().flat_map(|s| s.1.iter().map(|p| p.1)),
            false,
        );
        let largest = extent.0.map_or(0.0, |(lo, hi)| lo.abs().max(hi.abs()));
        extent.0 = (largest > 0.0).then_some((-largest, largest));
        let mut axis = self.axis.clone();
        axis.log = false;
        let scale = Scale::fit(&axis, extent, 0.03, 7);
        // The smallest value sits at 40 % of the radius, so that opposite sides stay apart.
        let radius = |v: f64| scale.place(v).map(|f| OUTER * (0.4 + 0.6 * f));
        let middle = SIZE / 2.0;
        let inside = html! {
            text.axis-label x="0" y="12" { (scale.label) }
            g transform={ "translate(" (Px(middle)) " " (Px(middle + 6.0)) ")" } {
                @for spoke in 0..12 {
                    @let (s, c) = (f64::from(spoke) * 30.0).to_radians().sin_cos();
                    path.grid d={ "M" (Px(c * OUTER * 0.4)) " " (Px(-s * OUTER * 0.4)) "L" (Px(c * OUTER)) " " (Px(-s * OUTER)) } {}
                    text.tick.mid x=(Px(c * (OUTER + 17.0))) y=(Px(-s * (OUTER + 15.0) + 4.0)) { (spoke * 30) "°" }
                }
                @for tick in &scale.ticks {
                    @if let Some(r) = radius(tick.at) { circle.ring r=(Px(r)) {} }
                }
                @for (_, points, colour) in &self.series {
                    path.line.dense[points.len() > 720].(colour.class()) d=(path(&outline(points, radius))) {}
                }
                @if let Some(r) = radius(0.0) { circle.ring.zero r=(Px(r)) {} }
                @for tick in &scale.ticks {
                    @if let Some(r) = radius(tick.at) {
                        @let (s, c) = 75f64.to_radians().sin_cos();
                        @let half = text_width(&tick.text) / 2.0 + 2.0;
                        rect.plate x=(Px(c * r - half)) y=(Px(-s * r - 7.0)) width=(Px(2.0 * half)) height="14" rx="2" {}
                        text.tick.mid x=(Px(c * r)) y=(Px(-s * r + 4.0)) { (tick.text) }
                    }
                }
            }
        };
        svg(SIZE, SIZE + 4.0, label, inside)
    }
}

/// The closed line through every value, or through the lowest and highest of each sector where there are many.
fn outline(points: &[(f64, f64)], radius: impl Fn(f64) -> Option<f64>) -> Vec<Vec<(f64, f64)>> {
    let mut sorted: Vec<(f64, f64)> = points
        .iter()
        .filter(|p| usable(p.0) && usable(p.1))
        .map(|p| (p.0.rem_euclid(360.0), p.1))
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    // In sector units a sector is one pixel column of a straight plot.
    let places = sorted.iter().map(|p| Some((p.0 / 360.0 * SECTORS, p.1)));
    let mut lines = polyline(places, SECTORS);
    for line in &mut lines {
        for p in line.iter_mut() {
            let (s, c) = (p.0 / SECTORS * 360.0).to_radians().sin_cos();
            let r = radius(p.1).unwrap_or(0.0);
            *p = (c * r, -s * r);
        }
        line.extend(line.first().copied().filter(|_| line.len() > 2));
    }
    lines
}
