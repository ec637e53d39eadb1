//! A recording: one folder per camera, in the EuRoC ASL layout, with images or detections.

use crate::data_csv::read_data_csv;
use crate::detections::{DetectedTag, DetectionsLine};
use crate::error::RecordingError;
use crate::lines::{bounded_lines, doubt};
use crate::picture::is_picture;
use sextant_site_model::CameraId;
use std::fs;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// The recordings of all cameras of a folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    cameras: Vec<CameraRecording>,
}

/// The recording of one camera, in order of time.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraRecording {
    /// The camera: the folder's name.
    pub camera: CameraId,
    /// Its images; capture times ascend.
    pub rows: Vec<Row>,
}

/// One image of one camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Id of the camera.
    pub camera: CameraId,
    /// Middle of the exposure by the camera's clock, ns since the Unix epoch.
    pub capture_ns: u64,
    /// Arrival at the fusion node, by its clock; the capture time if not recorded.
    pub arrival_ns: u64,
    /// Whether the arrival is recorded.
    pub arrival_stated: bool,
    /// Its image file or detections.
    pub frame: Frame,
}

/// Recorded data of an image.
#[derive(Debug, Clone, PartialEq)]
pub enum Frame {
    /// An image file, which exists.
    Picture(PathBuf),
    /// Detections.
    Detections(Vec<DetectedTag>),
}

impl Dataset {
    /// Opens every camera's folder below `folder`. Pictures are checked to exist, not yet read.
    ///
    /// # Errors
    /// A folder that is missing or has no camera, and any flaw of any `data.csv` or `detections.jsonl`.
    pub fn open(folder: &Path) -> Result<Self, RecordingError> {
        let folders = cameras_in(folder)?;
        if folders.is_empty() {
            return Err(no_camera(folder));
        }
        let cameras = folders.iter().map(|path| CameraRecording::open(path));
        Ok(Self {
            cameras: cameras.collect::<Result<_, _>>()?,
        })
    }

    /// As [`Self::open`], or, for work in which time does not matter, the pictures of one camera without a table, in
    /// the order of their names: those in `folder` or in `folder/<camera>`. Capture times then only count them.
    ///
    /// # Errors
    /// As [`Self::open`], and a folder without pictures.
    pub fn open_untimed(folder: &Path, camera: &CameraId) -> Result<Self, RecordingError> {
        if !cameras_in(folder)?.is_empty() {
            return Self::open(folder);
        }
        let mut pictures = pictures_in(folder)?;
        let below = folder.join(camera.as_str());
        if pictures.is_empty() && below.is_dir() {
            pictures = pictures_in(&below)?;
        }
        if pictures.is_empty() {
            return Err(no_camera(folder));
        }
        let rows = pictures.into_iter().zip(1..).map(|(path, number)| Row {
            camera: camera.clone(),
            capture_ns: number,
            arrival_ns: number,
            arrival_stated: false,
            frame: Frame::Picture(path),
        });
        let camera = CameraRecording {
            camera: camera.clone(),
            rows: rows.collect(),
        };
        Ok(Self {
            cameras: vec![camera],
        })
    }

    /// Whether the times of each camera's images can be times: for work in which they matter.
    ///
    /// # Errors
    /// For the first camera whose images are too close together, as in another unit or where they are counted.
    pub fn check_times(&self) -> Result<(), RecordingError> {
        for camera in &self.cameras {
            let times_ns = camera.rows.iter().map(|row| row.capture_ns);
            if let Some((cause, remedy)) = doubt(times_ns) {
                let path = Path::new(camera.camera.as_str());
                return Err(RecordingError::wrong(path, None, cause, remedy));
            }
        }
        Ok(())
    }

    /// The cameras, ordered by id.
    pub fn cameras(&self) -> &[CameraRecording] {
        &self.cameras
    }

    /// All images of all cameras in order of arrival, then capture time, then camera.
    pub fn rows_by_arrival(&self) -> Vec<&Row> {
        let mut rows: Vec<&Row> = self.cameras.iter().flat_map(|c| &c.rows).collect();
        rows.sort_by(|a, b| {
            (a.arrival_ns, a.capture_ns, &a.camera).cmp(&(b.arrival_ns, b.capture_ns, &b.camera))
        });
        rows
    }
}

impl CameraRecording {
    /// Opens the folder of one camera: `detections.jsonl` where there is one, else `data.csv` and its pictures.
    ///
    /// # Errors
    /// A folder whose name is no camera's, one with neither file, and any flaw in them.
    pub fn open(folder: &Path) -> Result<Self, RecordingError> {
        let camera = camera_of(folder)?;
        let detections = folder.join("detections.jsonl");
        let rows = if detections.is_file() {
            let lines = DetectionsLine::read_file(&detections)?;
            let rows = lines.into_iter().map(|line| Row {
                camera: camera.clone(),
                capture_ns: line.t_ns,
                arrival_ns: line.arrival_ns.unwrap_or(line.t_ns),
                arrival_stated: line.arrival_ns.is_some(),
                frame: Frame::Detections(line.detections),
            });
            rows.collect()
        } else {
            let lines = read_data_csv(folder)?;
            let rows = lines.into_iter().map(|line| Row {
                camera: camera.clone(),
                capture_ns: line.capture_ns,
                arrival_ns: line.arrival_ns.unwrap_or(line.capture_ns),
                arrival_stated: line.arrival_ns.is_some(),
                frame: Frame::Picture(line.picture),
            });
            rows.collect()
        };
        Ok(Self { camera, rows })
    }
}

/// The cameras' folders below a folder, sorted.
fn cameras_in(folder: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    let paths = paths_in(folder)?.into_iter();
    Ok(paths
        .filter(|path| path.is_dir() && is_camera(path))
        .collect())
}

/// The pictures in a folder, sorted. Hidden files are passed over.
fn pictures_in(folder: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    let is_hidden = |path: &Path| {
        let name = path.file_name().unwrap_or_default();
        name.as_encoded_bytes().starts_with(b".")
    };
    let mut pictures = Vec::new();
    for path in paths_in(folder)? {
        if path.is_file() && !is_hidden(&path) && is_picture(&path)? {
            pictures.push(path);
        }
    }
    Ok(pictures)
}

/// What is in a folder, sorted.
fn paths_in(folder: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    let unreadable =
        || RecordingError::unreadable(folder, "give a folder with one folder a camera");
    let entries = fs::read_dir(folder).map_err(unreadable())?;
    let mut paths = Vec::new();
    for entry in entries {
        paths.push(entry.map_err(unreadable())?.path());
    }
    paths.sort();
    Ok(paths)
}

fn camera_of(folder: &Path) -> Result<CameraId, RecordingError> {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    CameraId::new(&name).map_err(|error| {
        let cause = format!("the folder's name is no camera's id: {error}");
        RecordingError::wrong(folder, None, cause, "rename it as the rig names the camera")
    })
}

/// A folder with detections, with pictures, or with a list of pictures. EuRoC's other sensors have a `data.csv` as
/// well, but no folder `data` and no column `filename`.
fn is_camera(folder: &Path) -> bool {
    folder.join("detections.jsonl").is_file()
        || folder.join("data").is_dir()
        || lists_pictures(&folder.join("data.csv"))
}

fn lists_pictures(csv: &Path) -> bool {
    let Ok(file) = fs::File::open(csv) else {
        return false;
    };
    let Some(Ok(first)) = bounded_lines(BufReader::new(file)).next() else {
        return false;
    };
    let header = first
        .trim_start_matches('\u{feff}')
        .trim_start()
        .starts_with('#');
    !header || first.contains("filename")
}

fn no_camera(folder: &Path) -> RecordingError {
    let is_one = is_camera(folder);
    let remedy = if is_one {
        "this is the folder of one camera: give the folder above it"
    } else {
        "give a folder with DIR/<camera>/data.csv and the pictures in DIR/<camera>/data, or \
         DIR/<camera>/detections.jsonl"
    };
    RecordingError::wrong(folder, None, "no camera's folder in it", remedy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{GreyImage, write_grey_png};
    use tempfile::TempDir;

    fn add_camera(root: &TempDir, camera: &str, csv: &str) {
        let folder = root.path().join(camera);
        fs::create_dir_all(folder.join("data")).unwrap();
        fs::write(folder.join("data.csv"), csv).unwrap();
        let image = GreyImage {
            width: 1,
            height: 1,
            pixels: vec![0],
        };
        write_grey_png(&folder.join("data/a.png"), &image).unwrap();
    }

    fn complaint(root: &TempDir) -> String {
        let message = Dataset::open(root.path()).unwrap_err().to_string();
        message.replace(&root.path().display().to_string(), "DIR")
    }

    #[test]
    fn rows_come_by_arrival_then_capture_then_camera() {
        let root = tempfile::tempdir().unwrap();
        add_camera(&root, "b", "10,a.png,30\n20,a.png,25\n");
        add_camera(&root, "a", "5,a.png,30\n10,a.png,30\n22,a.png\n");
        let dataset = Dataset::open(root.path()).unwrap();
        let rows = dataset.rows_by_arrival();
        let order: Vec<_> = rows
            .iter()
            .map(|r| (r.camera.as_str(), r.capture_ns))
            .collect();
        assert_eq!(
            order,
            [("a", 22), ("b", 20), ("a", 5), ("a", 10), ("b", 10)]
        );
        assert!(!rows[0].arrival_stated);
    }

    #[test]
    fn detections_take_the_place_of_pictures() {
        let root = tempfile::tempdir().unwrap();
        add_camera(&root, "a", "not even looked at\n");
        fs::write(
            root.path().join("a/detections.jsonl"),
            "{\"t_ns\":3,\"detections\":[]}\n",
        )
        .unwrap();
        let dataset = Dataset::open(root.path()).unwrap();
        let row = &dataset.cameras()[0].rows[0];
        assert_eq!(row.frame, Frame::Detections(vec![]));
        assert_eq!((row.capture_ns, row.arrival_ns), (3, 3));
    }

    #[test]
    fn other_folders_and_sensors_are_passed_over() {
        let root = tempfile::tempdir().unwrap();
        add_camera(&root, "a", "1,a.png\n");
        fs::create_dir_all(root.path().join("imu0")).unwrap();
        fs::write(
            root.path().join("imu0/data.csv"),
            "#timestamp [ns],w_RS_S_x [rad s^-1]\n1,2\n",
        )
        .unwrap();
        fs::create_dir(root.path().join("Notes")).unwrap();
        assert_eq!(Dataset::open(root.path()).unwrap().cameras().len(), 1);
    }

    #[test]
    fn wrong_folders_are_refused() {
        let root = tempfile::tempdir().unwrap();
        assert!(complaint(&root).starts_with("DIR: no camera's folder in it; give a folder"));
        add_camera(&root, "Front", "1,a.png\n");
        assert!(complaint(&root).starts_with("DIR/Front: the folder's name is no camera's id"));
        let inside = Dataset::open(&root.path().join("Front")).unwrap_err();
        assert!(
            inside
                .to_string()
                .ends_with("this is the folder of one camera: give the folder above it")
        );
        let missing = Dataset::open(Path::new("/nowhere")).unwrap_err();
        assert!(
            missing
                .to_string()
                .starts_with("/nowhere: there is no such file or folder")
        );
    }

    #[test]
    fn pictures_without_a_list_come_by_name_where_time_does_not_matter() {
        let root = tempfile::tempdir().unwrap();
        let camera = CameraId::new("a").unwrap();
        let open = |below: &str| Dataset::open_untimed(&root.path().join(below), &camera);
        let nothing = open("").unwrap_err().to_string();
        assert!(nothing.contains("no camera's folder in it"), "{nothing}");
        add_camera(&root, "a", "5,a.png\n");
        for name in ["b.jpeg", "c", ".d.png"] {
            fs::copy(
                root.path().join("a/data/a.png"),
                root.path().join("a/data").join(name),
            )
            .unwrap();
        }
        fs::write(root.path().join("a/data/notes.txt"), "board 3").unwrap();
        let names = |dataset: &Dataset| -> Vec<String> {
            let rows = dataset.cameras()[0].rows.iter();
            let name = |row: &Row| match &row.frame {
                Frame::Picture(path) => path.file_name().unwrap().to_string_lossy().into_owned(),
                Frame::Detections(_) => String::new(),
            };
            rows.map(name).collect()
        };
        let dataset = open("a/data").unwrap();
        assert_eq!(names(&dataset), ["a.png", "b.jpeg", "c"]);
        assert_eq!(dataset.cameras()[0].rows[2].capture_ns, 3);
        fs::write(root.path().join("a/data/broken.JPG"), "no picture").unwrap();
        let dataset = open("a/data").unwrap();
        assert_eq!(names(&dataset), ["a.png", "b.jpeg", "broken.JPG", "c"]);
        fs::remove_file(root.path().join("a/data/broken.JPG")).unwrap();
        // A table comes before pictures.
        assert_eq!(names(&open("").unwrap()), ["a.png"]);
        fs::rename(root.path().join("a/data"), root.path().join("b")).unwrap();
        fs::remove_dir_all(root.path().join("a")).unwrap();
        fs::rename(root.path().join("b"), root.path().join("a")).unwrap();
        assert_eq!(names(&open("").unwrap()).len(), 3);
    }

    #[test]
    fn pictures_without_a_list_are_refused() {
        let root = tempfile::tempdir().unwrap();
        add_camera(&root, "a", "1,a.png\n");
        fs::remove_file(root.path().join("a/data.csv")).unwrap();
        assert!(complaint(&root).starts_with("DIR/a/data.csv: there is no such file"));
    }
}
