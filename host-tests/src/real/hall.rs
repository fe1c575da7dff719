//! The two Hall recordings, against twins that know a fixed pattern and a speed.

use std::path::Path;

use anyhow::{Context, Result};
use quadcal_host::diagnose::diagnosis::{Parameter, Verdict};
use quadcal_host::mechanism::Mechanism;
use quadcal_host::sim::Simulation;
use quadcal_host::twin::Twin;

use super::command::{Bench, Said};
use super::fold::{Edge, Edges};
use super::line::Line;

/// A Hall motor's recording and the speed from which on its pattern is folded.
#[derive(Clone, Copy, Debug)]
struct Motor {
    name: &'static str,
    pole_pairs: usize,
    least_rev_s: f64,
}

const SPINDLE: Motor = Motor {
    name: "hall-spindle",
    pole_pairs: 2,
    least_rev_s: 20.0,
};
const HUB: Motor = Motor {
    name: "hall-hub-motor",
    pole_pairs: 15,
    least_rev_s: 2.5,
};

impl Motor {
    fn edges(self, recordings: &Path) -> Result<Edges> {
        let path = recordings.join(format!("{}.csv", self.name));
        Edges::of(&path, 6 * self.pole_pairs)
    }

    /// A twin of a stretch: the pattern, the mean speed, and a shaft that nothing is known of. The turns themselves say how fast
    /// it went, as nothing in the twin holds a speed.
    fn twin(self, edges: &Edges, [from, until]: [usize; 2], errors_csv: &str) -> String {
        let (first, last) = (&edges.all[from], &edges.all[until - 1]);
        let seconds = (last.ticks - first.ticks) as f64 / edges.clock_hz;
        let turns = (last.place - first.place) as f64 / edges.a_turn as f64;
        format!(
            "duration = {{ seconds = {seconds:.3} }}\n[encoder.hall]\npole_pairs = {}\n[errors]\ncsv = \"{errors_csv}\"\n\
             [shaft]\ninertia_kg_m2 = 1e-4\n[drive.constant]\nr_min = {:.2}\n[timer]\nclock_hz = {}\n",
            self.pole_pairs,
            60.0 * turns / seconds,
            edges.clock_hz
        )
    }

    /// Diagnoses a stretch of the recording against the pattern folded on its own turns or given.
    fn diagnose(
        self,
        bench: &Bench,
        edges: &Edges,
        stretch: [usize; 2],
        errors: &[f64],
        name: &str,
    ) -> Result<Said> {
        let name = format!("{}-{name}", self.name);
        let rows: String = errors
            .iter()
            .enumerate()
            .map(|(k, e)| format!("{k},{e:e}\n"))
            .collect();
        let list = format!("{name}.errors.csv");
        bench.write(&list, &format!("k,e_rad\n{rows}"))?;
        let twin = bench.write(&format!("{name}.toml"), &self.twin(edges, stretch, &list))?;
        let recording = bench.write(&format!("{name}.csv"), &edges.cut(stretch[0], stretch[1]))?;
        bench.diagnose(&recording, &twin, &name)
    }
}

/// Halves of a recording, each beginning with the edge that the recording begins with.
fn halves(edges: &Edges) -> [[usize; 2]; 2] {
    let middle = edges.turn_from(edges.all.len() / 2);
    [[0, middle], [middle, edges.all.len()]]
}

/// Delay of each edge as a twin has it, s.
fn delay_s(twin: &Twin, edge: &Edge) -> f64 {
    let delay = twin.edge_delay.unwrap_or_default();
    let skew = twin.channel_skew.unwrap_or_default();
    let (delay, skew) = [
        (delay.a, skew.a_s),
        (delay.b, skew.b_s),
        (delay.c, skew.c_s),
    ][edge.channel];
    skew + if edge.rises {
        delay.rise_s
    } else {
        delay.fall_s
    }
}

/// Rise less fall, mean of the channels, s, and half its 95 % interval at the widest.
fn rise_less_fall(said: &Said) -> Option<(f64, f64)> {
    let finding = said.of(Mechanism::EdgeDelay)?;
    let all: Vec<&Parameter> = finding.parameters.values().collect();
    let mean = all.iter().map(|p| p.value).sum::<f64>() / all.len() as f64;
    let half = |p: &&Parameter| p.ci95.map_or(0.0, |[low, high]| 0.5 * (high - low));
    Some((mean, all.iter().map(half).fold(0.0, f64::max)))
}

fn microseconds((value, half): (f64, f64)) -> String {
    format!("{:.1} +- {:.1} us", 1e6 * value, 1e6 * half)
}

/// hall-spindle: learned and diagnosed on one half, judged on the other, and the other way round.
///
/// # Errors
/// Where something can't be run.
pub fn spindle(bench: &Bench, recordings: &Path) -> Result<Vec<Line>> {
    let motor = SPINDLE;
    let edges = motor.edges(recordings)?;
    let halves = halves(&edges);
    let intervals = edges.intervals(motor.least_rev_s);
    let of = |[from, until]: [usize; 2]| {
        let inside = intervals.iter().filter(|i| (from..until).contains(&i.at));
        inside.copied().collect::<Vec<_>>()
    };
    let whole = edges.unexplained(&intervals, &edges.pattern(&intervals), &|_| 0.0);
    let mut lines = vec![
        Line::told(
            "hall-spindle: fixed pattern of all turns leaves",
            percent(whole),
        ),
        Line::told(
            "  stamps in whole ticks alone leave",
            percent(edges.quantisation(&intervals)),
        ),
    ];
    for (number, (learned, judged)) in [(0, 1), (1, 0)].into_iter().enumerate() {
        let errors = edges.pattern(&of(halves[learned]));
        let name = format!("half-{}", number + 1);
        let said = motor.diagnose(bench, &edges, halves[learned], &errors, &name)?;
        let delay = rise_less_fall(&said);
        let new = Simulation::new(&said.twin)?.true_errors();
        let other = of(halves[judged]);
        let before = edges.unexplained(&other, &errors, &|_| 0.0);
        let after = edges.unexplained(&other, &new, &|edge| delay_s(&said.twin, edge));
        let which = ["first", "second"][learned];
        lines.push(Line::judged(
            &format!("  rise against fall, found on the {which} half"),
            "134 us, within 4",
            delay.map_or(said.names(), microseconds),
            delay.is_some_and(|(value, _)| (value - 134e-6).abs() < 4e-6),
        ));
        lines.push(Line::told(
            "  the other half: pattern alone leaves",
            percent(before),
        ));
        lines.push(Line::judged(
            "  the other half: the new twin leaves",
            "under 1.30 %",
            percent(after),
            after < 0.013,
        ));
    }
    Ok(lines)
}

/// hall-hub-motor: the whole run, its halves, and the stretch of one speed, in which the delay is the pattern's own.
///
/// # Errors
/// Where something can't be run.
pub fn hub(bench: &Bench, recordings: &Path) -> Result<Vec<Line>> {
    let motor = HUB;
    let edges = motor.edges(recordings)?;
    let intervals = edges.intervals(motor.least_rev_s);
    let [first, second] = halves(&edges);
    let early: Vec<_> = intervals
        .iter()
        .filter(|i| i.at < first[1])
        .copied()
        .collect();
    let errors = edges.pattern(&early);
    let all = [0, edges.all.len()];
    let mut lines = Vec::new();
    let mut found = Vec::new();
    for (name, stretch) in [
        ("first-half", first),
        ("second-half", second),
        ("whole", all),
    ] {
        let said = motor.diagnose(bench, &edges, stretch, &errors, name)?;
        let delay = rise_less_fall(&said);
        lines.push(Line::told(
            &format!(
                "hall-hub-motor, {}: rise against fall",
                name.replace('-', " ")
            ),
            delay.map_or(said.names(), microseconds),
        ));
        found.extend(delay);
    }
    if let [one, other, whole] = found.as_slice() {
        // A tick is 33 us, and the formal error of so many stamps is a third of this: what else moves edges is in the interval.
        lines.push(Line::judged(
            "  half the whole's 95 % interval",
            "1.5 us or more",
            format!("{:.1} us", 1e6 * whole.1),
            whole.1 >= 1.5e-6,
        ));
        let apart = (one.0 - other.0).abs();
        let allowed = one.1.hypot(other.1);
        lines.push(Line::judged(
            "  the halves differ by",
            &format!("{:.1} us or less, as they say", 1e6 * allowed),
            format!("{:.1} us", 1e6 * apart),
            apart <= allowed,
        ));
    }
    let steady = steady(&edges).context("no steady stretch")?;
    let said = motor.diagnose(bench, &edges, steady, &errors, "steady")?;
    let finding = said
        .of(Mechanism::EdgeDelay)
        .or(said.of(Mechanism::WidthError));
    let alike = finding.is_some_and(|f| {
        let names = [f.mechanism]
            .into_iter()
            .chain(f.look_alikes.iter().copied());
        let names: Vec<Mechanism> = names.collect();
        names.contains(&Mechanism::EdgeDelay) && names.contains(&Mechanism::WidthError)
    });
    lines.push(Line::judged(
        "  the stretch of one speed: delay or width",
        "ambiguous, what to record",
        format!(
            "{}; next: {}",
            format!("{:?}", said.diagnosis.verdict).to_lowercase(),
            finding
                .and_then(|f| f.next_recording.as_ref())
                .map_or("nothing", |next| next.text.split(':').next().unwrap_or(""))
        ),
        alike
            && said.diagnosis.verdict == Verdict::Ambiguous
            && finding.is_some_and(|f| f.next_recording.is_some()),
    ));
    Ok(lines)
}

/// The longest stretch within 3 % of the top speed.
fn steady(edges: &Edges) -> Option<[usize; 2]> {
    let intervals = edges.intervals(0.0);
    let top_s = intervals.iter().map(|i| i.turn_s).reduce(f64::min)?;
    let near: Vec<usize> = intervals
        .iter()
        .filter(|i| i.turn_s < 1.03 * top_s)
        .map(|i| i.at)
        .collect();
    let from = edges.turn_from(*near.first()?);
    Some([from, near.last()? + 1])
}

fn percent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}
