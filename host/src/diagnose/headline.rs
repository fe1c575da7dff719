//! The first line of a result: a verdict, and in words what a colleague could act on.

use super::diagnosis::{Finding, Place, Verdict};
use super::said::Said;
use crate::effect::words::words;
use crate::mechanism::Mechanism;

/// The verdict on what is said.
pub fn verdict(all: &[Said]) -> Verdict {
    let named = all.iter().filter(|one| one.named).count();
    if all.is_empty() {
        Verdict::Complete
    } else if named == 0 {
        Verdict::Unknown
    } else if all.iter().any(|one| open(&one.finding)) {
        Verdict::Ambiguous
    } else if named < all.len() {
        Verdict::Partly
    } else {
        Verdict::Explained
    }
}

/// Whether a recording would tell more.
fn open(finding: &Finding) -> bool {
    let told_by_rig = &finding.mechanism.card().told_by_rig;
    finding
        .look_alikes
        .iter()
        .any(|one| !told_by_rig.contains(one))
}

/// Orders and frequencies of findings of one name, in a headline.
#[derive(Default)]
struct Rhythms {
    orders: Vec<String>,
    tones: Vec<String>,
}

impl Rhythms {
    fn add(&mut self, place: &Place) {
        let alike = place.orders_alike.iter();
        let alike = alike.map(|order| format!(" or {}", digits(*order)));
        let alike: String = alike.collect();
        let orders = place.orders.iter();
        let orders = orders.map(|order| format!("{}{alike}", digits(*order)));
        self.orders.extend(orders);
        let tones = place.frequencies_hz.iter();
        self.tones
            .extend(tones.map(|hz| format!("{} Hz", digits(*hz))));
    }

    /// Such as " at orders 3, 6 and 9 and at 50 Hz".
    fn words(&self) -> String {
        /// Those that are written out; more are counted.
        const MOST: usize = 6;
        let list = |all: &[String]| match all {
            [] => String::new(),
            [one] => one.clone(),
            all if all.len() > MOST => {
                format!("{} and {} more", all[..MOST].join(", "), all.len() - MOST)
            }
            [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
        };
        let orders = match self.orders.len() {
            0 => "",
            1 => " at order ",
            _ => " at orders ",
        };
        let tones = match (self.orders.len(), self.tones.len()) {
            (_, 0) => "",
            (0, _) => " at ",
            _ => " and at ",
        };
        format!("{orders}{}{tones}{}", list(&self.orders), list(&self.tones))
    }
}

/// A number with as many digits as a headline needs.
fn digits(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The verdict in words.
pub fn summary(verdict: Verdict, all: &[Said]) -> String {
    let list = |start: &str, corrected: bool| {
        let mut names: Vec<(&str, Rhythms)> = Vec::new();
        let own = all.iter().filter(|one| one.corrects() == corrected);
        for one in own.filter(|one| one.named) {
            let finding = &one.finding;
            let name = match (corrected, finding.mechanism) {
                (true, Mechanism::Unknown) => finding.text.as_str(),
                _ => finding.mechanism.title(),
            };
            let at = names.iter().position(|(other, _)| *other == name);
            let at = at.unwrap_or_else(|| {
                names.push((name, Rhythms::default()));
                names.len() - 1
            });
            names[at].1.add(&finding.place);
        }
        let each = names.iter();
        let each = each.map(|(name, rhythms)| format!("{name}{}", rhythms.words()));
        let each: Vec<String> = each.collect();
        (!each.is_empty()).then(|| format!("{start}: {}.", each.join("; ")))
    };
    let said = [
        list("The twin has other numbers than the rig", true),
        list("The twin lacks", false),
    ];
    let said = said.into_iter().flatten().collect::<Vec<_>>().join(" ");
    match verdict {
        Verdict::Complete => "The twin explains the recordings; what is left is noise.".to_owned(),
        Verdict::Explained => said,
        Verdict::Partly => match nameless(all) {
            Some(cell) => {
                format!("{said} It lacks as well what has no name in the catalogue: {cell}.")
            }
            None => format!("{said} More than noise is left."),
        },
        Verdict::Ambiguous => {
            let mut findings = all.iter().map(|one| &one.finding);
            let first = findings.find(|finding| open(finding)).into_iter();
            let others = first.flat_map(|first| &first.look_alikes);
            let others: Vec<&str> = others.map(|one| one.title()).collect();
            let others = others.join("; ");
            format!("{said} These recordings allow as well: {others}.")
        }
        Verdict::Unknown => match nameless(all) {
            Some(cell) => format!("The twin lacks what has no name in the catalogue: {cell}."),
            None => "Something is there that is none of the known mechanisms.".to_owned(),
        },
    }
}

/// What has no name and yet a model, in words: the first effect, and how many more there are.
fn nameless(all: &[Said]) -> Option<String> {
    let mut cells = all
        .iter()
        .filter(|one| !one.named)
        .flat_map(|one| &one.cells);
    let first = words(&cells.next()?.effect);
    Some(match cells.count() {
        0 => first,
        1 => format!("{first}, and 1 effect more"),
        more => format!("{first}, and {more} effects more"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_and_frequencies_are_listed_once_each_and_many_are_counted() {
        let words = |orders: &[f64], hz: &[f64]| {
            let mut rhythms = Rhythms::default();
            rhythms.add(&Place {
                orders: orders.to_vec(),
                frequencies_hz: hz.to_vec(),
                ..Place::default()
            });
            rhythms.words()
        };
        assert_eq!(words(&[], &[]), "");
        assert_eq!(words(&[3.0], &[]), " at order 3");
        assert_eq!(
            words(&[3.0, 4.5], &[50.0]),
            " at orders 3 and 4.5 and at 50 Hz"
        );
        assert_eq!(words(&[], &[49.9, 50.0]), " at 49.9 Hz and 50 Hz");
        let many: Vec<f64> = (1..9).map(f64::from).collect();
        assert_eq!(words(&many, &[]), " at orders 1, 2, 3, 4, 5, 6 and 2 more");
    }
}
