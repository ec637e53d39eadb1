//! `sextant top`: live state of the cameras and objects of a site, and its faults.

mod board;
mod json;
mod rows;
mod screen;
mod table;

use crate::output::{Format, print_line};
use crate::site::SiteArguments;
use board::Board;
use clap::Args;
use screen::Screen;
use sextant_gateways::site::{RouterWatch, SiteSession};
use sextant_process::now_ns;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_proto::limits;
use sextant_zenoh_bus::{AliveWatch, DropRule, Subscription};
use std::time::{Duration, Instant};

/// Messages that wait while a block is drawn; the oldest give way.
const QUEUE: usize = 8192;
/// Between two blocks.
const PERIOD: Duration = Duration::from_secs(1);
/// Time in which every node has published a status; they come once per second.
const ALL_HEARD: Duration = Duration::from_millis(1600);
/// Timeout of queries for last values.
const ANSWER: Duration = Duration::from_millis(500);

/// Arguments of `sextant top`.
#[derive(Args, Debug)]
#[command(
    after_help = "On a terminal the view is redrawn in place; otherwise one block per second is printed. NO_COLOR is
respected. With --json, one line per second: {\"site\",\"t_ns\",\"connected\",\"nodes\":[{\"kind\",\"id\",\"up\",
\"age_s\"}],\"cameras\":[{\"id\",\"rate_hz\",\"detect_ms\":[p50,p99],\"captured\",\"dropped\",\"clock\":{\"source\",
\"error_ms\",\"offset_ms\",\"sigma_ms\",\"drift_ppm\"},\"image_age_ms\",\"received\",\"refused\",\"late\",\"gated\",
\"unknown_tags\",\"gone_s\"}],\"objects\":[{\"id\",\"state\",\"rate_hz\",\"position\",\"orientation\",\"sigma_mm\",
\"sigma_deg\",\"cameras\",\"tags\",\"latency_ms\",\"pose_age_ms\",\"gone_s\"}],\"faults\":[{\"from\",\"words\"}],
\"information\":[{\"from\",\"words\"}]}; null for unknown values. gone_s: seconds since a camera fell silent, or since
no fusion node has an object any more; it is dropped after 60 s, unless the camera is in the rig. Sigmas are the
expected length of the error."
)]
pub struct TopArguments {
    /// Print once and end.
    #[arg(long)]
    once: bool,
    #[command(flatten)]
    site: SiteArguments,
}

/// Runs `sextant top`.
///
/// # Errors
/// No router.
pub fn run(arguments: &TopArguments, format: Format) -> anyhow::Result<()> {
    let site = arguments.site.open()?;
    let mut view = BoardView::open(&site)?;
    if arguments.once {
        view.watch(ALL_HEARD);
        if !site.shutdown.is_requested() {
            print_line(&view.block(format, screen::width()))?;
        }
    } else {
        let screen = (format == Format::Text).then(Screen::take).flatten();
        view.watch(ANSWER);
        while !site.shutdown.is_requested() {
            match &screen {
                Some(screen) => {
                    screen.draw(&table::lines(&view.board, now_ns(), screen.width()))?
                }
                None => print_line(&view.block(format, screen::width()))?,
            }
            view.watch(PERIOD);
        }
    }
    drop(view);
    site.bus.close();
    Ok(())
}

/// The board and its subscription.
struct BoardView<'a> {
    site: &'a SiteSession,
    board: Board,
    router: RouterWatch,
    alive: AliveWatch,
    messages: Vec<Subscription>,
}

impl<'a> BoardView<'a> {
    fn open(site: &'a SiteSession) -> anyhow::Result<Self> {
        let keys = &site.keys;
        let wanted = [
            keys.all_camera_statuses(),
            keys.all_fusion_statuses(),
            keys.all_clocks(),
            keys.all_observations(),
            keys.all_poses(),
        ];
        let subscribe = |key: &String| {
            site.bus
                .subscribe(key, QUEUE, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES)
        };
        let messages = wanted.iter().map(subscribe).collect::<Result<_, _>>()?;
        let mut board = Board::new(keys.clone());
        for key in &wanted[..3] {
            let kept = site.bus.latest(key, limits::MAX_PAYLOAD_BYTES, ANSWER)?;
            kept.iter().for_each(|item| board.take(item, now_ns()));
        }
        Ok(Self {
            site,
            board,
            router: RouterWatch::default(),
            alive: site.bus.watch_alive(&keys.all_alive())?,
            messages,
        })
    }

    /// Handles messages for a duration.
    fn watch(&mut self, duration: Duration) {
        let end = Instant::now() + duration;
        while Instant::now() < end && !self.site.shutdown.wait(SHUTDOWN_POLL) {
            for subscription in &self.messages {
                while let Some(item) = subscription.try_recv() {
                    self.board.take(&item, now_ns());
                }
            }
            while let Some(presence) = self.alive.try_recv() {
                self.board.presence(&presence, now_ns());
            }
        }
        self.board.expire(now_ns());
        self.board.disconnected_s = self.router.silent_s(&self.site.bus);
    }

    fn block(&self, format: Format, width: usize) -> String {
        match format {
            Format::Json => json::line(&self.board, now_ns()),
            Format::Text => {
                let lines = table::lines(&self.board, now_ns(), width);
                let texts = lines.into_iter().map(|line| line.text);
                texts.collect::<Vec<_>>().join("\n")
            }
        }
    }
}
