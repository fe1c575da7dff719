//! A table of magnitudes as coloured cells on a logarithmic scale, the number in each.

use maud::{Markup, Render, html};

use super::draw::{Canvas, Px, svg, text_width};
use super::number::{MINUS, si_digits};
use super::plot::Colour;
use super::scale::usable;

/// Opacity of the fullest cell: ink on it is still easy to read, on light and dark pages.
const FULLEST: f64 = 0.62;
/// Size of text, px.
const TEXT: f64 = 12.0;
/// Space to the right, px: the last column's name stands askew.
const RIGHT: f64 = 24.0;
/// Distance of the lines over a cell that can't be, px.
const HATCH: f64 = 7.0;
/// Pieces of the scale bar.
const PIECES: usize = 31;

/// Magnitudes by row and column. The largest is outlined; a cell without a value is hatched.
#[derive(Clone, Debug)]
pub struct Heat {
    label: String,
    rows: Vec<String>,
    columns: Vec<String>,
    cells: Vec<Vec<Option<f64>>>,
    range: (f64, f64),
    bold_from: Option<f64>,
}

impl Heat {
    /// Cells of `label`, each row with its name; rows and columns that have no value are hatched.
    pub fn new(label: impl Into<String>, columns: &[&str]) -> Self {
        Self {
            label: label.into(),
            rows: Vec::new(),
            columns: columns.iter().map(|name| (*name).to_owned()).collect(),
            cells: Vec::new(),
            range: (1.0, 10.0),
            bold_from: None,
        }
    }

    /// Adds a row.
    pub fn row(mut self, name: impl Into<String>, values: &[Option<f64>]) -> Self {
        self.rows.push(name.into());
        let cell = |at: usize| values.get(at).copied().flatten().filter(|v| usable(*v));
        self.cells.push((0..self.columns.len()).map(cell).collect());
        self
    }

    /// The values of the palest and the fullest shade. Ends that are not above zero and rising are ignored.
    pub fn range(mut self, lo: f64, hi: f64) -> Self {
        if usable(lo) && usable(hi) && lo > 0.0 && lo < hi {
            self.range = (lo, hi);
        }
        self
    }

    /// Sets numbers from this on in bold.
    pub fn bold_from(mut self, value: f64) -> Self {
        self.bold_from = usable(value).then_some(value);
        self
    }

    /// Row and column of the largest value above zero, the first of equals.
    fn largest(&self) -> Option<(usize, usize)> {
        let mut best: Option<(f64, (usize, usize))> = None;
        for (r, row) in self.cells.iter().enumerate() {
            for (c, cell) in row.iter().enumerate() {
                if let Some(v) = cell.filter(|v| *v > best.map_or(0.0, |(most, _)| most)) {
                    best = Some((v, (r, c)));
                }
            }
        }
        best.map(|(_, at)| at)
    }

    fn shade(&self, value: f64) -> f64 {
        let (lo, hi) = self.range;
        if value <= lo {
            return 0.0;
        }
        FULLEST * ((value / lo).ln() / (hi / lo).ln()).clamp(0.0, 1.0)
    }

    pub(super) fn draw(&self, canvas: Canvas, label: &str) -> Markup {
        let widest = |names: &[String]| {
            let widths = names.iter().map(|name| text_width(name));
            widths.fold(0.0, f64::max)
        };
        let width = canvas.width();
        let left = (widest(&self.rows) + 10.0).min(width * 0.4);
        let top = widest(&self.columns) * 0.72 + 14.0;
        let w = (width - left - RIGHT) / self.columns.len().max(1) as f64;
        let h = (w * 0.85).clamp(22.0, 30.0);
        let high = h * self.rows.len() as f64;
        let inside = html! {
            g transform={ "translate(" (Px(left)) " " (Px(top)) ")" } {
                @for (c, name) in self.columns.iter().enumerate() {
                    text.tick transform={ "translate(" (Px((c as f64 + 0.5) * w)) " -6) rotate(-45)" } { (name) }
                }
                @for (r, (name, row)) in self.rows.iter().zip(&self.cells).enumerate() {
                    text.tick.end x="-7" y=(Px((r as f64 + 0.5) * h + 4.0)) { (name) }
                    @for (c, cell) in row.iter().enumerate() {
                        (self.cell(*cell, [name, &self.columns[c]], [c as f64 * w, r as f64 * h, w, h]))
                    }
                }
                @if let Some((r, c)) = self.largest() {
                    rect.pick x=(Px(c as f64 * w)) y=(Px(r as f64 * h)) width=(Px(w)) height=(Px(h)) {}
                }
                (self.scale_bar(high + 14.0, width - left - RIGHT))
            }
        };
        svg(width, top + high + 60.0, label, inside)
    }

    fn cell(&self, value: Option<f64>, names: [&String; 2], [x, y, w, h]: [f64; 4]) -> Markup {
        let Some(value) = value else {
            return html! {
                rect.heat-edge x=(Px(x)) y=(Px(y)) width=(Px(w)) height=(Px(h)) {}
                path.hatch d=(hatch(x, y, w, h)) {}
            };
        };
        let text = short(value);
        let size = (TEXT * (w - 3.0) / text_width(&text).max(1.0)).clamp(7.0, TEXT);
        let bold = self.bold_from.is_none_or(|from| value >= from);
        html! {
            g {
                title { (names[0]) ", " (names[1]) ": " (exact(value)) }
                rect.fill.(Colour::Blue.class()) fill-opacity={ (format!("{:.3}", self.shade(value))) }
                    x=(Px(x)) y=(Px(y)) width=(Px(w)) height=(Px(h)) {}
                rect.heat-edge x=(Px(x)) y=(Px(y)) width=(Px(w)) height=(Px(h)) {}
                text.mid.heat-number[bold] style={ "font-size:" (Px(size)) "px" }
                    x=(Px(x + w / 2.0)) y=(Px(y + h / 2.0 + 0.35 * size)) { (text) }
            }
        }
    }

    fn scale_bar(&self, y: f64, width: f64) -> Markup {
        let (lo, hi) = self.range;
        // Whole pixels, as neighbours that share one would be darker there.
        let end = |i: usize| (width * i as f64 / PIECES as f64).round();
        let decades = (lo.log10() - 1e-9).ceil() as i32..=(hi.log10() + 1e-9).floor() as i32;
        html! {
            @for i in 0..PIECES {
                @let opacity = FULLEST * (i as f64 + 0.5) / PIECES as f64;
                rect.cell.(Colour::Blue.class()) fill-opacity={ (format!("{opacity:.3}")) }
                    x=(Px(end(i))) y=(Px(y)) width=(Px(end(i + 1) - end(i))) height="8" {}
            }
            @for e in decades {
                @let value = 10f64.powi(e);
                text.tick.mid x=(Px(width * (value / lo).ln() / (hi / lo).ln())) y=(Px(y + 22.0)) { (short(value)) }
            }
            text.axis-label.end x=(Px(width)) y=(Px(y + 38.0)) { (self.label) }
        }
    }
}

/// Lines askew over a cell; no pattern, as a page has no addresses.
fn hatch(x: f64, y: f64, w: f64, h: f64) -> String {
    let text = |v: f64| Px(v).render().0;
    let mut d = String::new();
    let mut along = HATCH / 2.0;
    while along < w + h {
        let (from, to) = (along.min(w), (along - h).max(0.0));
        let (low, high) = ((along - w).max(0.0), along.min(h));
        d += &format!(
            "M{} {}L{} {}",
            text(x + from),
            text(y + low),
            text(x + to),
            text(y + high)
        );
        along += HATCH;
    }
    d
}

/// Two or three digits: `0.4`, `48`, `1.2k`.
fn short(value: f64) -> String {
    let steps = [(1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k")];
    let size = value.abs();
    let step = steps.into_iter().find(|(by, _)| size >= 0.9995 * by);
    let (by, letter) = step.unwrap_or((1.0, ""));
    let text = match size / by {
        n if n >= 9999.5 => return si_digits(value, "", 2).0,
        n if n < 9.95 => format!("{n:.1}"),
        n => format!("{n:.0}"),
    };
    let text = text.strip_suffix(".0").unwrap_or(&text);
    let sign = if value < 0.0 && text != "0" {
        MINUS
    } else {
        ""
    };
    format!("{sign}{text}{letter}")
}

/// Four digits.
fn exact(value: f64) -> String {
    si_digits(value, "", 4).0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> Heat {
        Heat::new("Gain per parameter", &["order", "frequency"])
            .row("torque", &[Some(5210.0), Some(0.42)])
            .row("disc", &[Some(31.0), None])
            .range(1.0, 1e4)
            .bold_from(11.0)
    }

    #[test]
    fn numbers_are_short_and_round_up_into_the_next_letter() {
        for (value, text) in [
            (0.0, "0"),
            (0.42, "0.4"),
            (1.0, "1"),
            (9.96, "10"),
            (999.4, "999"),
            (999.6, "1k"),
            (1234.0, "1.2k"),
            (110_000.0, "110k"),
            (999_600.0, "1M"),
            (2.34e6, "2.3M"),
            (-3.2, "\u{2212}3.2"),
        ] {
            assert_eq!(short(value), text, "{value}");
        }
    }

    #[test]
    fn each_cell_says_its_number_and_the_largest_is_outlined() {
        let drawn = map().draw(Canvas::Half, "map").into_string();
        let document = roxmltree::Document::parse(&drawn).unwrap();
        let titles: Vec<&str> = document
            .descendants()
            .filter(|node| node.has_tag_name("title"))
            .filter_map(|node| node.text())
            .collect();
        assert_eq!(
            titles,
            [
                "torque, order: 5210",
                "torque, frequency: 0.4200",
                "disc, order: 31.00"
            ]
        );
        let classed = |class: &str| {
            let is = |node: &roxmltree::Node| node.attribute("class") == Some(class);
            document.descendants().filter(is).collect::<Vec<_>>()
        };
        assert_eq!(classed("hatch").len(), 1);
        let bold: Vec<_> = classed("mid heat-number")
            .iter()
            .map(|n| n.text())
            .collect();
        assert_eq!(bold, [Some("5.2k"), Some("31")]);
        let [pick] = classed("pick")[..] else {
            panic!("one cell is the largest")
        };
        let first = classed("heat-edge")[0];
        assert_eq!(pick.attribute("x"), first.attribute("x"));
        assert_eq!(pick.attribute("y"), first.attribute("y"));
    }

    #[test]
    fn shades_go_with_the_logarithm_and_stay_within_the_range() {
        let map = map();
        assert_eq!(map.shade(0.3), 0.0);
        assert!((map.shade(100.0) - 0.5 * FULLEST).abs() < 1e-12);
        assert_eq!(map.shade(1e9), FULLEST);
    }

    #[test]
    fn a_map_without_cells_or_with_useless_values_is_still_drawn() {
        let empty = Heat::new("x", &[])
            .draw(Canvas::Narrow, "none")
            .into_string();
        assert!(roxmltree::Document::parse(&empty).is_ok());
        let bad = Heat::new("x", &["a", "b"]).row("r", &[Some(f64::NAN), Some(f64::INFINITY)]);
        let drawn = bad.draw(Canvas::Half, "bad").into_string();
        assert!(!drawn.contains("NaN") && !drawn.contains("class=\"pick\""));
    }
}
