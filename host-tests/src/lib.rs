//! Whole-behaviour tests of core and tool: shared helpers.
#![forbid(unsafe_code)]

pub mod events;
pub mod firmware;
