//! Poses and transforms.

use sextant_geometry::Pose as RigidMotion;
use sextant_proto::{CameraConfig, LinkPose, ObjectConfig, ObjectLinks, ObjectPose, PoseConfig};

use super::frames::{carrier_frame, link_frame, optical_frame, tag_frame};
use crate::messages::{
    Float64MultiArray, Header, MultiArrayDimension, MultiArrayLayout, NamedPose, NamedPoseArray,
    Odometry, Point, Pose, PoseWithCovariance, PoseWithCovarianceStamped, Quaternion, RigidBodies,
    RigidBody, Transform, TransformStamped, Twist, TwistWithCovariance, Vector3,
};

/// Variance of velocities, of which the site publishes none: large, as none is known.
const UNKNOWN_VARIANCE: f64 = 1e6;

/// `world_from_object` with covariance, at the time of capture.
#[must_use]
pub fn object_pose(pose: &ObjectPose, world: &str) -> PoseWithCovarianceStamped {
    PoseWithCovarianceStamped {
        header: Header::new(pose.capture_ns, world),
        pose: PoseWithCovariance {
            pose: plain_pose(pose),
            covariance: pose.covariance,
        },
    }
}

/// `world_from_object` with covariance, and the velocities in the axes of the object.
#[must_use]
pub fn odometry(pose: &ObjectPose, world: &str) -> Odometry {
    let object_from_world = pose.world_from_object().rotation.inverse();
    let [vx, vy, vz, wx, wy, wz] = pose.twist;
    let in_object = |x, y, z| {
        let v = object_from_world * nalgebra::Vector3::new(x, y, z);
        Vector3 {
            x: v.x,
            y: v.y,
            z: v.z,
        }
    };
    let is_diagonal = |place: usize| place.is_multiple_of(7);
    Odometry {
        header: Header::new(pose.capture_ns, world),
        child_frame_id: pose.object.to_string(),
        pose: PoseWithCovariance {
            pose: plain_pose(pose),
            covariance: pose.covariance,
        },
        twist: TwistWithCovariance {
            twist: Twist {
                linear: in_object(vx, vy, vz),
                angular: in_object(wx, wy, wz),
            },
            covariance: std::array::from_fn(|n| {
                if is_diagonal(n) {
                    UNKNOWN_VARIANCE
                } else {
                    0.0
                }
            }),
        },
    }
}

/// How good a pose is, for plots: the expected lengths of the errors of position (m) and attitude (rad), the
/// reprojection error (pixels), and the numbers of cameras and tags that entered.
#[must_use]
pub fn quality(pose: &ObjectPose) -> Float64MultiArray {
    let sigma = |from: usize| {
        let variances = (from..from + 3).map(|axis| pose.covariance[7 * axis].max(0.0));
        variances.sum::<f64>().sqrt()
    };
    let data = vec![
        sigma(0),
        sigma(3),
        f64::from(pose.rms_px),
        f64::from(pose.cameras),
        f64::from(pose.tags),
    ];
    let size = data.len() as u32;
    let dimension = MultiArrayDimension {
        label: "position_sigma_m attitude_sigma_rad rms_px cameras tags".to_owned(),
        size,
        stride: size,
    };
    let layout = MultiArrayLayout {
        dim: vec![dimension],
        data_offset: 0,
    };
    Float64MultiArray { layout, data }
}

/// `world_from_object` under the object's name, an array of one.
#[must_use]
pub fn named_pose(pose: &ObjectPose, world: &str) -> NamedPoseArray {
    NamedPoseArray {
        header: Header::new(pose.capture_ns, world),
        poses: vec![NamedPose {
            name: pose.object.to_string(),
            pose: plain_pose(pose),
        }],
    }
}

/// `world_from_object` as a rigid body without markers, an array of one.
#[must_use]
pub fn rigid_body(pose: &ObjectPose, world: &str) -> RigidBodies {
    RigidBodies {
        header: Header::new(pose.capture_ns, world),
        frame_number: pose.sequence as u32,
        rigidbodies: vec![RigidBody {
            rigid_body_name: pose.object.to_string(),
            markers: Vec::new(),
            pose: plain_pose(pose),
        }],
    }
}

fn plain_pose(pose: &ObjectPose) -> Pose {
    let Transform {
        translation: Vector3 { x, y, z },
        rotation,
    } = transform(&pose.world_from_object());
    Pose {
        position: Point { x, y, z },
        orientation: rotation,
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

/// What does not move: `world_from_camera` or `carrier_from_camera` of the calibrated cameras, `object_from_tag` of the
/// tags with a known pose. The time is that of the publication, ns since the Unix epoch.
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
        let (parent, pose) = match &camera.mount {
            Some(mount) => (mount.carrier.as_str(), &mount.carrier_from_camera),
            None => (world, camera.world_from_camera.as_ref()?),
        };
        Some(fixed(parent, optical_frame(&camera.id), pose))
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
