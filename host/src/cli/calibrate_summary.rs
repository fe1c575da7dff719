//! What `quadcal calibrate` writes as JSON.

mod recording;

use serde::Serialize;

use crate::calibrate::LinesFrom;
use crate::reports::calibrate::Calibrated;
use crate::reports::expected::LeftOut;
use crate::reports::words;
use recording::{Recording, Turns};

/// The result, as in the JSON.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    recordings: Vec<Recording>,
    sensor: &'static str,
    counted: &'static str,
    lines: u32,
    /// How the first recording's number of lines was found: `declared`, `index`, `header` or `pattern`, which is a guess.
    lines_from: &'static str,
    edges_per_turn: u32,
    origin: &'static str,
    clock_hz: u64,
    turns: Turns,
    faults: Faults,
    parameters: Vec<Value>,
    eps_rms_rad: f64,
    expected_error_before_rad: f64,
    /// Without the orders left alone.
    expected_error_after_rad: f64,
    /// Whether no order was left alone.
    expected_error_complete: bool,
    /// What the orders left alone as torque or the disc may make them add at most, RMS.
    left_alone_up_to_rad: f64,
    /// Of one edge's line position error.
    line_standard_error_rad: f64,
    /// What was to be expected after each turn.
    progress: Vec<AfterTurn>,
    /// Why learning ended, where a goal was given: `goal_met`, `no_further_gain`, or `go_on` at the end of the recordings.
    goal: Option<&'static str>,
    /// Whether the speeds differ enough to tell torque from geometry.
    two_speeds: bool,
    torque_ripple: Vec<Torque>,
    delays: Vec<Delay>,
    orders_left_alone: Vec<Order>,
    /// A speed loop may hide orders 1 up to this.
    orders_hidden_up_to: u16,
    /// Orders 1 up to this are left alone for it.
    orders_left_alone_for_loop_up_to: u16,
    /// Orders that look as if a speed loop had run; null where none do.
    speed_loop_suspected: Option<Suspected>,
    /// The part of the line's standard error that undoing a speed loop made.
    loop_standard_error_rad: f64,
}

/// What the core let expect after a turn.
#[derive(Debug, Serialize)]
struct AfterTurn {
    /// Turns taken so far, of all recordings.
    turns: u32,
    expected_error_rad: f64,
    /// After as many turns again.
    expected_after_twice_rad: f64,
}

#[derive(Debug, Serialize)]
struct Faults {
    lost: u32,
    extra: u32,
    illegal: u32,
    glitch: u32,
}

#[derive(Debug, Serialize)]
struct Value {
    name: &'static str,
    rad: f64,
    standard_error_rad: f64,
}

/// Peak sizes; the angle and the speed swing in the slowest turn.
#[derive(Debug, Serialize)]
struct Torque {
    order: u16,
    angle_rad: f64,
    angle_standard_error_rad: f64,
    speed_share: f64,
    acceleration_rad_s2: f64,
    acceleration_standard_error_rad_s2: f64,
    torque_n_m: Option<f64>,
    torque_standard_error_n_m: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Delay {
    name: &'static str,
    seconds: f64,
    standard_error_s: f64,
}

/// Orders that stand out broadly.
#[derive(Debug, Serialize)]
struct Suspected {
    first_order: usize,
    last_order: usize,
    /// Over the orders above.
    times: f64,
}

#[derive(Debug, Serialize)]
struct Order {
    order: u16,
    amplitude_rad: f64,
}

impl Summary {
    pub fn new(calibrated: &Calibrated<'_>) -> Self {
        let Calibrated {
            names,
            calibration,
            findings,
            shown,
            inertia_kg_m2,
        } = *calibrated;
        let left_out = LeftOut::of(calibration, findings);
        let (plan, faults) = (calibration.plan, &calibration.faults);
        let recordings = names.iter().zip(&calibration.recordings).zip(shown);
        Self {
            recordings: recordings
                .map(|((name, used), shown)| Recording::of(name, used, shown))
                .collect(),
            sensor: words::sensor(plan.kind),
            counted: plan.kind.line_name(),
            lines: plan.lines,
            lines_from: calibration
                .recordings
                .first()
                .map_or(LinesFrom::Declared, |used| used.lines_from)
                .id(),
            edges_per_turn: calibration.solution.shape().edges(),
            origin: words::origin(plan),
            clock_hz: calibration.clock_hz,
            turns: Turns::of(&calibration.totals, calibration.clock_hz),
            faults: Faults {
                lost: faults.lost,
                extra: faults.extra,
                illegal: faults.illegal,
                glitch: faults.glitch,
            },
            parameters: findings
                .parameters
                .iter()
                .map(|parameter| Value {
                    name: parameter.id,
                    rad: parameter.rad,
                    standard_error_rad: parameter.standard_error_rad,
                })
                .collect(),
            eps_rms_rad: findings.eps_rms_rad(),
            expected_error_before_rad: findings.before_rad,
            expected_error_after_rad: findings.after_rad,
            expected_error_complete: left_out.is_nothing(),
            left_alone_up_to_rad: left_out.up_to_rad,
            line_standard_error_rad: findings.after_rad,
            progress: calibration
                .progress
                .turns()
                .iter()
                .map(|after| AfterTurn {
                    turns: after.turns,
                    expected_error_rad: after.error_rad(),
                    expected_after_twice_rad: after.after_twice_rad(),
                })
                .collect(),
            goal: words::goal_id(calibration, findings.after_rad),
            two_speeds: calibration.two_speeds(),
            torque_ripple: findings
                .torques
                .iter()
                .map(|torque| {
                    let size = inertia_kg_m2.map(|inertia| torque.torque_n_m(inertia));
                    Torque {
                        order: torque.order,
                        angle_rad: torque.angle_rad,
                        angle_standard_error_rad: torque.angle_standard_error_rad,
                        speed_share: torque.speed_share(),
                        acceleration_rad_s2: torque.acceleration_rad_s2,
                        acceleration_standard_error_rad_s2: torque
                            .acceleration_standard_error_rad_s2,
                        torque_n_m: size.map(|[size, _]| size),
                        torque_standard_error_n_m: size.map(|[_, error]| error),
                    }
                })
                .collect(),
            delays: findings
                .delays
                .found()
                .iter()
                .map(|delay| Delay {
                    name: delay.id,
                    seconds: delay.seconds,
                    standard_error_s: delay.standard_error_s,
                })
                .collect(),
            orders_left_alone: findings
                .left_alone
                .iter()
                .map(|left| Order {
                    order: left.order,
                    amplitude_rad: left.amplitude_rad,
                })
                .collect(),
            orders_hidden_up_to: calibration.drive.hidden_up_to,
            orders_left_alone_for_loop_up_to: calibration.left_alone_for_loop(),
            speed_loop_suspected: findings.loop_suspicion.map(|hump| Suspected {
                first_order: hump.first,
                last_order: hump.last,
                times: hump.times,
            }),
            loop_standard_error_rad: calibration.loop_error_rad,
        }
    }
}
