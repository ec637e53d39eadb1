//! A line for each host: redrawn in place on a terminal, one after the other elsewhere. Progress goes to standard error.

use std::io::{IsTerminal, Write, stderr};
use std::sync::{Mutex, PoisonError};

/// All lines.
pub struct Progress {
    lines: Mutex<Vec<Line>>,
    is_terminal: bool,
}

struct Line {
    host: String,
    words: String,
}

impl Progress {
    /// A line for each of these hosts.
    pub fn of(hosts: impl Iterator<Item = String>) -> Self {
        let line = |host| Line {
            host,
            words: String::new(),
        };
        let progress = Self {
            lines: Mutex::new(hosts.map(line).collect()),
            is_terminal: stderr().is_terminal(),
        };
        if progress.is_terminal {
            progress.redraw(&progress.locked(), 0);
        }
        progress
    }

    /// Where a host is now.
    pub fn say(&self, host: usize, words: &str) {
        let mut lines = self.locked();
        let n_lines = lines.len();
        let line = &mut lines[host];
        if line.words == words {
            return;
        }
        words.clone_into(&mut line.words);
        if self.is_terminal {
            self.redraw(&lines, n_lines);
        } else {
            let line = &lines[host];
            let _ = writeln!(stderr().lock(), "{}: {}", line.host, line.words);
        }
    }

    fn locked(&self) -> std::sync::MutexGuard<'_, Vec<Line>> {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Draws all lines, `above` of which are on the screen already.
    fn redraw(&self, lines: &[Line], above: usize) {
        let mut text = String::new();
        if above > 0 {
            text.push_str(&format!("\x1b[{above}A"));
        }
        for line in lines {
            text.push_str(&format!("\x1b[2K{:<24} {}\n", line.host, line.words));
        }
        let _ = stderr().lock().write_all(text.as_bytes());
    }
}
