//! A line of progress on standard error for work of more than two seconds: only on a terminal, never with `--json`,
//! gone at the end.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Work that is shorter shows nothing.
const PATIENCE: Duration = Duration::from_secs(2);
/// Drawings a second.
const DRAWN_HZ: u8 = 5;
const LINE: &str = "[{bar:24}] {pos}/{len} {msg}, {eta} left";

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
    let mut progress = Some(Progress::new(items.len() as u64, what));
    let ends = items.map(Some).chain([None]);
    // The line goes away with the iterator, or when the last item is asked for.
    ends.map_while(move |item| {
        match (&item, &mut progress) {
            (Some(_), Some(progress)) => progress.step(),
            _ => progress = None,
        }
        item
    })
}

/// Work of a known number of steps.
pub struct Progress {
    bar: ProgressBar,
    /// Whether it may be drawn and is not yet.
    is_waiting: bool,
}

impl Progress {
    /// Work that begins now.
    pub fn new(total: u64, what: &'static str) -> Self {
        let hidden = ProgressDrawTarget::hidden();
        let bar = ProgressBar::with_draw_target(Some(total), hidden)
            .with_style(style())
            .with_message(what)
            .with_finish(ProgressFinish::AndClear);
        let is_waiting = !IS_FORBIDDEN.load(Ordering::Relaxed);
        Self { bar, is_waiting }
    }

    /// One step is done.
    pub fn step(&mut self) {
        if self.is_waiting && self.bar.elapsed() >= PATIENCE {
            self.is_waiting = false;
            let target = ProgressDrawTarget::stderr_with_hz(DRAWN_HZ);
            self.bar.set_draw_target(target);
        }
        self.bar.inc(1);
    }
}

/// The line.
fn style() -> ProgressStyle {
    let style = ProgressStyle::with_template(LINE);
    style
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("#--")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_template_of_the_line_is_valid() {
        assert!(ProgressStyle::with_template(LINE).is_ok());
    }

    #[test]
    fn every_item_passes() {
        assert!(over([1, 2, 3].into_iter(), "numbers").eq([1, 2, 3]));
    }
}
