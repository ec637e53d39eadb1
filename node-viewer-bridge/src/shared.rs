//! What the threads of the bridge share: the site as heard, what clients are sent, and the services.

use crate::config::ViewerConfig;
use crate::frame::frame_of;
use crate::guard::HostRule;
use crate::hub::Hub;
use crate::last_seconds::LastSeconds;
use crate::message::Message;
use crate::metrics::Metrics;
use crate::phone_claims::PhoneClaims;
use crate::protection::Protection;
use crate::web_camera::registry::WebCameras;
use crate::webhook::Webhook;
use crate::wizard::WizardService;
use crate::zones::ZoneService;
use sextant_process::monotonic_ns;
use sextant_site_files::FileError;
use sextant_site_mirror::SiteMirror;
use sextant_site_model::ObjectId;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// The network's thread has hung when it needs longer than this for one iteration; it may wait for answers and for the
/// end of a session.
const LONGEST_TURN_MS: u64 = 10_000;

/// What server and network share.
pub(crate) struct Shared {
    pub(crate) config: ViewerConfig,
    /// The address listened on.
    pub(crate) address: SocketAddr,
    pub(crate) hosts: HostRule,
    pub(crate) protection: Protection,
    pub(crate) hub: Hub,
    /// The site as heard; times are of the monotonic clock.
    mirror: Mutex<SiteMirror>,
    pub(crate) metrics: Metrics,
    /// What can be saved as a recording.
    pub(crate) last_seconds: LastSeconds,
    /// The wizards.
    pub(crate) wizard: WizardService,
    pub(crate) zones: ZoneService,
    pub(crate) web_cameras: Arc<WebCameras>,
    pub(crate) phone_claims: PhoneClaims,
    pub(crate) webhook: Option<Webhook>,
    pub(crate) started: Instant,
    /// Whether the bridge is connected to the site's network.
    pub(crate) connected: AtomicBool,
    /// When the network's thread last worked, ms after `started`.
    network_turn_ms: AtomicU64,
}

impl Shared {
    pub(crate) fn new(
        config: ViewerConfig,
        config_file: &Path,
        address: SocketAddr,
        protection: Protection,
    ) -> Result<Self, FileError> {
        let beside = config_file.parent().unwrap_or(Path::new(""));
        let folder = config
            .folder
            .as_ref()
            .map(|folder| whole(&beside.join(folder)));
        let webhook = config.webhook.as_ref();
        let shared = Self {
            zones: ZoneService::open(folder.as_deref())?,
            phone_claims: PhoneClaims::open(folder.as_deref()),
            webhook: webhook.map(|options| Webhook::new(options, config.site.clone())),
            wizard: WizardService::new(folder),
            hosts: HostRule::new(address, &config.host_names),
            address,
            config,
            protection,
            web_cameras: Arc::default(),
            hub: Hub::default(),
            mirror: Mutex::default(),
            metrics: Metrics::default(),
            last_seconds: LastSeconds::default(),
            started: Instant::now(),
            connected: AtomicBool::new(false),
            network_turn_ms: AtomicU64::new(0),
        };
        shared.zones.show(&shared.hub);
        Ok(shared)
    }

    fn elapsed_ms(&self) -> u64 {
        u64::try_from(self.started.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    /// The network's thread works.
    pub(crate) fn note_network_turn(&self) {
        self.network_turn_ms
            .store(self.elapsed_ms(), Ordering::Relaxed);
    }

    /// Whether the network's thread works.
    pub(crate) fn is_network_working(&self) -> bool {
        let last_ms = self.network_turn_ms.load(Ordering::Relaxed);
        self.elapsed_ms().saturating_sub(last_ms) < LONGEST_TURN_MS
    }

    /// The site as heard; held for a moment only, since the network's threads wait for it.
    pub(crate) fn mirror(&self) -> MutexGuard<'_, SiteMirror> {
        // Nothing under the lock panics half way, so a poisoned mirror is a whole one.
        self.mirror.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Forgets what nothing was heard of for long.
    pub(crate) fn expire(&self) {
        let gone = self.mirror().expire(monotonic_ns());
        gone.iter().for_each(|object| self.forget(object));
        self.metrics.keep_known(&self.mirror());
        self.hub.expire(monotonic_ns());
    }

    /// The site has this object and its links no more.
    pub(crate) fn forget(&self, object: &ObjectId) {
        self.zones.forget_object(object, &self.hub);
        for id in self.hub.parts_of(object.as_str()) {
            let farewell = frame_of(&Message::ObjectGone { id: &id });
            self.hub.forget_object(&id, &farewell);
        }
    }

    #[cfg(test)]
    pub(crate) fn for_tests() -> Self {
        let text = "site = \"demo\"\nlisten = \"127.0.0.1:0\"";
        let config: ViewerConfig =
            sextant_site_files::parse_toml(Path::new("viewer.toml"), text, |_| Ok(())).unwrap();
        let address = config.listen;
        let protection = Protection::load(&config, Path::new("")).unwrap();
        Self::new(config, Path::new("viewer.toml"), address, protection).unwrap()
    }
}

/// As people can find it, without the `.` that they may write for "here".
fn whole(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    path.components().collect()
}
