//! Replays an event file in QEMU for an encoder of 360 lines: 1440 edges a turn.
#![no_std]
#![no_main]

#[path = "../qemu/mod.rs"]
mod qemu;
#[path = "../qemu/replay.rs"]
#[macro_use]
mod replay;

replay_image!(360);
