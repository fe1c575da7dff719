//! The residual of a recording that reverses: where the shaft stops, an edge's place says no time, but its time says a place.
//!
//! The angle of each edge on the disc is compared with that of the twin's undisturbed shaft at the same time; the twin's torques,
//! delays and play are taken off along the way that the shaft really went.

use std::f64::consts::TAU;

use super::basis::Basis;
use super::kalman::Reading;
use super::seen::Seen;
use super::shaft::{Leap, ShaftLaw};
use super::still::Still;
use super::track::{Mark, Track};
use crate::twin::Twin;

impl Seen {
    /// Compares a recording with its twin time by time.
    pub(super) fn compare_by_time(&mut self, track: &Track, twin: &Twin, still: &Still, law: &ShaftLaw) {
        let course: Vec<Mark> = still.pace.iter().flat_map(|s| s.marks.iter().copied()).collect();
        if course.len() < 4 {
            return;
        }
        let step = TAU / track.edges as f64;
        let mut near = 0;
        for stretch in &track.stretches {
            for mark in &stretch.marks {
                while near + 4 < course.len() && course[near + 2].time_s < mark.time_s {
                    near += 1;
                }
                if mark.time_s < course[0].time_s || mark.time_s > course[course.len() - 1].time_s {
                    continue;
                }
                let (place, speed) = through(&course[near..near + 4], mark.time_s);
                let edge = (mark.place + still.origin).rem_euclid(track.edges);
                let edge = usize::try_from(edge).unwrap_or(0);
                let error = still.errors.get(edge).copied().unwrap_or(0.0);
                let after_s = self.times_s.last().map_or(0.0, |last| mark.time_s - last);
                let speed = speed * step;
                self.places.push(mark.place + still.origin);
                self.times_s.push(mark.time_s);
                self.speeds.push(speed.abs() * stretch.direction as f64);
                self.shows.push(1.0);
                self.angles.push((mark.place as f64 - place) * step - error);
                self.readings.push(Reading {
                    leap: Leap {
                        after_s,
                        damping: law.damping(mark.time_s, speed.abs()),
                        spring: law.spring(),
                    },
                    speed: speed.abs(),
                    fresh: false,
                });
            }
        }
        self.take_off(twin, law);
        // The counts of recording and twin may be whole turns apart.
        let turns = (self.angles.first().copied().unwrap_or(0.0) / TAU).round() * TAU;
        self.angles.iter_mut().for_each(|angle| *angle -= turns);
    }

    /// Takes off what the twin's torques, delays and play do.
    fn take_off(&mut self, twin: &Twin, law: &ShaftLaw) {
        let mut known: Vec<(Basis, Vec<f64>)> = Vec::new();
        // torque sin(order theta + phase)
        let round = |size: f64, phase: f64| vec![size * phase.sin(), size * phase.cos()];
        for ripple in twin.ripple.iter().chain(&twin.gear_mesh) {
            let basis = Basis::TorqueOrder { order: ripple.order };
            known.push((basis, round(ripple.torque_n_m.unwrap_or(0.0), ripple.phase_rad)));
        }
        for tone in &twin.torque_tone {
            let basis = Basis::TorqueTone { f_hz: tone.f_hz };
            known.push((basis, round(tone.torque_n_m.unwrap_or(0.0), tone.phase_rad)));
        }
        if let Some(hysteresis) = twin.hysteresis {
            known.push((Basis::Direction, vec![hysteresis.angle_rad]));
        }
        if let Some(backlash) = twin.backlash {
            known.push((Basis::Direction, vec![backlash.gap_rad]));
        }
        for (basis, sizes) in known {
            for (column, size) in basis.columns(self, law).into_iter().zip(sizes) {
                for (angle, value) in self.angles.iter_mut().zip(column) {
                    *angle -= size * value;
                }
            }
        }
    }
}

/// Place and its rate at a time, by the cubic through four edges.
fn through(marks: &[Mark], time_s: f64) -> (f64, f64) {
    let (mut place, mut rate) = (0.0, 0.0);
    for (i, mark) in marks.iter().enumerate() {
        let others: Vec<f64> = (0..marks.len()).filter(|j| *j != i).map(|j| marks[j].time_s).collect();
        let below: f64 = others.iter().map(|t| mark.time_s - t).product();
        let value = mark.place as f64 / below;
        let away: Vec<f64> = others.iter().map(|t| time_s - t).collect();
        place += value * away[0] * away[1] * away[2];
        rate += value * (away[0] * away[1] + away[0] * away[2] + away[1] * away[2]);
    }
    (place, rate)
}
