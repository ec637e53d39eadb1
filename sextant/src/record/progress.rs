//! How far a recording is: a line redrawn in place on a terminal, nothing elsewhere, and the figures at the end.

use crate::output::{Format, print_line};
use serde::Serialize;
use std::io::{self, IsTerminal, Write};
use std::path::Path;

/// Figures of a recording.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// For programs: which line this is.
    pub event: &'static str,
    /// The file.
    pub file: String,
    /// Duration so far.
    pub seconds: f64,
    /// Messages in the file, those for viewers included.
    pub messages: u64,
    /// Images received from shared memory.
    pub images: u64,
    /// Bytes in the file.
    pub bytes: u64,
    /// Messages and images that were not written: the disk was too slow, or they were damaged.
    pub dropped: u64,
    /// Images that came faster than they could be compressed.
    pub missed_images: u64,
}

impl Figures {
    /// The figures in one line, for people.
    pub fn text(&self) -> String {
        let seconds = self.seconds.max(1e-3);
        let megabytes = self.bytes as f64 / 1e6;
        let mut text = format!(
            "{:.1} s, {megabytes:.1} MB ({:.1} MB/s), {} messages ({:.0}/s)",
            self.seconds,
            megabytes / seconds,
            self.messages,
            self.messages as f64 / seconds
        );
        if self.images > 0 {
            text.push_str(&format!(
                ", {} images ({:.0}/s)",
                self.images,
                self.images as f64 / seconds
            ));
        }
        if self.missed_images > 0 {
            text.push_str(&format!(", {} images missed", self.missed_images));
        }
        if self.dropped > 0 {
            text.push_str(&format!(", {} dropped", self.dropped));
        }
        text
    }
}

/// The line on standard error that shows how a recording goes.
pub struct ProgressLine {
    format: Format,
    is_drawn: bool,
}

impl ProgressLine {
    /// A line for this output format.
    pub fn new(format: Format) -> Self {
        Self {
            format,
            is_drawn: false,
        }
    }

    /// The recording has begun.
    ///
    /// # Errors
    /// A closed output.
    pub fn begin(&self, file: &Path) -> io::Result<()> {
        match self.format {
            Format::Text => {
                eprintln!("recording into {}; Ctrl-C ends it", file.display());
                Ok(())
            }
            Format::Json => {
                let file = file.display().to_string();
                let line = serde_json::json!({ "event": "recording", "file": file });
                print_line(&line.to_string())
            }
        }
    }

    /// Shows figures, on a terminal.
    ///
    /// # Errors
    /// A closed output.
    pub fn show(&mut self, figures: &Figures) -> io::Result<()> {
        let mut out = io::stderr().lock();
        if self.format == Format::Json || !out.is_terminal() {
            return Ok(());
        }
        self.is_drawn = true;
        write!(out, "\r\x1b[K{}", figures.text())?;
        out.flush()
    }

    /// Removes the line from the terminal.
    pub fn end(&mut self) {
        if std::mem::take(&mut self.is_drawn) {
            eprint!("\r\x1b[K");
        }
    }
}
