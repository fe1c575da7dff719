//! Recordings of real machines in one table: each against a twin of sensor, timer, inertia and mean speed, with what is known of it.

use std::path::Path;

use anyhow::Result;
use quadcal_host::diagnose::diagnosis::{Diagnosis, Finding};
use quadcal_host::mechanism::Mechanism;

use super::command::Bench;
use super::line::Line;
use crate::trial::score::verdict_name;

/// Confidence above which a false name counts.
const SURE: f64 = 0.99;
/// How far the residual may grow on held-out turns by rounding alone, as a ratio.
const ROUNDING: f64 = 1.0001;
/// Column of a logic analyser's export that the wheel is in.
const CHANNEL: [&str; 2] = ["--map", "a=Channel 0"];

/// One recording.
#[derive(Clone, Copy, Debug)]
pub struct Recording {
    /// Its file, without the folder.
    pub file: &'static str,
    /// Section of its encoder.
    encoder: &'static str,
    /// Section of its drive, as much as a user could say.
    drive: &'static str,
    /// Tick rate of its stamps, Hz.
    clock_hz: u64,
    /// Inertia, kg m^2.
    inertia: f64,
    /// Length, s.
    seconds: f64,
    /// Whether it is a logic analyser's.
    logic: bool,
    /// What is known of it from elsewhere.
    known: &'static str,
    /// Names that are known to be false.
    never: &'static [Mechanism],
}

const HALL: &str = "[encoder.hall]\npole_pairs = 2\n";

/// The recordings.
pub const RECORDINGS: [Recording; 10] = [
    Recording {
        file: "hall-spindle.csv",
        encoder: HALL,
        drive: "[drive.constant]\nr_min = 4983\n",
        clock_hz: 30_000,
        inertia: 2e-5,
        seconds: 28.8,
        logic: false,
        known: "slots; rise against fall 134 us",
        never: &[Mechanism::LostEdges, Mechanism::ExtraEdges],
    },
    Recording {
        file: "hall-spindle-sweep.csv",
        encoder: HALL,
        drive: "[drive.constant]\nr_min = 2229\n",
        clock_hz: 30_000,
        inertia: 2e-5,
        seconds: 52.6,
        logic: false,
        known: "slots; rise against fall 259 to 284 us by channel",
        never: &[Mechanism::LostEdges, Mechanism::ExtraEdges],
    },
    Recording {
        file: "hall-speed-cycle.csv",
        encoder: HALL,
        drive: "[drive.constant]\nr_min = 2422\n",
        clock_hz: 30_000,
        inertia: 2e-5,
        seconds: 21.9,
        logic: false,
        known: "slots; no delay; steps and ramps of the drive",
        never: &[
            Mechanism::EdgeDelay,
            Mechanism::LostEdges,
            Mechanism::ExtraEdges,
        ],
    },
    Recording {
        file: "hall-hub-motor.csv",
        encoder: "[encoder.hall]\npole_pairs = 15\n",
        drive: "[drive.constant]\nr_min = 98\n",
        clock_hz: 30_000,
        inertia: 1e-3,
        seconds: 19.4,
        logic: false,
        known: "slots; a delay that is nearly one with them; it reverses",
        never: &[Mechanism::LostEdges, Mechanism::ExtraEdges],
    },
    Recording {
        file: "flywheel-6-magnets.csv",
        encoder: "[encoder.wheel]\nteeth = 6\n",
        drive: "[drive.run_down]\nr_min = 1066\noff_s = 0\n",
        clock_hz: 1_000_000,
        inertia: 0.1001,
        seconds: 591.2,
        logic: false,
        known: "magnets' places; drag by speed^1.97; 206 pushes; none lost",
        never: &[Mechanism::LostEdges, Mechanism::ExtraEdges],
    },
    Recording {
        file: "flywheel-lost-pulses.csv",
        encoder: "[encoder.wheel]\nteeth = 3\n",
        drive: "[drive.run_down]\nr_min = 820\noff_s = 0\n",
        clock_hz: 1_000_000,
        inertia: 0.1001,
        seconds: 182.1,
        logic: false,
        known: "about 250 pulses lost, mostly one at a time",
        never: &[Mechanism::ExtraEdges],
    },
    Recording {
        file: "wheel-36-2-1-running.csv",
        encoder: "[encoder.wheel]\nteeth = 36\nmissing = 2\n",
        drive: "[drive.constant]\nr_min = 1400\n",
        clock_hz: 1_000_000_000,
        inertia: 0.15,
        seconds: 1.29,
        logic: true,
        known: "a third tooth is missing; edges beside gaps bent; orders 0.5, 1, 2 of the speed",
        never: &[Mechanism::LostEdges, Mechanism::ExtraEdges],
    },
    Recording {
        file: "wheel-60-2-cranking.csv",
        encoder: "[encoder.wheel]\nteeth = 60\nmissing = 2\n",
        drive: "[drive.constant]\nr_min = 380\n",
        clock_hz: 1_000_000_000,
        inertia: 0.15,
        seconds: 7.0,
        logic: true,
        known: "order 2 of the speed, 16 % while cranking; no extra edges",
        never: &[Mechanism::ExtraEdges],
    },
    Recording {
        file: "crank-v6-plugs-out.csv",
        encoder: "[encoder.wheel]\nteeth = 36\n",
        drive: "[drive.constant]\nr_min = 164\n",
        clock_hz: 1_000_000_000,
        inertia: 0.15,
        seconds: 6.3,
        logic: true,
        known: "32 teeth of 36, three gaps; run-up, steady, coasts from 5.18 s",
        never: &[Mechanism::LostEdges, Mechanism::ExtraEdges],
    },
    Recording {
        file: "crank-v6-plugs-in.csv",
        encoder: "[encoder.wheel]\nteeth = 36\n",
        drive: "[drive.constant]\nr_min = 166\n",
        clock_hz: 1_000_000_000,
        inertia: 0.15,
        seconds: 7.9,
        logic: true,
        known: "the same wheel; torque at order 3 and harmonics; rocks back at 7.59 s",
        never: &[Mechanism::ExtraEdges],
    },
];

impl Recording {
    /// Its twin; without a drive where that is left to the diagnosis.
    #[must_use]
    pub fn twin(&self, with_drive: bool) -> String {
        format!(
            "duration = {{ seconds = {} }}\n{}[shaft]\ninertia_kg_m2 = {:e}\n{}[timer]\nclock_hz = {}\n",
            self.seconds,
            self.encoder,
            self.inertia,
            if with_drive { self.drive } else { "" },
            self.clock_hz
        )
    }

    /// Diagnoses it; nothing where the folder has it not.
    ///
    /// # Errors
    /// Where a file can't be written.
    pub fn diagnose(&self, bench: &Bench, folder: &Path, with_drive: bool) -> Result<Vec<Line>> {
        let path = folder.join(self.file);
        let name = self.file.trim_end_matches(".csv");
        if !path.is_file() {
            return Ok(vec![Line::told(name, "not there".to_owned())]);
        }
        let mut bench = bench.clone();
        if self.logic {
            bench.arguments.extend(CHANNEL.map(str::to_owned));
        }
        let twin = bench.write(&format!("{name}.toml"), &self.twin(with_drive))?;
        let mut lines = vec![Line::told(name, format!("known: {}", self.known))];
        match bench.diagnose(&path, &twin, name) {
            Ok(said) => lines.extend(self.lines(&said.diagnosis)),
            Err(why) => {
                let why = format!("{why:#}");
                let first = why.lines().next().unwrap_or_default().to_owned();
                lines.push(Line::judged("  diagnosed", "", first, false));
            }
        }
        Ok(lines)
    }

    fn lines(&self, said: &Diagnosis) -> Vec<Line> {
        let verdict = verdict_name(said.verdict).to_owned();
        let mut lines = vec![Line::told("  verdict", verdict)];
        lines.extend(said.findings.iter().map(|found| {
            let name = format!("  {} {:.1} %", found.mechanism, 100.0 * found.confidence);
            Line::told(&name, values(found))
        }));
        let wrong: Vec<&str> = said
            .findings
            .iter()
            .filter(|found| found.confidence > SURE && self.never.contains(&found.mechanism))
            .map(|found| found.mechanism.id())
            .collect();
        let none = wrong.is_empty();
        let text = if none {
            "none".to_owned()
        } else {
            wrong.join(", ")
        };
        lines.push(Line::judged(
            "  names known to be false",
            "none over 99 %",
            text,
            none,
        ));
        let held_out = &said.fit.held_out;
        if let (Some(before), Some(after)) = (held_out.rms_before_rad, held_out.rms_after_rad) {
            lines.push(Line::judged(
                "  RMS on held-out turns",
                "no larger than before",
                format!("{:.4} mrad, {:.4} before", 1e3 * after, 1e3 * before),
                after <= before * ROUNDING,
            ));
        }
        lines
    }
}

/// Values of a finding with their intervals.
fn values(found: &Finding) -> String {
    let each = found.parameters.iter().map(|(name, parameter)| {
        let half = parameter.ci95.map(|[low, high]| 0.5 * (high - low));
        let half = half.map_or_else(String::new, |half| format!(" +- {half:.2e}"));
        format!("{name} {:.4e}{half}", parameter.value)
    });
    each.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use quadcal_host::twin::Twin;

    use super::*;

    #[test]
    fn every_recording_has_a_twin_and_its_own_name() {
        for recording in &RECORDINGS {
            let twin = Twin::parse(&recording.twin(true), recording.file).unwrap();
            twin.check().unwrap();
            assert!(!recording.twin(false).contains("drive"));
        }
        let mut names: Vec<&str> = RECORDINGS.iter().map(|one| one.file).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), RECORDINGS.len());
    }
}
