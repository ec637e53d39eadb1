//! Logging of a process: `tracing` to stderr, one line an event. `SEXTANT_LOG` (else `RUST_LOG`) filters in the syntax of
//! `tracing-subscriber`; colour only on a terminal and never with `NO_COLOR`. Stdout stays free for results.

use std::io::IsTerminal;

use tracing::{Event, Subscriber};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::format::{Format, Full, Writer};
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields};
use tracing_subscriber::registry::LookupSpan;

/// What is logged when no environment variable says otherwise: our own events, and only complaints of the libraries.
const DEFAULT_FILTER: &str = "info,zenoh=error,iceoryx2=error";

/// Starts logging; `role` (as "camera north detect") stands at the head of each line when several processes share a
/// terminal. A second call changes nothing.
pub fn init(role: &str) {
    let colour = std::io::stderr().is_terminal()
        && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let subscriber = tracing_subscriber::fmt()
        .with_env_filter(filter())
        .with_writer(std::io::stderr)
        .with_ansi(colour)
        .event_format(Headed {
            role: role.to_owned(),
            line: Format::default().with_target(false),
        })
        .finish();
    // The second call of a process finds a subscriber and leaves it.
    let _ = tracing::subscriber::set_global_default(subscriber);
}

/// The line of `tracing-subscriber` behind the name of the process.
struct Headed {
    role: String,
    line: Format<Full>,
}

impl<S, N> FormatEvent<S, N> for Headed
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
        if !self.role.is_empty() {
            write!(writer, "[{}] ", self.role)?;
        }
        self.line.format_event(context, writer, event)
    }
}

fn filter() -> EnvFilter {
    ["SEXTANT_LOG", "RUST_LOG"]
        .iter()
        .filter_map(|name| EnvFilter::try_from_env(name).ok())
        .next()
        .unwrap_or_else(|| EnvFilter::new(DEFAULT_FILTER))
}
