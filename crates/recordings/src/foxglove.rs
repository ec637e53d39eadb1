//! Messages of a site as Foxglove and Lichtblick show them: JSON of Foxglove's schemas (<https://docs.foxglove.dev/docs/sdk/schemas>), and
//! pictures.
//!
//! In: a decoded message. Out: topic, schema and bytes, for a recording or a live server. Each camera and object has topics of its own, so
//! that a viewer that jumps to a time finds the last message of each. Frames: `world`, `camera/<camera>`, `object/<object>`, and
//! `object/<object>/<link>`.

mod annotations;
mod diagnostics;
pub mod layout;
pub mod schema;
pub mod websocket;

use crate::compressed_image as image;
use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion};
use schema::Schema;
use serde_json::{Value, json};
use sextant_geometry::Pose;
use sextant_proto::{
    AnyMessage, CameraConfig, LensConfig, ObjectConfig, ObjectLinks, ObjectPose, ObjectTagConfig,
    PoseConfig, Preview, RigConfig,
};
use sextant_site_model::CameraId;

/// A message for a viewer.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewerMessage {
    /// Where it is published.
    pub topic: String,
    /// What it is.
    pub schema: Schema,
    /// The message, as its schema encodes it.
    pub data: Vec<u8>,
}

/// Standard deviations to the edge of an ellipsoid: 95 % of the volume of a Gaussian in three dimensions.
const ELLIPSOID_SIGMAS: f64 = 2.795;
/// Edge colour of tags, and colour of ellipsoids: red, green, blue, opacity.
const TAG_COLOUR: [f64; 4] = [0.15, 0.65, 1.0, 1.0];
const ELLIPSOID_COLOUR: [f64; 4] = [1.0, 0.65, 0.1, 0.45];

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
        AnyMessage::CameraStatus(status) => vec![diagnostics::of_camera(status, arrival_ns)],
        AnyMessage::FusionStatus(status) => vec![diagnostics::of_fusion(status, arrival_ns)],
        _ => Vec::new(),
    }
}

fn json_message(topic: String, schema: Schema, message: &Value) -> ViewerMessage {
    ViewerMessage {
        topic,
        schema,
        data: message.to_string().into_bytes(),
    }
}

/// A preview, as recorded images are.
fn picture(preview: &Preview) -> ViewerMessage {
    ViewerMessage {
        topic: image::preview_topic(&preview.camera),
        schema: Schema::CompressedImage,
        data: image::encode_file(
            &preview.camera,
            preview.capture_ns,
            image::File::Jpeg(&preview.jpeg),
        ),
    }
}

/// Topic of a camera's lens.
fn calibration_topic(camera: &CameraId) -> String {
    format!("/camera/{camera}/calibration")
}

fn rig_messages(rig: &RigConfig, arrival_ns: u64) -> Vec<ViewerMessage> {
    let transforms = rig.cameras.iter().filter_map(|camera| {
        let frame = format!("camera/{}", camera.id);
        let world_from_camera = camera.world_from_camera.as_ref()?;
        Some(transform(arrival_ns, ["world", &frame], world_from_camera))
    });
    let transforms = json!({ "transforms": transforms.collect::<Vec<_>>() });
    let transforms = json_message("/rig".to_owned(), Schema::FrameTransforms, &transforms);
    let calibrations = rig.cameras.iter().map(|camera| {
        let topic = calibration_topic(&camera.id);
        let calibration = calibration(camera, arrival_ns);
        json_message(topic, Schema::CameraCalibration, &calibration)
    });
    std::iter::once(transforms).chain(calibrations).collect()
}

fn calibration(camera: &CameraConfig, arrival_ns: u64) -> Value {
    let [fx, fy, cx, cy] = camera.lens.intrinsics();
    let (model, distortion) = match camera.lens {
        LensConfig::Pinhole { .. } => ("plumb_bob", &[0.0; 5][..]),
        LensConfig::BrownConrady { .. } => ("plumb_bob", camera.lens.distortion()),
        LensConfig::KannalaBrandt { .. } => ("kannala_brandt", camera.lens.distortion()),
    };
    json!({
        "timestamp": time(arrival_ns),
        "frame_id": format!("camera/{}", camera.id),
        "width": camera.resolution[0],
        "height": camera.resolution[1],
        "distortion_model": model,
        "D": distortion,
        "K": [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        "R": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "P": [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    })
}

fn pose_messages(pose: &ObjectPose) -> Vec<ViewerMessage> {
    let frame = format!("object/{}", pose.object);
    let world_from_object = PoseConfig {
        position: pose.position,
        orientation: pose.orientation,
    };
    let transform = transform(pose.capture_ns, ["world", &frame], &world_from_object);
    let transforms = json!({ "transforms": [transform] });
    let topic = format!("/object/{}/transform", pose.object);
    let transforms = json_message(topic, Schema::FrameTransforms, &transforms);
    let topic = format!("/object/{}/ellipsoid", pose.object);
    let ellipsoid = json_message(topic, Schema::SceneUpdate, &ellipsoid(pose));
    vec![transforms, ellipsoid]
}

/// The region that holds the object's origin with 95 % probability.
fn ellipsoid(pose: &ObjectPose) -> Value {
    let covariance = Matrix3::from_fn(|row, column| pose.covariance[6 * row + column]);
    let axes = SymmetricEigen::new(covariance);
    let mut turn = axes.eigenvectors;
    if turn.determinant() < 0.0 {
        turn.set_column(2, &-turn.column(2).into_owned());
    }
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    let diameter = |axis: usize| 2.0 * ELLIPSOID_SIGMAS * axes.eigenvalues[axis].max(0.0).sqrt();
    let sphere = json!({
        "pose": {
            "position": vector(pose.position),
            "orientation": quaternion([turn.i, turn.j, turn.k, turn.w]),
        },
        "size": vector([0, 1, 2].map(diameter)),
        "color": colour(ELLIPSOID_COLOUR),
    });
    let id = format!("{} ellipsoid", pose.object);
    let lifetime_ns = 500_000_000;
    let mut entity = entity(&id, "world", pose.capture_ns, lifetime_ns);
    entity["spheres"] = json!([sphere]);
    json!({ "deletions": [], "entities": [entity] })
}

fn link_transforms(links: &ObjectLinks) -> ViewerMessage {
    let transforms = links.links.iter().map(|link| {
        let world_from_link = PoseConfig::from(&link.world_from_link());
        let frame = format!("object/{}/{}", links.object, link.link);
        transform(links.capture_ns, ["world", &frame], &world_from_link)
    });
    let transforms = json!({ "transforms": transforms.collect::<Vec<_>>() });
    let topic = format!("/object/{}/links", links.object);
    json_message(topic, Schema::FrameTransforms, &transforms)
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
            None => format!("object/{}", object.id),
        };
        let outline = outline(tag)?;
        let id = format!("{} {}:{}", object.id, tag.family, tag.id);
        let mut entity = entity(&id, &frame, arrival_ns, 0);
        entity["frame_locked"] = json!(true);
        entity["lines"] = json!([outline]);
        Some(entity)
    });
    let entities: Vec<_> = entities.collect();
    let deletions = if entities.is_empty() {
        json!([{ "timestamp": time(arrival_ns), "type": 1, "id": "" }])
    } else {
        json!([])
    };
    let update = json!({ "deletions": deletions, "entities": entities });
    json_message(topic, Schema::SceneUpdate, &update)
}

fn outline(tag: &ObjectTagConfig) -> Option<Value> {
    let frame_from_tag = Pose::from(tag.object_from_tag.as_ref()?);
    let corners = sextant_geometry::tag_corners_in_tag(tag.size_m);
    let points = corners.map(|corner| vector((frame_from_tag * corner).coords.into()));
    const LINE_LOOP: u8 = 1;
    Some(json!({
        "type": LINE_LOOP,
        "pose": { "position": vector([0.0; 3]), "orientation": quaternion([0.0, 0.0, 0.0, 1.0]) },
        "thickness": 2.0,
        "scale_invariant": true,
        "points": points,
        "color": colour(TAG_COLOUR),
        "colors": [],
        "indices": [],
    }))
}

/// An entity without primitives; it disappears after `lifetime_ns`, if that is not 0.
fn entity(id: &str, frame: &str, t_ns: u64, lifetime_ns: u64) -> Value {
    json!({
        "timestamp": time(t_ns), "frame_id": frame, "id": id, "lifetime": time(lifetime_ns), "frame_locked": false,
        "metadata": [], "arrows": [], "cubes": [], "spheres": [], "cylinders": [], "lines": [], "triangles": [], "texts": [],
        "models": [],
    })
}

fn transform(t_ns: u64, [parent, child]: [&str; 2], parent_from_child: &PoseConfig) -> Value {
    json!({
        "timestamp": time(t_ns),
        "parent_frame_id": parent,
        "child_frame_id": child,
        "translation": vector(parent_from_child.position),
        "rotation": quaternion(parent_from_child.orientation),
    })
}

fn time(ns: u64) -> Value {
    json!({ "sec": ns / 1_000_000_000, "nsec": ns % 1_000_000_000 })
}

fn vector([x, y, z]: [f64; 3]) -> Value {
    json!({ "x": x, "y": y, "z": z })
}

fn quaternion([x, y, z, w]: [f64; 4]) -> Value {
    json!({ "x": x, "y": y, "z": z, "w": w })
}

fn colour([r, g, b, a]: [f64; 4]) -> Value {
    json!({ "r": r, "g": g, "b": b, "a": a })
}

#[cfg(test)]
mod tests {
    use super::*;
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
            orientation: [0.0, 0.0, 0.0, 1.0],
            covariance,
            twist: [0.0; 6],
            cameras: 1,
            tags: 1,
            rms_px: 0.1,
        }
    }

    fn shown(message: &AnyMessage) -> Vec<(ViewerMessage, Value)> {
        let shown = messages(message, 7).into_iter();
        shown
            .map(|one| (one.clone(), serde_json::from_slice(&one.data).unwrap()))
            .collect()
    }

    /// Whether a message has the properties that its schema lists, of the types that it lists.
    fn agrees(message: &Value, schema: &Value) -> bool {
        match schema["type"].as_str() {
            Some("object") => schema["properties"].as_object().is_some_and(|properties| {
                let mut properties = properties.iter();
                properties.all(|(name, schema)| agrees(&message[name], schema))
            }),
            Some("array") => message
                .as_array()
                .is_some_and(|items| items.iter().all(|item| agrees(item, &schema["items"]))),
            Some("integer") => message.is_u64(),
            Some("number") => message.is_number(),
            Some("string") => message.is_string(),
            Some("boolean") => message.is_boolean(),
            _ => false,
        }
    }

    #[test]
    fn a_pose_is_a_transform_and_an_ellipsoid_of_its_covariance() {
        let shown = shown(&AnyMessage::ObjectPose(Box::new(pose())));
        let [(transform, tf), (_, scene)] = &shown[..] else {
            panic!("{shown:?}");
        };
        assert_eq!(transform.topic, "/object/cube/transform");
        assert_eq!(tf["transforms"][0]["timestamp"]["nsec"], 5);
        assert_eq!(tf["transforms"][0]["translation"]["z"], 3.0);
        let size = &scene["entities"][0]["spheres"][0]["size"];
        let mut sizes: Vec<f64> = ["x", "y", "z"]
            .map(|axis| size[axis].as_f64().unwrap())
            .into();
        sizes.sort_by(f64::total_cmp);
        for (size, sigma) in sizes.iter().zip([0.001, 0.002, 0.003]) {
            assert!((size / (2.0 * ELLIPSOID_SIGMAS * sigma) - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn every_message_has_what_its_schema_says() {
        let lens = LensConfig::Pinhole {
            fx: 600.0,
            fy: 600.0,
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
        };
        let cameras = vec![camera];
        let all = [
            AnyMessage::RigConfig(RigConfig {
                cameras,
                scale_sigma: None,
            }),
            AnyMessage::ObjectConfig(object),
            AnyMessage::ObjectPose(Box::new(pose())),
        ];
        let all: Vec<_> = all.iter().flat_map(shown).collect();
        assert_eq!(all.len(), 5);
        for (message, json) in &all {
            let schema = message.schema.json_schema().unwrap();
            assert!(agrees(json, &schema), "{message:?} against {schema}");
        }
    }
}
