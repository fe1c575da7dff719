//! The twin without randomness, run along a recording.

use std::f64::consts::TAU;

use quadcal::edge::Levels;

use super::track::{Mark, Track};
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::sim::{Class, Simulation};
use crate::twin::{Drive, Duration, Encoder, Errors, Faults, Noise, Twin, TwinError};

/// How far before the angle that its twin starts at a shaft may be found to have started, rad: it wandered on the way to the index. The
/// same for a twin and for the mended one, so that neither counts turns otherwise.
const START_RAD: f64 = 0.1;

/// The twin's shaft as nothing disturbs it.
#[derive(Clone, Debug)]
pub struct Still {
    /// Edges of a perfect disc on it, those before its index too.
    pub pace: Vec<Mark>,
    /// Of which this many make a step of the grid.
    pub finer: i64,
    /// Errors of the twin's disc, rad.
    pub errors: Vec<f64>,
    /// What a place lacks to be an edge of the disc, turns counted from the twin's start.
    pub origin: i64,
    /// By how much a place is ahead of the twin's number of its edge.
    pub shift: i64,
    /// Angle that the twin starts at, rad.
    pub start_rad: f64,
}

impl Still {
    /// Runs a twin along a recording.
    ///
    /// # Errors
    /// [`TwinError`] where it can't be run.
    pub fn of(track: &Track, plan: SensorPlan, twin: &Twin) -> Result<Self, TwinError> {
        let (still, turns) = started(track, without_randomness(track, twin))?;
        let mut errors = Simulation::new(&still)?.true_errors();
        // Of a pulse a tooth only the rise is seen.
        if errors.len() as i64 == 2 * track.edges {
            errors = errors.into_iter().step_by(2).collect();
        }
        // Where a loop is, the recording itself says where it sent the shaft.
        let (finer, pace) = match twin.speed_loop() {
            Some(_) => (1, Vec::new()),
            None => paced(track, plan, perfect(&still))?,
        };
        Ok(Self {
            pace,
            finer,
            errors,
            origin: track.origin + turns * track.edges,
            shift: i64::from(track.classes == 6),
            start_rad: still.shaft.initial_angle_rad,
        })
    }
}

/// The simulator's index is high where A alone is, whatever the recording's is.
#[must_use]
pub fn simulators(plan: SensorPlan) -> SensorPlan {
    let kind = match plan.kind {
        SensorKind::Quadrature {
            index_state: Some(_),
        } => SensorKind::Quadrature {
            index_state: Some(Levels(Levels::A)),
        },
        kind => kind,
    };
    SensorPlan { kind, ..plan }
}

/// A twin's edges.
fn simulated(plan: SensorPlan, twin: &Twin) -> Result<Vec<Mark>, TwinError> {
    if let SensorKind::Wheel {
        both_edges: true, ..
    } = plan.kind
        && twin.drive.reverses()
    {
        return to_and_fro(twin);
    }
    let rows = Simulation::new(twin)?.map(|event| Ok::<_, PlanError>(event.row));
    let track = Track::of(simulators(plan), twin.timer.clock_hz, rows);
    // The plan has decoded the recording, so it decodes this.
    let mut marks = Vec::new();
    if let Ok(track) = track {
        let counted = track
            .stretches
            .into_iter()
            .flat_map(|stretch| stretch.marks);
        marks.extend(track.early.into_iter().chain(counted));
    }
    Ok(marks)
}

/// Edges of a twin with one channel, which does not show which way it goes: the simulator knows. Counted from the first rise on.
fn to_and_fro(twin: &Twin) -> Result<Vec<Mark>, TwinError> {
    let edges = f64::from(twin.encoder.grid_edges());
    let events = Simulation::new(twin)?.filter(|event| event.truth.edge.is_some());
    let mut marks: Vec<Mark> = events
        .skip_while(|event| event.truth.class != Class::ARise)
        .map(|event| Mark {
            time_s: event.truth.time_s,
            place: (event.truth.angle_rad / TAU * edges).round() as i64,
        })
        .collect();
    let first = marks.first().map_or(0, |mark| mark.place);
    marks.iter_mut().for_each(|mark| mark.place -= first);
    Ok(marks)
}

/// Without randomness, with time stamps as good as exact, at the recording's mean speed where it is to hold one.
fn without_randomness(track: &Track, twin: &Twin) -> Twin {
    let mut still = twin.clone();
    // A wander also says how strongly the drive holds the speed, which stays.
    still.noise = still.noise.and_then(|noise| match noise {
        Noise::SpeedWander {
            correlation_rad,
            hold_s,
            ..
        } => Some(Noise::SpeedWander {
            rms_fraction: 1e-30,
            correlation_rad,
            hold_s,
        }),
        _ => None,
    });
    still.faults = Faults::default();
    still.capture_latency = None;
    if let Some(resonance) = &mut still.torsional_resonance {
        resonance.load_psd_n2_m2_s = None;
        resonance.load_hold_s = None;
    }
    still.timer.jitter_s = 0.0;
    still.timer.clock_hz = fine_hz(track);
    still.timer.bits = 64;
    still.timer.raw_captures = false;
    if let Some(longest) = track.longest()
        && still.speed_drift.is_none()
    {
        match &mut still.drive {
            Drive::Constant { r_min } => {
                *r_min = mean_r_min(track, &longest.marks).unwrap_or(*r_min)
            }
            Drive::RunDown { r_min, off_s } => {
                // A load takes the shaft from the speed that it is driven at.
                let loads = still.load_step.iter().map(|load| load.from_s);
                let until_s = loads.fold(*off_s, f64::min);
                let driven = longest.marks.partition_point(|mark| mark.time_s < until_s);
                *r_min = mean_r_min(track, &longest.marks[..driven]).unwrap_or(*r_min);
            }
            _ => {}
        }
    }
    // As long as the recording: a twin that is declared to run for days runs no longer.
    if let Some(end_s) = track.end_s() {
        still.duration = Duration::Seconds(1.05 * end_s);
    }
    still
}

/// A perfect twin's edges, and how many of them make a step of the grid. Where the shaft turns round, friction does so at once, half-way
/// between two edges that are long apart: a disc with some times the lines shows its way.
fn paced(track: &Track, plan: SensorPlan, twin: Twin) -> Result<(i64, Vec<Mark>), TwinError> {
    const FINER: u32 = 16;
    /// Lines that a decoder counts.
    const LINES_MOST: u32 = 16_000;
    /// Edges that take no time worth speaking of.
    const EDGES: usize = 400_000;
    let edges: usize = track.stretches.iter().map(|one| one.marks.len()).sum();
    let times = u32::try_from(EDGES / edges.max(1)).map_or(FINER, |times| times.min(FINER));
    if let Encoder::Quadrature { lines, index } = twin.encoder
        && let times = times.min(LINES_MOST / lines)
        && times > 1
        && (track.reverses() || twin.drive.reverses())
    {
        let plan = SensorPlan {
            lines: times * lines,
            ..plan
        };
        let encoder = Encoder::Quadrature {
            lines: plan.lines,
            index,
        };
        let fine = simulated(
            plan,
            &Twin {
                encoder,
                ..twin.clone()
            },
        )?;
        if !fine.is_empty() {
            return Ok((i64::from(times), fine));
        }
    }
    Ok((1, simulated(plan, &twin)?))
}

/// Ticks a second that leave no interval of a recording as long as a decoder that tells a wheel's gap by it can count.
fn fine_hz(track: &Track) -> u64 {
    const FINE_HZ: u64 = 1_000_000_000_000;
    const TICKS: f64 = 0.5 * u32::MAX as f64;
    let marks = || track.stretches.iter().flat_map(|s| &s.marks);
    let pairs = marks().zip(marks().skip(1));
    let longest_s = pairs.map(|(mark, next)| next.time_s - mark.time_s);
    let longest_s = longest_s.fold(0.0, f64::max);
    FINE_HZ.min((TICKS / longest_s) as u64)
}

/// The same, started so that it passes the recording's first place when the recording does; and the turns by which the shaft's angle
/// is then ahead of the recording's count.
fn started(track: &Track, mut still: Twin) -> Result<(Twin, i64), TwinError> {
    let Some(first) = track.stretches.first().and_then(|s| s.marks.first()) else {
        return Ok((still, 0));
    };
    if !track.anchored || first.time_s <= 0.0 {
        return Ok((still, 0));
    }
    let short = Twin {
        duration: Duration::Seconds(first.time_s),
        ..perfect(&still)
    };
    // What the shaft does until then; its last edge is near enough.
    let last = Simulation::new(&short)?.last();
    let Some(last) = last else {
        return Ok((still, 0));
    };
    let travelled = last.truth.angle_rad - still.shaft.initial_angle_rad;
    let place = first.place as f64 * TAU / track.edges as f64;
    let start = place - travelled;
    // Torques of no whole order tell turns apart: it starts in the turn that begins where the twin does.
    let ahead = start - still.shaft.initial_angle_rad + START_RAD;
    let turns = -ahead.div_euclid(TAU);
    still.shaft.initial_angle_rad = start + turns * TAU;
    Ok((still, turns as i64))
}

/// The same shaft with a disc and a capture that do nothing, and none of the torques that keep step with turn or time: a shaft that
/// lags lags in their rhythm too, so how far edges are apart is measured by the speed without it.
fn perfect(still: &Twin) -> Twin {
    Twin {
        errors: Errors::default(),
        local_defect: Vec::new(),
        edge_delay: None,
        channel_skew: None,
        threshold_ripple: Vec::new(),
        threshold_drift: Vec::new(),
        hysteresis: None,
        backlash: None,
        index_slip: Vec::new(),
        capture_latency: None,
        ripple: Vec::new(),
        gear_mesh: Vec::new(),
        bearing: Vec::new(),
        torque_tone: Vec::new(),
        ..still.clone()
    }
}

/// Mean speed over half a turn or more.
fn mean_r_min(track: &Track, marks: &[Mark]) -> Option<f64> {
    let (first, last) = (marks.first()?, marks.last()?);
    // Over whole turns the errors of the disc cancel, where there are any.
    let way = last.place - first.place;
    let whole = way / track.edges * track.edges;
    let way = if whole == 0 { way } else { whole };
    if 2 * way.abs() < track.edges {
        return None;
    }
    let there = marks.partition_point(|mark| (mark.place - first.place).abs() < way.abs());
    let end = marks.get(there).unwrap_or(last);
    let turns = (end.place - first.place) as f64 / track.edges as f64;
    Some(60.0 * turns / (end.time_s - first.time_s))
}
