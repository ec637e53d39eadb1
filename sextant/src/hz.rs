//! `sextant hz`: how often and how late messages come.

use crate::message_text::capture_ns;
use crate::output::{Format, print_line};
use crate::site::{SiteArguments, expression, report_router};
use crate::words;
use clap::Args;
use serde_json::json;
use sextant_gateways::site::RouterWatch;
use sextant_process::now_ns;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_proto::{AnyMessage, limits};
use sextant_zenoh_bus::{DropRule, Item, Payload};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Messages that wait while a report is made; the oldest give way.
const QUEUE: usize = 8192;
/// Keys that are counted; a flood of invented keys must not fill the memory.
const MAX_KEYS: usize = 4096;

/// Arguments of `sextant hz`.
#[derive(Args, Debug)]
#[command(
    after_help = "With --json, one line per report: {\"seconds\",\"keys\":[{\"key\",\"messages\",\"rate_hz\",
\"bytes_per_s\",\"latency_ms\":{\"p50\",\"p99\"},\"refused\"}]}. Latency is the time from capture to this command, by
the clocks of both machines; null if a message has no capture time. Stop with Ctrl-C."
)]
pub struct HzArguments {
    /// A camera, an object, a node, or a key (`object/*/pose`); everything when absent.
    #[arg(value_name = "NAME|KEY")]
    what: Option<String>,
    /// Seconds between two reports.
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    every: f64,
    /// End after this number of reports.
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    #[command(flatten)]
    site: SiteArguments,
}

/// Runs `sextant hz`.
///
/// # Errors
/// No router, or a key that is none.
pub fn run(arguments: &HzArguments, format: Format) -> anyhow::Result<()> {
    let period = Duration::try_from_secs_f64(arguments.every)?.max(SHUTDOWN_POLL);
    let site = arguments.site.open()?;
    let expression = match &arguments.what {
        Some(said) => expression(&site.keys, said),
        None => site.keys.everything(),
    };
    let messages = site.bus.subscribe(
        &expression,
        QUEUE,
        DropRule::Oldest,
        limits::MAX_PAYLOAD_BYTES,
    )?;
    let mut left = arguments.count.unwrap_or(u64::MAX);
    let mut router = RouterWatch::default();
    while left > 0 && !site.shutdown.is_requested() {
        let (start, mut counts) = (Instant::now(), BTreeMap::new());
        while start.elapsed() < period && !site.shutdown.is_requested() {
            if let Some(item) = messages.recv_timeout(SHUTDOWN_POLL) {
                count(&mut counts, &item);
            }
        }
        report_router(&mut router, &site.bus);
        print_line(&report(&mut counts, start.elapsed().as_secs_f64(), format))?;
        left -= 1;
    }
    site.bus.close();
    Ok(())
}

/// Messages of one key during one report.
#[derive(Debug, Default)]
struct Count {
    messages: u64,
    bytes: u64,
    refused: u64,
    latencies_ms: Vec<f64>,
}

fn count(counts: &mut BTreeMap<String, Count>, item: &Item) {
    let now = now_ns();
    if counts.len() >= MAX_KEYS && !counts.contains_key(&item.key) {
        return;
    }
    let count = counts.entry(item.key.clone()).or_default();
    count.messages += 1;
    match &item.payload {
        Payload::TooLong(length) => {
            count.bytes += *length as u64;
            count.refused += 1;
        }
        Payload::Bytes(bytes) => {
            count.bytes += bytes.len() as u64;
            match AnyMessage::decode(bytes) {
                Err(_) => count.refused += 1,
                Ok(message) => count.latencies_ms.extend(
                    capture_ns(&message).map(|capture| (now as f64 - capture as f64) / 1e6),
                ),
            }
        }
    }
}

impl Count {
    /// Median and 99th percentile.
    fn latency_ms(&mut self) -> Option<(f64, f64)> {
        self.latencies_ms.sort_by(f64::total_cmp);
        let last = self.latencies_ms.len().checked_sub(1)?;
        let at = |fraction: f64| self.latencies_ms[(last as f64 * fraction).round() as usize];
        Some((at(0.5), at(0.99)))
    }
}

fn report(counts: &mut BTreeMap<String, Count>, seconds: f64, format: Format) -> String {
    match format {
        Format::Json => json_report(counts, seconds),
        Format::Text => text_report(counts, seconds),
    }
}

fn json_report(counts: &mut BTreeMap<String, Count>, seconds: f64) -> String {
    let keys = counts.iter_mut().map(|(key, count)| {
        let latency = count
            .latency_ms()
            .map(|(p50, p99)| json!({"p50": p50, "p99": p99}));
        json!({
            "key": key, "messages": count.messages, "rate_hz": count.messages as f64 / seconds,
            "bytes_per_s": count.bytes as f64 / seconds, "latency_ms": latency, "refused": count.refused,
        })
    });
    json!({"seconds": seconds, "keys": keys.collect::<Vec<_>>()}).to_string()
}

fn text_report(counts: &mut BTreeMap<String, Count>, seconds: f64) -> String {
    let mut lines = vec![format!(
        "{:<40} {:>8} {:>10} {:>18}",
        "key", "per s", "kB/s", "latency ms 50/99%"
    )];
    for (key, count) in counts {
        let latency = count
            .latency_ms()
            .map(|(p50, p99)| format!("{} / {}", words::age_ms(p50, 1), words::age_ms(p99, 1)));
        let refused = match count.refused {
            0 => String::new(),
            refused => format!("  {refused} refused"),
        };
        lines.push(format!(
            "{:<40} {:>8.1} {:>10.1} {:>18}{refused}",
            words::plain(crate::echo::short(key)),
            count.messages as f64 / seconds,
            count.bytes as f64 / seconds / 1e3,
            latency.unwrap_or_else(|| "-".into())
        ));
    }
    if lines.len() == 1 {
        lines.push("nothing came; `sextant list` says what is there".to_owned());
    }
    lines.push(String::new());
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_sorted_latencies() {
        let mut count = Count {
            latencies_ms: (0..=100).rev().map(f64::from).collect(),
            ..Count::default()
        };
        assert_eq!(count.latency_ms(), Some((50.0, 99.0)));
        assert_eq!(Count::default().latency_ms(), None);
    }

    #[test]
    fn what_is_no_message_is_counted_as_refused() {
        let mut counts = BTreeMap::new();
        let key = "sextant/v1/demo/camera/north/observations".to_owned();
        for payload in [Payload::Bytes(vec![1, 2, 3]), Payload::TooLong(1 << 20)] {
            let item = Item {
                key: key.clone(),
                payload,
                sender: None,
            };
            count(&mut counts, &item);
        }
        let count = &counts[&key];
        assert_eq!(
            (count.messages, count.refused, count.bytes),
            (2, 2, 3 + (1 << 20))
        );
    }
}
