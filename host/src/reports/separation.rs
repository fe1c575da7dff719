//! What turns of different speed tell apart, in words and tables: torque from geometry, delays from angles.

use quadcal::estimate::DriveKnowledge;

use crate::calibrate::Calibration;
use crate::findings::{DelayFindings, Findings, LeftAlone, LoopSuspicion, Torque};
use crate::report::{Body, Cell, si};

use super::words;

/// A torque's size: what it does to the slowest turn, and the torque itself, or the acceleration where no inertia is known.
#[must_use]
pub fn torque(torque: &Torque, inertia_kg_m2: Option<f64>, slowest_r_min: f64) -> String {
    let size = match inertia_kg_m2.map(|inertia| torque.torque_n_m(inertia)) {
        Some([size, error]) => format!("{} ± {}", si(size, "N m"), si(error, "N m")),
        None => format!(
            "{} ± {}",
            si(torque.acceleration_rad_s2, "rad/s²"),
            si(torque.acceleration_standard_error_rad_s2, "rad/s²")
        ),
    };
    format!(
        "{size}; at {} it swings the speed by {} and the angle by {} ± {}",
        words::speed_range([slowest_r_min; 2]),
        si(100.0 * torque.speed_share(), "%"),
        si(torque.angle_rad, "rad"),
        si(torque.angle_standard_error_rad, "rad")
    )
}

/// The torques worth a line each, and how many weaker ones there are: a hundredth of the strongest swing is the bound.
#[must_use]
pub fn strong(torques: &[Torque]) -> (&[Torque], usize) {
    let bound = torques.first().map_or(0.0, |first| first.angle_rad / 100.0);
    let strong = torques.partition_point(|torque| torque.angle_rad >= bound);
    let (strong, weak) = torques.split_at(strong);
    (strong, weak.len())
}

/// What is known of delays where none was found; nothing where some were, or a sensor has none.
#[must_use]
pub const fn delays_unknown(delays: &DelayFindings) -> Option<&'static str> {
    match delays {
        DelayFindings::SpeedsAlike => Some(
            "not told from xi and p, as all turns ran at one speed; a recording at a second speed would separate them",
        ),
        DelayFindings::None => Some("none that stands out"),
        DelayFindings::OneClass | DelayFindings::Found(_) => None,
    }
}

/// The size of an order left alone.
#[must_use]
pub fn left_alone(left: &LeftAlone) -> String {
    format!(
        "{} in angle every turn: torque ripple, or eccentricity or tilt of the disc",
        si(left.amplitude_rad, "rad")
    )
}

/// What decides the orders left alone at one speed; nothing where there are none.
#[must_use]
pub fn advice(findings: &Findings, drive: DriveKnowledge) -> Option<String> {
    let orders: Vec<String> = findings
        .left_alone
        .iter()
        .map(|left| left.order.to_string())
        .collect();
    let many = match orders.len() {
        0 => return None,
        1 => "order",
        _ => "orders",
    };
    let pole_pairs = if drive.torque_base == 0 {
        ", or --pole-pairs where nothing but the motor makes torque"
    } else {
        ""
    };
    Some(format!(
        "a recording at another speed decides {many} {} (quadcal calibrate A.csv B.csv){pole_pairs}",
        orders.join(", ")
    ))
}

/// The orders left alone as a speed loop may hide them, and those that it may hide besides.
#[must_use]
pub fn hidden(calibration: &Calibration) -> Option<String> {
    hidden_words(
        calibration.left_alone_for_loop(),
        calibration.drive.hidden_up_to,
    )
}

fn hidden_words(left: u16, last: u16) -> Option<String> {
    const WHY: &str = "(--loop-hz at the slowest turn, or --hidden-up-to)";
    let words = match left {
        0 => return None,
        1 => format!("order 1 left alone, as a speed loop may hide it {WHY}"),
        _ => format!("orders 1 to {left} left alone, as a speed loop may hide them {WHY}"),
    };
    if left == last {
        return Some(words);
    }
    Some(format!(
        "{words}; it may hide orders {} to {last} too, which can't be left alone: record at a higher speed, or say what the loop \
         did (--twin, --torque)",
        left + 1
    ))
}

/// What a broad hump of low orders means, and what to do.
#[must_use]
pub fn loop_suspected(hump: &LoopSuspicion) -> String {
    let LoopSuspicion { first, last, times } = hump;
    format!(
        "orders {first} to {last} repeat every turn up to {times:.0} times as large as the orders above; a disc hardly does that, a speed \
         loop that ran while recording does, and then the table makes the angle worse: record again in torque or voltage mode, or say \
         what the loop did (--twin with its gains, --torque COLUMN), or leave these orders alone (--hidden-up-to {last})"
    )
}

/// The report's sections on torque, delays and orders left alone.
pub(super) fn sections(
    body: &mut Body,
    calibration: &Calibration,
    findings: &Findings,
    inertia_kg_m2: Option<f64>,
) {
    if !findings.torques.is_empty() {
        torque_section(body, calibration, findings, inertia_kg_m2);
    }
    delay_section(body, &findings.delays);
    let hidden = hidden(calibration);
    if let Some(hidden) = &hidden {
        body.section("Orders hidden by a speed loop", &[&sentence(hidden)]);
    }
    if let Some(hump) = &findings.loop_suspicion {
        body.section("Was a speed loop on?", &[&sentence(&loop_suspected(hump))]);
    }
    let Some(advice) = advice(findings, calibration.drive) else {
        return;
    };
    body.section(
        "Orders left alone",
        &[
            "These orders repeat every turn and stand far above their neighbours. Torque ripple locked to the shaft does that, and \
             so do eccentricity and tilt of the disc; turns at one speed can't tell which. The table does not touch them, so real \
             ripple is not hidden. A disc's error keeps its size in angle, torque ripple shrinks with the square of the speed.",
            &sentence(&advice),
        ],
    );
    let rows = findings.left_alone.iter().map(|left| {
        vec![
            Cell::fixed(f64::from(left.order), 0),
            Cell::si(left.amplitude_rad, "rad"),
        ]
    });
    body.table(
        "Orders left alone",
        &["Order (cycles a turn)", "Peak size in angle"],
        rows.collect(),
    );
}

fn torque_section(
    body: &mut Body,
    calibration: &Calibration,
    findings: &Findings,
    inertia_kg_m2: Option<f64>,
) {
    let [slowest, _] = words::speeds_r_min(&calibration.totals, calibration.clock_hz);
    let inertia = match inertia_kg_m2 {
        Some(inertia) => format!("The torque is that on an inertia of {inertia} kg m²."),
        None => "Times the inertia, the acceleration is the torque (--inertia).".to_owned(),
    };
    let text = format!(
        "The shaft's own swing, locked to its angle: it falls with the square of the speed, which tells it from the disc. It is no \
         error of the encoder and stays in the speed. Swings are those at {}. {inertia}",
        words::speed_range([slowest; 2])
    );
    body.section("Torque ripple", &[&text]);
    let rows = findings.torques.iter().map(|torque| {
        let size = match inertia_kg_m2.map(|inertia| torque.torque_n_m(inertia)) {
            Some([size, error]) => Cell::with_error(size, error, "N m"),
            None => Cell::with_error(
                torque.acceleration_rad_s2,
                torque.acceleration_standard_error_rad_s2,
                "rad/s²",
            ),
        };
        vec![
            Cell::fixed(f64::from(torque.order), 0),
            size,
            Cell::si(100.0 * torque.speed_share(), "%"),
            Cell::with_error(torque.angle_rad, torque.angle_standard_error_rad, "rad"),
        ]
    });
    let amplitude = if inertia_kg_m2.is_some() {
        "Torque ± standard error"
    } else {
        "Acceleration ± standard error"
    };
    body.table(
        "Torque ripple, peak sizes",
        &[
            "Order (cycles a turn)",
            amplitude,
            "Swing of the speed",
            "Swing of the angle ± standard error",
        ],
        rows.collect(),
    );
}

fn delay_section(body: &mut Body, delays: &DelayFindings) {
    const HEAD: &str = "Delays of the edges";
    if let Some(unknown) = delays_unknown(delays) {
        let text = format!("Rise and fall delays and channel skew: {unknown}.");
        body.section(HEAD, &[&text]);
    }
    let found = delays.found();
    if found.is_empty() {
        return;
    }
    body.section(
        HEAD,
        &["Time that one kind of edge is captured after another, beyond what the disc makes: its error in angle grows with the speed, \
           which tells it from xi and p."],
    );
    let rows = found.iter().map(|delay| {
        vec![
            delay.name.into(),
            Cell::with_error(delay.seconds, delay.standard_error_s, "s"),
        ]
    });
    body.table(
        "Delays",
        &["Delay", "Value ± standard error"],
        rows.collect(),
    );
}

/// With a capital and a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(char::to_uppercase);
    first
        .into_iter()
        .flatten()
        .chain(letters)
        .chain(['.'])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ripple(order: u16, angle_rad: f64) -> Torque {
        Torque {
            order,
            angle_rad,
            angle_standard_error_rad: angle_rad / 10.0,
            acceleration_rad_s2: 2.0,
            acceleration_standard_error_rad_s2: 0.2,
        }
    }

    #[test]
    fn torque_is_told_in_newton_metres_where_the_inertia_is_known() {
        let plain = |inertia| torque(&ripple(5, 2e-3), inertia, 15.0).replace('\u{a0}', " ");
        assert_eq!(
            plain(Some(1e-3)),
            "2.00 mN m ± 200 µN m; at 15.00 r/min it swings the speed by 1.00 % and the angle by 2.00 mrad ± 200 µrad"
        );
        assert!(plain(None).starts_with("2.00 rad/s² ± 0.200 rad/s²; at 15.00 r/min"));
    }

    #[test]
    fn torques_below_a_hundredth_of_the_strongest_are_only_counted() {
        let torques = [ripple(5, 2e-3), ripple(10, 2.1e-5), ripple(20, 1.9e-5)];
        let (strong, weaker) = strong(&torques);
        assert_eq!((strong.len(), weaker), (2, 1));
        assert_eq!(super::strong(&[]), (&[][..], 0));
    }

    #[test]
    fn what_a_speed_loop_may_hide_is_said_in_words() {
        assert_eq!(hidden_words(0, 0), None);
        let one = hidden_words(1, 1).unwrap();
        assert!(one.starts_with("order 1 left alone"));
        let all = hidden_words(9, 9).unwrap();
        assert!(all.starts_with("orders 1 to 9 left alone") && !all.contains("too"));
        let part = hidden_words(240, 800).unwrap();
        assert!(part.starts_with("orders 1 to 240 left alone"));
        assert!(part.contains("may hide orders 241 to 800 too"), "{part}");
    }
}
