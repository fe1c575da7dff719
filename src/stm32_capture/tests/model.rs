//! Timer, input filter, DMA and pins as the manuals describe them, register by register. Time goes on at every access.

use std::collections::BTreeMap;
use std::vec::Vec;

use crate::capture::Channel;
use crate::capture::tests::shaft::{Edge, Random};
use crate::edge::Levels;
use crate::stm32_capture::{Register, Registers};

/// Words of each channel's memory.
pub const LATCHES: usize = 64;

/// Ticks of the synchroniser in front of the filter.
pub const SYNCHRONISER: u64 = 3;

const CHANNELS: [Channel; 3] = [Channel::A, Channel::B, Channel::Z];
const MEMORY: [u32; 3] = [0x2000_A000, 0x2000_B000, 0x2000_C000];

/// Addresses of one family, from its manual's memory map.
pub struct Map {
    pub pins: u32,
    /// Control, remaining words, peripheral and memory address of the DMA streams that A, B and Z may take.
    pub dma: [[u32; 4]; 3],
    /// Bits that a stream's control register must have while it runs, and the register and value that route its request.
    pub control: u32,
    pub routes: [Option<(u32, u32)>; 3],
    /// Enable bits of the clocks.
    pub clocks: &'static [(u32, u32)],
}

/// RM0090, memory map and "DMA1 request mapping".
pub const F405_MAP: Map = Map {
    pins: 0x4002_0010,
    dma: [
        [0x4002_6088, 0x4002_608C, 0x4002_6090, 0x4002_6094],
        [0x4002_60A0, 0x4002_60A4, 0x4002_60A8, 0x4002_60AC],
        [0x4002_6028, 0x4002_602C, 0x4002_6030, 0x4002_6034],
    ],
    control: 0x0603_5501,
    routes: [None; 3],
    clocks: &[(0x4002_3830, 0x0020_0001), (0x4002_3840, 1)],
};

/// RM0440, memory map and DMAMUX inputs.
pub const G4_MAP: Map = Map {
    pins: 0x4800_0010,
    dma: [
        [0x4002_0008, 0x4002_000C, 0x4002_0010, 0x4002_0014],
        [0x4002_001C, 0x4002_0020, 0x4002_0024, 0x4002_0028],
        [0x4002_0030, 0x4002_0034, 0x4002_0038, 0x4002_003C],
    ],
    control: 0x3AA1,
    routes: [
        Some((0x4002_0800, 56)),
        Some((0x4002_0804, 57)),
        Some((0x4002_0808, 58)),
    ],
    clocks: &[(0x4002_1048, 5), (0x4002_104C, 1), (0x4002_1058, 1)],
};

const CR1: u32 = 0x4000_0000;
const DIER: u32 = 0x4000_000C;
const SR: u32 = 0x4000_0010;
const EGR: u32 = 0x4000_0014;
const CCMR1: u32 = 0x4000_0018;
const CCMR2: u32 = 0x4000_001C;
const CCER: u32 = 0x4000_0020;
const CNT: u32 = 0x4000_0024;
const ARR: u32 = 0x4000_002C;
const CCR1: u32 = 0x4000_0034;

/// What the bus does.
#[derive(Clone, Copy)]
pub struct Bus {
    /// Ticks that one transfer takes at most, and one register access.
    pub transfer: u64,
    pub access: u64,
    /// Ticks from when a transfer is counted to when memory has it, at most.
    pub lag: u64,
    /// Ticks that an interrupt takes at most which comes before one access in eight.
    pub interrupt: u64,
}

pub const BUS: Bus = Bus {
    transfer: 6,
    access: 4,
    lag: 5,
    interrupt: 0,
};

pub struct Model {
    map: Map,
    random: Random,
    bus: Bus,
    pub now: u64,
    /// When the counter was 0.
    zero: u64,
    plain: BTreeMap<u32, u32>,
    status: u32,
    latches: [u32; 3],
    memory: [[u32; LATCHES]; 3],
    remaining: [u32; 3],
    /// Counted, not written yet: time, channel, word, value.
    writing: Vec<(u64, usize, usize, u32)>,
    /// When DMA serves the next request.
    serving: Option<(u64, usize)>,
    pending: [bool; 3],
    /// Time spans in which others have the bus.
    pub stalls: Vec<(u64, u64)>,
    pins: Vec<Edge>,
    pin_at: usize,
    captured: Vec<Edge>,
    captured_at: usize,
    /// Captures (by number) that the timer misses without a word.
    pub deaf_at: Vec<usize>,
    pub keeps_period: bool,
    pub dma_stops: bool,
    /// Status flags that come right after the next look at them.
    pub raised: u32,
    pub misuse: Vec<&'static str>,
}

impl Model {
    pub fn new(map: Map, seed: u64, bus: Bus) -> Self {
        Self {
            map,
            random: Random(seed),
            bus,
            now: 0,
            zero: 0,
            plain: BTreeMap::new(),
            status: 0,
            latches: [0; 3],
            memory: [[0; LATCHES]; 3],
            remaining: [0; 3],
            writing: Vec::new(),
            serving: None,
            pending: [false; 3],
            stalls: Vec::new(),
            pins: Vec::new(),
            pin_at: 0,
            captured: Vec::new(),
            captured_at: 0,
            deaf_at: Vec::new(),
            keeps_period: true,
            dma_stops: true,
            raised: 0,
            misuse: Vec::new(),
        }
    }

    /// Lays the edges at the pins, in order of time from now on, and works out which pass a filter of `ticks`; returns these at the time
    /// of their capture.
    pub fn turn(&mut self, edges: &[Edge], ticks: u32) -> Vec<Edge> {
        self.pins = edges.to_vec();
        self.pin_at = 0;
        let passes = |at: usize| {
            let edge = edges[at];
            let mut same = edges[at + 1..].iter().filter(|e| e.channel == edge.channel);
            same.next()
                .is_none_or(|next| next.ticks - edge.ticks >= u64::from(ticks))
        };
        let mut levels = [false; 3];
        let mut out = Vec::new();
        for (at, edge) in edges.iter().enumerate() {
            let level = edge.levels.0 & edge.channel.bit() != 0;
            // A pulse that is too short changes nothing, and its end is no change then.
            if passes(at) && levels[edge.channel as usize] != level {
                levels[edge.channel as usize] = level;
                let bits = levels.iter().enumerate();
                let bits = bits.fold(0, |bits, (bit, high)| bits | u8::from(*high) << bit);
                out.push(Edge {
                    ticks: edge.ticks + SYNCHRONISER + u64::from(ticks),
                    channel: edge.channel,
                    levels: Levels(bits),
                });
            }
        }
        self.captured.clone_from(&out);
        self.captured_at = 0;
        out
    }

    /// Time since the counter began.
    pub fn counted(&self) -> u64 {
        self.now - self.zero
    }

    fn register(&self, address: u32) -> u32 {
        self.plain.get(&address).copied().unwrap_or(0)
    }

    /// Whether DMA of a channel is set up as the manual asks for.
    fn routed(&self, at: usize) -> bool {
        let [control, _, from, to] = self.map.dma[at];
        self.register(control) == self.map.control
            && self.register(from) == CCR1 + 4 * at as u32
            && self.register(to) == MEMORY[at]
            && self.map.routes[at].is_none_or(|(route, value)| self.register(route) == value)
            && self.register(DIER) >> (9 + at) & 1 == 1
    }

    /// Whether a channel captures both edges of its own pin.
    fn captures(&self, at: usize) -> bool {
        let mode = [CCMR1, CCMR1, CCMR2][at];
        let selected = self.register(mode) >> [0, 8, 0][at] & 3;
        let port = self.map.pins - 0x10;
        let clocked = |&(address, bits)| self.register(address) & bits == bits;
        self.map.clocks.iter().all(clocked)
            && self.register(port) >> (2 * at) & 3 == 2
            && self.register(port + 0x20) >> (4 * at) & 15 == 1
            && self.register(CR1) & 1 == 1
            && selected == 1
            && self.register(CCER) >> (4 * at) & 15 == 0xB
    }

    fn after_stalls(&self, mut at: u64) -> u64 {
        for &(from, to) in &self.stalls {
            if (from..to).contains(&at) {
                at = to;
            }
        }
        at
    }

    fn serve_next(&mut self, from: u64) {
        if self.serving.is_none()
            && let Some(at) = self.pending.iter().position(|pending| *pending)
        {
            let end = from + self.random.within(1, self.bus.transfer + 1);
            self.serving = Some((self.after_stalls(end), at));
        }
    }

    fn capture(&mut self, edge: &Edge) {
        let at = edge.channel as usize;
        if !self.captures(at) || self.deaf_at.contains(&(self.captured_at - 1)) {
            return;
        }
        self.latches[at] = (edge.ticks - self.zero) as u32;
        let (flag, over) = (2 << at, 0x200 << at);
        if self.status & flag != 0 {
            self.status |= over;
        }
        self.status |= flag;
        if self.routed(at) {
            self.pending[at] = true;
            self.serve_next(edge.ticks);
        }
    }

    fn serve(&mut self, time: u64, at: usize) {
        self.serving = None;
        self.pending[at] = false;
        self.status &= !(2 << at);
        let word = LATCHES - self.remaining[at] as usize;
        self.remaining[at] -= 1;
        if self.remaining[at] == 0 {
            self.remaining[at] = LATCHES as u32;
        }
        let written = time + self.random.within(0, self.bus.lag + 1);
        self.writing.push((written, at, word, self.latches[at]));
        self.serve_next(time);
    }

    /// Lets time pass.
    pub fn advance(&mut self, to: u64) {
        loop {
            let capture = self.captured.get(self.captured_at).map(|edge| edge.ticks);
            let served = self.serving.map(|(time, _)| time);
            let next = [capture, served].into_iter().flatten().min();
            let Some(next) = next.filter(|next| *next <= to) else {
                break;
            };
            if served == Some(next) {
                let (_, at) = self.serving.unwrap();
                self.serve(next, at);
            } else {
                let edge = self.captured[self.captured_at];
                self.captured_at += 1;
                self.capture(&edge);
            }
        }
        let wraps = |time: u64| (time - self.zero) >> 32;
        if self.register(CR1) & 1 == 1 && wraps(to) != wraps(self.now) {
            self.status |= 1;
        }
        self.now = to;
        let memory = &mut self.memory;
        self.writing.retain(|&(time, at, word, value)| {
            if time <= to {
                memory[at][word] = value;
            }
            time > to
        });
    }

    fn pass(&mut self) {
        let mut ticks = self.random.within(1, self.bus.access + 1);
        if self.bus.interrupt > 0 && self.random.within(0, 8) == 0 {
            ticks += self.random.within(0, self.bus.interrupt);
        }
        self.advance(self.now + ticks);
    }
}

impl Registers for Model {
    const LATCHES: usize = LATCHES;

    fn read(&mut self, register: Register) -> u32 {
        self.pass();
        let address = register.address();
        if let Some(at) = (0..3).find(|at| self.map.dma[*at][1] == address) {
            return self.remaining[at];
        }
        match address {
            CNT => self.counted() as u32,
            SR => {
                let status = self.status;
                self.status |= std::mem::take(&mut self.raised);
                status
            }
            ARR if !self.keeps_period => 0xFFFF,
            _ if address == self.map.pins => {
                while self
                    .pins
                    .get(self.pin_at)
                    .is_some_and(|e| e.ticks <= self.now)
                {
                    self.pin_at += 1;
                }
                let last = self.pin_at.checked_sub(1);
                // The other pins of the port are high.
                !7 | last.map_or(0, |at| u32::from(self.pins[at].levels.0))
            }
            _ => self.register(address),
        }
    }

    fn write(&mut self, register: Register, value: u32) {
        self.pass();
        let address = register.address();
        if !address.is_multiple_of(4) {
            self.misuse.push("an address between registers");
        }
        if matches!(address, CCMR1 | CCMR2) && self.register(CCER) != 0 {
            self.misuse.push("an input chosen while its channel is on");
        }
        for (at, [control, remaining, from, to]) in self.map.dma.into_iter().enumerate() {
            let on = self.register(control) & 1 != 0;
            if on && [remaining, from, to].contains(&address) {
                self.misuse.push("a stream set up while it is on");
            }
            if address == remaining {
                self.remaining[at] = value;
            }
            if address == control && !self.dma_stops {
                self.plain.insert(address, value | 1);
                return;
            }
        }
        match address {
            SR => self.status &= value,
            EGR => self.status |= 1,
            CR1 if value & 1 != 0 => {
                if self.status & 1 != 0 {
                    self.misuse.push("a wrap told before the counter has begun");
                }
                self.zero = self.now;
                self.plain.insert(address, value);
            }
            _ => {
                self.plain.insert(address, value);
            }
        }
    }

    fn latched(&mut self, channel: Channel, index: usize) -> u32 {
        self.memory[channel as usize][index]
    }

    fn memory(&self, channel: Channel) -> u32 {
        MEMORY[CHANNELS.iter().position(|c| *c == channel).unwrap()]
    }
}
