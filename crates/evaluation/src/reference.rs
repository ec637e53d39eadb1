//! Poses to compare with: another recording or pose file, ground truth as TUM text or EuRoC's CSV.

use crate::pose_table::PoseColumns;
use nalgebra::{Quaternion, Translation3};
use serde::Deserialize;
use sextant_geometry::{Pose, PoseParts, unit_quaternion};
use sextant_recordings::mcap::site_recording::SiteRecording;
use sextant_recordings::{RecordingError, bounded_lines};
use sextant_site_model::ObjectId;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

/// Poses further apart than this, ns, are not interpolated.
const LONGEST_GAP_NS: u64 = 200_000_000;

/// `world_from_object` by time in ns.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct Trajectory(BTreeMap<u64, Pose>);

/// Reference poses by object.
pub type References = BTreeMap<ObjectId, Trajectory>;

impl Trajectory {
    /// First and last time, ns.
    pub fn span_ns(&self) -> Option<(u64, u64)> {
        let first = self.0.first_key_value()?;
        Some((*first.0, *self.0.last_key_value()?.0))
    }

    /// The pose at a time: of exactly that time, or between its neighbours (linear, and along the shorter arc).
    pub fn at(&self, t_ns: u64) -> Option<Pose> {
        let (before_ns, before) = self.0.range(..=t_ns).next_back()?;
        if *before_ns == t_ns {
            return Some(*before);
        }
        let (after_ns, after) = self.0.range(t_ns..).next()?;
        let gap_ns = after_ns - before_ns;
        let share = (t_ns - before_ns) as f64 / gap_ns as f64;
        let rotation = before.rotation.try_slerp(&after.rotation, share, 1e-9);
        let shift = before
            .translation
            .vector
            .lerp(&after.translation.vector, share);
        let pose = Pose::from_parts(
            Translation3::from(shift),
            rotation.unwrap_or(before.rotation),
        );
        (gap_ns <= LONGEST_GAP_NS).then_some(pose)
    }
}

/// Why a file is no reference.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The extension is that of no format.
    #[error(
        "{}: the name says no format; let it end with .mcap, .jsonl, .tum, .txt or .csv",
        .0.display()
    )]
    UnknownFormat(PathBuf),
    /// The extension is that of no table of one body.
    #[error("{}: the name says no table of poses; let it end with .csv, .tum or .txt", .0.display())]
    UnknownTable(PathBuf),
    /// A CSV file without a header, where it has to say the order of the quaternion.
    #[error(
        "{}:1: no header says which column is what; write one first, such as t \
         [ns],x,y,z,qx,qy,qz,qw, or image,x,y,z,qx,qy,qz,qw with the number of each pose's image from 0",
        .0.display()
    )]
    NoHeader(PathBuf),
    /// A table by the numbers of images where times are needed.
    #[error("{}:1: the header names images and no time; write t [s] in place of image", .0.display())]
    NoTimes(PathBuf),
    /// A file of one trajectory is named after none of several objects.
    #[error("{}: which of the {objects} objects is it of? Name the file after it", path.display())]
    UnknownObject {
        /// The file.
        path: PathBuf,
        /// Number of objects.
        objects: usize,
    },
    /// A recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A file cannot be opened.
    #[error("{}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A line is no pose.
    #[error("{}:{line}: {cause}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong, and what to write.
        cause: String,
    },
}

/// Reads files for these objects. A file of one trajectory is that of the object whose id is its name, or of the only
/// object.
///
/// # Errors
/// See [`ReferenceError`].
pub fn read(files: &[PathBuf], objects: &BTreeSet<ObjectId>) -> Result<References, ReferenceError> {
    let mut references = References::new();
    for file in files {
        for (object, trajectory) in read_one(file, objects)? {
            references.entry(object).or_default().0.extend(trajectory.0);
        }
    }
    Ok(references)
}

fn read_one(file: &Path, objects: &BTreeSet<ObjectId>) -> Result<References, ReferenceError> {
    match file.extension().and_then(|extension| extension.to_str()) {
        Some("mcap") => of_recording(file),
        Some("jsonl" | "json") => of_lines(file),
        Some("tum" | "txt") => {
            Ok([(owner(file, objects)?, of_table(file, PoseColumns::TUM)?)].into())
        }
        Some("csv") => Ok([(owner(file, objects)?, of_table(file, PoseColumns::EUROC)?)].into()),
        _ => Err(ReferenceError::UnknownFormat(file.to_owned())),
    }
}

fn owner(file: &Path, objects: &BTreeSet<ObjectId>) -> Result<ObjectId, ReferenceError> {
    let stem = file
        .file_stem()
        .and_then(|stem| stem.to_str())
        .unwrap_or_default();
    let named = objects.iter().find(|object| object.as_str() == stem);
    let only = objects.first().filter(|_| objects.len() == 1);
    let owner = named.or(only).cloned();
    owner.ok_or_else(|| ReferenceError::UnknownObject {
        path: file.to_owned(),
        objects: objects.len(),
    })
}

/// The truth of an object where it was simulated, else its poses.
fn of_recording(file: &Path) -> Result<References, ReferenceError> {
    let recording = SiteRecording::read(file)?;
    let mut references = References::new();
    for truth in &recording.truths {
        let pose = pose_of(truth.position, truth.orientation);
        let trajectory = references.entry(truth.object.clone()).or_default();
        trajectory.0.insert(truth.capture_ns, pose);
    }
    let simulated: BTreeSet<ObjectId> = references.keys().cloned().collect();
    for pose in recording
        .poses
        .iter()
        .filter(|pose| !simulated.contains(&pose.object))
    {
        let trajectory = references.entry(pose.object.clone()).or_default();
        trajectory
            .0
            .insert(pose.capture_ns, pose.world_from_object());
    }
    Ok(references)
}

#[derive(Deserialize)]
struct PoseLine {
    t_ns: u64,
    object: ObjectId,
    #[serde(flatten)]
    pose: WrittenPose,
}

#[derive(Deserialize)]
struct WrittenPose {
    position: [f64; 3],
    orientation: [f64; 4],
}

fn of_lines(file: &Path) -> Result<References, ReferenceError> {
    const FORM: &str = "write {\"t_ns\",\"object\",\"position\":[3],\"orientation\":[x,y,z,w]}";
    let mut references = References::new();
    each_line(file, |line| {
        if line.starts_with('#') {
            return Ok(());
        }
        let read: PoseLine =
            serde_json::from_str(line).map_err(|cause| format!("{FORM}: {cause}"))?;
        let pose = checked(read.pose.position, read.pose.orientation)?;
        references
            .entry(read.object)
            .or_default()
            .0
            .insert(read.t_ns, pose);
        Ok(())
    })?;
    Ok(references)
}

/// A table of poses: the columns that its header names, or those of the format.
fn of_table(file: &Path, format: PoseColumns) -> Result<Trajectory, ReferenceError> {
    let table = Table::read(file, format)?;
    if table.columns.is_by_image() {
        return Err(ReferenceError::NoTimes(file.to_owned()));
    }
    Ok(table.poses)
}

/// A table as it was read.
struct Table {
    columns: PoseColumns,
    has_header: bool,
    /// By time or the number of an image.
    poses: Trajectory,
}

impl Table {
    fn read(file: &Path, format: PoseColumns) -> Result<Self, ReferenceError> {
        let mut table = Self {
            columns: format,
            has_header: false,
            poses: Trajectory::default(),
        };
        let mut unit = None;
        each_line(file, |line| {
            let is_data =
                line.starts_with(|first: char| first.is_ascii_digit() || "+-.".contains(first));
            let is_head = !is_data && table.poses.0.is_empty();
            if is_head && table.reads_header(line)? || line.starts_with('#') {
                return Ok(());
            }
            let without_header = |cause: String| {
                let form = format.form();
                format!("{cause}; write {form}, or a header that names the columns")
            };
            if !table.has_header
                && let Some(cause) = table.columns.complaint_without_header(line)
            {
                return Err(without_header(cause));
            }
            if table.columns.is_empty(line) {
                return Ok(());
            }
            let guessed = table.columns.guessed_unit(line);
            if *unit.get_or_insert(guessed) != guessed {
                let cause = "the times of some rows seem to be in another unit: name it in the header, such as t [s]";
                return Err(cause.to_owned());
            }
            let row = table.columns.row(line);
            let (t_ns, pose) = row.map_err(|cause| match table.has_header {
                true => cause,
                false => without_header(cause),
            })?;
            let former = table.poses.0.insert(t_ns, pose);
            if former.is_some() && table.columns.is_by_image() {
                return Err(format!(
                    "image {t_ns} has a pose already; write one row an image"
                ));
            }
            Ok(())
        })?;
        Ok(table)
    }

    /// Reads a line above the rows; whether it was no row.
    fn reads_header(&mut self, line: &str) -> Result<bool, String> {
        match PoseColumns::of_header(line) {
            Some(named) => {
                self.columns = named?;
                self.has_header = true;
                Ok(true)
            }
            None if line.starts_with('#') || line.starts_with("sep=") => Ok(true),
            None => match mocap_export(line) {
                Some(cause) => Err(cause.to_owned()),
                None => Ok(false),
            },
        }
    }
}

/// Poses of one body, by what their table has.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyedPoses {
    /// By time, ns.
    ByTime(BTreeMap<u64, Pose>),
    /// By the number of an image, from 0.
    ByImage(BTreeMap<u64, Pose>),
}

/// A table of the poses of one body: CSV with a header, by time or by the number of an image (a column `image`), or TUM
/// text.
///
/// # Errors
/// See [`ReferenceError`]; CSV without a header, since the order of a quaternion's numbers is not known then.
pub fn read_poses(file: &Path) -> Result<KeyedPoses, ReferenceError> {
    let extension = file.extension().and_then(|extension| extension.to_str());
    let needs_header = extension == Some("csv");
    let format = match extension {
        Some("csv") => PoseColumns::EUROC,
        Some("tum" | "txt") => PoseColumns::TUM,
        _ => return Err(ReferenceError::UnknownTable(file.to_owned())),
    };
    let table = Table::read(file, format)?;
    if needs_header && !table.has_header {
        return Err(ReferenceError::NoHeader(file.to_owned()));
    }
    Ok(match table.columns.is_by_image() {
        true => KeyedPoses::ByImage(table.poses.0),
        false => KeyedPoses::ByTime(table.poses.0),
    })
}

/// What a table of a motion capture system is, by its first line. These have several header lines, bodies side by side,
/// frames in place of times, or angles.
fn mocap_export(line: &str) -> Option<&'static str> {
    let first = line.split([',', '\t']).next()?.trim().trim_matches('"');
    match first {
        "Format Version" => Some(
            "this is an export of OptiTrack Motive; keep the time and the columns of one rigid \
             body, and write one header: t [s],qx,qy,qz,qw,x,y,z (in the order and unit of the \
             export, with quaternions and z up)",
        ),
        "Objects" | "Segments" | "Trajectories" => Some(
            "this is an export of Vicon Nexus or Tracker, which has frames and angles; write t \
             [s],x [mm],y [mm],z [mm],qx,qy,qz,qw with time = frame / rate",
        ),
        "NO_OF_FRAMES" => Some(
            "this is an export of QTM, which has matrices or angles; write t [s],x [mm],y [mm],z [mm],qx,qy,qz,qw",
        ),
        _ => None,
    }
}

/// Each line that is not empty, without a byte order mark; errors name it.
fn each_line(
    file: &Path,
    mut take: impl FnMut(&str) -> Result<(), String>,
) -> Result<(), ReferenceError> {
    let opened = File::open(file).map_err(|source| ReferenceError::Unreadable {
        path: file.to_owned(),
        source,
    })?;
    for (number, line) in (1..).zip(bounded_lines(BufReader::new(opened))) {
        let taken = line.map_err(|cause| cause.to_string()).and_then(|line| {
            match line.trim_start_matches('\u{feff}').trim() {
                "" => Ok(()),
                line => take(line),
            }
        });
        taken.map_err(|cause| ReferenceError::Line {
            path: file.to_owned(),
            line: number,
            cause,
        })?;
    }
    Ok(())
}

fn checked(position: [f64; 3], orientation: [f64; 4]) -> Result<Pose, String> {
    let parts = PoseParts {
        position,
        orientation,
    };
    parts.to_pose().map_err(|cause| cause.to_string())
}

fn pose_of(position: [f64; 3], [x, y, z, w]: [f64; 4]) -> Pose {
    Pose::from_parts(
        Translation3::from(position),
        unit_quaternion(Quaternion::new(w, x, y, z)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_of_a_robot_have_a_header_and_times_or_numbers_of_images() {
        let folder = tempfile::tempdir().unwrap();
        let read_text = |name: &str, text: &str| {
            let file = folder.path().join(name);
            std::fs::write(&file, text).unwrap();
            read_poses(&file).map_err(|error| error.to_string())
        };
        let poses: BTreeMap<u64, Pose> = [(7, Pose::translation(1.0, 2.0, 3.0))].into();
        let by_image = read_text("a.csv", "image,x,y,z,qx,qy,qz,qw\n7,1,2,3,0,0,0,1\n");
        assert_eq!(by_image, Ok(KeyedPoses::ByImage(poses.clone())));
        let euroc = "t [ns],x,y,z,qw,qx,qy,qz\n7,1,2,3,1,0,0,0\n";
        assert_eq!(read_text("a.csv", euroc), Ok(KeyedPoses::ByTime(poses)));
        let bare = read_text("a.csv", "7,1,2,3,0,0,0,1\n").unwrap_err();
        assert!(bare.contains("a.csv:1: no header"), "{bare}");
        let twice = "image,x,y,z,qx,qy,qz,qw\n7,1,2,3,0,0,0,1\n7,1,2,3,0,0,0,1\n";
        let twice = read_text("a.csv", twice).unwrap_err();
        assert!(
            twice.contains("a.csv:3: image 7 has a pose already"),
            "{twice}"
        );
        assert!(
            read_text("a.xyz", "")
                .unwrap_err()
                .contains(".csv, .tum or .txt")
        );
    }

    #[test]
    fn a_pose_lies_between_its_neighbours_unless_they_are_far_apart() {
        let poses = [(0, 0.0), (100, 1.0), (100 + 2 * LONGEST_GAP_NS, 2.0)];
        let pose = |(t_ns, x)| (t_ns, Pose::translation(x, 0.0, 0.0));
        let trajectory = Trajectory(poses.map(pose).into());
        let x = |t_ns| trajectory.at(t_ns).map(|pose| pose.translation.x);
        assert_eq!([x(0), x(25), x(100)], [Some(0.0), Some(0.25), Some(1.0)]);
        assert_eq!(x(200), None);
        assert_eq!(x(u64::MAX), None);
    }

    #[test]
    fn a_table_is_read_by_its_header() {
        let folder = tempfile::tempdir().unwrap();
        let objects = [ObjectId::new("cube").unwrap()].into();
        let read_text = |name: &str, text: &str| {
            let file = folder.path().join(name);
            std::fs::write(&file, text).unwrap();
            read(&[file], &objects).map(|mut read| read.pop_first().unwrap().1)
        };
        let expected =
            Trajectory([(1_700_000_000_000_000_000, Pose::translation(1.0, 2.0, 3.0))].into());
        for (name, text) in [
            (
                "a.csv",
                "#timestamp [ns],tx,ty,tz,qx,qy,qz,qw\n1700000000000000000,1,2,3,0,0,0,1\n",
            ),
            (
                "a.csv",
                "\u{feff}time [s],x [mm],y [mm],z [mm],qw,qx,qy,qz\r\n1700000000.0,1000,2000,3000,1,0,0,0\r\n",
            ),
            ("a.csv", "# EuRoC\n1700000000000000000,1,2,3,1,0,0,0\n"),
            (
                "a.tum",
                "1.700000000000000000e+09 1.0e+00 2.0e+00 3.0e+00 0.0e+00 0.0e+00 0.0e+00 1.0e+00\n",
            ),
            ("a.txt", "# of the lab\n1700000000.0 1 2 3 0 0 0 1\n"),
        ] {
            assert_eq!(read_text(name, text).unwrap(), expected, "{text}");
        }
        let spreadsheet = "sep=;\r\ntime [s];x;y;z;qx;qy;qz;qw\r\n\
            1700000000,0;1,0;2,0;3,0;0;0;0;1\r\n1700000000,1;;;;;;;\r\n";
        assert_eq!(read_text("a.csv", spreadsheet).unwrap(), expected);
        let motive = "Format Version,1.23,Take Name,Take 1\r\n\r\n,Type,Rigid Body\r\n";
        let error = read_text("a.csv", motive).unwrap_err().to_string();
        assert!(error.contains("an export of OptiTrack Motive"), "{error}");
        let error = read_text("a.txt", "NO_OF_FRAMES\t100\n")
            .unwrap_err()
            .to_string();
        assert!(error.contains("an export of QTM"), "{error}");
        let error = read_text("a.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("matrices") && error.contains("write seconds x y z"),
            "{error}"
        );
        let error = read_text("a.csv", "t,x,y,z,qx,qy,qz\n1,1,2,3,0,0,0\n").unwrap_err();
        assert!(
            error
                .to_string()
                .ends_with("a.csv:1: the header names no column qw"),
            "{error}"
        );
        let error = read_text("a.tum", "1 1 2 3 0 0 1\n").unwrap_err();
        assert!(error.to_string().contains("write seconds x y z"), "{error}");
    }
}
