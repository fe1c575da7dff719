//! The blind trial: cases drawn by `quadcal-blind`, `quadcal diagnose` run on each with the open folder alone, its answers scored
//! against the sealed truth.

pub mod cases;
pub mod cell;
pub mod families;
pub mod field;
pub mod figures;
pub mod interval;
pub mod luck;
pub mod matrix;
pub mod run;
pub mod score;
pub mod shown;
pub mod speed;
#[cfg(test)]
mod tests;
pub mod truth;
pub mod under_trial;
