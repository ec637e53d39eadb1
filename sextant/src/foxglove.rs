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
use std::fs::File;
use std::io::{self, Read};

/// Arguments of `sextant foxglove`.
#[derive(Args, Debug)]
#[command(
    after_help = "In Foxglove or Lichtblick: Open connection, Foxglove WebSocket, ws://127.0.0.1:8765. A layout for this
site:
  sextant foxglove --print-layout > sextant.json
and import it there. Topics are those of recordings; docs/foxglove.md lists them. Whoever reaches the address can watch
the site, web pages in a browser of this machine included. Of a protected site (--keys) a token is part of the address,
which is printed. With --json, one line at the end: {\"clients\",\"sent\",\"dropped\",\"invalid\",\"turned_away\"}. Stop
with Ctrl-C."
)]
pub struct FoxgloveArguments {
    /// Address of the server.
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:8765")]
    listen: String,
    /// Token of a protected site, part of the address; by default a new one at each start.
    #[arg(long, env = "SEXTANT_FOXGLOVE_TOKEN", hide_env_values = true, value_name = "TOKEN", value_parser = token)]
    token: Option<String>,
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
    let token = match (&arguments.token, site.role) {
        (Some(token), _) => Some(token.clone()),
        (None, Some(_)) => Some(new_token()?),
        (None, None) => None,
    };
    let query = token
        .as_ref()
        .map_or_else(String::new, |token| format!("/?token={token}"));
    let server = FoxgloveServer::start(listener, site.keys.site(), token, reporter())?;
    eprintln!("serving ws://{address}{query} for Foxglove and Lichtblick; Ctrl-C ends it");
    let counts = server.run(site)?;
    match format {
        Format::Json => print_line(&serde_json::to_string(&counts)?)?,
        Format::Text => eprintln!("{}", text_of(&counts)),
    }
    Ok(())
}

/// A token that an address can have.
fn token(text: &str) -> Result<String, String> {
    let is_plain = text
        .bytes()
        .all(|byte| byte.is_ascii_alphanumeric() || b"-_".contains(&byte));
    match is_plain && text.len() >= 16 {
        true => Ok(text.to_owned()),
        false => Err("write at least 16 letters, digits, - and _".to_owned()),
    }
}

/// 128 bits of the system's random numbers.
fn new_token() -> io::Result<String> {
    let mut bytes = [0; 16];
    File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
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
