//! The SVG around a figure's data: canvas, frame, grid, ticks and labels.

use maud::{Markup, Render, html};

use super::decimate::Place;
use super::plot::{Colour, Key, Mark};
use super::scale::Scale;

/// A length or position in pixels, written to a tenth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Px(pub(super) f64);

impl Render for Px {
    fn render_to(&self, out: &mut String) {
        // NaN becomes 0; nothing on a page is farther out than this.
        let tenths = (self.0.clamp(-1e5, 1e5) * 10.0).round() as i64;
        if tenths < 0 {
            out.push('-');
        }
        out.push_str(&(tenths.abs() / 10).to_string());
        if tenths % 10 != 0 {
            out.push('.');
            out.push_str(&(tenths.abs() % 10).to_string());
        }
    }
}

/// The size a figure is drawn for; a page holds a wide and a narrow drawing and shows the one that fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Canvas {
    /// The page's full width.
    Wide,
    /// One of two beside each other, or a round figure.
    Half,
    /// A phone.
    Narrow,
}

impl Canvas {
    pub(super) fn width(self) -> f64 {
        match self {
            Self::Wide => 900.0,
            Self::Half => 430.0,
            Self::Narrow => 350.0,
        }
    }

    pub(super) fn height(self) -> f64 {
        match self {
            Self::Wide => 300.0,
            Self::Half => 270.0,
            Self::Narrow => 250.0,
        }
    }

    /// Labelled ticks that fit along x.
    pub(super) fn ticks(self) -> usize {
        match self {
            Self::Wide => 9,
            Self::Half => 5,
            Self::Narrow => 4,
        }
    }
}

/// Rough width of a text at the tick size, in pixels.
pub(super) fn text_width(text: &str) -> f64 {
    text.chars()
        .map(|c| {
            if "\u{202f}.,:|ilI".contains(c) {
                3.6
            } else {
                6.9
            }
        })
        .sum()
}

/// An `svg` element of the given size.
pub(super) fn svg(width: f64, height: f64, label: &str, inside: Markup) -> Markup {
    html! {
        svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(label)
            viewBox={ "0 0 " (Px(width)) " " (Px(height)) } { (inside) }
    }
}

/// `d` of a path through each piece; a piece of one point becomes a dot under a round cap.
pub(super) fn path<'a>(pieces: impl IntoIterator<Item = &'a Vec<(f64, f64)>>) -> String {
    let mut d = String::new();
    for piece in pieces {
        let mut last: Option<(String, String)> = None;
        for (x, y) in piece {
            let (x, y) = (Px(*x).render().into_string(), Px(*y).render().into_string());
            match &last {
                None => d += &format!("M{x} {y}"),
                Some((lx, ly)) if *lx == x && *ly == y => continue,
                Some((lx, _)) if *lx == x => d += &format!("V{y}"),
                Some(_) => d += &format!("L{x} {y}"),
            }
            last = Some((x, y));
        }
        if piece.len() == 1 {
            d += "h0";
        }
    }
    d
}

/// Two scales laid out on a canvas; positions are in pixels of the inner drawing area.
pub(super) struct Frame {
    canvas: Canvas,
    left: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) x: Scale,
    pub(super) y: Scale,
    rows: bool,
}

const TOP: f64 = 26.0;
const BOTTOM: f64 = 40.0;
const RIGHT: f64 = 14.0;

impl Frame {
    /// Lays out the frame so that every tick label has room.
    pub(super) fn new(canvas: Canvas, x: Scale, y: Scale) -> Self {
        let widest = y
            .ticks
            .iter()
            .map(|t| text_width(&t.text))
            .fold(0.0, f64::max);
        let left = (widest + 12.0).clamp(34.0, canvas.width() * 0.35);
        Self {
            canvas,
            left,
            width: canvas.width() - left - RIGHT,
            height: canvas.height() - TOP - BOTTOM,
            x,
            y,
            rows: false,
        }
    }

    /// Drops the grid: the drawing area is filled with cells.
    pub(super) fn without_grid(mut self) -> Self {
        self.rows = true;
        self
    }

    pub(super) fn at_x(&self, v: f64) -> Option<f64> {
        self.x.place(v).map(|f| f * self.width)
    }

    pub(super) fn at_y(&self, v: f64) -> Option<f64> {
        self.y.place(v).map(|f| (1.0 - f) * self.height)
    }

    pub(super) fn at(&self, x: f64, y: f64) -> Place {
        Some((self.at_x(x)?, self.at_y(y)?))
    }

    /// The whole drawing: `inside` is clipped to the drawing area, `above` stands in the line over it, to the right.
    pub(super) fn render(&self, label: &str, inside: Markup, above: Markup) -> Markup {
        let (w, h) = (self.width, self.height);
        let all = html! {
            text.axis-label x="0" y="12" { (self.y.label) }
            g transform={ "translate(" (Px(self.left)) " " (Px(TOP)) ")" } {
                @if !self.rows {
                    path.minor d=(self.grid(&self.x.minor, &[])) {}
                    path.grid d=(self.grid(&at(&self.x), &at(&self.y))) {}
                }
                (above)
                svg width=(Px(w)) height=(Px(h)) { (inside) }
                path.frame d={ "M0 0V" (Px(h)) "H" (Px(w)) } {}
                (self.x_ticks())
                @for tick in &self.y.ticks {
                    @if let Some(y) = self.at_y(tick.at) {
                        text.tick.end x="-7" y=(Px(y + 4.0)) { (tick.text) }
                    }
                }
                text.axis-label.end x=(Px(w)) y=(Px(h + 35.0)) { (self.x.label) }
            }
        };
        svg(self.canvas.width(), self.canvas.height(), label, all)
    }

    /// Tick labels along x, kept on the canvas; one that would touch its neighbour is left out.
    fn x_ticks(&self) -> Markup {
        let mut free = f64::NEG_INFINITY;
        let mut shown = Vec::new();
        for tick in &self.x.ticks {
            let Some(x) = self.at_x(tick.at) else {
                continue;
            };
            let half = text_width(&tick.text) / 2.0;
            let x = x.min(self.width + RIGHT - half).max(half - self.left);
            if x - half > free {
                shown.push((x, &tick.text));
                free = x + half + 5.0;
            }
        }
        html! {
            @for (x, text) in shown {
                text.tick.mid x=(Px(x)) y=(Px(self.height + 17.0)) { (text) }
            }
        }
    }

    fn grid(&self, xs: &[f64], ys: &[f64]) -> String {
        let (w, h) = (self.width, self.height);
        let mut d = String::new();
        for x in xs.iter().filter_map(|v| self.at_x(*v)) {
            d += &format!("M{} 0v{}", Px(x).render().0, Px(h).render().0);
        }
        for y in ys.iter().filter_map(|v| self.at_y(*v)) {
            d += &format!("M0 {}h{}", Px(y).render().0, Px(w).render().0);
        }
        d
    }
}

fn at(scale: &Scale) -> Vec<f64> {
    scale.ticks.iter().map(|t| t.at).collect()
}

/// The legend, as text that wraps with the page.
pub(super) fn legend(keys: &[Key]) -> Markup {
    html! {
        @if !keys.is_empty() {
            ul.legend {
                @for key in keys {
                    li {
                        svg.(key.colour.class()) viewBox="0 0 20 10" aria-hidden="true" {
                            @match key.mark {
                                Mark::Line => path.key d="M0 5H20" {},
                                Mark::Dash => path.key.dash d="M0 5H20" {},
                                Mark::Dot => circle.fill cx="10" cy="5" r="3.5" {},
                                Mark::Area => rect.fill.soft width="20" height="10" {},
                            }
                        }
                        (key.name)
                    }
                }
            }
        }
    }
}

/// A labelled line across the drawing area.
pub(super) fn rule(frame: &Frame, at: f64, vertical: bool, text: &str) -> Markup {
    let (w, h) = (frame.width, frame.height);
    let place = if vertical {
        frame.at_x(at)
    } else {
        frame.at_y(at)
    };
    html! {
        @if let Some(p) = place {
            @if vertical {
                path.rule.(Colour::Grey.class()) d={ "M" (Px(p)) " 0v" (Px(h)) } {}
                @let end = p + 5.0 + text_width(text) > w;
                text.note.end[end] x=(Px(if end { p - 5.0 } else { p + 5.0 })) y="11" { (text) }
            } @else {
                path.rule.(Colour::Grey.class()) d={ "M0 " (Px(p)) "h" (Px(w)) } {}
                text.note.end x=(Px(w - 4.0)) y=(Px(if p < 16.0 { p + 13.0 } else { p - 4.0 })) { (text) }
            }
        }
    }
}
