//! `sextant record`: what happens at a site, in one MCAP file.

mod images;
mod inbox;
mod progress;

use crate::output::{Format, print_line};
use crate::output_file::OutputFile;
use crate::seconds;
use crate::site::{SiteArguments, report_router};
use anyhow::Context;
use clap::Args;
use images::ImageReaders;
use inbox::{Content, Entry, Inbox, inbox};
use node_camera::CameraNodeConfig;
use node_viewer_bridge::download_last_seconds;
use progress::{Figures, ProgressLine};
use serde_json::json;
use sextant_gateways::site::{RouterWatch, SiteSession, is_request};
use sextant_iceoryx_images::IceoryxOptions;
use sextant_process::host::host_name;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_process::{Exit, Failure, WithExit, now_ns};
use sextant_proto::{CameraStatus, KeyRef, decode, limits};
use sextant_recordings::mcap::RecordingInfo;
use sextant_recordings::mcap::writer::McapWriter;
use sextant_site_files::read_toml;
use sextant_site_model::{CameraId, ObjectId};
use sextant_zenoh_bus::{CallbackSubscription, Item};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Chunks are completed this often: what a kill may cost.
const FLUSH_PERIOD: Duration = Duration::from_millis(500);
/// Time for the first image, where images are asked for.
const IMAGES_WAIT: Duration = Duration::from_secs(5);
/// Timeout of queries for what is kept.
const ANSWER: Duration = Duration::from_millis(800);

/// Arguments of `sextant record`.
#[derive(Args, Debug)]
#[command(
    after_help = "The file holds observations, poses, rig, objects, statuses, clocks, truth of simulations, and what the
fusion node took in, with its times, so that `sextant replay` gives the poses that were published, bit for bit, if the
recording begins before the node's first image. Begun later, it gives the same poses at each replay, which approach
those published live within seconds. The file is complete up to the last half second at any time, also after kill -9. It
opens in Foxglove, Lichtblick and Rerun.

--images records the images of cameras on this host from shared memory, lossless, as PNG; run it as the user who runs
the camera node. Where none has come after 5 s, the command ends with exit code 4. Images of cameras on other hosts do
not cross the network; of these, --images records the previews (JPEG, 5 a second). To record their images, run `sextant
record --images` on each host: all files are by the same clocks.

With --json, one line when the recording has begun, {\"event\":\"recording\",\"file\"}, and one at the end:
{\"event\":\"recorded\",\"file\",\"seconds\",\"messages\",\"images\",\"bytes\",\"dropped\",\"missed_images\"}; of --last
one line, {\"event\":\"saved\",\"file\",\"seconds\",\"bytes\"}. Stop with Ctrl-C."
)]
pub struct RecordArguments {
    /// The file to write.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Save the last seconds instead, at most 30, which the viewer bridge keeps: without images.
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=30),
          conflicts_with_all = ["images", "camera_config", "duration", "objects"])]
    last: Option<u64>,
    /// Page of the viewer bridge, for --last.
    #[arg(long, value_name = "URL", default_value = "http://127.0.0.1:8600")]
    page: String,
    /// Token of the page, where it wants one.
    #[arg(
        long,
        env = "SEXTANT_PAGE_TOKEN",
        hide_env_values = true,
        value_name = "TOKEN"
    )]
    page_token: Option<String>,
    /// Record images as well.
    #[arg(long)]
    images: bool,
    /// A camera.toml of this host whose section shared_memory names another place of the images than the default;
    /// implies --images.
    #[arg(long, value_name = "FILE")]
    camera_config: Option<PathBuf>,
    /// End after this many seconds.
    #[arg(long, value_name = "SECONDS", value_parser = seconds::parse)]
    duration: Option<Duration>,
    /// Record the poses of this object only; may be repeated. All else is recorded, so that a replay is unaffected.
    #[arg(long = "object", value_name = "ID")]
    objects: Vec<ObjectId>,
    /// Replace the file if it exists.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    site: SiteArguments,
}

/// Runs `sextant record`.
///
/// # Errors
/// [`Exit::Input`] for a file that exists, [`Exit::Unavailable`] without a site, and what the disk refuses.
pub fn run(arguments: &RecordArguments, format: Format) -> anyhow::Result<()> {
    if let Some(seconds) = arguments.last {
        return save_last(arguments, seconds, format);
    }
    let place = match &arguments.camera_config {
        Some(file) => {
            let config: CameraNodeConfig = read_toml(file).exit_with(Exit::Input)?;
            Some(config.shared_memory)
        }
        None => arguments.images.then(IceoryxOptions::default),
    };
    let site = arguments.site.open()?;
    let file = OutputFile::create(&arguments.file, arguments.force)?;
    let recorded =
        Recorder::begin(arguments, place, &site, file, format)?.work(arguments.duration)?;
    site.bus.close();
    match format {
        Format::Json => print_line(&serde_json::to_string(&recorded)?)?,
        Format::Text => eprintln!("{}", recorded.text()),
    }
    Ok(())
}

/// What has happened already, from the viewer bridge.
fn save_last(arguments: &RecordArguments, seconds: u64, format: Format) -> anyhow::Result<()> {
    let (page, token) = (&arguments.page, arguments.page_token.as_deref());
    let recording = download_last_seconds(page, token, seconds)?;
    let mut output = OutputFile::create(&arguments.file, arguments.force)?;
    let written = output.writer().and_then(|mut file| {
        file.write_all(&recording)?;
        output.keep()
    });
    let (path, bytes) = (arguments.file.display().to_string(), recording.len());
    written.with_context(|| format!("{path}: cannot be written"))?;
    match format {
        Format::Json => {
            let line =
                json!({ "event": "saved", "file": path, "seconds": seconds, "bytes": bytes });
            print_line(&line.to_string())?;
        }
        Format::Text => eprintln!("{path}: the last {seconds} s, {bytes} bytes"),
    }
    Ok(())
}

/// A file that counts its bytes.
struct CountedFile {
    file: File,
    written: Arc<AtomicU64>,
}

impl Write for CountedFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let n_bytes = self.file.write(bytes)?;
        self.written.fetch_add(n_bytes as u64, Ordering::Relaxed);
        Ok(n_bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

struct Recorder<'a> {
    site: &'a SiteSession,
    file: PathBuf,
    output: OutputFile,
    writer: McapWriter<BufWriter<CountedFile>>,
    written: Arc<AtomicU64>,
    inbox: Arc<Inbox>,
    images: Option<ImageReaders>,
    /// Previews of cameras of other hosts.
    previews: BTreeMap<CameraId, CallbackSubscription>,
    subscriptions: Vec<CallbackSubscription>,
    progress: ProgressLine,
    begun: Instant,
}

impl<'a> Recorder<'a> {
    fn begin(
        arguments: &RecordArguments,
        place: Option<IceoryxOptions>,
        site: &'a SiteSession,
        output: OutputFile,
        format: Format,
    ) -> anyhow::Result<Self> {
        let inbox = Arc::new(inbox());
        let info = RecordingInfo {
            site: site.keys.site().to_string(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        let written = Arc::<AtomicU64>::default();
        let file = CountedFile {
            file: output.writer()?,
            written: Arc::clone(&written),
        };
        let writer = McapWriter::begin(BufWriter::new(file), &arguments.file, &info)?;
        let mut recorder = Self {
            site,
            file: arguments.file.clone(),
            output,
            writer,
            written,
            images: place.map(|place| ImageReaders::new(place, Arc::clone(&inbox))),
            previews: BTreeMap::new(),
            subscriptions: subscriptions(site, &inbox, &arguments.objects)?,
            inbox,
            progress: ProgressLine::new(format),
            begun: Instant::now(),
        };
        recorder.ask_for_kept()?;
        recorder.progress.begin(&recorder.file)?;
        Ok(recorder)
    }

    /// Messages that were published before this program came.
    fn ask_for_kept(&mut self) -> anyhow::Result<()> {
        let (bus, everything) = (&self.site.bus, self.site.keys.everything());
        let items = bus.latest(&everything, limits::MAX_PAYLOAD_BYTES, ANSWER)?;
        // Fusion nodes also answer with their models under keys that are for one another, `fusion/<node>/models/**`.
        let keys = &self.site.keys;
        let kept = items
            .into_iter()
            .filter(|item| keys.parse(&item.key).is_some());
        kept.for_each(|item| push(&self.inbox, item));
        Ok(())
    }

    fn work(mut self, duration: Option<Duration>) -> anyhow::Result<Figures> {
        let mut router = RouterWatch::default();
        let mut flush_due = Instant::now() + FLUSH_PERIOD;
        let is_over = |begun: Instant| duration.is_some_and(|duration| begun.elapsed() >= duration);
        let mut is_checked = false;
        while !self.site.shutdown.is_requested() && !is_over(self.begun) {
            if let Some(entry) = self.inbox.pop_timeout(SHUTDOWN_POLL) {
                self.write(entry)?;
            }
            if Instant::now() >= flush_due {
                self.writer.flush()?;
                self.output.keep()?;
                flush_due = Instant::now() + FLUSH_PERIOD;
                report_router(&mut router, &self.site.bus);
                let figures = self.figures();
                self.progress.show(&figures)?;
            }
            if !is_checked && self.begun.elapsed() >= IMAGES_WAIT {
                is_checked = true;
                if self.lacks_images() {
                    break;
                }
            }
        }
        let lack = self.lacks_images().then(|| self.no_images());
        let figures = self.finish()?;
        match lack {
            None => Ok(figures),
            Some(cause) => Err(Failure::new(Exit::Unavailable, cause).into()),
        }
    }

    /// Whether images were asked for, and none has come.
    fn lacks_images(&self) -> bool {
        self.images.is_some() && self.figures().images == 0 && self.previews.is_empty()
    }

    fn no_images(&self) -> anyhow::Error {
        let cameras = self.images.as_ref().map(ImageReaders::cameras);
        let cameras = cameras.unwrap_or_default();
        let cause = match cameras.is_empty() {
            true => "no camera of this host has been heard of".to_owned(),
            false => format!(
                "there are none of {} where cameras usually put them: name the file of a camera \
                 with --camera-config (of a demo: camera-NAME.toml in its folder), and run as the user who runs it",
                cameras.join(", ")
            ),
        };
        anyhow::anyhow!(
            "{}: no image was recorded: {cause}. Everything else is in the file",
            self.file.display()
        )
    }

    fn finish(mut self) -> anyhow::Result<Figures> {
        self.progress.end();
        let ended = self.figures();
        // Nothing arrives any more; what has arrived is written.
        self.images = None;
        self.previews.clear();
        self.subscriptions.clear();
        while let Some(entry) = self.inbox.try_pop() {
            self.write(entry)?;
        }
        let mut figures = Figures {
            images: ended.images,
            missed_images: ended.missed_images,
            ..self.figures()
        };
        let mut file = self.writer.finish()?;
        file.flush()?;
        file.get_ref().file.sync_all()?;
        self.output.keep()?;
        figures.bytes = self.written.load(Ordering::Relaxed);
        Ok(figures)
    }

    fn figures(&self) -> Figures {
        let counts = self.images.as_ref().map(ImageReaders::counts);
        let count = |of: fn(&images::ImageCounts) -> &AtomicU64| {
            counts.map_or(0, |counts| of(counts).load(Ordering::Relaxed))
        };
        Figures {
            event: "recorded",
            file: self.file.display().to_string(),
            seconds: self.begun.elapsed().as_secs_f64(),
            messages: self.writer.messages(),
            images: count(|counts| &counts.received),
            bytes: self.written.load(Ordering::Relaxed),
            dropped: self.inbox.counts().dropped + self.writer.dropped(),
            missed_images: count(|counts| &counts.missed),
        }
    }

    fn write(&mut self, entry: Entry) -> anyhow::Result<()> {
        match entry.content {
            Content::Image(image) => self.writer.write_image(&image, entry.arrival_ns)?,
            Content::Payload { key, bytes } => {
                self.writer.write_payload(&key, &bytes, entry.arrival_ns)?;
                if let Some(KeyRef::CameraStatus(camera)) = self.site.keys.parse(&key)
                    && let Ok(status) = decode::<CameraStatus>(&bytes)
                {
                    self.look_for_images(&camera, &status.host)?;
                }
            }
        }
        Ok(())
    }

    /// A camera on this host has images, another has previews.
    fn look_for_images(&mut self, camera: &CameraId, host: &str) -> anyhow::Result<()> {
        let Some(images) = &mut self.images else {
            return Ok(());
        };
        if host == host_name() {
            images.start(camera)?;
        } else if self.previews.len() < limits::MAX_CAMERAS && !self.previews.contains_key(camera) {
            eprintln!(
                "camera {camera} is on {}: its previews are recorded",
                crate::words::plain(host)
            );
            let key = self.site.keys.preview(camera);
            let subscription = subscribe(self.site, &key, &self.inbox)?;
            self.previews.insert(camera.clone(), subscription);
        }
        Ok(())
    }
}

fn subscriptions(
    site: &SiteSession,
    inbox: &Arc<Inbox>,
    objects: &[ObjectId],
) -> anyhow::Result<Vec<CallbackSubscription>> {
    let keys = &site.keys;
    let mut streams = vec![
        keys.all_observations(),
        keys.all_camera_statuses(),
        keys.all_config(),
        keys.all_inputs(),
        keys.all_fusion_statuses(),
        keys.all_clocks(),
        keys.all_config_answers(),
    ];
    let objects: BTreeSet<&ObjectId> = objects.iter().collect();
    if objects.is_empty() {
        streams.extend([keys.all_poses(), keys.all_links(), keys.all_truths()]);
    }
    for object in objects {
        streams.extend([keys.pose(object), keys.links(object), keys.truth(object)]);
    }
    let streams = streams.iter().map(|key| subscribe(site, key, inbox));
    streams.collect()
}

fn subscribe(
    site: &SiteSession,
    key: &str,
    inbox: &Arc<Inbox>,
) -> anyhow::Result<CallbackSubscription> {
    let (inbox, keys) = (Arc::clone(inbox), site.keys.clone());
    let subscription = site
        .bus
        .subscribe_with(key, limits::MAX_PAYLOAD_BYTES, move |item| {
            if !is_request(&keys, &item) {
                push(&inbox, item);
            }
        });
    subscription.exit_with(Exit::Unavailable)
}

fn push(inbox: &Inbox, item: Item) {
    if let sextant_zenoh_bus::Payload::Bytes(bytes) = item.payload {
        let entry = Entry {
            arrival_ns: now_ns(),
            content: Content::Payload {
                key: item.key,
                bytes,
            },
        };
        entry.push_to(inbox);
    }
}
