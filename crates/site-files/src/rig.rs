//! `rig.toml`: the cameras of a site.

use crate::atomic::write_keeping_former;
use crate::document::Document;
use crate::error::{Complaint, FileError};
use crate::foreign::{is_foreign, parse_foreign};
use crate::pose::{SCALE_SIGMA_REMEDY, SigmaTable, pose_of, pose_toml, sigma_toml};
use crate::read::read_text;
use serde::Deserialize;
use sextant_geometry::{Lens, PoseParts};
use sextant_site_model::{
    Camera, CameraId, Exposure, LensSigma, Mount, ObjectId, PoseSigma, Rig, RigError, Stamp,
};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RigFile {
    /// Whether every number without a sigma is exact: a simulation.
    #[serde(default)]
    exact: bool,
    /// Standard deviation of the common scale, as a share of it; optional.
    scale_sigma: Option<f64>,
    #[serde(default)]
    camera: Vec<CameraTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    id: CameraId,
    /// Width, height, pixels.
    resolution: [u32; 2],
    lens: Lens,
    /// Standard deviation; optional.
    lens_sigma: Option<LensSigmaTable>,
    /// Omitted until calibrated.
    world_from_camera: Option<PoseParts>,
    /// Standard deviation; optional.
    world_from_camera_sigma: Option<SigmaTable>,
    /// The object that carries it; omitted where it stands still.
    carrier: Option<ObjectId>,
    /// Replaces `world_from_camera` there.
    carrier_from_camera: Option<PoseParts>,
    /// Standard deviation; optional.
    carrier_from_camera_sigma: Option<SigmaTable>,
    /// Line delay of a rolling shutter, s.
    line_delay: Option<f64>,
    /// Exposure time of a row, s.
    exposure: Option<f64>,
    /// Reference of timestamps; the middle of the exposure if omitted.
    stamp: Option<Stamp>,
}

/// Standard deviations.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LensSigmaTable {
    /// Of fx and fy together, px.
    focal: f64,
    /// In the corners of the image, px.
    distortion: f64,
}

/// The rig of a file: `rig.toml`, or a calibration of another tool, recognised by its content.
///
/// # Errors
/// A file that is missing, malformed, or invalid; with line, column, key and remedy.
pub fn read_rig(path: &Path) -> Result<Rig, FileError> {
    let text = read_text(path)?;
    if is_foreign(path, &text) {
        return Ok(parse_foreign(path, &text)?.1);
    }
    parse_rig(path, &text)
}

/// The rig of a text; `path` is for messages.
///
/// # Errors
/// As [`read_rig`].
pub fn parse_rig(path: &Path, text: &str) -> Result<Rig, FileError> {
    let document = Document::parse(path, text)?;
    let file: RigFile = document.read()?;
    let rig = rig_of(&file, &document).map_err(|complaint| document.complaint(complaint))?;
    Ok(rig)
}

fn rig_of(file: &RigFile, document: &Document<'_>) -> Result<Rig, Complaint> {
    if file.camera.is_empty() {
        let remedy = "add a [[camera]] table with id, resolution and lens";
        return Err(Complaint::new("", "the rig has no camera", remedy));
    }
    unique(file, document)?;
    let cameras: Result<Vec<Camera>, Complaint> = file
        .camera
        .iter()
        .enumerate()
        .map(|(i, it)| camera_of(i, it))
        .collect();
    let rig = Rig::new(cameras?).map_err(|error| complaint("camera", &error))?;
    let rig = rig
        .with_scale_sigma(file.scale_sigma)
        .map_err(|error| Complaint::new("scale_sigma", error.to_string(), SCALE_SIGMA_REMEDY))?;
    Ok(if file.exact { rig.exact() } else { rig })
}

fn exposure_of(table: &CameraTable, key: &str) -> Result<Option<Exposure>, Complaint> {
    let stamp = table.stamp.unwrap_or_default();
    match table.exposure {
        Some(length_s) => Ok(Some(Exposure { length_s, stamp })),
        None if stamp == Stamp::Middle => Ok(None),
        None => Err(Complaint::new(
            format!("{key}.stamp"),
            "this moment does not give the middle of the exposure without its length",
            "add `exposure = ...` in seconds, 0 where the images state their own",
        )),
    }
}

fn unique(file: &RigFile, document: &Document<'_>) -> Result<(), Complaint> {
    let mut first = BTreeMap::new();
    for (index, camera) in file.camera.iter().enumerate() {
        let key = format!("camera[{index}].id");
        if let Some(earlier) = first.insert(&camera.id, key.clone()) {
            let line = document.line_of(&earlier).unwrap_or(0);
            let cause = format!("camera \"{}\" is there already, on line {line}", camera.id);
            return Err(Complaint::new(
                key,
                cause,
                "give each camera its own id or remove one",
            ));
        }
    }
    Ok(())
}

fn camera_of(index: usize, table: &CameraTable) -> Result<Camera, Complaint> {
    let key = format!("camera[{index}]");
    let pose = pose_of(
        table.world_from_camera.as_ref(),
        &format!("{key}.world_from_camera"),
    )?;
    let mount = mount_of(table, &key)?;
    let pose_sigma = match &mount {
        None => &table.world_from_camera_sigma,
        Some(_) => &table.carrier_from_camera_sigma,
    };
    let pose_sigma = pose_sigma.as_ref().map(PoseSigma::from);
    let lens_sigma = table.lens_sigma.as_ref().map(|sigma| LensSigma {
        focal_px: sigma.focal,
        distortion_px: sigma.distortion,
    });
    let camera = Camera {
        mount,
        pose_prior: pose_sigma.into(),
        lens_prior: lens_sigma.into(),
        line_delay_s: table.line_delay,
        exposure: exposure_of(table, &key)?,
        ..Camera::new(table.id.clone(), table.resolution, table.lens, pose)
    };
    // A rig with this camera alone: the rules are the site model's, the location is known here.
    Rig::new(vec![camera.clone()]).map_err(|error| complaint(&key, &error))?;
    Ok(camera)
}

/// The place of a camera on its carrier; `None` where it has none.
fn mount_of(table: &CameraTable, key: &str) -> Result<Option<Mount>, Complaint> {
    let of_mount = [
        ("carrier_from_camera", table.carrier_from_camera.is_some()),
        (
            "carrier_from_camera_sigma",
            table.carrier_from_camera_sigma.is_some(),
        ),
    ];
    let Some(carrier) = &table.carrier else {
        return match of_mount.iter().find(|(_, is_there)| *is_there) {
            None => Ok(None),
            Some((part, _)) => Err(Complaint::new(
                format!("{key}.{part}"),
                "the camera has no carrier",
                "add `carrier = ...` with the object that carries it, or remove the key",
            )),
        };
    };
    if table.world_from_camera_sigma.is_some() {
        return Err(Complaint::new(
            format!("{key}.world_from_camera_sigma"),
            "the camera is carried",
            "write `carrier_from_camera_sigma`",
        ));
    }
    let part = format!("{key}.carrier_from_camera");
    match pose_of(table.carrier_from_camera.as_ref(), &part)? {
        Some(carrier_from_camera) => Ok(Some(Mount {
            carrier: carrier.clone(),
            carrier_from_camera,
        })),
        None => Err(Complaint::new(
            format!("{key}.carrier"),
            "the place of the camera on its carrier is missing",
            "add `carrier_from_camera = \
             { position = [x, y, z], orientation = [qx, qy, qz, qw] }`; `sextant calibrate robot --on-hand` finds it",
        )),
    }
}

fn complaint(key: &str, error: &RigError) -> Complaint {
    let (part, remedy) = match error {
        RigError::Resolution { .. } => (
            ".resolution",
            "write width and height of the camera's images in pixels",
        ),
        RigError::Pose(_) => (".world_from_camera", "write finite numbers"),
        RigError::Mount(_) => (".carrier_from_camera", "write finite numbers"),
        RigError::TwoPlaces(_) => (
            ".world_from_camera",
            "remove it, or `carrier` where the camera stands still",
        ),
        RigError::PoseSigma(_) => (
            ".world_from_camera_sigma",
            "write metres and radians, one sigma an axis, or leave it out",
        ),
        RigError::LensSigma(_) => (
            ".lens_sigma",
            "write pixels, one sigma each, or leave it out",
        ),
        RigError::LineDelay(_) => (
            ".line_delay",
            "write the seconds from a row to the next, or leave it out where all rows have one time",
        ),
        RigError::Exposure(_) => (
            ".exposure",
            "write the seconds for which a row is exposed, or leave it out",
        ),
        _ => ("", ""),
    };
    Complaint::new(format!("{key}{part}"), error.to_string(), remedy)
}

/// The text of a rig file. Numbers have enough digits to be read back exactly.
pub fn rig_toml(rig: &Rig) -> String {
    let mut text = String::new();
    if let Some(sigma) = rig.scale_sigma() {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "scale_sigma = {sigma:?}\n");
    }
    for camera in rig.cameras() {
        let [width, height] = camera.resolution;
        let _ = write!(
            text,
            "[[camera]]\nid = \"{}\"\nresolution = [{width}, {height}]\nlens = {}\n",
            camera.id,
            lens_toml(&camera.lens)
        );
        if let Some(sigma) = camera.lens_prior.given() {
            let _ = writeln!(
                text,
                "lens_sigma = {{ focal = {:?}, distortion = {:?} }}",
                sigma.focal_px, sigma.distortion_px
            );
        }
        if let Some(pose) = &camera.world_from_camera {
            let _ = writeln!(text, "world_from_camera = {}", pose_toml(&pose.into()));
        }
        if let Some(mount) = &camera.mount {
            let pose = pose_toml(&(&mount.carrier_from_camera).into());
            let _ = writeln!(
                text,
                "carrier = \"{}\"\ncarrier_from_camera = {pose}",
                mount.carrier
            );
        }
        if let Some(sigma) = camera.pose_prior.given() {
            let outer = camera.mount.as_ref().map_or("world", |_| "carrier");
            let _ = writeln!(text, "{outer}_from_camera_sigma = {}", sigma_toml(&sigma));
        }
        if let Some(delay_s) = camera.line_delay_s {
            let _ = writeln!(text, "line_delay = {delay_s:?}");
        }
        if let Some(exposure) = &camera.exposure {
            text += &exposure_toml(exposure);
        }
        text.push('\n');
    }
    text
}

/// Writes a rig file atomically; the former version is kept ([`crate::former_of`]).
///
/// # Errors
/// An error of the system; the old file is then unchanged.
pub fn write_rig(path: &Path, rig: &Rig) -> Result<(), FileError> {
    write_keeping_former(path, rig_toml(rig).as_bytes())
}

fn exposure_toml(exposure: &Exposure) -> String {
    let length = format!("exposure = {:?}\n", exposure.length_s);
    match exposure.stamp {
        Stamp::Middle => length,
        Stamp::Start => length + "stamp = \"start\"\n",
        Stamp::End => length + "stamp = \"end\"\n",
    }
}

fn lens_toml(lens: &Lens) -> String {
    let numbers = lens.intrinsics();
    let mut text = format!(
        "{{ model = \"{}\", fx = {:?}, fy = {:?}, cx = {:?}, cy = {:?}",
        lens.model(),
        numbers.fx,
        numbers.fy,
        numbers.cx,
        numbers.cy
    );
    if !lens.distortion().is_empty() {
        let _ = write!(text, ", distortion = {:?}", lens.distortion());
    }
    text + " }"
}

#[cfg(test)]
mod tests;
