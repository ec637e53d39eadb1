//! What the detecting part knows of the site: its camera's lens and the sizes of all tags, as the fusion node publishes
//! them. Without them it publishes corners alone, which is all that fusion needs.

use std::time::{Duration, Instant};

use sextant_estimator::{CameraId, ObjectModel, Rig, TagId};
use sextant_geometry::Lens;
use sextant_proto::{CameraNotice, KeyRef, Keys, ObjectConfig, RigConfig, limits};
use sextant_zenoh_bus::{Bus, BusError, DropRule, Item, Subscription};

use super::sizes::{Full, Sizes};

/// How long to wait for the models of a fusion node that is there.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(500);
/// Least time between two queries of all objects for lack of room, since a query delays detection.
const ASK_PERIOD: Duration = Duration::from_secs(60);
/// A rig and more objects than a site has; the oldest gives way, and a later question fetches it again.
const QUEUE: usize = 256;

/// The models, kept up to date.
pub(super) struct Models {
    keys: Keys,
    camera: CameraId,
    subscription: Subscription,
    was_connected: bool,
    asked: Instant,
    /// Whether an object was refused for lack of room since the last query.
    is_short_of_room: bool,
    lens: Option<(Lens, [u32; 2])>,
    sizes: Sizes,
    notice: Option<CameraNotice>,
}

impl Models {
    /// Subscribes first and asks then, so that nothing falls between.
    pub(super) fn watch(bus: &Bus, keys: &Keys, camera: &CameraId) -> Result<Self, BusError> {
        let subscription = bus.subscribe(
            &keys.all_config(),
            QUEUE,
            DropRule::Oldest,
            limits::MAX_PAYLOAD_BYTES,
        )?;
        let mut models = Self {
            keys: keys.clone(),
            camera: camera.clone(),
            subscription,
            was_connected: false,
            asked: Instant::now(),
            is_short_of_room: false,
            lens: None,
            sizes: Sizes::default(),
            notice: None,
        };
        models.update(bus);
        Ok(models)
    }

    /// Takes in what has changed. After a lost connection everything is asked for again, and so it is now and then while there
    /// is no room: objects that nobody answers for are forgotten then.
    pub(super) fn update(&mut self, bus: &Bus) {
        let is_connected = bus.is_connected();
        let is_back = is_connected && !self.was_connected;
        if is_back || self.is_short_of_room && self.asked.elapsed() >= ASK_PERIOD {
            self.query(bus);
        }
        self.was_connected = is_connected;
        while let Some(item) = self.subscription.try_recv() {
            self.take(&item);
        }
    }

    /// The camera of this node.
    pub(super) fn camera(&self) -> &CameraId {
        &self.camera
    }

    /// The lens, if it is known for images of this size.
    pub(super) fn lens(&self, width: u16, height: u16) -> Option<&Lens> {
        let (lens, resolution) = self.lens.as_ref()?;
        (*resolution == [u32::from(width), u32::from(height)]).then_some(lens)
    }

    /// Edge of a tag's black square in metres.
    pub(super) fn size_m(&self, tag: &TagId) -> Option<f64> {
        self.sizes.size_m(tag)
    }

    /// What a person should know about the models.
    pub(super) fn notice(&self) -> Option<&CameraNotice> {
        self.notice.as_ref()
    }

    fn query(&mut self, bus: &Bus) {
        self.asked = Instant::now();
        self.is_short_of_room = false;
        match bus.latest(
            &self.keys.all_config(),
            limits::MAX_PAYLOAD_BYTES,
            ANSWER_TIMEOUT,
        ) {
            Ok(items) if items.is_empty() => {}
            Ok(items) => {
                self.sizes.clear();
                items.iter().for_each(|item| self.take(item));
            }
            Err(cause) => tracing::warn!(%cause, "the site's models can't be asked for"),
        }
    }

    fn take(&mut self, item: &Item) {
        let taken = match self.keys.parse(&item.key) {
            Some(KeyRef::ConfigRig) => self.take_rig(item),
            Some(KeyRef::ConfigObject(object)) => self.take_object(object.as_str(), item),
            _ => return,
        };
        self.notice = taken
            .err()
            .map(|problem| problem.notice(Keys::below_site(&item.key)));
        if let Some(notice) = &self.notice {
            tracing::warn!("{notice}");
        }
    }

    fn take_rig(&mut self, item: &Item) -> Result<(), ModelProblem> {
        let message: RigConfig = item.decode().map_err(ModelProblem::refused)?;
        let rig = Rig::try_from(&message).map_err(ModelProblem::refused)?;
        self.lens = rig
            .cameras()
            .iter()
            .find(|camera| camera.id == self.camera)
            .map(|camera| (camera.lens, camera.resolution));
        self.lens
            .is_some()
            .then_some(())
            .ok_or(ModelProblem::NotInRig)
    }

    fn take_object(&mut self, object: &str, item: &Item) -> Result<(), ModelProblem> {
        let message: ObjectConfig = item.decode().map_err(ModelProblem::refused)?;
        if message.is_removal() {
            self.sizes.remove(object);
            return Ok(());
        }
        let model = ObjectModel::try_from(&message).map_err(ModelProblem::refused)?;
        self.sizes.take(object, &model).map_err(|Full| {
            self.is_short_of_room = true;
            ModelProblem::TooManyTags
        })
    }
}

/// Why a model of the site is of no use here.
enum ModelProblem {
    /// It is damaged or makes no sense.
    Refused(String),
    NotInRig,
    TooManyTags,
}

impl ModelProblem {
    fn refused(cause: impl std::fmt::Display) -> Self {
        Self::Refused(limits::clipped(
            &cause.to_string(),
            limits::MAX_DETAIL_BYTES,
        ))
    }

    fn notice(self, key: &str) -> CameraNotice {
        let key = limits::clipped(key, limits::MAX_DETAIL_BYTES);
        match self {
            Self::Refused(detail) => CameraNotice::ModelRefused { key, detail },
            Self::NotInRig => CameraNotice::NotInRig,
            Self::TooManyTags => CameraNotice::TooManyTags { key },
        }
    }
}
