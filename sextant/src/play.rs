//! `sextant play`: a recording as a site of its own, at the pace at which it happened: on the page, and on the network
//! for every other tool.

mod previews;
mod publishers;

use crate::demo::{browser, free_page_address, open_router};
use crate::output::{Format, print_line};
use crate::{seconds, words};
use anyhow::{Context, anyhow, bail};
use clap::Args;
use node_viewer_bridge::ViewerConfig;
use publishers::Publishers;
use serde_json::json;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_process::{Exit, Shutdown, WithExit};
use sextant_proto::{KeyRef, Keys, NodeId, NodeKind, SiteId};
use sextant_recordings::mcap::reader::{McapReader, RecordedMessage};
use sextant_site_files::write_toml;
use sextant_zenoh_bus::{Bus, BusOptions, Presence, SecurityOptions};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest wait for the page.
const PATIENCE: Duration = Duration::from_secs(30);
/// Between the end of the recording and its repetition.
const PAUSE: Duration = Duration::from_secs(1);

/// Arguments of `sextant play`.
#[derive(Args, Debug)]
#[command(
    after_help = "The site of the recording runs on this machine only, on a router of its own. The page shows it, and
its time line goes back through the last ten minutes; so do `sextant echo`, `foxglove`, `ros2` and the other tools with
--connect and --site. Recorded images and previews are shown, of images five a second. After the end the page stays
until Ctrl-C.

With --json, a line at the start, {\"event\":\"playing\",\"page\",\"connect\",\"site\"}, and one at the end of the
recording, with --repeat at each end, {\"event\":\"played\",\"messages\",\"skipped\"}, counted since the start. Stop
with Ctrl-C."
)]
pub struct PlayArguments {
    /// A recording of `sextant record`.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Times as fast as it happened.
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = factor)]
    speed: f64,
    /// Begin this many seconds after the start of the recording.
    #[arg(long, value_name = "SECONDS", value_parser = seconds::parse)]
    from: Option<Duration>,
    /// Play it again and again.
    #[arg(long)]
    repeat: bool,
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
    let recording = Recording::open(arguments)?;
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
            keys: Keys::for_site(recording.site.clone()),
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
        https: false,
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

/// A file, read up to the message with which it is played.
struct Recording {
    reader: McapReader<BufReader<File>>,
    /// The last of each key before that describe the state of the site.
    state: BTreeMap<String, RecordedMessage>,
    first: RecordedMessage,
    site: SiteId,
}

impl Recording {
    fn open(arguments: &PlayArguments) -> anyhow::Result<Self> {
        let mut reader = McapReader::open(&arguments.file).exit_with(Exit::Input)?;
        let first = reader.next_message().exit_with(Exit::Input)?;
        let site = reader.info().and_then(|info| SiteId::new(&info.site).ok());
        let (Some(first), Some(site)) = (first, site) else {
            return Err(reader.emptiness()).exit_with(Exit::Input);
        };
        let mut recording = Self {
            reader,
            state: BTreeMap::new(),
            first,
            site,
        };
        if let Some(from) = arguments.from {
            let sought = recording.seek(from);
            let sought = sought.with_context(|| arguments.file.display().to_string());
            sought.exit_with(Exit::Input)?;
        }
        Ok(recording)
    }

    /// Reads up to the first message that arrived so long after the start.
    fn seek(&mut self, from: Duration) -> anyhow::Result<()> {
        let keys = Keys::for_site(self.site.clone());
        let start_ns = self.first.arrival_ns;
        let since_start = |message: &RecordedMessage| {
            Duration::from_nanos(message.arrival_ns.saturating_sub(start_ns))
        };
        while since_start(&self.first) < from {
            let Some(next) = self.reader.next_message()? else {
                let length_s = since_start(&self.first).as_secs_f64();
                bail!("the recording ends after {length_s:.1} s; give a smaller --from");
            };
            let former = std::mem::replace(&mut self.first, next);
            let key = &former.channel.topic;
            if is_state(&keys, key) {
                self.state.insert(key.clone(), former);
            }
        }
        Ok(())
    }
}

/// Whether a message under this key holds until the next one.
fn is_state(keys: &Keys, key: &str) -> bool {
    matches!(
        keys.parse(key),
        Some(
            KeyRef::ConfigRig
                | KeyRef::ConfigObject(_)
                | KeyRef::CameraStatus(_)
                | KeyRef::FusionStatus(_)
                | KeyRef::Clocks(_)
        )
    )
}

/// How a pass through the recording ended.
#[derive(PartialEq, Eq)]
enum Pass {
    Whole,
    Interrupted,
}

struct Player<'a> {
    bus: &'a Bus,
    keys: Keys,
    shutdown: &'a Shutdown,
    format: Format,
}

impl Player<'_> {
    /// Plays the recording, with `--repeat` again and again, and waits for a signal.
    fn play(
        &self,
        mut recording: Recording,
        arguments: &PlayArguments,
        page: SocketAddr,
    ) -> anyhow::Result<()> {
        self.wait_for_page()?;
        let url = format!("http://{page}");
        let is_opened = !arguments.no_browser && browser::open(&url);
        self.say_begin(&url, is_opened)?;
        let mut publishers = Publishers::new(self.bus, self.keys.clone());
        while self.play_once(recording, &mut publishers, arguments.speed)? == Pass::Whole {
            self.say_end(&publishers, arguments.repeat)?;
            if !arguments.repeat {
                while !self.shutdown.wait(PAUSE) {}
                break;
            }
            if self.shutdown.wait(PAUSE) {
                break;
            }
            recording = Recording::open(arguments)?;
        }
        Ok(())
    }

    fn play_once(
        &self,
        recording: Recording,
        publishers: &mut Publishers<'_>,
        speed: f64,
    ) -> anyhow::Result<Pass> {
        let Recording {
            mut reader,
            state,
            first,
            ..
        } = recording;
        for message in state.values() {
            publishers.put(message)?;
        }
        let (begun, first_ns) = (Instant::now(), first.arrival_ns);
        let mut next = Some(first);
        while let Some(message) = next {
            let passed_ns = message.arrival_ns.saturating_sub(first_ns);
            let due = Duration::from_nanos(passed_ns).div_f64(speed);
            if self.wait_until(begun, due) {
                return Ok(Pass::Interrupted);
            }
            publishers.put(&message)?;
            next = reader.next_message()?;
        }
        Ok(Pass::Whole)
    }

    /// Returns once the bridge is on the network, so that it misses nothing.
    fn wait_for_page(&self) -> anyhow::Result<()> {
        let alive = self.bus.watch_alive(&self.keys.all_alive())?;
        let deadline = Instant::now() + PATIENCE;
        while !self.shutdown.wait(SHUTDOWN_POLL) {
            while let Some(Presence::Joined(key)) = alive.try_recv() {
                if let Some(KeyRef::Alive(NodeKind::Viewer, _)) = self.keys.parse(&key) {
                    return Ok(());
                }
            }
            if Instant::now() > deadline {
                bail!("the page is not ready after {} s", PATIENCE.as_secs());
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

    fn say_end(&self, publishers: &Publishers<'_>, is_repeated: bool) -> std::io::Result<()> {
        let (messages, skipped) = (publishers.published, publishers.skipped);
        match self.format {
            Format::Json => print_line(
                &json!({ "event": "played", "messages": messages, "skipped": skipped }).to_string(),
            ),
            Format::Text => {
                let then = if is_repeated {
                    "it is repeated until Ctrl-C"
                } else {
                    "Ctrl-C ends the page"
                };
                eprintln!(
                    "the recording is over: {} published, {skipped} skipped; {then}",
                    words::count(messages as usize, "message")
                );
                Ok(())
            }
        }
    }
}
