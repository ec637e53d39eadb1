//! A request to edit the rig or an object, as `POST /api/models` brings it.

use crate::refusal::{Refusal, RefusalKind};
use serde::Deserialize;
use sextant_proto::{PoseConfig, SigmaConfig};

/// The longest request: an object of as many tags as a message holds.
pub(crate) const MAX_BYTES: usize = 512 * 1024;

/// What is to be edited.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub(crate) enum EditRequest {
    /// Name, pose and sigma of a camera of the rig.
    EditCamera(CameraEdit),
    /// Take a camera out of the rig.
    RemoveCamera(Removal),
    /// Name, place and tags of an object; adds it where it names no object.
    EditObject(ObjectEdit),
    /// Remove an object from the site.
    RemoveObject(Removal),
}

/// A camera as it is to be. What is not named here stays: the lens, the resolution, the exposure.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraEdit {
    /// Its present name.
    pub camera: String,
    /// As it was when the person began.
    pub version: String,
    /// Its name from now on.
    pub id: String,
    /// `world_from_camera`, or `carrier_from_camera` of a camera that an object carries; none where it is not
    /// calibrated.
    pub pose: Option<PoseConfig>,
    /// Standard deviation of that pose; none where the file gives none.
    pub sigma: Option<SigmaConfig>,
}

/// What is to go.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Removal {
    /// Its name.
    pub id: String,
    /// As it was when the person began.
    pub version: String,
}

/// An object, or one link of an articulated object, as it is to be. What is not named here stays: joints, other links,
/// sigmas of frame and scale.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectEdit {
    /// Its present name; none adds an object.
    pub object: Option<String>,
    /// The link whose tags these are.
    #[serde(default)]
    pub link: Option<String>,
    /// As it was when the person began; none of an object that is added.
    pub version: Option<String>,
    /// Its name from now on.
    pub id: String,
    /// `world_from_object` of a landmark.
    #[serde(default)]
    pub place: Option<PoseConfig>,
    /// All of its tags.
    pub tags: Vec<TagEdit>,
}

/// A tag as it is to be.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TagEdit {
    pub family: String,
    pub id: u32,
    /// Edge of its black square.
    pub size_m: f64,
    #[serde(default)]
    pub size_sigma_m: Option<f64>,
    /// `object_from_tag`, or `link_from_tag`; none until it is learned.
    pub pose: Option<PoseConfig>,
    #[serde(default)]
    pub sigma: Option<SigmaConfig>,
}

impl EditRequest {
    /// Reads one.
    pub(crate) fn parse(body: &[u8]) -> Result<Self, Refusal> {
        serde_json::from_slice(body).map_err(|error| Refusal {
            kind: RefusalKind::Wrong,
            field: None,
            cause: format!("not an edit: {error}"),
        })
    }
}
