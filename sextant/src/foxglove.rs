//! `sextant foxglove`: a running site for Foxglove and Lichtblick, over a WebSocket.

use crate::listening::listen;
use crate::output::{Format, print_line};
use crate::pose_feed::reporter;
use crate::site::SiteArguments;
use crate::words;
use clap::Args;
use sextant_gateways::SiteSession;
use sextant_gateways::foxglove::{FoxgloveServer, HubCounts, PORT};
use sextant_recordings::foxglove::layout::layout;

/// Arguments of `sextant foxglove`.
#[derive(Args, Debug)]
#[command(
    after_help = "In Foxglove or Lichtblick: Open connection, Foxglove WebSocket, ws://127.0.0.1:8765. A layout for this site:
  sextant foxglove --print-layout > sextant.json
and import it there. Topics are those of recordings; docs/foxglove.md lists them. The protocol knows no passwords: whoever reaches the address
can watch the site. With --json, one line at the end: {\"clients\",\"sent\",\"dropped\",\"invalid\",\"turned_away\"}. Stop with Ctrl-C."
)]
pub struct FoxgloveArguments {
    /// Address of the server.
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:8765")]
    listen: String,
    /// Print a layout with the site's cameras and objects, and end.
    #[arg(long)]
    print_layout: bool,
    #[command(flatten)]
    site: SiteArguments,
}

/// Runs `sextant foxglove`.
///
/// # Errors
/// An address that is none or in use, no router.
pub fn run(arguments: &FoxgloveArguments, format: Format) -> anyhow::Result<()> {
    if arguments.print_layout {
        return print_layout(arguments.site.open()?);
    }
    let listener = listen(&arguments.listen, PORT)?;
    let address = listener.local_addr()?;
    let site = arguments.site.open()?;
    let server = FoxgloveServer::start(listener, site.keys.site(), reporter())?;
    eprintln!("serving ws://{address} for Foxglove and Lichtblick; Ctrl-C ends it");
    let counts = server.run(site)?;
    match format {
        Format::Json => print_line(&serde_json::to_string(&counts)?)?,
        Format::Text => eprintln!("{}", text_of(&counts)),
    }
    Ok(())
}

fn text_of(counts: &HubCounts) -> String {
    format!(
        "{} to {}; {} dropped for slow ones, {} of the site invalid, {} turned away",
        words::count(counts.sent as usize, "message"),
        words::count(counts.clients as usize, "client"),
        counts.dropped,
        counts.invalid,
        counts.turned_away
    )
}

fn print_layout(site: SiteSession) -> anyhow::Result<()> {
    let keys = [site.keys.config_rig(), site.keys.all_config_objects()];
    let mirror = site.mirror(&keys)?;
    let cameras = mirror.rig().into_iter().flat_map(|rig| &rig.cameras);
    let cameras: Vec<_> = cameras.map(|camera| camera.id.clone()).collect();
    let objects: Vec<_> = mirror.configs().map(|object| object.id.clone()).collect();
    print_line(&serde_json::to_string_pretty(&layout(&cameras, &objects))?)?;
    site.bus.close();
    Ok(())
}
