//! The state as lines of text of limited width. 80 columns show everything.

use crate::top::board::Board;
use crate::top::rows::{CameraRow, ObjectRow};
use crate::words;
use sextant_proto::{ClockSource, FusionStatus, Rejections};
use sextant_site_report::State;

/// A line, cut to a width.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// Without control characters.
    pub text: String,
    /// Its colour.
    pub tone: Tone,
}

/// Meaning of a line, which determines its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// Plain text.
    Plain,
    /// A heading.
    Heading,
    /// Everything is in order.
    Good,
    /// A problem that may resolve by itself.
    Doubtful,
    /// A fault.
    Bad,
}

/// The state at `now_ns` in lines of at most `width` characters.
pub fn lines(board: &Board, now_ns: u64, width: usize) -> Vec<Line> {
    let faults = board.faults(now_ns);
    let (cameras, objects) = (board.cameras(now_ns), board.objects(now_ns));
    let fusion = board.fusion(now_ns);
    let counts = [
        counted(cameras.len(), "camera"),
        counted(objects.len(), "object"),
        counted(fusion.len(), "fusion node"),
    ];
    let mut lines = vec![title(board, &counts, faults.len(), now_ns)];
    // First, so that a small terminal shows it, too.
    lines.extend(paragraph("WRONG", Tone::Bad, &faults, width));
    lines.push(line(String::new(), Tone::Plain));
    lines.push(line(cameras_heading(), Tone::Heading));
    lines.extend(cameras.iter().map(|row| camera(row, now_ns)));
    lines.push(line(String::new(), Tone::Plain));
    lines.push(line(objects_heading(), Tone::Heading));
    lines.extend(objects.iter().map(object));
    lines.extend(paragraph(
        "TO KNOW",
        Tone::Plain,
        &board.information(now_ns),
        width,
    ));
    lines.extend(paragraph(
        "NOT TAKEN",
        Tone::Doubtful,
        &refusals(&fusion),
        width,
    ));
    for line in &mut lines {
        line.text = line
            .text
            .chars()
            .take(width)
            .collect::<String>()
            .trim_end()
            .to_owned();
    }
    lines
}

fn cameras_heading() -> String {
    format!(
        "{:<13}{:>6}{:>12}{:>8}  {:<12}{:>9}{:>9}{:>8}",
        "CAMERA", "per s", "detect ms", "dropped", "clock", "error", "offset", "age ms"
    )
}

fn objects_heading() -> String {
    format!(
        "{:<13}{:<13}{:>6}{:>22}{:>13}{:>4}{:>4}{:>5}",
        "OBJECT", "state", "per s", "x y z mm", "sigma mm deg", "cam", "tag", "ms"
    )
}

/// A heading with faults by source; nothing without faults.
fn paragraph(name: &str, tone: Tone, said: &[(String, String)], width: usize) -> Vec<Line> {
    if said.is_empty() {
        return Vec::new();
    }
    let mut lines = vec![
        line(String::new(), Tone::Plain),
        line(name.to_owned(), Tone::Heading),
    ];
    for (from, words) in said {
        let texts = wrapped(&format!("{from}: {words}"), width).into_iter();
        lines.extend(texts.map(|text| line(text, tone)));
    }
    lines
}

fn line(text: String, tone: Tone) -> Line {
    Line { text, tone }
}

fn title(board: &Board, counts: &[String], faults: usize, now_ns: u64) -> Line {
    let text = format!(
        "site {}  {} UTC  {}{}",
        board.keys.site(),
        &words::time_of_day(now_ns)[..8],
        counts.join(", "),
        match faults {
            0 => ", nothing wrong".to_owned(),
            faults => format!(", {} wrong", counted(faults, "thing")),
        }
    );
    line(text, if faults == 0 { Tone::Good } else { Tone::Bad })
}

fn counted(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

/// Row of a camera or object that has left.
fn gone(id: &str, since_ns: u64) -> Line {
    let since = &words::time_of_day(since_ns)[..8];
    let text = format!("{:<13}gone since {since} UTC", shortened(id, 12));
    line(text, Tone::Doubtful)
}

fn camera(row: &CameraRow<'_>, now_ns: u64) -> Line {
    if let Some(since_ns) = row.gone_ns {
        return gone(row.id.as_str(), since_ns);
    }
    let age_ms = |capture_ns: u64| now_ns.saturating_sub(capture_ns) as f64 * 1e-6;
    let number = |value: Option<String>| value.unwrap_or_else(|| "-".to_owned());
    let status = row.status;
    // Images of a recording have the age of the recording, which is nobody's fault.
    let is_recorded = status.is_some_and(|s| s.clock.source == ClockSource::Recorded);
    let captured_ns = row.last_capture_ns.filter(|_| !is_recorded);
    let intake = row.intake.map(|intake| intake.rate_hz);
    let rate = status.map(|status| status.rate_hz).or(intake);
    let text = format!(
        "{:<13}{:>6}{:>12}{:>8}  {:<12}{:>9}{:>9}{:>8}",
        shortened(row.id.as_str(), 12),
        number(rate.map(|rate| format!("{rate:.1}"))),
        number(status.map(|s| format!("{:.1}/{:.1}", s.detect_ms[0], s.detect_ms[1]))),
        number(status.map(|s| s.dropped.to_string())),
        number(status.map(|s| s.clock.source.name().to_owned())),
        number(status.map(|s| milliseconds(s.clock.error_ns as f64 / 1e6))),
        number(
            row.clock
                .map(|clock| format!("{:+.1}ms", clock.offset_s * 1e3))
        ),
        number(captured_ns.map(|at| words::age_ms(age_ms(at), 0))),
    );
    line(
        text,
        match row.lacks_images {
            true => Tone::Doubtful,
            false => Tone::Plain,
        },
    )
}

fn milliseconds(ms: f64) -> String {
    match ms {
        ms if ms >= 1000.0 => format!("{:.0}s", ms / 1e3),
        ms if ms >= 10.0 => format!("{ms:.0}ms"),
        ms => format!("{ms:.2}ms"),
    }
}

fn object(row: &ObjectRow<'_>) -> Line {
    if let Some(since_ns) = row.gone_ns {
        return gone(row.id.as_str(), since_ns);
    }
    let tone = match row.state {
        State::Tracking => Tone::Plain,
        State::Initialising | State::Coasting | State::Lost => Tone::Doubtful,
    };
    let begin = format!(
        "{:<13}{:<13}",
        shortened(row.id.as_str(), 12),
        words::state(row.state)
    );
    let Some(pose) = row.pose else {
        return line(format!("{begin}{:>6}", "-"), tone);
    };
    let [x, y, z] = pose.position.map(|metres| metres * 1e3);
    let latency_ms = latency_ms(pose.capture_ns, pose.published_ns);
    let text = format!(
        "{begin}{:>6.1}{:>22}{:>13}{:>4}{:>4}{:>5}",
        row.rate_hz,
        format!("{x:.1} {y:.1} {z:.1}"),
        format!(
            "{} {}",
            sigma(&pose.covariance, 0, 1e3),
            sigma(&pose.covariance, 3, 180.0 / std::f64::consts::PI)
        ),
        pose.cameras,
        pose.tags,
        match latency_ms.abs() < 1e7 {
            true => words::age_ms(latency_ms.clamp(-999.0, 9999.0), 0),
            // A recording's, or by a wrong clock, which is reported where it is a fault.
            false => "-".to_owned(),
        },
    );
    line(text, tone)
}

/// From the middle of the exposure to the pose; negative where the clocks disagree by more than the latency.
pub fn latency_ms(capture_ns: u64, published_ns: u64) -> f64 {
    (i128::from(published_ns) - i128::from(capture_ns)) as f64 / 1e6
}

/// Expected length of the error of position (`from` 0) or attitude (`from` 3).
pub fn sigma_of(covariance: &[f64; 36], from: usize) -> f64 {
    let variances = (from..from + 3).map(|k| covariance[k * 7].max(0.0));
    variances.sum::<f64>().sqrt()
}

fn sigma(covariance: &[f64; 36], from: usize, scale: f64) -> String {
    match sigma_of(covariance, from) * scale {
        large if large >= 100.0 => format!("{large:.0}"),
        middle if middle >= 10.0 => format!("{middle:.1}"),
        small => format!("{small:.2}"),
    }
}

/// Observations that the fusion nodes rejected, by camera.
fn refusals(fusion: &[&FusionStatus]) -> Vec<(String, String)> {
    let mut refusals = Vec::new();
    for status in fusion {
        for camera in &status.cameras {
            let mut parts = Vec::new();
            if camera.rejected.total() > 0 {
                parts.push(format!(
                    "{} payloads ({})",
                    camera.rejected.total(),
                    causes(&camera.rejected)
                ));
            }
            if camera.late > 0 {
                parts.push(format!("{} images too late", camera.late));
            }
            if camera.gated > 0 {
                parts.push(format!("{} tags rejected", camera.gated));
            }
            if !parts.is_empty() {
                refusals.push((camera.camera.to_string(), parts.join(", ")));
            }
        }
        if status.foreign.total() > 0 {
            let words = format!(
                "{} payloads ({})",
                status.foreign.total(),
                causes(&status.foreign)
            );
            refusals.push(("cameras that the rig lacks".to_owned(), words));
        }
    }
    refusals
}

fn causes(rejected: &Rejections) -> String {
    let named = [
        ("no payload of ours", rejected.bad_magic),
        ("another version", rejected.foreign_version),
        ("wrong kind", rejected.wrong_kind),
        ("damaged", rejected.damaged),
        ("too long", rejected.too_long),
        ("out of range", rejected.out_of_range),
        ("wrong camera", rejected.wrong_camera),
    ];
    let some = named.iter().filter(|(_, count)| *count > 0);
    let said = some.map(|(name, count)| format!("{name} {count}"));
    said.collect::<Vec<_>>().join(", ")
}

fn shortened(name: &str, most: usize) -> String {
    if name.len() <= most {
        return name.to_owned();
    }
    name.chars()
        .take(most.saturating_sub(1))
        .chain(['~'])
        .collect()
}

/// A sentence wrapped into lines, indented from the second on.
fn wrapped(sentence: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::from(" ")];
    for word in sentence.split_whitespace() {
        let Some(last) = lines.last_mut() else { break };
        if last.trim().is_empty() || last.chars().count() + 1 + word.chars().count() <= width {
            last.push(' ');
            last.push_str(word);
        } else {
            lines.push(format!("    {word}"));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::top::board::tests::{NOW_NS, board, left_board};

    fn text(width: usize) -> String {
        let lines = lines(&board(), NOW_NS, width);
        let texts: Vec<String> = lines.into_iter().map(|line| line.text).collect();
        texts.join("\n")
    }

    #[test]
    fn eighty_columns_show_everything() {
        let text = text(80);
        for part in [
            "site lab  08:00:00 UTC  1 camera, 2 objects, 1 fusion node, 1 thing wrong",
            "north          29.9     3.2/4.5      10  ntp            0.25ms  -12.5ms      40",
            "cube         tracking       30.",
            "100.0 -200.0 300.0    0.17 0.01   3   5   20",
            "ball         lost              -",
            "  fusion: camera north is not where the rig says",
            "  north: 2 payloads (damaged 2), 8 images too late, 10 tags rejected",
        ] {
            assert!(text.contains(part), "{part}\nis not in\n{text}");
        }
    }

    #[test]
    fn who_left_is_shown_with_the_time() {
        let lines = lines(&left_board(), NOW_NS + 10_000_000_000, 80);
        let texts: Vec<String> = lines.into_iter().map(|line| line.text).collect();
        for part in [
            "north        gone since 08:00:00 UTC",
            "cube         gone since 08:00:01 UTC",
        ] {
            assert!(
                texts.iter().any(|text| text == part),
                "{part}\nis not in\n{texts:#?}"
            );
        }
    }

    #[test]
    fn no_line_is_wider_than_asked_for() {
        for width in [40, 60, 80, 200] {
            for line in text(width).lines() {
                assert!(line.chars().count() <= width, "{width}: {line}");
            }
        }
    }

    #[test]
    fn long_sentences_are_wrapped_between_words() {
        assert_eq!(
            wrapped("a: one two three four", 12),
            ["  a: one two", "    three", "    four"]
        );
        assert_eq!(wrapped(&"x".repeat(30), 12).len(), 1);
    }
}
