//! The page's doors: what a browser is answered without a token, with one for looking, and with one for changing; by
//! TLS where other machines reach it. The bridge is a real process on a site of profile `site`.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_zenoh_bus::Profile;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::{Child, Output};
use std::sync::Arc;
use std::time::{Duration, Instant};
use system_tests::{LockedSite, PATIENCE, free_port, send, sextant};
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};

const WIZARD: &str = r#"{"do":"discard"}"#;
/// Of a version that never was.
const EDIT: &str = r#"{"do":"remove_object","id":"box","version":"0"}"#;
const JSON: &str = "Content-Type: application/json\r\n";
const UPGRADE: &str = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
    Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

/// How the first message ends, whatever the role.
const HELLO_END: &str = "r\"}";

/// A bridge of a member. Dropping it ends it.
struct Bridge<'a> {
    site: &'a LockedSite,
    member: &'static str,
    port: u16,
    has_tls: bool,
    process: Child,
}

impl<'a> Bridge<'a> {
    fn start(site: &'a LockedSite, member: &'static str, address: &str) -> Self {
        let port = free_port();
        let file = site.path(&format!("{member}.toml"));
        let text = format!(
            "site = \"lab\"\nnode = \"{member}\"\nlisten = \"{address}:{port}\"\n[network]\n\
             connect = [\"{}\"]\n[security]\nprofile = \"site\"\nkeys = \"authority/{member}\"\n",
            site.connect
        );
        fs::write(&file, text).expect("a file");
        let mut command = sextant();
        command.args(["viewer", "--config"]).arg(&file);
        let bridge = Self {
            site,
            member,
            port,
            has_tls: address != "127.0.0.1",
            process: command.spawn().expect("sextant starts"),
        };
        let deadline = Instant::now() + PATIENCE;
        while bridge.get("/readyz", "").0 != 200 {
            assert!(Instant::now() < deadline, "the bridge does not come up");
            std::thread::sleep(Duration::from_millis(20));
        }
        bridge
    }

    fn token(&self, kind: &str) -> String {
        let file = self.site.keys_of(self.member).join("page-tokens.toml");
        let text = fs::read_to_string(file).expect("tokens");
        let head = format!("{kind} = \"");
        let line = text.lines().find_map(|line| line.strip_prefix(&head));
        line.expect("a token").trim_end_matches('"').to_owned()
    }

    fn connect(&self) -> Option<Box<dyn ReadWrite>> {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).ok()?;
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        if !self.has_tls {
            return Some(Box::new(stream));
        }
        let mut roots = RootCertStore::empty();
        let authority = self.site.authority().join("authority.pem");
        let authority = CertificateDer::from_pem_file(authority).expect("a certificate");
        roots.add(authority).expect("an authority");
        let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .expect("versions")
            .with_root_certificates(roots)
            .with_no_client_auth();
        let name = ServerName::try_from("localhost").expect("a name");
        let client = ClientConnection::new(Arc::new(config), name).expect("a client");
        Some(Box::new(StreamOwned::new(client, stream)))
    }

    /// Status and answer: all of it, or, of a WebSocket, up to `until`.
    fn ask(&self, head: &str, body: &str, until: &str) -> (u16, String) {
        let Some(mut stream) = self.connect() else {
            return (0, String::new());
        };
        let request = format!(
            "{head}Host: localhost:{}\r\nContent-Length: {}\r\n\r\n{body}",
            self.port,
            body.len()
        );
        if stream.write_all(request.as_bytes()).is_err() {
            return (0, String::new());
        }
        let (mut answer, mut part) = (Vec::new(), [0; 4096]);
        while let Ok(length @ 1..) = stream.read(&mut part) {
            answer.extend_from_slice(&part[..length]);
            let text = String::from_utf8_lossy(&answer);
            let is_refused = text.contains("\r\n\r\n") && !text.starts_with("HTTP/1.1 101");
            if !until.is_empty() && (is_refused || text.contains(until)) {
                break;
            }
        }
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let status = answer.split(' ').nth(1).and_then(|code| code.parse().ok());
        (status.unwrap_or(0), answer)
    }

    fn get(&self, path: &str, headers: &str) -> (u16, String) {
        let head = format!("GET {path} HTTP/1.1\r\nConnection: close\r\n{headers}");
        self.ask(&head, "", "")
    }

    fn post(&self, path: &str, headers: &str, body: &str) -> (u16, String) {
        let head = format!("POST {path} HTTP/1.1\r\nConnection: close\r\n{JSON}{headers}");
        self.ask(&head, body, "")
    }

    /// What the WebSocket says first, or why there is none.
    fn upgrade(&self, headers: &str) -> (u16, String) {
        let head = format!("GET /ws HTTP/1.1\r\n{UPGRADE}{headers}");
        self.ask(&head, "", HELLO_END)
    }

    /// The cookie that a browser gets for a token.
    fn cookie(&self, token: &str) -> String {
        let (status, answer) = self.post("/api/session", "", &format!("{{\"token\":\"{token}\"}}"));
        assert_eq!(status, 200, "{answer}");
        let set = answer
            .lines()
            .find_map(|line| line.strip_prefix("set-cookie: "));
        let set = set.expect("a cookie");
        assert!(
            set.contains("HttpOnly") && set.contains("SameSite=Strict"),
            "{set}"
        );
        assert_eq!(set.contains("Secure"), self.has_tls, "{set}");
        format!("Cookie: {}\r\n", set.split(';').next().expect("a pair"))
    }
}

trait ReadWrite: Read + Write {}
impl<T: Read + Write> ReadWrite for T {}

impl Drop for Bridge<'_> {
    fn drop(&mut self) {
        send(self.process.id(), libc::SIGTERM);
        let _ = self.process.wait();
    }
}

#[test]
fn the_page_answers_by_token() {
    let site = LockedSite::start(Profile::Site);
    for address in ["127.0.0.1", "0.0.0.0"] {
        let bridge = Bridge::start(&site, "desk", address);
        // Without a token: the page, which asks for one, and nothing of the site.
        let (status, page) = bridge.get("/", "");
        assert!(status == 200 && page.contains("This page wants a token"));
        for path in ["/api/state", "/api/session", "/metrics"] {
            let (status, answer) = bridge.get(path, "");
            assert!(status == 401 && !answer.contains("box"), "{path}: {answer}");
        }
        assert_eq!(bridge.upgrade("").0, 401);
        assert_eq!(bridge.post("/api/wizard", "", WIZARD).0, 401);
        assert_eq!(bridge.post("/api/models", "", EDIT).0, 401);
        // The cameras are not running: anybody hears that something is wrong, readers what.
        let (status, health) = bridge.get("/healthz", "");
        assert!(status == 503 && !health.contains("cam0"), "{health}");

        let reading = bridge.cookie(&bridge.token("read"));
        let (status, state) = bridge.get("/api/state", &reading);
        assert!(
            status == 200 && state.contains("\"role\":\"viewer\""),
            "{state}"
        );
        let (status, metrics) = bridge.get("/metrics", &reading);
        assert!(
            status == 200 && metrics.contains("sextant_bridge_connected 1"),
            "{metrics}"
        );
        let health = bridge.get("/healthz", &reading).1;
        assert!(health.contains("cam0"), "{health}");
        assert!(bridge.upgrade(&reading).1.contains("\"role\":\"viewer\""));
        assert_eq!(bridge.post("/api/wizard", &reading, WIZARD).0, 403);
        assert_eq!(bridge.post("/api/models", &reading, EDIT).0, 403);

        let operating = bridge.cookie(&bridge.token("operate"));
        assert!(
            bridge
                .upgrade(&operating)
                .1
                .contains("\"role\":\"operator\"")
        );
        assert_eq!(bridge.post("/api/wizard", &operating, WIZARD).0, 202);
        let (status, cause) = bridge.post("/api/models", &operating, EDIT);
        assert!(status == 409 && cause.contains("newer version"), "{cause}");
        let bearer = format!("Authorization: Bearer {}\r\n", bridge.token("operate"));
        assert_eq!(bridge.post("/api/wizard", &bearer, WIZARD).0, 202);

        // Another page in the operator's browser, which sends the cookie if the browser lets it.
        let foreign = format!("{operating}Origin: http://elsewhere.example\r\n");
        assert_eq!(bridge.upgrade(&foreign).0, 403);
        assert_eq!(bridge.post("/api/wizard", &foreign, WIZARD).0, 403);
        assert_eq!(bridge.post("/api/models", &foreign, EDIT).0, 403);
    }
}

#[test]
fn who_guesses_tokens_has_to_wait() {
    let site = LockedSite::start(Profile::Site);
    let bridge = Bridge::start(&site, "desk", "127.0.0.1");
    let guess = || bridge.post("/api/session", "", r#"{"token":"guess"}"#).0;
    let guesses: Vec<u16> = (0..11).map(|_| guess()).collect();
    assert_eq!(guesses[0], 401);
    assert_eq!(guesses[10], 429);
    let right = format!("{{\"token\":\"{}\"}}", bridge.token("operate"));
    assert_eq!(bridge.post("/api/session", "", &right).0, 429);
}

#[test]
fn a_bridge_with_the_keys_of_a_viewer_has_no_operators() {
    let site = LockedSite::start(Profile::Site);
    let bridge = Bridge::start(&site, "screen", "127.0.0.1");
    let operating = bridge.cookie(&bridge.token("operate"));
    assert!(bridge.upgrade(&operating).1.contains("\"role\":\"viewer\""));
    assert_eq!(bridge.post("/api/wizard", &operating, WIZARD).0, 403);
}

#[test]
fn a_page_for_everybody_has_to_say_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("viewer.toml");
    let check = |more: &str| -> Output {
        let text = format!("site = \"lab\"\nlisten = \"0.0.0.0:8600\"\n{more}");
        fs::write(&file, text).expect("a file");
        let mut command = sextant();
        command
            .arg("check")
            .arg(&file)
            .output()
            .expect("sextant runs")
    };
    let refused = check("");
    assert_eq!(refused.status.code(), Some(3));
    let words = String::from_utf8_lossy(&refused.stderr);
    assert!(words.contains("profile = \"open\""), "{words}");
    assert!(check("[security]\nprofile = \"open\"\n").status.success());
}
