//! The page in a real browser: objects move, outlines lie on the pictures, and it comes back when the bridge does.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_test_needs as needs;
use std::fs;
use std::net::TcpListener;
use std::path::Path;
use std::process::Child;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use system_tests::{Demo, run_page_checks, send, sextant};

/// A viewer bridge that starts anew whenever it ends, as systemd would have it.
struct SupervisedBridge {
    stop: Arc<AtomicBool>,
    supervisor: Option<JoinHandle<()>>,
    process_id_file: std::path::PathBuf,
}

impl SupervisedBridge {
    fn start(folder: &Path) -> Self {
        let (stop, process_id_file) = (Arc::new(AtomicBool::new(false)), folder.join("viewer.pid"));
        let (config, file, stopping) = (
            folder.join("viewer.toml"),
            process_id_file.clone(),
            Arc::clone(&stop),
        );
        let first = spawn(&config, &file);
        let supervisor = std::thread::spawn(move || {
            let mut bridge = first;
            while bridge.wait().is_ok() && !stopping.load(Ordering::SeqCst) {
                bridge = spawn(&config, &file);
            }
        });
        Self {
            stop,
            supervisor: Some(supervisor),
            process_id_file,
        }
    }
}

impl Drop for SupervisedBridge {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        let id = fs::read_to_string(&self.process_id_file)
            .ok()
            .and_then(|id| id.parse().ok());
        id.into_iter().for_each(|id| send(id, libc::SIGTERM));
        let _ = self.supervisor.take().map(JoinHandle::join);
    }
}

fn spawn(config: &Path, process_id_file: &Path) -> Child {
    let child = sextant()
        .args(["viewer", "--config"])
        .arg(config)
        .spawn()
        .expect("sextant starts");
    fs::write(process_id_file, child.id().to_string()).expect("the folder can be written");
    child
}

fn write_config(folder: &Path, connect: &str) -> String {
    let port = TcpListener::bind("127.0.0.1:0")
        .and_then(|l| l.local_addr())
        .expect("a free port")
        .port();
    let listen = format!("127.0.0.1:{port}");
    let text = format!(
        "site = \"demo\"\nnode = \"second\"\nlisten = \"{listen}\"\n[network]\n\
         mode = \"client\"\nconnect = [\"{connect}\"]\n"
    );
    fs::write(folder.join("viewer.toml"), text).expect("the folder can be written");
    format!("http://{listen}")
}

#[test]
fn objects_move_outlines_are_drawn_and_the_page_reconnects() {
    if needs::PAGE.is_skipped() {
        return;
    }
    let demo = Demo::start(&["--cameras", "2", "--objects", "2"]);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let url = write_config(folder.path(), &demo.connect);
    let bridge = SupervisedBridge::start(folder.path());
    let restart = format!("kill -TERM $(cat '{}')", bridge.process_id_file.display());
    run_page_checks(
        "viewer.mjs",
        &[&url, "--timeout", "60", "--restart", &restart],
    );
    drop(bridge);
    demo.signal(libc::SIGINT);
    assert!(demo.wait().status.success());
}
