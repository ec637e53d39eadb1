//! `sextant demo`: a whole site in one command, without hardware, whose files have the errors of a real site.
//!
//! Simulated cameras render images of moving tagged objects. Everything else is real: shared memory, detector,
//! network, fusion and page run in the processes of a real site. The parent is the site's router, knows the simulator's
//! truth, and reports the true errors of the estimates.

pub mod browser;
mod processes;
mod readiness;
mod site_folder;
mod terminal;
mod watch;

use crate::seconds;
use crate::simulate::Demonstration;
use anyhow::{Context, bail};
use clap::Args;
use processes::Processes;
use serde::Serialize;
use sextant_evaluation::live::{LatencySummary, ObjectSummary};
use sextant_process::{Exit, Failure, Shutdown, WithExit};
use sextant_proto::{Keys, SiteId};
use sextant_zenoh_bus::{Bus, BusError, BusOptions, Security};
use site_folder::{Addresses, SiteFolder};
use std::ffi::OsString;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::time::Duration;
use watch::Watch;

/// Port of the router, which is also the other commands' default.
const DEFAULT_ROUTER: &str = "tcp/127.0.0.1:7447";
/// Used when another site has that port.
const ANY_ROUTER: &str = "tcp/127.0.0.1:0";
/// Attempts to find a port, since a free one may be taken before it is used.
const ROUTER_TRIES: usize = 3;

/// Arguments of `sextant demo`.
#[derive(Args, Debug)]
pub struct DemoArguments {
    #[command(flatten)]
    site: Demonstration,
    /// Duration in seconds; without it the demo runs until Ctrl-C.
    #[arg(long, value_name = "SECONDS", value_parser = seconds::parse)]
    duration: Option<Duration>,
    /// Don't open a browser.
    #[arg(long)]
    no_browser: bool,
    /// Port of the web page on this machine.
    #[arg(long, default_value_t = 8600)]
    port: u16,
    /// Record the demo into this file from its first image on, so that `sextant replay` gives the very poses.
    #[arg(long, value_name = "FILE.mcap")]
    record: Option<PathBuf>,
    /// Record images as well.
    #[arg(long, requires = "record")]
    images: bool,
    /// Also serve Foxglove and Lichtblick at ws://127.0.0.1:8765.
    #[arg(long)]
    foxglove: bool,
    /// Name of the demo's site, which is part of every key on the network.
    #[arg(long = "site", default_value = "demo", value_name = "NAME")]
    name: SiteId,
}

impl DemoArguments {
    /// Arguments by which this program's tools find the site.
    fn site_arguments(&self, router: &str) -> Vec<OsString> {
        let site = self.name.to_string();
        let site = ["--site", &site, "--connect", router];
        site.map(OsString::from).into()
    }

    /// Arguments of `sextant record`, if it is wanted.
    fn recorder(&self, router: &str, folder: &SiteFolder) -> Option<Vec<OsString>> {
        let file = self.record.as_ref()?;
        let mut arguments = self.site_arguments(router);
        arguments.push(file.into());
        if let Some(camera) = folder.cameras().first().filter(|_| self.images) {
            arguments.push("--camera-config".into());
            arguments.push(folder.camera_config(camera).into());
        }
        Some(arguments)
    }
}

/// Final result of a demo.
#[derive(Debug, Serialize)]
pub struct Summary {
    cameras: Vec<watch::CameraSummary>,
    objects: Vec<ObjectSummary>,
    latency_ms: LatencySummary,
}

/// Runs the demo until its duration is over, Ctrl-C, or the death of a child.
///
/// # Errors
/// [`Exit::Unavailable`] for a port in use, [`Exit::Fault`] when a child dies.
pub fn run(arguments: &DemoArguments, format: crate::output::Format) -> anyhow::Result<()> {
    let shutdown = Shutdown::install()?;
    let page = free_page_address(arguments.port)?;
    let scenario = arguments.site.scenario();
    let bus = open_router(&shutdown)?;
    let router = bus
        .endpoints()
        .first()
        .cloned()
        .context("the router listens nowhere")?;
    let folder = SiteFolder::create(
        &scenario,
        &Addresses {
            site: &arguments.name,
            router: &router,
            page,
        },
    )?;
    let recorder = arguments.recorder(&router, &folder);
    let mut processes = Processes::start(&folder, recorder.as_deref())?;
    if arguments.foxglove {
        processes.start_foxglove(&arguments.site_arguments(&router))?;
    }
    let keys = Keys::for_site(arguments.name.clone());
    let terminal = terminal::Terminal::new(format);

    readiness::wait(&bus, &keys, folder.cameras(), &mut processes, &shutdown)?;
    if !shutdown.is_requested() {
        let url = format!("http://{page}");
        let opened = !arguments.no_browser && browser::open(&url);
        terminal.ready(&url, opened, &router, &processes.ids());
        if let Some(errors) = arguments.site.imperfections() {
            terminal.imperfect(errors);
        }
    }
    let mut watch = Watch::start(&bus, &keys, &scenario, &terminal)?;
    let outcome = watch.until_end(arguments.duration, &mut processes, &shutdown);
    let killed = processes.stop();
    let summary = watch.finish(&folder);
    drop(folder);
    bus.close();
    outcome?;
    terminal.summary(&summary)?;
    if !killed.is_empty() {
        bail!("had to be killed: {}", killed.join(", "));
    }
    Ok(())
}

/// Address of the page, if it is free.
pub fn free_page_address(port: u16) -> anyhow::Result<SocketAddr> {
    let address = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
    let listener = TcpListener::bind(address)
        .with_context(|| {
            format!("port {port} of the page can't be had: choose another with --port")
        })
        .exit_with(Exit::Unavailable)?;
    Ok(listener.local_addr()?)
}

/// Starts the router on its usual port, or on another one if that is taken.
pub fn open_router(shutdown: &Shutdown) -> anyhow::Result<Bus> {
    let open = |endpoint| {
        let stop = || shutdown.is_requested();
        Bus::open_unless(
            &BusOptions::router_on(endpoint),
            &Security::default(),
            &stop,
        )
    };
    let endpoints =
        std::iter::once(DEFAULT_ROUTER).chain(std::iter::repeat_n(ANY_ROUTER, ROUTER_TRIES));
    let mut failure = None;
    for endpoint in endpoints {
        match open(endpoint) {
            Ok(bus) => return Ok(bus),
            Err(cause @ (BusError::InUse { .. } | BusError::Open(_))) => failure = Some(cause),
            Err(cause) => return Err(Failure::new(Exit::Unavailable, cause).into()),
        }
    }
    Err(failure.map_or_else(
        || anyhow::anyhow!("no port was tried"),
        |cause| Failure::new(Exit::Unavailable, cause).into(),
    ))
}
