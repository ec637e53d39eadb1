//! Words for people: states, and text from elsewhere made harmless for a terminal.

pub use sextant_process::terminal::plain;

use serde::Serialize;
use serde_json::Value;
use sextant_calibrator::{Finding, HeldOutImages, Verdict};
use sextant_proto::{CameraStatus, ChangeOutcome, FusionStatus, Notice, SettingsOutcome};
use sextant_site_model::ObjectId;
use sextant_site_report::{Severity, State};
use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::mem::{Discriminant, discriminant};

/// The state in one word.
pub fn state(state: State) -> &'static str {
    match state {
        State::Initialising => "initialising",
        State::Tracking => "tracking",
        State::Coasting => "coasting",
        State::Lost => "lost",
    }
}

/// The residual of images that had no part in a solution.
pub fn held_out(held_out: &HeldOutImages) -> String {
    format!(
        "{} images were held out: off by {:.3} px where the others were solved without them, and by {:.3} px where \
         they had a part.",
        held_out.images, held_out.rms_px, held_out.used_rms_px
    )
}

/// What a node reports.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeFinding {
    /// The node.
    pub from: String,
    pub severity: Severity,
    /// A sentence.
    pub words: String,
}

/// Faults, imperfections and notices of a fusion node.
pub fn findings(status: &FusionStatus) -> Vec<NodeFinding> {
    let findings = keyed_findings(status).into_iter();
    findings.map(|(_, finding)| finding).collect()
}

/// Most findings of one kind that a verdict lists.
const MOST_OF_A_KIND: usize = 6;

/// What limits a calibration, a line each; of many of one kind the first, and how many more there are.
pub fn reasons(verdict: &Verdict) -> Vec<String> {
    let mut kinds: Vec<(Discriminant<Finding>, Vec<&Finding>)> = Vec::new();
    for finding in &verdict.because {
        let kind = discriminant(finding);
        match kinds.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, findings)) => findings.push(finding),
            None => kinds.push((kind, vec![finding])),
        }
    }
    let mut lines = Vec::new();
    for (_, findings) in kinds {
        let listed = findings.iter().take(MOST_OF_A_KIND);
        lines.extend(listed.map(|finding| format!("  - {finding}")));
        if let Some(more) = findings
            .len()
            .checked_sub(MOST_OF_A_KIND)
            .filter(|more| *more > 0)
        {
            lines.push(format!(
                "    and {more} more of this kind; --json lists all"
            ));
        }
    }
    lines
}

/// Findings of all fusion nodes. What several report about the site is there once, from the one that published last.
pub fn merged_findings<'a>(statuses: impl Iterator<Item = &'a FusionStatus>) -> Vec<NodeFinding> {
    let mut statuses: Vec<_> = statuses.collect();
    statuses.sort_by_key(|status| Reverse(status.epoch));
    let mut known = BTreeSet::new();
    let of_node = |status: &FusionStatus| {
        let mut findings = keyed_findings(status);
        findings.retain(|(key, _)| known.insert(key.clone()));
        findings.into_iter().map(|(_, finding)| finding)
    };
    statuses.into_iter().flat_map(of_node).collect()
}

/// Findings, each with a key that stays the same while amounts change.
fn keyed_findings(status: &FusionStatus) -> Vec<(String, NodeFinding)> {
    let faults = status.faults.iter();
    let faults = faults.map(|fault| (subject(fault), Severity::Fault, fault.to_string()));
    let left_out = match status.faults_left_out {
        0 => None,
        n => Some((
            "left out".to_owned(),
            Severity::Fault,
            format!("and {} more", count(n as usize, "fault")),
        )),
    };
    let imperfections = status.imperfections.iter();
    let imperfections = imperfections.map(|one| {
        let key = format!("off {}", subject(one));
        (key, Severity::Information, one.to_string())
    });
    let notices = status.notices.iter().map(|notice| {
        let owner = if is_about_node(notice) {
            status.node.as_str()
        } else {
            ""
        };
        let key = format!("{owner} {}", subject(notice));
        (key, notice.severity(), notice.to_string())
    });
    let all = faults.chain(left_out).chain(imperfections).chain(notices);
    let finding = |severity, sentence: String| NodeFinding {
        from: status.node.to_string(),
        severity,
        words: plain(&sentence),
    };
    all.map(|(key, severity, sentence)| (key, finding(severity, sentence)))
        .collect()
}

/// Whether a notice is about the node itself, not about the site.
fn is_about_node(notice: &Notice) -> bool {
    matches!(
        notice,
        Notice::Overload { .. }
            | Notice::Unpublished { .. }
            | Notice::ClockStepped { .. }
            | Notice::NameTaken { .. }
            | Notice::NotKept { .. }
    )
}

/// The variant of a finding and what it is about, without amounts.
fn subject(finding: &impl Serialize) -> String {
    let mut value = serde_json::to_value(finding).unwrap_or_default();
    let fields = value
        .as_object_mut()
        .and_then(|variant| variant.values_mut().next());
    if let Some(fields) = fields.and_then(Value::as_object_mut) {
        fields.retain(|_, field| !field.is_number());
    }
    value.to_string()
}

/// What a camera node reports.
pub fn camera_findings(status: &CameraStatus) -> Vec<NodeFinding> {
    let fallbacks = match status.fallbacks {
        0 => None,
        n => Some(format!(
            "the CPU made {} in place of the accelerator: see the log of the capturing part",
            count(n as usize, "image")
        )),
    };
    let settings = match &status.controls.outcome {
        SettingsOutcome::None | SettingsOutcome::Pending | SettingsOutcome::Applied => None,
        outcome => Some(settings_outcome(outcome)),
    };
    let notices = status.notices.iter();
    let notices = notices.map(|notice| (notice.severity(), notice.to_string()));
    let faults = fallbacks.into_iter().chain(settings);
    let all = faults.map(|words| (Severity::Fault, words)).chain(notices);
    let finding = |(severity, sentence): (Severity, String)| NodeFinding {
        from: status.camera.to_string(),
        severity,
        words: plain(&sentence),
    };
    all.map(finding).collect()
}

/// What became of a change of the site.
pub fn outcome(outcome: &ChangeOutcome) -> &'static str {
    match outcome {
        ChangeOutcome::Taken => "taken",
        ChangeOutcome::Kept => "taken and kept",
        ChangeOutcome::Same => "as it was already",
        ChangeOutcome::Refused(_) => "refused",
    }
}

/// What became of the site's settings at a camera.
pub fn settings_outcome(outcome: &SettingsOutcome) -> String {
    match outcome {
        SettingsOutcome::None => "the site sets nothing".to_owned(),
        SettingsOutcome::Pending => "the site's settings are not applied yet".to_owned(),
        SettingsOutcome::Applied => "the site's settings are applied".to_owned(),
        SettingsOutcome::Adjusted { detail } => {
            format!("the site's settings are adjusted: {}", plain(detail))
        }
        SettingsOutcome::Refused { detail } => {
            format!("the site's settings are refused: {}", plain(detail))
        }
    }
}

/// A number of things: `1 tag`, `6 tags`.
pub fn count(number: usize, thing: &str) -> String {
    match number {
        1 => format!("1 {thing}"),
        _ => format!("{number} {thing}s"),
    }
}

/// An age in ms with so many decimals. What is hours old and more is of a recording or by a wrong clock: its age is
/// days or years.
pub fn age_ms(ms: f64, decimals: usize) -> String {
    const DAY_MS: f64 = 86_400e3;
    match ms.abs() {
        size if size < 1e7 => format!("{ms:.decimals$}"),
        size if size < 700.0 * DAY_MS => format!("{:.1} d", ms / DAY_MS),
        _ => format!("{:.1} y", ms / (365.25 * DAY_MS)),
    }
}

/// Whose poses: `the poses of a, b`.
pub fn poses_of(objects: &[ObjectId]) -> String {
    if objects.is_empty() {
        return "the poses of all objects".to_owned();
    }
    let names: Vec<&str> = objects.iter().map(ObjectId::as_str).collect();
    format!("the poses of {}", names.join(", "))
}

/// Nanoseconds since the epoch as the time of day in UTC, to the millisecond.
pub fn time_of_day(ns: u64) -> String {
    let ms = ns / 1_000_000;
    let (seconds, ms) = (ms / 1000 % 86_400, ms % 1000);
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    format!("{hours:02}:{minutes:02}:{:02}.{ms:03}", seconds % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_lists_a_few_findings_of_each_kind() {
        let few = |id: u32| Finding::FewImages {
            tag: format!("tag36h11:{id}"),
            fits: 2,
        };
        let mut because: Vec<Finding> = (0..100).map(few).collect();
        because.push(Finding::ContradictingCameras);
        let verdict = Verdict {
            grade: sextant_calibrator::Grade::Usable,
            because,
        };
        let lines = reasons(&verdict);
        assert_eq!(lines.len(), MOST_OF_A_KIND + 2);
        assert_eq!(lines[0], "  - only 2 images of tag36h11:0 fit");
        assert!(
            lines[MOST_OF_A_KIND].contains("and 94 more of this kind"),
            "{lines:?}"
        );
    }

    #[test]
    fn a_time_is_read_as_a_clock_shows_it() {
        assert_eq!(time_of_day(1_800_000_000_123_456_789), "08:00:00.123");
        assert_eq!(time_of_day(0), "00:00:00.000");
    }
}
