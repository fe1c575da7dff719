//! `quadcal diagnose --mechanisms`: what a diagnosis can name, and what is known of each.

use std::fmt::Write as _;

use crate::mechanism::{Card, Mechanism, Quantity};

/// Columns of a line.
const COLUMNS: usize = 100;
/// Where values begin.
const INDENT: usize = 17;

/// A mechanism's card, or a line for each mechanism.
#[must_use]
pub fn text(one: Option<Mechanism>) -> String {
    match one {
        Some(mechanism) => card(mechanism),
        None => list(),
    }
}

/// The id on the command line.
pub fn mechanism(text: &str) -> Result<Mechanism, String> {
    Mechanism::from_id(text).ok_or_else(|| {
        let parts: Vec<&str> = text.split(['_', ' ', '-']).collect();
        let ids = Mechanism::ALL.iter().map(|one| one.id());
        let near = ids.filter(|id| parts.iter().any(|part| part.len() > 2 && id.contains(part)));
        let near: Vec<&str> = near.collect();
        let near = match near.is_empty() {
            true => String::new(),
            false => format!(", perhaps {}", near.join(" or ")),
        };
        format!("give an id of the list that '--mechanisms' alone prints{near}")
    })
}

fn list() -> String {
    let width = Mechanism::ALL.iter().map(|one| one.id().len());
    let width = width.max().unwrap_or(0);
    Mechanism::ALL
        .iter()
        .map(|one| format!("{one:width$}  {}\n", one.title()))
        .collect()
}

fn card(mechanism: Mechanism) -> String {
    let Card {
        title,
        physics,
        equation,
        source,
        twin,
        parameters,
        locked_to,
        speed_exponent,
        edge_classes,
        look_alikes,
        separated_by,
        ..
    } = mechanism.card();
    let mut text = format!("{mechanism}: {title}\n\n");
    let mut row = |name: &str, value: &str| text += &wrapped(name, value);
    row("Physics", physics);
    row("Equation", equation);
    row("Source", source);
    row("Keeps step with", &locked_to.join(", or "));
    if mechanism != Mechanism::Unknown {
        row("Edges", edge_classes);
        let size = speed_exponent.map_or_else(
            || "no one power of the speed".to_owned(),
            |exponent| format!("speed^{exponent}"),
        );
        row("Size in angle", &size);
    }
    row("In the twin", twin);
    let ids = |all: &[Mechanism]| all.iter().map(|one| one.id()).collect::<Vec<_>>();
    row("Look-alikes", &ids(look_alikes).join(", "));
    row("Told apart by", separated_by);
    text += "\nParameters, with the range outside of which a fit gets no name\n";
    text += &quantities(parameters);
    text
}

fn quantities(all: &[Quantity]) -> String {
    let longest = |name: fn(&Quantity) -> &str| all.iter().map(|one| name(one).len()).max();
    let name = longest(|one| &one.name).unwrap_or(0);
    let unit = longest(|one| &one.unit).unwrap_or(0);
    let mut text = String::new();
    for one in all {
        let range = one.range.map(number).join(" to ");
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "  {:name$}  {:unit$}  {range:16}  {}",
            one.name, one.unit, one.what
        );
    }
    text
}

/// A bound, short.
fn number(value: f64) -> String {
    let plain = format!("{value}");
    if plain.len() <= 6 {
        return plain;
    }
    let rounded = format!("{value:.3}").parse();
    match rounded {
        Ok(rounded @ 0.01..1e4) => format!("{rounded:?}"),
        _ => format!("{value:e}"),
    }
}

/// A named text, its lines one under the other; nothing of an empty text.
fn wrapped(name: &str, value: &str) -> String {
    let mut text = String::new();
    let mut line = format!("{name:INDENT$}");
    let mut empty = true;
    for word in value.split_whitespace() {
        if !empty && line.len() + 1 + word.len() > COLUMNS {
            text += line.trim_end();
            text.push('\n');
            line = " ".repeat(INDENT);
            empty = true;
        }
        if !empty {
            line.push(' ');
        }
        line += word;
        empty = false;
    }
    if empty {
        return text;
    }
    text += &line;
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mechanism_has_a_line_and_a_card_no_wider_than_a_terminal() {
        let list = text(None);
        assert_eq!(list.lines().count(), Mechanism::ALL.len());
        for mechanism in Mechanism::ALL {
            let line = list.lines().find(|line| {
                let id = line.split_whitespace().next();
                id == Some(mechanism.id())
            });
            assert!(line.unwrap().ends_with(mechanism.title()));
            let card = text(Some(mechanism));
            for part in &mechanism.card().parameters {
                assert!(card.contains(&part.name), "{card}");
            }
            for other in &mechanism.card().look_alikes {
                assert!(card.contains(other.id()), "{card}");
            }
            let prose = card.split("\nParameters").next().unwrap();
            assert!(prose.lines().all(|line| line.len() <= COLUMNS), "{card}");
        }
    }

    #[test]
    fn bounds_are_short() {
        for (value, short) in [
            (0.0, "0"),
            (-0.53, "-0.53"),
            (std::f64::consts::TAU, "6.283"),
            (1e7, "1e7"),
            (1e-7, "1e-7"),
            (0.999, "0.999"),
            (11_000.0, "11000"),
        ] {
            assert_eq!(number(value), short);
        }
    }

    #[test]
    fn an_id_that_is_none_brings_those_like_it() {
        let said = mechanism("gear").unwrap_err();
        assert!(said.ends_with("perhaps gear_mesh"), "{said}");
        assert!(mechanism("xyzzy").unwrap_err().ends_with("prints"));
    }
}
