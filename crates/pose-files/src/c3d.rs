//! C3D (c3d.org, user guide of 2021), the file of biomechanics: of each object a point, its origin, and a rotation, as
//! Theia3D and Visual3D have them.
//!
//! Blocks of 512 bytes: a header, parameters in groups, points, rotations. All numbers are little-endian; points are
//! 32-bit floats in millimetres. A C3D file has a constant rate: each frame takes the pose that is nearest in time, if
//! that is within half a frame. Where there is none, the residual and the reliability are -1.

use crate::narrowed;
use sextant_geometry::Pose;
use sextant_site_model::ObjectId;
use sextant_site_report::{ObjectEstimate, State};
use std::collections::BTreeMap;

const BLOCK_BYTES: usize = 512;
const HEADER_MARK: [u8; 2] = [2, 0x50];
/// Little-endian integers, IEEE floats.
const INTEL: u8 = 84;
/// Frames of a longer file would have no number, and a longer list of names none either.
const MAX_FRAMES: usize = 10_000_000;
const MAX_OBJECTS: usize = 255;
const MAX_BLOCKS: usize = 65_535;
/// A mark that points are floats.
const SCALE: f32 = -1.0;
/// Of a rotation: a 4x4 matrix, column by column, and its reliability.
const ROTATION_FLOATS: usize = 17;

/// What does not fit a C3D file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum C3dError {
    /// Fewer than two capture times.
    #[error("a C3D file needs poses of two times at least")]
    TooShort,
    /// Too many frames or objects.
    #[error(
        "a C3D file holds 255 objects and about 30 MB of points; take fewer objects or a part of the time"
    )]
    TooLong,
}

/// Poses as a C3D file.
///
/// # Errors
/// See [`C3dError`].
pub fn c3d(poses: &[ObjectEstimate]) -> Result<Vec<u8>, C3dError> {
    let grid = Grid::from_poses(poses).ok_or(C3dError::TooShort)?;
    let mut objects: BTreeMap<&ObjectId, Vec<&ObjectEstimate>> = BTreeMap::new();
    for pose in poses {
        objects.entry(&pose.object).or_default().push(pose);
    }
    let n_point_blocks = (objects.len() * 16 * grid.n_frames).div_ceil(BLOCK_BYTES);
    let is_too_long = grid.n_frames > MAX_FRAMES || n_point_blocks > MAX_BLOCKS - 64;
    if objects.len() > MAX_OBJECTS || is_too_long {
        return Err(C3dError::TooLong);
    }
    let names: Vec<&str> = objects.keys().map(|name| name.as_str()).collect();
    // The numbers of blocks are of a fixed length.
    let n_parameter_blocks = parameters(&names, &grid, 0, 0).len() / BLOCK_BYTES;
    let points_at = 2 + n_parameter_blocks;
    let rotations_at = points_at + n_point_blocks;
    let mut file = header(names.len(), &grid, points_at);
    file.extend(parameters(&names, &grid, points_at, rotations_at));
    let samples: Vec<Vec<Option<&ObjectEstimate>>> =
        objects.values().map(|poses| grid.sampled(poses)).collect();
    for write in [write_point, write_rotation] {
        for frame in 0..grid.n_frames {
            for object in &samples {
                write(&mut file, object[frame]);
            }
        }
        pad(&mut file);
    }
    Ok(file)
}

/// Frames at a constant rate.
struct Grid {
    start_ns: u64,
    period_ns: u64,
    n_frames: usize,
}

impl Grid {
    /// From the first pose to the last, at the usual interval of the poses of an object.
    fn from_poses(poses: &[ObjectEstimate]) -> Option<Self> {
        let mut times: BTreeMap<&ObjectId, Vec<u64>> = BTreeMap::new();
        for pose in poses {
            times.entry(&pose.object).or_default().push(pose.capture_ns);
        }
        let mut intervals: Vec<u64> = Vec::new();
        for times in times.values_mut() {
            times.sort_unstable();
            times.dedup();
            intervals.extend(times.windows(2).map(|pair| pair[1] - pair[0]));
        }
        let middle = intervals.len().checked_sub(1)? / 2;
        let median_ns = *intervals.select_nth_unstable(middle).1;
        // Their mean without gaps: an error of the median would add up from frame to frame.
        let is_usual = |interval: &u64| interval.abs_diff(median_ns) <= median_ns / 2;
        intervals.retain(is_usual);
        let mean_ns = intervals.iter().sum::<u64>() / intervals.len() as u64;
        // A rate of a thousand a second at most.
        let period_ns = mean_ns.max(1_000_000);
        let all = || poses.iter().map(|pose| pose.capture_ns);
        let (start_ns, end_ns) = (all().min()?, all().max()?);
        let n_frames = (end_ns - start_ns).div_ceil(period_ns) + 1;
        Some(Self {
            start_ns,
            period_ns,
            n_frames: usize::try_from(n_frames).ok()?,
        })
    }

    fn rate_hz(&self) -> f32 {
        (1e9 / self.period_ns as f64) as f32
    }

    /// Of each frame the pose that is nearest, within half a period.
    fn sampled<'a>(&self, poses: &[&'a ObjectEstimate]) -> Vec<Option<&'a ObjectEstimate>> {
        let mut frames: Vec<Option<&ObjectEstimate>> = vec![None; self.n_frames];
        for pose in poses {
            let since = pose.capture_ns - self.start_ns;
            let place = (since + self.period_ns / 2) / self.period_ns;
            let time = place * self.period_ns;
            let off = |pose: &ObjectEstimate| (pose.capture_ns - self.start_ns).abs_diff(time);
            if let Some(frame) = frames.get_mut(place as usize)
                && frame.is_none_or(|other| off(pose) <= off(other))
            {
                *frame = Some(pose);
            }
        }
        frames
    }
}

fn header(n_points: usize, grid: &Grid, points_at: usize) -> Vec<u8> {
    let mut block = HEADER_MARK.to_vec();
    let last = grid.n_frames.min(usize::from(u16::MAX));
    // Points, analogue samples, first and last frame, longest gap that was filled.
    for number in [n_points, 0, 1, last, 0] {
        block.extend((number as u16).to_le_bytes());
    }
    block.extend(SCALE.to_le_bytes());
    block.extend((points_at as u16).to_le_bytes());
    block.extend([0; 2]);
    block.extend(grid.rate_hz().to_le_bytes());
    pad(&mut block);
    block
}

/// The section of parameters.
fn parameters(names: &[&str], grid: &Grid, points_at: usize, rotations_at: usize) -> Vec<u8> {
    let mut section = vec![1, 0x50, 0, INTEL];
    for (number, (group, parameters)) in (1..).zip(groups(names, grid, points_at, rotations_at)) {
        entry(&mut section, group, -number, &[]);
        for (name, value) in parameters {
            entry(&mut section, name, number, &value.0);
        }
    }
    section.push(0);
    pad(&mut section);
    section[2] = (section.len() / BLOCK_BYTES) as u8;
    section
}

/// A group of parameters by its name, with their names and values.
type Group = (&'static str, Vec<(&'static str, Value)>);

fn groups(names: &[&str], grid: &Grid, points_at: usize, rotations_at: usize) -> [Group; 5] {
    let n_frames = grid.n_frames.min(usize::from(u16::MAX)) as u16;
    let n_objects = names.len() as u16;
    let count = Value::integers;
    [
        (
            "POINT",
            vec![
                ("USED", count(&[n_objects])),
                ("FRAMES", count(&[n_frames])),
                ("DATA_START", count(&[points_at as u16])),
                ("SCALE", Value::float(SCALE)),
                ("RATE", Value::float(grid.rate_hz())),
                ("UNITS", Value::texts(&["mm"])),
                ("LABELS", Value::texts(names)),
                ("X_SCREEN", Value::texts(&["+X"])),
                ("Y_SCREEN", Value::texts(&["+Z"])),
            ],
        ),
        ("ANALOG", vec![("USED", count(&[0]))]),
        (
            "ROTATION",
            vec![
                ("USED", count(&[n_objects])),
                ("DATA_START", count(&[rotations_at as u16])),
                ("RATE", Value::float(grid.rate_hz())),
                ("RATIO", count(&[1])),
                ("LABELS", Value::texts(names)),
            ],
        ),
        (
            "TRIAL",
            vec![
                ("ACTUAL_START_FIELD", count(&[1, 0])),
                (
                    "ACTUAL_END_FIELD",
                    count(&[grid.n_frames as u16, (grid.n_frames >> 16) as u16]),
                ),
                ("CAMERA_RATE", Value::float(grid.rate_hz())),
            ],
        ),
        (
            "MANUFACTURER",
            vec![
                ("COMPANY", Value::texts(&["Sextant"])),
                ("START_TIME_NS", Value::texts(&[&grid.start_ns.to_string()])),
            ],
        ),
    ]
}

/// A group or a parameter of one, without description.
fn entry(section: &mut Vec<u8>, name: &str, number: i8, value: &[u8]) {
    section.extend([name.len() as u8, number as u8]);
    section.extend(name.as_bytes());
    // To the next entry, from here on.
    section.extend((2 + value.len() as u16 + 1).to_le_bytes());
    section.extend(value);
    section.push(0);
}

/// Type, dimensions and content of a parameter.
struct Value(Vec<u8>);

impl Value {
    fn integers(numbers: &[u16]) -> Self {
        let mut bytes = match numbers {
            [_] => vec![2, 0],
            _ => vec![2, 1, numbers.len() as u8],
        };
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        Self(bytes)
    }

    fn float(number: f32) -> Self {
        Self([&[4, 0][..], &number.to_le_bytes()].concat())
    }

    fn texts(texts: &[&str]) -> Self {
        let length = texts.iter().map(|text| text.len()).max().unwrap_or(0);
        let mut bytes = vec![0xff, 2, length as u8, texts.len() as u8];
        for text in texts {
            bytes.extend(format!("{text:length$}").as_bytes());
        }
        Self(bytes)
    }
}

/// Whether an object is where its pose says; a prediction counts as none.
fn tracked(pose: Option<&ObjectEstimate>) -> Option<&ObjectEstimate> {
    pose.filter(|pose| pose.state == State::Tracking)
}

/// x, y, z in millimetres, and whether they are valid: readers disagree about residuals other than 0 and -1.
fn write_point(file: &mut Vec<u8>, pose: Option<&ObjectEstimate>) {
    let point = tracked(pose).map_or([0.0, 0.0, 0.0, -1.0], |pose| {
        let [x, y, z] = (pose.world_from_object.translation.vector * 1000.0).into();
        [narrowed(x), narrowed(y), narrowed(z), 0.0]
    });
    write_floats(file, &point);
}

fn write_rotation(file: &mut Vec<u8>, pose: Option<&ObjectEstimate>) {
    let mut floats = [0.0; ROTATION_FLOATS];
    match tracked(pose) {
        Some(pose) => {
            let matrix = in_millimetres(&pose.world_from_object).to_homogeneous();
            for (place, value) in floats.iter_mut().zip(matrix.iter()) {
                *place = narrowed(*value);
            }
        }
        None => floats[ROTATION_FLOATS - 1] = -1.0,
    }
    write_floats(file, &floats);
}

fn in_millimetres(pose: &Pose) -> Pose {
    Pose::from_parts((pose.translation.vector * 1000.0).into(), pose.rotation)
}

fn write_floats(file: &mut Vec<u8>, floats: &[f32]) {
    for float in floats {
        file.extend(float.to_le_bytes());
    }
}

/// Fills the last block.
fn pad(file: &mut Vec<u8>) {
    file.resize(file.len().next_multiple_of(BLOCK_BYTES), 0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix6, Translation3, UnitQuaternion, Vector6};

    fn pose(object: &str, t_ms: u64, x: f64) -> ObjectEstimate {
        ObjectEstimate {
            object: ObjectId::new(object).unwrap(),
            capture_ns: 1_800_000_000_000_000_000 + t_ms * 1_000_000,
            world_from_object: Pose::from_parts(
                Translation3::new(x, -2.0, 3.0),
                UnitQuaternion::identity(),
            ),
            covariance: Matrix6::identity() * 1e-6,
            twist: Vector6::zeros(),
            state: State::Tracking,
            cameras: 1,
            tags: 1,
            rms_px: 0.1,
            articulated: None,
        }
    }

    fn float(file: &[u8], at: usize) -> f32 {
        f32::from_le_bytes(file[at..at + 4].try_into().unwrap())
    }

    /// `clients/python/tests/test_c3d.py` reads such a file with ezc3d.
    #[test]
    fn frames_without_a_pose_are_marked() {
        let poses = [
            pose("cube", 0, 1.0),
            pose("ball", 0, 5.0),
            pose("cube", 10, 1.1),
            // One that is late, and one that is missing.
            pose("cube", 21, 1.2),
            pose("cube", 30, 1.3),
            pose("cube", 50, 1.5),
        ];
        let file = c3d(&poses).unwrap();
        assert_eq!(file.len() % BLOCK_BYTES, 0);
        assert_eq!(file[..10], [2, 0x50, 2, 0, 0, 0, 1, 0, 6, 0]);
        assert_eq!(float(&file, 20), 100.0);
        let points = BLOCK_BYTES * (usize::from(file[16]) - 1);
        let at = |frame: usize, object: usize| {
            let at = points + 16 * (2 * frame + object);
            [0, 4, 8, 12].map(|place| float(&file, at + place))
        };
        assert_eq!(at(0, 0), [5000.0, -2000.0, 3000.0, 0.0]);
        assert_eq!(at(0, 1), [1000.0, -2000.0, 3000.0, 0.0]);
        assert_eq!(at(1, 0)[3], -1.0);
        assert_eq!(at(2, 1)[0], 1200.0);
        assert_eq!(at(4, 1), [0.0, 0.0, 0.0, -1.0]);
        assert_eq!(at(5, 1)[0], 1500.0);
    }

    #[test]
    fn too_few_poses_and_too_many_frames_are_errors() {
        assert_eq!(c3d(&[]), Err(C3dError::TooShort));
        assert_eq!(c3d(&[pose("cube", 0, 1.0)]), Err(C3dError::TooShort));
        let years = [
            pose("cube", 0, 1.0),
            pose("cube", 1, 1.0),
            pose("cube", 1 << 40, 1.0),
        ];
        assert_eq!(c3d(&years), Err(C3dError::TooLong));
    }
}
