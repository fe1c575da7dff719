//! The built-in twin.

use std::path::PathBuf;

use super::{Drive, Duration, Encoder, Errors, Faults, Per, Position, Ripple, Shaft, Timer, Twin};

impl Twin {
    /// The rig of the paper's simulation (section 4.1): 2500 lines, 15 r/min, 5 pole pairs with three harmonics.
    ///
    /// The paper gives no ripple amplitudes, no inertia and no clock. Chosen here: speed swings of 1 %, 0.5 % and 0.25 % at orders
    /// 5, 10 and 15, a small servo motor's inertia and friction, the 84 MHz timer of an STM32F405, 12 turns.
    #[must_use]
    pub fn paper() -> Self {
        let ripple = |order, phase_rad, speed_fraction| Ripple {
            order,
            phase_rad,
            torque_n_m: None,
            speed_fraction: Some(speed_fraction),
        };
        Self {
            seed: 1,
            duration: Duration::Turns(12.0),
            encoder: Encoder::Quadrature {
                lines: 2500,
                index: true,
            },
            errors: Errors {
                position: Some(Position::Uniform {
                    amplitude_rad: 6.2832e-5,
                    per: Per::Edge,
                }),
                width_a_rad: 1.2566e-4,
                width_b_rad: 1.1310e-4,
                quadrature_rad: 1.2566e-4,
                ..Errors::default()
            },
            shaft: Shaft {
                inertia_kg_m2: 1e-4,
                viscous_n_m_s: 1e-4,
                ..Shaft::default()
            },
            drive: Drive::Constant { r_min: 15.0 },
            free_phases: false,
            ripple: vec![
                ripple(5.0, 0.3, 0.01),
                ripple(10.0, 1.1, 0.005),
                ripple(15.0, 2.0, 0.0025),
            ],
            local_defect: Vec::new(),
            gear_mesh: Vec::new(),
            bearing: Vec::new(),
            torque_tone: Vec::new(),
            load_step: Vec::new(),
            index_slip: Vec::new(),
            noise: None,
            speed_drift: None,
            stick_slip: None,
            torsional_resonance: None,
            edge_delay: None,
            channel_skew: None,
            threshold_ripple: Vec::new(),
            threshold_drift: Vec::new(),
            hysteresis: None,
            backlash: None,
            capture_latency: None,
            effect: Vec::new(),
            timer: Timer {
                clock_hz: 84_000_000,
                bits: 64,
                jitter_s: 0.0,
                raw_captures: false,
            },
            faults: Faults::default(),
            name: "paper".to_owned(),
            folder: PathBuf::new(),
        }
    }
}
