//! The images of a calibration or of learning, recorded or of the running site, up to the result. The commands say what
//! is sought; from there on both ways are the same code.

mod block;
mod live;
mod progress_display;
mod recording;

pub use live::Live;
pub use recording::{each_image, wrong};

use crate::output::Format;
use crate::recorded::{Preferred, Recorded};
use crate::site::SiteArguments;
use anyhow::{anyhow, bail};
use clap::Args;
use sextant_calibrator::procedure::{Procedure, ProcedureError, ProcedureOutcome};
use sextant_process::{Exit, Failure, WithExit};
use sextant_replay::ChessboardSearch;
use sextant_site_model::{CameraId, Rig};
use sextant_tag_families::Family;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Where the images come from.
#[derive(Args, Debug)]
pub struct ImageArguments {
    /// The recording: DIR/CAMERA/data.csv with the pictures in DIR/CAMERA/data, or DIR/CAMERA/detections.jsonl, or an
    /// MCAP file.
    #[arg(value_name = "DIR|FILE.mcap", required_unless_present = "live")]
    recording: Option<PathBuf>,
    /// Use images of the running site.
    #[arg(long, conflicts_with = "recording")]
    live: bool,
    #[command(flatten)]
    site: SiteArguments,
    /// Number of detection threads for recorded images; the result does not depend on it.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
    /// Refuse a partial result. Without it, what can be solved is written, the rest is named and kept as it is, and the
    /// exit code is 4.
    #[arg(long)]
    strict: bool,
}

/// Which images a procedure uses, and which tags it detects in them.
pub struct ImageSelection {
    /// Cameras with their lenses and the size of their pictures.
    pub rig: Rig,
    /// Cameras to use; empty for all.
    pub cameras: Vec<CameraId>,
    /// Tag families to detect.
    pub families: BTreeSet<Family>,
    /// A plain chessboard to look for.
    pub chessboard: Option<ChessboardSearch>,
}

/// The source of a procedure's images, opened.
pub enum Images<'a> {
    /// Of a folder or file.
    Recorded {
        /// The folder or file.
        folder: &'a Path,
        /// What is in it.
        recorded: Recorded,
        /// How many look for tags.
        threads: u8,
    },
    /// Of the running site.
    Live(Box<Live>),
}

impl ImageArguments {
    /// Opens the folder, or connects to the site. `untimed` is the camera of a folder that may have pictures alone.
    ///
    /// # Errors
    /// [`Exit::Unavailable`] when no router answers, [`Exit::Input`] for a folder that cannot be used, and for a
    /// chessboard, which cameras of a site do not look for.
    pub fn open(
        &self,
        format: Format,
        chessboard: Option<&ChessboardSearch>,
        untimed: Option<&CameraId>,
    ) -> anyhow::Result<Images<'_>> {
        // Cameras of a site look for no chessboard.
        let preferred = match chessboard {
            Some(_) => Preferred::Pictures,
            None => Preferred::Detections,
        };
        Ok(match &self.recording {
            Some(folder) => Images::Recorded {
                folder,
                recorded: Recorded::open(folder, preferred, untimed)?,
                threads: self.threads,
            },
            None if chessboard.is_some() => bail!(Failure::new(
                Exit::Input,
                anyhow!(
                    "the cameras of a site look for tags, not for plain chessboards; save images \
                     (`sextant record --images`) and give their folder, or use a board with tags \
                     (`sextant print charuco`)"
                )
            )),
            None => Images::Live(Box::new(Live::open(self.site.open()?, format)?)),
        })
    }

    /// Writes a result by `write`, unless it is partial and `--strict` was given.
    ///
    /// # Errors
    /// Those of `write`; [`Exit::Unavailable`] after a partial result was written, [`Exit::Input`] where it is refused.
    pub fn keep(
        &self,
        outcome: &ProcedureOutcome,
        write: impl FnOnce() -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let unsolved = outcome.unsolved();
        if unsolved.is_empty() {
            return write();
        }
        let unsolved = unsolved.join("; ");
        if self.strict {
            bail!(Failure::new(Exit::Input, anyhow!("{unsolved}")));
        }
        write()?;
        bail!(Failure::new(
            Exit::Unavailable,
            anyhow!("partial: {unsolved}")
        ))
    }

    /// Command that applies the result to the running site; nothing after a recording.
    pub fn handing_over(&self, what: &str, file: &Path) -> Option<String> {
        let file = file.display();
        let site = self.site.as_typed();
        self.live.then(|| {
            format!(
                "The site works on with what it had; to hand this over: sextant \
                config set {what} {file}{site}"
            )
        })
    }
}

impl Images<'_> {
    /// Runs the procedure over the images and solves it.
    ///
    /// # Errors
    /// [`Exit::Input`] for images that give no result, with the cause; [`Exit::Interrupted`] for a live procedure that
    /// was stopped before any detection.
    pub fn outcome(
        self,
        mut procedure: Procedure,
        looking: &ImageSelection,
    ) -> anyhow::Result<ProcedureOutcome> {
        match self {
            Self::Live(live) => live.outcome(procedure, looking),
            Self::Recorded {
                folder,
                recorded,
                threads,
            } => {
                let mut taken: Result<(), ProcedureError> = Ok(());
                each_image(folder, &recorded.dataset, looking, threads, |image| {
                    if taken.is_ok() {
                        taken = procedure.handle(image);
                    }
                })?;
                taken.exit_with(Exit::Input)?;
                procedure.solve().exit_with(Exit::Input)
            }
        }
    }
}
