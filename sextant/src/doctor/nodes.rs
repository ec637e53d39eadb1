//! What the files of nodes need of this machine: the camera's device, the page's port, folders that can be written.

use crate::config::ConfigKind;
use crate::doctor::Finding;
use node_camera::CameraNodeConfig;
use node_fusion::FusionConfig;
use node_viewer_bridge::ViewerConfig;
use sextant_process::host;
use sextant_proto::{NodeId, NodeKind};
use sextant_site_files::read_toml;
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

/// Findings about the node of a file that passed its check, and the node's name where the network knows one.
pub fn findings(kind: &str, file: &Path) -> (Vec<Finding>, Option<NamedNode>) {
    let folder = file.parent().unwrap_or(Path::new(""));
    if kind == ConfigKind::Camera.word() {
        let config = CameraNodeConfig::read(file).ok();
        let name = config.as_ref().map(|config| config.camera.as_str());
        let name = name.and_then(|name| NodeId::new(name).ok());
        let source = config.as_ref().map(source);
        return (
            source.into_iter().collect(),
            name.map(|name| (NodeKind::Camera, name)),
        );
    }
    if kind == ConfigKind::Fusion.word() {
        let config: Option<FusionConfig> = read_toml(file).ok();
        let name = config.as_ref().map(|config| config.node.clone());
        let files = config.filter(|config| config.keep_changes);
        let files = files.map(|config| folder.join(config.rig));
        let folder = files.as_deref().and_then(Path::parent).map(writable);
        return (
            folder.into_iter().flatten().collect(),
            name.map(|name| (NodeKind::Fusion, name)),
        );
    }
    if kind == ConfigKind::Viewer.word() {
        let Ok(config) = read_toml::<ViewerConfig>(file) else {
            return (Vec::new(), None);
        };
        let folder = config.folder.map(|below| writable(&folder.join(below)));
        let mut findings = vec![page(config.listen)];
        findings.extend(folder.into_iter().flatten());
        return (findings, None);
    }
    (Vec::new(), None)
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
}
