//! A line of progress on standard error for work of more than two seconds: only on a terminal, never with `--json`, gone at the end.

use sextant_process::terminal;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Work that is shorter shows nothing.
const PATIENCE: Duration = Duration::from_secs(2);
/// Between two drawings.
const REDRAWN: Duration = Duration::from_millis(200);
/// Characters of a full bar.
const WIDTH: u64 = 24;

static IS_FORBIDDEN: AtomicBool = AtomicBool::new(false);

/// Shows no progress in this process: its output is for programs.
pub fn forbid() {
    IS_FORBIDDEN.store(true, Ordering::Relaxed);
}

/// The items, with a line of progress while they are taken.
pub fn over<I: ExactSizeIterator>(
    items: I,
    what: &'static str,
) -> impl Iterator<Item = I::Item> + use<I> {
    let mut progress = Progress::new(items.len() as u64, what);
    let mut items = items;
    // The line goes away with the closure, or when the last item is asked for.
    std::iter::from_fn(move || {
        let item = items.next();
        match item {
            Some(_) => progress.step(),
            None => progress.clear(),
        }
        item
    })
}

/// Work of a known number of steps.
pub struct Progress {
    total: u64,
    what: &'static str,
    done: u64,
    start: Instant,
    due: Instant,
    is_visible: bool,
    is_drawn: bool,
}

impl Progress {
    /// Work that begins now.
    pub fn new(total: u64, what: &'static str) -> Self {
        let is_allowed = !IS_FORBIDDEN.load(Ordering::Relaxed);
        let start = Instant::now();
        Self {
            total,
            what,
            done: 0,
            start,
            due: start + PATIENCE,
            is_visible: is_allowed && terminal::can_redraw(&io::stderr()),
            is_drawn: false,
        }
    }

    /// One step is done.
    pub fn step(&mut self) {
        self.done += 1;
        let now = Instant::now();
        if self.is_visible && now >= self.due {
            self.due = now + REDRAWN;
            self.is_drawn = true;
            let line = line(self.done, self.total, self.what, self.start.elapsed());
            // A terminal that is gone needs no progress.
            let _ = write!(io::stderr(), "\r{line}\x1b[K");
        }
    }

    fn clear(&mut self) {
        if std::mem::take(&mut self.is_drawn) {
            let _ = write!(io::stderr(), "\r\x1b[K");
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

fn line(done: u64, total: u64, what: &str, elapsed: Duration) -> String {
    let total = total.max(done).max(1);
    let full = (done * WIDTH / total) as usize;
    let bar = "#".repeat(full) + &"-".repeat(WIDTH as usize - full);
    let left = elapsed.as_secs_f64() * (total - done) as f64 / done.max(1) as f64;
    format!("[{bar}] {done}/{total} {what}, {left:.0} s left")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_the_share_and_the_time_left() {
        let half = line(50, 100, "images", Duration::from_secs(10));
        assert_eq!(half, "[############------------] 50/100 images, 10 s left");
        let end = line(7, 7, "images", Duration::from_secs(10));
        assert_eq!(end, "[########################] 7/7 images, 0 s left");
        assert!(line(0, 0, "images", Duration::ZERO).contains("0/1"));
    }

    #[test]
    fn every_item_passes() {
        assert!(over([1, 2, 3].into_iter(), "numbers").eq([1, 2, 3]));
    }
}
