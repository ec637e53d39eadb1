//! A site with locked doors: an authority, its members' keys, and a fusion node as the router that enforces them.

use crate::fused_site::free_port;
use crate::program::sextant;
use crate::scene::Scene;
use crate::status::{PATIENCE, first_status};
use sextant_proto::{FusionStatus, Keys, limits};
use sextant_site_files::{write_object, write_rig};
use sextant_zenoh_bus::{Bus, BusOptions, DropRule, Profile, Security};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Output};
use std::time::Instant;

/// Members of every such site beside its cameras, as `sextant keys add` wants them. An emulated board
/// ([`crate::Board`]) has an address of its own for the router.
const MEMBERS: [&[&str]; 3] = [
    &["fusion", "--role", "fusion", "--host", crate::board::HOST],
    &["screen", "--role", "viewer"],
    &["desk", "--role", "operator"],
];

/// A running site. Dropping it ends it.
pub struct LockedSite {
    fusion: Child,
    folder: tempfile::TempDir,
    profile: Profile,
    /// The router's endpoint.
    pub connect: String,
    /// The site's keys on the network.
    pub keys: Keys,
    /// What its cameras see.
    pub scene: Scene,
}

/// Runs `sextant keys`.
///
/// # Panics
/// When there is no such program.
#[must_use]
pub fn keys(arguments: &[&str], dir: &Path) -> Output {
    let [command, rest @ ..] = arguments else {
        panic!("a command")
    };
    let mut program = sextant();
    program.args(["keys", command]).arg(dir).args(rest);
    program.output().expect("sextant runs")
}

fn make_keys(authority: &Path, scene: &Scene) {
    make(&["init", "--site", "lab"], authority);
    for member in MEMBERS {
        make(&[&["add"], member].concat(), authority);
    }
    for camera in scene.rig.cameras() {
        make(&["add", camera.id.as_str(), "--role", "camera"], authority);
    }
}

fn make(arguments: &[&str], dir: &Path) {
    let made = keys(arguments, dir);
    assert!(made.status.success(), "{made:?}");
}

impl LockedSite {
    /// Starts a site of two cameras and a box, with its members.
    ///
    /// # Panics
    /// When it does not come up.
    #[must_use]
    pub fn start(profile: Profile) -> Self {
        Self::start_scene(profile, Scene::new(2, &["box"]))
    }

    /// Starts a site of a scene's cameras and its first object.
    ///
    /// # Panics
    /// When it does not come up.
    #[must_use]
    pub fn start_scene(profile: Profile, scene: Scene) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        write_rig(&folder.path().join("rig.toml"), &scene.rig).expect("a rig");
        write_object(&folder.path().join("object.toml"), &scene.objects[0]).expect("an object");
        make_keys(&folder.path().join("authority"), &scene);
        let protocol = if profile == Profile::Site {
            "quic"
        } else {
            "tcp"
        };
        let connect = format!("{protocol}/127.0.0.1:{}", free_port());
        let text = format!(
            "site = \"lab\"\nrig = \"rig.toml\"\nobjects = [\"object.toml\"]\n[network]\n\
             mode = \"router\"\nlisten = [\"{connect}\"]\n[security]\nprofile = \"{}\"\nkeys = \"authority/fusion\"\n",
            profile.name()
        );
        std::fs::write(folder.path().join("fusion.toml"), text).expect("the folder can be written");
        let fusion = run(folder.path());
        let site = Self {
            fusion,
            folder,
            profile,
            connect,
            keys: Keys::new("lab").expect("an id"),
            scene,
        };
        site.await_status(&site.open("screen"), |_| true);
        site
    }

    /// Ends the fusion node and starts it again, as after a change of the members.
    ///
    /// # Panics
    /// When it does not come up.
    pub fn restart(&mut self) {
        self.end();
        self.fusion = run(self.folder.path());
        self.await_status(&self.open("screen"), |_| true);
    }

    /// Runs `sextant keys` on the site's authority.
    ///
    /// # Panics
    /// When that fails.
    pub fn change_members(&self, arguments: &[&str]) {
        make(arguments, &self.authority());
    }

    /// The authority's folder.
    #[must_use]
    pub fn authority(&self) -> PathBuf {
        self.path("authority")
    }

    /// A file beside the fusion node's own.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The folder of a member's keys.
    #[must_use]
    pub fn keys_of(&self, name: &str) -> PathBuf {
        self.authority().join(name)
    }

    /// A member's place on the network.
    ///
    /// # Panics
    /// When it gets none.
    #[must_use]
    pub fn open(&self, name: &str) -> Bus {
        self.open_with(&self.keys_of(name))
    }

    /// A place on the network with these keys.
    ///
    /// # Panics
    /// When it gets none.
    #[must_use]
    pub fn open_with(&self, keys: &Path) -> Bus {
        let security = Security::of_client(&self.connect, Some(keys), "lab").expect("keys");
        assert_eq!(security.profile(), self.profile);
        let deadline = Instant::now() + PATIENCE;
        let late = || Instant::now() >= deadline;
        let options = BusOptions::client_of(&self.connect);
        Bus::open_unless(&options, &security, &late).expect("the router takes the keys")
    }

    /// Whether the router refuses a process that connects like this: it has logged `words` once more and let it in no
    /// further.
    ///
    /// # Panics
    /// When the router says nothing of it.
    #[must_use]
    pub fn refuses(&self, options: &BusOptions, security: &Security, words: &str) -> bool {
        let said = |log: &str| log.matches(words).count();
        let before = said(&self.log());
        let deadline = Instant::now() + PATIENCE;
        let is_refused = || {
            assert!(
                Instant::now() < deadline,
                "nothing of {words:?}: {}",
                self.log()
            );
            said(&self.log()) > before
        };
        Bus::open_unless(options, security, &is_refused).is_err()
    }

    /// What the fusion node has logged.
    ///
    /// # Panics
    /// When its log is gone.
    #[must_use]
    pub fn log(&self) -> String {
        std::fs::read_to_string(self.path("fusion.log")).expect("a log")
    }

    /// The first status that is as wanted, as a reader hears it.
    ///
    /// # Panics
    /// When there is none in time; says what the last one was.
    pub fn await_status(
        &self,
        reader: &Bus,
        wanted: impl Fn(&FusionStatus) -> bool,
    ) -> FusionStatus {
        let statuses = reader
            .subscribe(
                &self.keys.all_fusion_statuses(),
                64,
                DropRule::Oldest,
                limits::MAX_PAYLOAD_BYTES,
            )
            .expect("a subscription");
        first_status(&statuses, wanted)
            .unwrap_or_else(|last| panic!("no such status; the last one: {last:?}; {}", self.log()))
    }

    fn end(&mut self) {
        crate::send(self.fusion.id(), libc::SIGTERM);
        let _ = self.fusion.wait();
    }
}

fn run(folder: &Path) -> Child {
    let log = File::options()
        .create(true)
        .append(true)
        .open(folder.join("fusion.log"))
        .expect("a log");
    let mut command = sextant();
    command
        .args(["fusion", "--config"])
        .arg(folder.join("fusion.toml"))
        .stderr(log);
    command.spawn().expect("sextant starts")
}

impl Drop for LockedSite {
    fn drop(&mut self) {
        if matches!(self.fusion.try_wait(), Ok(None)) {
            self.end();
        }
    }
}
