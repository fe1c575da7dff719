mod capture;
mod delay;
mod disc;
mod drives;
mod elastic;
mod extended;
mod finer;
mod latency;
mod load;
mod motion;
mod shift;
mod slip;

use std::f64::consts::TAU;

use quadcal::edge::{Levels, Sample};

use super::*;
use crate::twin::{self, Drive, Encoder, Harmonic, Per, Position, Ripple, Step};

const RAD_S: f64 = TAU / 60.0;

/// The paper's rig without ripple and errors, at a speed.
fn plain(r_min: f64, turns: f64) -> Twin {
    Twin {
        ripple: Vec::new(),
        errors: twin::Errors::default(),
        drive: Drive::Constant { r_min },
        duration: Duration::Turns(turns),
        ..Twin::paper()
    }
}

fn speed_loop(r_min: f64, bandwidth_hz: f64) -> Drive {
    Drive::SpeedLoop {
        r_min,
        f_hz: 10_000.0,
        bandwidth_hz: Some(bandwidth_hz),
        kp_n_m_s: None,
        ki_n_m: None,
        timeout_s: None,
        limit_n_m: None,
    }
}

fn wander(rms_fraction: f64) -> Option<twin::Noise> {
    Some(twin::Noise::SpeedWander {
        rms_fraction,
        correlation_rad: Some(0.5),
        hold_s: None,
    })
}
