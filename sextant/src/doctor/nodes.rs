//! What the files of nodes need of this machine: the camera's device, the page's port, folders that can be written.

use crate::config::ConfigKind;
use crate::doctor::Finding;
use crate::site::SiteOfFile;
use node_camera::CameraNodeConfig;
use node_fusion::FusionConfig;
use node_viewer_bridge::{PhonePage, ViewerConfig};
use serde::Deserialize;
use sextant_process::host;
use sextant_proto::{NodeId, NodeKind, SiteId};
use sextant_site_files::read_toml;
use sextant_tag_families::Family;
use sextant_zenoh_bus::{BusOptions, SecurityOptions};
use std::collections::BTreeSet;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::time::Duration;

/// Least free space where nodes write, bytes.
const ENOUGH_DISK_BYTES: u64 = 64 << 20;
/// How long a page may take to answer.
const ANSWER: Duration = Duration::from_secs(1);

/// A node that a file describes.
pub type NamedNode = (NodeKind, NodeId);

/// What the files of all nodes have: the site and the way to it.
#[derive(Debug, Deserialize)]
struct AnyNode {
    site: SiteId,
    #[serde(default)]
    network: BusOptions,
    #[serde(default)]
    security: SecurityOptions,
}

/// The site of a node's file, and how the node gets to it; none where the file is no node's.
pub fn site_of_file(file: &Path) -> Option<SiteOfFile> {
    let node: AnyNode = read_toml(file).ok()?;
    let connect = node.network.connect.iter().flatten().next().cloned();
    let own = node
        .network
        .listen
        .first()
        .and_then(|listen| reachable(listen));
    Some(SiteOfFile {
        site: node.site,
        connect: connect.or(own),
        keys: node.security.keys.map(|keys| beside(file).join(keys)),
    })
}

/// Where this machine reaches a router that listens on `endpoint`.
fn reachable(endpoint: &str) -> Option<String> {
    let is_chosen_at_start = endpoint.ends_with(":0");
    let here = endpoint
        .replace("/0.0.0.0:", "/127.0.0.1:")
        .replace("/[::]:", "/[::1]:");
    (!is_chosen_at_start).then_some(here)
}

/// Findings, and the node's name where the network knows one.
type NodeFindings = (Vec<Finding>, Option<NamedNode>);

/// Findings about the node of a file that passed its check as of this kind.
pub fn findings(kind: &str, file: &Path) -> NodeFindings {
    let found = if kind == ConfigKind::Camera.word() {
        camera(file)
    } else if kind == ConfigKind::Fusion.word() {
        fusion(file)
    } else if kind == ConfigKind::Viewer.word() {
        viewer(file)
    } else {
        None
    };
    found.unwrap_or_default()
}

fn camera(file: &Path) -> Option<NodeFindings> {
    let config = CameraNodeConfig::read(file).ok()?;
    let name = NodeId::new(config.camera.as_str()).ok();
    let node = name.map(|name| (NodeKind::Camera, name));
    Some((vec![source(&config)], node))
}

fn fusion(file: &Path) -> Option<NodeFindings> {
    let config: FusionConfig = read_toml(file).ok()?;
    let rig = beside(file).join(&config.rig);
    let folder = rig.parent().filter(|_| config.keep_changes);
    let findings = folder.map(writable).unwrap_or_default();
    Some((findings, Some((NodeKind::Fusion, config.node))))
}

fn viewer(file: &Path) -> Option<NodeFindings> {
    let config: ViewerConfig = read_toml(file).ok()?;
    let folder = config.folder.map(|folder| beside(file).join(folder));
    let mut findings = folder.as_deref().map(writable).unwrap_or_default();
    findings.push(page(config.listen));
    if let Ok(page) = node_viewer_bridge::phone_page(file) {
        findings.extend(phones(page));
    }
    Some((findings, None))
}

/// Whether phones can be cameras by this page.
fn phones(page: PhonePage) -> Vec<Finding> {
    const ABOUT: &str = "phones";
    let mut findings = Vec::new();
    match page.caution {
        Some(caution) if page.is_local => return vec![Finding::ok(ABOUT, caution)],
        Some(caution) => {
            let words = "phones cannot be cameras by this page";
            return vec![Finding::warning(ABOUT, words, &caution)];
        }
        None => {}
    }
    if let Some(name) = page.missing_name {
        let (words, remedy) = match page.is_self_signed {
            true => (
                "its next start makes another one",
                "restart the viewer".to_owned(),
            ),
            false => (
                "browsers refuse it there",
                format!(
                    "`sextant keys renew DIR NODE --host {name}`, copy the keys of the page and \
                     restart it; or name the page in host_names of viewer.toml"
                ),
            ),
        };
        let words =
            format!("links of phones name {name}, which the page's certificate lacks: {words}");
        findings.push(Finding::warning(ABOUT, words, &remedy));
    }
    findings.push(Finding::ok(
        ABOUT,
        match page.is_self_signed {
            true => {
                "`sextant phone` shows the link; browsers warn once, since the certificate is \
            the page's own: continue to the page"
            }
            false => "`sextant phone` shows their links",
        },
    ));
    findings
}

/// Families that browsers leave out, for their tens of thousands of codes (clients/web/README.md).
const NOT_IN_BROWSERS: [Family; 3] = [
    Family::TagCustom48h12,
    Family::TagStandard52h13,
    Family::TagCircle49h12,
];

/// What phones do not see of tags of these families.
pub fn unread_by_phones(families: &BTreeSet<Family>) -> impl Iterator<Item = Finding> {
    let unread = families.iter().filter(|it| NOT_IN_BROWSERS.contains(it));
    unread.map(|family| {
        Finding::warning(
            "phones",
            format!("browsers do not read tags of {family}"),
            "print tags of another family where phones are to see them",
        )
    })
}

/// The folder of a file.
fn beside(file: &Path) -> &Path {
    let folder = file.parent().filter(|folder| *folder != Path::new(""));
    folder.unwrap_or(Path::new("."))
}

/// Whether a camera node's device, program or file is there and fits.
fn source(config: &CameraNodeConfig) -> Finding {
    let words = |words: String| format!("{}: {words}", config.camera);
    match node_camera::examine(&config.source) {
        Ok(found) => Finding::ok("source", words(found)),
        Err(cause) => Finding::fault(
            "source",
            words(cause.to_string()),
            "`sextant camera --probe` lists this machine's cameras; docs/cameras.md has a file for each kind",
        ),
    }
}

/// Whether the page's address can be listened on, or its bridge runs already.
fn page(address: SocketAddr) -> Finding {
    let port = address.port();
    match TcpListener::bind(address) {
        Ok(_) => Finding::ok("page", format!("{address} is free")),
        Err(cause) if cause.kind() == ErrorKind::AddrInUse => match is_bridge(address) {
            true => Finding::ok("page", format!("a viewer bridge serves {address}")),
            false => Finding::fault(
                "page",
                format!("port {port} is in use by another program"),
                &format!(
                    "choose another `listen` in viewer.toml, or end the program (`ss -ltnp 'sport = :{port}'` names it)"
                ),
            ),
        },
        Err(cause) => Finding::fault(
            "page",
            format!("{address} cannot be listened on: {cause}"),
            "`ip address` lists this machine's addresses; ports below 1024 are the superuser's",
        ),
    }
}

/// Asks what only a viewer bridge without TLS answers.
fn is_bridge(mut address: SocketAddr) -> bool {
    if address.ip().is_unspecified() {
        address.set_ip(IpAddr::V4(Ipv4Addr::LOCALHOST));
    }
    let ask = || -> std::io::Result<String> {
        let mut stream = TcpStream::connect_timeout(&address, ANSWER)?;
        stream.set_read_timeout(Some(ANSWER))?;
        stream
            .write_all(b"GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")?;
        let mut answer = Vec::new();
        stream.take(4096).read_to_end(&mut answer)?;
        Ok(String::from_utf8_lossy(&answer).into_owned())
    };
    ask().is_ok_and(|answer| answer.contains("{\"status\":"))
}

/// Whether a node can replace files in a folder, and how much room there is.
fn writable(folder: &Path) -> Vec<Finding> {
    let name = folder.display();
    // As a node would, which makes missing folders.
    let existing = folder.ancestors().find(|folder| folder.is_dir());
    let existing = existing.unwrap_or(Path::new("."));
    let probe = existing.join(format!(".sextant-doctor-{}", std::process::id()));
    let written = OpenOptions::new().write(true).create_new(true).open(&probe);
    let _ = std::fs::remove_file(&probe);
    if let Err(cause) = written {
        return vec![Finding::fault(
            "folder",
            format!("{name} can't be written: {cause}"),
            "nodes keep calibrations and changes there: give it to the user who runs them, or name another folder",
        )];
    }
    let room = host::free_bytes(existing).map(|bytes| room(&name.to_string(), bytes));
    room.into_iter().collect()
}

fn room(name: &str, bytes: u64) -> Finding {
    let words = format!("{name} can be written, {} MB are free", bytes >> 20);
    if bytes < ENOUGH_DISK_BYTES {
        return Finding::fault(
            "folder",
            words,
            "make room: files that can't be written whole are not replaced",
        );
    }
    Finding::ok("folder", words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::Verdict;

    #[test]
    fn a_full_disk_is_a_fault() {
        assert_eq!(room("/data", 1 << 20).verdict, Verdict::Fault);
        assert_eq!(room("/data", 1 << 30).verdict, Verdict::Ok);
    }

    #[test]
    fn a_source_that_cannot_work_is_a_fault() {
        let folder = tempfile::tempdir().unwrap();
        let verdict = |source: &str| {
            let file = folder.path().join("camera.toml");
            let text = format!("site = \"s\"\ncamera = \"c\"\nsource = {source}\n");
            std::fs::write(&file, text).unwrap();
            let (findings, node) = findings(ConfigKind::Camera.word(), &file);
            assert_eq!(node.unwrap().1.as_str(), "c");
            findings[0].verdict
        };
        assert_eq!(
            verdict("{ kind = \"command\", run = [\"sh\"], format = \"y4m\" }"),
            Verdict::Ok
        );
        assert_eq!(
            verdict("{ kind = \"command\", run = [\"no-such-program\"], format = \"y4m\" }"),
            Verdict::Fault
        );
        assert_eq!(
            verdict("{ kind = \"video\", file = \"missing.mp4\" }"),
            Verdict::Fault
        );
        assert_eq!(
            verdict("{ kind = \"v4l2\", device = \"/dev/null\", resolution = [640, 480] }"),
            Verdict::Fault
        );
    }

    #[test]
    fn a_page_says_what_keeps_phones_away() {
        let folder = tempfile::tempdir().unwrap();
        let of = |text: &str| {
            let file = folder.path().join("viewer.toml");
            std::fs::write(&file, format!("site = \"s\"\n{text}")).unwrap();
            let (findings, _) = findings(ConfigKind::Viewer.word(), &file);
            let phones = findings.into_iter().filter(|one| one.about == "phones");
            phones.collect::<Vec<_>>()
        };
        let open = "listen = \"0.0.0.0:0\"\nfolder = \".\"\n";
        let profile = "[security]\nprofile = \"open\"\n";
        assert_eq!(of("")[0].verdict, Verdict::Ok);
        let plain = of(&format!("{open}{profile}"));
        assert!(plain[0].remedy.as_ref().unwrap().contains("https = true"));
        let secure = format!("{open}https = true\nhost_names = [\"viewer.lab\"]\n{profile}");
        assert_eq!(of(&secure).len(), 1, "{:?}", of(&secure));
        // One that cannot be read has no name at all.
        std::fs::write(folder.path().join("page.pem"), "none").unwrap();
        let former = of(&secure);
        assert!(former[0].words.contains("viewer.lab"), "{former:?}");
    }

    #[test]
    fn families_that_browsers_leave_out_are_named() {
        let families = BTreeSet::from([Family::Tag36h11, Family::TagStandard52h13]);
        let findings: Vec<_> = unread_by_phones(&families).collect();
        assert_eq!(findings.len(), 1);
        assert!(findings[0].words.contains("tagStandard52h13"));
    }
}
