//! Display of progress: a block redrawn in place on a terminal, plain lines otherwise, or JSON.

use super::block;
use crate::output::{Format, print_line};
use sextant_calibrator::procedure::Progress;
use sextant_process::terminal;
use std::io::{self, Write};
use std::time::{Duration, Instant};

/// Least time between two drawings of the block.
const REDRAWN: Duration = Duration::from_millis(250);
/// Least time between two lines.
const SPOKEN: Duration = Duration::from_secs(1);
/// Progress after which another line is printed.
const STEP: f64 = 0.05;

/// Displays the progress of a procedure: in place on a terminal, else by lines.
pub struct ProgressDisplay {
    manner: DisplayMode,
    due: Instant,
    last: Option<(String, f64)>,
    remarked: Vec<String>,
}

enum DisplayMode {
    /// Lines of the displayed block.
    Block(usize),
    Lines,
    Json,
}

impl ProgressDisplay {
    /// A display for this output format.
    pub fn new(format: Format) -> Self {
        Self {
            manner: match format {
                Format::Json => DisplayMode::Json,
                Format::Text if terminal::can_redraw(&io::stdout()) => DisplayMode::Block(0),
                Format::Text => DisplayMode::Lines,
            },
            due: Instant::now(),
            last: None,
            remarked: Vec::new(),
        }
    }

    /// Whether the next update is due.
    pub fn is_due(&self) -> bool {
        Instant::now() >= self.due
    }

    /// Shows progress, with remarks on the cameras.
    ///
    /// # Errors
    /// A closed output.
    pub fn show(&mut self, progress: &Progress, remarks: &[String]) -> anyhow::Result<()> {
        let period = match self.manner {
            DisplayMode::Block(_) => REDRAWN,
            DisplayMode::Lines | DisplayMode::Json => SPOKEN,
        };
        self.due = Instant::now() + period;
        if let DisplayMode::Block(drawn) = &mut self.manner {
            let lines = block::lines(progress, remarks);
            *drawn = draw(*drawn, &lines)?;
            return Ok(());
        }
        for remark in remarks {
            self.remark(remark);
        }
        if !self.is_news(progress) {
            return Ok(());
        }
        self.last = Some((progress.hint.clone(), progress.fraction));
        match self.manner {
            DisplayMode::Json => print_line(&serde_json::to_string(progress)?)?,
            _ => print_line(&block::line(progress))?,
        }
        Ok(())
    }

    fn is_news(&self, progress: &Progress) -> bool {
        self.last.as_ref().is_none_or(|(hint, fraction)| {
            *hint != progress.hint
                || progress.fraction >= fraction + STEP
                || progress.is_enough && *fraction < 1.0
        })
    }

    /// Prints a line about the whole procedure, below the block.
    ///
    /// # Errors
    /// A closed output.
    pub fn say(&mut self, words: &str) -> io::Result<()> {
        match &mut self.manner {
            DisplayMode::Block(drawn) => {
                *drawn = 0;
                print_line(words)
            }
            DisplayMode::Lines => print_line(words),
            DisplayMode::Json => {
                eprintln!("{words}");
                Ok(())
            }
        }
    }

    /// Prints a remark once, on standard error.
    pub fn remark(&mut self, remark: &str) {
        if !self.remarked.iter().any(|said| said == remark) {
            eprintln!("{remark}");
            self.remarked.push(remark.to_owned());
        }
    }
}

/// Draws over the displayed block, and returns its number of lines.
fn draw(standing: usize, lines: &[String]) -> io::Result<usize> {
    let (columns, rows) = terminal::size().map_or((80, 24), |(c, r)| (c.into(), r.into()));
    let lines: Vec<String> = lines
        .iter()
        .flat_map(|line| wrapped(line, columns))
        .collect();
    // One row is the cursor's; what to do next stands last and is always shown.
    let shown = lines.len().min(usize::max(rows, 2) - 1);
    let mut out = String::new();
    if standing > 0 {
        out.push_str(&format!("\x1b[{standing}F"));
    }
    for line in &lines[lines.len() - shown..] {
        out.push_str(line);
        out.push_str("\x1b[K\n");
    }
    out.push_str("\x1b[J");
    let mut stdout = io::stdout().lock();
    stdout.write_all(out.as_bytes())?;
    stdout.flush()?;
    Ok(shown)
}

/// Breaks a line into lines that fit, between words if possible.
fn wrapped(line: &str, columns: usize) -> Vec<String> {
    let letters: Vec<char> = line.chars().collect();
    let columns = columns.max(8);
    let (mut parts, mut rest) = (Vec::new(), &letters[..]);
    while rest.len() > columns {
        let space = rest[..columns].iter().rposition(|c| *c == ' ');
        let end = space.filter(|at| *at > columns / 2).unwrap_or(columns);
        parts.push(rest[..end].iter().collect());
        rest = &rest[end..];
    }
    parts.push(rest.iter().collect());
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_break_between_words_and_lose_nothing() {
        let line =
            "> Several things move, each as one: name a tag of yours, or keep the others still";
        for columns in [10, 33, 200] {
            let parts = wrapped(line, columns);
            assert!(parts.iter().all(|part| part.chars().count() <= columns));
            assert_eq!(parts.concat(), line);
        }
        assert_eq!(wrapped("", 20), [""]);
        assert_eq!(wrapped(&"x".repeat(25), 10).len(), 3);
    }
}
