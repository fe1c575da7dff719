//! The diagnosis as one engine: edges to course to map to search to judge.
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)]

pub mod agreement;
pub mod align;
mod alike;
pub mod bench;
pub mod cells;
mod columns;
mod corners;
pub mod correct;
pub mod course;
pub mod declared;
pub mod diagnosis;
pub mod disc;
pub mod edges;
pub mod effect;
pub mod events;
pub mod filter;
mod findings;
mod held_up;
pub mod identify;
pub mod judge;
mod jury;
pub mod lsq;
pub mod map;
pub mod mean_turn;
pub mod model;
pub mod name;
mod nearby;
pub mod noise;
pub mod numbers;
pub mod pattern;
pub mod pipeline;
pub mod plant;
mod possible;
pub mod record;
pub mod rig;
mod said;
pub mod scan;
pub mod search;
mod speed_loop;
pub mod spread;
mod square;
pub mod stamps;
mod stiffness;
mod sweep;
mod task;
#[cfg(test)]
mod tests;
pub mod write;
