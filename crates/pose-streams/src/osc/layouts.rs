//! Which addresses and arguments a pose becomes: Sextant's own layout and those of two programs.

use crate::axes::{Axes, ConvertedPose, euler_zxy_deg};
use crate::osc::{OscArgument, OscMessage};
use sextant_proto::ObjectPose;
use sextant_site_model::ObjectId;
use sextant_site_report::State;
use std::str::FromStr;

/// Trackers that VRChat has.
pub const MAX_VRCHAT_TRACKERS: usize = 8;
/// Trackers that Virtual Motion Tracker has.
pub const MAX_VMT_TRACKERS: usize = 58;

/// What is sent for a pose.
#[derive(Debug, Clone, PartialEq)]
pub enum OscLayout {
    /// One message: position x y z, quaternion x y z w.
    Plain {
        /// Its address.
        address: AddressTemplate,
        /// The convention of its numbers.
        axes: Axes,
    },
    /// `/tracking/trackers/N/position` and `/tracking/trackers/N/rotation` of VRChat (docs.vrchat.com, "OSC Trackers"),
    /// N from 1 in the order of the objects: Unity's axes, Euler angles in degrees.
    VrChat {
        /// The objects that are trackers.
        trackers: Vec<ObjectId>,
    },
    /// `/VMT/Room/Unity` of Virtual Motion Tracker (gpsnmeajp, "API"), index from 0 in the order of the objects:
    /// Unity's axes, a quaternion. A lost object is switched off.
    Vmt {
        /// The objects that are trackers.
        trackers: Vec<ObjectId>,
    },
}

impl OscLayout {
    /// The messages for a pose; none for a pose that says nothing yet, for a lost object (but see [`Self::Vmt`]) and
    /// for an object that is no tracker.
    #[must_use]
    pub fn messages(&self, pose: &ObjectPose) -> Vec<OscMessage> {
        let is_known = matches!(pose.state, State::Tracking | State::Coasting);
        match self {
            Self::Plain { address, axes } if is_known => {
                let converted = axes.convert(&pose.world_from_object());
                vec![OscMessage::floats(
                    address.address(&pose.object),
                    all(&converted),
                )]
            }
            Self::VrChat { trackers } if is_known => {
                index_of(trackers, pose).map_or_else(Vec::new, |index| vrchat(index + 1, pose))
            }
            Self::Vmt { trackers } if is_known || pose.state == State::Lost => {
                let index = index_of(trackers, pose);
                index.map_or_else(Vec::new, |index| vec![vmt(index, pose, is_known)])
            }
            _ => Vec::new(),
        }
    }
}

fn index_of(trackers: &[ObjectId], pose: &ObjectPose) -> Option<usize> {
    trackers.iter().position(|tracker| *tracker == pose.object)
}

fn all(pose: &ConvertedPose) -> impl Iterator<Item = f64> {
    pose.position.into_iter().chain(pose.orientation)
}

fn vrchat(number: usize, pose: &ObjectPose) -> Vec<OscMessage> {
    let converted = Axes::Unity.convert(&pose.world_from_object());
    let address = |what| format!("/tracking/trackers/{number}/{what}");
    let euler = euler_zxy_deg(converted.orientation);
    vec![
        OscMessage::floats(address("position"), converted.position),
        OscMessage::floats(address("rotation"), euler),
    ]
}

fn vmt(index: usize, pose: &ObjectPose, is_known: bool) -> OscMessage {
    let converted = Axes::Unity.convert(&pose.world_from_object());
    let index = i32::try_from(index).unwrap_or(i32::MAX);
    let time_offset = 0.0;
    let mut message = OscMessage::floats(
        "/VMT/Room/Unity".to_owned(),
        std::iter::once(time_offset).chain(all(&converted)),
    );
    let head = [index, i32::from(is_known)].map(OscArgument::Int);
    message.arguments.splice(..0, head);
    message
}

/// An address with `{object}` in place of an object's id.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AddressTemplate(String);

/// Why a text is no address.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// It does not begin with a slash.
    #[error("an address begins with `/`")]
    NoSlash,
    /// A character that OSC keeps for itself, or that is not ASCII.
    #[error("an address has no {0:?}; the one placeholder is {{object}}")]
    Character(char),
}

impl FromStr for AddressTemplate {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        if !text.starts_with('/') {
            return Err(AddressError::NoSlash);
        }
        let rest = text.replace(PLACEHOLDER, "");
        let is_wrong = |c: &char| !c.is_ascii_graphic() || " #*,?[]{}".contains(*c);
        match rest.chars().find(is_wrong) {
            Some(wrong) => Err(AddressError::Character(wrong)),
            None => Ok(Self(text.to_owned())),
        }
    }
}

const PLACEHOLDER: &str = "{object}";

impl AddressTemplate {
    /// The address of an object.
    #[must_use]
    pub fn address(&self, object: &ObjectId) -> String {
        self.0.replace(PLACEHOLDER, object.as_str())
    }

    /// Whether objects have addresses of their own.
    #[must_use]
    pub fn distinguishes_objects(&self) -> bool {
        self.0.contains(PLACEHOLDER)
    }
}

impl std::fmt::Display for AddressTemplate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(state: State) -> ObjectPose {
        ObjectPose {
            object: id("cube"),
            epoch: 1,
            sequence: 1,
            capture_ns: 1,
            published_ns: 1,
            state,
            position: [1.0, 2.0, 3.0],
            // A quarter turn to the left.
            orientation: [0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()],
            covariance: [0.0; 36],
            twist: [0.0; 6],
            cameras: 1,
            tags: 1,
            rms_px: 0.1,
        }
    }

    fn id(text: &str) -> ObjectId {
        ObjectId::new(text).unwrap()
    }

    fn floats(message: &OscMessage) -> Vec<f32> {
        let float = |argument: &OscArgument| match argument {
            OscArgument::Float(value) => Some(*value),
            OscArgument::Int(_) => None,
        };
        message.arguments.iter().filter_map(float).collect()
    }

    const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

    #[test]
    fn plain_is_position_and_quaternion_under_the_objects_address() {
        let layout = OscLayout::Plain {
            address: "/sextant/{object}/pose".parse().unwrap(),
            axes: Axes::ZUp,
        };
        let messages = layout.messages(&pose(State::Coasting));
        assert_eq!(messages[0].address, "/sextant/cube/pose");
        assert_eq!(floats(&messages[0]), [1.0, 2.0, 3.0, 0.0, 0.0, HALF, HALF]);
        assert_eq!(layout.messages(&pose(State::Initialising)), []);
        assert_eq!(layout.messages(&pose(State::Lost)), []);
    }

    #[test]
    fn vrchat_numbers_its_trackers_from_one_and_turns_in_degrees() {
        let layout = OscLayout::VrChat {
            trackers: vec![id("hip"), id("cube")],
        };
        let messages = layout.messages(&pose(State::Tracking));
        let addresses: Vec<&str> = messages.iter().map(|m| m.address.as_str()).collect();
        assert_eq!(
            addresses,
            [
                "/tracking/trackers/2/position",
                "/tracking/trackers/2/rotation"
            ]
        );
        assert_eq!(floats(&messages[0]), [-2.0, 3.0, 1.0]);
        let euler = floats(&messages[1]);
        assert!((euler[1] + 90.0).abs() < 1e-4, "{euler:?}");
    }

    #[test]
    fn vmt_has_index_enable_and_quaternion_and_switches_lost_objects_off() {
        let layout = OscLayout::Vmt {
            trackers: vec![id("cube")],
        };
        let sent = |state| layout.messages(&pose(state)).remove(0);
        let message = sent(State::Tracking);
        assert_eq!(message.arguments[..2], [0, 1].map(OscArgument::Int));
        assert_eq!(
            floats(&message),
            [0.0, -2.0, 3.0, 1.0, 0.0, -HALF, 0.0, HALF]
        );
        assert_eq!(sent(State::Lost).arguments[1], OscArgument::Int(0));
    }

    #[test]
    fn addresses_are_checked() {
        let parsed = |text: &str| text.parse::<AddressTemplate>();
        assert!(parsed("/a/{object}/b").unwrap().distinguishes_objects());
        assert_eq!(parsed("a"), Err(AddressError::NoSlash));
        assert_eq!(parsed("/a b"), Err(AddressError::Character(' ')));
        assert_eq!(parsed("/{objct}"), Err(AddressError::Character('{')));
        assert_eq!(parsed("/ä"), Err(AddressError::Character('ä')));
    }
}
