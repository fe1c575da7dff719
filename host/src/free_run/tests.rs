//! The loop's doing worked out from edges, against the simulator's shaft.

use quadcal::estimate::DriveKnowledge;

use super::trend::TrendFit;
use super::*;
use crate::calibrate::{self, CalibrateOptions};
use crate::findings::{self, Findings};
use crate::recording::{ReadError, Row};
use crate::sensor::SensorPlan;
use crate::sim::{Event, Simulation};
use crate::survey::Survey;
use crate::twin::{Drive, Duration, Encoder, Harmonic, Noise, Twin};

/// A motor of seven pole pairs, so that order 1 is known to be geometry at one speed.
const MOTOR_ONLY: DriveKnowledge = DriveKnowledge {
    torque_base: 7,
    hidden_up_to: 0,
};

const EXACT: Knowledge = Knowledge {
    gains_within: 0.0,
    phase: true,
};

/// A disc of 50 lines with coarse errors in a loop of 20 Hz, at 300 r/min.
fn twin(limit_n_m: Option<f64>) -> Twin {
    let mut twin = Twin::paper();
    twin.encoder = Encoder::Quadrature {
        lines: 50,
        index: true,
    };
    twin.duration = Duration::Turns(30.0);
    twin.errors.position = None;
    twin.errors.width_a_rad = 4e-3;
    twin.errors.quadrature_rad = 2e-3;
    twin.errors.eccentricity = Some(Harmonic {
        amplitude_rad: 5e-3,
        phase_rad: 0.7,
    });
    twin.ripple.clear();
    twin.drive = Drive::SpeedLoop {
        r_min: 300.0,
        f_hz: 1_000.0,
        bandwidth_hz: Some(20.0),
        kp_n_m_s: None,
        ki_n_m: None,
        timeout_s: None,
        limit_n_m,
    };
    twin
}

struct Recorded {
    events: Vec<Event>,
    survey: Survey,
    plan: SensorPlan,
    push: Push,
}

impl Recorded {
    fn of(twin: &Twin) -> Self {
        let simulation = Simulation::new(twin).unwrap();
        let header = simulation.header();
        let events: Vec<Event> = simulation.collect();
        let survey = Survey::of(header, events.iter().map(|event| Ok(event.row))).unwrap();
        Self {
            plan: calibrate::plan(&survey, &CalibrateOptions::default()).unwrap(),
            push: Push::Loop(LoopModel::of(twin).unwrap()),
            events,
            survey,
        }
    }

    fn rows(&self) -> impl Iterator<Item = Result<Row, ReadError>> {
        self.events.iter().map(|event| Ok(event.row))
    }

    fn free(&self, push: Push, knowledge: Knowledge) -> FreeRun {
        let open = || Ok::<_, FreeRunError>(self.rows());
        FreeRun::of(open, &self.survey.header, self.plan, push, knowledge).unwrap()
    }

    /// RMS, rad, of what a constant acceleration leaves of the true angles over the free run's times.
    fn unexplained(&self, run: &FreeRun) -> f64 {
        let clock = run.header(&self.survey.header).clock_hz as f64;
        let rows = run.rows(self.rows()).map(|row| row.unwrap());
        let points: Vec<(f64, f64)> = rows
            .zip(&self.events)
            .map(|(row, event)| (row.ticks as f64 / clock - 1.0, event))
            .map(|(time, event)| (time, event.truth.angle_rad - run.speed_rad_s() * time))
            .collect();
        let mut fit = TrendFit::new(0.0);
        for &(time, angle) in &points {
            fit.add(time, &[angle]);
        }
        let trend = fit.trend();
        let rest = |&(time, angle): &(f64, f64)| (angle - trend.at(time)[0]).powi(2);
        (points.iter().map(rest).sum::<f64>() / points.len() as f64).sqrt()
    }
}

#[test]
fn a_shaft_without_its_loop_runs_steadily() {
    let recorded = Recorded::of(&twin(None));
    let run = recorded.free(recorded.push.clone(), EXACT);
    // A tick is 3.7e-7 rad; the eccentricity that the loop hides is 5e-3.
    let left = recorded.unexplained(&run);
    assert!(left < 5e-6, "{left:e}");
}

#[test]
fn a_drive_at_its_limit_is_followed() {
    let recorded = Recorded::of(&twin(Some(0.02)));
    let Push::Loop(model) = &recorded.push else {
        panic!("the twin's drive is a loop");
    };
    let left = recorded.unexplained(&recorded.free(recorded.push.clone(), EXACT));
    assert!(left < 2e-5, "{left:e}");
    let unlimited = Push::Loop(LoopModel {
        limit: f64::INFINITY,
        ..*model
    });
    let left = recorded.unexplained(&recorded.free(unlimited, EXACT));
    assert!(left > 1e-4, "the limit was never reached: {left:e}");
}

#[test]
fn what_wrong_gains_leave_in_the_table_is_foretold() {
    let recorded = Recorded::of(&twin(None));
    let Push::Loop(model) = &recorded.push else {
        panic!("the twin's drive is a loop");
    };
    let learned = |gains| {
        let run = recorded.free(Push::Loop(LoopModel { gains, ..*model }), EXACT);
        let survey = run.survey(recorded.survey.clone());
        let rows = run.rows(recorded.rows());
        let options = CalibrateOptions {
            drive: MOTOR_ONLY,
            ..CalibrateOptions::default()
        };
        let learned = calibrate::learn(survey, recorded.plan, rows, &options).unwrap();
        (Findings::of(&learned).error_rad, run)
    };
    let Gains { kp, ki } = model.gains;
    let (right, run) = learned(model.gains);
    assert_eq!(run.repeating_error_rad(), 0.0);
    for (off_kp, off_ki) in [(0.01, 0.0), (0.0, 0.01), (0.01, 0.01)] {
        let off = Gains {
            kp: off_kp * kp,
            ki: off_ki * ki,
        };
        let (wrong, _) = learned(Gains {
            kp: kp + off.kp,
            ki: ki + off.ki,
        });
        let left = findings::distance(&wrong, &right);
        let foretold = run.repeated.rms(off, 1.0);
        assert!((left / foretold - 1.0).abs() < 0.1, "{left:e} {foretold:e}");
    }
}

#[test]
fn an_unknown_sample_time_is_found_and_an_implausible_fit_is_not_used() {
    let mut twin = twin(None);
    twin.noise = Some(Noise::White {
        psd_n2_m2_s: 1e-13,
        hold_s: None,
    });
    let mut recorded = Recorded::of(&twin);
    for event in &mut recorded.events {
        event.row.ticks += 12_345;
    }
    let Push::Loop(model) = &recorded.push else {
        panic!("the twin's drive is a loop");
    };
    let gains = Gains {
        kp: 1.1 * model.gains.kp,
        ki: 0.9 * model.gains.ki,
    };
    let wrong = Push::Loop(LoopModel { gains, ..*model });
    let run = recorded.free(
        wrong,
        Knowledge {
            gains_within: 0.1,
            phase: false,
        },
    );
    let Push::Loop(found) = run.push() else {
        panic!("a loop stays one");
    };
    // With an edge a sample, a hundred ticks of 84000 hold hardly one.
    let ticks = found.phase_s * 84e6;
    assert!((ticks - 12_345.0).abs() < 100.0, "{ticks}");
    // Edges and samples in step repeat every turn and tell nothing of the gains: the fit is of the noise, and not used.
    assert!(run.fit().is_none());
    assert_eq!(run.gains(), gains);
}

#[test]
fn a_recording_without_a_run_or_of_one_turn_is_refused() {
    let mut short = twin(None);
    short.duration = Duration::Turns(2.2);
    let simulation = Simulation::new(&short).unwrap();
    let header = simulation.header();
    let rows: Vec<Row> = simulation.map(|event| event.row).collect();
    let recorded = Recorded::of(&twin(None));
    let of = |rows: &[Row], gains_within| {
        let open = || Ok::<_, FreeRunError>(rows.iter().copied().map(Ok));
        let knowledge = Knowledge {
            gains_within,
            ..EXACT
        };
        FreeRun::of(
            open,
            &header,
            recorded.plan,
            recorded.push.clone(),
            knowledge,
        )
    };
    assert!(matches!(of(&rows, 0.1), Err(FreeRunError::TooShort)));
    assert!(of(&rows, 0.0).is_ok());
    assert!(matches!(of(&rows[..1], 0.0), Err(FreeRunError::NoRun)));
}
