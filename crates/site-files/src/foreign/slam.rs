//! Cameras of SLAM systems and of the makers of cameras: parameters by name, `fx`, `k1` and so on. ORB-SLAM and
//! stella_vslam, Basalt, RealSense, the ZED and Metashape.

use super::distortion::{Keys, lens_of};
use super::matrix::{missing, pixels, pose};
use super::name_of;
use crate::error::Complaint;
use nalgebra::{Quaternion, Translation3};
use sextant_geometry::{Intrinsics, Pose, unit_quaternion};
use sextant_site_model::{Camera, CameraId};
use yaml_serde::{Mapping, Value};

const POLYNOMIAL: [&str; 8] = ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"];
const FISHEYE: [&str; 4] = ["k1", "k2", "k3", "k4"];

/// Finds a value of one camera by its name.
type Lookup<'a> = Box<dyn Fn(&str) -> Option<&'a Value> + 'a>;

/// The values of one camera by their names.
struct Parameters<'a> {
    value: Lookup<'a>,
    /// What the file calls the lens model, where it does.
    model: &'a str,
    size: [u32; 2],
}

impl Parameters<'_> {
    fn number(&self, key: &str) -> Result<Option<f64>, Complaint> {
        let finite = |value: &Value| {
            let number = value.as_f64().filter(|number| number.is_finite());
            number.ok_or_else(|| Complaint::new(key, "this is no finite number", ""))
        };
        (self.value)(key).map(finite).transpose()
    }

    fn needed(&self, key: &str) -> Result<f64, Complaint> {
        self.number(key)?.ok_or_else(|| missing(key))
    }

    fn camera(&self, name: &str) -> Result<Camera, Complaint> {
        let intrinsics = Intrinsics {
            fx: self.needed("fx")?,
            fy: self.needed("fy")?,
            cx: self.needed("cx")?,
            cy: self.needed("cy")?,
        };
        let (model, names): (_, &[&str]) = match &*self.model.to_lowercase() {
            "" | "pinhole" | "perspective" | "rectified" | "pinhole-radtan8" => {
                ("plumb_bob", &POLYNOMIAL)
            }
            "kannalabrandt8" | "fisheye" | "kb4" => ("equidistant", &FISHEYE),
            _ => (self.model, &[]),
        };
        let coefficients = names.iter().map(|key| Ok(self.number(key)?.unwrap_or(0.0)));
        let coefficients = coefficients.collect::<Result<Vec<f64>, Complaint>>()?;
        let keys = Keys {
            model: "model",
            coefficients: "k1",
        };
        let lens = lens_of(&keys, model, intrinsics, &coefficients, self.size)?;
        let id = CameraId::new(&name_of(name))
            .map_err(|error| Complaint::new("", error.to_string(), "rename the file"))?;
        Ok(Camera::new(id, self.size, lens, None))
    }
}

fn text(value: Option<&Value>) -> Option<&str> {
    value.and_then(Value::as_str)
}

/// `group.key` as OpenCV's files have it, or the key in a mapping of that name.
fn in_group<'a>(document: &'a Value, group: &str, key: &str) -> Option<&'a Value> {
    let flat = document.get(format!("{group}.{key}"));
    flat.or_else(|| document.get(group)?.get(key))
}

const GROUPS: [&str; 3] = ["Camera", "Camera1", "Camera2"];

/// Whether a document has a camera as ORB-SLAM and stella_vslam write it.
pub(super) fn has_orb_slam(document: &Value) -> bool {
    let mut groups = GROUPS.iter();
    groups.any(|group| in_group(document, group, "fx").is_some())
}

/// One camera, or ORB-SLAM 3's two, of which the first is the world where the file places them.
pub(super) fn orb_slam(document: &Value, stem: &str) -> Result<Vec<Camera>, Complaint> {
    let common = |keys: &[&str]| {
        keys.iter()
            .find_map(|key| in_group(document, "Camera", key))
    };
    let size = [&["width", "cols"], &["height", "rows"]].map(|keys| match common(keys) {
        Some(value) => pixels(keys[0], value),
        None => Err(Complaint::new(
            format!("Camera.{}", keys[0]),
            "the file does not say the size of the images",
            "add Camera.width and Camera.height, those with which it was calibrated",
        )),
    });
    let [width, height] = size;
    let size = [width?, height?];
    let groups = GROUPS.iter();
    let groups: Vec<&str> = groups
        .copied()
        .filter(|group| in_group(document, group, "fx").is_some())
        .collect();
    let mut cameras = Vec::new();
    for (number, group) in (1..).zip(&groups) {
        let parameters = Parameters {
            value: Box::new(|key| in_group(document, group, key)),
            model: text(common(&["type", "model"])).unwrap_or_default(),
            size,
        };
        let name = match groups.len() {
            1 => stem.to_owned(),
            _ => format!("{stem}_{number}"),
        };
        cameras.push(parameters.camera(&name)?);
    }
    if let ([first, second], Some(value)) =
        (&mut cameras[..], in_group(document, "Stereo", "T_c1_c2"))
    {
        first.world_from_camera = Some(Pose::identity());
        second.world_from_camera = Some(pose("Stereo.T_c1_c2", value)?);
    }
    Ok(cameras)
}

/// Basalt's `calibration.json`: all cameras, relative to the first.
pub(super) fn basalt(document: &Value) -> Result<Vec<Camera>, Complaint> {
    let list = |key: &'static str| {
        let list = document.get("value0").and_then(|value| value.get(key));
        let list = list.and_then(Value::as_sequence);
        list.ok_or_else(|| missing(key))
    };
    let (lenses, sizes, places) = (list("intrinsics")?, list("resolution")?, list("T_imu_cam")?);
    let mut cameras = Vec::new();
    let mut imu_from_first = None;
    for (index, ((lens, size), place)) in lenses.iter().zip(sizes).zip(places).enumerate() {
        let part = |axis: usize| pixels("resolution", size.get(axis).unwrap_or(&Value::Null));
        let parameters = Parameters {
            value: Box::new(|key| lens.get("intrinsics")?.get(key)),
            model: text(lens.get("camera_type")).unwrap_or_default(),
            size: [part(0)?, part(1)?],
        };
        let mut camera = parameters.camera(&format!("cam{index}"))?;
        let imu_from_camera = placed(place)?;
        let first = *imu_from_first.get_or_insert(imu_from_camera);
        camera.world_from_camera = (lenses.len() > 1).then(|| first.inverse() * imu_from_camera);
        cameras.push(camera);
    }
    Ok(cameras)
}

/// `{px, py, pz, qx, qy, qz, qw}`.
fn placed(place: &Value) -> Result<Pose, Complaint> {
    let number = |key: &str| {
        let number = place.get(key).and_then(Value::as_f64);
        let number = number.filter(|number| number.is_finite());
        number.ok_or_else(|| missing(&format!("T_imu_cam.{key}")))
    };
    let turned = Quaternion::new(number("qw")?, number("qx")?, number("qy")?, number("qz")?);
    if !(0.9..1.1).contains(&turned.norm()) {
        let cause = "the quaternion is not of length 1";
        return Err(Complaint::new("T_imu_cam", cause, ""));
    }
    let at = Translation3::new(number("px")?, number("py")?, number("pz")?);
    Ok(Pose::from_parts(at, unit_quaternion(turned)))
}

/// Intrinsics of a RealSense as its library names them.
pub(super) fn realsense(document: &Value, stem: &str) -> Result<Camera, Complaint> {
    let model = text(document.get("model")).unwrap_or_default();
    let model = model.rsplit('.').next().unwrap_or_default();
    let coefficients = document.get("coeffs").and_then(Value::as_sequence);
    let coefficients = coefficients.map(Vec::as_slice).unwrap_or_default();
    let is_distorted = coefficients.iter().any(|k| k.as_f64() != Some(0.0));
    let (model, names): (_, &[&str]) = match model {
        _ if !is_distorted => ("", &[]),
        "brown_conrady" => ("", &POLYNOMIAL[..5]),
        "kannala_brandt4" => ("kb4", &FISHEYE),
        other => {
            let cause = format!("the distortion model `{other}` has no counterpart here");
            let remedy = "calibrate the lens: `sextant calibrate lens`";
            return Err(Complaint::new("model", cause, remedy));
        }
    };
    let part = |key: &'static str| document.get(key).ok_or_else(|| missing(key));
    let parameters = Parameters {
        value: Box::new(
            |key| match (key, names.iter().position(|name| *name == key)) {
                (_, Some(index)) => coefficients.get(index),
                ("cx", _) => document.get("ppx"),
                ("cy", _) => document.get("ppy"),
                _ => document.get(key).filter(|_| key.starts_with('f')),
            },
        ),
        model,
        size: [
            pixels("width", part("width")?)?,
            pixels("height", part("height")?)?,
        ],
    };
    parameters.camera(stem)
}

/// Sections of a ZED's file by the size of the images.
const ZED_SIZES: [(&str, [u32; 2]); 4] = [
    ("2K", [2208, 1242]),
    ("FHD", [1920, 1080]),
    ("HD", [1280, 720]),
    ("VGA", [672, 376]),
];

fn zed_sections(document: &Value) -> impl Iterator<Item = (String, &Value, [u32; 2])> {
    let sections = ["LEFT", "RIGHT"]
        .into_iter()
        .flat_map(|side| ZED_SIZES.map(|(name, size)| (side, name, size)));
    sections.filter_map(|(side, name, size)| {
        let section = document.get(format!("{side}_CAM_{name}"))?;
        Some((format!("{side}_{name}"), section, size))
    })
}

/// Whether a document is a ZED's `SN....conf`.
pub(super) fn has_zed(document: &Value) -> bool {
    zed_sections(document).next().is_some()
}

/// Both cameras of a ZED in each of its sizes: `left_hd`, `right_vga` and so on.
pub(super) fn zed(document: &Value) -> Result<Vec<Camera>, Complaint> {
    let cameras = zed_sections(document).map(|(name, section, size)| {
        let parameters = Parameters {
            value: Box::new(|key| section.get(key)),
            model: "",
            size,
        };
        parameters.camera(&name)
    });
    cameras.collect()
}

/// Metashape's `calibration`: one focal length, the principal point from the middle of the image, P1 and P2 the other
/// way round.
pub(super) fn metashape(document: &Value, stem: &str) -> Result<Camera, Complaint> {
    let given = |key: &'static str| document.get(key).ok_or_else(|| missing(key));
    let number = |key: &'static str| document.get(key).and_then(Value::as_f64).unwrap_or(0.0);
    let size = [
        pixels("width", given("width")?)?,
        pixels("height", given("height")?)?,
    ];
    let projection = text(document.get("projection")).unwrap_or("frame");
    if projection != "frame" || number("b2") != 0.0 || number("k4") != 0.0 {
        let cause = "only frame cameras without b2 and k4 have a counterpart here";
        return Err(Complaint::new("projection", cause, "export it as OpenCV"));
    }
    let f = given("f")?.as_f64().ok_or_else(|| missing("f"))?;
    // There (0.5, 0.5) is the middle of the upper left pixel.
    let middle = size.map(|pixels| f64::from(pixels) / 2.0 - 0.5);
    let values: Mapping = [
        ("fx", f + number("b1")),
        ("fy", f),
        ("cx", middle[0] + number("cx")),
        ("cy", middle[1] + number("cy")),
        ("k1", number("k1")),
        ("k2", number("k2")),
        ("p1", number("p2")),
        ("p2", number("p1")),
        ("k3", number("k3")),
    ]
    .into_iter()
    .map(|(key, value)| (key.into(), value.into()))
    .collect();
    let parameters = Parameters {
        value: Box::new(|key| values.get(key)),
        model: "",
        size,
    };
    parameters.camera(stem)
}
