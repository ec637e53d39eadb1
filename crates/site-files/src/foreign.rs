//! Calibrations of other tools: ROS `camera_info`, Kalibr `camchain` and OpenCV's YAML, read and written; OpenCV's JSON
//! and XML, PhotonVision, WPILib, anipose, caliscope, MATLAB, nerfstudio, camodocal, EuRoC, SLAM systems and makers of
//! cameras, read. What a file is, its content says, not its name.
//!
//! The three that are written count pixels from the centre of the top left one and look along z with y down, as here,
//! so lens parameters and camera axes are unchanged. Kalibr's chain gives each camera relative to the previous one
//! (`T_cn_cnm1`, a map of points of camera n-1 into camera n). Reading makes it `world_from_camera` with the first
//! camera as the world; writing accepts any world frame. The other two formats describe one camera without a pose.
//! Formats that count pixels from elsewhere are converted ([`others`]).
//!
//! Rational and thin-prism terms become the nearest lens that is known here ([`refit`]). What has no counterpart is
//! refused with the cause: skew, other models.

pub(crate) mod anipose;
mod camera_info;
mod distortion;
mod document;
mod kalibr;
mod matrix;
mod nested;
mod opencv;
mod others;
mod refit;
mod slam;

use crate::error::{Complaint, FileError, InvalidFile};
use crate::read::read_text;
pub use document::has_foreign_name;
pub(crate) use document::parse_document;
use document::{Syntax, syntax_of};
use sextant_geometry::Intrinsics;
use sextant_site_model::{Camera, Rig, RigError};
use std::fmt;
use std::path::Path;
use yaml_serde::Value;

/// A format of another tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForeignFormat {
    /// `camera_info` in a file of ROS, or a message as printed by `ros2 topic echo`.
    Ros,
    /// A camera chain written by `kalibr_calibrate_cameras`.
    Kalibr,
    /// A file of OpenCV's FileStorage, as in its calibration sample.
    OpenCv,
    /// A calibration of PhotonVision.
    PhotonVision,
    /// Cameras of anipose or caliscope.
    Anipose,
    /// MATLAB's `cameraParameters` as JSON.
    Matlab,
    /// nerfstudio's `transforms.json`.
    Nerfstudio,
    /// A camera file of camodocal, as VINS reads it.
    Camodocal,
    /// EuRoC's `sensor.yaml`.
    Euroc,
    /// Settings of ORB-SLAM or stella_vslam.
    OrbSlam,
    /// Basalt's calibration.
    Basalt,
    /// Intrinsics of a RealSense.
    RealSense,
    /// A ZED's configuration.
    Zed,
    /// Metashape's calibration as XML.
    Metashape,
    /// The cameras of MC-Calib.
    McCalib,
    /// The calibration of multical.
    Multical,
}

impl fmt::Display for ForeignFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ros => "ROS camera_info",
            Self::Kalibr => "Kalibr camchain",
            Self::OpenCv => "OpenCV YAML",
            Self::PhotonVision => "PhotonVision JSON",
            Self::Anipose => "anipose TOML",
            Self::Matlab => "MATLAB JSON",
            Self::Nerfstudio => "nerfstudio transforms.json",
            Self::Camodocal => "camodocal YAML",
            Self::Euroc => "EuRoC sensor.yaml",
            Self::OrbSlam => "ORB-SLAM YAML",
            Self::Basalt => "Basalt JSON",
            Self::RealSense => "RealSense JSON",
            Self::Zed => "ZED configuration",
            Self::Metashape => "Metashape XML",
            Self::McCalib => "MC-Calib YAML",
            Self::Multical => "multical JSON",
        })
    }
}

/// Whether a text is written as files of other tools are, and no file of this project.
pub fn is_foreign(path: &Path, text: &str) -> bool {
    match syntax_of(path, text) {
        Syntax::Yaml | Syntax::Xml => true,
        // Cameras of anipose and of the ZED; boards of anipose's projects are read with object files.
        Syntax::Toml => toml::from_str(text)
            .is_ok_and(|document| anipose::has_cameras(&document) || slam::has_zed(&document)),
    }
}

/// The cameras of another tool's file, and its format.
///
/// # Errors
/// A file that is missing, malformed, of unknown format, or with features that the lens models here lack.
pub fn read_foreign(path: &Path) -> Result<(ForeignFormat, Rig), FileError> {
    parse_foreign(path, &read_text(path)?)
}

/// As [`read_foreign`], for a text; `path` names a camera without a name, and is for messages.
///
/// # Errors
/// As [`read_foreign`].
pub fn parse_foreign(path: &Path, text: &str) -> Result<(ForeignFormat, Rig), FileError> {
    let document = parse_document(path, text)?;
    let wrong = |complaint| InvalidFile::with_all(path, complaint);
    let format = format_of(&document, text).ok_or_else(|| {
        if let Some(other) = other_file(&document) {
            return wrong(other);
        }
        wrong(Complaint::new(
            "",
            format!(
                "this is no calibration that is known: it has {}",
                keys_of(&document)
            ),
            "known are ROS camera_info (camera_matrix, distortion_model), Kalibr camchains \
             (cam0: ...), OpenCV's YAML, JSON and XML, PhotonVision, anipose, caliscope, MATLAB \
             as JSON, nerfstudio's transforms.json, EuRoC's sensor.yaml, ORB-SLAM, stella_vslam, \
             Basalt, RealSense, ZED, Metashape, MC-Calib and multical",
        ))
    })?;
    let one = |read: fn(&Value, &str) -> Result<Camera, Complaint>| {
        read(&document, stem_of(path)).map(|camera| vec![camera])
    };
    let cameras = match format {
        ForeignFormat::Kalibr => kalibr::cameras(&document),
        ForeignFormat::Anipose => anipose::cameras(&document),
        ForeignFormat::Matlab => one(others::matlab),
        ForeignFormat::Nerfstudio => one(others::nerfstudio),
        ForeignFormat::Camodocal => one(others::camodocal),
        ForeignFormat::Euroc => kalibr::euroc(&document, folder_or_stem(path)).map(|one| vec![one]),
        ForeignFormat::OrbSlam => slam::orb_slam(&document, stem_of(path)),
        ForeignFormat::Basalt => slam::basalt(&document),
        ForeignFormat::RealSense => one(slam::realsense),
        ForeignFormat::Zed => slam::zed(&document),
        ForeignFormat::Metashape => one(slam::metashape),
        ForeignFormat::McCalib => nested::mc_calib(&document),
        ForeignFormat::Multical => nested::multical(&document),
        ForeignFormat::Ros | ForeignFormat::OpenCv | ForeignFormat::PhotonVision => {
            camera_info::cameras(&document, stem_of(path))
        }
    };
    let cameras = cameras.and_then(|cameras| {
        // A region of interest may lie anywhere.
        let is_whole = document.get("roi").is_none();
        let mut checked = cameras.iter().filter(|_| is_whole);
        checked.try_for_each(check_size)?;
        Ok(cameras)
    });
    let rig = cameras.and_then(|cameras| Rig::new(cameras).map_err(|error| refused(&error)));
    Ok((format, rig.map_err(wrong)?))
}

/// The text of a camera in a format for one camera.
///
/// # Errors
/// [`ForeignFormat::Kalibr`]'s radtan has no third radial term.
pub fn foreign_text(format: ForeignFormat, cameras: &[Camera]) -> Result<String, Complaint> {
    let one = || match cameras {
        [camera] => Ok(camera),
        _ => Err(Complaint::new(
            "",
            format!("{format} holds one camera, there are {}", cameras.len()),
            "name one with --camera",
        )),
    };
    match format {
        ForeignFormat::Ros => Ok(camera_info::text(one()?)),
        ForeignFormat::OpenCv => Ok(opencv::text(one()?)),
        ForeignFormat::Kalibr => kalibr::text(cameras),
        other => Err(Complaint::new(
            "",
            format!("{other} is read, not written"),
            "write ROS, Kalibr or OpenCV",
        )),
    }
}

fn format_of(document: &Value, text: &str) -> Option<ForeignFormat> {
    let has = |key: &str| document.get(key).is_some();
    if nested::is_mc_calib(document) {
        Some(ForeignFormat::McCalib)
    } else if nested::is_multical(document) {
        Some(ForeignFormat::Multical)
    } else if kalibr::is_chain(document) {
        Some(ForeignFormat::Kalibr)
    } else if anipose::has_cameras(document) {
        Some(ForeignFormat::Anipose)
    } else if has("cameraIntrinsics") {
        Some(ForeignFormat::PhotonVision)
    } else if has("RadialDistortion") {
        Some(ForeignFormat::Matlab)
    } else if has("fl_x") {
        Some(ForeignFormat::Nerfstudio)
    } else if has("model_type") {
        Some(ForeignFormat::Camodocal)
    } else if slam::has_orb_slam(document) {
        Some(ForeignFormat::OrbSlam)
    } else if has("value0") {
        Some(ForeignFormat::Basalt)
    } else if has("ppx") {
        Some(ForeignFormat::RealSense)
    } else if slam::has_zed(document) {
        Some(ForeignFormat::Zed)
    } else if has("projection") && has("f") {
        Some(ForeignFormat::Metashape)
    } else if kalibr::is_euroc(document) {
        Some(ForeignFormat::Euroc)
    } else if text.starts_with("%YAML:1.0") || text.contains("opencv-matrix") {
        Some(ForeignFormat::OpenCv)
    } else if camera_info::MATRIX.into_iter().any(has) {
        Some(ForeignFormat::Ros)
    } else {
        None
    }
}

/// Files of other tools that are known and hold no lenses: the keys by which one knows them, at the top or below the
/// first entry, what they are, and what to do.
const OTHER_FILES: [(&[&str], &str, &str); 5] = [
    (
        &["pose"],
        "poses of cameras without lenses, as TagSLAM's camera_poses.yaml",
        "convert its cameras.yaml, which has the lenses, and write each pose into the rig as \
         world_from_camera, or find them by `sextant calibrate rig`",
    ),
    (
        &["bodies"],
        "bodies with tags, as TagSLAM's tagslam.yaml",
        "write each body as an object file: tag family, ids, sizes and poses (docs/models.md); the \
         cameras are in its cameras.yaml",
    ),
    (
        &["transformation", "parameters"],
        "the result of a hand-eye calibration by easy_handeye",
        "write its transformation into robot.toml as docs/robots.md shows, or calibrate by `sextant \
         calibrate robot`",
    ),
    (
        &["transform", "parameters"],
        "the result of a hand-eye calibration by easy_handeye2",
        "write its transform into robot.toml as docs/robots.md shows, or calibrate by `sextant \
         calibrate robot`",
    ),
    (
        &["nb_object"],
        "objects of MC-Calib",
        "its cameras are in calibrated_cameras_data.yml",
    ),
];

/// What a file is that has no lenses.
fn other_file(document: &Value) -> Option<Complaint> {
    let below = document.as_mapping().and_then(|keys| keys.values().next());
    let has = |keys: &[&str]| {
        let within = |value: &Value| keys.iter().all(|key| value.get(*key).is_some());
        within(document) || below.is_some_and(within)
    };
    let (_, what, remedy) = OTHER_FILES.iter().find(|(keys, ..)| has(keys))?;
    Some(Complaint::new(
        "",
        format!("this has no lens: {what}"),
        remedy.to_owned(),
    ))
}

/// The keys at the top of a document, in words.
fn keys_of(document: &Value) -> String {
    const SHOWN: usize = 8;
    let keys = document.as_mapping().into_iter().flatten();
    let keys: Vec<&str> = keys.filter_map(|(key, _)| key.as_str()).collect();
    let more = if keys.len() > SHOWN { ", ..." } else { "" };
    match keys.is_empty() {
        true => "no keys".to_owned(),
        false => format!(
            "the keys {}{more}",
            keys[..keys.len().min(SHOWN)].join(", ")
        ),
    }
}

/// Distance of a principal point from the middle of the image, as a share of the image, from which it may be that of
/// other images.
const OFF_CENTRE: f64 = 0.1;

/// Refuses a size that is not that of the images of the calibration: the principal point is outside of it, or in the
/// middle of the image only where width and height change places.
fn check_size(camera: &Camera) -> Result<(), Complaint> {
    let [width, height] = camera.resolution;
    let Intrinsics { cx, cy, .. } = camera.lens.intrinsics();
    let is_inside = |at: f64, pixels: u32| (0.0..=f64::from(pixels)).contains(&at);
    let is_central = |at: f64, pixels: u32| (at / f64::from(pixels) - 0.5).abs() < OFF_CENTRE;
    let (id, place) = (
        camera.id.as_str(),
        format!("the principal point ({cx:.0}, {cy:.0})"),
    );
    if is_central(cx, height)
        && is_central(cy, width)
        && !is_central(cx, width)
        && !is_central(cy, height)
    {
        let cause = format!(
            "{place} is in the middle of images of {height} x {width} pixels, not of {width} x {height}"
        );
        return Err(Complaint::new(id, cause, "exchange width and height"));
    }
    if is_inside(cx, width) && is_inside(cy, height) {
        return Ok(());
    }
    let cause = format!(
        "{place} lies outside of the images of {width} x {height} pixels: they are not those of the calibration"
    );
    let remedy = "state the size of the images with which it was calibrated";
    Err(Complaint::new(id, cause, remedy))
}

fn refused(error: &RigError) -> Complaint {
    Complaint::new("", error.to_string(), "")
}

/// Name of a file without folder and ending.
pub(crate) fn stem_of(path: &Path) -> &str {
    path.file_stem()
        .and_then(|stem| stem.to_str())
        .unwrap_or("camera")
}

/// As [`stem_of`]; of `cam0/sensor.yaml` the folder's name.
fn folder_or_stem(path: &Path) -> &str {
    let folder = path.parent().and_then(Path::file_name);
    let folder = folder.and_then(|name| name.to_str());
    folder
        .filter(|_| stem_of(path) == "sensor")
        .unwrap_or_else(|| stem_of(path))
}

/// Longest name, and how much of the beginning of a longer one is kept.
const MAX_NAME: usize = 32;
const KEPT_BEGINNING: usize = 11;

/// A valid name from a tool's name of a camera or file: lower case, other characters as `_`. A long one keeps its end,
/// in which the cameras of a recording differ.
pub(crate) fn name_of(said: &str) -> String {
    let letters = said.chars().map(|c| match c.to_ascii_lowercase() {
        c @ ('a'..='z' | '0'..='9' | '_' | '-') => c,
        _ => '_',
    });
    let letters: Vec<char> = letters.collect();
    let name: String = match letters.len().checked_sub(MAX_NAME - KEPT_BEGINNING) {
        Some(end) if letters.len() > MAX_NAME => {
            let (beginning, end) = (&letters[..KEPT_BEGINNING], &letters[end..]);
            beginning.iter().chain(end).collect()
        }
        _ => letters.into_iter().collect(),
    };
    if name.is_empty() {
        "camera".to_owned()
    } else {
        name
    }
}

#[cfg(test)]
mod tests;
