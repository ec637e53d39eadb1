//! Binary glTF 2.0 (Khronos, specification 2.0.1), for browsers, game engines and viewers.
//!
//! glTF has y up: the root node turns the world, below it coordinates are Sextant's. Cameras are pinholes whose axis
//! goes through the centre of the image; the lens is in their `extras`. Times are seconds since the first pose. All
//! numbers of samples are 32-bit floats: at an hour, times are right to 0.12 ms. glTF has no visibility: hidden objects
//! are scaled to zero.

use crate::animation::{AnimatedObject, Animation, PlacedCamera, PlacedTag, to_gl_camera};
use crate::narrowed;
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::{Map, Value, json};
use sextant_geometry::{Pose, PoseParts, tag_corners_in_tag};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
const JSON_CHUNK: &[u8; 4] = b"JSON";
const BINARY_CHUNK: &[u8; 4] = b"BIN\0";
const INDEX: Element = Element {
    component: 5123,
    kind: "SCALAR",
    n_bytes: 2,
};
const SCALAR: Element = Element::floats("SCALAR", 1);
const VEC3: Element = Element::floats("VEC3", 3);
const VEC4: Element = Element::floats("VEC4", 4);
const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
/// Time, translation and rotation.
const SAMPLE_BYTES: usize = 4 + 12 + 16;
/// Samples of a file: lengths have 32 bits.
const MAX_SAMPLES: usize = (1 << 31) / SAMPLE_BYTES;

/// More than a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{0} poses are more than the {MAX_SAMPLES} that a GLB file holds; write USD")]
pub struct TooManyPoses(usize);

/// An animation as a GLB file. It takes 32 bytes a pose.
///
/// # Errors
/// Where there are more poses than a file can hold.
pub fn glb(animation: &Animation) -> Result<Vec<u8>, TooManyPoses> {
    let n_samples: usize = animation.objects.iter().map(n_samples).sum();
    if n_samples > MAX_SAMPLES {
        return Err(TooManyPoses(n_samples));
    }
    let mut document = Document {
        animation,
        nodes: Vec::new(),
        cameras: Vec::new(),
        meshes: Vec::new(),
        mesh_of_size: BTreeMap::new(),
        quad: None,
        channels: Vec::new(),
        samplers: Vec::new(),
        buffer: Buffer::default(),
    };
    document.scene();
    Ok(document.file())
}

fn n_samples(object: &AnimatedObject) -> usize {
    let links: usize = object.links.iter().map(|link| link.samples.len()).sum();
    object.samples().count() + links
}

/// A file that is being made.
struct Document<'a> {
    animation: &'a Animation,
    nodes: Vec<Value>,
    cameras: Vec<Value>,
    meshes: Vec<Value>,
    /// Meshes of tags by the bits of their sizes, m.
    mesh_of_size: BTreeMap<u64, usize>,
    /// Accessor of the corners' order, which all tags share.
    quad: Option<usize>,
    channels: Vec<Value>,
    samplers: Vec<Value>,
    buffer: Buffer,
}

/// What an accessor has a list of.
struct Element {
    /// Code of its numbers' type.
    component: u32,
    kind: &'static str,
    n_bytes: usize,
}

impl Element {
    /// So many 32-bit floats.
    const fn floats(kind: &'static str, n: usize) -> Self {
        Self {
            component: 5126,
            kind,
            n_bytes: 4 * n,
        }
    }
}

/// Binary data and what it holds.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Document<'_> {
    /// Adds all nodes; the first is the root.
    fn scene(&mut self) {
        let y_up_from_z_up = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -FRAC_PI_2);
        let root = Pose::from_parts(nalgebra::Translation3::identity(), y_up_from_z_up);
        let root = self.node("Site", &root);
        let animation = self.animation;
        self.nodes[root]["extras"] = json!({ "startTimeNs": animation.start_ns.to_string() });
        let cameras: Vec<usize> = animation
            .cameras
            .iter()
            .map(|camera| self.camera(camera))
            .collect();
        let objects = animation.objects.iter().map(|object| self.object(object));
        let children = cameras.into_iter().chain(objects).collect();
        self.adopt(root, children);
    }

    fn node(&mut self, name: &str, pose: &Pose) -> usize {
        let (translation, rotation) = floats(pose);
        let node = json!({ "name": name, "translation": translation, "rotation": rotation });
        added(&mut self.nodes, node)
    }

    fn adopt(&mut self, parent: usize, children: Vec<usize>) {
        if !children.is_empty() {
            self.nodes[parent]["children"] = children.into();
        }
    }

    fn camera(&mut self, placed: &PlacedCamera) -> usize {
        let camera = &placed.camera;
        let [width, height] = camera.resolution.map(f64::from);
        let lens = camera.lens.intrinsics();
        let model = camera.lens.model().to_string();
        let described = json!({
            "name": camera.id.as_str(),
            "type": "perspective",
            "perspective": {
                "aspectRatio": (width / lens.fx) / (height / lens.fy),
                "yfov": 2.0 * (0.5 * height / lens.fy).atan(),
                "znear": 0.01,
                "zfar": 1000.0,
            },
            "extras": {
                "resolution": camera.resolution,
                "model": model,
                "intrinsics": [lens.fx, lens.fy, lens.cx, lens.cy],
                "distortion": camera.lens.distortion(),
            },
        });
        let camera_index = added(&mut self.cameras, described);
        let parent_from_gl = to_gl_camera(&placed.parent_from_camera);
        let node = self.node(camera.id.as_str(), &parent_from_gl);
        self.nodes[node]["camera"] = camera_index.into();
        node
    }

    fn object(&mut self, object: &AnimatedObject) -> usize {
        let first = object.samples().next();
        let first = first.map_or_else(Pose::identity, |(_, pose)| pose);
        let node = self.node(object.id.as_str(), &first);
        self.motion(node, object.samples());
        let changes = object.visibility(self.animation);
        if !changes.is_empty() {
            self.visibility(node, &changes);
        }
        let mut children = self.tags(&object.tags);
        for link in &object.links {
            let child = self.node(link.id.as_str(), &link.samples[0].1);
            self.motion(child, link.samples.iter().copied());
            let tags = self.tags(&link.tags);
            self.adopt(child, tags);
            children.push(child);
        }
        children.extend(object.cameras.iter().map(|camera| self.camera(camera)));
        self.adopt(node, children);
        node
    }

    fn tags(&mut self, tags: &[PlacedTag]) -> Vec<usize> {
        let node = |placed: &PlacedTag| {
            let mesh = self.quad(placed.tag.size_m);
            let node = self.node(&placed.tag.tag.to_string(), &placed.parent_from_tag);
            self.nodes[node]["mesh"] = mesh.into();
            node
        };
        tags.iter().map(node).collect()
    }

    /// The mesh of a tag of this size.
    fn quad(&mut self, size_m: f64) -> usize {
        if let Some(mesh) = self.mesh_of_size.get(&size_m.to_bits()) {
            return *mesh;
        }
        let buffer = &mut self.buffer;
        let indices = *self.quad.get_or_insert_with(|| {
            // Counter-clockwise for who looks at the face.
            let corners = [0u16, 3, 2, 0, 2, 1];
            let bytes = corners.into_iter().flat_map(u16::to_le_bytes).collect();
            buffer.add(bytes, &INDEX, Some(ELEMENT_ARRAY_BUFFER))
        });
        let corners = tag_corners_in_tag(size_m).map(|p| [p.x, p.y, p.z].map(narrowed));
        let half = narrowed(0.5 * size_m);
        let bytes = bytes_of(corners.into_iter().flatten());
        let positions = buffer.add(bytes, &VEC3, Some(ARRAY_BUFFER));
        buffer.accessors[positions]["min"] = json!([-half, -half, 0.0]);
        buffer.accessors[positions]["max"] = json!([half, half, 0.0]);
        let primitive = json!({
            "attributes": { "POSITION": positions },
            "indices": indices,
            "material": 0,
        });
        let mesh = json!({ "name": "tag", "primitives": [primitive] });
        let mesh = added(&mut self.meshes, mesh);
        self.mesh_of_size.insert(size_m.to_bits(), mesh);
        mesh
    }

    fn motion(&mut self, node: usize, samples: impl Iterator<Item = (u64, Pose)>) {
        let (mut times, mut translations, mut rotations) = (Vec::new(), Vec::new(), Vec::new());
        for (t_ns, pose) in samples {
            if self.is_later(&mut times, t_ns) {
                let (translation, rotation) = floats(&pose);
                translations.extend(translation);
                rotations.extend(rotation);
            }
        }
        let input = self.times(&times);
        let translations = bytes_of(translations);
        let output = self.buffer.add(translations, &VEC3, None);
        self.channel(node, "translation", "LINEAR", input, output);
        let rotations = bytes_of(rotations);
        let output = self.buffer.add(rotations, &VEC4, None);
        self.channel(node, "rotation", "LINEAR", input, output);
    }

    fn visibility(&mut self, node: usize, changes: &[(u64, bool)]) {
        let (mut times, mut scales) = (Vec::new(), Vec::new());
        for (t_ns, is_visible) in changes {
            if self.is_later(&mut times, *t_ns) {
                scales.extend([f32::from(*is_visible); 3]);
            }
        }
        let input = self.times(&times);
        let output = self.buffer.add(bytes_of(scales), &VEC3, None);
        self.channel(node, "scale", "STEP", input, output);
    }

    /// Adds a time, s, if it is later than the last one as a 32-bit float.
    fn is_later(&self, times: &mut Vec<f32>, t_ns: u64) -> bool {
        let time = narrowed(self.animation.seconds(t_ns));
        let is_later = times.last().is_none_or(|last| *last < time);
        if is_later {
            times.push(time);
        }
        is_later
    }

    fn times(&mut self, times: &[f32]) -> usize {
        let bytes = bytes_of(times.iter().copied());
        let input = self.buffer.add(bytes, &SCALAR, None);
        self.buffer.accessors[input]["min"] = json!([times.first()]);
        self.buffer.accessors[input]["max"] = json!([times.last()]);
        input
    }

    fn channel(&mut self, node: usize, path: &str, mode: &str, input: usize, output: usize) {
        let sampler = json!({ "input": input, "output": output, "interpolation": mode });
        let sampler = added(&mut self.samplers, sampler);
        let target = json!({ "node": node, "path": path });
        self.channels
            .push(json!({ "sampler": sampler, "target": target }));
    }

    /// Header, JSON and binary data.
    fn file(self) -> Vec<u8> {
        let generator = format!("Sextant {}", env!("CARGO_PKG_VERSION"));
        let mut bytes = self.buffer.bytes;
        let black = json!({
            "name": "tag",
            "doubleSided": true,
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.02, 0.02, 0.02, 1.0],
                "metallicFactor": 0.0,
            },
        });
        let animation =
            json!({ "name": "poses", "channels": self.channels, "samplers": self.samplers });
        let lists = [
            ("cameras", self.cameras),
            (
                "materials",
                if self.meshes.is_empty() {
                    Vec::new()
                } else {
                    vec![black]
                },
            ),
            ("meshes", self.meshes),
            ("nodes", self.nodes),
            ("animations", vec![animation]),
            ("accessors", self.buffer.accessors),
            ("bufferViews", self.buffer.views),
            ("buffers", vec![json!({ "byteLength": bytes.len() })]),
        ];
        let mut document = Map::new();
        document.insert(
            "asset".into(),
            json!({ "version": "2.0", "generator": generator }),
        );
        document.insert("scene".into(), 0.into());
        document.insert("scenes".into(), json!([{ "nodes": [0] }]));
        for (name, list) in lists {
            // An empty list is invalid.
            if !list.is_empty() {
                document.insert(name.into(), list.into());
            }
        }
        let mut text = Value::Object(document).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let total = 12 + 8 + text.len() + 8 + bytes.len();
        let mut file = Vec::with_capacity(total);
        file.extend(MAGIC);
        file.extend(VERSION.to_le_bytes());
        file.extend((total as u32).to_le_bytes());
        for (kind, chunk) in [(JSON_CHUNK, text), (BINARY_CHUNK, bytes)] {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
        file
    }
}

impl Buffer {
    /// The accessor of elements that take a multiple of four bytes together.
    fn add(&mut self, bytes: Vec<u8>, element: &Element, target: Option<u32>) -> usize {
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.bytes.extend(bytes);
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        let view = added(&mut self.views, view);
        let accessor = json!({
            "bufferView": view,
            "componentType": element.component,
            "type": element.kind,
            "count": length / element.n_bytes,
        });
        added(&mut self.accessors, accessor)
    }
}

/// Appends to a list; the index of what was appended.
fn added(list: &mut Vec<Value>, value: Value) -> usize {
    list.push(value);
    list.len() - 1
}

/// Translation, and rotation x, y, z, w.
fn floats(pose: &Pose) -> ([f32; 3], [f32; 4]) {
    let parts = PoseParts::from(pose);
    (
        parts.position.map(narrowed),
        parts.orientation.map(narrowed),
    )
}

fn bytes_of(floats: impl IntoIterator<Item = f32>) -> Vec<u8> {
    floats.into_iter().flat_map(f32::to_le_bytes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::animation::tests::{animation, pose};
    use sextant_site_report::State;

    /// The JSON of a file.
    fn document(file: &[u8]) -> Value {
        assert_eq!(&file[..4], MAGIC);
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!([word(4), word(8)], [2, file.len()]);
        let end = 20 + word(12);
        assert_eq!(&file[end + 4..end + 8], BINARY_CHUNK);
        assert_eq!(end + 8 + word(end), file.len());
        serde_json::from_slice(&file[20..end]).unwrap()
    }

    #[test]
    fn a_file_has_one_root_that_turns_z_up() {
        let poses = [0, 20].map(|t_ms| pose("cube", t_ms, State::Tracking, 0.0));
        let document = document(&glb(&animation(&poses)).unwrap());
        assert_eq!(document["scenes"][0]["nodes"], json!([0]));
        let root = &document["nodes"][0];
        assert_eq!(root["children"], json!([1, 2]));
        let [x, w] = [0, 3].map(|k| root["rotation"][k].as_f64().unwrap());
        assert!((x + 0.5f64.sqrt()).abs() < 1e-7 && (w - 0.5f64.sqrt()).abs() < 1e-7);
        let camera = &document["cameras"][0]["perspective"];
        let ratio = camera["aspectRatio"].as_f64().unwrap();
        assert!((ratio - 640.0 / 600.0 / (480.0 / 610.0)).abs() < 1e-12);
        assert_eq!(
            document["animations"][0]["channels"]
                .as_array()
                .unwrap()
                .len(),
            2
        );
    }

    #[test]
    fn a_lost_object_is_scaled_to_zero() {
        let states = [
            (0, State::Tracking),
            (20, State::Lost),
            (40, State::Tracking),
        ];
        let poses = states.map(|(t_ms, state)| pose("cube", t_ms, state, 0.0));
        let document = document(&glb(&animation(&poses)).unwrap());
        let channel = &document["animations"][0]["channels"][2];
        assert_eq!(channel["target"]["path"], "scale");
        let sampler = &document["animations"][0]["samplers"][2];
        assert_eq!(sampler["interpolation"], "STEP");
    }

    #[test]
    fn times_that_are_equal_as_floats_have_one_sample() {
        let mut poses: Vec<_> = [0, 10_000_000]
            .map(|t_ms| pose("cube", t_ms, State::Tracking, 0.0))
            .into();
        poses.push(poses[1].clone());
        poses[2].capture_ns += 10_000;
        let document = document(&glb(&animation(&poses)).unwrap());
        let input = document["animations"][0]["samplers"][0]["input"]
            .as_u64()
            .unwrap();
        let times = &document["accessors"][input as usize];
        // First, its hold, the last, its hold.
        assert_eq!(times["count"], 4);
    }
}
