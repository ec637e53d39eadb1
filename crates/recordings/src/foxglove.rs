//! Messages of a site as viewers show them: Foxglove's schemas in protobuf
//! (<https://docs.foxglove.dev/docs/sdk/schemas>), which Foxglove, Lichtblick, Rerun and PlotJuggler decode; and ROS
//! messages for what Foxglove has no schema for.
//!
//! In: a decoded message. Out: topic, schema and bytes, for a recording or a live server. Each camera and object has
//! topics of its own, so that a viewer that jumps to a time finds the last message of each. Frames: `world`,
//! `camera/<camera>`, `object/<object>`, and `object/<object>/<link>`.

mod annotations;
pub mod layout;
pub mod schema;
pub mod websocket;

use crate::compressed_image as image;
use ::foxglove::Encode;
use ::foxglove::messages::line_primitive::Type as LineType;
use ::foxglove::messages::scene_entity_deletion::Type as DeletionType;
use ::foxglove::messages::{
    CameraCalibration, Color, Duration, FrameTransform, FrameTransforms, LinePrimitive, Point3,
    Pose, PoseInFrame, Quaternion, SceneEntity, SceneEntityDeletion, SceneUpdate, SpherePrimitive,
    Timestamp, Vector3,
};
use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion};
use schema::Schema;
use sextant_proto::{
    AnyMessage, CameraConfig, LensConfig, ObjectConfig, ObjectLinks, ObjectPose, ObjectTagConfig,
    PoseConfig, Preview, RigConfig,
};
use sextant_ros2::messages::{DiagnosticArray, DiagnosticStatus, Header};
use sextant_ros2::{RosMessage, convert, encode};
use sextant_site_model::{CameraId, ObjectId};

/// A message for a viewer.
#[derive(Debug, Clone)]
pub struct ViewerMessage {
    /// Where it is published.
    pub topic: String,
    /// What it is; needed once a topic.
    pub schema: fn() -> Schema,
    /// The message, as its schema encodes it.
    pub data: Vec<u8>,
}

impl ViewerMessage {
    fn protobuf<M: Encode>(topic: String, message: &M) -> Self {
        let mut data = Vec::with_capacity(message.encoded_len().unwrap_or_default());
        // It fails where the room is bounded, which that of a Vec is not.
        let _ = message.encode(&mut data);
        Self {
            topic,
            schema: schema::protobuf::<M>,
            data,
        }
    }

    pub(crate) fn ros<M: RosMessage>(topic: String, message: &M) -> Self {
        Self {
            topic,
            schema: schema::ros::<M>,
            data: encode(message),
        }
    }
}

/// Topic of the state of all nodes.
const DIAGNOSTICS: &str = "/diagnostics";
/// Standard deviations to the edge of an ellipsoid: 95 % of the volume of a Gaussian in three dimensions.
const ELLIPSOID_SIGMAS: f64 = 2.795;
/// Edge colour of tags.
const TAG_COLOUR: Color = Color {
    r: 0.15,
    g: 0.65,
    b: 1.0,
    a: 1.0,
};
const ELLIPSOID_COLOUR: Color = Color {
    r: 1.0,
    g: 0.65,
    b: 0.1,
    a: 0.45,
};

/// What a viewer shows of a message that arrived at `arrival_ns`; nothing of most kinds.
#[must_use]
pub fn messages(message: &AnyMessage, arrival_ns: u64) -> Vec<ViewerMessage> {
    match message {
        AnyMessage::RigConfig(rig) => rig_messages(rig, arrival_ns),
        AnyMessage::ObjectConfig(object) => vec![tags_of(object, arrival_ns)],
        AnyMessage::ObjectPose(pose) => pose_messages(pose),
        AnyMessage::ObjectLinks(links) => vec![link_transforms(links)],
        AnyMessage::Observations(image) => vec![annotations::message(image)],
        AnyMessage::Preview(preview) => vec![picture(preview)],
        AnyMessage::CameraStatus(status) => {
            vec![diagnostics(convert::camera_status(status), arrival_ns)]
        }
        AnyMessage::FusionStatus(status) => {
            vec![diagnostics(convert::fusion_status(status), arrival_ns)]
        }
        _ => Vec::new(),
    }
}

fn diagnostics(status: DiagnosticStatus, arrival_ns: u64) -> ViewerMessage {
    let message = DiagnosticArray {
        header: Header::new(arrival_ns, ""),
        status: vec![status],
    };
    ViewerMessage::ros(DIAGNOSTICS.to_owned(), &message)
}

/// A preview, as recorded images are.
fn picture(preview: &Preview) -> ViewerMessage {
    let (camera, jpeg) = (&preview.camera, preview.jpeg.clone());
    let message = image::message(camera, preview.capture_ns, "jpeg", jpeg);
    ViewerMessage::ros(image::preview_topic(camera), &message)
}

/// The frame of an object.
fn object_frame(object: &ObjectId) -> String {
    format!("object/{object}")
}

/// Topic of a camera's lens.
fn calibration_topic(camera: &CameraId) -> String {
    format!("/camera/{camera}/calibration")
}

fn rig_messages(rig: &RigConfig, arrival_ns: u64) -> Vec<ViewerMessage> {
    let transforms = rig.cameras.iter().filter_map(|camera| {
        let (parent, pose) = match &camera.mount {
            Some(mount) => (object_frame(&mount.carrier), &mount.carrier_from_camera),
            None => (WORLD.to_owned(), camera.world_from_camera.as_ref()?),
        };
        Some(FrameTransform {
            parent_frame_id: parent,
            ..transform(arrival_ns, image::frame_of(&camera.id), pose)
        })
    });
    let transforms = transforms_message("/rig".to_owned(), transforms.collect());
    let calibrations = rig.cameras.iter().map(|camera| {
        let topic = calibration_topic(&camera.id);
        ViewerMessage::protobuf(topic, &calibration(camera, arrival_ns))
    });
    std::iter::once(transforms).chain(calibrations).collect()
}

fn calibration(camera: &CameraConfig, arrival_ns: u64) -> CameraCalibration {
    let info = convert::camera_info(camera, arrival_ns);
    let distortion_model = match camera.lens {
        // ROS calls it equidistant.
        LensConfig::KannalaBrandt { .. } => "kannala_brandt".to_owned(),
        _ => info.distortion_model,
    };
    CameraCalibration {
        timestamp: time(arrival_ns),
        frame_id: image::frame_of(&camera.id),
        width: info.width,
        height: info.height,
        distortion_model,
        d: info.d,
        k: info.k.to_vec(),
        r: info.r.to_vec(),
        p: info.p.to_vec(),
    }
}

fn pose_messages(pose: &ObjectPose) -> Vec<ViewerMessage> {
    let topic = |what: &str| format!("/object/{}/{what}", pose.object);
    let frame = object_frame(&pose.object);
    let world_from_object = PoseConfig {
        position: pose.position,
        orientation: pose.orientation,
    };
    let transform = transform(pose.capture_ns, frame, &world_from_object);
    let in_world = PoseInFrame {
        timestamp: time(pose.capture_ns),
        frame_id: WORLD.to_owned(),
        pose: pose_of(pose.position, pose.orientation),
    };
    vec![
        transforms_message(topic("transform"), vec![transform]),
        ViewerMessage::protobuf(topic("pose"), &in_world),
        ViewerMessage::ros(topic("quality"), &convert::quality(pose)),
        ViewerMessage::protobuf(topic("ellipsoid"), &ellipsoid(pose)),
    ]
}

/// The region that holds the object's origin with 95 % probability.
fn ellipsoid(pose: &ObjectPose) -> SceneUpdate {
    let covariance = Matrix3::from_fn(|row, column| pose.covariance[6 * row + column]);
    let axes = SymmetricEigen::new(covariance);
    let mut turn = axes.eigenvectors;
    if turn.determinant() < 0.0 {
        turn.set_column(2, &-turn.column(2).into_owned());
    }
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    let diameter = |axis: usize| 2.0 * ELLIPSOID_SIGMAS * axes.eigenvalues[axis].max(0.0).sqrt();
    let sphere = SpherePrimitive {
        pose: pose_of(pose.position, [turn.i, turn.j, turn.k, turn.w]),
        size: vector([0, 1, 2].map(diameter)),
        color: Some(ELLIPSOID_COLOUR),
    };
    let entity = SceneEntity {
        timestamp: time(pose.capture_ns),
        frame_id: WORLD.to_owned(),
        id: format!("{} ellipsoid", pose.object),
        lifetime: Some(Duration::new(0, 500_000_000)),
        spheres: vec![sphere],
        ..SceneEntity::default()
    };
    SceneUpdate {
        deletions: Vec::new(),
        entities: vec![entity],
    }
}

fn link_transforms(links: &ObjectLinks) -> ViewerMessage {
    let transforms = links.links.iter().map(|link| {
        let world_from_link = PoseConfig::from(&link.world_from_link());
        let frame = format!("object/{}/{}", links.object, link.link);
        transform(links.capture_ns, frame, &world_from_link)
    });
    transforms_message(
        format!("/object/{}/links", links.object),
        transforms.collect(),
    )
}

/// The outlines of an object's tags in its frame, or that they are gone.
fn tags_of(object: &ObjectConfig, arrival_ns: u64) -> ViewerMessage {
    let topic = format!("/object/{}/tags", object.id);
    let entities = object.tags.iter().filter_map(|tag| {
        let frame = match tag
            .link
            .and_then(|link| object.links.get(usize::from(link)))
        {
            Some(link) => format!("object/{}/{link}", object.id),
            None => object_frame(&object.id),
        };
        Some(SceneEntity {
            timestamp: time(arrival_ns),
            frame_id: frame,
            id: format!("{} {}:{}", object.id, tag.family, tag.id),
            frame_locked: true,
            lines: vec![outline(tag)?],
            ..SceneEntity::default()
        })
    });
    let entities: Vec<_> = entities.collect();
    let all = || SceneEntityDeletion {
        timestamp: time(arrival_ns),
        r#type: DeletionType::All.into(),
        id: String::new(),
    };
    let update = SceneUpdate {
        deletions: entities.is_empty().then(all).into_iter().collect(),
        entities,
    };
    ViewerMessage::protobuf(topic, &update)
}

fn outline(tag: &ObjectTagConfig) -> Option<LinePrimitive> {
    let frame_from_tag = sextant_geometry::Pose::from(tag.object_from_tag.as_ref()?);
    let corners = sextant_geometry::tag_corners_in_tag(tag.size_m);
    let points = corners.map(|corner| {
        let corner = frame_from_tag * corner;
        Point3 {
            x: corner.x,
            y: corner.y,
            z: corner.z,
        }
    });
    Some(LinePrimitive {
        r#type: LineType::LineLoop.into(),
        pose: pose_of([0.0; 3], [0.0, 0.0, 0.0, 1.0]),
        thickness: 2.0,
        scale_invariant: true,
        points: points.into(),
        color: Some(TAG_COLOUR),
        ..LinePrimitive::default()
    })
}

const WORLD: &str = "world";

fn transforms_message(topic: String, transforms: Vec<FrameTransform>) -> ViewerMessage {
    ViewerMessage::protobuf(topic, &FrameTransforms { transforms })
}

fn transform(t_ns: u64, child: String, world_from_child: &PoseConfig) -> FrameTransform {
    FrameTransform {
        timestamp: time(t_ns),
        parent_frame_id: WORLD.to_owned(),
        child_frame_id: child,
        translation: vector(world_from_child.position),
        rotation: quaternion(world_from_child.orientation),
    }
}

/// Later than 2106 it stays at the last second that the message can carry.
fn time(ns: u64) -> Option<Timestamp> {
    let seconds = u32::try_from(ns / 1_000_000_000).unwrap_or(u32::MAX);
    Some(Timestamp::new(seconds, (ns % 1_000_000_000) as u32))
}

fn pose_of(position: [f64; 3], orientation: [f64; 4]) -> Option<Pose> {
    Some(Pose {
        position: vector(position),
        orientation: quaternion(orientation),
    })
}

fn vector([x, y, z]: [f64; 3]) -> Option<Vector3> {
    Some(Vector3 { x, y, z })
}

fn quaternion([x, y, z, w]: [f64; 4]) -> Option<Quaternion> {
    Some(Quaternion { x, y, z, w })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::foxglove::Decode;
    use sextant_site_model::ObjectId;
    use sextant_site_report::State;
    use sextant_tag_families::Family;

    fn pose() -> ObjectPose {
        let mut covariance = [0.0; 36];
        for (axis, sigma) in [0.001, 0.002, 0.003, 0.01, 0.01, 0.01].iter().enumerate() {
            covariance[7 * axis] = sigma * sigma;
        }
        ObjectPose {
            object: ObjectId::new("cube").unwrap(),
            epoch: 1,
            sequence: 1,
            capture_ns: 1_800_000_000_000_000_005,
            published_ns: 1,
            state: State::Tracking,
            position: [1.0, 2.0, 3.0],
            orientation: [0.1, 0.3, 0.5, 0.65_f64.sqrt()],
            covariance,
            twist: [0.0; 6],
            cameras: 1,
            tags: 1,
            rms_px: 0.1,
        }
    }

    fn shown<M: Decode>(message: &AnyMessage, topic: &str) -> M {
        let shown = messages(message, 7);
        let one = shown.iter().find(|one| one.topic == topic).unwrap();
        M::decode(&*one.data).ok().unwrap()
    }

    #[test]
    fn a_pose_is_a_transform_and_an_ellipsoid_of_its_covariance() {
        let message = AnyMessage::ObjectPose(Box::new(pose()));
        let tf: FrameTransforms = shown(&message, "/object/cube/transform");
        assert_eq!(tf.transforms[0].timestamp.unwrap().nsec(), 5);
        assert_eq!(tf.transforms[0].translation, vector([1.0, 2.0, 3.0]));
        let turn = Some(Quaternion {
            x: 0.1,
            y: 0.3,
            z: 0.5,
            w: 0.65_f64.sqrt(),
        });
        assert_eq!(tf.transforms[0].rotation, turn);
        let in_world: PoseInFrame = shown(&message, "/object/cube/pose");
        assert_eq!(in_world.pose.unwrap().position, vector([1.0, 2.0, 3.0]));
        assert_eq!(in_world.pose.unwrap().orientation, turn);
        let scene: SceneUpdate = shown(&message, "/object/cube/ellipsoid");
        let size = scene.entities[0].spheres[0].size.unwrap();
        let mut sizes = [size.x, size.y, size.z];
        sizes.sort_by(f64::total_cmp);
        for (size, sigma) in sizes.iter().zip([0.001, 0.002, 0.003]) {
            assert!((size / (2.0 * ELLIPSOID_SIGMAS * sigma) - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn models_are_transforms_lenses_and_outlines() {
        let lens = LensConfig::Pinhole {
            fx: 600.0,
            fy: 601.0,
            cx: 319.5,
            cy: 239.5,
        };
        let placed = PoseConfig {
            position: [1.0, 0.0, 0.0],
            orientation: [0.0, 0.0, 0.0, 1.0],
        };
        let camera = CameraConfig {
            id: CameraId::new("north").unwrap(),
            resolution: [640, 480],
            lens,
            lens_sigma: None,
            world_from_camera: Some(placed),
            mount: None,
            world_from_camera_sigma: None,
            line_delay_s: None,
            exposure: None,
        };
        let tag = ObjectTagConfig {
            family: Family::Tag36h11,
            id: 3,
            size_m: 0.04,
            size_sigma_m: None,
            link: None,
            object_from_tag: Some(placed),
            object_from_tag_sigma: None,
        };
        let object = ObjectConfig {
            id: ObjectId::new("cube").unwrap(),
            links: Vec::new(),
            joints: Vec::new(),
            tags: vec![tag],
            frame_sigma: None,
            scale_sigma: None,
            world_from_object: None,
        };
        let rig = AnyMessage::RigConfig(RigConfig {
            cameras: vec![camera],
            scale_sigma: None,
        });
        let lens: CameraCalibration = shown(&rig, "/camera/north/calibration");
        assert_eq!((lens.width, lens.height), (640, 480));
        let k = [600.0, 0.0, 319.5, 0.0, 601.0, 239.5, 0.0, 0.0, 1.0];
        assert_eq!(lens.k, k);
        let p = [
            600.0, 0.0, 319.5, 0.0, 0.0, 601.0, 239.5, 0.0, 0.0, 0.0, 1.0, 0.0,
        ];
        assert_eq!(lens.p, p);
        let tf: FrameTransforms = shown(&rig, "/rig");
        assert_eq!(tf.transforms[0].child_frame_id, "camera/north");
        let mut object = object;
        let tags: SceneUpdate = shown(
            &AnyMessage::ObjectConfig(object.clone()),
            "/object/cube/tags",
        );
        assert_eq!(tags.entities[0].lines[0].points.len(), 4);
        assert_eq!(tags.deletions, []);
        object.tags.clear();
        let gone: SceneUpdate = shown(&AnyMessage::ObjectConfig(object), "/object/cube/tags");
        assert_eq!((gone.entities.len(), gone.deletions.len()), (0, 1));
    }
}
