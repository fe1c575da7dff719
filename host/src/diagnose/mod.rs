//! Where a recording and its twin differ, and why.
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)]

pub mod alone;
pub mod basis;
pub mod bench;
pub mod beside;
mod best;
pub mod board;
pub mod classes;
pub mod code;
pub mod column;
pub mod conclude;
pub mod crowd;
mod delays;
pub mod diagnosis;
pub mod disc;
mod disc_parts;
mod disc_shown;
pub mod ends;
pub mod estimate;
pub mod events;
mod every_turn;
pub mod explore;
mod faded;
mod follow;
mod goes;
mod held_up;
pub mod hold;
pub mod hypothesis;
pub mod index;
pub mod instants;
pub mod joined;
pub mod judge;
pub mod kalman;
mod known;
pub mod least_squares;
pub mod leftover;
pub mod locate;
mod looped;
mod mark_plot;
pub mod mend;
pub mod mended;
mod mender;
pub mod motion;
pub mod moved;
pub mod named;
pub mod next;
pub mod noise;
pub mod noise_fit;
pub mod one_channel;
mod pace;
mod pairs;
pub mod place;
pub mod play;
pub mod plots;
pub mod prepare;
pub mod propose;
pub mod pushed;
pub mod refine;
mod repair;
pub mod repeats;
pub mod response;
mod rests;
pub mod rivals;
pub mod run;
mod run_out;
pub mod scan;
pub mod search;
pub mod seen;
pub mod settle;
mod settling;
pub mod shaft;
pub mod shown;
mod sift;
mod slow;
pub mod spectrum;
pub mod spread;
pub mod start;
pub mod steady;
pub mod still;
mod swing;
pub mod tell;
mod ties;
mod told_disc;
pub mod torques;
pub mod track;
pub mod turning;
pub mod verdict;
mod walk;
pub mod weigh;
mod widths;

#[cfg(test)]
mod tests;
