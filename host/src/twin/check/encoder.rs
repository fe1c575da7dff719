//! Ranges and conflicts of the encoder and its errors.

use std::f64::consts::PI;

use super::{ANGLE_ADVICE, Checker};
use crate::twin::{Encoder, Errors, Gap, Position, Twin};

const LEAVE_ONE: &str = "leave at least one tooth on the wheel";
/// Most gaps of a wheel.
const GAPS_MAX: usize = 1000;

fn check_gaps(c: &mut Checker<'_>, teeth: u32, gaps: &[Gap]) {
    c.list("encoder.wheel.gaps", gaps.len(), GAPS_MAX);
    let mut left = teeth;
    let mut taken: Vec<Gap> = Vec::new();
    for (i, gap) in gaps.iter().take(GAPS_MAX).enumerate() {
        let key = format!("encoder.wheel.gaps[{i}]");
        let last = teeth.saturating_sub(1);
        c.count(
            &format!("{key}.at"),
            gap.at,
            0,
            last,
            "count places from 0, the first tooth after the reference",
        );
        c.count(
            &format!("{key}.missing"),
            gap.missing,
            1,
            teeth.saturating_sub(gap.at),
            "a gap ends with the turn: write what is beyond as a gap at 0",
        );
        let apart = |other: &Gap| {
            gap.at >= other.at.saturating_add(other.missing)
                || other.at >= gap.at.saturating_add(gap.missing)
        };
        c.require(
            taken.iter().all(apart),
            &key,
            format_args!("at {}", gap.at),
            "places that no other gap has",
            "let gaps not overlap",
        );
        taken.push(*gap);
        left = left.saturating_sub(gap.missing);
    }
    c.require(
        left > 0 || teeth == 0,
        "encoder.wheel.gaps",
        "no tooth left",
        "gaps of less than all teeth",
        LEAVE_ONE,
    );
}

impl Twin {
    pub(super) fn check_encoder(&self, c: &mut Checker<'_>) {
        match &self.encoder {
            &Encoder::Quadrature { lines, .. } => {
                c.count(
                    "encoder.quadrature.lines",
                    lines,
                    1,
                    1_000_000,
                    "give the grating lines of one turn",
                );
            }
            &Encoder::Hall { pole_pairs } => {
                c.count(
                    "encoder.hall.pole_pairs",
                    pole_pairs,
                    1,
                    10_000,
                    "give the magnet pole pairs of one turn",
                );
            }
            Encoder::Wheel {
                teeth,
                missing,
                gaps,
            } => {
                let (teeth, missing) = (*teeth, *missing);
                c.count(
                    "encoder.wheel.teeth",
                    teeth,
                    1,
                    1_000_000,
                    "give the tooth places of one turn",
                );
                c.count(
                    "encoder.wheel.missing",
                    missing,
                    0,
                    teeth.saturating_sub(1),
                    LEAVE_ONE,
                );
                c.require(
                    missing == 0 || gaps.is_empty(),
                    "encoder.wheel.gaps",
                    "given together with missing",
                    "missing alone, or gaps alone",
                    "put the missing teeth into the list of gaps",
                );
                check_gaps(c, teeth, gaps);
            }
        }
    }

    pub(super) fn check_errors(&self, c: &mut Checker<'_>) {
        let e = &self.errors;
        if let Some(seed) = e.seed {
            c.seed("errors.seed", seed);
        }
        match e.position {
            Some(Position::Uniform { amplitude_rad, .. }) => {
                c.between(
                    "errors.position.uniform.amplitude_rad",
                    amplitude_rad,
                    0.0,
                    PI,
                    ANGLE_ADVICE,
                );
            }
            Some(Position::Normal { rms_rad, .. }) => {
                c.between(
                    "errors.position.normal.rms_rad",
                    rms_rad,
                    0.0,
                    PI,
                    ANGLE_ADVICE,
                );
            }
            None => {}
        }
        let hall = matches!(self.encoder, Encoder::Hall { .. });
        let quadrature = matches!(self.encoder, Encoder::Quadrature { .. });
        for (key, value, has_channel) in [
            ("errors.width_a_rad", e.width_a_rad, true),
            ("errors.width_b_rad", e.width_b_rad, hall || quadrature),
            ("errors.width_c_rad", e.width_c_rad, hall),
            ("errors.quadrature_rad", e.quadrature_rad, quadrature),
            ("errors.shift_b_rad", e.shift_b_rad, hall),
            ("errors.shift_c_rad", e.shift_c_rad, hall),
        ] {
            c.between(key, value, -PI, PI, ANGLE_ADVICE);
            c.require(
                has_channel || value == 0.0,
                key,
                value,
                "0 for this kind of encoder",
                "take it out, or change the encoder's kind",
            );
        }
        for (key, harmonic) in [
            ("errors.eccentricity", e.eccentricity),
            ("errors.tilt", e.tilt),
        ] {
            if let Some(h) = harmonic {
                c.between(
                    &format!("{key}.amplitude_rad"),
                    h.amplitude_rad,
                    0.0,
                    PI,
                    ANGLE_ADVICE,
                );
                c.between(
                    &format!("{key}.phase_rad"),
                    h.phase_rad,
                    -1e3,
                    1e3,
                    ANGLE_ADVICE,
                );
            }
        }
        self.check_error_list(c);
    }

    fn check_wave_errors(&self, c: &mut Checker<'_>) {
        let (key, sure) = (
            "errors.wave_standard_errors_rad",
            &self.errors.wave_standard_errors_rad,
        );
        if sure.is_empty() {
            return;
        }
        c.require(
            self.errors.csv.is_some(),
            key,
            "given without a list",
            "beside errors.csv",
            "these are standard errors of the list that errors.csv names",
        );
        let most = self.encoder.grid_edges() as usize / 2;
        c.require(
            sure.len() <= most,
            key,
            format_args!("{} numbers", sure.len()),
            &format!("up to {most} numbers, one for each order of a turn"),
            "leave out the orders that the disc's edges can't show",
        );
        for (at, value) in sure.iter().enumerate() {
            c.between(&format!("{key}[{at}]"), *value, 0.0, PI, ANGLE_ADVICE);
        }
    }

    fn check_error_list(&self, c: &mut Checker<'_>) {
        let e = &self.errors;
        self.check_wave_errors(c);
        if let Some(r_min) = e.learned_r_min {
            let key = "errors.learned_r_min";
            c.require(
                e.csv.is_some(),
                key,
                "given without a list",
                "beside errors.csv",
                "this is the speed at which the list that errors.csv names was learned",
            );
            c.between(
                key,
                r_min,
                1e-3,
                1e6,
                "give the mean speed of that recording",
            );
        }
        let whole = if e.csv.is_some() {
            "errors.csv"
        } else {
            "errors.list_rad"
        };
        if e.csv.is_none() && e.list_rad.is_empty() {
            return;
        }
        let parts = Errors {
            list_rad: Vec::new(),
            csv: None,
            wave_standard_errors_rad: Vec::new(),
            learned_r_min: None,
            ..e.clone()
        };
        c.require(
            parts == Errors::default() && (e.csv.is_none() || e.list_rad.is_empty()),
            whole,
            "given together with other errors",
            "a list alone, or the parts alone",
            "a list is the whole of e: take out the other keys of [errors]",
        );
        if e.csv.is_none() {
            let edges = self.encoder.grid_edges() as usize;
            c.require(
                e.list_rad.len() == edges,
                whole,
                format_args!("{} numbers", e.list_rad.len()),
                &format!("{edges} numbers, one for each edge of a turn"),
                "give every edge its error",
            );
            for (k, value) in e.list_rad.iter().enumerate() {
                c.between(
                    &format!("errors.list_rad[{k}]"),
                    *value,
                    -PI,
                    PI,
                    ANGLE_ADVICE,
                );
            }
        }
    }
}
