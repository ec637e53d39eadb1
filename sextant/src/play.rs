//! `sextant play`: a recording as a site of its own, at the pace at which it happened: on the page, and on the network for every other tool.

mod publishers;

use crate::demo::{browser, free_page_address, open_router};
use crate::output::{Format, print_line};
use crate::words;
use anyhow::{Context, anyhow};
use clap::Args;
use node_viewer_bridge::ViewerConfig;
use publishers::Publishers;
use serde_json::json;
use sextant_process::{Exit, Failure, Shutdown, WithExit};
use sextant_proto::{KeyRef, Keys, NodeId, NodeKind, SiteId};
use sextant_recordings::mcap::WIRE_ENCODING;
use sextant_recordings::mcap::reader::{McapReader, RecordedMessage};
use sextant_site_files::write_toml;
use sextant_zenoh_bus::{Bus, BusOptions, Presence, SecurityOptions};
use std::fs::File;
use std::io::BufReader;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest wait for the page.
const PATIENCE: Duration = Duration::from_secs(30);
const GLANCE: Duration = Duration::from_millis(50);

/// Arguments of `sextant play`.
#[derive(Args, Debug)]
#[command(
    after_help = "The site of the recording runs on this machine only, on a router of its own. The page shows it, and its time line goes back
through the last ten minutes; so do `sextant echo`, `foxglove`, `ros2` and the other tools with --connect and --site. Previews are shown if they
were recorded. After the end the page stays until Ctrl-C.

With --json, a line at the start, {\"event\":\"playing\",\"page\",\"connect\",\"site\"}, and one at the end of the recording,
{\"event\":\"played\",\"messages\",\"skipped\"}. Stop with Ctrl-C."
)]
pub struct PlayArguments {
    /// A recording of `sextant record`.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Times as fast as it happened.
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = factor)]
    speed: f64,
    /// Don't open a browser.
    #[arg(long)]
    no_browser: bool,
    /// Port of the web page on this machine.
    #[arg(long, default_value_t = 8600)]
    port: u16,
}

fn factor(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(factor) if (0.01..=100.0).contains(&factor) => Ok(factor),
        _ => Err("a speed is a number from 0.01 to 100".to_owned()),
    }
}

/// Runs `sextant play`.
///
/// # Errors
/// [`Exit::Input`] for a file that is no recording, [`Exit::Unavailable`] for a port in use.
pub fn run(arguments: &PlayArguments, format: Format) -> anyhow::Result<()> {
    let recording = Recording::open(&arguments.file)?;
    let shutdown = Shutdown::install()?;
    let page = free_page_address(arguments.port)?;
    let bus = open_router(&shutdown)?;
    let folder = tempfile::tempdir().context("no temporary folder")?;
    let config = folder.path().join("viewer.toml");
    write_viewer_config(&config, &bus, &recording.site, page)?;
    std::thread::scope(|scope| {
        let viewer = std::thread::Builder::new()
            .name("viewer".to_owned())
            .spawn_scoped(scope, || {
                let ended = node_viewer_bridge::run(&config, &shutdown);
                shutdown.request();
                ended
            })?;
        let player = Player {
            bus: &bus,
            keys: Keys::of(recording.site.clone()),
            shutdown: &shutdown,
            format,
        };
        let played = player.play(recording, arguments, page);
        if played.is_err() {
            shutdown.request();
        }
        let viewed = viewer.join().map_err(|_| anyhow!("the bridge panicked"))?;
        played.and(viewed)
    })?;
    bus.close();
    Ok(())
}

fn write_viewer_config(
    file: &Path,
    bus: &Bus,
    site: &SiteId,
    page: SocketAddr,
) -> anyhow::Result<()> {
    let endpoints = bus.endpoints();
    let router = endpoints.first().context("the router listens nowhere")?;
    let config = ViewerConfig {
        site: site.clone(),
        node: NodeId::new("viewer")?,
        listen: page,
        host_names: Vec::new(),
        folder: None,
        webhook: None,
        network: BusOptions::client_of(router),
        security: SecurityOptions::default(),
    };
    Ok(write_toml(file, &config)?)
}

/// A file, up to its first message.
struct Recording {
    reader: McapReader<BufReader<File>>,
    first: RecordedMessage,
    site: SiteId,
}

impl Recording {
    fn open(path: &Path) -> anyhow::Result<Self> {
        let mut reader = McapReader::open(path).exit_with(Exit::Input)?;
        let first = reader.next_message().exit_with(Exit::Input)?;
        let site = reader.info().and_then(|info| SiteId::new(&info.site).ok());
        let (Some(first), Some(site)) = (first, site) else {
            let cause = anyhow!(
                "{}: no recording of a Sextant site, or an empty one; give one made by `sextant record`",
                path.display()
            );
            return Err(Failure::new(Exit::Input, cause).into());
        };
        Ok(Self {
            reader,
            first,
            site,
        })
    }
}

struct Player<'a> {
    bus: &'a Bus,
    keys: Keys,
    shutdown: &'a Shutdown,
    format: Format,
}

impl Player<'_> {
    /// Plays the recording and waits for a signal.
    fn play(
        &self,
        recording: Recording,
        arguments: &PlayArguments,
        page: SocketAddr,
    ) -> anyhow::Result<()> {
        self.wait_for_page()?;
        let url = format!("http://{page}");
        let is_opened = !arguments.no_browser && browser::open(&url);
        self.say_begin(&url, is_opened)?;
        let Recording {
            mut reader, first, ..
        } = recording;
        let mut publishers = Publishers::new(self.bus, self.keys.clone());
        let (begun, first_ns) = (Instant::now(), first.arrival_ns);
        let mut next = Some(first);
        while let Some(message) = next {
            let passed_ns = message.arrival_ns.saturating_sub(first_ns);
            let due = Duration::from_nanos(passed_ns).div_f64(arguments.speed);
            if self.wait_until(begun, due) {
                return Ok(());
            }
            if message.channel.encoding == WIRE_ENCODING {
                publishers.put(&message.channel.topic, &message.data)?;
            }
            next = reader.next_message()?;
        }
        self.say_end(&publishers)?;
        while !self.shutdown.wait(Duration::from_secs(1)) {}
        Ok(())
    }

    /// Returns once the bridge is on the network, so that it misses nothing.
    fn wait_for_page(&self) -> anyhow::Result<()> {
        let alive = self.bus.watch_alive(&self.keys.all_alive())?;
        let deadline = Instant::now() + PATIENCE;
        while !self.shutdown.wait(GLANCE) {
            while let Some(Presence::Joined(key)) = alive.try_recv() {
                if let Some(KeyRef::Alive(NodeKind::Viewer, _)) = self.keys.parse(&key) {
                    return Ok(());
                }
            }
            if Instant::now() > deadline {
                anyhow::bail!("the page is not ready after {} s", PATIENCE.as_secs());
            }
        }
        Ok(())
    }

    /// Whether a signal came before.
    fn wait_until(&self, begun: Instant, due: Duration) -> bool {
        let wait = due.saturating_sub(begun.elapsed());
        if wait.is_zero() {
            self.shutdown.is_requested()
        } else {
            self.shutdown.wait(wait)
        }
    }

    fn say_begin(&self, url: &str, is_opened: bool) -> std::io::Result<()> {
        let endpoints = self.bus.endpoints();
        let (router, site) = (endpoints.first(), self.keys.site());
        match self.format {
            Format::Json => print_line(
                &json!({ "event": "playing", "page": url, "connect": router, "site": site })
                    .to_string(),
            ),
            Format::Text => {
                let opened = if is_opened {
                    " (opened in your browser)"
                } else {
                    ""
                };
                let router = router.map_or("", String::as_str);
                eprintln!(
                    "playing site {site} at {url}{opened}; other tools: --connect {router} --site {site}"
                );
                Ok(())
            }
        }
    }

    fn say_end(&self, publishers: &Publishers<'_>) -> std::io::Result<()> {
        let (messages, skipped) = (publishers.published, publishers.skipped);
        match self.format {
            Format::Json => print_line(
                &json!({ "event": "played", "messages": messages, "skipped": skipped }).to_string(),
            ),
            Format::Text => {
                eprintln!(
                    "the recording is over: {} published, {skipped} skipped; Ctrl-C ends the page",
                    words::count(messages as usize, "message")
                );
                Ok(())
            }
        }
    }
}
