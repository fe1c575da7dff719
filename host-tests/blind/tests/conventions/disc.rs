//! Errors of the disc, levels, plays, the index.

use quadcal_blind::effect::Effect;
use quadcal_host::twin::{
    Backlash, Channel, Flank, Harmonic, Hysteresis, IndexSlip, LocalDefect, ThresholdDrift,
    ThresholdRipple,
};

use crate::{agree, back_and_forth, steady};

#[test]
fn errors_of_the_disc() {
    let (amplitude_rad, phase_rad) = (1e-3, 0.7);
    let harmonic = Some(Harmonic {
        amplitude_rad,
        phase_rad,
    });
    let eccentricity = Effect::Eccentricity {
        amplitude_rad,
        phase_rad,
    };
    agree(&steady(), &[eccentricity], |twin| {
        twin.errors.eccentricity = harmonic;
    });
    let tilt = Effect::DiscTilt {
        amplitude_rad,
        phase_rad,
    };
    agree(&steady(), &[tilt], |twin| twin.errors.tilt = harmonic);
    let rad = [1e-3, -5e-4, 0.0];
    agree(&steady(), &[Effect::WidthError { rad }], |twin| {
        (twin.errors.width_a_rad, twin.errors.width_b_rad) = (rad[0], rad[1]);
    });
    let quadrature = Effect::QuadratureError { rad: 8e-4 };
    agree(&steady(), &[quadrature], |twin| {
        twin.errors.quadrature_rad = 8e-4;
    });
    let defect = Effect::LocalDefect {
        angle_rad: 1.2,
        width_rad: 0.05,
        error_rad: -1e-3,
        channel: Some(1),
        rises: Some(false),
    };
    agree(&steady(), &[defect], |twin| {
        twin.local_defect = vec![LocalDefect {
            angle_rad: 1.2,
            width_rad: 0.05,
            error_rad: -1e-3,
            channel: Some(Channel::B),
            edge: Some(Flank::Fall),
        }];
    });
}

#[test]
fn levels_move_the_same_way() {
    let ripple = Effect::ThresholdRipple {
        f_hz: 50.0,
        phase_rad: 0.4,
        angle_rad: 5e-4,
        channel: Some(0),
    };
    agree(&steady(), &[ripple], |twin| {
        twin.threshold_ripple = vec![ThresholdRipple {
            f_hz: 50.0,
            phase_rad: 0.4,
            angle_rad: 5e-4,
            channel: Some(Channel::A),
        }];
    });
    let drift = Effect::ThresholdDrift {
        angle_rad: -5e-4,
        tau_s: 0.2,
        from_s: 0.3,
    };
    agree(&steady(), &[drift], |twin| {
        twin.threshold_drift = vec![ThresholdDrift {
            angle_rad: -5e-4,
            tau_s: 0.2,
            from_s: 0.3,
            channel: None,
        }];
    });
}

#[test]
fn plays_of_the_same_angle_after_a_reversal() {
    let rig = back_and_forth();
    agree(&rig, &[Effect::Hysteresis { angle_rad: 2e-3 }], |twin| {
        twin.hysteresis = Some(Hysteresis {
            angle_rad: 2e-3,
            channel: None,
        });
    });
    agree(&rig, &[Effect::Backlash { gap_rad: 2e-3 }], |twin| {
        twin.backlash = Some(Backlash { gap_rad: 2e-3 });
    });
}

#[test]
fn an_index_slips_to_the_same_side() {
    for edges in [2, -3] {
        let slip = Effect::IndexSlip { at_s: 0.4, edges };
        agree(&steady(), &[slip], |twin| {
            twin.index_slip = vec![IndexSlip { at_s: 0.4, edges }];
        });
    }
}
