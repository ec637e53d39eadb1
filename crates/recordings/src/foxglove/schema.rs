//! The schemas as JSON Schema, with the names by which viewers know them; that of pictures, which are no JSON, as ROS has it.

use crate::compressed_image as image;
use serde_json::{Map, Value, json};

/// A schema that viewers know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "each is the schema of its name")]
pub enum Schema {
    FrameTransforms,
    CameraCalibration,
    SceneUpdate,
    ImageAnnotations,
    /// Of ROS; its messages are JSON all the same.
    DiagnosticArray,
    /// Of ROS, in CDR.
    CompressedImage,
}

impl Schema {
    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::FrameTransforms => "foxglove.FrameTransforms",
            Self::CameraCalibration => "foxglove.CameraCalibration",
            Self::SceneUpdate => "foxglove.SceneUpdate",
            Self::ImageAnnotations => "foxglove.ImageAnnotations",
            Self::DiagnosticArray => "diagnostic_msgs/msg/DiagnosticArray",
            Self::CompressedImage => image::SCHEMA,
        }
    }

    /// Encoding of its messages.
    #[must_use]
    pub const fn message_encoding(self) -> &'static str {
        match self {
            Self::CompressedImage => image::ENCODING,
            _ => "json",
        }
    }

    /// Encoding of [`Self::text`].
    #[must_use]
    pub const fn encoding(self) -> &'static str {
        match self {
            Self::CompressedImage => image::SCHEMA_ENCODING,
            _ => "jsonschema",
        }
    }

    /// The schema as viewers get it: the fields that are written.
    #[must_use]
    pub fn text(self) -> String {
        match self.json_schema() {
            Some(schema) => schema.to_string(),
            None => image::SCHEMA_TEXT.to_owned(),
        }
    }

    /// Its JSON Schema, unless its messages are not JSON.
    #[must_use]
    pub fn json_schema(self) -> Option<Value> {
        let mut schema = match self {
            Self::FrameTransforms => object([("transforms", list(transform()))]),
            Self::CameraCalibration => calibration(),
            Self::SceneUpdate => object([
                ("deletions", list(deletion())),
                ("entities", list(entity())),
            ]),
            Self::ImageAnnotations => annotations(),
            Self::DiagnosticArray => object([("header", header()), ("status", list(diagnosis()))]),
            Self::CompressedImage => return None,
        };
        schema["title"] = json!(self.name());
        Some(schema)
    }
}

fn object<const N: usize>(properties: [(&str, Value); N]) -> Value {
    let properties = properties.into_iter();
    let properties: Map<String, Value> = properties
        .map(|(name, schema)| (name.to_owned(), schema))
        .collect();
    json!({ "type": "object", "properties": properties })
}

fn list(items: Value) -> Value {
    json!({ "type": "array", "items": items })
}

fn number() -> Value {
    json!({ "type": "number" })
}

fn integer() -> Value {
    json!({ "type": "integer", "minimum": 0 })
}

fn text() -> Value {
    json!({ "type": "string" })
}

fn flag() -> Value {
    json!({ "type": "boolean" })
}

/// A moment or a duration, by the titles that viewers look for.
fn time(title: &str) -> Value {
    let mut time = object([("sec", integer()), ("nsec", integer())]);
    time["title"] = json!(title);
    time
}

fn vector() -> Value {
    object([("x", number()), ("y", number()), ("z", number())])
}

fn quaternion() -> Value {
    object([
        ("x", number()),
        ("y", number()),
        ("z", number()),
        ("w", number()),
    ])
}

fn pose() -> Value {
    object([("position", vector()), ("orientation", quaternion())])
}

fn colour() -> Value {
    object([
        ("r", number()),
        ("g", number()),
        ("b", number()),
        ("a", number()),
    ])
}

fn transform() -> Value {
    object([
        ("timestamp", time("time")),
        ("parent_frame_id", text()),
        ("child_frame_id", text()),
        ("translation", vector()),
        ("rotation", quaternion()),
    ])
}

fn calibration() -> Value {
    object([
        ("timestamp", time("time")),
        ("frame_id", text()),
        ("width", integer()),
        ("height", integer()),
        ("distortion_model", text()),
        ("D", list(number())),
        ("K", list(number())),
        ("R", list(number())),
        ("P", list(number())),
    ])
}

fn deletion() -> Value {
    object([
        ("timestamp", time("time")),
        ("type", integer()),
        ("id", text()),
    ])
}

fn entity() -> Value {
    object([
        ("timestamp", time("time")),
        ("frame_id", text()),
        ("id", text()),
        ("lifetime", time("duration")),
        ("frame_locked", flag()),
        ("metadata", list(object([]))),
        ("arrows", list(object([]))),
        ("cubes", list(object([]))),
        ("spheres", list(sphere())),
        ("cylinders", list(object([]))),
        ("lines", list(line())),
        ("triangles", list(object([]))),
        ("texts", list(object([]))),
        ("models", list(object([]))),
    ])
}

fn sphere() -> Value {
    object([("pose", pose()), ("size", vector()), ("color", colour())])
}

fn line() -> Value {
    object([
        ("type", integer()),
        ("pose", pose()),
        ("thickness", number()),
        ("scale_invariant", flag()),
        ("points", list(vector())),
        ("color", colour()),
        ("colors", list(colour())),
        ("indices", list(integer())),
    ])
}

fn annotations() -> Value {
    object([
        ("timestamp", time("time")),
        ("circles", list(object([]))),
        ("points", list(points())),
        ("texts", list(label())),
    ])
}

fn points() -> Value {
    object([
        ("timestamp", time("time")),
        ("type", integer()),
        ("points", list(point())),
        ("outline_color", colour()),
        ("outline_colors", list(colour())),
        ("fill_color", colour()),
        ("thickness", number()),
    ])
}

fn label() -> Value {
    object([
        ("timestamp", time("time")),
        ("position", point()),
        ("text", text()),
        ("font_size", number()),
        ("text_color", colour()),
        ("background_color", colour()),
    ])
}

fn point() -> Value {
    object([("x", number()), ("y", number())])
}

fn header() -> Value {
    object([("stamp", time("time")), ("frame_id", text())])
}

fn diagnosis() -> Value {
    let value = object([("key", text()), ("value", text())]);
    object([
        ("level", integer()),
        ("name", text()),
        ("message", text()),
        ("hardware_id", text()),
        ("values", list(value)),
    ])
}
