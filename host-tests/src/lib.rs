//! Whole-behaviour tests of core and tool: shared helpers.
#![forbid(unsafe_code)]
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap
)]

pub mod accuracy;
pub mod anywhere;
pub mod bound;
pub mod paper;
pub mod peer_average;
pub mod peer_bladesight;
pub mod peer_polynomial;
pub mod reference;

pub mod events;
pub mod field;
pub mod field_trial;
pub mod firmware;
pub mod fuzz_device;
pub mod guard;
pub mod locate;
pub mod parallel;
pub mod power_cut;
pub mod real;
pub mod rig;
pub mod session;
pub mod slot_check;
pub mod speed_loop;
pub mod trial;
