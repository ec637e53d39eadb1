//! `sextant echo --format`: poses as text for other programs, to standard output or a file, a line a pose.

use super::EchoArguments;
use crate::output::print_line;
use crate::output_file::OutputFile;
use crate::pose_feed;
use crate::robot_frame::OutputFrame;
use anyhow::{Context, anyhow, bail};
use clap::ValueEnum;
use sextant_gateways::pose_feed::{Next, PoseReceiver};
use sextant_process::whole_lines::write_line;
use sextant_process::{Exit, Failure};
use sextant_proto::ObjectPose;
use sextant_recordings::{csv_header, pose_csv, pose_json, pose_tum};
use sextant_site_model::ObjectId;
use sextant_site_report::ObjectEstimate;
use std::fs::File;
use std::path::PathBuf;

/// A text format for poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PoseFormat {
    /// JSON lines, as `sextant replay` writes them.
    Json,
    /// Comma-separated values with a header.
    Csv,
    /// `timestamp tx ty tz qx qy qz qw`, as `evo` reads it; one object.
    Tum,
}

/// Writes the poses of the named objects, of all when none is named.
///
/// # Errors
/// [`Exit::Usage`] for a name that is no object's, and for TUM of several objects; no router; a file that cannot be
/// written.
pub fn run(arguments: &EchoArguments, format: PoseFormat) -> anyhow::Result<()> {
    let usage = |cause: String| Failure::new(Exit::Usage, anyhow!(cause));
    let ids = arguments.names.iter().map(|name| ObjectId::new(name));
    let objects: Vec<ObjectId> = ids
        .collect::<Result<_, _>>()
        .map_err(|cause| usage(format!("--format is for objects: {cause}")))?;
    if format == PoseFormat::Tum && objects.len() != 1 {
        bail!(usage("TUM text has one object only; name it".to_owned()));
    }
    let mut lines = PoseLines {
        format,
        frame: OutputFrame::read(arguments.frame.as_deref())?,
        output: Output::open(arguments)?,
        left: arguments.count.unwrap_or(u64::MAX),
    };
    if format == PoseFormat::Csv {
        lines.output.line(&csv_header())?;
    }
    let counts = pose_feed::run(&arguments.feed, &objects, &mut lines)?;
    if counts.dropped > 0 || counts.refused > 0 {
        eprintln!(
            "{} poses dropped because the reader is too slow, {} payloads refused",
            counts.dropped, counts.refused
        );
    }
    Ok(())
}

struct PoseLines {
    format: PoseFormat,
    frame: OutputFrame,
    output: Output,
    left: u64,
}

impl PoseReceiver for PoseLines {
    type Error = anyhow::Error;

    fn take(&mut self, pose: &ObjectPose) -> anyhow::Result<Next> {
        if self.left > 0 {
            let estimate = self.frame.transform(ObjectEstimate::from(pose));
            let line = match self.format {
                PoseFormat::Json => pose_json(&estimate),
                PoseFormat::Csv => pose_csv(&estimate),
                PoseFormat::Tum => pose_tum(&estimate),
            };
            self.output.line(&line)?;
            self.left -= 1;
        }
        Ok(match self.left {
            0 => Next::Done,
            _ => Next::More,
        })
    }
}

enum Output {
    Standard,
    File {
        file: File,
        output: OutputFile,
        path: PathBuf,
        lines: u64,
    },
}

impl Output {
    fn open(arguments: &EchoArguments) -> anyhow::Result<Self> {
        let Some(path) = &arguments.out else {
            return Ok(Self::Standard);
        };
        let output = OutputFile::create(path, arguments.force).context("--out")?;
        Ok(Self::File {
            file: output.writer()?,
            output,
            path: path.to_owned(),
            lines: 0,
        })
    }

    /// Writes a line, whole or not at all, and hands it on at once.
    fn line(&mut self, line: &str) -> anyhow::Result<()> {
        match self {
            Self::Standard => print_line(line).context("standard output"),
            Self::File {
                file,
                output,
                path,
                lines,
            } => {
                let written = write_line(file, format!("{line}\n").as_bytes());
                let written = written.and_then(|()| output.keep());
                written.with_context(|| {
                    format!(
                        "{}: cannot write on; the {lines} lines before are complete",
                        path.display()
                    )
                })?;
                *lines += 1;
                Ok(())
            }
        }
    }
}
