//! `sextant doctor`: what a site needs of this machine and its network, before anything runs.
//!
//! Each finding is right, doubtful or a fault; the latter two with a remedy. Nothing is changed.

mod machine;
mod nodes;
mod site;

use crate::check::{CrossChecks, check_path};
use crate::output::{Format, print_line};
use crate::site::SiteArguments;
use anyhow::bail;
use clap::Args;
use nodes::NamedNode;
use serde::Serialize;
use sextant_process::{Exit, Failure};
use std::path::PathBuf;

/// Arguments of `sextant doctor`.
#[derive(Args, Debug)]
#[command(after_help = "For example, on a board: sextant doctor camera.toml
The network is that of the first node's file: its site, router and keys, unless --site, --connect or --keys say
otherwise.
With --json, one line per finding: {\"about\",\"verdict\",\"words\",\"remedy\"}, where verdict is ok, warning or fault,
and remedy is null if none is needed. The exit code is 1 if there is a fault.")]
pub struct DoctorArguments {
    /// Configuration, rig and object files, checked together as by `sextant check`.
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    site: SiteArguments,
}

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// No action is needed.
    Ok,
    /// It works with limits, or not every site needs it.
    Warning,
    /// A site cannot run like this.
    Fault,
}

/// The result of one check.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    about: &'static str,
    verdict: Verdict,
    words: String,
    remedy: Option<String>,
}

impl Finding {
    /// No action is needed.
    pub fn ok(about: &'static str, words: impl Into<String>) -> Self {
        Self {
            about,
            verdict: Verdict::Ok,
            words: words.into(),
            remedy: None,
        }
    }

    /// It works with limits, or not every site needs it.
    pub fn warning(about: &'static str, words: impl Into<String>, remedy: &str) -> Self {
        Self {
            verdict: Verdict::Warning,
            remedy: Some(remedy.to_owned()),
            ..Self::ok(about, words)
        }
    }

    /// A site cannot run like this.
    pub fn fault(about: &'static str, words: impl Into<String>, remedy: &str) -> Self {
        Self {
            verdict: Verdict::Fault,
            ..Self::warning(about, words, remedy)
        }
    }

    fn line(&self, format: Format) -> String {
        let verdict = match self.verdict {
            Verdict::Ok => "ok",
            Verdict::Warning => "warning",
            Verdict::Fault => "fault",
        };
        match (format, &self.remedy) {
            // Texts and enums: there is nothing that JSON could refuse.
            (Format::Json, _) => serde_json::to_string(self).unwrap_or_default(),
            (Format::Text, None) => format!("{verdict:<8} {}: {}", self.about, self.words),
            (Format::Text, Some(remedy)) => {
                format!("{verdict:<8} {}: {}; {remedy}", self.about, self.words)
            }
        }
    }
}

/// Runs `sextant doctor`.
///
/// # Errors
/// [`Exit::Fault`] when a finding is a fault.
pub fn run(arguments: &DoctorArguments, format: Format) -> anyhow::Result<()> {
    let mut findings = vec![Finding::ok(
        "version",
        concat!("sextant ", env!("CARGO_PKG_VERSION")),
    )];
    let (about_files, named) = files(&arguments.files);
    findings.extend(about_files);
    findings.extend(machine::findings());
    let mut faults = 0_usize;
    // Prints local findings first, since the network may be slow.
    for finding in findings {
        faults += usize::from(finding.verdict == Verdict::Fault);
        print_line(&finding.line(format))?;
    }
    // The site is that of the first node's file, where the command line does not say otherwise.
    let mut of_files = arguments
        .files
        .iter()
        .filter_map(|file| nodes::site_of_file(file));
    let site = match of_files.next() {
        Some(of_file) => arguments.site.or_as_in_file(&of_file),
        None => arguments.site.clone(),
    };
    for finding in site::findings(&site, &named)? {
        faults += usize::from(finding.verdict == Verdict::Fault);
        print_line(&finding.line(format))?;
    }
    if faults > 0 {
        let cause = anyhow::anyhow!("{faults} of these must be mended before a site runs");
        bail!(Failure::new(Exit::Fault, cause));
    }
    Ok(())
}

/// Findings about files, and the nodes that they describe.
fn files(paths: &[PathBuf]) -> (Vec<Finding>, Vec<NamedNode>) {
    let mut together = CrossChecks::default();
    let (mut findings, mut named) = (Vec::new(), Vec::new());
    for path in paths {
        let name = path.display();
        match check_path(path, None, &mut together) {
            Ok((kind, summary)) => {
                findings.push(Finding::ok("file", format!("{name}: {kind}, {summary}")));
                let (of_node, node) = nodes::findings(kind, path);
                findings.extend(of_node);
                named.extend(node);
            }
            Err(error) => {
                findings.push(Finding::fault(
                    "file",
                    format!("{error:#}"),
                    "mend the file",
                ));
            }
        }
    }
    findings.extend(nodes::unread_by_phones(&together.families()));
    let complaints = together.complaints().into_iter();
    findings.extend(complaints.map(|words| Finding::fault("files", words, "mend one of them")));
    (findings, named)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finding_says_what_is_wrong_and_what_to_do() {
        let finding = Finding::fault("clock", "it stands still", "wind it up");
        assert_eq!(
            finding.line(Format::Text),
            "fault    clock: it stands still; wind it up"
        );
        assert_eq!(
            finding.line(Format::Json),
            r#"{"about":"clock","verdict":"fault","words":"it stands still","remedy":"wind it up"}"#
        );
    }
}
