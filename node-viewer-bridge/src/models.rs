//! Rigs and objects as they are drawn: the types that messages and wizards show.

use crate::changes::edit::version_of_camera;
use serde::Serialize;
use sextant_proto::{
    CameraConfig, LensConfig, MountConfig, ObjectTagConfig, PoseConfig, SigmaConfig,
};
use sextant_site_model::CameraId;
use sextant_tag_families::{Family, module_is_white};

/// A camera of the rig.
#[derive(Debug, Serialize)]
pub(crate) struct RigCamera<'a> {
    pub(crate) id: &'a CameraId,
    pub(crate) resolution: [u32; 2],
    pub(crate) lens: Lens<'a>,
    pub(crate) world_from_camera: Option<PoseConfig>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) mount: Option<&'a MountConfig>,
    /// Standard deviation of its pose, where the file gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) sigma: Option<SigmaConfig>,
    pub(crate) version: String,
}

/// A lens as in `rig.toml`.
#[derive(Debug, Serialize)]
pub(crate) struct Lens<'a> {
    pub(crate) model: &'static str,
    pub(crate) fx: f64,
    pub(crate) fy: f64,
    pub(crate) cx: f64,
    pub(crate) cy: f64,
    #[serde(skip_serializing_if = "<[f64]>::is_empty")]
    pub(crate) distortion: &'a [f64],
}

/// A tag of an object, with its print.
#[derive(Debug, Serialize)]
pub(crate) struct ObjectTag {
    pub(crate) family: Family,
    pub(crate) id: u32,
    pub(crate) size_m: f64,
    pub(crate) printed_size_m: f64,
    pub(crate) object_from_tag: Option<PoseConfig>,
    /// Standard deviations of size and pose, where the file gives them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) size_sigma_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) sigma: Option<SigmaConfig>,
    /// Rows of the print, top first; `1` is white.
    pub(crate) modules: Vec<String>,
}

pub(crate) fn camera(camera: &CameraConfig) -> RigCamera<'_> {
    RigCamera {
        id: &camera.id,
        resolution: camera.resolution,
        lens: lens(&camera.lens),
        world_from_camera: camera.world_from_camera,
        mount: camera.mount.as_ref(),
        sigma: camera.world_from_camera_sigma,
        version: version_of_camera(camera),
    }
}

fn lens(config: &LensConfig) -> Lens<'_> {
    let [fx, fy, cx, cy] = config.intrinsics();
    let model = match config {
        LensConfig::Pinhole { .. } => "pinhole",
        LensConfig::BrownConrady { .. } => "brown-conrady",
        LensConfig::KannalaBrandt { .. } => "kannala-brandt",
    };
    let distortion = config.distortion();
    Lens {
        model,
        fx,
        fy,
        cx,
        cy,
        distortion,
    }
}

pub(crate) fn object_tag(tag: &ObjectTagConfig) -> ObjectTag {
    let data = tag.family.data();
    let in_modules = f64::from(data.total_width) / f64::from(data.border_width);
    ObjectTag {
        family: tag.family,
        id: tag.id,
        size_m: tag.size_m,
        printed_size_m: tag.size_m * in_modules,
        object_from_tag: tag.object_from_tag,
        size_sigma_m: tag.size_sigma_m,
        sigma: tag.object_from_tag_sigma,
        modules: modules(tag.family, tag.id),
    }
}

fn modules(family: Family, id: u32) -> Vec<String> {
    let width = usize::from(family.data().total_width);
    let module = |x, y| {
        if module_is_white(family, id, x, y) {
            '1'
        } else {
            '0'
        }
    };
    (0..width)
        .map(|y| (0..width).map(|x| module(x, y)).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_print_has_a_white_ring_around_a_black_one() {
        let rows = modules(Family::Tag36h11, 0);
        assert_eq!(rows.len(), 10);
        assert_eq!(rows[0], "1111111111");
        assert_eq!(rows[1], "1000000001");
    }

    #[test]
    fn a_lens_is_written_as_in_the_rig_file() {
        let config = LensConfig::KannalaBrandt {
            fx: 1.0,
            fy: 2.0,
            cx: 3.0,
            cy: 4.0,
            distortion: [0.1, 0.2, 0.3, 0.4],
        };
        let json = serde_json::to_value(lens(&config)).unwrap();
        assert_eq!(json["model"], "kannala-brandt");
        assert_eq!(json["distortion"][3], 0.4);
    }
}
