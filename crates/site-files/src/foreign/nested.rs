//! Files with several cameras one level below their top: MC-Calib's `calibrated_cameras_data.yml` (`nb_camera`,
//! `camera_0`, ...) and multical's `calibration.json` (`cameras`).
//!
//! MC-Calib's `camera_pose_matrix` is `world_from_camera`, the world being the reference camera, in the unit of its
//! board, which the file does not name: as for anipose, distances of 50 and more are millimetres. multical's poses are
//! not read.

use super::anipose::MOST_METRES;
use super::distortion::{Keys, lens_of};
use super::matrix::{intrinsics, missing, numbers, pixels, pose};
use super::name_of;
use crate::error::Complaint;
use sextant_site_model::{Camera, CameraId};
use yaml_serde::Value;

/// Whether a document is MC-Calib's.
pub(super) fn is_mc_calib(document: &Value) -> bool {
    document.get("nb_camera").is_some() && document.get("camera_0").is_some()
}

/// Whether a document is multical's.
pub(super) fn is_multical(document: &Value) -> bool {
    let mut cameras = entries(document, "cameras");
    cameras.any(|(_, camera)| camera.get("K").is_some() && camera.get("image_size").is_some())
}

fn entries<'a>(document: &'a Value, key: &str) -> impl Iterator<Item = (&'a str, &'a Value)> {
    let table = document.get(key).and_then(Value::as_mapping);
    let entries = table.into_iter().flatten();
    entries.filter_map(|(name, value)| Some((name.as_str()?, value)))
}

fn inside(name: &str) -> impl Fn(Complaint) -> Complaint {
    move |complaint| Complaint {
        key: format!("{name}.{}", complaint.key),
        ..complaint
    }
}

/// MC-Calib's cameras.
pub(super) fn mc_calib(document: &Value) -> Result<Vec<Camera>, Complaint> {
    let numbered = (0..).map_while(|number| {
        let name = format!("camera_{number}");
        document.get(&name).map(|table| (name, table))
    });
    let mut cameras = Vec::new();
    for (name, table) in numbered {
        cameras.push(mc_camera(&name, table).map_err(inside(&name))?);
    }
    let positions = cameras
        .iter()
        .filter_map(|camera: &Camera| camera.world_from_camera);
    let farthest = positions.map(|pose| pose.translation.vector.norm());
    let metres = match farthest.fold(0.0, f64::max) < MOST_METRES {
        true => 1.0,
        false => 1e-3,
    };
    let poses = cameras.iter_mut();
    for pose in poses.filter_map(|camera| camera.world_from_camera.as_mut()) {
        pose.translation.vector *= metres;
    }
    Ok(cameras)
}

fn mc_camera(name: &str, table: &Value) -> Result<Camera, Complaint> {
    let value = |key: &'static str| table.get(key).ok_or_else(|| missing(key));
    let size = [
        pixels("img_width", value("img_width")?)?,
        pixels("img_height", value("img_height")?)?,
    ];
    let is_fisheye = table.get("distortion_type").and_then(Value::as_u64) == Some(1);
    let lens_only = camera(&Source {
        name,
        matrix: ("camera_matrix", value("camera_matrix")?),
        coefficients: ("distortion_vector", value("distortion_vector")?),
        is_fisheye,
        size,
    })?;
    let key = "camera_pose_matrix";
    let pose = table.get(key).map(|value| pose(key, value)).transpose()?;
    Ok(Camera {
        world_from_camera: pose,
        ..lens_only
    })
}

/// multical's cameras, without places.
pub(super) fn multical(document: &Value) -> Result<Vec<Camera>, Complaint> {
    let cameras = entries(document, "cameras").map(|(name, table)| {
        let value = |key: &'static str| table.get(key).ok_or_else(|| missing(key));
        let read = || {
            let size = numbers("image_size", value("image_size")?)?;
            let [width, height] = size[..] else {
                return Err(Complaint::new(
                    "image_size",
                    "it is no width and height",
                    "",
                ));
            };
            let model = table.get("model").and_then(Value::as_str);
            camera(&Source {
                name,
                matrix: ("K", value("K")?),
                coefficients: ("dist", value("dist")?),
                is_fisheye: model == Some("fisheye"),
                size: [
                    pixels("image_size", &Value::from(width))?,
                    pixels("image_size", &Value::from(height))?,
                ],
            })
        };
        read().map_err(inside(&format!("cameras.{name}")))
    });
    cameras.collect()
}

/// What a file says of a camera's lens.
struct Source<'a> {
    name: &'a str,
    matrix: (&'static str, &'a Value),
    coefficients: (&'static str, &'a Value),
    is_fisheye: bool,
    size: [u32; 2],
}

fn camera(source: &Source<'_>) -> Result<Camera, Complaint> {
    let (matrix_key, matrix) = source.matrix;
    let (coefficients_key, coefficients) = source.coefficients;
    let lens = lens_of(
        &Keys {
            model: "model",
            coefficients: coefficients_key,
        },
        if source.is_fisheye {
            "fisheye"
        } else {
            "plumb_bob"
        },
        intrinsics(matrix_key, matrix)?,
        &numbers(coefficients_key, coefficients)?,
        source.size,
    )?;
    let id = CameraId::new(&name_of(source.name))
        .map_err(|error| Complaint::new("name", error.to_string(), ""))?;
    Ok(Camera::new(id, source.size, lens, None))
}
