//! Real recordings, diagnosed: what `quadcal diagnose` finds on a twin that knows little, held against what is known from elsewhere.

pub mod command;
pub mod flywheel;
pub mod fold;
pub mod hall;
pub mod line;
pub mod run_down;
pub mod table;
