//! What the detecting part knows of the site: its camera's lens and the sizes of all tags, as the fusion node publishes
//! them. Without them it publishes corners alone, which is all that fusion needs.

use std::time::{Duration, Instant};

use sextant_geometry::Lens;
use sextant_process::monotonic_ns;
use sextant_proto::{
    AnyMessage, CameraControls, CameraNotice, CameraSettings, Keys, RigConfig, SettingsOutcome,
    limits,
};
use sextant_site_mirror::{Rejection, SiteMirror};
use sextant_site_model::{CameraId, Rig, TagId};
use sextant_zenoh_bus::{Bus, BusError, DropRule, Item, Subscription};

use crate::config::CameraNodeConfig;
use crate::settings_files::SettingsFiles;

/// How long to wait for the models of a fusion node that is there.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(500);
/// Least time between two queries of all objects for lack of room, since a query delays detection.
const ASK_PERIOD: Duration = Duration::from_secs(60);
/// A rig and more objects than a site has; the oldest gives way, and a later question fetches it again.
const QUEUE: usize = 256;

/// What the site tells this camera.
#[derive(Debug, Default)]
pub(super) struct SiteState<'a> {
    /// What is wrong with its models.
    pub notice: Option<&'a CameraNotice>,
    /// Exposure, gain and rate: wanted and in force.
    pub controls: CameraControls,
}

/// The models, kept up to date.
pub(super) struct Models {
    keys: Keys,
    camera: CameraId,
    subscriptions: Vec<Subscription>,
    was_connected: bool,
    asked: Instant,
    /// Whether an object was refused for lack of room since the last query.
    is_short_of_room: bool,
    lens: Option<(Lens, [u32; 2])>,
    mirror: SiteMirror,
    notice: Option<CameraNotice>,
    /// What the site wants of the camera, which the capturing part finds in a file.
    settings: CameraSettings,
    files: SettingsFiles,
}

impl Models {
    /// Subscribes first and asks then, so that nothing falls between.
    pub(super) fn watch(
        bus: &Bus,
        keys: &Keys,
        config: &CameraNodeConfig,
        files: SettingsFiles,
    ) -> Result<Self, BusError> {
        let subscribe =
            |key: String| bus.subscribe(&key, QUEUE, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES);
        let subscriptions = own_keys(keys, &config.camera).map(subscribe);
        let none = || CameraSettings::none(config.camera.clone());
        let mut models = Self {
            keys: keys.clone(),
            camera: config.camera.clone(),
            subscriptions: subscriptions.into_iter().collect::<Result<_, _>>()?,
            was_connected: false,
            asked: Instant::now(),
            is_short_of_room: false,
            lens: None,
            mirror: SiteMirror::default(),
            notice: None,
            settings: files.settings().unwrap_or_else(none),
            files,
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
        for index in 0..self.subscriptions.len() {
            while let Some(item) = self.subscriptions[index].try_recv() {
                self.take(&item);
            }
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
        self.mirror.tag(*tag).map(|(_, size_m)| size_m)
    }

    /// What the status says of the site.
    pub(super) fn state(&self) -> SiteState<'_> {
        let (controls, wanted) = (self.files.controls(), self.settings.values());
        SiteState {
            notice: self.notice.as_ref(),
            controls: match controls.wanted() == wanted {
                true => controls,
                false => controls.wanting(wanted, SettingsOutcome::Pending),
            },
        }
    }

    fn query(&mut self, bus: &Bus) {
        self.asked = Instant::now();
        self.is_short_of_room = false;
        let keys = own_keys(&self.keys, &self.camera).into_iter();
        let latest = |key: String| bus.latest(&key, limits::MAX_PAYLOAD_BYTES, ANSWER_TIMEOUT);
        match keys.map(latest).collect::<Result<Vec<_>, _>>() {
            Ok(items) => self.take_all(&items.concat()),
            Err(cause) => tracing::warn!(%cause, "the site's models can't be asked for"),
        }
    }

    /// What is not among the answers does not exist; no answer at all says nothing.
    fn take_all(&mut self, items: &[Item]) {
        if items.is_empty() {
            return;
        }
        self.mirror = SiteMirror::default();
        let own = self.keys.config_camera(&self.camera);
        if items.iter().all(|item| item.key != own) {
            self.hand_over(CameraSettings::none(self.camera.clone()));
        }
        items.iter().for_each(|item| self.take(item));
    }

    fn take(&mut self, item: &Item) {
        let Some(key) = self.keys.parse(&item.key) else {
            return;
        };
        let sender = item.sender.as_deref();
        let update = self
            .mirror
            .handle(monotonic_ns(), &key, sender, item.try_bytes());
        let taken = match update.map(|update| update.message) {
            Ok(AnyMessage::RigConfig(rig)) => self.take_rig(&rig),
            Ok(AnyMessage::CameraSettings(settings)) => {
                self.hand_over(settings);
                Ok(())
            }
            Ok(_) => Ok(()),
            Err(Rejection::TooMany(_)) => {
                self.is_short_of_room = true;
                Err(ModelProblem::TooManyTags)
            }
            Err(why) => Err(ModelProblem::refused(why)),
        };
        self.notice = taken
            .err()
            .map(|problem| problem.notice(Keys::below_site(&item.key)));
        if let Some(notice) = &self.notice {
            tracing::warn!("{notice}");
        }
    }

    fn take_rig(&mut self, rig: &RigConfig) -> Result<(), ModelProblem> {
        let rig = Rig::try_from(rig).map_err(ModelProblem::refused)?;
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

    /// Gives settings to the capturing part.
    fn hand_over(&mut self, settings: CameraSettings) {
        if let Err(cause) = self.files.write_settings(&settings) {
            tracing::warn!(%cause, "the site's settings of this camera do not reach its capturing part");
        }
        self.settings = settings;
    }
}

/// What a camera reads of the site's configuration, and may read.
fn own_keys(keys: &Keys, camera: &CameraId) -> [String; 3] {
    [
        keys.config_rig(),
        keys.all_config_objects(),
        keys.config_camera(camera),
    ]
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
