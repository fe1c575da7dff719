//! Machines, queues, DMA and pins on their bus as the data sheets describe them; time goes on at every access.

mod machine;
mod map;

use std::collections::BTreeMap;
use std::vec::Vec;

pub use map::{Map, RP2040_MAP, RP2350_MAP};

use machine::Machine;

use crate::capture::tests::shaft::{Edge, Random};
use crate::pio_capture::{Register, Registers};

pub const WORDS: usize = 64;

const MEMORY: u32 = 0x2000_1000;

/// Cycles of the synchroniser at each pin.
pub const SYNCHRONISER: u64 = 2;

const PIO: u32 = 0x5020_0000;
const DMA: u32 = 0x5000_0000;

/// What the bus does.
#[derive(Clone, Copy)]
pub struct Bus {
    /// Cycles that one transfer takes at most, and one register access.
    pub transfer: u64,
    pub access: u64,
    /// Cycles from when a transfer is counted to when memory has it, at most.
    pub lag: u64,
    /// Cycles that an interrupt takes at most which comes before one access in eight.
    pub interrupt: u64,
}

pub const BUS: Bus = Bus {
    transfer: 8,
    access: 4,
    lag: 5,
    interrupt: 0,
};

/// A channel of DMA.
#[derive(Default)]
struct Channel {
    from: u32,
    to: u32,
    reload: u32,
    left: u32,
    control: u32,
}

pub struct Model {
    map: Map,
    random: Random,
    bus: Bus,
    first_pin: u32,
    /// Cycles.
    pub now: u64,
    /// When the machines began.
    pub zero: u64,
    plain: BTreeMap<u32, u32>,
    words: [u32; 32],
    pub machines: [Machine; 2],
    no_room: bool,
    channels: [Channel; 2],
    /// When DMA may transfer again.
    free: u64,
    memory: [u32; WORDS],
    /// Counted, not written yet: time, word, value.
    writing: Vec<(u64, usize, u32)>,
    /// Spans in which others have the bus, cycles.
    pub stalls: Vec<(u64, u64)>,
    /// The word (by number) that does not reach memory, and how many have been transferred.
    pub dropped: Option<usize>,
    transferred: usize,
    edges: Vec<Edge>,
    edge_at: usize,
    /// Where DMA sees the memory.
    pub memory_at: u32,
    /// Whether blocks come out of reset, and DMA stops.
    pub comes_out: bool,
    pub dma_stops: bool,
    pub misuse: Vec<&'static str>,
}

impl Model {
    pub fn new(map: Map, seed: u64, bus: Bus, first_pin: u32) -> Self {
        // As a reset leaves them, with a machine of another program at work.
        let plain = BTreeMap::from([(map.resets, u32::MAX), (PIO, 0b1000)]);
        Self {
            map,
            random: Random(seed),
            bus,
            first_pin,
            now: 0,
            zero: 0,
            plain,
            words: [u32::MAX; 32],
            machines: Default::default(),
            no_room: false,
            channels: Default::default(),
            free: 0,
            memory: [0; WORDS],
            writing: Vec::new(),
            stalls: Vec::new(),
            dropped: None,
            transferred: 0,
            edges: Vec::new(),
            edge_at: 0,
            memory_at: MEMORY,
            comes_out: true,
            dma_stops: true,
            misuse: Vec::new(),
        }
    }

    /// Lays edges at the pins, at their times in cycles.
    pub fn turn(&mut self, edges: &[Edge]) {
        self.edges.extend_from_slice(edges);
    }

    /// The count that a machine has now.
    pub fn counted(&self) -> u64 {
        (self.now - self.zero) / 6
    }

    /// Lets so many ticks pass at a standstill, in no time: registers are as they would be.
    pub fn skip(&mut self, ticks: u32) {
        assert!(self.machines.iter().all(|machine| machine.into.is_empty()));
        let [captures, tells] = &mut self.machines;
        for register in [&mut captures.isr, &mut captures.x, &mut tells.x] {
            // Levels stay what they are; X of the first one has a count for a part of the loop only.
            if *register > 7 {
                *register = register.wrapping_sub(ticks);
            }
        }
        self.now += 6 * u64::from(ticks);
        self.free = self.free.max(self.now);
    }

    fn plain(&self, address: u32) -> u32 {
        self.plain.get(&address).copied().unwrap_or_default()
    }

    /// The levels that machines see; the other pins are high.
    fn pins(&mut self) -> u32 {
        while self
            .edges
            .get(self.edge_at)
            .is_some_and(|edge| edge.ticks + SYNCHRONISER <= self.now)
        {
            self.edge_at += 1;
        }
        let last = self.edge_at.checked_sub(1);
        let levels = last.map_or(0, |at| u32::from(self.edges[at].levels.0));
        let (set, clear) = self.map.pad;
        let pads = (0..3).all(|pin| {
            let pad = self.plain(self.map.pads + 4 * (self.first_pin + pin));
            pad & set == set && pad & clear == 0
        });
        if pads {
            !(7 << self.first_pin) | levels << self.first_pin
        } else {
            u32::MAX
        }
    }

    fn transfer(&mut self) {
        let now = self.now;
        let stalled = self
            .stalls
            .iter()
            .any(|&(from, to)| (from..to).contains(&now));
        let Some(at) = (0..2).find(|at| self.channels[*at].left > 0) else {
            return;
        };
        let set_up = self.channels[at].control == self.map.control[at]
            && self.channels[at].from == PIO + 0x20;
        if stalled || now < self.free || !set_up {
            return;
        }
        let Some(word) = self.machines[0].out.pop_front() else {
            return;
        };
        self.transferred += 1;
        if self.dropped == Some(self.transferred - 1) {
            return;
        }
        let channel = &mut self.channels[at];
        let index = (channel.to - self.memory_at) / 4;
        channel.to = self.memory_at + (index + 1) % WORDS as u32 * 4;
        channel.left -= 1;
        if channel.left == 0 {
            let next = &mut self.channels[1 - at];
            if next.control & 1 != 0 {
                next.left = next.reload;
            }
        }
        let written = now + self.random.within(0, self.bus.lag + 1);
        self.writing.push((written, index as usize, word));
        self.free = now + self.random.within(1, self.bus.transfer + 1);
    }

    /// Lets time pass.
    pub fn advance(&mut self, to: u64) {
        while self.now < to {
            let pins = self.pins();
            let [captures, tells] = &mut self.machines;
            self.no_room |= captures.cycle(&self.words, pins);
            if tells.cycle(&self.words, pins) {
                self.misuse.push("an answer that nobody took");
            }
            self.transfer();
            let (now, memory) = (self.now, &mut self.memory);
            self.writing.retain(|&(time, index, word)| {
                if time <= now {
                    memory[index] = word;
                }
                time > now
            });
            self.now += 1;
        }
    }

    fn pass(&mut self) {
        let mut cycles = self.random.within(1, self.bus.access + 1);
        if self.bus.interrupt > 0 && self.random.within(0, 8) == 0 {
            cycles += self.random.within(0, self.bus.interrupt);
        }
        self.advance(self.now + cycles);
    }

    fn in_reset(&self) -> bool {
        self.plain(self.map.resets) & self.map.blocks != 0
    }

    fn write_pio(&mut self, offset: u32, value: u32) {
        let running = self.machines.iter().any(|machine| machine.on);
        match offset {
            0 => {
                if value & 0b1000 == 0 {
                    self.misuse.push("another's machine stopped");
                }
                for (bit, machine) in self.machines.iter_mut().enumerate() {
                    if value >> 4 >> bit & 1 != 0 {
                        machine.isr = 0;
                        machine.delay = 0;
                    }
                    if value >> bit & 1 != 0 && !machine.on {
                        self.zero = self.now;
                    }
                    machine.on = value >> bit & 1 != 0;
                }
                self.plain.insert(PIO, value & 15);
            }
            0x08 => self.no_room &= value & 1 == 0,
            0x14 => {
                if self.machines[1].into.len() < 4 {
                    self.machines[1].into.push_back(value);
                }
            }
            0x48..0xC8 if running => self.misuse.push("a program changed while it runs"),
            0x48..0xC8 => self.words[(offset as usize - 0x48) / 4] = value,
            0xC8..0xF8 if running => self.misuse.push("a machine set up while it runs"),
            0xC8..0xF8 => {
                let pins = self.pins();
                let machine = &mut self.machines[(offset as usize - 0xC8) / 0x18];
                match (offset - 0xC8) % 0x18 {
                    0 => assert_eq!(value, 0x1_0000, "the whole clock"),
                    0x04 => machine.control = value,
                    0x08 => {
                        if (value ^ machine.shift) >> 30 != 0 {
                            machine.into.clear();
                            machine.out.clear();
                        }
                        assert_eq!(value >> 16 & 3, 0, "nothing by itself");
                        machine.shift = value;
                    }
                    0x10 => {
                        machine.execute(value, pins, None);
                    }
                    0x14 => machine.mapping = value,
                    _ => self.misuse.push("a register that is only read"),
                }
            }
            _ => self.misuse.push("a register that is not the driver's"),
        }
    }

    fn write_dma(&mut self, offset: u32, value: u32) {
        if self.map.abort == DMA + offset {
            for channel in &mut self.channels {
                channel.left = 0;
            }
            return;
        }
        let channel = &mut self.channels[offset as usize / 0x40];
        match offset % 0x40 {
            0 => channel.from = value,
            0x04 => channel.to = value,
            0x08 => channel.reload = value,
            0x0C => {
                channel.control = value;
                channel.left = channel.reload;
            }
            0x10 => channel.control = value,
            _ => self
                .misuse
                .push("a register of DMA that is not the driver's"),
        }
    }
}

impl Registers for Model {
    const WORDS: usize = WORDS;

    fn read(&mut self, register: Register) -> u32 {
        self.pass();
        let address = register.address();
        let [captures, tells] = &mut self.machines;
        match address {
            _ if address == self.map.resets + 8 => {
                if self.comes_out {
                    !self.plain(self.map.resets)
                } else {
                    0
                }
            }
            _ if address == self.map.abort => u32::from(!self.dma_stops),
            0xD000_0004 => self.pins(),
            0x5020_0004 => {
                u32::from(captures.out.is_empty()) << 8 | u32::from(tells.out.is_empty()) << 9
            }
            0x5020_0008 => u32::from(self.no_room),
            0x5020_0024 => tells.out.pop_front().unwrap_or_default(),
            0x5000_0004 => self.channels[0].to,
            0x5000_0044 => self.channels[1].to,
            _ => self.plain(address),
        }
    }

    fn write(&mut self, register: Register, value: u32) {
        self.pass();
        let address = register.address();
        if !address.is_multiple_of(4) {
            self.misuse.push("an address between registers");
        }
        if self.in_reset() && address != self.map.resets {
            self.misuse.push("a block in reset");
        }
        match address {
            PIO..0x5020_1000 => self.write_pio(address - PIO, value),
            DMA..0x5000_1000 => self.write_dma(address - DMA, value),
            _ => {
                self.plain.insert(address, value);
            }
        }
    }

    fn word(&mut self, index: usize) -> u32 {
        self.memory[index]
    }

    fn memory(&self) -> u32 {
        self.memory_at
    }
}
