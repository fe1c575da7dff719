//! The disc's pattern in the user's terms: one finding, however it was found.

use std::collections::BTreeMap;

use super::diagnosis::{Evidence, Finding, Parameter, Place};
use super::settle::Settled;
use super::tell::p_value;
use crate::mechanism::Mechanism;

/// Orders of the disc's pattern that were found one by one are one finding, that of the strongest.
pub fn one_disc(findings: &mut Vec<Finding>) {
    let lines = |finding: &Finding| finding.mechanism == Mechanism::LineError;
    let orders: Vec<f64> = findings
        .iter()
        .filter(|finding| lines(finding))
        .flat_map(|finding| finding.place.orders.clone())
        .collect();
    let mut first = true;
    findings.retain_mut(|finding| {
        if !lines(finding) {
            return true;
        }
        if first && orders.len() > 1 {
            finding.place.orders.clone_from(&orders);
            finding.text = format!(
                "{} orders of the turn, the same angle at any speed",
                orders.len()
            );
        }
        std::mem::take(&mut first)
    });
}

/// Edges of a disc that are so few that each is told by itself.
const FEW: usize = 16;

/// The disc's pattern as a finding.
#[must_use]
pub fn disc(settled: &Settled) -> Option<Finding> {
    let pattern = settled.pattern.as_ref()?;
    let unit = Mechanism::LineError.card().unit("rms_rad");
    let parameter = |value: f64, standard_error: f64| Parameter {
        value,
        unit: unit.to_owned(),
        // Where the likelihood does not bend, there is no bound.
        ci95: standard_error
            .is_finite()
            .then_some([value - 1.96 * standard_error, value + 1.96 * standard_error]),
    };
    let mut parameters = BTreeMap::new();
    if pattern.errors_rad.len() <= FEW {
        let each = pattern.errors_rad.iter().enumerate();
        parameters.extend(each.map(|(k, error)| {
            (
                format!("e_{k:02}_rad"),
                parameter(*error, pattern.edge_error_rad),
            )
        }));
    }
    parameters.insert(
        "rms_rad".to_owned(),
        parameter(pattern.rms_rad, pattern.standard_error_rad),
    );
    Some(Finding {
        mechanism: Mechanism::LineError,
        text: format!(
            "every edge has an error of its own, {:.3e} rad RMS, once a turn",
            pattern.rms_rad
        ),
        confidence: 1.0,
        parameters,
        place: Place::default(),
        evidence: Evidence {
            delta_bic: pattern.score,
            p_value: p_value(settled, pattern.score),
            held_out_rms_ratio: settled.held.disc,
            runner_up: None,
        },
        look_alikes: Vec::new(),
        next_recording: None,
    })
}
