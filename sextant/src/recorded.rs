//! A recording of pictures or detections, whichever way it is kept: a folder, or an MCAP file, which is unpacked for as
//! long as it is used.

use crate::convert::{Counts, RecordingConversion};
use anyhow::{Context, bail};
use sextant_process::{Exit, Failure, WithExit};
use sextant_recordings::Dataset;
use sextant_recordings::mcap::is_mcap_file;
use sextant_site_model::CameraId;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A recording, opened as a folder of images or detections.
pub struct Recorded {
    /// What is in it.
    pub dataset: Dataset,
    /// Width and height of the images of each camera, px, where detections of an MCAP file state them.
    pub resolutions: BTreeMap<CameraId, [u32; 2]>,
    /// Files of an MCAP file; removed with this.
    _unpacked: Option<TempDir>,
}

/// What is used of images of an MCAP file that has both. Of a folder that has both, detections are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preferred {
    /// What the cameras found while it was recorded.
    Detections,
    /// The pictures, in which tags are sought anew.
    Pictures,
}

impl Recorded {
    /// Opens a folder or an MCAP file. `untimed` is the camera of a folder that may have pictures alone.
    ///
    /// # Errors
    /// [`Exit::Input`] for a recording that cannot be used, and for a file that is none.
    pub fn open(
        path: &Path,
        preferred: Preferred,
        untimed: Option<&CameraId>,
    ) -> anyhow::Result<Self> {
        let (unpacked, resolutions) = match path.is_file() {
            true => unpack(path, preferred)
                .map(|(folder, counts)| (Some(folder), counts.resolutions))?,
            false => (None, BTreeMap::new()),
        };
        let folder = unpacked.as_ref().map_or(path, TempDir::path);
        let dataset = match untimed {
            Some(camera) => Dataset::open_untimed(folder, camera),
            None => Dataset::open(folder),
        };
        let dataset = dataset.exit_with(Exit::Input)?;
        // Of one camera every image stands for itself.
        if dataset.cameras().len() > 1 {
            dataset.check_times().exit_with(Exit::Input)?;
        }
        Ok(Self {
            dataset,
            resolutions,
            _unpacked: unpacked,
        })
    }
}

/// The files of a recording in a new folder for temporary files.
fn unpack(file: &Path, preferred: Preferred) -> anyhow::Result<(TempDir, Counts)> {
    let path = file.display();
    if !is_mcap_file(file) {
        let cause = anyhow::anyhow!(
            "{path}: this file is no recording; give an MCAP file of `sextant record` or a \
             folder with one folder a camera"
        );
        bail!(Failure::new(Exit::Input, cause));
    }
    let folder = TempDir::new().context("a folder for the recording's files; TMPDIR says where")?;
    let counts = RecordingConversion {
        from: file,
        to: folder.path(),
        rig: None,
        objects: &[],
    }
    .to_folder()
    .context("unpacking the recording")?;
    if counts.is_empty() {
        let cause = anyhow::anyhow!(
            "{path}: there are neither images nor detections in it; record while cameras run, \
             with `--images` for their pictures"
        );
        bail!(Failure::new(Exit::Input, cause));
    }
    if preferred == Preferred::Pictures {
        remove_detections_beside_pictures(folder.path())?;
    }
    Ok((folder, counts))
}

fn remove_detections_beside_pictures(folder: &Path) -> anyhow::Result<()> {
    for entry in fs::read_dir(folder)? {
        let camera = entry?.path();
        let detections = camera.join("detections.jsonl");
        if camera.join("data.csv").is_file() && detections.is_file() {
            fs::remove_file(detections)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_recordings::{Frame, GreyImage, write_grey_png};

    #[test]
    fn detections_of_an_mcap_file_say_how_large_images_are() {
        let folder = tempfile::tempdir().unwrap();
        let [from, rig, file] = ["from", "rig.toml", "a.mcap"].map(|name| folder.path().join(name));
        fs::create_dir_all(from.join("north")).unwrap();
        let line = "{\"t_ns\":5,\"detections\":[]}\n";
        fs::write(from.join("north/detections.jsonl"), line).unwrap();
        let camera = "[[camera]]\nid = \"north\"\nresolution = [64, 48]\n\
            lens = { model = \"pinhole\", fx = 60.0, fy = 60.0, cx = 31.5, cy = 23.5 }\n";
        fs::write(&rig, camera).unwrap();
        let to_file = RecordingConversion {
            from: &from,
            to: &file,
            rig: Some(&rig),
            objects: &[],
        };
        to_file.to_file().unwrap();
        let recorded = Recorded::open(&file, Preferred::Detections, None).unwrap();
        let north = CameraId::new("north").unwrap();
        assert_eq!(recorded.resolutions, [(north, [64, 48])].into());
        let of_folder = Recorded::open(&from, Preferred::Detections, None).unwrap();
        assert!(of_folder.resolutions.is_empty());
    }

    #[test]
    fn an_mcap_file_is_opened_like_its_folder_and_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let [from, file] = ["from", "a.bag"].map(|name| folder.path().join(name));
        fs::create_dir_all(from.join("north/data")).unwrap();
        fs::write(
            from.join("north/data.csv"),
            "#timestamp [ns],filename\n5,5.png\n",
        )
        .unwrap();
        let image = GreyImage {
            width: 4,
            height: 3,
            pixels: vec![7; 12],
        };
        write_grey_png(&from.join("north/data/5.png"), &image).unwrap();
        let to_file = RecordingConversion {
            from: &from,
            to: &file,
            rig: None,
            objects: &[],
        };
        to_file.to_file().unwrap();
        let recorded = Recorded::open(&file, Preferred::Pictures, None).unwrap();
        let row = &recorded.dataset.cameras()[0].rows[0];
        assert_eq!((row.camera.as_str(), row.capture_ns), ("north", 5));
        let Frame::Picture(picture) = row.frame.clone() else {
            panic!("a picture");
        };
        assert!(picture.is_file());
        drop(recorded);
        assert!(!picture.exists());
    }

    #[test]
    fn a_file_that_is_no_recording_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("notes.mcap");
        fs::write(&file, "notes").unwrap();
        let error = Recorded::open(&file, Preferred::Pictures, None)
            .err()
            .unwrap();
        assert!(
            error
                .to_string()
                .contains("this file is no recording; give an MCAP file"),
            "{error}"
        );
    }
}
