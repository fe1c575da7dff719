//! Learning an encoder again in the field, by command, as an explicit state machine.
//!
//! ```text
//! +------+  start   +------------+   turns   +-----------+    steady in the window     +----------+
//! | idle |--------->| waiting    |---------->| checking  |---------------------------->| learning |
//! +------+          | for motion |<----------| the speed |<----------------------------|          |
//!                   +------------+   still   +-----------+      leaves the window      +----------+
//!                       ^   ^                                                           |      |
//!                 start |   +-----------------------------------------------------------+      |
//!                       |                               still                                  | enough
//! +------+              |       +--------+         too few turns                               v turns
//! | done |--------------+-------| failed |<-----------------------------------------------+---------+
//! +------+                      +--------+                                                | solving |
//!    ^                           ^  ^  ^          not better on fresh turns               +---------+
//!    |              not written  |  |  +------------------------------------------+            | solved
//!    |            +--------------+  | time is over                                |            v
//!    |            |                 |                                             +-------+---------+
//!    |  written  +------------+  commit  +-----------------+    better on fresh turns     | proving |
//!    +-----------| committing |<---------| ready to commit |<-----------------------------+---------+
//!                |            |--------->|                 |
//!                +------------+ held back+-----------------+
//!                                                 ^ a table is handed over: from idle, done, failed
//!
//! from waiting, checking, learning, solving, proving:  time is over, the interlock says no  -> failed
//! from all but committing:                             abort                                -> idle
//! ```
//!
//! [`Machine`] is pure: [`Event`]s come in, a state and at most one [`Action`] come out. It neither touches edges nor flash;
//! whoever owns it does what the actions say. The table in use goes on correcting from the start to the moment that another one
//! is in flash.
//!
//! The interlock is asked when the command to commit comes, and once more right before flash is erased. Where it says no by then, the
//! table is held back: nothing was touched, it waits as before, and another command commits it.
//!
//! A learned table has to be better than the one in use on turns that it was not learned from. One that is handed over need not be:
//! whoever has the key vouches for it, and a new encoder's table has to go in at standstill. But while it waits it is held against the
//! one in use on the turns that come ([`Action::Compare`]), so that the preview has figures where the shaft turns.
//!
//! Every state that waits for something has a limit in [`Limits`]; where turns come and go, the whole has one too.

mod event;
mod figures;
mod interlock;
mod machine;
mod options;
mod stage;

#[cfg(test)]
mod tests;

pub use event::{Action, Candidate, Event, Refused, SolveInSlices, Solving, Taken};
pub use figures::{Figures, Scatter};
pub use interlock::{Interlock, WearBudget, WearConfig};
pub use machine::Machine;
pub use options::{Limits, Options, PROOF_TURNS_LEAST, SpeedWindow, TURNS_LEAST};
pub use stage::{Failure, Obstacle, Stage, Waiting, WriteFailure};
