//! What can be wrong with a site, with the words for it and what is to be done.

use serde::{Deserialize, Serialize};

use sextant_site_model::{CameraId, ObjectId, TagId};

use crate::clock_cause::{clock_cause, in_brackets};
use crate::sentences;

/// Something wrong with the site. On the wire the number of the variant, from 0, in this order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// The camera is not where the rig says.
    CameraMoved {
        /// Which camera.
        camera: CameraId,
    },
    /// One of the two is not where the rig says; no third sees what they see.
    CamerasDisagree {
        /// The one.
        a: CameraId,
        /// The other.
        b: CameraId,
    },
    /// The tag is not where the object's model says: loose or wrongly placed.
    TagMisplaced {
        /// On which object.
        object: ObjectId,
        /// Which tag.
        tag: TagId,
    },
    /// The tag is not as large as the object's model says.
    TagSize {
        /// On which object.
        object: ObjectId,
        /// Which tag.
        tag: TagId,
        /// Its true size over the model's.
        ratio: f64,
    },
    /// The tag is seen where the object can't have it: on something else, or a second print of it.
    TagElsewhere {
        /// The object that has it.
        object: ObjectId,
        /// Which tag.
        tag: TagId,
        /// The object that it is seen on, if it is one.
        on: Option<ObjectId>,
    },
    /// The camera's stamps lie that many seconds after the reference clock.
    ClockOff {
        /// Which camera.
        camera: CameraId,
        /// Seconds, one sigma at most a tenth of it.
        offset_s: f64,
    },
    /// The camera's images are not taken in, since their stamps are too far from the present.
    Untimely {
        /// Which camera.
        camera: CameraId,
        /// Seconds from the newest images' stamps to their arrival; below zero where stamps lie ahead.
        age_s: f64,
    },
    /// The tag is in one image twice.
    DuplicateTag {
        /// Which camera saw it.
        camera: CameraId,
        /// Which tag.
        tag: TagId,
    },
    /// The clock of the fusion node's host differs from that of most cameras; poses have the cameras' time.
    HostClockOff {
        /// Seconds that it lies after theirs.
        offset_s: f64,
    },
    /// The camera's images have not changed for a while, corner for corner: its capture stands still.
    CameraFrozen {
        /// Which camera.
        camera: CameraId,
        /// For how long, s.
        still_s: f64,
    },
    /// The camera bends what it sees otherwise than its lens in the rig says.
    LensOff {
        /// Which camera.
        camera: CameraId,
    },
    /// All tags of the object are larger or smaller than its model says: printed at another scale.
    ObjectScaled {
        /// Which object.
        object: ObjectId,
        /// Their true size over the model's.
        ratio: f64,
    },
    /// Most views of the object's tags contradict any pose of it: its model or the cameras' poses are wrong, and it is
    /// not tracked.
    ObjectContradicted {
        /// Which object.
        object: ObjectId,
        /// Share of the views, 0 to 1.
        share: f64,
    },
    /// No tag of the object has a place on it, so that it can't be tracked.
    ObjectUnplaced {
        /// Which object.
        object: ObjectId,
    },
    /// The camera's images are not taken in, since they are of another size than the rig says.
    ImageSize {
        /// Which camera.
        camera: CameraId,
        /// Their width and height, px.
        size: [u32; 2],
        /// Those of the rig, px.
        of_rig: [u32; 2],
    },
    /// The camera is turned by right angles about its line of sight, as a phone held in the other landscape.
    CameraTurned {
        /// Which camera.
        camera: CameraId,
        /// 90, 180 or 270 about its z axis.
        degrees: u16,
    },
    /// Each of the two cameras has the name of the other.
    CamerasExchanged {
        /// The one.
        a: CameraId,
        /// The other.
        b: CameraId,
    },
    /// The camera has another focal length than the rig says: another lens or another zoom.
    LensChanged {
        /// Which camera.
        camera: CameraId,
        /// Its focal length over the rig's.
        ratio: f64,
    },
    /// The tag is stuck on turned by right angles in its plane.
    TagTurned {
        /// On which object.
        object: ObjectId,
        /// Which tag.
        tag: TagId,
        /// 90, 180 or 270 about its z axis.
        degrees: u16,
    },
    /// Each of the two tags is where the other should be.
    TagsExchanged {
        /// On which object.
        object: ObjectId,
        /// The one.
        a: TagId,
        /// The other.
        b: TagId,
    },
    /// The camera sees no tag, though an object that others track stands in its picture.
    CameraBlind {
        /// Which camera.
        camera: CameraId,
        /// Which object.
        object: ObjectId,
        /// For how long, s.
        blind_s: f64,
    },
}

sentences! { Fault {
    Self::CameraMoved { camera } =>
        "camera {camera} is not where the rig says",
        ": calibrate it again";
    Self::CamerasDisagree { a, b } =>
        "cameras {a} and {b} contradict each other, one is not where the rig says",
        ": calibrate both again, or let a third see the same";
    Self::TagMisplaced { object, tag } =>
        "tag {tag} of object {object} is loose or not where the model says",
        ": stick it back, or learn the object again";
    Self::TagSize { object, tag, ratio } =>
        "tag {tag} of object {object} is {percent:.1} % {how} than the model says",
        ": measure it and correct its size there",
        percent = (ratio - 1.0).abs() * 100.0,
        how = if *ratio > 1.0 { "larger" } else { "smaller" };
    Self::TagElsewhere { object, tag, on: Some(other) } =>
        "tag {tag} of object {object} is seen where it can't be, on object {other}",
        ": take it off, or print another id for one of them";
    Self::TagElsewhere { object, tag, on: None } =>
        "tag {tag} of object {object} is seen where it can't be",
        ": take it off there, or print another id for one of them";
    Self::ClockOff { camera, offset_s } if offset_s.abs() < 0.1 =>
        "the clock of camera {camera} is off by {ms:+.1} ms",
        ": set its clock; poses allow for it",
        ms = offset_s * 1e3;
    Self::ClockOff { camera, offset_s } =>
        "the clock of camera {camera} is {off} {side}{cause}",
        ": set its clock; poses allow for it",
        off = span(offset_s.abs()),
        side = if *offset_s > 0.0 { "ahead" } else { "behind" },
        cause = in_brackets(*offset_s);
    Self::Untimely { camera, age_s } if *age_s < 0.0 =>
        "images of camera {camera} are stamped {ahead} ahead of their arrival{cause} and left out",
        ": set its clock",
        ahead = span(-age_s),
        cause = in_brackets(-age_s);
    Self::Untimely { camera, age_s } =>
        "images of camera {camera} arrive {age} after their stamps{cause} and are left out",
        ": set its clock, or look at its network",
        age = span(*age_s),
        cause = in_brackets(-age_s);
    Self::DuplicateTag { camera, tag } =>
        "camera {camera} sees tag {tag} twice",
        ": print another id for one of them";
    Self::HostClockOff { offset_s } if are_cameras_wrong(*offset_s) =>
        "the clocks of the cameras are {off} ahead of that of the fusion host ({cause})",
        ": have them told the offset (ptp4l's utc_offset, phc2sys -O); until then poses have their time",
        off = span(-offset_s),
        cause = clock_cause(-offset_s).unwrap_or_default();
    Self::HostClockOff { offset_s } =>
        "the clock of the fusion host is {off} {side} those of the cameras{cause}",
        ": set it; poses have the cameras' time",
        off = span(offset_s.abs()),
        side = if *offset_s > 0.0 { "ahead of" } else { "behind" },
        cause = in_brackets(*offset_s);
    Self::CameraFrozen { camera, still_s } =>
        "the picture of camera {camera} has stood still for {still_s:.0} s, corner for corner",
        ": restart its capture";
    Self::LensOff { camera } =>
        "camera {camera} bends what it sees otherwise than its lens in the rig file says",
        ": run `sextant calibrate lens`";
    Self::ObjectScaled { object, ratio } =>
        "the tags of object {object} are {percent:.0} % as large as the model says, all of them",
        ": measure one and correct the sizes",
        percent = ratio * 100.0;
    Self::ObjectContradicted { object, share } =>
        "{percent:.0} % of the views of object {object} contradict any pose of it",
        ": check which tags are where, their sizes and the cameras' poses, or learn the object again",
        percent = share * 100.0;
    Self::ObjectUnplaced { object } =>
        "no tag of object {object} has a place on it, it can't be tracked",
        ": run `sextant learn`, or give object_from_tag in its file";
    Self::ImageSize { camera, size: [width, height], of_rig: [rig_width, rig_height] } =>
        "images of camera {camera} are {width}x{height}, its lens in the rig is of {rig_width}x{rig_height}, so that \
         they are left out",
        ": let it take images of that size, or calibrate the lens at the other one";
    Self::CameraTurned { camera, degrees } =>
        "camera {camera} is turned by {degrees} degrees about its line of sight, poses allow for it",
        ": turn it back, or calibrate it again";
    Self::CamerasExchanged { a, b } =>
        "cameras {a} and {b} have exchanged their names, poses allow for it",
        ": exchange the two ids in the rig file, or the two cables";
    Self::LensChanged { camera, ratio } =>
        "the focal length of camera {camera} is {percent:.0} % of that in the rig file, another lens or zoom",
        ": set the zoom back, or run `sextant calibrate lens`",
        percent = ratio * 100.0;
    Self::TagTurned { object, tag, degrees: 180 } =>
        "tag {tag} of object {object} is stuck on upside down, poses allow for it",
        ": turn its pose in the object's file by 180 degrees about z";
    Self::TagTurned { object, tag, degrees } =>
        "tag {tag} of object {object} is stuck on turned by {degrees} degrees, poses allow for it",
        ": turn its pose in the object's file by as much about z";
    Self::TagsExchanged { object, a, b } =>
        "tags {a} and {b} of object {object} are exchanged, poses allow for it",
        ": exchange their ids in the object's file";
    Self::CameraBlind { camera, object, blind_s } =>
        "camera {camera} has seen no tag for {blind_s:.0} s, though object {object} is in its picture by the rig: it \
         is covered or out of focus, was moved, or has another lens",
        ": look at its picture; put it back, or calibrate it again";
}}

impl Fault {
    /// The one camera that it is about.
    #[must_use]
    pub fn camera(&self) -> Option<&CameraId> {
        match self {
            Self::CameraMoved { camera }
            | Self::ClockOff { camera, .. }
            | Self::Untimely { camera, .. }
            | Self::DuplicateTag { camera, .. }
            | Self::CameraFrozen { camera, .. }
            | Self::CameraBlind { camera, .. }
            | Self::LensOff { camera }
            | Self::ImageSize { camera, .. }
            | Self::CameraTurned { camera, .. }
            | Self::LensChanged { camera, .. } => Some(camera),
            _ => None,
        }
    }
}

/// Whether the host's clock is behind by what cameras on another time scale are ahead: then it is theirs that is wrong.
fn are_cameras_wrong(host_offset_s: f64) -> bool {
    (-40.0..-10.0).contains(&host_offset_s) && clock_cause(-host_offset_s).is_some()
}

/// A span of time in words.
fn span(seconds: f64) -> String {
    const DAY: f64 = 86_400.0;
    match seconds {
        s if s < 120.0 => format!("{s:.2} s"),
        s if s < 2.0 * DAY => format!("{:.1} h", s / 3600.0),
        s if s < 700.0 * DAY => format!("{:.0} days", s / DAY),
        s => format!("{:.1} years", s / (365.25 * DAY)),
    }
}
