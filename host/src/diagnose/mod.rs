//! The diagnosis as one engine: edges to course to map to search to judge.
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)]

pub(crate) mod agreement;
pub(crate) mod align;
mod alike;
pub(crate) mod bench;
pub(crate) mod cells;
mod columns;
mod corners;
pub(crate) mod correct;
pub(crate) mod course;
pub(crate) mod declared;
pub mod diagnosis;
pub(crate) mod disc;
pub mod edges;
pub(crate) mod effect;
pub(crate) mod events;
pub(crate) mod filter;
pub(crate) mod findings;
mod headline;
mod held_up;
pub(crate) mod identify;
pub(crate) mod judge;
mod jury;
pub(crate) mod lsq;
pub(crate) mod map;
pub(crate) mod mean_turn;
pub(crate) mod model;
pub(crate) mod name;
mod nearby;
pub(crate) mod noise;
pub(crate) mod numbers;
pub(crate) mod pattern;
pub(crate) mod phases;
pub mod pipeline;
pub(crate) mod plant;
mod possible;
pub(crate) mod record;
pub mod rig;
mod said;
pub(crate) mod scan;
pub(crate) mod search;
mod speed_loop;
pub mod spread;
mod square;
pub(crate) mod stamps;
mod stiffness;
mod sweep;
mod task;
#[cfg(test)]
mod tests;
pub mod write;
