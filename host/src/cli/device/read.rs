//! `quadcal device identify`, `status` and `preview`: what only reads.

use clap::Args;

use super::super::failure::Failure;
use super::super::output::{Facts, JsonArg};
use super::line::LineArgs;
use super::summary::{IdentitySummary, PreviewSummary, ProofSummary, StatusSummary};
use super::{EXIT_CODES, facts};

const IDENTIFY_EXAMPLES: &str = "\
Examples:
  quadcal device identify --port /dev/ttyACM0
  quadcal device identify --port tcp:localhost:4444 --json - | jq .serial

";

/// Show who the device is: firmware, encoder, clock
#[derive(Debug, Args)]
#[command(after_help = [IDENTIFY_EXAMPLES, EXIT_CODES].concat())]
pub(super) struct Identify {
    #[command(flatten)]
    json: JsonArg,
}

impl Identify {
    pub fn run(self, line: &LineArgs) -> Result<(), Failure> {
        let mut client = line.reader()?;
        let identity = client.identify()?;
        let mut facts = Facts::default();
        facts.push("Port", client.name());
        facts::identity(&mut facts, &identity);
        self.json
            .write(&IdentitySummary::new(client.name(), &identity), &facts)
    }
}

const STATUS_EXAMPLES: &str = "\
Examples:
  quadcal device status --port /dev/ttyACM0
  quadcal device status --port unix:/tmp/drive --json - | jq -r .stage

";

/// Show where calibration stands, and the table in use
#[derive(Debug, Args)]
#[command(after_help = [STATUS_EXAMPLES, EXIT_CODES].concat())]
pub(super) struct Status {
    #[command(flatten)]
    json: JsonArg,
}

impl Status {
    pub fn run(self, line: &LineArgs) -> Result<(), Failure> {
        let mut client = line.reader()?;
        let status = client.status()?;
        let mut facts = Facts::default();
        facts.push("Port", client.name());
        facts::status(&mut facts, &status);
        self.json
            .write(&StatusSummary::new(client.name(), &status), &facts)
    }
}

const PREVIEW_EXAMPLES: &str = "\
Examples:
  quadcal device preview --port /dev/ttyACM0
  quadcal device preview --port /dev/ttyACM0 --json - | jq .proof.better

Both tables saw the same edges of the same turns, which neither was learned from. What the shaft
itself swings is in the angle of both; from edge to edge it hardly matters. With no table in use,
the old one is the bare encoder.

";

/// Show the new table, learned or loaded, against the old one, on fresh turns
#[derive(Debug, Args)]
#[command(after_help = [PREVIEW_EXAMPLES, EXIT_CODES].concat())]
pub(super) struct Preview {
    #[command(flatten)]
    json: JsonArg,
}

impl Preview {
    pub fn run(self, line: &LineArgs) -> Result<(), Failure> {
        let mut client = line.reader()?;
        let figures = client.preview()?;
        let mut facts = Facts::default();
        facts.push("Port", client.name());
        match &figures {
            Some(figures) => facts::proof(&mut facts, figures),
            None => {
                let none = "nothing yet; 'quadcal device recalibrate' or 'load' makes a table to compare while the shaft turns";
                facts.push("Proven on", none);
            }
        }
        let summary = PreviewSummary {
            port: client.name().to_owned(),
            proof: figures.as_ref().map(ProofSummary::new),
        };
        self.json.write(&summary, &facts)
    }
}
