//! Every thread of this node panics, each in a process of its own: the process ends and says so. Only a wizard's solve
//! is contained.

use crate::run;
use sextant_process::children::ChildProcess;
use sextant_process::{Exit, Shutdown, logging, panics};
use sextant_proto::Keys;
use sextant_zenoh_bus::{Bus, BusOptions, Qos};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{ChildStderr, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Names the configuration in a process that shall be the node.
const CONFIG: &str = "SEXTANT_TEST_NODE";
const PATIENCE: Duration = Duration::from_secs(60);

/// Not a test but the node, when this binary is run again for one.
#[test]
fn the_node_itself() {
    if let Some(config) = std::env::var_os(CONFIG) {
        panics::end_the_process();
        logging::init("");
        run(Path::new(&config), &Shutdown::install().unwrap()).unwrap();
    }
}

/// A bridge that panics in one place, and the router of its site.
struct Site {
    bus: Bus,
    bridge: ChildProcess,
    stderr: BufReader<ChildStderr>,
    _folder: tempfile::TempDir,
}

impl Site {
    fn start(place: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let bus = Bus::open(&BusOptions::router_on("tcp/127.0.0.1:0")).unwrap();
        let config = folder.path().join("viewer.toml");
        let text = format!(
            "site = \"test\"\nlisten = \"127.0.0.1:0\"\nfolder = \".\"\n[network]\nconnect = [{:?}]\n",
            bus.endpoints()[0]
        );
        std::fs::write(&config, text).unwrap();
        let rig = "[[camera]]\nid = \"a\"\nresolution = [640, 480]\n\
                   lens = { model = \"brown-conrady\", fx = 600, fy = 600, cx = 320, cy = 240, \
                   distortion = [0, 0, 0, 0, 0] }\n";
        std::fs::write(folder.path().join("rig.toml"), rig).unwrap();
        let mut command = Command::new(std::env::current_exe().unwrap());
        command
            .args(["panic_tests::the_node_itself", "--exact", "--nocapture"])
            .env(CONFIG, config)
            .env("SEXTANT_TEST_PANIC", place)
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut bridge = ChildProcess::spawn(place, &mut command).unwrap();
        let stderr = BufReader::new(bridge.child_mut().stderr.take().unwrap());
        Self {
            bus,
            bridge,
            stderr,
            _folder: folder,
        }
    }

    /// Publishes something for the bridge until it has ended.
    fn end(&mut self) -> ExitStatus {
        let key = Keys::new("test").unwrap().truth(&"cube".parse().unwrap());
        let publisher = self.bus.raw_publisher(&key, Qos::Status).unwrap();
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            publisher.put(b"nothing").unwrap();
            if let Some(status) = self.bridge.try_wait().unwrap() {
                return status;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        panic!("the bridge went on");
    }

    /// Where its page is, as it says itself.
    fn address(&mut self) -> String {
        let lines = self.stderr.by_ref().lines().map(Result::unwrap);
        let page = lines.filter_map(|line| Some(line.split_once("http://")?.1.to_owned()));
        let page = page.into_iter().next().expect("it names its page");
        page.trim_end_matches('/').to_owned()
    }
}

fn request(address: &str, head: &str, body: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    let length = body.len();
    write!(
        stream,
        "{head} HTTP/1.1\r\nHost: {address}\r\nContent-Type: application/json\r\nContent-Length: \
         {length}\r\nConnection: close\r\n\r\n{body}"
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[test]
fn a_panic_of_any_thread_ends_the_process() {
    for place in ["server", "network", "wizard", "intake", "web_cameras"] {
        let mut site = Site::start(place);
        let status = site.end();
        let mut words = String::new();
        site.stderr.read_to_string(&mut words).unwrap();
        assert_eq!(status.code(), Some(Exit::Panic as i32), "{place}: {words}");
        assert!(
            words.contains(&format!("process ends: the fail point {place}")),
            "{words}"
        );
    }
}

#[test]
fn a_panic_of_a_solve_is_reported_and_the_bridge_goes_on() {
    let mut site = Site::start("solve");
    let address = site.address();
    let learn = r#"{"do":"start","wizard":"learn","id":"cube","cameras":["a"],"tags":[{"id":0,"size_m":0.04},{"id":1,"size_m":0.04}]}"#;
    for command in [learn, r#"{"do":"solve"}"#] {
        let answer = request(&address, "POST /api/wizard", command);
        assert!(answer.starts_with("HTTP/1.1 202"), "{answer}");
    }
    let deadline = Instant::now() + PATIENCE;
    while !request(&address, "GET /api/state", "").contains("solving failed by a defect") {
        assert!(Instant::now() < deadline, "nobody is told");
    }
    site.bridge.ask_to_stop();
    let status = site.bridge.wait_until(deadline).unwrap();
    assert_eq!(status.and_then(|status| status.code()), Some(0));
}
