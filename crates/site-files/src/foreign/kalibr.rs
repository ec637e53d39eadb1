//! Kalibr's camera chains: `cam0`, `cam1`, ..., each with its pose relative to the previous one.

use super::distortion::{Keys, lens_of};
use super::matrix::{exactly, first, is_writable, missing, numbers, pixels, pose, rows_of};
use super::name_of;
use crate::error::Complaint;
use sextant_geometry::{Intrinsics, Lens, LensModel, Pose};
use sextant_site_model::{Camera, CameraId};
use std::fmt::Write as _;
use yaml_serde::Value;

const KEYS: Keys = Keys {
    model: "distortion_model",
    coefficients: "distortion_coeffs",
};

/// The cameras of a chain. With more than one, the first is the world frame.
pub(super) fn cameras(document: &Value) -> Result<Vec<Camera>, Complaint> {
    let links = links_of(document);
    if links.iter().all(|(name, _)| name.starts_with("cam")) {
        check_numbers(document, links.len())?;
    }
    let mut cameras: Vec<Camera> = Vec::new();
    let mut world_from_former = Pose::identity();
    for (index, (name, link)) in links.iter().enumerate() {
        let within = |complaint| inside(name, complaint);
        let former = index.checked_sub(1).map(|former| links[former].1);
        let world_from_camera = match former {
            Some(former) => world_from_former * former_from(former, link).map_err(within)?,
            None => Pose::identity(),
        };
        world_from_former = world_from_camera;
        let mut camera = camera(name, link).map_err(within)?;
        camera.world_from_camera = (links.len() > 1).then_some(world_from_camera);
        cameras.push(camera);
    }
    Ok(cameras)
}

/// Whether a document is EuRoC's `sensor.yaml` of a camera, which has the keys of a link.
pub(super) fn is_euroc(document: &Value) -> bool {
    let keys = ["camera_model", "intrinsics", "resolution"];
    keys.iter().all(|key| document.get(*key).is_some())
}

/// The camera of EuRoC's `sensor.yaml`. Its place on the body is passed over.
pub(super) fn euroc(document: &Value, name: &str) -> Result<Camera, Complaint> {
    camera(name, document)
}

/// Refuses a chain that lacks a camera before another: poses are relative to the one before.
fn check_numbers(document: &Value, n: usize) -> Result<(), Complaint> {
    let keys = document.as_mapping().into_iter().flatten();
    let number = |key: &Value| key.as_str()?.strip_prefix("cam")?.parse::<usize>().ok();
    let numbers = keys.filter_map(|(key, _)| number(key));
    match numbers.max() {
        Some(last) if n > 0 && last >= n => Err(Complaint::new(
            format!("cam{n}"),
            format!(
                "it is missing, but there is cam{last}: each pose is relative to the camera before"
            ),
            "give the whole chain, numbered from cam0",
        )),
        _ => Ok(()),
    }
}

/// `cam0`, `cam1`, ... in this order; else every mapping that has a camera model, as the file orders them.
fn links_of(document: &Value) -> Vec<(String, &Value)> {
    let numbered = (0..).map_while(|index| {
        let name = format!("cam{index}");
        document.get(&name).map(|link| (name, link))
    });
    let numbered: Vec<_> = numbered.collect();
    if !numbered.is_empty() {
        return numbered;
    }
    let entries = document.as_mapping().into_iter().flatten();
    let cameras = entries.filter(|(_, value)| {
        value.get("camera_model").is_some() && value.get("intrinsics").is_some()
    });
    let named = cameras.filter_map(|(name, link)| Some((name.as_str()?.to_owned(), link)));
    named.collect()
}

/// Whether a document is a chain: its entries have lenses, or poses relative to one another.
pub(super) fn is_chain(document: &Value) -> bool {
    const OF_LINKS: [&str; 5] = [
        "camera_model",
        "intrinsics",
        "distortion_model",
        "distortion_coeffs",
        "resolution",
    ];
    let has = |link: &Value| OF_LINKS.iter().any(|key| link.get(*key).is_some());
    links_of(document).iter().any(|(_, link)| has(link))
}

fn inside(name: &str, complaint: Complaint) -> Complaint {
    Complaint {
        key: format!("{name}.{}", complaint.key),
        ..complaint
    }
}

/// Maps points of a camera into the previous one of the chain.
fn former_from(former: &Value, link: &Value) -> Result<Pose, Complaint> {
    let stated =
        |value: &Value, key: &'static str| value.get(key).map(|value| pose(key, value)).transpose();
    if let Some(this_from_former) = stated(link, "T_cn_cnm1")? {
        return Ok(this_from_former.inverse());
    }
    let key = "T_cam_imu";
    match (stated(former, key)?, stated(link, key)?) {
        (Some(former_from_imu), Some(this_from_imu)) => {
            Ok(former_from_imu * this_from_imu.inverse())
        }
        _ => Err(missing("T_cn_cnm1")),
    }
}

fn camera(name: &str, link: &Value) -> Result<Camera, Complaint> {
    let text = |key: &str| link.get(key).and_then(Value::as_str);
    if let Some(model) = text("camera_model").filter(|&model| model != "pinhole") {
        let cause = format!("the camera model `{model}` has no counterpart here");
        let remedy = "calibrate with pinhole-radtan or pinhole-equi";
        return Err(Complaint::new("camera_model", cause, remedy));
    }
    let list = |key: &'static str| {
        let spellings = [key, "distortion_coefficients"];
        let n = 1 + usize::from(key == KEYS.coefficients);
        let (key, value) = first(link, &spellings[..n]).ok_or_else(|| missing(key))?;
        numbers(key, value)
    };
    let [fx, fy, cx, cy] = exactly("intrinsics", list("intrinsics")?)?;
    let model = text(KEYS.model).unwrap_or("none");
    let coefficients = match model {
        "none" => Vec::new(),
        _ => list(KEYS.coefficients)?,
    };
    let size = resolution(link)?;
    let lens = lens_of(
        &KEYS,
        model,
        Intrinsics { fx, fy, cx, cy },
        &coefficients,
        size,
    )?;
    Ok(Camera::new(
        CameraId::new(&name_in(name, text("rostopic")))
            .map_err(|error| Complaint::new("rostopic", error.to_string(), ""))?,
        size,
        lens,
        None,
    ))
}

fn resolution(link: &Value) -> Result<[u32; 2], Complaint> {
    let (key, value) = first(link, &["resolution"]).ok_or_else(|| missing("resolution"))?;
    match value.as_sequence().map(Vec::as_slice) {
        Some([width, height]) => Ok([pixels(key, width)?, pixels(key, height)?]),
        _ => Err(Complaint::new(key, "it is no width and height", "")),
    }
}

/// `/north/image_raw` becomes the camera `north`; without such a topic the name is that of the entry.
fn name_in(name: &str, topic: Option<&str>) -> String {
    let parts: Vec<&str> = topic
        .unwrap_or("")
        .split('/')
        .filter(|part| !part.is_empty())
        .collect();
    match parts.as_slice() {
        [.., camera, _image] => name_of(camera),
        _ => name_of(name),
    }
}

/// The chain of cameras. Unknown poses are omitted.
pub(super) fn text(cameras: &[Camera]) -> Result<String, Complaint> {
    let mut text = String::new();
    for (index, camera) in cameras.iter().enumerate() {
        let [width, height] = camera.resolution;
        let Intrinsics { fx, fy, cx, cy } = camera.lens.intrinsics();
        let (model, coefficients) = radtan(camera, &camera.lens)?;
        // Writing to a String cannot fail.
        let _ = writeln!(text, "cam{index}:");
        let former = index.checked_sub(1).map(|former| &cameras[former]);
        if let Some(rows) = former.and_then(|former| link(former, camera)) {
            text.push_str("  T_cn_cnm1:\n");
            for row in rows {
                let _ = writeln!(text, "  - {row:?}");
            }
        }
        let _ = write!(
            text,
            "  camera_model: pinhole
  distortion_coeffs: {coefficients:?}
  distortion_model: {model}
  intrinsics: [{fx:?}, {fy:?}, {cx:?}, {cy:?}]
  resolution: [{width}, {height}]
  rostopic: /{}/image_raw
",
            camera.id
        );
    }
    Ok(text)
}

/// T_cn_cnm1 of successive cameras.
fn link(former: &Camera, camera: &Camera) -> Option<[[f64; 4]; 4]> {
    let this_from_former = camera.world_from_camera?.inverse() * former.world_from_camera?;
    is_writable(&this_from_former).then(|| rows_of(&this_from_former))
}

fn radtan(camera: &Camera, lens: &Lens) -> Result<(&'static str, Vec<f64>), Complaint> {
    match (lens.model(), lens.distortion()) {
        (LensModel::KannalaBrandt, coefficients) => Ok(("equidistant", coefficients.to_vec())),
        (LensModel::BrownConrady, [radial_and_tangential @ .., k3]) if *k3 == 0.0 => {
            Ok(("radtan", radial_and_tangential.to_vec()))
        }
        (LensModel::BrownConrady, _) => Err(Complaint::new(
            "",
            format!(
                "camera \"{}\" has a third radial term (k3), which Kalibr's radtan lacks",
                camera.id
            ),
            "calibrate it as kannala-brandt (Kalibr's equidistant), or export as ROS or OpenCV",
        )),
        (LensModel::Pinhole, _) => Ok(("radtan", vec![0.0; 4])),
    }
}
