//! The schemas as JSON Schema, with the names by which viewers know them.

use serde_json::{Map, Value, json};

/// A schema of Foxglove's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "each is the schema of its name")]
pub enum Schema {
    FrameTransforms,
    CameraCalibration,
    SceneUpdate,
}

impl Schema {
    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::FrameTransforms => "foxglove.FrameTransforms",
            Self::CameraCalibration => "foxglove.CameraCalibration",
            Self::SceneUpdate => "foxglove.SceneUpdate",
        }
    }

    /// Its JSON Schema: the fields that are written.
    #[must_use]
    pub fn json_schema(self) -> Value {
        let mut schema = match self {
            Self::FrameTransforms => object([("transforms", list(transform()))]),
            Self::CameraCalibration => calibration(),
            Self::SceneUpdate => object([
                ("deletions", list(deletion())),
                ("entities", list(entity())),
            ]),
        };
        schema["title"] = json!(self.name());
        schema
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
