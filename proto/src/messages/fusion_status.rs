//! Status of a fusion node, about once a second: messages received and rejected, objects, faults and notices.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{DecodeError, Message, MessageKind};
use crate::ids::NodeId;
use crate::limits::{MAX_CAMERAS, MAX_FAULTS, MAX_IMPERFECTIONS, MAX_NOTICES, MAX_OBJECTS};
use crate::messages::notice::Notice;
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::{CameraId, ObjectId};
use sextant_site_report::{Fault, Imperfection, State};

/// Status of a fusion node. Counts are since the process started.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FusionStatus {
    /// The node; the same as in the key.
    pub node: NodeId,
    /// Version of the software.
    pub version: String,
    /// Seconds since the process started.
    pub uptime_s: u64,
    /// Newest epoch of the poses that it publishes; none while it publishes none.
    pub epoch: Option<u64>,
    /// Messages of each camera of the rig, ordered by id.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_CAMERAS>")]
    pub cameras: Vec<CameraIntake>,
    /// Messages rejected under keys of cameras that the rig lacks.
    pub foreign: Rejections,
    /// The objects that the node tracks, ordered by id.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_OBJECTS>")]
    pub objects: Vec<ObjectHealth>,
    /// What is wrong with the site.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_FAULTS>")]
    pub faults: Vec<Fault>,
    /// Further faults that found no room in the list.
    pub faults_left_out: u32,
    /// What the images show to be imperfect in the site's files; poses allow for it.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_IMPERFECTIONS>")]
    pub imperfections: Vec<Imperfection>,
    /// What happened to the node itself.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_NOTICES>")]
    pub notices: Vec<Notice>,
}

/// Messages of one camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraIntake {
    /// The camera.
    pub camera: CameraId,
    /// Payloads that arrived under its key, refused ones included.
    pub received: u64,
    /// Those that were refused.
    pub rejected: Rejections,
    /// Tags that belong to no object.
    pub unknown_tags: u64,
    /// Images too old for the estimator's window, or on arrival.
    pub late: u64,
    /// Tags that the estimator rejected as outliers.
    pub gated: u64,
    /// Capture time of its newest image, ns since the Unix epoch; 0 before the first.
    pub last_capture_ns: u64,
    /// Images per second over the last seconds.
    pub rate_hz: f32,
}

/// Rejected payloads, by reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Rejections {
    /// Not a payload of ours.
    pub bad_magic: u64,
    /// Another version of the contract, or flags of one.
    pub foreign_version: u64,
    /// A message that does not belong under this key.
    pub wrong_kind: u64,
    /// Ends early, makes no sense, or has something behind it.
    pub damaged: u64,
    /// Longer than its kind allows.
    pub too_long: u64,
    /// A value out of its range, or not finite.
    pub out_of_range: u64,
    /// Names another camera than its key, or one that the rig lacks.
    pub wrong_camera: u64,
}

/// State of one object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObjectHealth {
    /// The object.
    pub object: ObjectId,
    /// Its state.
    pub state: State,
    /// Poses per second over the last seconds.
    pub rate_hz: f32,
}

impl Rejections {
    /// Counts one rejected payload under its reason.
    pub fn count(&mut self, why: &DecodeError) {
        let counter = match why {
            DecodeError::BadMagic => &mut self.bad_magic,
            DecodeError::ForeignVersion(_) | DecodeError::UnknownFlags(_) => {
                &mut self.foreign_version
            }
            DecodeError::WrongKind { .. } => &mut self.wrong_kind,
            DecodeError::Damaged | DecodeError::TrailingBytes(_) => &mut self.damaged,
            DecodeError::TooLong(_) => &mut self.too_long,
            DecodeError::OutOfRange(_) => &mut self.out_of_range,
        };
        *counter = counter.saturating_add(1);
    }

    /// All of them together.
    #[must_use]
    pub fn total(&self) -> u64 {
        [
            self.bad_magic,
            self.foreign_version,
            self.wrong_kind,
            self.damaged,
            self.too_long,
            self.out_of_range,
            self.wrong_camera,
        ]
        .into_iter()
        .fold(0, u64::saturating_add)
    }
}

impl Message for FusionStatus {
    const KIND: MessageKind = MessageKind::FusionStatus;

    fn check(&self) -> Result<(), OutOfRange> {
        check::name(&self.version, "version")?;
        holds(self.cameras.len() <= MAX_CAMERAS, "cameras")?;
        holds(self.objects.len() <= MAX_OBJECTS, "objects")?;
        for camera in &self.cameras {
            check::time(camera.last_capture_ns, "cameras[].last_capture_ns")?;
            check::amount(f64::from(camera.rate_hz), "cameras[].rate_hz")?;
        }
        for object in &self.objects {
            check::amount(f64::from(object.rate_hz), "objects[].rate_hz")?;
        }
        holds(self.faults.len() <= MAX_FAULTS, "faults")?;
        self.faults.iter().try_for_each(check_fault)?;
        let n_imperfections = self.imperfections.len();
        holds(n_imperfections <= MAX_IMPERFECTIONS, "imperfections")?;
        self.imperfections.iter().try_for_each(check_imperfection)?;
        holds(self.notices.len() <= MAX_NOTICES, "notices")?;
        self.notices.iter().try_for_each(Notice::check)
    }
}

fn check_fault(fault: &Fault) -> Result<(), OutOfRange> {
    match fault {
        Fault::TagSize { ratio, .. } => check::amount(*ratio, "faults[].ratio"),
        Fault::ClockOff { offset_s, .. } => check::finite(&[*offset_s], "faults[].offset_s"),
        Fault::Untimely { age_s, .. } => check::finite(&[*age_s], "faults[].age_s"),
        Fault::HostClockOff { offset_s } => check::finite(&[*offset_s], "faults[].offset_s"),
        Fault::CameraFrozen { still_s, .. } => check::amount(*still_s, "faults[].still_s"),
        Fault::CameraBlind { blind_s, .. } => check::amount(*blind_s, "faults[].blind_s"),
        Fault::ObjectScaled { ratio, .. } | Fault::LensChanged { ratio, .. } => {
            check::amount(*ratio, "faults[].ratio")
        }
        Fault::ObjectContradicted { share, .. } => check::amount(*share, "faults[].share"),
        Fault::CameraMoved { .. }
        | Fault::CamerasDisagree { .. }
        | Fault::TagMisplaced { .. }
        | Fault::TagElsewhere { .. }
        | Fault::DuplicateTag { .. }
        | Fault::LensOff { .. }
        | Fault::CameraTurned { .. }
        | Fault::CamerasExchanged { .. }
        | Fault::TagTurned { .. }
        | Fault::TagsExchanged { .. }
        | Fault::ObjectUnplaced { .. }
        | Fault::ImageSize { .. } => Ok(()),
    }
}

fn check_imperfection(imperfection: &Imperfection) -> Result<(), OutOfRange> {
    const FIELD: &str = "imperfections[]";
    match imperfection {
        Imperfection::CamerasDisagree { apart_m, .. } => check::amount(*apart_m, FIELD),
        Imperfection::TagOff {
            position_m,
            orientation_rad,
            ..
        } => {
            check::amount(*position_m, FIELD)?;
            check::amount(*orientation_rad, FIELD)
        }
        Imperfection::SizeOff { ratio, .. }
        | Imperfection::FocalLengthOff { ratio, .. }
        | Imperfection::ScaleOff { ratio, .. } => check::amount(*ratio, FIELD),
    }
}
