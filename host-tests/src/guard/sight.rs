//! What tells two rigs apart, at best: the difference of their edges without noise, in units of the noise.
//!
//! Both twins run without noise. The difference in time of each edge that both pass, times the speed, is the signal; the filter of
//! `quadcal-blind` makes the noise white, and start angle and speed, which no one knows beforehand, are taken out. To its length comes
//! what noise of other size shows by itself, and what is counted: edges that one of the two has not, glitches.

use std::collections::HashMap;
use std::f64::consts::TAU;

use anyhow::Result;
use quadcal_blind::ideal::DETECTABLE;
use quadcal_blind::whiten::{Edge, Whitener};
use quadcal_host::sim::{Class, Simulation};
use toml::Table;

use super::tree::{self, number};

/// Tick rate at which runs without noise are captured, Hz: finer than any stamp's error.
const CLOCK_HZ: i64 = 1_000_000_000_000;
/// Way at either end of a run that is left out, rad: as far as a change moves an edge.
const END_RAD: f64 = 0.06;
/// Least speed at which an edge counts, as a share of the largest: at standstill a stamp says all.
const SLOWEST: f64 = 1e-2;

/// One edge of a run without noise.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// Class, place through all turns, and how often it was passed before.
    key: (Class, i64, u32),
    time_s: f64,
    angle_rad: f64,
}

/// A run without noise.
struct Run {
    edges: Vec<Seen>,
    edges_a_turn: f64,
    glitches: usize,
}

/// How surely the recordings of two rigs are told apart, d'. The noise is that of the first.
///
/// # Errors
/// Where one of them can't be simulated.
pub fn distance(one: &Table, other: &Table) -> Result<f64> {
    let (one, other) = (&held(one, other), &held(other, one));
    let (here, there) = (run(one)?, run(other)?);
    let noise = noise(one, &here);
    let step = here.edges_a_turn.recip() * TAU;
    let ends = 1 + (END_RAD / step).ceil() as usize;
    let signal = signal(&here, &there, &noise, ends);
    let counted = counted(&here, &there, ends) as f64 * DETECTABLE;
    let by_size = by_size(&noise, &self::noise(other, &here));
    Ok(counted + (signal * signal + by_size * by_size).sqrt())
}

/// A rig whose loop is that of another one too, with a drive in place of the loop that pulls as strongly. Which interval a sample sees
/// hangs on a hair, so that a loop answers the smallest change with another course; that is no mark of the change.
fn held(one: &Table, other: &Table) -> Table {
    let path = tree::path("drive.speed_loop");
    let control = tree::get(one, &path);
    let mut held = one.clone();
    if control.is_some() && control == tree::get(other, &path) {
        let r_min = number(one, "drive.speed_loop.r_min").unwrap_or(0.0);
        tree::remove(&mut held, &path);
        tree::set(&mut held, "drive.constant.r_min", r_min);
        tree::add(&mut held, "shaft.stiffness_n_m_s", gain(one));
    }
    held
}

/// Proportional gain of a rig's loop, N m s; 0 without one.
fn gain(tree: &Table) -> f64 {
    let bandwidth = || {
        let hz = number(tree, "drive.speed_loop.bandwidth_hz")?;
        Some(TAU * hz * number(tree, "shaft.inertia_kg_m2")?)
    };
    number(tree, "drive.speed_loop.kp_n_m_s")
        .or_else(bandwidth)
        .unwrap_or(0.0)
}

/// Runs a twin with its noise taken out.
fn run(tree: &Table) -> Result<Run> {
    let mut calm = tree.clone();
    if number(tree, "noise.speed_wander.rms_fraction").is_some() {
        // It says how stiffly the drive holds its speed, too.
        tree::set(&mut calm, "noise.speed_wander.rms_fraction", 1e-15);
    } else {
        calm.remove("noise");
    }
    for dotted in [
        "timer.jitter_s",
        "torsional_resonance.load_psd_n2_m2_s",
        "torsional_resonance.load_hold_s",
        "capture_latency.mean_s",
        "faults.lost_probability",
    ] {
        tree::remove(&mut calm, &tree::path(dotted));
    }
    if calm
        .get("capture_latency")
        .and_then(toml::Value::as_table)
        .is_some_and(Table::is_empty)
    {
        calm.remove("capture_latency");
    }
    tree::set(&mut calm, "timer.clock_hz", CLOCK_HZ);
    let simulation = Simulation::new(&tree::twin(&calm)?)?;
    let edges_a_turn = simulation.true_errors().len() as f64;
    let mut visits: HashMap<(Class, i64), u32> = HashMap::new();
    let mut run = Run {
        edges: Vec::new(),
        edges_a_turn,
        glitches: 0,
    };
    for event in simulation {
        if event.truth.class == Class::Glitch {
            run.glitches += 1;
            continue;
        }
        let angle_rad = event.truth.angle_rad;
        let place = match event.truth.edge {
            Some(k) => {
                let grid = TAU * f64::from(k) / edges_a_turn;
                i64::from(k) + (edges_a_turn * ((angle_rad - grid) / TAU).round()) as i64
            }
            None => (angle_rad / TAU).round() as i64,
        };
        let visit = visits.entry((event.truth.class, place)).or_insert(0);
        run.edges.push(Seen {
            key: (event.truth.class, place, *visit),
            time_s: event.row.ticks as f64 / CLOCK_HZ as f64,
            angle_rad,
        });
        *visit += 1;
    }
    Ok(run)
}

/// Speed at each edge, rad/s, either way.
fn speeds(run: &Run) -> Vec<f64> {
    let edges = &run.edges;
    let at = |at: usize| {
        let (from, to) = (at.saturating_sub(1), (at + 1).min(edges.len() - 1));
        let long = edges[to].time_s - edges[from].time_s;
        let way = edges[to].angle_rad - edges[from].angle_rad;
        if long > 0.0 { (way / long).abs() } else { 0.0 }
    };
    let speeds: Vec<f64> = (0..edges.len()).map(at).collect();
    let top = speeds.iter().copied().fold(0.0, f64::max);
    speeds
        .iter()
        .map(|speed| speed.max(SLOWEST * top))
        .collect()
}

/// The noise of a rig over the edges of a run.
struct Noise {
    edges: Vec<Edge>,
    /// Density of the acceleration, (rad/s^2)^2 s.
    density: f64,
    speeds: Vec<f64>,
}

fn noise(tree: &Table, run: &Run) -> Noise {
    let of = |dotted: &str| number(tree, dotted).unwrap_or(0.0);
    let speeds = speeds(run);
    let top = speeds.iter().copied().fold(0.0, f64::max);
    let inertia = of("shaft.inertia_kg_m2");
    let damping = match number(tree, "noise.speed_wander.correlation_rad") {
        Some(way) => top / way,
        None => (of("shaft.viscous_n_m_s") + of("shaft.stiffness_n_m_s") + gain(tree)) / inertia,
    };
    let wander = of("noise.speed_wander.rms_fraction") * top;
    // Below a mode, what shakes its far side shakes all of it.
    let psd = of("noise.white.psd_n2_m2_s") + of("torsional_resonance.load_psd_n2_m2_s");
    let density = psd / (inertia * inertia) + 2.0 * damping * wander * wander;
    let tick = 1.0 / of("timer.clock_hz");
    let stamp =
        of("timer.jitter_s").powi(2) + of("capture_latency.mean_s").powi(2) + tick * tick / 12.0;
    let mut since = 0.0;
    let edges = run.edges.iter().zip(&speeds).map(|(edge, speed)| {
        let since_s = (edge.time_s - since).max(0.0);
        since = edge.time_s;
        Edge {
            since_s,
            damping,
            slope: 0.0,
            own_rad2: speed * speed * stamp,
        }
    });
    Noise {
        edges: edges.collect(),
        density,
        speeds,
    }
}

impl Noise {
    /// A signal in units of the noise. Without torque noise the course is exact, and each edge stands for itself.
    fn white(&self, signal: &[f64]) -> Vec<f64> {
        if self.density > 0.0 {
            return Whitener::new(&self.edges, self.density).apply(signal);
        }
        let each = signal.iter().zip(&self.edges);
        each.map(|(value, edge)| value / edge.own_rad2.sqrt())
            .collect()
    }

    /// Standard deviations of what each edge adds to the ones before, rad.
    fn deviations(&self) -> Vec<f64> {
        if self.density > 0.0 {
            return Whitener::new(&self.edges, self.density)
                .deviations()
                .collect();
        }
        self.edges.iter().map(|edge| edge.own_rad2.sqrt()).collect()
    }
}

/// Length of what moves, without start angle and speed.
///
/// Edges at the very ends may not be met by the other; what they might have said must not be made up.
fn signal(here: &Run, there: &Run, noise: &Noise, ends: usize) -> f64 {
    let times: HashMap<_, f64> = there.edges.iter().map(|e| (e.key, e.time_s)).collect();
    let until = here.edges.len().saturating_sub(ends);
    let mut last = (here
        .edges
        .iter()
        .skip(ends)
        .zip(&noise.speeds[ends.min(until)..]))
    .find_map(|(edge, speed)| Some((times.get(&edge.key)? - edge.time_s) * speed))
    .unwrap_or(0.0);
    let moved = here.edges.iter().zip(&noise.speeds).enumerate();
    let moved = moved.map(|(at, (edge, speed))| {
        // An edge that is not met says nothing of its own.
        if (ends..until).contains(&at)
            && let Some(time) = times.get(&edge.key)
        {
            last = (time - edge.time_s) * speed;
        }
        last
    });
    let moved: Vec<f64> = moved.collect();
    let mut white = noise.white(&moved);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let columns: [&dyn Fn(&Seen) -> f64; 3] =
        [&|_| 1.0, &|edge| edge.time_s, &|edge| edge.angle_rad];
    for column in columns {
        let column: Vec<f64> = here.edges.iter().map(column).collect();
        let mut column = noise.white(&column);
        let before = dot(&column, &column);
        for _ in 0..2 {
            for known in &basis {
                take(&mut column, known);
            }
        }
        let after = dot(&column, &column);
        if after > 1e-9 * before {
            column.iter_mut().for_each(|value| *value /= after.sqrt());
            basis.push(column);
        }
    }
    for column in &basis {
        take(&mut white, column);
    }
    dot(&white, &white).sqrt()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes a column of length 1 out of a signal.
fn take(signal: &mut [f64], column: &[f64]) {
    let share = dot(signal, column);
    let pairs = signal.iter_mut().zip(column);
    pairs.for_each(|(value, column)| *value -= share * column);
}

/// What noise of another size shows: half the squared log ratio of each variance.
fn by_size(one: &Noise, other: &Noise) -> f64 {
    let pairs = one.deviations().into_iter().zip(other.deviations());
    // A diffuse start says nothing.
    let each = pairs
        .skip(10)
        .map(|(one, other)| 2.0 * (other / one).ln().powi(2));
    each.sum::<f64>().sqrt()
}

/// Edges within the run that one has and the other has not, by themselves: not those by which a run is longer, or turns later.
fn counted(here: &Run, there: &Run, ends: usize) -> usize {
    let lacks = |one: &Run, other: &Run| {
        let keys: std::collections::HashSet<_> = other.edges.iter().map(|e| e.key).collect();
        let has: Vec<bool> = one.edges.iter().map(|e| keys.contains(&e.key)).collect();
        let within = has.get(ends..has.len().saturating_sub(ends)).unwrap_or(&[]);
        within.windows(3).filter(|w| w[0] && !w[1] && w[2]).count()
    };
    let glitches = here.glitches.abs_diff(there.glitches) / 2;
    lacks(here, there) + lacks(there, here) + glitches
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWIN: &str = "duration = { turns = 10 }\n[encoder.quadrature]\nlines = 250\nindex = true\n\
        [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-3\n[drive.constant]\nr_min = 300\n\
        [timer]\nclock_hz = 84000000\njitter_s = 1e-6\n";

    fn with(more: &str) -> Table {
        tree::parse(&format!("{TWIN}{more}")).unwrap()
    }

    #[test]
    fn an_eccentricity_shows_by_its_size_over_that_of_a_stamp_and_the_root_of_the_edges() {
        let rig = with("[errors]\neccentricity = { amplitude_rad = 1e-6 }\n");
        let found = distance(&with(""), &rig).unwrap();
        // 10,000 edges, 1e-6 / sqrt(2) RMS against 1e-6 s at 31.4 rad/s; the index adds 20.
        let expected = (1e4_f64 / 2.0).sqrt() * 1e-6 / (1e-6 * 31.416);
        assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
        assert!(distance(&with(""), &with("")).unwrap() < 1e-6);
    }

    #[test]
    fn jitter_shows_by_its_variance_and_a_lost_edge_by_its_count() {
        let mut twice = with("");
        tree::set(&mut twice, "timer.jitter_s", 1.1e-6);
        let found = distance(&with(""), &twice).unwrap();
        let expected = (1e4_f64 / 2.0).sqrt() * 2.0 * 1.1_f64.ln();
        assert!((found / expected - 1.0).abs() < 0.1, "{found} {expected}");
        let lost = with("[faults]\nlost_edges = [500, 900]\n");
        let found = distance(&with(""), &lost).unwrap();
        assert!((found - 2.0 * DETECTABLE).abs() < 1e-3, "{found}");
    }
}
