//! `quadcal convert`: a recording in another format.

use std::io::{self, Write};

use clap::{Args, ValueEnum};

use crate::recording::write::{NativeWriter, VcdWriter};

use super::failure::Failure;
use super::input::InputArgs;
use super::output::{Output, Target};
use super::progress::Watched;
use super::{EXIT_CODES, Globals};

const EXAMPLES: &str = "\
Examples:
  quadcal convert capture.vcd -o capture.csv
  quadcal convert analyser.csv --map 'a=Channel 0' --map 'b=Channel 1' -o edges.csv
  quadcal convert intervals.txt --list intervals -o wheel.vcd
  quadcal convert capture.vcd -o - --to csv | head

";

/// Rewrite a recording as native CSV or VCD
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Convert {
    #[command(flatten)]
    input: InputArgs,
    /// File to write, '-' for stdout; it appears once it is complete
    #[arg(short, long, value_name = "OUT")]
    output: Target,
    /// Format to write, where the name of OUT does not end in .csv or .vcd
    #[arg(long, value_enum)]
    to: Option<Kind>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Native CSV: '# clock_hz = ...', then ticks and levels
    Csv,
    /// Value change dump, as waveform viewers read
    Vcd,
}

/// A writer of either format.
enum Writer {
    Csv(NativeWriter<Output>),
    Vcd(Box<VcdWriter<Output>>),
}

impl Convert {
    /// Reads the recording through and writes it.
    pub fn run(self, globals: Globals) -> Result<(), Failure> {
        let target = &self.output;
        let kind = self.kind()?;
        self.input.spare(target)?;
        let recording = self.input.open()?;
        let writing = |error| Failure::writing(target, error);
        let (output, header) = (target.create()?, &recording.header);
        let mut writer = match kind {
            Kind::Csv => Writer::Csv(NativeWriter::new(output, header).map_err(writing)?),
            Kind::Vcd => Writer::Vcd(Box::new(VcdWriter::new(output, header).map_err(writing)?)),
        };
        let mut rows = Watched::new(recording, globals);
        let mut written = 0_u64;
        for row in rows.by_ref() {
            let row = row?;
            match &mut writer {
                Writer::Csv(writer) => writer.row(&row),
                Writer::Vcd(writer) => writer.row(&row),
            }
            .map_err(writing)?;
            written += 1;
        }
        let output = match writer {
            Writer::Csv(writer) => writer.finish(),
            Writer::Vcd(writer) => writer.finish(),
        }
        .map_err(writing)?;
        output.commit().map_err(|source| target.failed(source))?;
        let repeated = rows.recording().repeated_rows();
        drop(rows);
        if !globals.quiet {
            let left_out = match repeated {
                0 => String::new(),
                repeated => format!(", {repeated} that repeat the levels above left out"),
            };
            // A remark that cannot be shown is no reason to fail.
            let _ = writeln!(io::stderr(), "{target}: {written} rows written{left_out}");
        }
        Ok(())
    }

    fn kind(&self) -> Result<Kind, Failure> {
        let extension = match &self.output {
            Target::File(path) => path.extension().and_then(|extension| extension.to_str()),
            Target::Stdout => None,
        };
        let named = [("csv", Kind::Csv), ("vcd", Kind::Vcd)]
            .into_iter()
            .find(|(name, _)| extension.is_some_and(|found| found.eq_ignore_ascii_case(name)))
            .map(|(_, kind)| kind);
        self.to.or(named).ok_or_else(|| Failure::OutputFormat {
            target: self.output.clone(),
        })
    }
}
