//! A simulated shaft that turns in real time, whether anyone looks or not, and writes what a capture timer sees of it.

use std::fs::File;
use std::io::{self, Write};
use std::iter::Peekable;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use quadcal::edge::Sample;
use quadcal::replay::{Event, Header, TimerWidth, Wiring};
use quadcal::units::Ticks;
use quadcal_host::sim::Simulation;
use quadcal_host::twin::{Twin, TwinError};

use super::timer::Timer;

/// Time between two looks at the clock.
const LOOK: Duration = Duration::from_millis(1);

/// Changes of level that are made up in one go at the most.
const BURST: usize = 20_000;

/// Bytes that a file keeps: seconds of edges, of which a reader is milliseconds behind.
const KEPT: u64 = 16 << 20;

/// Where edges go.
#[derive(Default)]
struct Wire {
    file: Option<File>,
    timer: Timer,
    /// Bytes written, and of those the ones given back to the disk.
    written: u64,
    freed: u64,
    failed: Option<io::Error>,
}

impl Wire {
    /// Writes what the timer saw of these changes of level, and then up to `now`.
    fn write(&mut self, due: &[Sample], now: Ticks) {
        let Some(file) = &mut self.file else { return };
        let mut bytes = Vec::new();
        let mut record = |event: Event| bytes.extend(event.emit());
        for sample in due {
            self.timer.capture(*sample, &mut record);
        }
        self.timer.pass(now, &mut record);
        match file.write_all(&bytes) {
            Ok(()) => self.written += bytes.len() as u64,
            Err(error) => self.failed = Some(error),
        }
        if self.written - self.freed > 2 * KEPT {
            let old = self.written - KEPT;
            free(file, self.freed, old - self.freed);
            self.freed = old;
        }
    }
}

/// Gives bytes of a file back to the disk, where the system can; the file stays as long as it is.
#[cfg(target_os = "linux")]
fn free(file: &File, from: u64, bytes: u64) {
    use rustix::fs::{FallocateFlags, fallocate};
    let hole = FallocateFlags::PUNCH_HOLE | FallocateFlags::KEEP_SIZE;
    let _ = fallocate(file, hole, from, bytes);
}

#[cfg(not(target_os = "linux"))]
fn free(_: &File, _: u64, _: u64) {}

/// The shaft, which stops when this is dropped.
pub struct Shaft {
    head: Header,
    wire: Arc<Mutex<Wire>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Shaft {
    /// Starts to turn, with a quadrature encoder of `lines` lines at a timer of `clock_hz`, as the twin has.
    ///
    /// # Errors
    /// [`TwinError`] for a twin that can't be simulated.
    pub fn start(twin: &Twin, lines: u32, clock_hz: u32) -> Result<Self, TwinError> {
        let edges = Simulation::new(twin)?.peekable();
        let wire = Arc::new(Mutex::new(Wire::default()));
        let stop = Arc::new(AtomicBool::new(false));
        let thread = thread::spawn({
            let (wire, stop) = (Arc::clone(&wire), Arc::clone(&stop));
            move || turn(edges, clock_hz, &wire, &stop)
        });
        Ok(Self {
            head: Header {
                timer: TimerWidth::Bits16,
                wiring: Wiring::Quadrature,
                lines,
                clock_hz,
                turns: 0,
            },
            wire,
            stop,
            thread: Some(thread),
        })
    }

    /// Edges go to a new file from now on, with a timer that has just started.
    ///
    /// # Errors
    /// The system's, for this file or the one before.
    pub fn write_to(&self, path: &Path) -> io::Result<()> {
        let mut file = File::create(path)?;
        file.write_all(&self.head.emit())?;
        let before = std::mem::replace(
            &mut *lock(&self.wire),
            Wire {
                file: Some(file),
                ..Wire::default()
            },
        );
        before.failed.map_or(Ok(()), Err)
    }
}

impl Drop for Shaft {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn lock(wire: &Mutex<Wire>) -> MutexGuard<'_, Wire> {
    wire.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Turns until it is to stop or the edges end.
fn turn(mut edges: Peekable<Simulation>, clock_hz: u32, wire: &Mutex<Wire>, stop: &AtomicBool) {
    let begin = Instant::now();
    let mut due = Vec::new();
    while !stop.load(Ordering::Relaxed) {
        let ticks = begin.elapsed().as_nanos() * u128::from(clock_hz) / 1_000_000_000;
        let mut now = Ticks::try_from(ticks).unwrap_or(Ticks::MAX);
        while due.len() < BURST
            && let Some(event) = edges.next_if(|event| event.row.ticks <= now)
        {
            due.push(event.row);
        }
        let Some(next) = edges.peek() else { return };
        // Where the computer is too slow, time goes on as far as there are edges.
        let late = next.row.ticks <= now;
        now = now.min(next.row.ticks.saturating_sub(1));
        lock(wire).write(&due, now);
        due.clear();
        if !late {
            thread::sleep(LOOK);
        }
    }
}
