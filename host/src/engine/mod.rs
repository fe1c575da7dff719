//! The diagnosis engine.

pub mod edges;
