//! A value by angle and turn as a strip of coloured cells, one row a turn.

use maud::{Markup, html};

use super::draw::{Canvas, Frame, Px, text_width};
use super::number::si;
use super::plot::{Axis, Colour};
use super::scale::{Extent, Scale, usable};

/// Shades of each sign.
const SHADES: usize = 8;
/// Cells in one drawing; more would cost file size and show nothing more.
const CELLS: usize = 9000;
/// Rows in one drawing.
const ROWS: usize = 80;

/// A signed value over one turn (columns) and many turns (rows).
#[derive(Clone, Debug)]
pub struct Strip {
    x: Axis,
    label: String,
    unit: String,
    rows: Vec<Vec<f64>>,
    limit: Option<f64>,
}

impl Strip {
    /// An empty strip of `label` in `unit`, over the shaft angle.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            x: Axis::turn(),
            label: label.into(),
            unit: unit.into(),
            rows: Vec::new(),
            limit: None,
        }
    }

    /// Adds the next turn: values evenly spaced over 0 to 360 degrees, NaN where there is none.
    pub fn turn(mut self, values: &[f64]) -> Self {
        self.rows.push(values.to_vec());
        self
    }

    /// Sets the value of the fullest shade; without, 99 % of the cells lie within it.
    pub fn limit(mut self, limit: f64) -> Self {
        self.limit = (usable(limit) && limit > 0.0).then_some(limit);
        self
    }

    pub(super) fn draw(&self, canvas: Canvas, label: &str) -> Markup {
        let y = Axis::new("Turn", "").range(0.5, self.rows.len().max(1) as f64 + 0.5);
        let x = Scale::fit(&self.x, Extent::default(), 0.0, canvas.ticks());
        let mut y = Scale::fit(&y, Extent::default(), 0.0, 6);
        y.ticks.retain(|t| t.at.fract() == 0.0);
        let frame = Frame::new(canvas, x, y).without_grid();
        let rows = self.rows.len().clamp(1, ROWS);
        let columns = (CELLS / rows).min((frame.width / 2.0) as usize).max(1);
        let grid: Vec<Vec<Option<f64>>> = (0..rows).map(|r| self.cells(r, rows, columns)).collect();
        let limit = self.limit.unwrap_or_else(|| robust_limit(&grid));
        let inside = html! {
            rect.empty width=(Px(frame.width)) height=(Px(frame.height)) {}
            @for shade in 1..=SHADES {
                @for (colour, sign) in [(Colour::BEFORE, 1.0), (Colour::AFTER, -1.0)] {
                    @let d = shade_path(&grid, &frame, columns, |v| level(v * sign, limit) == shade);
                    @if !d.is_empty() { path.(colour.class()).cell fill-opacity=(opacity(shade)) d=(d) {} }
                }
            }
        };
        frame.render(label, inside, self.scale_bar(&frame, limit))
    }

    /// One drawn row: of all values in a cell the largest in size.
    fn cells(&self, row: usize, rows: usize, columns: usize) -> Vec<Option<f64>> {
        let total = self.rows.len();
        let mut out = vec![None; columns];
        for turn in
            &self.rows[(row * total / rows).min(total)..((row + 1) * total / rows).min(total)]
        {
            // Fewer values than columns: each value fills several.
            let steps = turn.len().max(columns);
            for i in 0..if turn.is_empty() { 0 } else { steps } {
                let value = turn[i * turn.len() / steps];
                let cell: &mut Option<f64> = &mut out[i * columns / steps];
                if usable(value) && cell.is_none_or(|c| c.abs() < value.abs()) {
                    *cell = Some(value);
                }
            }
        }
        out
    }

    fn scale_bar(&self, frame: &Frame, limit: f64) -> Markup {
        let (low, high) = (
            si(-limit, &self.unit),
            format!("+{}", si(limit, &self.unit)),
        );
        let cell = 7.0;
        let bar = cell * (2 * SHADES) as f64;
        let start = frame.width - text_width(&high) - 6.0 - bar;
        html! {
            @if frame.width > 420.0 {
                text.axis-label.end x=(Px(start - text_width(&low) - 14.0)) y="-14" { (self.label) }
            }
            text.tick.end x=(Px(start - 5.0)) y="-14" { (low) }
            @for i in 0..2 * SHADES {
                @let negative = i < SHADES;
                @let shade = if negative { SHADES - i } else { i + 1 - SHADES };
                rect.cell.(if negative { Colour::AFTER } else { Colour::BEFORE }.class()) fill-opacity=(opacity(shade))
                    x=(Px(start + cell * i as f64)) y="-23" width=(Px(cell)) height="9" {}
            }
            text.tick.end x=(Px(frame.width)) y="-14" { (high) }
        }
    }
}

fn opacity(shade: usize) -> String {
    format!("{:.2}", shade as f64 / SHADES as f64)
}

/// 0 for values of the other sign or near zero, `SHADES` at the limit and beyond.
fn level(value: f64, limit: f64) -> usize {
    (value / limit * SHADES as f64)
        .round()
        .clamp(0.0, SHADES as f64) as usize
}

fn robust_limit(grid: &[Vec<Option<f64>>]) -> f64 {
    let mut sizes: Vec<f64> = grid.iter().flatten().flatten().map(|v| v.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let limit = sizes.get(sizes.len() * 99 / 100).copied().unwrap_or(0.0);
    if limit > 0.0 { limit } else { 1.0 }
}

/// Rectangles over each run of cells that belong to one shade.
fn shade_path(
    grid: &[Vec<Option<f64>>],
    frame: &Frame,
    columns: usize,
    belongs: impl Fn(f64) -> bool,
) -> String {
    let (w, h) = (
        frame.width / columns as f64,
        frame.height / grid.len() as f64,
    );
    let text = |v: f64| maud::Render::render(&Px(v)).0;
    let mut d = String::new();
    for (r, row) in grid.iter().enumerate() {
        // The first turn is at the foot, as its tick says.
        let top = h * (grid.len() - 1 - r) as f64;
        let mut start = None;
        // One past the end closes the last run.
        let cells = row.iter().take(columns).copied().chain([None]);
        for (c, cell) in cells.enumerate() {
            let inside = cell.is_some_and(&belongs);
            match (inside, start) {
                (true, None) => start = Some(c),
                (false, Some(from)) => {
                    let (x, wide) = (from as f64 * w, (c - from) as f64 * w);
                    let (x, wide, h) = (text(x), text(wide), text(h));
                    d += &format!("M{x} {}h{wide}v{h}h-{wide}z", text(top));
                    start = None;
                }
                _ => {}
            }
        }
    }
    d
}
