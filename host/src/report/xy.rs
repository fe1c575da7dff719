//! Lines, steps and points over two axes, with shaded bands and marked values.

use maud::{Markup, html};

use super::decimate::{Place, polyline, scatter};
use super::draw::{Canvas, Frame, Px, path, rule};
use super::plot::{Axis, Colour, Key, Mark};
use super::scale::{Extent, Scale, tip};

/// Points up to this many get tool tips.
const FEW: usize = 200;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Style {
    Line,
    Dashed,
    Step,
    Points,
}

/// Samples of one quantity. Gaps are NaN; x and y are cut to the shorter of the two.
#[derive(Clone, Debug)]
pub struct Series {
    name: String,
    points: Vec<(f64, f64)>,
    style: Style,
    colour: Option<Colour>,
}

impl Series {
    fn new(name: impl Into<String>, x: &[f64], y: &[f64], style: Style) -> Self {
        Self {
            name: name.into(),
            points: x.iter().copied().zip(y.iter().copied()).collect(),
            style,
            colour: None,
        }
    }

    /// Samples joined by a line.
    pub fn line(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, x, y, Style::Line)
    }

    /// Samples joined by a dashed line: a model, a limit, a reference.
    pub fn dashed(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, x, y, Style::Dashed)
    }

    /// Each sample holds until the next.
    pub fn step(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, x, y, Style::Step)
    }

    /// Samples as dots.
    pub fn points(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, x, y, Style::Points)
    }

    /// Sets the colour; without, series take the palette in order.
    pub fn colour(mut self, colour: Colour) -> Self {
        self.colour = Some(colour);
        self
    }
}

/// A shaded range of y, such as a 95 % confidence band.
#[derive(Clone, Debug)]
pub struct Band {
    name: String,
    points: Vec<(f64, f64, f64)>,
    colour: Colour,
}

impl Band {
    /// The range from `lo` to `hi` at each `x`; cut to the shortest of the three.
    pub fn new(name: impl Into<String>, x: &[f64], lo: &[f64], hi: &[f64], colour: Colour) -> Self {
        let points = x
            .iter()
            .zip(lo)
            .zip(hi)
            .map(|((x, lo), hi)| (*x, *lo, *hi))
            .collect();
        Self {
            name: name.into(),
            points,
            colour,
        }
    }

    pub(super) fn key(&self) -> Key {
        Key::new(self.colour, Mark::Area, &self.name)
    }

    pub(super) fn values(&self) -> impl Iterator<Item = f64> {
        self.points.iter().flat_map(|p| [p.1, p.2])
    }

    pub(super) fn draw(&self, frame: &Frame) -> Markup {
        let both = |p: &(f64, f64, f64)| Some((frame.at(p.0, p.1)?, frame.at(p.0, p.2)?));
        let mut d = String::new();
        for piece in self.points.split(|p| both(p).is_none()) {
            let edge = |upper: bool| {
                let places = piece
                    .iter()
                    .map(|p| both(p).map(|(lo, hi)| if upper { hi } else { lo }));
                polyline(places, frame.width).concat()
            };
            let outline: Vec<_> = edge(true)
                .into_iter()
                .chain(edge(false).into_iter().rev())
                .collect();
            if outline.len() > 1 {
                d += &path([&outline]);
                d.push('Z');
            }
        }
        html! { path.band.(self.colour.class()) d=(d) {} }
    }
}

/// Series over two axes.
#[derive(Clone, Debug)]
pub struct Xy {
    x: Axis,
    y: Axis,
    series: Vec<Series>,
    bands: Vec<Band>,
    rules: Vec<(bool, f64, String)>,
}

/// Whether a series has more points than can be told apart.
fn is_dense(series: &Series, frame: &Frame) -> bool {
    series.points.len() as f64 > 2.0 * frame.width
}

impl Xy {
    /// An empty figure.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            x,
            y,
            series: Vec::new(),
            bands: Vec::new(),
            rules: Vec::new(),
        }
    }

    /// Adds a series, drawn over those before it.
    pub fn series(mut self, mut series: Series) -> Self {
        const ORDER: [Colour; 5] = [
            Colour::Blue,
            Colour::Orange,
            Colour::Green,
            Colour::Purple,
            Colour::Sky,
        ];
        series
            .colour
            .get_or_insert(ORDER[self.series.len() % ORDER.len()]);
        self.series.push(series);
        self
    }

    /// Adds a shaded band behind the series.
    pub fn band(mut self, band: Band) -> Self {
        self.bands.push(band);
        self
    }

    /// Marks a value of x with a labelled upright line.
    pub fn mark_x(mut self, at: f64, label: impl Into<String>) -> Self {
        self.rules.push((true, at, label.into()));
        self
    }

    /// Marks a value of y with a labelled level line.
    pub fn mark_y(mut self, at: f64, label: impl Into<String>) -> Self {
        self.rules.push((false, at, label.into()));
        self
    }

    pub(super) fn keys(&self) -> Vec<Key> {
        let series = self.series.iter().map(|s| {
            let mark = match s.style {
                Style::Line | Style::Step => Mark::Line,
                Style::Dashed => Mark::Dash,
                Style::Points => Mark::Dot,
            };
            Key::new(s.colour.unwrap_or(Colour::Blue), mark, &s.name)
        });
        let keys: Vec<_> = series.chain(self.bands.iter().map(Band::key)).collect();
        keys.into_iter().filter(|k| !k.name.is_empty()).collect()
    }

    pub(super) fn draw(&self, canvas: Canvas, label: &str) -> Markup {
        let (mut x, mut y) = (Extent::default(), Extent::default());
        for s in &self.series {
            x.take(s.points.iter().map(|p| p.0), self.x.log);
            y.take(s.points.iter().map(|p| p.1), self.y.log);
        }
        for b in &self.bands {
            x.take(b.points.iter().map(|p| p.0), self.x.log);
            y.take(b.values(), self.y.log);
        }
        for (vertical, at, _) in &self.rules {
            if *vertical { &mut x } else { &mut y }
                .take([*at], if *vertical { self.x.log } else { self.y.log });
        }
        let dots = self
            .series
            .iter()
            .any(|s| s.style == Style::Points && s.points.len() <= FEW);
        let x = Scale::fit(&self.x, x, if dots { 0.02 } else { 0.0 }, canvas.ticks());
        let frame = Frame::new(canvas, x, Scale::fit(&self.y, y, 0.06, 6));
        let inside = html! {
            @for band in &self.bands { (band.draw(&frame)) }
            @for (index, series) in self.series.iter().enumerate() {
                (self.draw_series(&frame, series, self.series[..index].iter().any(|below| is_dense(below, &frame))))
            }
            @for (vertical, at, text) in &self.rules { (rule(&frame, *at, *vertical, text)) }
        };
        frame.render(label, inside, html! {})
    }

    /// Draws a series; one `over` a dense one stands out from it.
    fn draw_series(&self, frame: &Frame, series: &Series, over: bool) -> Markup {
        let colour = series.colour.unwrap_or(Colour::Blue).class();
        let places = series.points.iter().map(|p| frame.at(p.0, p.1));
        let few = series.points.len() <= FEW;
        let dense = is_dense(series, frame) && !over;
        match series.style {
            Style::Points if few => html! { (self.dots(frame, series, colour, "dot")) },
            Style::Points => {
                let dots: Vec<_> = scatter(places, 2.0).into_iter().map(|p| vec![p]).collect();
                html! { path.cloud.(colour) d=(path(&dots)) {} }
            }
            Style::Step => {
                let held: Vec<Place> = places
                    .clone()
                    .zip(places.skip(1).chain([None]))
                    .flat_map(|(here, next)| {
                        let corner = here.zip(next).map(|(h, n)| (n.0, h.1));
                        [here, corner.or(here)]
                    })
                    .collect();
                let lines = polyline(held.into_iter(), frame.width);
                html! { path.line.dense[dense].(colour) d=(path(&lines)) {} }
            }
            Style::Line | Style::Dashed => {
                let lines = polyline(places, frame.width);
                let dashed = series.style == Style::Dashed;
                html! {
                    @if over { path.casing d=(path(&lines)) {} }
                    path.line.dash[dashed].dense[dense].over[over].(colour) d=(path(&lines)) {}
                    @if few { (self.dots(frame, series, colour, "touch")) }
                }
            }
        }
    }

    /// Dots with tool tips; of class `touch` they are unseen and only widen what the pointer can hit.
    fn dots(&self, frame: &Frame, series: &Series, colour: &str, class: &str) -> Markup {
        html! {
            g.(class).(colour) {
                @for p in &series.points {
                    @if let Some((x, y)) = frame.at(p.0, p.1) {
                        circle cx=(Px(x)) cy=(Px(y)) r=(if class == "dot" { "3" } else { "6" }) {
                            title { (series.name) ": " (tip(&self.x, p.0)) ", " (tip(&self.y, p.1)) }
                        }
                    }
                }
            }
        }
    }
}
