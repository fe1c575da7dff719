//! Replays an event file in QEMU for an encoder of 2500 lines: 10,000 edges a turn, the largest table of the design.
#![no_std]
#![no_main]

#[path = "../qemu/mod.rs"]
mod qemu;
#[path = "../qemu/replay.rs"]
#[macro_use]
mod replay;

replay_image!(2500);
