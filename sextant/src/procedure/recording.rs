//! The images of a recording, as every calibration takes them in.

use super::ImageSelection;
use crate::detect::NothingFound;
use crate::progress;
use anyhow::bail;
use sextant_apriltag::Options;
use sextant_process::{Exit, Failure, WithExit};
use sextant_recordings::{Dataset, Frame, Row};
use sextant_replay::in_order;
use sextant_replay::{ChessboardSearch, TagFinder};
use sextant_replay::{ObservationError, observation};
use sextant_site_model::{CameraId, ImageObservation};
use std::path::Path;

/// Hands every image of the wanted cameras (none: all) of a folder to `take`, in the order of their arrival.
///
/// # Errors
/// [`Exit::Input`] for a recording that cannot be used, or has a camera that the rig lacks.
pub fn each_image(
    folder: &Path,
    dataset: &Dataset,
    looking: &ImageSelection,
    threads: u8,
    mut take: impl FnMut(&ImageObservation),
) -> anyhow::Result<()> {
    let (rig, cameras) = (&looking.rig, &looking.cameras);
    let wanted = |id: &CameraId| cameras.is_empty() || cameras.contains(id);
    for recording in dataset.cameras().iter().filter(|c| wanted(&c.camera)) {
        if rig.camera(&recording.camera).is_none() {
            wrong(format!(
                "{}: the rig has no camera \"{}\"; add it there or take the folder away",
                folder.join(recording.camera.as_str()).display(),
                recording.camera
            ))?;
        }
    }
    for id in cameras {
        if !dataset.cameras().iter().any(|c| c.camera == *id) {
            wrong(format!(
                "{}: there is no folder of camera \"{id}\"",
                folder.display()
            ))?;
        }
    }
    let options = Options {
        families: looking.families.iter().copied().collect(),
        ..Options::default()
    };
    let rows = dataset.rows_by_arrival();
    let rows = rows.into_iter().filter(|row| wanted(&row.camera));
    let rows: Vec<&Row> = rows.collect();
    let mut nothing = NothingFound::default();
    in_order(
        usize::from(threads),
        progress::over(rows.into_iter(), "images"),
        || TagFinder::new(&options, looking.chessboard.as_ref()).or_inverted(&options),
        |finder, row: &Row| (row, observation(finder, row, rig)),
        |(row, seen): (&Row, Result<ImageObservation, ObservationError>)| {
            let seen = seen.exit_with(Exit::Input)?;
            if let Frame::Picture(path) = &row.frame {
                nothing.add(path, seen.tags.len());
            }
            take(&seen);
            anyhow::Ok(())
        },
    )?;
    if let Some(other) = nothing.other_board(&options) {
        eprintln!("warning: {other}");
    }
    for remark in looking
        .chessboard
        .iter()
        .flat_map(ChessboardSearch::remarks)
    {
        eprintln!("warning: {remark}");
    }
    Ok(())
}

/// A complaint about what was given.
///
/// # Errors
/// Always: [`Exit::Input`].
pub fn wrong(message: String) -> anyhow::Result<()> {
    bail!(Failure::new(Exit::Input, anyhow::anyhow!(message)))
}
