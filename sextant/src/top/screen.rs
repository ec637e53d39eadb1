//! The terminal as a screen that is redrawn in place, and restored at the end.

use crate::top::table::{Line, Tone};
use sextant_process::terminal;
use std::io::{self, Write};

/// Default number of columns.
const USUAL_WIDTH: usize = 100;
/// A terminal with fewer columns is assumed not to know its size.
const NARROWEST: usize = 40;

/// Columns for text on standard output.
pub fn width() -> usize {
    terminal::size().map_or(USUAL_WIDTH, |(columns, _)| {
        usize::from(columns).max(NARROWEST)
    })
}

/// The terminal's alternate screen. Dropping it restores the previous content.
pub struct Screen {
    is_coloured: bool,
}

impl Screen {
    /// Switches to the alternate screen, if standard output is a terminal.
    pub fn take() -> Option<Self> {
        if !terminal::can_redraw(&io::stdout()) {
            return None;
        }
        // The alternate screen, with a hidden cursor.
        print("\x1b[?1049h\x1b[?25l").ok()?;
        let is_coloured = terminal::has_colour(&io::stdout());
        Some(Self { is_coloured })
    }

    /// Current number of columns.
    pub fn width(&self) -> usize {
        width()
    }

    /// Draws the lines that fit on the screen.
    ///
    /// # Errors
    /// A terminal that is closed.
    pub fn draw(&self, lines: &[Line]) -> io::Result<()> {
        let rows = terminal::size().map_or(usize::MAX, |(_, rows)| usize::from(rows));
        print(&frame(lines, rows, self.is_coloured))
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // A closed terminal needs no restoring.
        let _ = print("\x1b[?25h\x1b[?1049l");
    }
}

/// Draws from the top left corner, each line to its end, and clears the rest. The last row may count what did not fit.
fn frame(lines: &[Line], rows: usize, is_coloured: bool) -> String {
    let shown = if lines.len() > rows {
        rows.saturating_sub(1)
    } else {
        lines.len()
    };
    let mut frame = String::from("\x1b[H");
    for (k, line) in lines[..shown].iter().enumerate() {
        if k > 0 {
            frame.push_str("\r\n");
        }
        let colour = if is_coloured { colour(line.tone) } else { "" };
        frame.push_str(colour);
        frame.push_str(&line.text);
        if !colour.is_empty() {
            frame.push_str("\x1b[0m");
        }
        frame.push_str("\x1b[K");
    }
    if shown < lines.len() && rows > 0 {
        frame.push_str(&format!("\r\n({} lines more)\x1b[K", lines.len() - shown));
    }
    frame.push_str("\x1b[J");
    frame
}

fn colour(tone: Tone) -> &'static str {
    match tone {
        Tone::Plain => "",
        Tone::Heading => "\x1b[1m",
        Tone::Good => "\x1b[32m",
        Tone::Doubtful => "\x1b[33m",
        Tone::Bad => "\x1b[31m",
    }
}

fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(n: usize) -> Vec<Line> {
        let line = |k| Line {
            text: format!("line {k}"),
            tone: Tone::Bad,
        };
        (0..n).map(line).collect()
    }

    #[test]
    fn what_has_no_room_is_counted() {
        let frame = frame(&lines(10), 4, false);
        assert!(frame.contains("line 2") && !frame.contains("line 3"));
        assert!(frame.contains("(7 lines more)"));
        assert_eq!(frame.matches("\r\n").count(), 3);
    }

    #[test]
    fn colours_end_with_their_line_and_can_be_had_without() {
        assert!(frame(&lines(1), 4, true).contains("\x1b[31mline 0\x1b[0m\x1b[K"));
        assert!(!frame(&lines(1), 4, false).contains("\x1b[31m"));
    }
}
