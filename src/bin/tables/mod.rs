//! The body of the images that keep tables in flash: what counts, and one commit more.

mod derive;

use core::fmt;

use cortex_m_semihosting::hprintln;
use embedded_storage::nor_flash::NorFlash;
use quadcal::shape::ShapeError;
use quadcal::slot;
use quadcal::store::{Found, Layout, LayoutError, Place, Store, StoreError};

pub use derive::EDGES;

/// Why tables can't be kept. `F` is the flash's own error.
pub enum Failure<F> {
    Layout(LayoutError),
    Store(StoreError<F>),
    Shape(ShapeError),
    /// A table counts that is not the one of its sequence number.
    WrongTable {
        sequence: u32,
    },
}

impl<F> From<StoreError<F>> for Failure<F> {
    fn from(error: StoreError<F>) -> Self {
        Self::Store(error)
    }
}

impl<F: fmt::Debug> fmt::Display for Failure<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Layout(error) => write!(f, "{error:?}"),
            Self::Store(error) => write!(f, "{error:?}"),
            Self::Shape(error) => write!(f, "{error:?}"),
            Self::WrongTable { sequence } => {
                write!(
                    f,
                    "the table of sequence {sequence} is not what was written"
                )
            }
        }
    }
}

/// Tables in a flash with the STM32F405's sectors.
pub struct Tables<'a, F> {
    flash: F,
    layout: Layout,
    entries: &'a mut [i16; EDGES],
}

impl<'a, F: NorFlash> Tables<'a, F> {
    /// Tables in `flash`, with memory for one.
    pub fn new(flash: F, entries: &'a mut [i16; EDGES]) -> Result<Self, Failure<F::Error>> {
        let layout = quadcal::stm32f405::layout(&flash).map_err(Failure::Layout)?;
        Ok(Self {
            flash,
            layout,
            entries,
        })
    }

    /// The store itself.
    pub const fn store(&mut self) -> Store<&mut F> {
        Store::new(&mut self.flash, self.layout)
    }

    /// Says which table counts, after comparing every byte of it with what its sequence number says.
    pub fn report(&mut self) -> Result<(), Failure<F::Error>> {
        let found = self.store().newest()?;
        let wear = [self.store().wear(Place::A)?, self.store().wear(Place::B)?];
        match found {
            None => hprintln!("counts none wear_a={} wear_b={}", wear[0], wear[1]),
            Some(found) => {
                self.verify(&found)?;
                hprintln!(
                    "counts place={:?} sequence={} wear_a={} wear_b={}",
                    found.place,
                    found.header.stamp.sequence,
                    wear[0],
                    wear[1]
                );
            }
        }
        Ok(())
    }

    /// Commits the table of the next sequence number, and says so once it was read back.
    pub fn commit(&mut self) -> Result<(), Failure<F::Error>> {
        let newest = self.store().newest()?;
        let sequence = newest.map_or(0, |found| found.header.stamp.sequence.wrapping_add(1));
        let header = derive::header(sequence).map_err(Failure::Shape)?;
        self.fill(sequence);
        let found = Store::new(&mut self.flash, self.layout).commit(&header, self.entries)?;
        self.verify(&found)?;
        hprintln!("committed place={:?} sequence={}", found.place, sequence);
        Ok(())
    }

    fn fill(&mut self, sequence: u32) {
        for (edge, entry) in (0..).zip(self.entries.iter_mut()) {
            *entry = derive::entry(sequence, edge);
        }
    }

    fn verify(&mut self, found: &Found) -> Result<(), Failure<F::Error>> {
        let sequence = found.header.stamp.sequence;
        let header = derive::header(sequence).map_err(Failure::Shape)?;
        self.fill(sequence);
        let mut at = found.offset;
        slot::write(&header, self.entries, |bytes| {
            // Pieces are a header or a few words, and never longer.
            let mut there = [0; slot::HEADER_BYTES];
            let there = there.get_mut(..bytes.len()).unwrap_or_default();
            let read = self.flash.read(at, there);
            read.map_err(|error| Failure::Store(StoreError::Flash(error)))?;
            at += bytes.len() as u32;
            if there == bytes {
                Ok(())
            } else {
                Err(Failure::WrongTable { sequence })
            }
        })
    }
}
