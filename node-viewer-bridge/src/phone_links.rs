//! Links by which phones and other browsers become cameras, and what may be in their way.

use crate::access::PageAccess;
use crate::certificate::{self, outward};
use crate::config::ViewerConfig;
use crate::phone_claims::PhoneClaims;
use crate::protection::Admission;
use crate::refusal::Refusal;
use anyhow::Context;
use qrcode::QrCode;
use serde::{Deserialize, Serialize};
use sextant_process::{Exit, WithExit};
use sextant_site_files::read_toml;
use sextant_site_model::CameraId;
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};

/// Longest command, bytes.
pub(crate) const MAX_COMMAND_BYTES: usize = 256;

/// What an operator asks of the links.
#[derive(Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Command {
    /// The next device that uses the link of this camera may be it.
    Free { camera: CameraId },
}

impl Command {
    /// # Errors
    /// Bytes that are no command.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, Refusal> {
        serde_json::from_slice(bytes).map_err(|error| Refusal::wrong("camera", error))
    }
}

/// Links that make browsers cameras of the site.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhoneLinks {
    /// One per phone with a key; a single one for a site without keys.
    pub links: Vec<PhoneLink>,
    /// What a person has to change before phones can use them.
    pub caution: Option<String>,
}

/// A link that makes a browser a camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhoneLink {
    /// The camera's name; none where the browser chooses.
    pub camera: Option<CameraId>,
    /// Whether a device has used the link: then it is for that device alone.
    pub used: bool,
    /// The address, with the phone's token in its fragment, which browsers send to no server.
    pub url: String,
    /// The same as a QR code: a row a text, dark modules `1` and light ones `0`, without the quiet zone.
    pub qr: Vec<String>,
}

/// The links of a bridge with this file.
///
/// # Errors
/// [`Exit::Input`] for a wrong file.
pub fn phone_links(config_file: &Path) -> anyhow::Result<PhoneLinks> {
    let (config, admission) = load(config_file)?;
    let kept = kept_folder(&config, config_file);
    let claims = PhoneClaims::open(kept.as_deref());
    let (access, is_secure) = (&admission.access, admission.is_secure);
    Ok(links(
        &config,
        config.listen,
        access,
        is_secure,
        None,
        &claims,
    ))
}

/// What a page is to phones.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PhonePage {
    /// What has to change before phones can be cameras.
    pub caution: Option<String>,
    /// Whether only the bridge's own machine reaches it.
    pub is_local: bool,
    /// Whether its certificate is the bridge's own, of which browsers warn.
    pub is_self_signed: bool,
    /// The name or address in its links, if its certificate does not have it.
    pub missing_name: Option<String>,
}

/// The page of a bridge with this file, as it would be to phones.
///
/// # Errors
/// [`Exit::Input`] for a wrong file.
pub fn phone_page(config_file: &Path) -> anyhow::Result<PhonePage> {
    let (config, admission) = load(config_file)?;
    let keys = admission.network.keys();
    let certificate = match keys {
        Some(keys) => Some(keys.files.page_certificate()),
        None => kept_folder(&config, config_file).map(|kept| kept.join(certificate::FILE)),
    };
    // One that is not there yet is made at the start.
    let certificate = certificate.filter(|_| admission.is_secure);
    let certificate = certificate.and_then(|file| std::fs::read_to_string(file).ok());
    let place = place(&config, config.listen, None);
    let name = place.rsplit_once(':').map_or(&*place, |(name, _)| name);
    let names = [name.trim_matches(['[', ']']).to_owned()];
    let missing = certificate.and_then(|it| certificate::first_missing(&it, &names).cloned());
    let (access, is_secure) = (&admission.access, admission.is_secure);
    Ok(PhonePage {
        caution: links(
            &config,
            config.listen,
            access,
            is_secure,
            None,
            &PhoneClaims::default(),
        )
        .caution,
        is_local: config.listen.ip().to_canonical().is_loopback(),
        is_self_signed: admission.is_secure && keys.is_none(),
        missing_name: missing,
    })
}

fn load(config_file: &Path) -> anyhow::Result<(ViewerConfig, Admission)> {
    let config: ViewerConfig = read_toml(config_file).exit_with(Exit::Input)?;
    let folder = config_file.parent().unwrap_or(Path::new(""));
    let admission = Admission::load(&config, folder)
        .with_context(|| config_file.display().to_string())
        .exit_with(Exit::Input)?;
    Ok((config, admission))
}

fn kept_folder(config: &ViewerConfig, config_file: &Path) -> Option<PathBuf> {
    let beside = config_file.parent().unwrap_or(Path::new(""));
    config.folder.as_ref().map(|kept| beside.join(kept))
}

/// Links to a bridge that listens on `address`, with its access rule and whether it uses TLS; `host` is the one that a
/// browser asked for.
pub(crate) fn links(
    config: &ViewerConfig,
    address: SocketAddr,
    access: &PageAccess,
    is_secure: bool,
    host: Option<&str>,
    claims: &PhoneClaims,
) -> PhoneLinks {
    let scheme = if is_secure { "https" } else { "http" };
    let place = place(config, address, host);
    let url = format!("{scheme}://{place}/camera");
    let phones = access.phones();
    let links = match phones {
        None => vec![PhoneLink::new(None, url)],
        Some(phones) => {
            let links = phones.iter().map(|(camera, token)| {
                let own = format!("{url}?name={camera}#token={token}");
                PhoneLink {
                    used: claims.is_used(camera, token),
                    ..PhoneLink::new(Some(camera.clone()), own)
                }
            });
            links.collect()
        }
    };
    let is_local = address.ip().to_canonical().is_loopback();
    let caution = if links.is_empty() {
        Some(
            "No phone has keys yet: run `sextant keys add DIR NAME --role phone`, copy the keys \
             of this page again and restart it.",
        )
    } else if is_local {
        Some(
            "Only this machine reaches this page. For phones, in viewer.toml: listen = \
             \"0.0.0.0:8600\", https = true and [security] profile = \"open\"; or keys of the site (docs/phones.md).",
        )
    } else if !is_secure {
        Some("Browsers give cameras to secure pages only: set https = true in viewer.toml.")
    } else {
        None
    };
    PhoneLinks {
        links,
        caution: caution.map(str::to_owned),
    }
}

/// Host and port that other machines reach: as the browser that asks wrote them, unless only its own machine does.
fn place(config: &ViewerConfig, address: SocketAddr, host: Option<&str>) -> String {
    let is_own = |host: &&str| {
        let name = host.rsplit_once(':').map_or(*host, |(name, _)| name);
        let name = name.trim_matches(['[', ']']);
        let loopback = name.parse::<IpAddr>().is_ok_and(|it| it.is_loopback());
        name == "localhost" || loopback
    };
    if let Some(host) = host.filter(|host| !is_own(host)) {
        return host.to_owned();
    }
    match (address.ip().is_unspecified(), config.host_names.first()) {
        (false, _) => address.to_string(),
        (true, Some(name)) => format!("{name}:{}", address.port()),
        (true, None) => SocketAddr::new(outward(), address.port()).to_string(),
    }
}

impl PhoneLink {
    fn new(camera: Option<CameraId>, url: String) -> Self {
        // A link of a few hundred bytes fits; a longer one is shown as text alone.
        let qr = QrCode::new(&url).map_or(Vec::new(), |code| {
            let colours = code.to_colors();
            let rows = colours.chunks(code.width().max(1));
            rows.map(|row| row.iter().map(|it| it.select('1', '0')).collect())
                .collect()
        });
        Self {
            camera,
            used: false,
            url,
            qr,
        }
    }

    /// The QR code for a terminal, with its quiet zone: two modules a character, light ones drawn, as terminals are
    /// dark.
    #[must_use]
    pub fn qr_text(&self) -> String {
        const QUIET: usize = 2;
        let is_dark = |x: usize, y: usize| {
            let row = y.checked_sub(QUIET).and_then(|y| self.qr.get(y));
            let module = x.checked_sub(QUIET).zip(row);
            module.is_some_and(|(x, row)| row.as_bytes().get(x) == Some(&b'1'))
        };
        let size = self.qr.len() + 2 * QUIET;
        let mut text = String::new();
        for y in (0..size).step_by(2) {
            for x in 0..size {
                text.push(match (is_dark(x, y), is_dark(x, y + 1)) {
                    (true, true) => ' ',
                    (true, false) => '▄',
                    (false, true) => '▀',
                    (false, false) => '█',
                });
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn links_of(text: &str, host: Option<&str>) -> PhoneLinks {
        let file = Path::new("viewer.toml");
        let config: ViewerConfig = sextant_site_files::parse_toml(file, text, |_| Ok(())).unwrap();
        let admission = Admission::load(&config, Path::new("")).unwrap();
        let (access, is_secure) = (&admission.access, admission.is_secure);
        let claims = PhoneClaims::default();
        links(&config, config.listen, access, is_secure, host, &claims)
    }

    #[test]
    fn a_link_names_the_host_that_others_reach() {
        let open =
            "site = \"a\"\nlisten = \"0.0.0.0:8600\"\nhttps = true\n[security]\nprofile = \"open\"";
        let links = links_of(open, Some("viewer.lab:8600"));
        assert_eq!(links.links[0].url, "https://viewer.lab:8600/camera");
        assert_eq!(links.caution, None);
        let links = links_of(open, Some("localhost:8600"));
        assert!(!links.links[0].url.contains("localhost"), "{links:?}");
    }

    #[test]
    fn what_keeps_phones_away_is_said() {
        let local = links_of("site = \"a\"", None).caution.unwrap();
        assert!(local.contains("listen ="), "{local}");
        let plain = "site = \"a\"\nlisten = \"0.0.0.0:8600\"\n[security]\nprofile = \"open\"";
        let plain = links_of(plain, None).caution.unwrap();
        assert!(plain.contains("https = true"), "{plain}");
    }

    #[test]
    fn a_code_for_the_terminal_has_a_quiet_zone() {
        let link = PhoneLink::new(None, "https://192.168.1.5:8600/camera".to_owned());
        assert!(link.qr.len() >= 21 && link.qr.iter().all(|row| row.len() == link.qr.len()));
        let text = link.qr_text();
        assert!(text.lines().next().unwrap().chars().all(|it| it == '█'));
    }
}
