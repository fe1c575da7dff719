//! The flash interface as RM0090 describes it: keys, busy flag, error flags, bits that only fall, a cache that goes stale.

use std::collections::BTreeMap;
use std::vec::Vec;

use super::super::interface::{access, control, key, status};
use super::super::*;

/// What goes wrong in an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// It is not done, and these flags are set.
    Flags(u32),
    /// It is done, but the busy flag stays for this many looks.
    Slow(u32),
    /// It is done in part: some bits stay as they were.
    Weak,
    /// The power fails in the midst: some bits stay as they were, and nothing is done any more.
    PowerFails,
}

/// How far the controller is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lock {
    Shut,
    FirstKey,
    Open,
    /// Until reset.
    Dead,
}

#[derive(Clone)]
pub struct Model {
    pub memory: Vec<u8>,
    pub acr: u32,
    pub sr: u32,
    cr: u32,
    lock: Lock,
    /// Looks at the status for which the controller stays busy, and after every operation.
    busy: u32,
    pub busy_for: u32,
    /// Largest `PSIZE` that the supply allows.
    pub psize_max: u32,
    /// Write-protected sectors, a bit each.
    pub protected: u32,
    /// Operation in which something goes wrong.
    pub fault: Option<(u32, Fault)>,
    pub operations: u32,
    pub off: bool,
    /// Whether the control register keeps what it is told.
    pub deaf: bool,
    /// What must never be done.
    pub misuse: Vec<&'static str>,
    cache: BTreeMap<u32, [u8; 16]>,
    pub log: Vec<(Register, u32)>,
}

impl Model {
    pub fn new() -> Self {
        Self {
            memory: std::vec![0xFF; CAPACITY as usize],
            acr: access::DCEN | access::ICEN | 5,
            sr: 0,
            cr: control::LOCK,
            lock: Lock::Shut,
            busy: 0,
            busy_for: 1,
            psize_max: 2,
            protected: 0,
            fault: None,
            operations: 0,
            off: false,
            deaf: false,
            misuse: Vec::new(),
            cache: BTreeMap::new(),
            log: Vec::new(),
        }
    }

    /// Power or reset: the memory alone stays.
    pub fn restart(&mut self) {
        *self = Self {
            memory: std::mem::take(&mut self.memory),
            operations: self.operations,
            psize_max: self.psize_max,
            ..Self::new()
        };
    }

    pub fn locked(&self) -> bool {
        self.cr & control::LOCK != 0
    }

    fn wrong(&mut self, what: &'static str) {
        self.misuse.push(what);
    }

    fn key(&mut self, value: u32) {
        self.lock = match (self.lock, value) {
            (Lock::Shut, key::FIRST) => Lock::FirstKey,
            (Lock::FirstKey, key::SECOND) => Lock::Open,
            _ => {
                self.wrong("bus error: key");
                Lock::Dead
            }
        };
        if self.lock == Lock::Open {
            self.cr &= !control::LOCK;
        } else {
            self.cr |= control::LOCK;
        }
    }

    fn control(&mut self, value: u32) {
        if self.busy > 0 {
            self.wrong("bus stalls: control register written while busy");
        } else if self.lock == Lock::Open && !self.deaf {
            self.cr = value & !control::STRT;
            if value & control::LOCK != 0 {
                self.cr = control::LOCK;
                self.lock = Lock::Shut;
            } else if value & control::STRT != 0 {
                self.start();
            }
        }
    }

    fn start(&mut self) {
        let sector = (self.cr >> control::SNB_AT) & 15;
        if self.cr & (control::SER | control::PG) != control::SER || sector >= SECTORS {
            self.wrong("an erasure of nothing or of everything");
        }
        let range = sector_start(sector)..sector_start(sector + 1);
        self.operate(range.start, |model, keep| {
            for at in range {
                model.memory[at as usize] |= !keep(at);
            }
        });
    }

    /// Does an operation in a sector; `work` is told which bits of a byte stay as they are.
    fn operate(&mut self, at: u32, work: impl FnOnce(&mut Self, &dyn Fn(u32) -> u8)) {
        if (self.cr >> control::PSIZE_AT) & 3 > self.psize_max {
            self.wrong("parallelism beyond the supply");
        }
        let fault = self.fault.filter(|fault| fault.0 == self.operations);
        self.operations += 1;
        if self.protected & (1 << sector_at(at)) != 0 {
            self.sr |= status::WRPERR;
            return;
        }
        self.busy = self.busy_for;
        let some = |at: u32| (at.wrapping_mul(0x9E37_79B9) >> 13) as u8;
        match fault.map(|fault| fault.1) {
            None => work(self, &|_| 0),
            Some(Fault::Flags(flags)) => {
                self.sr |= flags;
                self.busy = 0;
            }
            Some(Fault::Slow(looks)) => {
                work(self, &|_| 0);
                self.busy = looks;
            }
            Some(Fault::Weak) => work(self, &some),
            Some(Fault::PowerFails) => {
                work(self, &some);
                self.off = true;
            }
        }
    }
}

impl Interface for Model {
    fn read(&mut self, register: Register) -> u32 {
        match register {
            Register::Access => self.acr,
            Register::Key => 0,
            Register::Status if self.off => status::OPERR,
            Register::Status => {
                let busy = if self.busy > 0 { status::BSY } else { 0 };
                self.busy = self.busy.saturating_sub(1);
                self.sr | busy
            }
            Register::Control => self.cr,
        }
    }

    fn write(&mut self, register: Register, value: u32) {
        self.log.push((register, value));
        if self.off {
            return;
        }
        match register {
            Register::Access => {
                let resets = access::DCRST | access::ICRST;
                if value & resets != 0 && self.acr & (access::DCEN | access::ICEN) != 0 {
                    self.wrong("a cache flushed while on");
                } else if value & access::DCRST != 0 {
                    self.cache.clear();
                }
                self.acr = value;
            }
            Register::Key => self.key(value),
            // Flags are cleared by writing ones.
            Register::Status => self.sr &= !value,
            Register::Control => self.control(value),
        }
    }

    fn program(&mut self, offset: u32, unit: Unit) {
        if self.off {
            return;
        }
        if self.busy > 0 {
            self.wrong("bus stalls: memory written while busy");
        }
        let (size, value) = match unit {
            Unit::Byte(value) => (0, value.to_le_bytes().to_vec()),
            Unit::Half(value) => (1, value.to_le_bytes().to_vec()),
            Unit::Word(value) => (2, value.to_le_bytes().to_vec()),
        };
        if self.cr & control::PG == 0 {
            self.sr |= status::PGSERR;
        } else if (self.cr >> control::PSIZE_AT) & 3 != size {
            self.sr |= status::PGPERR;
        } else if offset % 16 + value.len() as u32 > 16 {
            self.sr |= status::PGAERR;
        } else {
            self.operate(offset, |model, keep| {
                for (at, byte) in (offset..).zip(&value) {
                    model.memory[at as usize] &= byte | keep(at);
                    // A write changes the cached copy too.
                    if let Some(line) = model.cache.get_mut(&(at / 16)) {
                        line[at as usize % 16] = model.memory[at as usize];
                    }
                }
            });
        }
    }

    fn load(&mut self, offset: u32, bytes: &mut [u8]) {
        if self.busy > 0 {
            self.wrong("bus stalls: memory read while busy");
        }
        for (at, byte) in (offset..).zip(bytes) {
            *byte = self.memory[at as usize];
            if self.acr & access::DCEN != 0 {
                let start = at as usize / 16 * 16;
                let line = *self.memory[start..].first_chunk().unwrap();
                *byte = self.cache.entry(at / 16).or_insert(line)[at as usize % 16];
            }
        }
    }
}
