//! A site of several hosts: name spaces of the network with a link each, real routers, fusion nodes, cameras that
//! render their images, and a page. A host whose link is pulled is replaced, and stands by when it is back.
//!
//! What it needs of the machine is in `crates/test-needs`; it is skipped where that is missing.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_proto::{Keys, State};
use sextant_test_needs as needs;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};
use system_tests::{PATIENCE, Witness, run_in_name_spaces, send, sextant};

const IN_NAME_SPACES: &str = "SEXTANT_TEST_HOSTS";
const HOSTS: [(&str, &str); 6] = [
    ("board", "10.78.0.11"),
    ("router1", "10.78.0.21"),
    ("router2", "10.78.0.22"),
    ("fusion1", "10.78.0.31"),
    ("fusion2", "10.78.0.32"),
    ("page", "10.78.0.41"),
];
const ROUTERS: [&str; 2] = ["tcp/10.78.0.21:7447", "tcp/10.78.0.22:7447"];

#[test]
fn a_site_of_several_hosts_loses_one_and_goes_on() {
    if let Some(folder) = std::env::var_os(IN_NAME_SPACES) {
        return the_site(Path::new(&folder));
    }
    if needs::HOSTS.is_skipped() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    run_in_name_spaces(needs::HOSTS.test, IN_NAME_SPACES, folder.path());
}

fn the_site(folder: &Path) {
    let mut site = Site::start(folder);
    let keys = Keys::new("lab").expect("an id");
    let witness = Witness::start(&keys, &ROUTERS);
    let is_tracking = |pose: &sextant_proto::ObjectPose| pose.state == State::Tracking;
    let begun = Instant::now();
    witness.await_pose(begun, is_tracking);
    until("one node publishes and the other stands by", || {
        let listed = site.list();
        listed.contains("fusion1") && listed.matches("stands by").count() == 1
    });
    // Give the standby's track the time that its own first images take.
    witness.await_pose(Instant::now(), is_tracking);

    let first = witness.sights().last().expect("a pose").pose.epoch;
    let publisher = if site.list_of("fusion1").contains("stands by") {
        "fusion2"
    } else {
        "fusion1"
    };
    let pulled = Instant::now();
    sh(&format!("ip -n {publisher} link set eth0 down"));
    let taken_over = witness.await_pose(pulled, |pose| pose.epoch > first && is_tracking(pose));
    println!("taken over after {:?}", taken_over - pulled);

    sh(&format!("ip -n {publisher} link set eth0 up"));
    until("the first one stands by", || {
        site.list_of(publisher).contains("stands by")
    });

    // The router of half of the site dies with its host: everything is behind the other one then.
    let second = witness.sights().last().expect("a pose").pose.epoch;
    sh("ip -n router1 link set eth0 down");
    let pulled = Instant::now() + Duration::from_secs(5);
    witness.await_pose(pulled, |pose| pose.epoch >= second && is_tracking(pose));
    until("the page answers", || site.page_answers());

    let sights = witness.sights();
    let used = sights.iter().filter(|one| one.is_current);
    let epochs: Vec<u64> = used.map(|one| one.pose.epoch).collect();
    assert!(epochs.is_sorted());
    site.end();
}

/// The processes of all hosts; they end with the name space of processes, too.
struct Site {
    folder: PathBuf,
    running: Vec<Child>,
}

impl Site {
    fn start(folder: &Path) -> Self {
        sh(&format!(
            "mount --make-rprivate / && mount -t tmpfs tmpfs /run && mount -t tmpfs tmpfs \"{}\" &&
            ip link set lo up && ip link add site type bridge && ip addr add 10.78.0.1/24 dev \
            site && ip link set site up",
            folder.display()
        ));
        for (name, address) in HOSTS {
            sh(&format!(
                "ip netns add {name} && ip link add to-{name} type veth peer name eth0 netns \
                 {name} && ip link set to-{name} master site up &&
                ip -n {name} addr add {address}/24 dev eth0 && ip -n {name} link set eth0 up && \
                ip -n {name} link set lo up"
            ));
        }
        let mut site = Self {
            folder: folder.to_owned(),
            running: Vec::new(),
        };
        site.write_files();
        for router in ["router1", "router2"] {
            site.run(router, &["router"], &format!("{router}.toml"));
        }
        for address in ROUTERS {
            let address = address.trim_start_matches("tcp/");
            until("the router listens", || TcpStream::connect(address).is_ok());
        }
        site.run("fusion1", &["fusion"], "fusion1/fusion.toml");
        site.run("fusion2", &["fusion"], "fusion2/fusion.toml");
        for camera in ["north", "south"] {
            site.run("board", &["camera"], &format!("camera-{camera}.toml"));
        }
        site.run("page", &["viewer"], "viewer.toml");
        site
    }

    fn write_files(&self) {
        let files = self.folder.join("files");
        let made = sextant()
            .args([
                "simulate",
                "--seconds",
                "0",
                "--cameras",
                "2",
                "--objects",
                "1",
            ])
            .args(["--exact", "--out"])
            .arg(&files)
            .output()
            .expect("sextant runs");
        assert!(made.status.success(), "{made:?}");
        fs::copy(
            files.join("scenario.toml"),
            self.folder.join("scenario.toml"),
        )
        .expect("a copy");
        let open = "[security]\nprofile = \"open\"\n";
        let network = format!("[network]\nmode = \"client\"\nconnect = {ROUTERS:?}\n{open}");
        for (router, other) in [
            ("router1", "[]".to_owned()),
            ("router2", format!("{:?}", &ROUTERS[..1])),
        ] {
            self.write(
                &format!("{router}.toml"),
                &format!(
                    "site = \"lab\"\nnode = \"{router}\"\n[network]\n\
                    listen = [\"tcp/0.0.0.0:7447\"]\nconnect = {other}\n{open}"
                ),
            );
        }
        for node in ["fusion1", "fusion2"] {
            let own = self.folder.join(node);
            fs::create_dir(&own).expect("a folder");
            for file in ["rig.toml", "cuboid.toml"] {
                fs::copy(files.join(file), own.join(file)).expect("a copy");
            }
            self.write(
                &format!("{node}/fusion.toml"),
                &format!(
                    "site = \"lab\"\nnode = \"{node}\"\nrig = \"rig.toml\"\n\
                    objects = [\"cuboid.toml\"]\n{network}"
                ),
            );
        }
        for camera in ["north", "south"] {
            let memory = format!(
                "[shared_memory]\nroot = \"/run/sx\"\nprefix = \"hosts{}\"\n",
                std::process::id()
            );
            self.write(
                &format!("camera-{camera}.toml"),
                &format!(
                    "site = \"lab\"\ncamera = \"{camera}\"\n[source]\nkind = \"simulator\"\n\
                    scenario = \"scenario.toml\"\n{memory}{network}"
                ),
            );
        }
        self.write(
            "viewer.toml",
            &format!("site = \"lab\"\nlisten = \"10.78.0.41:8600\"\n{network}"),
        );
    }

    fn write(&self, file: &str, text: &str) {
        fs::write(self.folder.join(file), text).expect("a file");
    }

    fn run(&mut self, host: &str, command: &[&str], config: &str) {
        let child = Command::new("nsenter")
            .arg(format!("--net=/run/netns/{host}"))
            .arg(sextant().get_program())
            .args(command)
            .arg("--config")
            .arg(self.folder.join(config))
            .spawn();
        self.running.push(child.expect("util-linux is there"));
    }

    /// What `sextant list` says behind either router.
    fn list(&self) -> String {
        let lists = ROUTERS.map(|router| {
            let mut list = sextant();
            list.args(["list", "--site", "lab", "--connect", router]);
            list.output().expect("sextant runs")
        });
        let text = lists.iter().find(|output| output.status.success());
        text.map_or_else(String::new, |output| {
            String::from_utf8_lossy(&output.stdout).into_owned()
        })
    }

    fn list_of(&self, node: &str) -> String {
        let list = self.list();
        let line = list.lines().find(|line| line.contains(node));
        line.unwrap_or_default().to_owned()
    }

    fn page_answers(&self) -> bool {
        let Ok(mut page) = TcpStream::connect("10.78.0.41:8600") else {
            return false;
        };
        let request = "GET /metrics HTTP/1.1\r\nHost: 10.78.0.41:8600\r\nConnection: close\r\n\r\n";
        let mut answer = String::new();
        page.write_all(request.as_bytes()).is_ok()
            && page.read_to_string(&mut answer).is_ok()
            && answer.starts_with("HTTP/1.1 200")
    }

    fn end(&mut self) {
        for child in &mut self.running {
            send(child.id(), libc::SIGTERM);
        }
        for child in &mut self.running {
            let _ = child.wait();
        }
    }
}

impl Drop for Site {
    fn drop(&mut self) {
        self.end();
    }
}

fn sh(commands: &str) {
    let output = Command::new("sh").args(["-ec", commands]).output();
    let output = output.expect("a shell");
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{commands}\n{words}");
}

fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "never: {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}
