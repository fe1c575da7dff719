//! The residual: what each edge says of the shaft's angle at its time, less the angle that the twin's shaft has then.
//!
//! The twin's course without disturbance is simulated; under a speed loop the shaft goes where the loop sends it, which hangs on every
//! edge that came before. That push is known: the loop saw the recorded edges (the direct method of closed-loop identification,
//! L. Ljung, System Identification, 2nd ed., section 13.4). The twin's torques, delays, levels and play are taken off along the way
//! that the shaft really went: a shaft that lags keeps the ripple's places, and the tone's times.

use std::f64::consts::TAU;

use super::basis::Basis;
use super::delays::Delays;
use super::kalman::Reading;
use super::known::{known, play_rad};
use super::looped::looped;
use super::pace::pace;
use super::pushed;
use super::run_down::braked;
use super::run_out::RunOuts;
use super::seen::Seen;
use super::shaft::{Leap, ShaftLaw};
use super::slow::too_slow;
use super::still::Still;
use super::swing::{Known, Torques, swing};
use super::track::{Mark, Track};
use crate::twin::{Drive, Twin};

/// What is taken for the error of a swing, over its change from the last pass but one to the last.
const DOUBT: f64 = 2.0;

/// Intervals by which the cubic goes on beyond the twin's first edge and last.
const BEYOND: f64 = 2.0;

/// The shaft's course at the time of each mark: angle, speed, and the variance of a jolt that nobody knows, rad, rad/s and its square;
/// none where it is not known.
pub type Course = Vec<Option<(f64, f64, f64)>>;

impl Seen {
    /// Compares a recording with its twin.
    pub(super) fn compare(&mut self, track: &Track, twin: &Twin, still: &Still, law: &ShaftLaw) {
        let captured = track.directed();
        // Places lie whole turns from the twin's, which changes no edge's class.
        let marks = Delays::of(twin, track.classes).passed(&captured);
        let step = TAU / track.edges as f64;
        let pushed = pushed::course(&marks, track, twin);
        self.pushed = pushed.is_some();
        // What pushes the shaft by what was seen of it goes no even way from edge to edge.
        let even = twin.speed_loop().is_none() && !self.pushed;
        let mut bends = Vec::new();
        // From when on what the real speed brakes is off already.
        let mut free_from_s = f64::INFINITY;
        let course = match (twin.speed_loop(), pushed) {
            (Some(model), _) => {
                // The loop saw what was captured.
                let looped = looped(&captured, &marks, track, twin, &model);
                self.ties = looped.ties;
                bends = looped.bends;
                looped.course
            }
            (None, Some(pushed)) => pushed,
            (None, None) => {
                let own = undisturbed(&marks, still, step);
                match braked(&marks, track, twin, &own) {
                    Some((course, off_s)) => {
                        free_from_s = off_s;
                        course
                    }
                    None => own,
                }
            }
        };
        let mut before: Option<(Mark, i64)> = None;
        // The last edge that was left out as a task held it up, and the jolts until then: the count goes on past it.
        let mut held: Option<(Mark, f64)> = None;
        let slow = too_slow(twin, &course);
        // A shaft that comes to rest is held by friction too; one that is driven round goes on, and its edges say which way it went.
        let rests = matches!(twin.drive, Drive::RunDown { .. });
        self.slow = if rests { 0.0 } else { slow };
        let mut last_speed = None;
        let mut anew = false;
        // What nothing holds, something else pushes, or turns round, goes at its own speed, not at the twin's.
        let unheld = !law.held() || self.pushed || free_from_s.is_finite() || twin.drive.reverses();
        self.measured = unheld;
        let measured = if unheld || slow > 0.0 {
            speeds(&marks, track)
        } else {
            Vec::new()
        };
        for (at, ((mark, direction), there)) in marks.iter().zip(course).enumerate() {
            let Some((angle, speed, jolt)) = there else {
                continue;
            };
            if track
                .ends
                .is_some_and(|ends| ends.has(captured[at].0.time_s))
            {
                held = Some((*mark, held.map_or(0.0, |last| last.1) + jolt));
                continue;
            }
            let own = measured.get(at).copied().flatten();
            // What goes to and fro about one edge has no speed that shows.
            let own = if self.slow > 0.0 {
                own.or(Some(0.0))
            } else {
                own
            };
            let slowly = own.unwrap_or(speed).abs().min(speed.abs()) < slow;
            if slowly && rests {
                anew = true;
                continue;
            }
            let after_s = self.times_s.last().map_or(0.0, |last| mark.time_s - last);
            let bend = match last_speed.replace(speed) {
                Some(last) if even && after_s > 0.0 => (speed - last) / after_s,
                _ => bends.get(at).copied().unwrap_or(0.0),
            };
            self.bends.push(bend);
            // Dry friction turns with the shaft, and not when the twin's does.
            let turns = before.is_some_and(|last| last.1 != *direction) && self.slow > 0.0;
            let along = speed * *direction as f64;
            let rubs = twin.drive.reverses() && (turns || along <= 0.0);
            let rub = 2.0 * twin.friction_n_m(0.0) / law.inertia * after_s;
            let rubbed = if rubs { rub * rub } else { 0.0 };
            self.rubbed.push(rubbed);
            let speed = own.filter(|_| unheld).unwrap_or(speed);
            // A reversal goes on from the last edge; where the count was lost, nothing does.
            let held = held.take();
            let jolt = jolt + held.map_or(0.0, |last| last.1);
            let near = |last: &(Mark, i64)| {
                let last = (held.map_or(last.0, |held| held.0), last.1);
                let apart = (mark.place - last.0.place) * direction;
                last.1 != *direction || (1..=track.classes).contains(&apart)
            };
            let lost = !before.as_ref().is_none_or(near) && !track.anchored;
            // The course starts anew with every push.
            let last = self.readings.last();
            let begins = self.pushed && jolt > 0.0 && last.is_none_or(|last| last.jolt == 0.0);
            let fresh = lost || begins;
            // How it turned round was not seen.
            anew |= before.as_ref().is_some_and(|last| {
                last.1 != *direction && (mark.place - last.0.place).abs() > track.classes
            });
            before = Some((*mark, *direction));
            let edge = (mark.place + still.origin - still.shift).rem_euclid(track.edges);
            let edge = usize::try_from(edge).unwrap_or(0);
            let error = still.errors.get(edge).copied().unwrap_or(0.0);
            self.places.push(mark.place + still.origin);
            self.times_s.push(mark.time_s);
            self.speeds.push(speed.abs() * *direction as f64);
            self.angles.push(mark.place as f64 * step - angle - error);
            self.readings.push(Reading {
                leap: Leap {
                    after_s,
                    damping: if mark.time_s > free_from_s {
                        0.0
                    } else {
                        law.damping(mark.time_s, speed.abs())
                    },
                    spring: law.spring,
                },
                speed: speed.abs(),
                at_s: mark.time_s,
                fresh,
                anew: std::mem::take(&mut anew),
                jolt: jolt + rubbed,
                doubt_s: 0.0,
            });
        }
        // The counts of recording and twin may be whole turns apart.
        let turns = (self.angles.first().copied().unwrap_or(0.0) / TAU).round() * TAU;
        self.angles.iter_mut().for_each(|angle| *angle -= turns);
    }

    /// Takes off what the twin's run-out and torques do on the disc as it is known now.
    pub(super) fn swing(&mut self) {
        self.run_out();
        let swing = swing(self, &self.torques);
        let each = swing.angles.iter().zip(&self.swings);
        for (angle, (now, before)) in self.angles.iter_mut().zip(each) {
            *angle -= now - before;
        }
        self.swings = swing.angles;
        // A speed that was measured has most of the swing in it.
        if !self.measured {
            self.swung = swing.speeds;
        }
        self.smoothest = std::sync::OnceLock::new();
        self.pace = pace(self, &[]);
        for (at, way) in swing.ways.into_iter().enumerate() {
            if self.speeds[at].abs() >= self.slow {
                continue;
            }
            let reading = &mut self.readings[at];
            match way {
                Known::Within(speed) => reading.jolt = self.rubbed[at] + (DOUBT * speed).powi(2),
                Known::Unseen => reading.anew = true,
            }
        }
    }

    /// Takes off what the twin's torques, run-out, levels and play do.
    pub(super) fn take_off(&mut self, twin: &Twin, law: &ShaftLaw) {
        self.level_off = vec![0.0; self.len()];
        let looped = twin.speed_loop().is_some();
        for (basis, sizes) in known(twin, looped) {
            let level = matches!(basis, Basis::LevelTone { .. } | Basis::LevelDrift { .. });
            for (column, size) in basis.columns(self, law).into_iter().zip(sizes) {
                for (at, value) in column.into_iter().enumerate() {
                    self.angles[at] -= size * value;
                    if level {
                        self.level_off[at] += size * value;
                    }
                }
            }
        }
        self.play_rad = play_rad(twin);
        for at in 0..self.len() {
            self.angles[at] += self.play_rad * self.side(at);
        }
        // Where the shaft is when an edge comes is known now.
        self.torques = Torques::of(twin, law);
        self.run_outs = RunOuts::of(twin);
        self.swings = vec![0.0; self.len()];
        self.swing();
    }
}

/// The twin's shaft without disturbance, by the cubic through four of its edges.
fn undisturbed(marks: &[(Mark, i64)], still: &Still, step: f64) -> Course {
    let course = &still.pace;
    let step = step / still.finer as f64;
    let (Some(first), Some(last)) = (course.first(), course.last()) else {
        return vec![None; marks.len()];
    };
    if course.len() < 4 {
        return vec![None; marks.len()];
    }
    // A delay puts the first edge before the first that the twin has, and a faster twin ends before the last.
    let beyond_s = BEYOND * still.finer as f64 * (course[1].time_s - first.time_s);
    let mut near = 0;
    let each = marks.iter().map(|(mark, _)| {
        while near + 4 < course.len() && course[near + 2].time_s < mark.time_s {
            near += 1;
        }
        (first.time_s - beyond_s..=last.time_s + beyond_s)
            .contains(&mark.time_s)
            .then(|| {
                let (place, rate) = through(&course[near..near + 4], mark.time_s);
                (place * step, rate * step, 0.0)
            })
    });
    each.collect()
}

/// Speed at each mark over about a turn, in which the disc's errors cancel, or over some lines of a fine disc, rad/s; over a few
/// edges where the direction does not hold for so long.
pub(super) fn speeds(marks: &[(Mark, i64)], track: &Track) -> Vec<Option<f64>> {
    const FINE: i64 = 240;
    let step = TAU / track.edges as f64;
    let lines = track.edges / track.classes;
    let window = if track.edges <= FINE {
        track.edges
    } else {
        track.classes * (lines / 60).max(1)
    };
    let half = (window / 2).max(1) as usize;
    (0..marks.len())
        .map(|at| {
            let from = at.saturating_sub(half);
            let until = (at + half).min(marks.len() - 1);
            let way = (marks[until].0.place - marks[from].0.place) as f64 * step;
            let time = marks[until].0.time_s - marks[from].0.time_s;
            let straight = way.abs() > 0.9 * (until - from) as f64 * step && until > from;
            if straight && time > 0.0 {
                return Some(way / time);
            }
            // Where it turns round, as far as it gets in a few edges.
            let few = &marks[at.saturating_sub(2)..(at + 3).min(marks.len())];
            let places = few.iter().map(|(mark, _)| mark.place);
            let way = places.clone().max()? - places.min()?;
            let time = few.last()?.0.time_s - few.first()?.0.time_s;
            (time > 0.0 && way > 0).then(|| way as f64 * step / time)
        })
        .collect()
}

/// Place and its rate at a time, by the cubic through four edges.
fn through(marks: &[Mark], time_s: f64) -> (f64, f64) {
    let (mut place, mut rate) = (0.0, 0.0);
    for (i, mark) in marks.iter().enumerate() {
        let others: Vec<f64> = (0..marks.len())
            .filter(|j| *j != i)
            .map(|j| marks[j].time_s)
            .collect();
        let below: f64 = others.iter().map(|t| mark.time_s - t).product();
        let value = mark.place as f64 / below;
        let away: Vec<f64> = others.iter().map(|t| time_s - t).collect();
        place += value * away[0] * away[1] * away[2];
        rate += value * (away[0] * away[1] + away[0] * away[2] + away[1] * away[2]);
    }
    (place, rate)
}
