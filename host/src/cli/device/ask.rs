//! A question to the user, where there is one.

use std::io::{self, BufRead, IsTerminal, Write};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use super::interrupt;

/// Time between two looks at whether Ctrl-C was pressed.
const ATTENTION: Duration = Duration::from_millis(50);

/// What the user wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// That it is done.
    Yes,
    /// That it is not.
    No,
    /// That all ends: Ctrl-C, where [`interrupt`] has it.
    Stop,
    /// There is nobody to answer.
    Nobody,
}

/// Whether there is somebody to answer: input and output are a terminal.
fn possible() -> bool {
    io::stdin().is_terminal() && io::stderr().is_terminal()
}

/// Asks a question that is answered by yes or no, with `reasons` to decide by before it. Nothing is shown where there is nobody to answer.
pub(super) fn yes(reasons: &str, question: &str) -> Answer {
    if !possible() {
        return Answer::Nobody;
    }
    let mut stderr = io::stderr().lock();
    let asked = write!(stderr, "{reasons}{question} [y/N] ").and_then(|()| stderr.flush());
    drop(stderr);
    if asked.is_err() {
        return Answer::Nobody;
    }
    // Reading a line goes on over a signal: Ctrl-C is looked for beside it.
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        let mut line = String::new();
        let read = io::stdin().lock().read_line(&mut line);
        let _ = sender.send(read.map(|_| line));
    });
    loop {
        match receiver.recv_timeout(ATTENTION) {
            Ok(Ok(line)) if matches!(line.trim(), "y" | "Y" | "yes") => return Answer::Yes,
            Ok(Ok(_)) => return Answer::No,
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => return Answer::Nobody,
            Err(RecvTimeoutError::Timeout) if interrupt::asked() => {
                let _ = writeln!(io::stderr());
                return Answer::Stop;
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
}
