//! A question to the user, where there is one.

use std::io::{self, BufRead, IsTerminal, Write};

/// Whether there is somebody to answer: input and output are a terminal.
pub(super) fn possible() -> bool {
    io::stdin().is_terminal() && io::stderr().is_terminal()
}

/// Asks a question that is answered by yes or no. None where there is nobody to answer.
pub(super) fn yes(question: &str) -> Option<bool> {
    if !possible() {
        return None;
    }
    let mut stderr = io::stderr().lock();
    let mut answer = String::new();
    write!(stderr, "{question} [y/N] ").ok()?;
    stderr.flush().ok()?;
    io::stdin().lock().read_line(&mut answer).ok()?;
    Some(matches!(answer.trim(), "y" | "Y" | "yes"))
}
