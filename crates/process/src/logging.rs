//! Logging of a process: `tracing` to stderr, one line per event. `SEXTANT_LOG` (else `RUST_LOG`) filters by level and
//! part, as in `info,zenoh=debug`; colour only on a terminal and never with `NO_COLOR`. Stdout is reserved for results.
//!
//! A log statement prints at most ten lines at once, then one per half minute with the number of omitted ones. Debug
//! and trace are not limited. A line that cannot be written whole, as on a full disk, is omitted.

mod refusals;

use std::fs::File;
use std::io;
use std::os::fd::AsFd;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use tracing::callsite::Identifier;
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::fmt::format::{Format, Full, Writer};
use tracing_subscriber::fmt::time::{FormatTime, SystemTime};
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::registry::LookupSpan;

use crate::rate_limit::RateLimit;
use crate::terminal;
use crate::whole_lines::write_line;

use self::refusals::Wording;

/// Default filter: our own events, warnings of libraries, and refused connections
/// ([`refusals`]).
const DEFAULT_FILTER: &str = "info,zenoh=error,iceoryx2=error";

/// Starts logging; `role` (such as "camera north detect") is the prefix of each line when several processes share a
/// terminal. A second call changes nothing.
pub fn init(role: &str) {
    let wanted = filter_of_a_person();
    let is_filtered_by_a_person = wanted.is_some();
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(|| StandardError)
        .with_ansi(terminal::has_colour(&io::stderr()))
        .event_format(NamedFormat {
            role: role.to_owned(),
            line: Format::default().with_target(false),
            limit: RateLimit::new(),
            is_filtered_by_a_person,
        });
    let subscriber = tracing_subscriber::registry()
        .with(wanted.unwrap_or_else(usual_filter))
        .with(lines);
    // A second call finds a subscriber and keeps it.
    let _ = tracing::subscriber::set_global_default(subscriber);
}

/// The line of `tracing-subscriber` after the name of the process.
struct NamedFormat {
    role: String,
    line: Format<Full>,
    limit: RateLimit<Identifier>,
    is_filtered_by_a_person: bool,
}

impl NamedFormat {
    /// Number of omitted lines of this log statement; `None` if this one is to be omitted as well.
    fn admit(&self, event: &Event<'_>) -> Option<u64> {
        let metadata = event.metadata();
        if *metadata.level() > Level::INFO && self.is_filtered_by_a_person {
            return Some(0);
        }
        self.limit.admit(metadata.callsite(), Instant::now())
    }
}

impl<S, N> FormatEvent<S, N> for NamedFormat
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    N: for<'a> FormatFields<'a> + 'static,
{
    fn format_event(
        &self,
        context: &FmtContext<'_, S, N>,
        mut writer: Writer<'_>,
        event: &Event<'_>,
    ) -> std::fmt::Result {
        let wording = refusals::wording(event);
        if wording == Wording::Beside && !self.is_filtered_by_a_person {
            return Ok(());
        }
        let Some(left_out) = self.admit(event) else {
            return Ok(());
        };
        if !self.role.is_empty() {
            write!(writer, "[{}] ", self.role)?;
        }
        if left_out > 0 {
            write!(writer, "({left_out} like this left out) ")?;
        }
        match wording {
            Wording::Instead(words) => {
                SystemTime.format_time(&mut writer)?;
                writeln!(writer, "  WARN {words}")
            }
            Wording::Own | Wording::Beside => self.line.format_event(context, writer, event),
        }
    }
}

/// Standard error, one write per line. Never fails, since a failure could not be reported.
struct StandardError;

impl io::Write for StandardError {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        static LINES: Mutex<()> = Mutex::new(());
        let _one_at_a_time = LINES.lock().unwrap_or_else(PoisonError::into_inner);
        if let Ok(stderr) = io::stderr().as_fd().try_clone_to_owned() {
            let _ = write_line(&File::from(stderr), line);
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn filter_of_a_person() -> Option<Targets> {
    let set = |name: &&str| std::env::var(name).ok()?.parse().ok();
    ["SEXTANT_LOG", "RUST_LOG"].iter().find_map(set)
}

fn usual_filter() -> Targets {
    format!("{DEFAULT_FILTER},{}", refusals::FILTER)
        .parse()
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    #[test]
    fn by_default_libraries_are_quiet_but_for_refusals() {
        let filter = usual_filter();
        assert!(filter.would_enable("node_camera::detect", &Level::INFO));
        assert!(!filter.would_enable("zenoh::api", &Level::WARN));
        assert!(filter.would_enable("zenoh_link_commons::quic", &Level::WARN));
    }

    /// Runs this test again as a process of its own and captures its standard error.
    #[test]
    fn a_warning_with_every_image_is_logged_a_few_times() {
        const CHILD: &str = "SEXTANT_TEST_FLOOD";
        const NAME: &str = "logging::tests::a_warning_with_every_image_is_logged_a_few_times";
        if std::env::var_os(CHILD).is_some() {
            init("north");
            (0..1000).for_each(|image| tracing::warn!(image, "it is too dark"));
            tracing::warn!("it is another thing");
            return;
        }
        let child = Command::new(std::env::current_exe().unwrap())
            .args([NAME, "--exact", "--nocapture"])
            .env(CHILD, "1")
            .env("SEXTANT_LOG", "info")
            .output()
            .unwrap();
        let log = String::from_utf8(child.stderr).unwrap();
        let lines = |what| log.lines().filter(|line| line.contains(what)).count();
        assert_eq!(lines("it is too dark"), 10, "{log}");
        assert_eq!(lines("it is another thing"), 1, "{log}");
    }
}
