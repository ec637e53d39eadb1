//! A request to a wizard, as `POST /api/wizard` brings it.

use crate::refusal::{Refusal, RefusalKind};
use serde::Deserialize;
use sextant_proto::{CameraSettings, Message, NodeId};

/// The longest command: a board file of a few hundred tags.
pub(crate) const MAX_BYTES: usize = 256 * 1024;

/// What a person asks for.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub(crate) enum Command {
    /// Begin; refused while another wizard runs.
    Start(Box<Start>),
    /// Solve with the images that are there.
    Solve,
    /// Go on collecting after a result, or in place of a solve that takes too long.
    Resume,
    /// Keep the result: in the site's files, and in force on the running site.
    Keep,
    /// Give up, or put a finished wizard away.
    Discard,
    /// Put in force the refined calibration that a fusion node proposes; no wizard has a part in it.
    ApplyRefinement { node: NodeId },
    /// Put in force what was before the last change, as a fusion node has it.
    Revert { node: NodeId },
    /// Set exposure, gain and rate of a camera; the camera's status shows the outcome.
    SetCamera(CameraSettings),
}

/// Which wizard, and what it has to know.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "wizard", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Start {
    /// A camera's lens.
    Lens {
        camera: String,
        board: BoardRequest,
        /// The lens model; without it the images choose.
        #[serde(default)]
        model: Option<String>,
    },
    /// Where the cameras are.
    Rig {
        object: ObjectRequest,
        origin: OriginRequest,
    },
    /// Where an object's tags sit.
    Learn {
        id: String,
        #[serde(default = "usual_family")]
        family: String,
        tags: Vec<TagRequest>,
        /// Cameras whose images count; none means all.
        #[serde(default)]
        cameras: Vec<String>,
        /// The tag whose frame is the object's; without it the middle of the tags.
        #[serde(default)]
        origin: Option<u32>,
        /// Whether the object's other tags, as the site knows them, stay where they are.
        #[serde(default)]
        others: Others,
    },
}

/// The board of the lens wizard.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum BoardRequest {
    /// Text of the object file that `sextant print board` wrote.
    File(String),
    /// As it was printed.
    Grid(GridRequest),
}

/// A printed grid of tags.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct GridRequest {
    pub columns: u16,
    pub rows: u16,
    /// Edge of a black square as printed.
    pub size_m: f64,
    /// The tag at the top left.
    #[serde(default)]
    pub first: u32,
    #[serde(default = "usual_family")]
    pub family: String,
}

/// What is carried through the room.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ObjectRequest {
    /// An object of the site.
    Known(String),
    /// Text of an object file.
    File(String),
}

/// The world's frame.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum OriginRequest {
    /// As it is: the first camera that has a pose keeps it.
    AsItIs,
    /// A camera's own frame.
    Camera(String),
    /// That of a tag on the floor.
    Tag {
        #[serde(default = "usual_family")]
        family: String,
        id: u32,
        size_m: f64,
    },
}

/// A tag to be placed.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TagRequest {
    pub id: u32,
    /// Edge of its black square.
    pub size_m: f64,
}

/// What becomes of tags that the site's object has and that are not to be placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Others {
    /// The object consists of the placed tags only.
    #[default]
    Leave,
    /// They stay where they are, and the object's frame with them.
    Keep,
}

fn usual_family() -> String {
    "tag36h11".to_owned()
}

/// Whether a camera may have these settings, apart from what its driver can do.
pub(super) fn check_settings(settings: &CameraSettings) -> Result<(), Refusal> {
    settings.check().map_err(|wrong| match wrong.0 {
        field @ "exposure_us" => Refusal::wrong(field, "an exposure is 1 us to 1 s"),
        field @ "gain" => Refusal::wrong(field, "a gain is 0 to 1000000"),
        field => Refusal::wrong(field, "a rate is 0.1 to 1000 images/s"),
    })
}

impl Command {
    /// Reads one; what is no command is named.
    pub(crate) fn parse(body: &[u8]) -> Result<Self, Refusal> {
        serde_json::from_slice(body).map_err(|error| Refusal {
            kind: RefusalKind::Wrong,
            field: None,
            cause: format!("not a command: {error}"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Command, Refusal> {
        Command::parse(text.as_bytes())
    }

    #[test]
    fn each_wizard_is_started_by_its_own_request() {
        let lens = r#"{"do":"start","wizard":"lens","camera":"a","board":{"grid":{"columns":5,"rows":6,"size_m":0.028}}}"#;
        let rig = r#"{"do":"start","wizard":"rig","object":{"known":"cube"},"origin":"as_it_is"}"#;
        let learn =
            r#"{"do":"start","wizard":"learn","id":"cube","tags":[{"id":3,"size_m":0.04}]}"#;
        for start in [lens, rig, learn] {
            assert!(matches!(read(start), Ok(Command::Start(_))), "{start}");
        }
        assert_eq!(read(r#"{"do":"keep"}"#), Ok(Command::Keep));
    }

    #[test]
    fn settings_of_a_camera_are_checked_at_their_fields() {
        let refused = |text: &str| match read(text).unwrap() {
            Command::SetCamera(settings) => check_settings(&settings).err().and_then(|r| r.field),
            other => panic!("{other:?}"),
        };
        let with = |field: &str| format!(r#"{{"do":"set_camera","camera":"north",{field}}}"#);
        assert_eq!(refused(&with(r#""exposure_us":4000,"gain":null"#)), None);
        assert_eq!(refused(&with(r#""exposure_us":0"#)), Some("exposure_us"));
        assert_eq!(refused(&with(r#""gain":-1"#)), Some("gain"));
        assert_eq!(refused(&with(r#""rate_hz":0"#)), Some("rate_hz"));
        assert!(read(&with(r#""focus":1"#)).is_err());
    }

    #[test]
    fn what_is_no_command_is_refused_in_words() {
        let wrongs = [
            r#"{"do":"dance"}"#,
            r#"{"do":"start","wizard":"lens"}"#,
            r#"{"do":"start","wizard":"learn","id":"cube","tags":[{"id":-1,"size_m":0.04}]}"#,
            r#"{"do":"start","wizard":"rig","object":{"known":"cube"},"origin":"as_it_is","more":1}"#,
            "[]",
            "",
            "\u{0}",
        ];
        for wrong in wrongs {
            let refusal = read(wrong).unwrap_err();
            assert!(refusal.cause.starts_with("not a command"), "{wrong}");
        }
    }
}
