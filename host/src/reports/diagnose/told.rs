//! A finding in named facts, the same on the page and on the terminal.

use crate::diagnose::diagnosis::{Answer, Sized};
use crate::diagnose::diagnosis::{Finding, Parameter};
use crate::effect::Site;
use crate::mechanism::Mechanism;
use crate::reports::diagnose::words::{
    in_order, list_or, named, next, parameter_name, sentence, with_interval,
};

use super::cells::{self, cell, sizes};
use super::sure::{determined, sure};

/// Instants that are written out; more are counted.
const INSTANTS: usize = 5;

/// A finding as it is told.
pub(super) struct Told {
    /// What it is.
    pub(super) title: String,
    /// Named facts, each of one or more lines.
    pub(super) facts: Vec<(String, Vec<String>)>,
}

/// The effects of a finding; none where it is counted or is noise.
pub(super) fn effects(answer: &Answer, index: usize) -> &[Sized] {
    answer.cells.get(index).map_or(&[], Vec::as_slice)
}

/// Title of a finding: its mechanism's with its id, or its cell where that has no name.
pub(super) fn title(finding: &Finding, effects: &[Sized]) -> String {
    match finding.mechanism {
        Mechanism::Unknown if effects.is_empty() => sentence(Mechanism::Unknown.title()),
        Mechanism::Unknown if corrects(effects) => {
            "Other numbers than the twin declares".to_owned()
        }
        Mechanism::Unknown => sentence(&cell(effects)),
        mechanism => sentence(&named(mechanism)),
    }
}

/// A finding of an answer.
pub(super) fn told(answer: &Answer, index: usize, finding: &Finding) -> Told {
    let effects = effects(answer, index);
    let mut facts = Vec::new();
    let mut add = |name: &str, lines: Vec<String>| {
        let lines: Vec<String> = lines.into_iter().filter(|line| !line.is_empty()).collect();
        if !lines.is_empty() {
            facts.push((name.to_owned(), lines));
        }
    };
    add("What", vec![without_name(finding, effects)]);
    add(
        "Where",
        vec![
            place(finding, effects),
            edges(finding),
            orders(finding),
            instants(finding),
        ],
    );
    add("How much", how_much(answer, index, finding));
    add("How sure", vec![sure(finding)]);
    let share = answer.shares.get(index).copied().flatten();
    add("Explains", vec![share.map_or_else(String::new, explains)]);
    add("Could also be", vec![alike(finding)]);
    add("Record next", vec![recording(answer, finding)]);
    Told {
        title: title(finding, effects),
        facts,
    }
}

/// Whether all of it is other values of numbers that the twin declares.
fn corrects(effects: &[Sized]) -> bool {
    let declared = |sized: &Sized| matches!(sized.effect.site, Site::Declared(_));
    !effects.is_empty() && effects.iter().all(declared)
}

/// Says so where it is none of the catalogue's.
fn without_name(finding: &Finding, effects: &[Sized]) -> String {
    match (finding.mechanism, effects) {
        (Mechanism::Unknown, []) => "An effect that no mechanism of the catalogue makes".to_owned(),
        (Mechanism::Unknown, effects) if corrects(effects) => String::new(),
        (Mechanism::Unknown, _) => {
            "An effect without a name in the catalogue; its cell and sizes are its model".to_owned()
        }
        _ => String::new(),
    }
}

/// The cell in words; what has none is told by its sentence.
fn place(finding: &Finding, effects: &[Sized]) -> String {
    match effects {
        [] => sentence(finding.text.trim().trim_end_matches('.')),
        // Paths keep their case.
        effects if corrects(effects) => finding.text.clone(),
        effects => sentence(&cell(effects)),
    }
}

/// Which edges of the disc are off, and by how much.
fn edges(finding: &Finding) -> String {
    let each = finding.place.edges.iter().map(|off| {
        let error = Parameter {
            unit: "rad".to_owned(),
            ci95: Some(off.ci95),
            ..Parameter::exact(off.error_rad)
        };
        format!("edge {} by {}", off.edge, with_interval(&error))
    });
    sentence(&each.collect::<Vec<_>>().join(", "))
}

/// Orders that it may have as well.
fn orders(finding: &Finding) -> String {
    let orders = finding.place.orders_alike.iter();
    let orders: Vec<String> = orders.map(|order| format!("{order}")).collect();
    match orders.is_empty() {
        true => String::new(),
        false => format!(
            "Or at order {}: so few edges a turn do not tell them apart, and its torque would be another",
            list_or(&orders)
        ),
    }
}

/// When it happened, of what is counted.
fn instants(finding: &Finding) -> String {
    let times = &finding.place.times_s;
    let counted = matches!(
        finding.mechanism,
        Mechanism::LostEdges | Mechanism::ExtraEdges | Mechanism::IndexSlip
    );
    if times.is_empty() || !counted {
        return String::new();
    }
    let first: Vec<String> = times
        .iter()
        .take(INSTANTS)
        .map(|time| format!("{time:.4} s"))
        .collect();
    let more = match times.len().saturating_sub(INSTANTS) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("At {}{more}", first.join(", "))
}

/// Each number with its interval; sizes of the cell where the finding has no numbers.
fn how_much(answer: &Answer, index: usize, finding: &Finding) -> Vec<String> {
    let effects = effects(answer, index);
    if finding.parameters.is_empty() {
        return sizes(effects, answer.inertia_known)
            .into_iter()
            .map(|size| sentence(&size))
            .collect();
    }
    let each = in_order(&finding.parameters).into_iter();
    let each = each.map(|(name, parameter)| {
        let parameter = Parameter {
            unit: unit(answer, index, name, parameter),
            ..parameter.clone()
        };
        let words = match parameter_name(name, &parameter.unit).as_str() {
            "f" => "Frequency".to_owned(),
            words => sentence(words),
        };
        // A declared number that is measured as none is determined.
        let corrected = effects
            .iter()
            .any(|one| matches!(one.effect.site, Site::Declared(_)));
        let open = match determined(name, &parameter) {
            Some(false) if !corrected => ": not determined by these recordings",
            _ => "",
        };
        format!("{words} {}{open}", number(&parameter))
    });
    each.collect()
}

/// A number with its interval; what is counted has no decimals.
pub(super) fn number(parameter: &Parameter) -> String {
    match parameter.ci95 {
        None if parameter.unit == "1" && parameter.value.fract() == 0.0 => {
            format!("{:.0}", parameter.value).replace('-', "\u{2212}")
        }
        _ => with_interval(parameter),
    }
}

/// The unit of a number: where no card names it that of its cell, or the one at the end of its name.
pub(super) fn unit(answer: &Answer, index: usize, name: &str, parameter: &Parameter) -> String {
    const ENDS: [(&str, &str); 6] = [
        ("_hz_s", "Hz/s"),
        ("_n_m", "N m"),
        ("_rad_s", "rad/s"),
        ("_rad", "rad"),
        ("_hz", "Hz"),
        ("_s", "s"),
    ];
    let by_name = ENDS.iter().find(|(end, _)| name.ends_with(end));
    let finding = answer.diagnosis.findings.get(index);
    let named = finding.is_some_and(|finding| finding.mechanism != Mechanism::Unknown);
    match (effects(answer, index).first(), by_name) {
        _ if named || parameter.unit != "1" => parameter.unit.clone(),
        (Some(first), _) if name == "size" => cells::unit(&first.effect, answer.inertia_known),
        (_, Some((_, unit))) => (*unit).to_owned(),
        _ => parameter.unit.clone(),
    }
}

/// The share of the reducible residual that it explains.
fn explains(share: f64) -> String {
    let percent = match 100.0 * share {
        percent if !percent.is_finite() => return String::new(),
        percent if percent < 0.1 => "under 0.1 %".to_owned(),
        percent if percent > 99.9 => "over 99.9 %".to_owned(),
        // Not all, where others explain something too.
        percent if !(10.0..99.0).contains(&percent) => format!("{percent:.1} %"),
        percent => format!("{percent:.0} %"),
    };
    format!("{percent} of the reducible sum of squares of the residual")
}

/// What else it could be.
fn alike(finding: &Finding) -> String {
    let look_alikes = &finding.look_alikes;
    let names: Vec<String> = look_alikes.iter().copied().map(named).collect();
    let told_by_rig = &finding.mechanism.card().told_by_rig;
    let told = !names.is_empty() && look_alikes.iter().all(|one| told_by_rig.contains(one));
    let by = if told {
        ": no recording tells, but whether the rig has one"
    } else {
        ""
    };
    sentence(&format!("{}{by}", list_or(&names)))
}

/// The recording that would tell; what is said at the top is not said again.
fn recording(answer: &Answer, finding: &Finding) -> String {
    match &finding.next_recording {
        None => String::new(),
        same if *same == answer.diagnosis.next_recording => {
            "The recording named at the top would tell".to_owned()
        }
        Some(other) => next(other),
    }
}

#[cfg(test)]
mod tests {
    use super::explains;

    #[test]
    fn a_share_is_said_to_be_all_only_where_it_is() {
        for (share, expected) in [
            (0.9996, "over 99.9 %"),
            (0.9962, "99.6 %"),
            (0.871, "87 %"),
            (0.0042, "0.4 %"),
        ] {
            let said = explains(share);
            assert!(said.starts_with(&format!("{expected} of")), "{said}");
        }
    }
}
