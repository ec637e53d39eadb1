//! `sextant phone`: links and QR codes by which phones become cameras.

use crate::output::{Format, print_line};
use clap::Args;
use node_viewer_bridge::{PhoneLink, phone_links};
use std::path::PathBuf;

/// Arguments of `sextant phone`.
#[derive(Args, Debug)]
#[command(after_help = "For example: sextant phone --config viewer.toml
Scan the code with a phone's camera and open the link: the page explains what the browser asks. docs/phones.md goes the whole way.
With --json, a line a link: {\"camera\",\"url\",\"qr\"}; camera is null where the phone chooses a name.
The link of a site with keys contains the phone's token: show it to nobody else.")]
pub struct PhoneArguments {
    /// File of the viewer bridge that serves the page.
    #[arg(long, default_value = "viewer.toml")]
    config: PathBuf,
}

/// Runs `sextant phone`.
///
/// # Errors
/// A file of a viewer bridge that is missing or wrong.
pub fn run(arguments: &PhoneArguments, format: Format) -> anyhow::Result<()> {
    let links = phone_links(&arguments.config)?;
    for link in &links.links {
        match format {
            Format::Json => print_line(&serde_json::to_string(link)?)?,
            Format::Text => print_line(&text(link))?,
        }
    }
    if let Some(caution) = links.caution {
        eprintln!("{caution}");
    }
    Ok(())
}

fn text(link: &PhoneLink) -> String {
    let name = link.camera.as_ref();
    let name = name.map_or(String::new(), |name| format!("camera {name}\n"));
    format!("{name}{}{}", link.qr_text(), link.url)
}
