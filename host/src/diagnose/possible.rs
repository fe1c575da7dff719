//! What no machine can be: friction that drives a shaft, edges that pass each other, a disc that is off its centre by more than any.

use std::f64::consts::TAU;

use super::bench::Bench;
use super::effect::{Carrier, Effect, Growth, Here, Site};
use super::model::{Board, Model, Term};
use super::pattern::LARGE;
use crate::mechanism::Mechanism;

/// Speeds at which friction is seen, and part of its largest that errors of its numbers may make push.
const SPEEDS: u32 = 8;
const FREE: f64 = 0.05;
/// Edges within the time constant of what settles, at the least.
const SETTLES: usize = 8;
/// Order that torques of motors and gears stay below: more edges a turn show all of them as they are.
const HIGHEST: f64 = 64.0;

impl Board {
    /// Whether a machine can be so.
    #[must_use]
    pub fn can_be(&self, model: &Model) -> bool {
        let mut terms = model.terms.iter();
        terms.all(|term| !self.is_alias(&term.effect) && self.shows_settle(&term.effect))
            && self.keeps_order(model)
            && self.dissipates(model)
    }

    /// Whether an order of the disc is another effect's: past half of the edges it is that of a lower one, and what is the same at each line
    /// is that of edge classes, where these are no more numbers than the wave. Torques past it and above those of motors and gears show nowhere but where the shaft hardly moves, as
    /// anything does that happens there; so do those that edges show as less than once a turn, where the drive is unknown.
    #[must_use]
    pub fn is_alias(&self, effect: &Effect) -> bool {
        let Carrier::Order(order) = effect.carrier else {
            return false;
        };
        self.benches.iter().any(|bench| {
            let record = &bench.record;
            let lines = (record.of_edges / record.classes) as f64;
            let fast = order > 0.5 * record.edges as f64;
            match effect.site {
                Site::Disc(_) => fast || record.channels() < 3 && (order / lines).fract() == 0.0,
                Site::Torque => {
                    let edges = record.edges as f64;
                    let off = order - edges * (order / edges).round();
                    fast && (order > HIGHEST || self.undriven && off.abs() < 1.0)
                }
                _ => false,
            }
        })
    }

    /// Whether edges show how an effect settles: what is over within a few of them is there all along.
    fn shows_settle(&self, effect: &Effect) -> bool {
        let Carrier::Settling(from_s, tau_s) = effect.carrier else {
            return true;
        };
        self.benches.iter().any(|bench| {
            let times = &bench.record.time_s;
            let before = |time_s: f64| times.partition_point(|time| *time <= time_s);
            before(from_s + tau_s) - before(from_s) >= SETTLES
        })
    }

    /// Orders of torques that move evenly spaced edges as one of an order does: each follows only so many a turn. Higher
    /// ones than a motor's are none.
    #[must_use]
    pub fn images(&self, effect: &Effect) -> Vec<Effect> {
        self.mirrored(effect, u32::MAX)
    }

    /// Those of them that one turn's edges mirror: a search that goes from one to the next reaches all.
    #[must_use]
    pub fn nearest_images(&self, effect: &Effect) -> Vec<Effect> {
        self.mirrored(effect, 1)
    }

    /// Whether anything but how its size goes with the speed tells a torque from its images: how stiffly an unknown drive holds the shaft is
    /// open, and makes one of the other. Where the shaft turns round they push other ways.
    #[must_use]
    pub fn tells_images(&self) -> bool {
        let mut ways = self.benches.iter().map(|bench| &bench.record.way);
        !self.undriven || ways.any(|way| way.windows(2).any(|two| two[0] != two[1]))
    }

    fn mirrored(&self, effect: &Effect, most: u32) -> Vec<Effect> {
        let (Site::Torque, Carrier::Order(order)) = (effect.site, effect.carrier) else {
            return Vec::new();
        };
        let edges = self.benches.first().map_or(0, |bench| bench.record.edges) as f64;
        if edges <= 0.0 {
            return Vec::new();
        }
        let most = most.min(((HIGHEST + order) / edges) as u32);
        let turns = (1..=most).map(|all| f64::from(all) * edges);
        let each = turns.flat_map(|all| [(all - order).abs(), all + order]);
        each.filter(|image| *image > 0.0 && *image != order && *image < HIGHEST)
            .map(|image| Effect {
                carrier: Carrier::Order(image),
                ..*effect
            })
            .collect()
    }

    /// Whether an effect is a torque that a lower order looks like, or, the same at each line, edge classes.
    #[must_use]
    pub fn is_image(&self, effect: &Effect) -> bool {
        let (Site::Torque, Carrier::Order(order)) = (effect.site, effect.carrier) else {
            return false;
        };
        let records = self.benches.iter().map(|bench| &bench.record);
        let edges = records.clone().map(|record| record.edges).max();
        let mut lines = records
            .filter(|record| record.classes > 1)
            .map(|record| (record.of_edges / record.classes) as f64);
        2.0 * order > edges.unwrap_or(0) as f64 || lines.any(|lines| (order / lines).fract() == 0.0)
    }

    /// Whether all friction together, declared and found, takes energy from the shaft at every speed that it has.
    fn dissipates(&self, model: &Model) -> bool {
        let own = |term: &&Term| term.effect.is_friction() && term.effect.site == Site::Torque;
        let found: Vec<&Term> = model.terms.iter().filter(own).collect();
        if found.is_empty() {
            return true;
        }
        self.benches.iter().all(|bench| {
            let law = &bench.plant.law;
            let steady = bench.course.steady.iter().map(|speed| speed.abs());
            let (least, most) = steady.fold((f64::INFINITY, 0.0_f64), |(least, most), speed| {
                (least.min(speed), most.max(speed))
            });
            let here = |speed| Here {
                time_s: 0.0,
                inside_s: 0.0,
                angle: 0.0,
                speed,
                way: 1.0,
            };
            let pushes = (0..=SPEEDS).map(|at| {
                let speed = least + (most - least) * f64::from(at) / f64::from(SPEEDS);
                let each = found.iter();
                let each = each.map(|term| term.effect.sized(&term.sizes, here(speed)));
                let declared = law.inertia * (law.friction(speed).0 + law.viscous * speed);
                each.sum::<f64>() - declared
            });
            // Each kind by itself as well: none feeds the shaft what another one takes.
            let kinds = found.iter().flat_map(|term| {
                let alike = found.iter().filter(|other| other.effect == term.effect);
                let sizes: f64 = alike.map(|other| other.sizes[0]).sum();
                let all = sizes + law.inertia * law.coefficient(term.effect.carrier);
                [least, most].map(|speed| term.effect.sized(&[all], here(speed)))
            });
            let pushes: Vec<f64> = pushes.chain(kinds).collect();
            let largest = pushes
                .iter()
                .fold(0.0_f64, |most, push| most.max(push.abs()));
            pushes.into_iter().all(|push| push <= FREE * largest)
        })
    }

    /// Whether all edges come in their order with what a model shifts: an edge does not pass the next one, and one of many that are off
    /// alike does not come near it, nor does one that swings go as fast as the shaft. No rhythm and no play is larger than a machine's.
    #[must_use]
    fn keeps_order(&self, model: &Model) -> bool {
        let shifts = |term: &&Term| {
            !term.nuisance && matches!(term.effect.site, Site::Disc(_) | Site::Level(_))
        };
        let [_, run_out] = Mechanism::Bearing.card().range("runout_rad");
        model.terms.iter().filter(shifts).all(|term| {
            let (most, amplitude) = match term.effect.carrier {
                Carrier::Order(_) | Carrier::Tone(_) => (LARGE, run_out),
                Carrier::Direction => (1.0, run_out),
                _ => (1.0, f64::INFINITY),
            };
            let size = term
                .sizes
                .iter()
                .fold(0.0, |sum: f64, size| sum.hypot(*size));
            let varies = term.effect.growth != Growth::Constant;
            let goes = |bench: &Bench| {
                let hz = match term.effect.carrier {
                    Carrier::Tone(hz) => hz,
                    Carrier::Chirp(hz, rate) => {
                        hz.abs().max((hz + rate * bench.record.seconds()).abs())
                    }
                    _ => 0.0,
                };
                TAU * hz * size < LARGE * bench.leaps.speed()
            };
            (varies || size <= amplitude)
                && self.benches.iter().all(goes)
                && self.benches.iter().all(|bench| {
                    let columns = bench.columns(&term.effect);
                    let off = |at: usize| {
                        let each = columns.iter().zip(&term.sizes);
                        each.map(|(column, size)| size * column[at]).sum::<f64>()
                    };
                    let record = &bench.record;
                    (1..record.len()).all(|at| {
                        let way = (record.grid_rad(at) - record.grid_rad(at - 1)).abs();
                        way == 0.0 || (off(at) - off(at - 1)).abs() < most * way
                    })
                })
        })
    }
}
