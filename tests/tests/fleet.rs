//! `sextant deploy` to three hosts: name spaces for network and mounts, each with a root of its own over this
//! machine's, a real sshd, a real dpkg or BusyBox' way of starting, and the real camera node with keys of its own. A
//! host whose package or configuration fails has what it had before.
//!
//! What it needs of the machine is in `crates/test-needs`; it is skipped where that is missing.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use serde_json::Value;
use sextant_test_needs::FLEET;
use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use system_tests::{
    PATIENCE, Workshop, keys, node_camera, run_in_name_spaces, send, sextant, workspace_root,
};

const IN_NAME_SPACES: &str = "SEXTANT_TEST_FLEET";
/// Where each host finds this build's camera node, whatever of this machine it sees.
const PROGRAM: &str = "/usr/local/lib/node-camera";
/// The site's address, and those of the hosts.
const SITE: &str = "10.77.0.1";
const HOSTS: [Host; 3] = [
    Host {
        name: "north",
        address: "10.77.0.11",
        kind: "debian",
    },
    Host {
        name: "south",
        address: "10.77.0.12",
        kind: "debian",
    },
    Host {
        name: "east",
        address: "10.77.0.13",
        kind: "busybox",
    },
];

struct Host {
    name: &'static str,
    address: &'static str,
    kind: &'static str,
}

#[test]
fn hosts_of_a_fleet_are_new_or_as_they_were() {
    if let Some(folder) = std::env::var_os(IN_NAME_SPACES) {
        return the_fleet(Path::new(&folder));
    }
    if FLEET.is_skipped() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    run_in_name_spaces(FLEET.test, IN_NAME_SPACES, folder.path());
}

fn the_fleet(folder: &Path) {
    let fleet = Fleet::start(folder);
    every_host_gets_what_it_shall_have(&fleet);
    a_second_run_has_nothing_to_do(&fleet);
    a_package_that_fails_half_way_is_undone(&fleet);
    a_camera_that_the_site_does_not_see_is_undone(&fleet);
    an_interrupted_deployment_is_undone(&fleet);
    a_host_that_does_not_let_us_in_is_reported_with_a_remedy(&fleet);
}

fn every_host_gets_what_it_shall_have(fleet: &Fleet) {
    fleet.package("0.1.0-1");
    for host in &HOSTS {
        fleet.configure(host.name, &fleet.router());
    }
    let planned = fleet.deploy(&["--dry-run"]);
    assert_eq!(outcomes(&planned, 0), ["planned"; 3]);
    assert!(!fleet.root("north").join("usr/bin/node-camera").exists());
    let deployed = fleet.deploy(&[]);
    assert_eq!(outcomes(&deployed, 0), ["new"; 3]);
    for host in ["north", "south"] {
        assert_eq!(fleet.installed(host), "ii  0.1.0-1");
    }
    let listed = fleet.sextant(&["list"]);
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    for host in &HOSTS {
        assert!(
            listed.contains(&format!("camera {}", host.name)),
            "{listed}"
        );
    }
}

fn a_second_run_has_nothing_to_do(fleet: &Fleet) {
    let before = HOSTS.map(|host| fleet.files(host.name));
    assert_eq!(outcomes(&fleet.deploy(&[]), 0), ["unchanged"; 3]);
    assert_eq!(HOSTS.map(|host| fleet.files(host.name)), before);
}

/// The package's own script fails on one host, when dpkg has put the new files in place.
fn a_package_that_fails_half_way_is_undone(fleet: &Fleet) {
    let before = fleet.files("south");
    fleet.package("0.1.0-2");
    let fails = fleet.root("south").join("etc/package-fails");
    fs::write(&fails, "").expect("a file");
    let deployed = fleet.deploy(&[]);
    assert_eq!(outcomes(&deployed, 1), ["new", "rolled-back", "new"]);
    let south = &reports(&deployed)[1];
    assert_eq!(south["cause"], "the package cannot be installed");
    assert!(
        south["log"].to_string().contains("this package fails here"),
        "{south}"
    );
    fs::remove_file(&fails).expect("it is there");
    assert_eq!(fleet.installed("north"), "ii  0.1.0-2");
    assert_eq!(fleet.installed("south"), "ii  0.1.0-1");
    assert_eq!(fleet.files("south"), before);
    fleet.await_camera("south");
}

/// The new configuration leads nowhere: package, configuration and keys are the former ones again.
fn a_camera_that_the_site_does_not_see_is_undone(fleet: &Fleet) {
    let before = fleet.files("south");
    fleet.configure("south", "quic/10.77.0.99:7447");
    fleet.keys(&["renew", "south"]);
    let deployed = fleet.deploy(&["--timeout", "5"]);
    assert_eq!(
        outcomes(&deployed, 1),
        ["unchanged", "rolled-back", "unchanged"]
    );
    let south = &reports(&deployed)[1];
    assert!(
        south["cause"]
            .to_string()
            .contains("did not see its camera within 5 s"),
        "{south}"
    );
    assert!(
        south["log"].to_string().contains("no router answers"),
        "{south}"
    );
    assert_eq!(fleet.installed("south"), "ii  0.1.0-1");
    assert_eq!(fleet.files("south"), before);
    fleet.await_camera("south");
}

/// Ctrl-C while the site is waited for.
fn an_interrupted_deployment_is_undone(fleet: &Fleet) {
    let before = fleet.files("east");
    fleet.configure("east", "quic/10.77.0.99:7447");
    let mut child = fleet.start_deployment(&["--timeout", "600"], &["east"]);
    let said = BufReader::new(child.stderr.take().expect("a pipe"));
    let mut lines = said.lines().map_while(Result::ok);
    assert!(lines.any(|line| line == "east: waiting"), "it never waited");
    send(child.id(), libc::SIGINT);
    let output = child.wait_with_output().expect("it ends");
    drop(lines);
    assert_eq!(outcomes(&output, 130), ["rolled-back"]);
    assert_eq!(fleet.files("east"), before);
    fleet.await_camera("east");
}

fn a_host_that_does_not_let_us_in_is_reported_with_a_remedy(fleet: &Fleet) {
    for (host, remedy) in [
        ("unknown", "compare the fingerprint"),
        ("locked", "ssh-copy-id"),
        ("powerless", "NOPASSWD"),
    ] {
        let output = fleet.start_deployment(&[], &[&format!("{host}=north")]);
        let output = output.wait_with_output().expect("it ends");
        assert_eq!(outcomes(&output, 4), ["unreachable"]);
        let cause = reports(&output)[0]["cause"].to_string();
        assert!(cause.contains(remedy), "{cause}");
    }
}

fn reports(output: &Output) -> Vec<Value> {
    let text = String::from_utf8_lossy(&output.stdout);
    let lines = text.lines();
    lines
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect()
}

/// What became of each host, after this exit code.
fn outcomes(output: &Output, code: i32) -> Vec<String> {
    assert_eq!(output.status.code(), Some(code), "{output:?}");
    let reports = reports(output);
    let outcomes = reports
        .iter()
        .map(|report| report["outcome"].as_str().expect("a word").to_owned());
    outcomes.collect()
}

/// The site and its hosts.
struct Fleet {
    folder: PathBuf,
    /// They end with the name space of processes, too.
    running: Vec<Child>,
}

impl Drop for Fleet {
    fn drop(&mut self) {
        for child in &mut self.running {
            send(child.id(), libc::SIGTERM);
            let _ = child.wait();
        }
    }
}

impl Fleet {
    fn start(folder: &Path) -> Self {
        let mut fleet = Self {
            folder: folder.to_owned(),
            running: Vec::new(),
        };
        let setup = format!(
            "mount --make-rprivate / && mount -t tmpfs tmpfs \"$1\" && mount -t tmpfs tmpfs /run \
             && cd \"$1\" && mkdir config packages &&
            ssh-keygen -q -t ed25519 -N '' -f host_key && ssh-keygen -q -t ed25519 -N '' -f id \
            && cp id.pub authorized_keys &&
            ip link set lo up && ip link add site type bridge && ip addr add {SITE}/24 dev site && ip link set site up"
        );
        sh(&setup, &[folder.as_os_str()]);
        fleet.start_site();
        let mut ssh = String::new();
        for host in &HOSTS {
            fleet.start_host(host);
            ssh.push_str(&format!(
                "Host {}\nHostName {}\nUserKnownHostsFile \"{}/known_hosts\"\nUser root\n",
                host.name,
                host.address,
                folder.display()
            ));
        }
        let [north, ..] = &HOSTS;
        for (host, user, known) in [
            ("unknown", "root", "none"),
            ("locked", "ghost", "known_hosts"),
            ("powerless", "pi", "known_hosts"),
        ] {
            ssh.push_str(&format!(
                "Host {host}\nHostName {}\nUserKnownHostsFile \"{}/{known}\"\nUser {user}\n",
                north.address,
                folder.display()
            ));
        }
        ssh.push_str(&format!(
            "Host *\nIdentityFile \"{}/id\"\nIdentitiesOnly yes\n",
            folder.display()
        ));
        fs::write(folder.join("ssh_config"), ssh).expect("a file");
        fleet
    }

    /// A fusion node as the router, with a member for each host.
    fn start_site(&mut self) {
        self.keys(&["init", "--site", "lab"]);
        self.keys(&["add", "fusion", "--role", "fusion", "--host", SITE]);
        self.keys(&["add", "ada", "--role", "operator"]);
        for host in &HOSTS {
            self.keys(&["add", host.name, "--role", "camera"]);
        }
        let rig = self.folder.join("rig.toml");
        sextant_site_files::write_rig(&rig, &Workshop::default().rig()).expect("a file");
        let text = "site = \"lab\"\nrig = \"rig.toml\"\nobjects = []\n[network]\n\
            mode = \"router\"\nlisten = [\"quic/0.0.0.0:7447\"]\n[security]\nprofile = \"site\"\n\
            keys = \"authority/fusion\"\n";
        let config = self.folder.join("fusion.toml");
        fs::write(&config, text).expect("a file");
        let fusion = sextant().args(["fusion", "--config"]).arg(config).spawn();
        self.running.push(fusion.expect("sextant starts"));
    }

    fn start_host(&mut self, host: &Host) {
        let Host {
            name,
            address,
            kind,
        } = host;
        sh(&format!(
            "ip netns add {name} && ip link add to-{name} type veth peer name eth0 netns {name} \
             && ip link set to-{name} master site up &&
            ip -n {name} addr add {address}/24 dev eth0 && ip -n {name} link set eth0 up && ip -n {name} link set lo up"
        ), &[]);
        let folder = self.folder.join(name);
        fs::create_dir(&folder).expect("a folder");
        let log = fs::File::create(folder.join("sshd.log")).expect("a file");
        let child = Command::new("nsenter")
            .arg(format!("--net=/run/netns/{name}"))
            .args(["unshare", "--mount", "--propagation", "slave"])
            .arg(workspace_root().join("tests/fleet/enter"))
            .arg(&folder)
            .arg(kind)
            .arg(node_camera().get_program())
            .arg(PROGRAM)
            .stderr(log)
            .spawn();
        self.running.push(child.expect("util-linux is there"));
        until("sshd answers", || {
            TcpStream::connect((*address, 22)).is_ok()
        });
        let key = fs::read_to_string(self.folder.join("host_key.pub")).expect("a key");
        let mut known = fs::File::options()
            .create(true)
            .append(true)
            .open(self.folder.join("known_hosts"))
            .expect("a file");
        write!(known, "{address} {key}").expect("the file takes it");
    }

    fn router(&self) -> String {
        format!("quic/{SITE}:7447")
    }

    /// The `camera-NAME.toml` that is deployed: grey images by a program.
    fn configure(&self, camera: &str, router: &str) {
        let text = format!(
            "site = \"lab\"\ncamera = \"{camera}\"\n[source]\nkind = \"command\"\n\
             run = [\"sh\", \"-c\", \"while :; do head -c 3072 /dev/zero; sleep 0.1; done\"]\n\
             format = \"grey\"\nresolution = [64, 48]\n[network]\nconnect = [\"{router}\"]\n\
             [security]\nprofile = \"site\"\nkeys = \"keys/{camera}\"\n"
        );
        let file = self
            .folder
            .join("config")
            .join(format!("camera-{camera}.toml"));
        fs::write(file, text).expect("a file");
    }

    /// Packages of a version in the place of those before. What is in them starts [`PROGRAM`].
    fn package(&self, version: &str) {
        let init = workspace_root().join("deploy/init.d/S90sextant-camera");
        let build = format!(
            "cd \"$1\" && rm -rf tree packages/* && mkdir -p tree/usr/bin tree/etc/default tree/etc/init.d &&
            printf '#!/bin/sh\\n# {version}\\nexec {PROGRAM} \"$@\"\\n' \
            >tree/usr/bin/node-camera && chmod 755 tree/usr/bin/node-camera &&
            echo '# {version}' >tree/etc/default/sextant-camera && cp \"$2\" tree/etc/init.d/ &&
            tar -czf packages/sextant-camera-0.1.0-$(uname -m).tar.gz -C tree usr etc && rm -r \
            tree/etc/init.d && mkdir tree/DEBIAN &&
            echo /etc/default/sextant-camera >tree/DEBIAN/conffiles &&
            printf '#!/bin/sh\\n[ ! -e /etc/package-fails ] || [ {version} = 0.1.0-1 ] || {{ \
            echo this package fails here; exit 1; }}\\n' >tree/DEBIAN/postinst &&
            chmod 755 tree/DEBIAN/postinst && architecture=$(dpkg --print-architecture) &&
            printf 'Package: sextant-camera\\nVersion: {version}\\nArchitecture: \
            %s\\nMaintainer: T <t@example.invalid>\\nDescription: a stand-in\\n' $architecture >tree/DEBIAN/control &&
            dpkg-deb --root-owner-group -Znone --build tree \
            packages/sextant-camera_{version}_$architecture.deb >/dev/null"
        );
        sh(&build, &[self.folder.as_os_str(), init.as_os_str()]);
    }

    fn keys(&self, arguments: &[&str]) {
        let made = keys(arguments, &self.folder.join("authority"));
        assert!(made.status.success(), "{made:?}");
    }

    fn sextant(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("sextant runs")
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut sextant = sextant();
        sextant
            .args(arguments)
            .args(["--site", "lab", "--connect", &self.router()]);
        sextant.arg("--keys").arg(self.folder.join("authority/ada"));
        sextant
    }

    /// Deploys to all hosts.
    fn deploy(&self, options: &[&str]) -> Output {
        let hosts = HOSTS.map(|host| host.name);
        self.start_deployment(options, &hosts)
            .wait_with_output()
            .expect("it ends")
    }

    fn start_deployment(&self, options: &[&str], hosts: &[&str]) -> Child {
        let mut command = self.command(&["deploy", "--json"]);
        command.args(options).args(hosts);
        for (option, file) in [
            ("--config", "config"),
            ("--authority", "authority"),
            ("--packages", "packages"),
            ("--ssh-config", "ssh_config"),
        ] {
            command.arg(option).arg(self.folder.join(file));
        }
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("sextant runs")
    }

    /// What a host has below its root, as sshd sees it.
    fn root(&self, host: &str) -> PathBuf {
        let at = HOSTS
            .iter()
            .position(|one| one.name == host)
            .expect("a host");
        // The fusion node is the first; nsenter and enter become sshd.
        PathBuf::from(format!("/proc/{}/root", self.running[at + 1].id()))
    }

    /// dpkg's word on the package.
    fn installed(&self, host: &str) -> String {
        let output = Command::new("chroot")
            .arg(self.root(host))
            .args([
                "dpkg-query",
                "--show",
                "--showformat",
                "${db:Status-Abbrev} ${Version}",
                "sextant-camera",
            ])
            .output()
            .expect("chroot runs");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Everything that a deployment changes, with its content and permissions.
    fn files(&self, host: &str) -> String {
        let output = Command::new("chroot")
            .arg(self.root(host))
            .args([
                "sh",
                "-c",
                "for f in $(find /var/lib/sextant /etc/sextant \
                /usr/bin/node-camera /etc/default/sextant-camera -type f 2>/dev/null | sort); do \
                stat -c '%n %a %U' $f; sha256sum <$f; done; ls /var/lib/sextant-deploy/*",
            ])
            .output()
            .expect("chroot runs");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// The site sees a camera.
    fn await_camera(&self, camera: &str) {
        until("the camera is back", || {
            let listed = self.sextant(&["list", "--json"]);
            let listed: Value = serde_json::from_slice(&listed.stdout).unwrap_or_default();
            let cameras = listed["cameras"].as_array().cloned().unwrap_or_default();
            cameras.iter().any(|one| one["camera"] == camera)
        });
    }
}

fn sh(commands: &str, arguments: &[&OsStr]) {
    let output = Command::new("sh")
        .args(["-ec", commands, "sh"])
        .args(arguments)
        .output()
        .expect("a shell");
    assert!(
        output.status.success(),
        "{commands}\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "never: {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}
