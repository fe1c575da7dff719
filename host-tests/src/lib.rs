//! Whole-behaviour tests of core and tool: shared helpers.
#![forbid(unsafe_code)]
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap
)]

pub mod accuracy;
pub mod paper;
pub mod reference;

pub mod events;
pub mod firmware;
pub mod locate;
pub mod rig;
pub mod session;
