//! `quadcal device dump` and `load`: tables between device and file.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use quadcal::recalibrate::Figures;
use quadcal::slot::Slot;
use quadcal::units::RAD_PER_TURN32;
use quadcal::wire::{Request, TableInfo};

use crate::report::si;
use crate::table_file;

use super::super::Globals;
use super::super::failure::Failure;
use super::super::output::{Facts, JsonArg, Target, spare};
use super::super::progress::Progress;
use super::ask::Answer;
use super::committing::Committed;
use super::line::{AnyClient, LineArgs};
use super::summary::{ProofSummary, TableSummary, TransferSummary};
use super::{EXIT_CODES, ask, committing, facts, interrupt};

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
    /// File to write, '-' for stdout; once complete and checked, it takes an older one's place
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
        self.json
            .write_beside(&[Some(&self.output)], &summary, &facts)
    }
}

const LOAD_EXAMPLES: &str = "\
Examples:
  quadcal device load drive.qct --port /dev/ttyACM0 --key-file drive.key --commit
  quadcal calibrate rig.csv -o rig.qct && quadcal device load rig.qct --port /dev/ttyACM0

The table is checked before anything is sent: its check sum, and that its encoder has the shape and
serial number of the device's. Loaded, it waits to be committed: with --commit, by answering yes, or
by 'quadcal device commit'. Where the shaft turns, the device first holds it against the table in
use on a few fresh turns; with --commit, a worse one is left waiting (exit code 1) without --force.

";

/// What is said of a table that is worse than the one in use.
const WORSE: &str = "on fresh turns the loaded table is WORSE than the one in use";

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
    /// Commit it even if it is worse than the table in use
    #[arg(long, requires = "commit")]
    force: bool,
    #[command(flatten)]
    json: JsonArg,
}

/// What becomes of a table that was handed over.
enum Fate {
    Tried(Committed),
    Left,
    Worse,
    Stopped,
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
        let mut compared = Facts::default();
        match &figures {
            Some(figures) => facts::proof(&mut compared, figures),
            None if client.live()?.speed_raw == 0 => {
                compared.push("Proven on", "not compared: the shaft stands still");
            }
            None => {
                compared.push("Proven on", "not compared: no turn was usable in time");
            }
        }
        let worse = figures.as_ref().is_some_and(Figures::is_worse);
        let fate = self.fate(&mut client, worse, &compared, globals)?;
        let name = self.table.display().to_string();
        let table = match &fate {
            Fate::Tried(committed) => committed.table(),
            _ => None,
        };
        let mut summary = transfer(client.name(), &name, &bytes, table)?;
        let mut facts = table_facts(&summary);
        facts.append(compared);
        summary.proof = figures.as_ref().map(ProofSummary::new);
        summary.committed = matches!(fate, Fate::Tried(Committed::InFlash(_)));
        summary.outcome = Some(fate.outcome());
        fate.describe(&mut facts);
        self.json.write(&summary, &facts)?;
        match fate {
            Fate::Tried(committed) => committed.end(),
            Fate::Left => Ok(()),
            Fate::Worse => Err(Failure::WorseLoaded { table: self.table }),
            Fate::Stopped => Err(Failure::Stopped),
        }
    }

    fn fate(
        &self,
        client: &mut AnyClient,
        worse: bool,
        compared: &Facts,
        globals: Globals,
    ) -> Result<Fate, Failure> {
        if self.commit && worse && !self.force {
            return Ok(Fate::Worse);
        }
        if !self.commit {
            interrupt::catch();
            let answer = ask::yes(&compared.to_string(), "The table is loaded. Commit it?");
            interrupt::release();
            match answer {
                Answer::Yes => {}
                Answer::Stop => {
                    client.change("abort", &Request::Abort)?;
                    return Ok(Fate::Stopped);
                }
                Answer::No | Answer::Nobody => return Ok(Fate::Left),
            }
        } else if worse && !globals.quiet {
            // A warning that cannot be shown is no reason to fail.
            let _ = writeln!(io::stderr(), "Warning: {WORSE}");
        }
        Ok(Fate::Tried(committing::commit(client)))
    }
}

impl Fate {
    const fn outcome(&self) -> &'static str {
        match self {
            Self::Tried(committed) => committed.outcome(),
            Self::Left => "waiting",
            Self::Worse => "worse",
            Self::Stopped => "stopped",
        }
    }

    fn describe(&self, facts: &mut Facts) {
        match self {
            Self::Tried(committed) => committed.describe(facts),
            Self::Left | Self::Worse => {
                facts.push("Outcome", committing::waits_text());
            }
            Self::Stopped => {
                facts.push("Outcome", "given up; the table in use is as before");
            }
        }
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
        outcome: None,
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
