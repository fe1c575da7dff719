//! A state machine: it executes the words that were written to its memory, a cycle at a time.

use std::collections::VecDeque;

/// A state machine, for the instructions that move, shift, queue and jump.
#[derive(Default)]
pub struct Machine {
    pub on: bool,
    at: u32,
    pub delay: u32,
    pub x: u32,
    y: u32,
    pub isr: u32,
    osr: u32,
    pub control: u32,
    pub shift: u32,
    pub mapping: u32,
    pub into: VecDeque<u32>,
    pub out: VecDeque<u32>,
}

impl Machine {
    fn room(&self) -> usize {
        if self.shift >> 31 != 0 { 8 } else { 4 }
    }

    fn source(&self, code: u32, pins: u32) -> u32 {
        match code {
            0 => pins.rotate_right(self.mapping >> 15 & 31),
            1 => self.x,
            2 => self.y,
            3 => 0,
            5 => {
                assert_eq!(self.control >> 4 & 7, 0, "status is that of the queue in");
                let few = (self.into.len() as u32) < (self.control & 15);
                if few { u32::MAX } else { 0 }
            }
            6 => self.isr,
            7 => self.osr,
            _ => panic!("no source {code}"),
        }
    }

    fn destination(&mut self, code: u32) -> &mut u32 {
        match code {
            1 => &mut self.x,
            2 => &mut self.y,
            6 => &mut self.isr,
            7 => &mut self.osr,
            _ => panic!("no destination {code}"),
        }
    }

    /// Executes an instruction. Returns whether the queue had no room.
    pub fn execute(&mut self, word: u32, pins: u32, memory_at: Option<u32>) -> bool {
        let (field, low) = (word >> 5 & 7, word & 31);
        let ones = |bits: u32| u32::MAX >> (32 - bits);
        let mut jump = None;
        let mut stalled = false;
        match word >> 13 {
            0 => {
                let taken = match field {
                    0 => true,
                    2 => {
                        self.x = self.x.wrapping_sub(1);
                        self.x != u32::MAX
                    }
                    3 => self.y == 0,
                    5 => self.x != self.y,
                    _ => panic!("no condition {field}"),
                };
                jump = taken.then_some(low);
            }
            2 => {
                assert_eq!(self.shift >> 18 & 1, 0, "in, to the left");
                self.isr = self.isr << low | (self.source(field, pins) & ones(low));
            }
            3 => {
                assert_eq!(self.shift >> 19 & 1, 1, "out, to the right");
                *self.destination(field) = self.osr & ones(low);
                self.osr >>= low;
            }
            4 if field & 4 == 0 => {
                assert_eq!(field, 0, "push does not block");
                if self.out.len() < self.room() {
                    self.out.push_back(self.isr);
                } else {
                    stalled = true;
                }
                self.isr = 0;
            }
            4 => {
                assert_eq!(field, 4, "pull does not block");
                self.osr = self.into.pop_front().unwrap_or(self.x);
            }
            5 => {
                let value = self.source(low & 7, pins);
                *self.destination(field) = match low >> 3 {
                    0 => value,
                    1 => !value,
                    _ => panic!("no reversal"),
                };
            }
            _ => panic!("no instruction {word:04X}"),
        }
        self.delay = word >> 8 & 31;
        if let Some(at) = memory_at {
            let end = at == self.control >> 12 & 31;
            self.at = if end { self.control >> 7 & 31 } else { at + 1 };
        }
        self.at = jump.unwrap_or(self.at);
        stalled
    }

    /// Lets a cycle pass. Returns whether the queue had no room.
    pub fn cycle(&mut self, words: &[u32; 32], pins: u32) -> bool {
        if !self.on {
            return false;
        }
        if self.delay > 0 {
            self.delay -= 1;
            return false;
        }
        self.execute(words[self.at as usize], pins, Some(self.at))
    }
}
