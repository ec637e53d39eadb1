//! The process: bind first (a taken port is said at once), then network and server side by side until asked to stop.

use crate::config::ViewerConfig;
use crate::forwarder::frame_of;
use crate::guard::HostRule;
use crate::hub::Hub;
use crate::last_seconds::LastSeconds;
use crate::message::Message;
use crate::metrics::Metrics;
use crate::network;
use crate::protection::Protection;
use crate::server;
use crate::webhook::Webhook;
use crate::wizard::{self, WizardService};
use crate::zones::ZoneService;
use anyhow::{Context, anyhow};
use sextant_process::{Exit, Shutdown, WithExit, memory, monotonic_ns, now_ns};
use sextant_site_files::{FileError, read_toml};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::ObjectId;
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// The network's thread has hung when it needs longer than this for one iteration; it may wait for answers and for the end of a session.
const LONGEST_TURN_MS: u64 = 10_000;

/// What server and network share.
pub(crate) struct Shared {
    pub(crate) config: ViewerConfig,
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
    pub(crate) webhook: Option<Webhook>,
    pub(crate) started: Instant,
    /// Whether the bridge is connected to the site's network.
    pub(crate) connected: AtomicBool,
    /// When the network's thread last worked, ms after `started`.
    network_turn_ms: AtomicU64,
}

impl Shared {
    fn new(
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
            webhook: webhook.map(|options| Webhook::new(options, config.site.clone())),
            wizard: WizardService::new(folder),
            hosts: HostRule::new(address, &config.host_names),
            config,
            protection,
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

/// Runs a viewer bridge until `shutdown`.
///
/// # Errors
/// [`Exit::Input`] for a wrong file, [`Exit::Unavailable`] when the address or the network can't be had.
pub fn run(config_file: &Path, shutdown: &Shutdown) -> anyhow::Result<()> {
    memory::keep_heap_small();
    let config: ViewerConfig = read_toml(config_file).exit_with(Exit::Input)?;
    let folder = config_file.parent().unwrap_or(Path::new(""));
    let protection = Protection::load(&config, folder)
        .with_context(|| config_file.display().to_string())
        .exit_with(Exit::Input)?;
    if let Some(words) = protection.network.warning(now_ns() / 1_000_000_000) {
        tracing::warn!("{words}");
    }
    let listener = listen(config.listen).exit_with(Exit::Unavailable)?;
    let address = listener.local_addr().context("the address listened on")?;
    let scheme = if protection.tls.is_some() {
        "https"
    } else {
        "http"
    };
    tracing::info!("the page: {scheme}://{}/", for_browsers(address));
    let shared = Shared::new(config, config_file, address, protection).exit_with(Exit::Input)?;
    let shared = Arc::new(shared);
    serve_both(&shared, listener, shutdown)
}

/// Whichever part ends first, be it by a fault, takes the other with it.
fn serve_both(
    shared: &Arc<Shared>,
    listener: TcpListener,
    shutdown: &Shutdown,
) -> anyhow::Result<()> {
    std::thread::scope(|scope| {
        let network = std::thread::Builder::new()
            .name("network".into())
            .spawn_scoped(scope, || {
                let result = network::run(shared, shutdown);
                shutdown.request();
                result
            })?;
        let wizard = Arc::clone(shared);
        std::thread::Builder::new()
            .name("wizard".into())
            .spawn_scoped(scope, move || wizard::run(&wizard, shutdown))?;
        let served = server::run(shared, listener, shutdown);
        shutdown.request();
        let connected = network
            .join()
            .unwrap_or_else(|_| Err(anyhow!("the network thread panicked")));
        served.and(connected)
    })
}

fn listen(address: SocketAddr) -> anyhow::Result<TcpListener> {
    let listener = TcpListener::bind(address)
        .map_err(|cause| anyhow!("cannot listen on {address}: {}", remedy(&cause, address)))?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

fn remedy(cause: &std::io::Error, address: SocketAddr) -> String {
    let port = address.port();
    match cause.kind() {
        ErrorKind::AddrInUse => format!(
            "the port is in use; choose another `listen` in viewer.toml, or end the program that holds it (`ss -ltnp 'sport = :{port}'` names it)"
        ),
        ErrorKind::AddrNotAvailable => {
            "this machine has no such address; `ip address` lists those it has".to_owned()
        }
        ErrorKind::PermissionDenied => {
            format!("port {port} is reserved for the superuser; choose one from 1024 on")
        }
        _ => cause.to_string(),
    }
}

/// The address as a browser on this machine would write it.
fn for_browsers(address: SocketAddr) -> SocketAddr {
    let mut shown = address;
    if address.ip().is_unspecified() {
        shown.set_ip(std::net::Ipv4Addr::LOCALHOST.into());
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_taken_port_is_said_with_a_remedy() {
        let holder = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = holder.local_addr().unwrap();
        let error = listen(address).unwrap_err().to_string();
        assert!(error.contains("in use") && error.contains("viewer.toml"));
    }
}
