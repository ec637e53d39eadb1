//! What a camera's node knows of its site: its lens and the sizes of all tags, and its settings, as the fusion node
//! publishes them. Without them it publishes corners alone, which is all that fusion needs.
//!
//! Sans-I/O: messages, tokens, the state of the link and the time are arguments. Times are ns by a clock that is never
//! set.

use sextant_geometry::Lens;
use sextant_proto::{
    AnyMessage, CameraNotice, CameraSettings, KeyRef, Keys, NodeKind, RigConfig, limits,
};
use sextant_site_mirror::{Rejection, Renewal, SiteMirror};
use sextant_site_model::{CameraId, Rig, TagId};
use sextant_zenoh_bus::{Item, Presence};

/// Least time between two questions for lack of room, ns.
const ASK_PERIOD_NS: u64 = 60_000_000_000;

/// The models, kept up to date.
///
/// Subscribe to [`keys`](Self::keys) and watch [`tokens`](Self::tokens) first, then ask whenever [`asks`](Self::asks)
/// says so, so that nothing falls between.
#[derive(Debug)]
pub struct SiteModels {
    keys: Keys,
    camera: CameraId,
    renewal: Renewal<Item>,
    asked_ns: u64,
    /// Whether an object was refused for lack of room since the last question.
    is_short_of_room: bool,
    lens: Option<(Lens, [u32; 2])>,
    mirror: SiteMirror,
    notice: Option<CameraNotice>,
    /// What the site wants of the camera.
    settings: CameraSettings,
    are_settings_new: bool,
}

impl SiteModels {
    /// Those of a camera whose settings are these so far; nothing else is known.
    #[must_use]
    pub fn new(keys: Keys, settings: CameraSettings) -> Self {
        Self {
            keys,
            camera: settings.camera.clone(),
            renewal: Renewal::default(),
            asked_ns: 0,
            is_short_of_room: false,
            lens: None,
            mirror: SiteMirror::default(),
            notice: None,
            settings,
            are_settings_new: false,
        }
    }

    /// What a camera reads of the site's configuration, and may read.
    #[must_use]
    pub fn keys(&self) -> [String; 3] {
        [
            self.keys.config_rig(),
            self.keys.all_config_objects(),
            self.keys.config_camera(&self.camera),
        ]
    }

    /// The tokens of those who keep it.
    #[must_use]
    pub fn tokens(&self) -> String {
        self.keys.all_fusion_alive()
    }

    /// State of the link to the network, whether or not it has changed.
    pub fn link(&mut self, is_linked: bool) {
        self.renewal.link(is_linked);
    }

    /// A token has appeared or is gone.
    pub fn presence(&mut self, change: &Presence) {
        if let Presence::Joined(key) = change
            && let Some(KeyRef::Alive(NodeKind::Fusion, _)) = self.keys.parse(key)
        {
            self.renewal.joined();
        }
    }

    /// Whether to ask for the latest values of all keys now. Also now and then while there is no room: objects that
    /// nobody answers for are forgotten then.
    pub fn asks(&mut self, now_ns: u64) -> bool {
        if self.is_short_of_room && now_ns.saturating_sub(self.asked_ns) >= ASK_PERIOD_NS {
            self.renewal.joined();
        }
        let asks = self.renewal.take_due(now_ns);
        if asks {
            self.asked_ns = now_ns;
            self.is_short_of_room = false;
        }
        asks
    }

    /// The answers. Where they are all, what is not among them does not exist, unless there is none at all, which says
    /// nothing.
    pub fn answered(&mut self, items: &[Item], are_all: bool, now_ns: u64) {
        if are_all && !items.is_empty() {
            self.mirror = SiteMirror::default();
            let own = self.keys.config_camera(&self.camera);
            if items.iter().all(|item| item.key != own) {
                self.take_settings(CameraSettings::none(self.camera.clone()));
            }
        }
        items.iter().for_each(|item| self.take(item, now_ns));
        while let Some(item) = self.renewal.next_held() {
            self.take(&item, now_ns);
        }
    }

    /// A message under one of the keys.
    pub fn handle(&mut self, item: Item, now_ns: u64) {
        if let Some(item) = self.renewal.hold(item) {
            self.take(&item, now_ns);
        }
    }

    fn take(&mut self, item: &Item, now_ns: u64) {
        let Some(key) = self.keys.parse(&item.key) else {
            return;
        };
        let sender = item.sender.as_deref();
        let update = self.mirror.handle(now_ns, &key, sender, item.try_bytes());
        let taken = match update.map(|update| update.message) {
            Ok(AnyMessage::RigConfig(rig)) => self.take_rig(&rig),
            Ok(AnyMessage::CameraSettings(settings)) => {
                self.take_settings(settings);
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

    /// The camera of this node.
    #[must_use]
    pub fn camera(&self) -> &CameraId {
        &self.camera
    }

    /// The lens, if it is known for images of this size.
    #[must_use]
    pub fn lens(&self, width: u16, height: u16) -> Option<&Lens> {
        let (lens, resolution) = self.lens.as_ref()?;
        (*resolution == [u32::from(width), u32::from(height)]).then_some(lens)
    }

    /// Edge of a tag's black square, m.
    #[must_use]
    pub fn size_m(&self, tag: &TagId) -> Option<f64> {
        self.mirror.tag(*tag).map(|(_, size_m)| size_m)
    }

    /// What the site wants of the camera.
    #[must_use]
    pub fn settings(&self) -> &CameraSettings {
        &self.settings
    }

    /// The settings, once after each time that they came.
    pub fn poll_settings(&mut self) -> Option<&CameraSettings> {
        std::mem::take(&mut self.are_settings_new).then_some(&self.settings)
    }

    /// What is wrong with the models.
    #[must_use]
    pub fn notice(&self) -> Option<&CameraNotice> {
        self.notice.as_ref()
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

    fn take_settings(&mut self, settings: CameraSettings) {
        self.settings = settings;
        self.are_settings_new = true;
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
