//! Amplitude by order: stems over logarithmic axes, a noise floor, a confidence band and named orders.

use maud::{Markup, html};

use super::decimate::{crest, polyline};
use super::draw::{Canvas, Frame, Px, path, text_width};
use super::number::si;
use super::plot::{Axis, Band, Colour, Key, Mark};
use super::scale::{Extent, Scale};

/// Height of one row of order names, in pixels.
const ROW: f64 = 15.0;
/// Most rows of order names.
const ROWS: usize = 4;
/// Stems closer together than this, in pixels, are drawn pale under an outline.
const CLOSE: f64 = 2.5;
/// Amplitudes smaller than this part of the largest are not shown.
const DEPTH: f64 = 1e-6;

#[derive(Clone, Debug)]
struct Stems {
    name: String,
    orders: Vec<f64>,
    amplitudes: Vec<f64>,
    colour: Colour,
}

/// An order spectrum (orders are cycles a revolution, whole or not).
#[derive(Clone, Debug)]
pub struct Spectrum {
    label: String,
    unit: String,
    stems: Vec<Stems>,
    floor: Vec<(f64, f64)>,
    floor_name: String,
    band: Option<Band>,
    named: Vec<(f64, String)>,
}

impl Spectrum {
    /// An empty spectrum of amplitudes in `unit`.
    pub fn new(unit: impl Into<String>) -> Self {
        Self {
            label: "Amplitude".to_owned(),
            unit: unit.into(),
            stems: Vec::new(),
            floor: Vec::new(),
            floor_name: String::new(),
            band: None,
            named: Vec::new(),
        }
    }

    /// Says what the heights are, where they are no amplitudes.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// Adds amplitudes by order, drawn over those before them. Orders or amplitudes at or below zero are not shown.
    pub fn stems(
        mut self,
        name: impl Into<String>,
        orders: &[f64],
        amplitudes: &[f64],
        colour: Colour,
    ) -> Self {
        self.stems.push(Stems {
            name: name.into(),
            orders: orders.to_vec(),
            amplitudes: amplitudes.to_vec(),
            colour,
        });
        self
    }

    /// The noise floor by order; one point stands for every order.
    pub fn floor(mut self, name: impl Into<String>, orders: &[f64], amplitudes: &[f64]) -> Self {
        self.floor_name = name.into();
        self.floor = orders
            .iter()
            .copied()
            .zip(amplitudes.iter().copied())
            .collect();
        self
    }

    /// A shaded range, such as where 95 % of the noise lies.
    pub fn band(mut self, name: impl Into<String>, orders: &[f64], lo: &[f64], hi: &[f64]) -> Self {
        self.band = Some(Band::new(name, orders, lo, hi, Colour::Grey));
        self
    }

    /// Names an order; the label points at the tallest stem there.
    pub fn name(mut self, order: f64, label: impl Into<String>) -> Self {
        self.named.push((order, label.into()));
        self
    }

    pub(super) fn keys(&self) -> Vec<Key> {
        let mut keys: Vec<_> = self
            .stems
            .iter()
            .map(|s| Key::new(s.colour, Mark::Line, &s.name))
            .collect();
        if !self.floor.is_empty() {
            keys.push(Key::new(Colour::Grey, Mark::Dash, &self.floor_name));
        }
        keys.extend(self.band.as_ref().map(Band::key));
        keys
    }

    pub(super) fn draw(&self, canvas: Canvas, label: &str) -> Markup {
        let x_axis = Axis::new("Order, cycles a revolution", "").log();
        let y_axis = Axis::new(self.label.clone(), self.unit.clone()).log();
        let (mut x, mut y) = (Extent::default(), Extent::default());
        for s in &self.stems {
            x.take(s.orders.iter().copied(), true);
            y.take(s.amplitudes.iter().copied(), true);
        }
        let mut floor = Extent::default();
        floor.take(self.floor.iter().map(|p| p.1), true);
        floor.take(self.band.iter().flat_map(Band::values), true);
        if let Some((lo, hi)) = floor.0 {
            y.0 = Some(y.0.map_or((lo / 3.0, hi * 3.0), |(_, top)| (lo / 4.0, top.max(hi))));
        }
        y.0 = y.0.map(|(lo, hi)| (lo.max(hi * DEPTH), hi));
        let x = Scale::fit(&x_axis, x, 0.02, canvas.ticks());
        let draft = Frame::new(canvas, x.clone(), Scale::fit(&y_axis, y, 0.04, 6));
        let (names, rows) = self.place_names(&draft);
        let headroom = 1.0 - rows as f64 * ROW / draft.height;
        let y = Scale::headroom(&y_axis, y, headroom);
        let frame = Frame::new(canvas, x, Scale::fit(&y_axis, y, 0.04, 6));
        let inside = html! {
            @if let Some(band) = &self.band { (band.draw(&frame)) }
            @for s in &self.stems { (s.draw(&frame, &self.unit)) }
            (self.draw_floor(&frame))
            @for name in &names { (self.draw_tip(&frame, name)) }
            @for name in &names {
                @if let Some(row) = name.row {
                    text.note.mid.halo x=(Px(name.middle)) y=(Px(baseline(row))) { (name.text) }
                }
            }
        };
        frame.render(label, inside, html! {})
    }

    fn draw_floor(&self, frame: &Frame) -> Markup {
        let line = if let [(_, level)] = self.floor[..] {
            let y = frame.at_y(level);
            vec![y.map_or(Vec::new(), |y| vec![(0.0, y), (frame.width, y)])]
        } else {
            polyline(self.floor.iter().map(|p| frame.at(p.0, p.1)), frame.width)
        };
        let d = path(&line);
        html! { path.casing d=(d) {} path.line.dash.grey d=(d) {} }
    }

    /// Gives every named order a place in one of a few rows so that no two labels touch; one that finds none keeps its
    /// dot and tool tip.
    fn place_names(&self, frame: &Frame) -> (Vec<Name<'_>>, usize) {
        let mut named: Vec<_> = self.named.iter().collect();
        named.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut ends: Vec<f64> = Vec::new();
        let mut out = Vec::new();
        for (order, text) in named {
            let Some(x) = frame.at_x(*order) else {
                continue;
            };
            let half = text_width(text) / 2.0 + 3.0;
            let middle = x.min(frame.width - half).max(half);
            let free = ends.iter().position(|end| *end < middle - half);
            let row = free.or((ends.len() < ROWS).then_some(ends.len()));
            if let Some(row) = row {
                ends.resize(ends.len().max(row + 1), f64::NEG_INFINITY);
                ends[row] = middle + half;
            }
            out.push(Name {
                order: *order,
                text,
                middle,
                row,
            });
        }
        (out, ends.len())
    }

    /// The dot on the named stem, and a thin line from it up to its label.
    fn draw_tip(&self, frame: &Frame, name: &Name<'_>) -> Markup {
        let tallest = self
            .stems
            .iter()
            .filter_map(|s| Some((s.near(name.order)?, s)))
            .max_by(|a, b| a.0.1.total_cmp(&b.0.1));
        html! {
            @if let Some(((order, amplitude), stems)) = tallest {
                @if let Some((x, y)) = frame.at(order, amplitude) {
                    @if let Some(row) = name.row {
                        @let from = baseline(row) + 3.0;
                        path.leader d={ "M" (Px(x)) " " (Px(from)) "V" (Px((y - 5.0).max(from))) } {}
                    }
                    g.dot.(stems.colour.class()) {
                        circle cx=(Px(x)) cy=(Px(y)) r="3.5" {
                            title { (name.text) ": " (stems.name) " " (si(amplitude, &self.unit)) }
                        }
                    }
                }
            }
        }
    }
}

/// A named order's place: middle of its label and its row, counted from the top.
struct Name<'a> {
    order: f64,
    text: &'a str,
    middle: f64,
    row: Option<usize>,
}

fn baseline(row: usize) -> f64 {
    (row as f64 + 1.0) * ROW - 3.0
}

impl Stems {
    /// The order next to `order`, within half an order, and its amplitude.
    fn near(&self, order: f64) -> Option<(f64, f64)> {
        let points = self
            .orders
            .iter()
            .copied()
            .zip(self.amplitudes.iter().copied());
        points
            .filter(|(o, a)| (o - order).abs() <= 0.5 && *a > 0.0 && a.is_finite())
            .min_by(|a, b| (a.0 - order).abs().total_cmp(&(b.0 - order).abs()))
    }

    fn draw(&self, frame: &Frame, unit: &str) -> Markup {
        let places = self
            .orders
            .iter()
            .zip(&self.amplitudes)
            .map(|(o, a)| frame.at(*o, *a));
        let tops = crest(places.filter(|p| p.is_some_and(|(_, y)| y < frame.height)));
        // Columns stand side by side where orders crowd: there an outline says more than a solid block.
        let near = |i: usize, j: usize| match (tops.get(i), tops.get(j)) {
            (Some(a), Some(b)) => (b.0 - a.0).abs() < CLOSE,
            _ => false,
        };
        let crowded = |i: usize| near(i, i + 1) && (i == 0 || near(i - 1, i));
        let stems = |close: bool| -> String {
            let some = (0..tops.len()).filter(|i| crowded(*i) == close);
            let stem = |i: usize| vec![(tops[i].0, frame.height), tops[i]];
            path(&some.map(stem).collect::<Vec<_>>())
        };
        let outline: Vec<_> = (0..tops.len())
            .map(|i| crowded(i).then_some(tops[i]))
            .collect();
        let outline: Vec<Vec<_>> = outline
            .split(Option::is_none)
            .map(|piece| piece.iter().flatten().copied().collect())
            .collect();
        let colour = self.colour.class();
        html! {
            path.stem.pale.(colour) d=(stems(true)) {}
            path.line.dense.(colour) d=(path(&outline)) {}
            path.stem.(colour) d=(stems(false)) {}
            @if self.orders.len() <= 200 {
                g.touch {
                    @for (o, a) in self.orders.iter().zip(&self.amplitudes) {
                        @if let Some((x, y)) = frame.at(*o, *a) {
                            circle cx=(Px(x)) cy=(Px(y)) r="5" {
                                title { (self.name) ": order " (si(*o, "")) ", " (si(*a, unit)) }
                            }
                        }
                    }
                }
            }
        }
    }
}
