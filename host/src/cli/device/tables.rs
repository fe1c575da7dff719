//! `quadcal device dump` and `load`: tables between device and file.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use quadcal::recalibrate::Figures;
use quadcal::slot::Slot;
use quadcal::units::RAD_PER_TURN32;
use quadcal::wire::TableInfo;

use crate::report::si;
use crate::table_file;

use super::super::Globals;
use super::super::failure::Failure;
use super::super::output::{Facts, JsonArg, Target, spare};
use super::super::progress::Progress;
use super::line::LineArgs;
use super::summary::{ProofSummary, TableSummary, TransferSummary};
use super::{EXIT_CODES, ask, facts};

const DUMP_EXAMPLES: &str = "\
Examples:
  quadcal device dump --port /dev/ttyACM0 -o drive.qct
  quadcal verify today.csv --table drive.qct
  quadcal device dump --port /dev/ttyACM0 -o - | sha256sum

The file holds the bytes of the slot in flash, as quadcal calibrate writes them too.

";

/// Read the table in use into a file
#[derive(Debug, Args)]
#[command(after_help = [DUMP_EXAMPLES, EXIT_CODES].concat())]
pub(super) struct Dump {
    /// File to write, '-' for stdout; it appears once it is complete and checked
    #[arg(short, long, value_name = "TABLE")]
    output: Target,
    #[command(flatten)]
    json: JsonArg,
}

impl Dump {
    pub fn run(self, line: &LineArgs, globals: Globals) -> Result<(), Failure> {
        if self.json.json.as_ref() == Some(&self.output) {
            return Err(Failure::OverOutput {
                target: self.output,
            });
        }
        let mut client = line.reader()?;
        let mut progress = Progress::count("Reading", "bytes", None, globals);
        let bytes = client.dump(|done, whole| progress.of(done.into(), whole.into()))?;
        drop(progress);
        self.output.write(&bytes)?;
        let summary = transfer(client.name(), &self.output.to_string(), &bytes, None)?;
        let facts = table_facts(&summary);
        if self.output == Target::Stdout && self.json.json.is_none() {
            return Ok(());
        }
        self.json.write(&summary, &facts)
    }
}

const LOAD_EXAMPLES: &str = "\
Examples:
  quadcal device load drive.qct --port /dev/ttyACM0 --key-file drive.key --commit
  quadcal calibrate rig.csv -o rig.qct && quadcal device load rig.qct --port /dev/ttyACM0

The table is checked before anything is sent: its check sum, and that its encoder has the shape and
serial number of the device's. Loaded, it waits to be committed: with --commit, by answering yes, or
by 'quadcal device commit'. Where the shaft turns, the device first holds it against the table in
use on a few fresh turns; a worse one is warned of, but may be committed.

";

/// What is said of a table that is worse than the one in use.
const WORSE: &str = "on fresh turns the loaded table is worse than the one in use; 'quadcal device abort' gives it up, 'rollback' \
                     brings the old one back";

/// Hand a table over to the device
#[derive(Debug, Args)]
#[command(after_help = [LOAD_EXAMPLES, EXIT_CODES].concat())]
pub(super) struct Load {
    /// Error table, as quadcal calibrate or device dump wrote it
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// Commit it without asking
    #[arg(long)]
    commit: bool,
    #[command(flatten)]
    json: JsonArg,
}

impl Load {
    pub fn run(self, line: &LineArgs, globals: Globals) -> Result<(), Failure> {
        spare(&[self.json.json.as_ref()], &self.table)?;
        let bytes = table_file::read(&self.table).map_err(|source| Failure::Open {
            path: self.table.clone(),
            source,
        })?;
        table_file::parse(&bytes).map_err(|fault| Failure::Table {
            table: self.table.clone(),
            fault,
        })?;
        let mut client = line.commander()?;
        let mut progress = Progress::count("Loading", "bytes", None, globals);
        let loaded = client.load(&bytes, |done, whole| progress.of(done.into(), whole.into()));
        drop(progress);
        loaded.map_err(|error| Failure::loading(&self.table, error))?;
        let mut progress = Progress::count("Comparing", "turns", None, globals);
        let figures = client.compare(|done, whole| progress.of(done.into(), whole.into()));
        drop(progress);
        let figures = figures?;
        if !globals.quiet && figures.as_ref().is_some_and(Figures::is_worse) {
            let _ = writeln!(io::stderr(), "Warning: {WORSE}");
        }
        let commit = self.commit || ask::yes("The table is loaded. Commit it?") == Some(true);
        let table = if commit { client.commit()? } else { None };
        client.close();
        let name = self.table.display().to_string();
        let summary = transfer(
            client.name(),
            &name,
            &bytes,
            table.as_ref().filter(|_| commit),
        )?;
        let mut facts = table_facts(&summary);
        if let Some(figures) = &figures {
            facts::proof(&mut facts, figures);
        }
        if commit {
            facts::table(&mut facts, table.as_ref());
        } else {
            facts.push("Waits", "'quadcal device commit' makes it count");
        }
        let summary = TransferSummary {
            committed: commit,
            proof: figures.as_ref().map(ProofSummary::new),
            ..summary
        };
        self.json.write(&summary, &facts)
    }
}

fn transfer(
    port: &str,
    file: &str,
    bytes: &[u8],
    table: Option<&TableInfo>,
) -> Result<TransferSummary, Failure> {
    let slot = Slot::parse(bytes).map_err(|fault| Failure::Table {
        table: file.into(),
        fault,
    })?;
    let header = slot.header;
    Ok(TransferSummary {
        port: port.to_owned(),
        file: file.to_owned(),
        bytes: bytes.len(),
        edges_per_turn: header.shape.edges(),
        turns: header.turns,
        standard_error_rad: f64::from(header.standard_error) * RAD_PER_TURN32,
        committed: false,
        proof: None,
        table: table.map(TableSummary::new),
    })
}

fn table_facts(summary: &TransferSummary) -> Facts {
    let mut facts = Facts::default();
    facts
        .push("Port", &summary.port)
        .push("Table", &summary.file)
        .push("Bytes", summary.bytes)
        .push("Edges a turn", summary.edges_per_turn)
        .push("Learned from", format!("{} turns", summary.turns))
        .push(
            "Expected to be left, RMS",
            si(summary.standard_error_rad, "rad"),
        );
    facts
}
