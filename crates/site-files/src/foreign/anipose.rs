//! Cameras of anipose (aniposelib, freemocap) and caliscope: TOML tables `cam_0` or `cameras.0` with `matrix`,
//! `distortions`, `size` and the pose `camera_from_world` as a rotation vector and a translation.
//!
//! Translations are in the unit of the calibration board, which the file does not name. Distances of 50 and more are
//! millimetres: cameras of one room are no 50 m apart, and no two of them 50 mm. `unit` in its table `metadata`, which
//! these tools pass over, says otherwise.

use super::distortion::{Keys, lens_of};
use super::matrix::{self, exactly, intrinsics, missing, numbers, pixels};
use super::name_of;
use crate::error::Complaint;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_site_model::{Camera, CameraId};
use yaml_serde::{Mapping, Value};

/// Greatest distance of a camera from the origin that is read as metres.
pub(super) const MOST_METRES: f64 = 50.0;

/// The tables of cameras, if the document has any.
fn tables(document: &Value) -> Option<&Mapping> {
    let tables = document.get("cameras").unwrap_or(document).as_mapping()?;
    tables.values().any(is_camera).then_some(tables)
}

fn is_camera(table: &Value) -> bool {
    table.get("matrix").is_some() && table.get("distortions").is_some()
}

/// Whether a document has cameras of these tools.
pub(super) fn has_cameras(document: &Value) -> bool {
    tables(document).is_some()
}

/// The cameras of a document, as the file orders them.
pub(super) fn cameras(document: &Value) -> Result<Vec<Camera>, Complaint> {
    let mut cameras = placed(document)?;
    let (metres, _) = unit_of(document, farthest(&cameras))?;
    let poses = cameras.iter_mut();
    for pose in poses.filter_map(|camera| camera.world_from_camera.as_mut()) {
        pose.translation.vector *= metres;
    }
    Ok(cameras)
}

/// The cameras with translations in the file's unit.
fn placed(document: &Value) -> Result<Vec<Camera>, Complaint> {
    let tables = tables(document).into_iter().flatten();
    let mut cameras = Vec::new();
    for (key, table) in tables.filter(|(_, table)| is_camera(table)) {
        let key = key.as_str().unwrap_or("camera");
        cameras.push(camera(key, table).map_err(|complaint| Complaint {
            key: format!("{key}.{}", complaint.key),
            ..complaint
        })?);
    }
    Ok(cameras)
}

/// Units of length in metres, by the word for each.
const UNITS: [(&str, f64); 3] = [("m", 1.0), ("cm", 1e-2), ("mm", 1e-3)];

/// The unit of translations in metres; and the word for it where it is assumed.
fn unit_of(document: &Value, farthest: f64) -> Result<(f64, Option<&'static str>), Complaint> {
    let named = document.get("metadata").and_then(|table| table.get("unit"));
    let Some(named) = named else {
        let word = if farthest < MOST_METRES {
            "metres"
        } else {
            "millimetres"
        };
        let metres = if farthest < MOST_METRES { 1.0 } else { 1e-3 };
        return Ok((metres, Some(word)));
    };
    let known = UNITS.iter().find(|(word, _)| named.as_str() == Some(word));
    match known {
        Some((_, metres)) => Ok((*metres, None)),
        None => Err(Complaint::new(
            "metadata.unit",
            "this is no unit of length that is known",
            "write m, cm or mm",
        )),
    }
}

/// What is assumed of the unit, where it matters.
pub(crate) fn assumption(document: &Value) -> Option<String> {
    let cameras = placed(document).ok()?;
    let farthest = farthest(&cameras);
    let (metres, word) = unit_of(document, farthest).ok()?;
    let word = word.filter(|_| farthest > 0.0)?;
    Some(format!(
        "lengths are taken for {word}, since the file does not say their unit: the farthest \
         camera is {:.3} m from the origin; else write unit = \"m\", \"cm\" or \"mm\" below [metadata] in it",
        farthest * metres
    ))
}

/// Distance of the farthest camera from the origin, in the file's unit.
fn farthest(cameras: &[Camera]) -> f64 {
    let poses = cameras.iter().filter_map(|camera| camera.world_from_camera);
    let distances = poses.map(|pose| pose.translation.vector.norm());
    distances.fold(0.0, f64::max)
}

fn camera(key: &str, table: &Value) -> Result<Camera, Complaint> {
    let value = |key: &'static str| table.get(key).ok_or_else(|| missing(key));
    let [width, height] = match value("size")?.as_sequence().map(Vec::as_slice) {
        Some([width, height]) => [pixels("size", width)?, pixels("size", height)?],
        _ => return Err(Complaint::new("size", "it is no width and height", "")),
    };
    let is_fisheye = table
        .get("fisheye")
        .and_then(Value::as_bool)
        .unwrap_or(false);
    let lens = lens_of(
        &Keys {
            model: "fisheye",
            coefficients: "distortions",
        },
        if is_fisheye { "fisheye" } else { "plumb_bob" },
        intrinsics("matrix", value("matrix")?)?,
        &numbers("distortions", value("distortions")?)?,
        [width, height],
    )?;
    let name = table.get("name").and_then(Value::as_str);
    let id = CameraId::new(&name_of(name.unwrap_or(key)))
        .map_err(|error| Complaint::new("name", error.to_string(), ""))?;
    Ok(Camera::new(id, [width, height], lens, pose(table)?))
}

/// `world_from_camera`, where the file has the inverse: the rotation as a rotation vector, or, in older files of
/// caliscope, as a matrix.
fn pose(table: &Value) -> Result<Option<Pose>, Complaint> {
    let list = |key: &'static str| {
        let value = table.get(key).filter(|value| !value.is_null());
        value.map(|value| numbers(key, value)).transpose()
    };
    let Some((rotation, translation)) = list("rotation")?.zip(list("translation")?) else {
        return Ok(None);
    };
    let [x, y, z] = exactly("translation", translation)?;
    let rotation = match rotation[..] {
        [a, b, c, d, e, f, g, h, i] => {
            let rows = [a, b, c, x, d, e, f, y, g, h, i, z, 0.0, 0.0, 0.0, 1.0];
            let rows: Vec<Value> = rows.into_iter().map(Value::from).collect();
            return Ok(Some(
                matrix::pose("rotation", &Value::from(rows))?.inverse(),
            ));
        }
        _ => Vector3::from(exactly::<3>("rotation", rotation)?),
    };
    let rotation = UnitQuaternion::from_scaled_axis(rotation);
    Ok(Some(
        Pose::from_parts(Translation3::new(x, y, z), rotation).inverse(),
    ))
}
