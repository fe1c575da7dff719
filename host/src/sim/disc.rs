//! The disc: at which true shaft angle each channel changes.

use std::f64::consts::TAU;

use quadcal::edge::{Direction, Levels};

use super::Class;
use super::random::{Purpose, Stream};
use super::shift::change_of;
use super::{defect, effects, error_list};
use crate::effect::Site;
use crate::twin::{Bearing, Encoder, Errors, Per, Position, Twin, TwinError};

/// One change of level on the disc.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    /// True shaft angle, 0 to 2 pi.
    angle_rad: f64,
    /// Its place on the grid, rad.
    grid_rad: f64,
    /// Number of the edge; none for the index.
    pub(super) edge: Option<u32>,
    /// What changes, seen forward.
    pub(super) class: Class,
    /// Levels just after the mark, seen forward.
    levels: u8,
}

/// All changes of one turn, by angle. A place counts marks from angle 0 on, through all turns.
#[derive(Clone, Debug)]
pub(super) struct Disc {
    marks: Vec<Mark>,
    errors: Vec<f64>,
    /// Errors that do not repeat each turn.
    runouts: Vec<Runout>,
    encoder: Encoder,
}

/// Newton's steps to where a mark is passed under run-out, at the most.
const RUNOUT_STEPS: usize = 8;
/// Last step of them, rad.
const RUNOUT_NEAR: f64 = 1e-13;

/// An error amplitude sin(order theta + phase) through all turns, theta being the shaft's angle.
#[derive(Clone, Copy, Debug)]
struct Runout {
    order: f64,
    phase_rad: f64,
    amplitude_rad: f64,
}

impl Disc {
    pub(super) fn new(twin: &Twin) -> Result<Self, TwinError> {
        let encoder = twin.encoder.clone();
        let errors = errors_of(twin)?;
        let step = TAU / f64::from(encoder.grid_edges());
        let angle = |k: u32| f64::from(k) * step - errors[k as usize];
        let real: Vec<u32> = (0..encoder.grid_edges())
            .filter(|k| encoder.is_real(*k))
            .collect();
        let next = real.iter().cycle().skip(1);
        for (&first, &second) in real.iter().zip(next) {
            let turn = if second <= first { TAU } else { 0.0 };
            let by_rad = angle(first) - angle(second) - turn;
            if by_rad >= 0.0 {
                return Err(TwinError::EdgesCross {
                    name: twin.name.clone(),
                    first,
                    second,
                    by_rad,
                    step_rad: step,
                });
            }
        }
        let mark = |angle_rad: f64, grid: f64, edge, class| Mark {
            angle_rad: angle_rad.rem_euclid(TAU),
            grid_rad: grid * step,
            edge,
            class,
            levels: 0,
        };
        let mut marks: Vec<Mark> = real
            .into_iter()
            .map(|k| mark(angle(k), f64::from(k), Some(k), class_of(&encoder, k)))
            .collect();
        if encoder.has_index() {
            let (before, after) = (angle(0) - 0.5 * step, angle(0) + 0.5 * step);
            marks.push(mark(before, -0.5, None, Class::IndexRise));
            marks.push(mark(after, 0.5, None, Class::IndexFall));
        }
        marks.sort_by(|a, b| a.angle_rad.total_cmp(&b.angle_rad));
        // Every channel changes at least once a turn, so the second time round the levels are right.
        let mut levels = 0;
        for _ in 0..2 {
            for mark in &mut marks {
                let (bit, rises) = mark.class.bit_and_rise();
                levels = if rises { levels | bit } else { levels & !bit };
                mark.levels = levels;
            }
        }
        Ok(Self {
            marks,
            errors,
            runouts: runouts_of(twin),
            encoder,
        })
    }

    /// e(k) for every edge of the grid, rad; 0 where a tooth is missing.
    pub(super) fn errors(&self) -> &[f64] {
        &self.errors
    }

    fn split(&self, place: i64) -> (f64, usize) {
        let marks = self.marks.len() as i64;
        let turn = place.div_euclid(marks);
        (turn as f64, (place - turn * marks) as usize)
    }

    /// The mark at a place.
    pub(super) fn mark(&self, place: i64) -> &Mark {
        &self.marks[self.split(place).1]
    }

    /// True shaft angle of a place, rad, through all turns.
    pub(super) fn angle_rad(&self, place: i64) -> f64 {
        let (turn, index) = self.split(place);
        turn * TAU + self.marks[index].angle_rad
    }

    /// The marks of one turn, by angle.
    pub(super) fn marks(&self) -> &[Mark] {
        &self.marks
    }

    /// True shaft angle of a mark in a turn, rad, run-out included: that goes by the angle at which the shaft is when the mark is
    /// passed, so it is found by Newton's steps.
    pub(super) fn mark_angle_rad(&self, turn: f64, mark: &Mark) -> f64 {
        let still = turn * TAU + mark.angle_rad;
        let mut angle = still;
        if self.runouts.is_empty() {
            return angle;
        }
        for _ in 0..RUNOUT_STEPS {
            let (mut off, mut slope) = (angle - still, 1.0);
            for runout in &self.runouts {
                let (sin, cos) = libm::sincos(runout.order * angle + runout.phase_rad);
                off += runout.amplitude_rad * sin;
                slope += runout.amplitude_rad * runout.order * cos;
            }
            let step = off / slope;
            angle -= step;
            if step.abs() < RUNOUT_NEAR {
                break;
            }
        }
        angle
    }

    /// A mark's place on the grid in a turn, rad, through all turns.
    pub(super) fn grid_rad(turn: f64, mark: &Mark) -> f64 {
        let round = ((mark.angle_rad - mark.grid_rad) / TAU).round();
        (turn + round) * TAU + mark.grid_rad
    }

    /// Levels between the mark before a place and the one at it.
    pub(super) fn levels_before(&self, place: i64) -> Levels {
        Levels(self.mark(place - 1).levels)
    }

    /// The first place whose angle lies above `angle_rad`.
    pub(super) fn place_above(&self, angle_rad: f64) -> i64 {
        let turn = (angle_rad / TAU).floor();
        let within = angle_rad - turn * TAU;
        let index = self.marks.partition_point(|mark| mark.angle_rad <= within);
        turn as i64 * self.marks.len() as i64 + index as i64
    }

    /// Grid steps from the edge before `edge` in this direction: 1, or more across a gap.
    pub(super) fn steps_into(&self, edge: u32, direction: Direction) -> u32 {
        let grid = self.encoder.grid_edges();
        let (before, back) = match direction {
            Direction::Forward => ((edge + grid - 1) % grid, Direction::Reverse),
            Direction::Reverse => ((edge + 1) % grid, Direction::Forward),
        };
        1 + self.encoder.edges_to_real(before, back)
    }
}

pub(super) fn class_of(encoder: &Encoder, k: u32) -> Class {
    use Class::{AFall, ARise, BFall, BRise, CFall, CRise};
    let (classes, group): (&[Class], u32) = match encoder {
        Encoder::Quadrature { .. } => (&[ARise, BRise, AFall, BFall], 4),
        Encoder::Hall { .. } => (&[BRise, CFall, ARise, BFall, CRise, AFall], 6),
        Encoder::Wheel { .. } => (&[ARise, AFall], 2),
    };
    classes[(k % group) as usize]
}

fn errors_of(twin: &Twin) -> Result<Vec<f64>, TwinError> {
    let edges = twin.encoder.grid_edges();
    let mut errors = if let Some(path) = twin.error_list_path() {
        error_list::read(&path, &twin.encoder)?
    } else if twin.errors.list_rad.is_empty() {
        drawn_errors(twin)
    } else {
        twin.errors.list_rad.clone()
    };
    if !twin.local_defect.is_empty() {
        for (k, error) in (0..edges).zip(&mut errors) {
            let grid = f64::from(k) * (TAU / f64::from(edges));
            *error += defect::error_rad(twin, class_of(&twin.encoder, k), grid);
        }
    }
    let mut of_disc = effects::at(twin, |site| matches!(site, Site::Disc(_)));
    of_disc.retain(|(effect, _)| effect.is_of_disc());
    if !of_disc.is_empty() {
        for (k, error) in (0..edges).zip(&mut errors) {
            let grid = f64::from(k) * (TAU / f64::from(edges));
            if let Some(change) = change_of(class_of(&twin.encoder, k)) {
                *error += effects::on_disc(&of_disc, change, grid);
            }
        }
    }
    for (k, error) in (0..edges).zip(&mut errors) {
        if !twin.encoder.is_real(k) {
            *error = 0.0;
        }
    }
    Ok(errors)
}

/// Errors of the parts that a twin declares.
fn drawn_errors(twin: &Twin) -> Vec<f64> {
    let edges = twin.encoder.grid_edges();
    let seed = twin.errors.seed.unwrap_or(twin.seed);
    let mut random = Stream::new(seed, Purpose::LinePosition);
    let mut position = 0.0;
    let errors = (0..edges).map(|k| {
        position = line_position(twin, k, position, &mut random);
        let class = class_of(&twin.encoder, k);
        let grid = f64::from(k) * (TAU / f64::from(edges));
        position + fixed_part(&twin.errors, class, grid)
    });
    errors.collect()
}

fn runouts_of(twin: &Twin) -> Vec<Runout> {
    let runout = |bearing: &Bearing| {
        Some(Runout {
            order: bearing.order,
            phase_rad: bearing.phase_rad,
            amplitude_rad: bearing.runout_rad?,
        })
    };
    twin.bearing.iter().filter_map(runout).collect()
}

fn line_position(twin: &Twin, k: u32, last: f64, random: &mut Stream) -> f64 {
    let own = |per: Per| per == Per::Edge || k.is_multiple_of(twin.encoder.edges_per_line());
    match twin.errors.position {
        Some(Position::Uniform { amplitude_rad, per }) if own(per) => {
            amplitude_rad * (2.0 * random.unit() - 1.0)
        }
        Some(Position::Normal { rms_rad, per }) if own(per) => rms_rad * random.normal(),
        _ => last,
    }
}

fn fixed_part(errors: &Errors, class: Class, grid_rad: f64) -> f64 {
    let of_class = match class {
        Class::AFall => errors.width_a_rad,
        Class::BRise => errors.quadrature_rad + errors.shift_b_rad,
        Class::BFall => errors.width_b_rad + errors.quadrature_rad + errors.shift_b_rad,
        Class::CRise => errors.shift_c_rad,
        Class::CFall => errors.width_c_rad + errors.shift_c_rad,
        Class::ARise | Class::IndexRise | Class::IndexFall | Class::Glitch => 0.0,
    };
    let harmonics = [(1.0, errors.eccentricity), (2.0, errors.tilt)];
    harmonics.iter().fold(of_class, |sum, (order, harmonic)| {
        sum + harmonic.map_or(0.0, |h| {
            h.amplitude_rad * libm::sin(order * grid_rad - h.phase_rad)
        })
    })
}
