//! An error around the shaft, exaggerated radially: the zero circle, rings at round values, spokes by angle.

use maud::{Markup, html};

use super::draw::{Px, path, svg};
use super::plot::{Axis, Colour, Key, Mark};
use super::scale::{Extent, Scale, usable};

const SIZE: f64 = 430.0;
/// Radius of the outermost ring in pixels; the degrees stand outside it.
const OUTER: f64 = 178.0;
/// Directions drawn, enough that a neighbour is under two pixels away on the outer ring.
const SECTORS: usize = 720;

/// A named series of angles in degrees and values.
type Ring = (String, Vec<(f64, f64)>, Colour);

/// A quantity by shaft angle, drawn around a circle.
#[derive(Clone, Debug)]
pub struct Polar {
    axis: Axis,
    series: Vec<Ring>,
}

impl Polar {
    /// An empty figure; `radial` names the quantity and its unit.
    pub fn new(radial: Axis) -> Self {
        Self {
            axis: radial,
            series: Vec::new(),
        }
    }

    /// Adds values at shaft angles in degrees. Where several fall into half a degree, the largest in size is drawn.
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
        let key = |(name, _, colour): &Ring| Key::new(*colour, Mark::Line, name);
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
        let scale = Scale::fit(&axis, extent, 0.03, 5);
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
                    @if let Some(r) = radius(tick.at) {
                        circle.ring.zero[tick.at.abs() < largest * 1e-9] r=(Px(r)) {}
                    }
                }
                @for (_, points, colour) in &self.series {
                    path.line.(colour.class()) d=(path(&outline(points, radius))) {}
                }
                @for tick in &scale.ticks {
                    @if let Some(r) = radius(tick.at) {
                        @let (s, c) = 15f64.to_radians().sin_cos();
                        text.tick.mid.halo x=(Px(c * r)) y=(Px(-s * r + 4.0)) { (tick.text) }
                    }
                }
            }
        };
        svg(SIZE, SIZE + 4.0, label, inside)
    }
}

/// The closed line through the sectors that hold values; an empty sector is a gap unless values are sparse throughout.
fn outline(points: &[(f64, f64)], radius: impl Fn(f64) -> Option<f64>) -> Vec<Vec<(f64, f64)>> {
    let mut sectors: Vec<Option<(f64, f64)>> = vec![None; SECTORS];
    for &(angle, value) in points.iter().filter(|p| usable(p.0) && usable(p.1)) {
        let turned = angle.rem_euclid(360.0);
        let sector = &mut sectors[(turned / 360.0 * SECTORS as f64) as usize % SECTORS];
        if sector.is_none_or(|(_, v)| v.abs() < value.abs()) {
            *sector = Some((turned, value));
        }
    }
    let mut line: Vec<(f64, f64)> = sectors
        .into_iter()
        .flatten()
        .filter_map(|(angle, value)| {
            let (s, c) = angle.to_radians().sin_cos();
            radius(value).map(|r| (c * r, -s * r))
        })
        .collect();
    line.extend(line.first().copied().filter(|_| line.len() > 2));
    vec![line]
}
