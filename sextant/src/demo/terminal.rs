//! Terminal output of the demo: address of the page, true errors, final summary.

use crate::demo::Summary;
use crate::output::Format;
use sextant_evaluation::live::{LiveScore, ObjectSummary};
use sextant_process::terminal;
use sextant_proto::CameraStatus;
use sextant_simulator::Imperfections;
use sextant_site_model::CameraId;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::time::{Duration, Instant};

const REFRESH: Duration = Duration::from_millis(500);
const REPORT: Duration = Duration::from_secs(5);

/// Terminal output of one demo.
#[derive(Debug, Clone)]
pub struct Terminal {
    format: Format,
    is_live: bool,
    lines_shown: Cell<usize>,
    due: Cell<Instant>,
}

impl Terminal {
    /// A table that is redrawn on a terminal, an occasional report elsewhere, JSON lines with `--json`.
    pub fn new(format: Format) -> Self {
        let is_live = terminal::can_redraw(&std::io::stdout());
        Self {
            format,
            is_live,
            lines_shown: Cell::new(0),
            due: Cell::new(Instant::now()),
        }
    }

    /// Reports that all nodes are ready.
    pub fn ready(
        &self,
        url: &str,
        browser_opened: bool,
        router: &str,
        processes: &[(String, u32)],
    ) {
        if self.format == Format::Json {
            let processes: BTreeMap<&str, u32> = processes
                .iter()
                .map(|(name, id)| (name.as_str(), *id))
                .collect();
            let ready = serde_json::json!({
                "event": "ready", "page": url, "connect": router, "processes": processes,
            });
            say(&ready.to_string());
            return;
        }
        let opened = if browser_opened {
            " (opened in your browser)"
        } else {
            ""
        };
        say(&format!(
            "\n  Sextant is running: {} processes, no hardware.\n",
            processes.len()
        ));
        say(&format!("    page      {url}{opened}"));
        say(&format!(
            "    poses     sextant echo --connect {router} OBJECT"
        ));
        say("    stop      Ctrl-C\n");
    }

    /// Describes the errors of the site's files.
    pub fn imperfect(&self, errors: &Imperfections) {
        if self.format == Format::Json {
            return;
        }
        say(&format!(
            "  The site's files are off as hand-made ones are: cameras {:.0} mm and {:.1} deg an \
             axis, focal lengths {:.1} %,",
            errors.camera_position * 1e3,
            errors.camera_rotation.to_degrees(),
            errors.focal * 1e2,
        ));
        say(&format!(
            "  tags {:.1} mm and {:.1} deg, prints {:.1} %. Fusion learns that from the images; \
             --exact is a site without errors.\n",
            errors.tag_position * 1e3,
            errors.tag_rotation.to_degrees(),
            errors.print_scale * 1e2,
        ));
    }

    /// Reports the current state, when it is due.
    pub fn show(&self, score: &LiveScore, cameras: &BTreeMap<CameraId, CameraStatus>) {
        if self.format == Format::Json || Instant::now() < self.due.get() {
            return;
        }
        self.due
            .set(Instant::now() + if self.is_live { REFRESH } else { REPORT });
        let table = table(&score.objects(), score.latency().p99, cameras);
        if self.is_live && self.lines_shown.get() > 0 {
            say_raw(&format!("\x1b[{}A\x1b[J", self.lines_shown.get()));
        }
        self.lines_shown.set(table.lines().count());
        say_raw(&table);
    }

    /// Prints the summary as the last line.
    ///
    /// # Errors
    /// Never for the numbers of a summary.
    pub fn summary(&self, summary: &Summary) -> serde_json::Result<()> {
        if self.format == Format::Json {
            say(&serde_json::to_string(summary)?);
            return Ok(());
        }
        let captured: u64 = summary.cameras.iter().map(|camera| camera.captured).sum();
        let dropped: u64 = summary.cameras.iter().map(|camera| camera.dropped).sum();
        let mut text = String::from("\n");
        write_objects(&mut text, &summary.objects);
        let _ = writeln!(
            text,
            "\n  {captured} images captured, {dropped} dropped; capture to pose {}",
            latency_text(summary.latency_ms.p99)
        );
        say_raw(&text);
        Ok(())
    }
}

fn table(
    objects: &[ObjectSummary],
    p99_ms: Option<f64>,
    cameras: &BTreeMap<CameraId, CameraStatus>,
) -> String {
    let mut text = String::new();
    write_objects(&mut text, objects);
    text.push('\n');
    for (id, status) in cameras {
        let [p50, _] = status.detect_ms;
        let _ = writeln!(
            text,
            "  camera {id:<10} {:>5.1} images/s   detection {p50:>5.2} ms   dropped {}",
            status.rate_hz, status.dropped
        );
    }
    let _ = writeln!(text, "  capture to pose {}\n", latency_text(p99_ms));
    text
}

fn write_objects(text: &mut String, objects: &[ObjectSummary]) {
    let _ = writeln!(
        text,
        "  {:<12} {:>8} {:>9} {:>14} {:>10} {:>14} {:>10}",
        "object", "poses", "covered", "true error", "sigma", "true error", "sigma"
    );
    for object in objects {
        let number = |value: Option<f64>, unit: &str| {
            value.map_or_else(|| "-".to_owned(), |v| format!("{v:.3} {unit}"))
        };
        let position = number(object.position_rms_mm, "mm");
        let position_sigma = number(object.position_sigma_mm, "mm");
        let attitude = number(object.attitude_rms_deg, "deg");
        let attitude_sigma = number(object.attitude_sigma_deg, "deg");
        let covered = format!("{:.1} %", object.coverage * 100.0);
        let _ = writeln!(
            text,
            "  {:<12} {:>8} {covered:>9} {position:>14} {position_sigma:>10} {attitude:>14} {attitude_sigma:>10}",
            object.id, object.poses
        );
    }
}

fn latency_text(p99_ms: Option<f64>) -> String {
    p99_ms.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.1} ms (99 %)"))
}

fn say(line: &str) {
    say_raw(&format!("{line}\n"));
}

/// A closed standard output is ignored: the demo can also be watched on the page.
fn say_raw(text: &str) {
    let mut stdout = std::io::stdout().lock();
    let _ = stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush());
}
