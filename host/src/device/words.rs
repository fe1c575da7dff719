//! What a device says, in words.

use quadcal::recalibrate::{Failure, Obstacle, Stage, Waiting, WriteFailure};
use quadcal::wire::{Refusal, TableFault};

/// Name of a stage in JSON.
#[must_use]
pub const fn stage_name(stage: Stage) -> &'static str {
    match stage {
        Stage::Idle => "idle",
        Stage::WaitingForMotion => "waiting_for_motion",
        Stage::CheckingSpeed => "checking_speed",
        Stage::Learning => "learning",
        Stage::Solving => "solving",
        Stage::Proving => "proving",
        Stage::ReadyToCommit => "ready_to_commit",
        Stage::Committing => "committing",
        Stage::Done => "done",
        Stage::Failed(_) => "failed",
    }
}

/// A stage, to be read after "Calibration:".
#[must_use]
pub fn stage_text(stage: Stage) -> String {
    match stage {
        Stage::Idle => "idle".to_owned(),
        Stage::WaitingForMotion => "waiting for the shaft to turn".to_owned(),
        Stage::CheckingSpeed => "waiting for a steady speed in the window".to_owned(),
        Stage::Learning => "learning".to_owned(),
        Stage::Solving => "working the table out".to_owned(),
        Stage::Proving => "holding the new table against the old on fresh turns".to_owned(),
        Stage::ReadyToCommit => "a new table waits to be committed".to_owned(),
        Stage::Committing => "writing the table to flash".to_owned(),
        Stage::Done => "done, the new table is in use".to_owned(),
        Stage::Failed(failure) => failure_text(&failure),
    }
}

/// Name of a failure in JSON.
#[must_use]
pub const fn failure_name(failure: &Failure) -> &'static str {
    match failure {
        Failure::TimedOut(_) => "timed_out",
        Failure::Interlock(_) => "interlock",
        Failure::TooFewTurns(_) => "too_few_turns",
        Failure::NotBetter => "not_better",
        Failure::NotWritten(_) => "not_written",
    }
}

/// Why a calibration came to nothing; what to do.
#[must_use]
pub fn failure_text(failure: &Failure) -> String {
    match failure {
        Failure::TimedOut(waiting) => timed_out(*waiting).to_owned(),
        Failure::Interlock(obstacle) => {
            format!("the drive stopped the calibration: {}", obstacle_text(*obstacle))
        }
        Failure::TooFewTurns(turns) => {
            format!("{turns} turns were usable, too few for a table; let the shaft turn evenly and try again")
        }
        Failure::NotBetter => {
            "on fresh turns the new table is not better than the one in use, which stays; if it should be, let the shaft turn more \
             evenly and at two speeds (more --turns help only where all were used), and look with 'quadcal device preview'"
                .to_owned()
        }
        Failure::NotWritten(failure) => write_failure(*failure).to_owned(),
    }
}

const fn timed_out(waiting: Waiting) -> &'static str {
    match waiting {
        Waiting::Motion => "the shaft did not turn in time; start the drive, then try again",
        Waiting::Speed => {
            "the speed did not stay in the window for long enough; drive more evenly, or widen --from and --to"
        }
        Waiting::Turn => {
            "no turn was usable for too long; look at the faults with 'quadcal device watch', and check index and wiring"
        }
        Waiting::Solver => "the table was not worked out in time; update the firmware or report it",
        Waiting::Proof => "no fresh turn was usable for too long; let the shaft turn until the end",
        Waiting::Commit => {
            "the table was not committed in time and is gone; calibrate again, with --commit"
        }
        Waiting::Table => {
            "the calibration took too long as a whole; drive more evenly, or ask for fewer --turns"
        }
    }
}

const fn write_failure(failure: WriteFailure) -> &'static str {
    match failure {
        WriteFailure::Flash => {
            "the flash failed while it was written, and the old table stays; check the supply and try again"
        }
        WriteFailure::TooLong => "the table does not fit its place in flash; update the firmware",
        WriteFailure::WornOut => "the flash was erased as often as it may be; replace the board",
        WriteFailure::Verify => {
            "the table did not read back as written, and the old one stays; check the supply and try again"
        }
        WriteFailure::Missing => "there was no table to write; calibrate or load one",
    }
}

/// What is in the way; what to do.
#[must_use]
pub fn obstacle_text(obstacle: Obstacle) -> String {
    match obstacle {
        Obstacle::Moving => "the shaft turns; bring it to rest and try again".to_owned(),
        Obstacle::Disabled => "the drive is not enabled; enable it and try again".to_owned(),
        Obstacle::Fault => "the drive has a fault; clear it and try again".to_owned(),
        Obstacle::Supply => {
            "the supply is too low or not sure to stay; check it and try again".to_owned()
        }
        Obstacle::Temperature => "it is too hot or too cold; wait and try again".to_owned(),
        Obstacle::Working => "the machine is at work; wait until it is done".to_owned(),
        Obstacle::Other(code) => {
            format!("the firmware's own reason {code}; see the firmware's description")
        }
    }
}

/// Why a device refuses; what to do.
#[must_use]
pub fn refusal_text(refusal: &Refusal) -> String {
    let fixed = match refusal {
        Refusal::Stage(stage) => return stage_refusal(*stage).to_owned(),
        Refusal::Interlock(obstacle) => return obstacle_text(*obstacle),
        Refusal::NotWritten(failure) => write_failure(*failure),
        Refusal::Table(fault) => table_fault(*fault),
        Refusal::Version(version) => {
            return format!("it speaks protocol version {version}; update quadcal or the firmware");
        }
        Refusal::Wait(ms) => {
            let seconds = ms.div_ceil(1000);
            return format!(
                "too many wrong keys were tried; wait {seconds} s, then give the right one"
            );
        }
        Refusal::Wear(seconds) => {
            return format!(
                "the flash was written too often lately; wait {}",
                duration(*seconds)
            );
        }
        Refusal::Offset(next) => {
            return format!("pieces of the table went missing from byte {next} on; load it again");
        }
        Refusal::Unknown => "the firmware does not know this request; update the firmware",
        Refusal::NoSession => "the session has ended; try again",
        Refusal::WrongProof => "the key is not this device's; give the right one",
        Refusal::Replayed => "it came twice or out of order; try again",
        Refusal::NoNonce => "the device has no random numbers, so no session opens; restart it",
        Refusal::Flash => {
            "the flash can't be read or written; restart the device and look at its status"
        }
        Refusal::NothingOlder => {
            "there is no older table to go back to; 'quadcal device erase' leaves none in use"
        }
        Refusal::NoTable => "the device has no table; calibrate it or load one",
        Refusal::Window => {
            "no speed is both in the window asked for and in the drive's own; widen --from and --to"
        }
    };
    fixed.to_owned()
}

const fn stage_refusal(stage: Stage) -> &'static str {
    match stage {
        Stage::Idle | Stage::Done | Stage::Failed(_) => {
            "no table waits to be committed; calibrate or load one first"
        }
        Stage::ReadyToCommit => {
            "a table waits to be committed; commit it, or give it up with 'quadcal device abort'"
        }
        Stage::Committing => "a table is being written; wait a moment",
        Stage::WaitingForMotion
        | Stage::CheckingSpeed
        | Stage::Learning
        | Stage::Solving
        | Stage::Proving => {
            "a calibration is under way; wait for it, or end it with 'quadcal device abort'"
        }
    }
}

const fn table_fault(fault: TableFault) -> &'static str {
    match fault {
        TableFault::Header => {
            "the device can't read the table's header; write the table again with this quadcal"
        }
        TableFault::Shape => {
            "the table is of an encoder of another shape; give the table of this one"
        }
        TableFault::Encoder => {
            "the table is of another encoder, by its serial number; give the table of this one"
        }
        TableFault::Clock => {
            "the table's delays don't fit the device's clock; calibrate on the device"
        }
        TableFault::Crc => "the table was damaged on the way; load it again",
    }
}

fn duration(seconds: u32) -> String {
    match seconds {
        0..120 => format!("{seconds} s"),
        120..7200 => format!("{} min", seconds.div_ceil(60)),
        _ => format!("{} h", seconds.div_ceil(3600)),
    }
}

/// Name of an edge class of an encoder with so many.
#[must_use]
pub fn class_name(classes: usize, class: usize) -> String {
    match (classes, class) {
        (4, 0) => "A rising".to_owned(),
        (4, 1) => "B rising".to_owned(),
        (4, 2) => "A falling".to_owned(),
        (4, 3) => "B falling".to_owned(),
        _ => format!("class {class}"),
    }
}

#[cfg(test)]
mod tests;
