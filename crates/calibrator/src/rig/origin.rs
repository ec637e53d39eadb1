//! World frame: that of a camera, of a tag on the floor, or one defined by three tags.

use super::RigError;
use crate::image_store::TagSpec;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_site_model::{CameraId, Rig, TagId};
use std::f64::consts::PI;

/// Definition of the world frame.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum Origin {
    /// The first camera of the rig keeps its pose in the rig file; without one it is the world frame.
    #[default]
    FirstCamera,
    /// As [`Origin::FirstCamera`], with another camera.
    Camera(CameraId),
    /// A static tag (not on the carried object) is the world frame; its size in metres.
    Tag(TagId, f64),
    /// Three static tags: the centre of the first is the origin, the second lies on the x axis, the third on the
    /// side of positive y; z is up where they run anticlockwise as seen from above. Their size in metres.
    ThreeTags([TagId; 3], f64),
    /// Another frame, rotated about its origin by the smallest angle that makes z point up. A camera that would keep
    /// its pose is rotated with the frame.
    Levelled(Box<Origin>, Up),
}

/// Source of the vertical. Sizes in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Up {
    /// A tag on something level, facing up.
    Flat(TagId, f64),
    /// A tag that hangs plumb and upright: its upper edge is up.
    Upright(TagId, f64),
    /// Two tags on a plumb line: the lower and the upper one.
    Plumb([TagId; 2], f64),
}

impl Up {
    fn tags(&self) -> Vec<(TagId, f64)> {
        match self {
            Self::Flat(tag, size_m) | Self::Upright(tag, size_m) => vec![(*tag, *size_m)],
            Self::Plumb(tags, size_m) => tags.map(|tag| (tag, *size_m)).to_vec(),
        }
    }

    /// Up in the frame of the tags' poses.
    fn direction(
        &self,
        found: impl Fn(TagId) -> Result<Pose, RigError>,
    ) -> Result<Vector3<f64>, RigError> {
        match self {
            Self::Flat(tag, _) => Ok(found(*tag)?.rotation * Vector3::z()),
            Self::Upright(tag, _) => Ok(found(*tag)?.rotation * Vector3::y()),
            Self::Plumb([low, high], _) => {
                let apart = found(*high)?.translation.vector - found(*low)?.translation.vector;
                apart.try_normalize(1e-3).ok_or_else(|| {
                    RigError::Undetermined(
                        "the two tags of the plumb line are in one place".to_owned(),
                    )
                })
            }
        }
    }
}

impl Origin {
    pub(super) fn check(&self, rig: &Rig) -> Result<(), RigError> {
        match self {
            Self::Camera(id) if rig.camera(id).is_none() => {
                Err(RigError::UnknownOrigin(format!("camera {id}")))
            }
            Self::Levelled(frame, _) => frame.check(rig),
            _ => Ok(()),
        }
    }

    /// Static tags with their sizes in metres; none on the carried object.
    pub fn tags(&self) -> Vec<(TagId, f64)> {
        match self {
            Self::FirstCamera | Self::Camera(_) => Vec::new(),
            Self::Tag(tag, size_m) => vec![(*tag, *size_m)],
            Self::ThreeTags(tags, size_m) => tags.map(|tag| (tag, *size_m)).to_vec(),
            // Tags of the frame come first and keep their order.
            Self::Levelled(frame, up) => {
                let mut tags = frame.tags();
                for (tag, size_m) in up.tags() {
                    if !tags.iter().any(|(known, _)| *known == tag) {
                        tags.push((tag, size_m));
                    }
                }
                tags
            }
        }
    }

    pub(super) fn add_floor_tags(&self, wanted: &mut Vec<TagSpec>) {
        for (tag, size_m) in self.tags() {
            wanted.push(TagSpec { tag, size_m });
        }
    }

    /// Reference camera, whose pose is fixed in the adjustment.
    pub(super) fn reference(&self, rig: &Rig) -> usize {
        let named = match self {
            Self::Levelled(frame, _) => return frame.reference(rig),
            Self::Camera(id) => rig.cameras().iter().position(|camera| camera.id == *id),
            _ => None,
        };
        named.unwrap_or(0)
    }

    /// `world_from_adjusted`, given the poses of the floor tags in the frame of the adjustment.
    pub(super) fn world(&self, floor: &[Option<Pose>]) -> Result<Pose, RigError> {
        let found = |at: usize| {
            let tag = self.tags()[at].0;
            let pose = floor.get(at).copied().flatten();
            pose.ok_or_else(|| RigError::UnknownOrigin(format!("tag {tag}")))
        };
        let tag_found = |tag: TagId| {
            let at = self.tags().iter().position(|(own, _)| *own == tag);
            found(at.unwrap_or_default())
        };
        match self {
            Self::FirstCamera | Self::Camera(_) => Ok(Pose::identity()),
            Self::Tag(..) => Ok(found(0)?.inverse()),
            Self::ThreeTags(..) => {
                let points = [found(0)?, found(1)?, found(2)?].map(|p| p.translation.vector);
                frame_through(points).ok_or_else(|| {
                    RigError::Undetermined(
                        "the three tags of the origin lie on one line".to_owned(),
                    )
                })
            }
            Self::Levelled(frame, up) => {
                let world = frame.world(floor)?;
                Ok(level(&(world.rotation * up.direction(tag_found)?)) * world)
            }
        }
    }
}

/// Smallest rotation about the origin that maps a direction onto z.
fn level(up: &Vector3<f64>) -> Pose {
    let upside_down = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    let turn = UnitQuaternion::rotation_between(up, &Vector3::z()).unwrap_or_else(upside_down);
    Isometry3::from_parts(Translation3::identity(), turn)
}

/// The pose that brings the first point to the origin, the second onto +x, the third into the half plane of +y.
fn frame_through([origin, on_x, beside]: [Vector3<f64>; 3]) -> Option<Pose> {
    let x = (on_x - origin).try_normalize(1e-6)?;
    let z = x.cross(&(beside - origin)).try_normalize(1e-6)?;
    let axes = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]));
    let frame = Isometry3::from_parts(
        Translation3::from(origin),
        UnitQuaternion::from_rotation_matrix(&axes),
    );
    Some(frame.inverse())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn three_points_make_a_frame() {
        let points = [[1.0, 1.0, 0.5], [1.0, 3.0, 0.5], [0.0, 2.0, 0.5]].map(Vector3::from);
        let world = frame_through(points).unwrap();
        let at = |p: Vector3<f64>| world * Point3::from(p);
        assert!((at(points[0]).coords).norm() < 1e-12);
        assert!((at(points[1]) - Point3::new(2.0, 0.0, 0.0)).norm() < 1e-12);
        assert!((at(points[2]) - Point3::new(1.0, 1.0, 0.0)).norm() < 1e-12);
        assert!(frame_through([points[0], points[1], points[0]]).is_none());
    }

    #[test]
    fn levelling_turns_no_more_than_it_must() {
        for up in [
            [0.0, -1.0, 0.0],
            [0.3, 0.2, 0.9],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ] {
            let up = Vector3::from(up).normalize();
            let turn = level(&up).rotation;
            assert!((turn * up - Vector3::z()).norm() < 1e-9);
            assert!((turn.angle() - up.z.acos()).abs() < 1e-6);
        }
    }
}
