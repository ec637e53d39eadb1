//! Errors of the files of a site that images show: not faults, since no file is exact, but worth a message.

use serde::{Deserialize, Serialize};

use sextant_site_model::{CameraId, ObjectId, TagId};

use crate::sentences;

/// An error of a rig's or an object's file that poses allow for. On the wire the number of the variant, from 0, in this
/// order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Imperfection {
    /// By the rig's file two cameras see an object in different places.
    CamerasDisagree {
        /// The one.
        a: CameraId,
        /// The other.
        b: CameraId,
        /// How far apart, m.
        apart_m: f64,
    },
    /// A tag is not where the object's file has it.
    TagOff {
        /// On which object.
        object: ObjectId,
        /// The tag that is off most.
        tag: TagId,
        /// By how much, m.
        position_m: f64,
        /// By how much, rad.
        orientation_rad: f64,
    },
    /// A tag is not as large as the object's file says.
    SizeOff {
        /// On which object.
        object: ObjectId,
        /// The tag that is off most.
        tag: TagId,
        /// Its size as estimated over that in the file.
        ratio: f64,
    },
    /// The focal length of a camera is not as the rig's file has it.
    FocalLengthOff {
        /// Which camera.
        camera: CameraId,
        /// As estimated over that in the file.
        ratio: f64,
    },
    /// All sizes and places of an object's tags are at another scale than its file has them.
    ScaleOff {
        /// Which object.
        object: ObjectId,
        /// The scale as estimated over that of the file.
        ratio: f64,
    },
}

sentences! { Imperfection {
    Self::CamerasDisagree { a, b, apart_m } =>
        "cameras {a} and {b} disagree by {mm:.1} mm",
        ": run `sextant calibrate rig`; poses allow for it",
        mm = apart_m * 1e3;
    Self::TagOff { object, tag, position_m, orientation_rad } =>
        "tag {tag} of object {object} is {mm:.1} mm and {deg:.1} degrees off its place in the file",
        ": run `sextant learn`; poses allow for it",
        mm = position_m * 1e3,
        deg = orientation_rad.to_degrees();
    Self::SizeOff { object, tag, ratio } =>
        "tag {tag} of object {object} is {percent:+.1} % off its size in the file",
        ": measure it, or run `sextant learn`; poses allow for it",
        percent = (ratio - 1.0) * 100.0;
    Self::FocalLengthOff { camera, ratio } =>
        "the focal length of camera {camera} is {percent:+.2} % off that in the rig file",
        ": run `sextant calibrate lens`; poses allow for it",
        percent = (ratio - 1.0) * 100.0;
    Self::ScaleOff { object, ratio } =>
        "object {object} is {percent:.1} % as large as its file says",
        ": measure a tag and correct the file; poses allow for it",
        percent = ratio * 100.0;
}}
