//! The network and the files around [`SiteModels`].

use sextant_geometry::Lens;
use sextant_process::monotonic_ns;
use sextant_proto::{CameraControls, CameraNotice, CameraSettings, Keys, SettingsOutcome, limits};
use sextant_site_model::{CameraId, TagId};
use sextant_zenoh_bus::{AliveWatch, Bus, BusError, DropRule, Item, Question, Subscription};
use std::time::Duration;

use crate::config::CameraNodeConfig;
use crate::settings_files::SettingsFiles;
use crate::site_models::SiteModels;

/// How long to wait for the models of a fusion node that is there.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(500);
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
pub(super) struct SubscribedModels {
    site: SiteModels,
    subscriptions: Vec<Subscription>,
    tokens: AliveWatch,
    /// What is asked for, until the last answer.
    questions: Vec<Question>,
    answers: Vec<Item>,
    are_all: bool,
    /// Where the capturing part finds what the site wants of the camera.
    files: SettingsFiles,
}

impl SubscribedModels {
    pub(super) fn watch(
        bus: &Bus,
        keys: &Keys,
        config: &CameraNodeConfig,
        files: SettingsFiles,
    ) -> Result<Self, BusError> {
        let none = || CameraSettings::none(config.camera.clone());
        let site = SiteModels::new(keys.clone(), files.settings().unwrap_or_else(none));
        let subscribe =
            |key: String| bus.subscribe(&key, QUEUE, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES);
        let subscriptions = site.keys().map(subscribe);
        let mut models = Self {
            subscriptions: subscriptions.into_iter().collect::<Result<_, _>>()?,
            tokens: bus.watch_alive(&site.tokens())?,
            questions: Vec::new(),
            answers: Vec::new(),
            are_all: true,
            site,
            files,
        };
        models.update(bus);
        Ok(models)
    }

    /// Takes in what has changed.
    pub(super) fn update(&mut self, bus: &Bus) {
        self.site.link(bus.is_connected());
        while let Some(change) = self.tokens.try_recv() {
            self.site.presence(&change);
        }
        self.take_answers();
        for subscription in &self.subscriptions {
            while let Some(item) = subscription.try_recv() {
                self.site.handle(item, monotonic_ns());
            }
        }
        if self.site.asks(monotonic_ns()) {
            self.ask(bus);
        }
        if let Some(settings) = self.site.poll_settings()
            && let Err(cause) = self.files.write_settings(settings)
        {
            tracing::warn!(%cause, "the site's settings of this camera do not reach its capturing part");
        }
    }

    fn ask(&mut self, bus: &Bus) {
        let ask = |key: String| bus.ask_others(&key, limits::MAX_PAYLOAD_BYTES, ANSWER_TIMEOUT);
        match self.site.keys().into_iter().map(ask).collect() {
            Ok(questions) => {
                self.questions = questions;
                self.are_all = true;
            }
            Err(cause) => {
                tracing::warn!(%cause, "the site's models can't be asked for");
                self.site.answered(&[], false, monotonic_ns());
            }
        }
    }

    fn take_answers(&mut self) {
        if self.questions.is_empty() {
            return;
        }
        let (answers, are_all) = (&mut self.answers, &mut self.are_all);
        self.questions.retain(|question| match question.poll() {
            Some(items) => {
                answers.extend(items);
                *are_all &= !question.is_partial();
                false
            }
            None => true,
        });
        if self.questions.is_empty() {
            let items = std::mem::take(&mut self.answers);
            self.site.answered(&items, self.are_all, monotonic_ns());
        }
    }

    /// The camera of this node.
    pub(super) fn camera(&self) -> &CameraId {
        self.site.camera()
    }

    /// The lens, if it is known for images of this size.
    pub(super) fn lens(&self, width: u16, height: u16) -> Option<&Lens> {
        self.site.lens(width, height)
    }

    /// Edge of a tag's black square, m.
    pub(super) fn size_m(&self, tag: &TagId) -> Option<f64> {
        self.site.size_m(tag)
    }

    /// What the status says of the site.
    pub(super) fn state(&self) -> SiteState<'_> {
        let (controls, wanted) = (self.files.controls(), self.site.settings().values());
        SiteState {
            notice: self.site.notice(),
            controls: match controls.wanted() == wanted {
                true => controls,
                false => controls.wanting(wanted, SettingsOutcome::Pending),
            },
        }
    }
}
