//! Where a recording and its twin differ, and why.
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)]

pub mod basis;
pub mod board;
pub mod diagnosis;
pub mod hypothesis;
pub mod kalman;
pub mod locate;
pub mod motion;
pub mod noise_fit;
pub mod prepare;
pub mod propose;
pub mod run;
pub mod search;
pub mod seen;
pub mod shaft;
pub mod shown;
pub mod spectrum;
pub mod still;
pub mod track;
mod turning;
