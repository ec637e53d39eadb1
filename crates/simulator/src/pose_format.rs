//! Poses in files: `{ position = [x, y, z], orientation = [x, y, z, w] }`, for `#[serde(with = "pose_format")]`.

use nalgebra::{Quaternion, UnitQuaternion};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use sextant_geometry::{Pose, PoseParts};

/// A quaternion as near to length 1 as this is one that [`serialize`] wrote.
const WRITTEN_BY_US: f64 = 1e-12;

pub(crate) fn serialize<S: Serializer>(pose: &Pose, serializer: S) -> Result<S::Ok, S::Error> {
    PoseParts::from(pose).serialize(serializer)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Pose, D::Error> {
    let parts = PoseParts::deserialize(deserializer)?;
    let mut pose = parts.to_pose().map_err(D::Error::custom)?;
    // What was written comes back bit by bit, not normalised again: every process renders the same world.
    let [x, y, z, w] = parts.orientation;
    let written = Quaternion::new(w, x, y, z);
    if (written.norm() - 1.0).abs() < WRITTEN_BY_US {
        pose.rotation = UnitQuaternion::new_unchecked(written);
    }
    Ok(pose)
}
