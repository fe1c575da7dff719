//! The page around text, tables and figures.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::draw::{Canvas, legend};
use super::number::si;
use super::parts::{Block, Body, Card, Cell, Figure, Level, Tile};
use super::source::Footer;
use super::{Report, Verdict};

const STYLE: &str = include_str!("style.css");

/// Written out, as maud leaves void elements open and the page is to be well-formed XML too.
const META: &str = r#"<meta charset="utf-8"/><meta name="viewport" content="width=device-width, initial-scale=1"/><meta name="color-scheme" content="light dark"/>"#;

pub(super) fn render(report: &Report) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                (PreEscaped(META))
                title { (report.title) " – " (report.subtitle) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main {
                    header {
                        h1 { (report.title) }
                        @if !report.subtitle.is_empty() { p.subtitle { (report.subtitle) } }
                    }
                    @if let Some(v) = &report.verdict { (verdict(v)) }
                    (body(&report.body))
                    @if let Some(f) = &report.footer { (footer(f)) }
                }
            }
        }
    }
}

fn verdict(verdict: &Verdict) -> Markup {
    let (class, word, sign) = match verdict.level {
        Level::Good => ("good", "Good", "M5 10.5l3.5 3.5 6.5-7.5"),
        Level::Warn => ("warn", "Caution", "M10 5v6.5M10 14.8v.2"),
        Level::Bad => ("bad", "Bad", "M6 6l8 8M14 6l-8 8"),
    };
    html! {
        section.verdict.(class) {
            p.headline {
                svg viewBox="0 0 20 20" role="img" aria-label=(word) {
                    circle cx="10" cy="10" r="10" {}
                    path d=(sign) {}
                }
                (verdict.headline)
            }
            @if !verdict.action.is_empty() { p.action { (verdict.action) } }
            @if !verdict.tiles.is_empty() {
                div.tiles { @for t in &verdict.tiles { (tile(t)) } }
            }
        }
    }
}

fn tile(tile: &Tile) -> Markup {
    html! {
        div.tile {
            p.label { (tile.label) }
            p.value { (tile.value) @if !tile.unit.is_empty() { span.unit { (tile.unit) } } }
            @if !tile.note.is_empty() { p.remark { (tile.note) } }
        }
    }
}

fn body(content: &Body) -> Markup {
    html! {
        @for block in &content.blocks {
            @match block {
                Block::Section { title, paragraphs } => {
                    @if !title.is_empty() { h2 { (title) } }
                    @for p in paragraphs { p.text { (p) } }
                }
                Block::Table { caption, columns, rows } => (table(caption, columns, rows)),
                Block::Figure(f) => (figure(f, Canvas::Wide)),
                Block::Pair(pair) => div.pair {
                    @for f in pair.iter() { (figure(f, Canvas::Half)) }
                },
                Block::Card(c) => (card(c)),
                Block::Details { title, body: inner } => details {
                    summary { (title) }
                    (body(inner))
                },
            }
        }
    }
}

fn card(card: &Card) -> Markup {
    html! {
        section.card {
            h3 { (card.title) }
            div.facts.split[card.figure.is_some()] {
                dl {
                    @for (name, texts) in &card.facts {
                        dt { (name) }
                        dd { @for text in texts { p { (text) } } }
                    }
                }
                @if let Some(f) = &card.figure { (figure(f, Canvas::Half)) }
            }
            (body(&card.body))
        }
    }
}

fn figure(figure: &Figure, canvas: Canvas) -> Markup {
    let (plot, caption) = (&figure.plot, figure.caption.as_str());
    html! {
        figure {
            (legend(&plot.keys()))
            @if plot.is_round() {
                div.round { (plot.draw(canvas, caption)) }
            } @else {
                div.wide { (plot.draw(canvas, caption)) }
                div.narrow { (plot.draw(Canvas::Narrow, caption)) }
            }
            @if !caption.is_empty() { figcaption { (caption) } }
        }
    }
}

fn table(caption: &str, columns: &[String], rows: &[Vec<Cell>]) -> Markup {
    let flush: Vec<bool> = (0..columns.len())
        .map(|c| {
            let mut cells = rows.iter().filter_map(|r| r.get(c));
            let words = |cell: &Cell| matches!(cell, Cell::Text(_));
            !rows.is_empty() && !cells.any(words)
        })
        .collect();
    html! {
        div.table {
            table {
                @if !caption.is_empty() { caption { (caption) } }
                thead { tr { @for (c, name) in columns.iter().enumerate() { th.number[flush[c]] scope="col" { (name) } } } }
                tbody {
                    @for row in rows {
                        tr {
                            @for cell in row {
                                @match cell {
                                    Cell::Text(t) => td { (t) },
                                    Cell::Number(n) => td.number { (n) },
                                    Cell::Empty => td.number.none { "–" },
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn footer(footer: &Footer) -> Markup {
    html! {
        footer {
            dl {
                dt { "Program" } dd { (footer.version) }
                dt { "Command" } dd { code { (footer.command) } }
                @for file in &footer.inputs {
                    dt { "Input" }
                    dd {
                        (file.name) ", " (si(file.bytes as f64, "B"))
                        span.hash { "SHA-256 " (file.sha256) }
                    }
                }
            }
        }
    }
}
