//! Cameras of anipose (aniposelib, freemocap) and caliscope: TOML tables `cam_0` or `cameras.0` with `matrix`, `distortions`, `size`
//! and the pose `camera_from_world` as a rotation vector and a translation.
//!
//! Translations are in the unit of the calibration board, which the file does not name. Distances of 50 and more are millimetres:
//! cameras of one room are no 50 m apart, and no two of them 50 mm.

use super::distortion::{Keys, lens_of};
use super::matrix::{exactly, intrinsics, missing, numbers, pixels};
use super::name_of;
use crate::error::Complaint;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_site_model::{Camera, CameraId};
use yaml_serde::{Mapping, Value};

/// Greatest distance of a camera from the origin that is read as metres.
const MOST_METRES: f64 = 50.0;

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
    let tables = tables(document).into_iter().flatten();
    let mut cameras = Vec::new();
    for (key, table) in tables.filter(|(_, table)| is_camera(table)) {
        let key = key.as_str().unwrap_or("camera");
        cameras.push(camera(key, table).map_err(|complaint| Complaint {
            key: format!("{key}.{}", complaint.key),
            ..complaint
        })?);
    }
    let distances = cameras.iter().filter_map(|camera| camera.world_from_camera);
    let farthest = distances
        .map(|pose| pose.translation.vector.norm())
        .fold(0.0, f64::max);
    if farthest >= MOST_METRES {
        for pose in cameras
            .iter_mut()
            .filter_map(|camera| camera.world_from_camera.as_mut())
        {
            pose.translation.vector *= 1e-3;
        }
    }
    Ok(cameras)
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

/// `world_from_camera`, where the file has the inverse.
fn pose(table: &Value) -> Result<Option<Pose>, Complaint> {
    let vector = |key: &'static str| match table.get(key).filter(|value| !value.is_null()) {
        Some(value) => exactly::<3>(key, numbers(key, value)?).map(|v| Some(Vector3::from(v))),
        None => Ok(None),
    };
    let (rotation, translation) = (vector("rotation")?, vector("translation")?);
    Ok(rotation.zip(translation).map(|(rotation, translation)| {
        let rotation = UnitQuaternion::from_scaled_axis(rotation);
        Pose::from_parts(Translation3::from(translation), rotation).inverse()
    }))
}
