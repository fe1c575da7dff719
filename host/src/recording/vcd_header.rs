//! The definitions of a VCD: which signals are the channels, and what a unit of time is.

use std::sync::Arc;

use vcd::{Command, IdCode, TimescaleUnit, VarType};

use super::Channels;
use super::columns::{bit, channels, found};
use super::error::ReadError;
use super::options::{ReadOptions, Signal};
use super::place::{Place, quote};
use super::vcd::{PULSE, Source};
use super::vcd_time::Timescale;

/// A signal of the VCD that is a channel.
#[derive(Clone, Debug)]
pub(super) struct Wire {
    pub id: IdCode,
    pub name: String,
    pub bit: u8,
}

/// What the definitions say.
pub(super) struct Definitions {
    pub timescale: Timescale,
    pub channels: Channels,
    pub wires: Vec<Wire>,
    pub notes: Vec<(String, String)>,
}

/// Most names that are kept for a message, most scopes within each other, most bytes of comments.
const NAMES: usize = 16;
const DEPTH: usize = 256;
const NOTE_BYTES: usize = 1024 * 1024;

/// Reads up to and with `$enddefinitions`.
pub(super) fn read(source: &mut Source, options: &ReadOptions) -> Result<Definitions, ReadError> {
    let mut finder = Finder::default();
    let mut scope = Vec::new();
    let mut unit = None;
    let mut notes = Vec::new();
    let mut note_bytes = 0;
    loop {
        let Some(command) = source.next()? else {
            return Err(source.cut("before $enddefinitions"));
        };
        match command {
            Command::Timescale(quantity, of) => unit = Some((quantity, of, source.here())),
            Command::ScopeDef(_, name) => scope.push(name),
            Command::Upscope => {
                scope.pop();
            }
            Command::VarDef(kind, size, id, name, _) => {
                let at = source.here();
                finder.take(
                    Variable {
                        kind,
                        size,
                        id,
                        name,
                    },
                    &scope,
                    options,
                    &at,
                )?;
            }
            Command::Comment(text) => {
                note_bytes += text.len();
                if let Some((key, value)) = text.split_once('=') {
                    notes.push((key.trim().to_owned(), value.trim().to_owned()));
                }
            }
            Command::Enddefinitions => break,
            Command::Date(_) | Command::Version(_) => {}
            _ => {
                return Err(ReadError::Vcd {
                    at: source.here(),
                    reason: "changes before $enddefinitions".to_owned(),
                });
            }
        }
        if scope.len() > DEPTH || note_bytes > NOTE_BYTES {
            return Err(ReadError::TooLong {
                at: source.here(),
                limit: NOTE_BYTES,
            });
        }
    }
    let timescale = timescale(unit, &notes, source)?;
    let (channels, wires) = finder.finish(&source.here(), options)?;
    Ok(Definitions {
        timescale,
        channels,
        wires,
        notes,
    })
}

fn timescale(
    unit: Option<(u32, TimescaleUnit, Place)>,
    notes: &[(String, String)],
    source: &Source,
) -> Result<Timescale, ReadError> {
    let Some((quantity, unit, at)) = unit else {
        return Err(ReadError::NoClock {
            at: source.here(),
            wanted: "$timescale 1 ns $end",
        });
    };
    let plain = Timescale::new(quantity, unit.divisor()).ok_or_else(|| ReadError::BadHeader {
        at,
        key: "$timescale".to_owned(),
        value: format!("{quantity} {unit}"),
        wanted: "1, 10 or 100 of s, ms, us, ns, ps or fs",
    })?;
    // A VCD written from ticks of another clock names it in a comment, so that its ticks come back.
    let written_from = notes
        .iter()
        .find(|(key, _)| key == "clock_hz")
        .and_then(|(_, hz)| hz.parse().ok());
    Ok(written_from
        .and_then(|hz| Timescale::recounted(quantity, unit.divisor(), hz))
        .unwrap_or(plain))
}

/// A `$var` of the header.
struct Variable {
    kind: VarType,
    size: u32,
    id: IdCode,
    name: String,
}

/// Picks the channels among the signals.
#[derive(Default)]
struct Finder {
    /// In the order of [`Signal::CHANNELS`].
    channels: [Option<Wire>; 4],
    pulse: Option<Wire>,
    names: Vec<String>,
}

impl Finder {
    fn take(
        &mut self,
        variable: Variable,
        scope: &[String],
        options: &ReadOptions,
        at: &Place,
    ) -> Result<(), ReadError> {
        let name = variable.name.trim();
        let path = || format!("{}.{name}", scope.join("."));
        if self.names.len() < NAMES {
            self.names.push(name.to_owned());
        }
        let wire = Wire {
            id: variable.id,
            name: name.to_owned(),
            bit: 1,
        };
        if variable.kind == VarType::Event {
            if name.eq_ignore_ascii_case(options.mapped(Signal::A).unwrap_or(PULSE)) {
                keep(&mut self.pulse, wire, at)?;
            }
            return Ok(());
        }
        for (slot, signal) in self.channels.iter_mut().zip(Signal::CHANNELS) {
            let wanted = options.name(signal).trim().to_lowercase();
            if name.to_lowercase() != wanted && path().to_lowercase() != wanted {
                continue;
            }
            if variable.size != 1 {
                return Err(ReadError::BadHeader {
                    at: named(at, name),
                    key: "the signal's width".to_owned(),
                    value: variable.size.to_string(),
                    wanted: "1 bit",
                });
            }
            keep(slot, wire.clone(), at)?;
        }
        Ok(())
    }

    fn finish(self, at: &Place, options: &ReadOptions) -> Result<(Channels, Vec<Wire>), ReadError> {
        let present = [0, 1, 2, 3].map(|n| self.channels[n].is_some());
        if let (Some(pulse), false) = (&self.pulse, present.contains(&true)) {
            return Ok((Channels::Pulses, vec![pulse.clone()]));
        }
        // Without any channel there is nothing that could be pulses.
        let channels =
            channels(present, true, options).map_err(|signal| ReadError::MissingColumn {
                at: at.clone(),
                wanted: quote(options.name(signal).as_bytes()),
                found: found(self.names.iter().map(String::as_str)),
            })?;
        let wires = self
            .channels
            .into_iter()
            .zip(Signal::CHANNELS)
            .filter_map(|(wire, signal)| {
                let bit = bit(channels, signal)?;
                wire.map(|wire| Wire { bit, ..wire })
            });
        Ok((channels, wires.collect()))
    }
}

/// Keeps a signal; a second one of that name is fine if it is the same under another scope.
fn keep(slot: &mut Option<Wire>, wire: Wire, at: &Place) -> Result<(), ReadError> {
    match slot {
        Some(kept) if kept.id != wire.id => Err(ReadError::DuplicateColumn {
            at: named(at, &wire.name),
        }),
        _ => {
            *slot = Some(wire);
            Ok(())
        }
    }
}

fn named(at: &Place, name: &str) -> Place {
    let file: &Arc<str> = &at.file;
    Place::named(file, at.line.unwrap_or(1), name)
}
