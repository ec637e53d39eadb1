//! Poses and transforms.

use sextant_geometry::Pose as RigidMotion;
use sextant_proto::{CameraConfig, LinkPose, ObjectConfig, ObjectLinks, ObjectPose, PoseConfig};

use super::frames::{carrier_frame, link_frame, optical_frame, tag_frame};
use crate::messages::{
    Header, Point, Pose, PoseWithCovariance, PoseWithCovarianceStamped, Quaternion, Transform,
    TransformStamped, Vector3,
};

/// `world_from_object` with covariance, at the time of capture.
#[must_use]
pub fn object_pose(pose: &ObjectPose, world: &str) -> PoseWithCovarianceStamped {
    let Transform {
        translation: Vector3 { x, y, z },
        rotation,
    } = transform(&pose.world_from_object());
    PoseWithCovarianceStamped {
        header: Header::new(pose.capture_ns, world),
        pose: PoseWithCovariance {
            pose: Pose {
                position: Point { x, y, z },
                orientation: rotation,
            },
            covariance: pose.covariance,
        },
    }
}

/// `world_from_object`, at the time of capture.
#[must_use]
pub fn object_transform(pose: &ObjectPose, world: &str) -> TransformStamped {
    TransformStamped {
        header: Header::new(pose.capture_ns, world),
        child_frame_id: pose.object.to_string(),
        transform: transform(&pose.world_from_object()),
    }
}

/// `world_from_link`, at the time of capture.
#[must_use]
pub fn link_transform(links: &ObjectLinks, link: &LinkPose, world: &str) -> TransformStamped {
    let world_from_link = RigidMotion::from(&PoseConfig {
        position: link.position,
        orientation: link.orientation,
    });
    TransformStamped {
        header: Header::new(links.capture_ns, world),
        child_frame_id: link_frame(&links.object, &link.link),
        transform: transform(&world_from_link),
    }
}

/// What does not move: `world_from_camera` of the calibrated cameras, `object_from_tag` of the tags with a known pose. The time is
/// that of the publication, ns since the Unix epoch.
pub fn static_transforms<'a>(
    cameras: impl Iterator<Item = &'a CameraConfig>,
    objects: impl Iterator<Item = &'a ObjectConfig>,
    world: &str,
    now_ns: u64,
) -> Vec<TransformStamped> {
    let fixed = |parent: &str, child: String, parent_from_child: &PoseConfig| TransformStamped {
        header: Header::new(now_ns, parent),
        child_frame_id: child,
        transform: transform(&RigidMotion::from(parent_from_child)),
    };
    let cameras = cameras.filter_map(|camera| {
        let pose = camera.world_from_camera.as_ref()?;
        Some(fixed(world, optical_frame(&camera.id), pose))
    });
    let tags = objects.flat_map(|object| {
        object.tags.iter().filter_map(move |tag| {
            let pose = tag.object_from_tag.as_ref()?;
            let carrier = carrier_frame(object, tag);
            Some(fixed(&carrier, tag_frame(&object.id, tag), pose))
        })
    });
    cameras.chain(tags).collect()
}

fn transform(a_from_b: &RigidMotion) -> Transform {
    let (t, q) = (
        a_from_b.translation.vector,
        a_from_b.rotation.quaternion().coords,
    );
    Transform {
        translation: Vector3 {
            x: t.x,
            y: t.y,
            z: t.z,
        },
        rotation: Quaternion {
            x: q.x,
            y: q.y,
            z: q.z,
            w: q.w,
        },
    }
}
