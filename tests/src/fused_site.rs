//! A fusion node with its files, and a test in the place of its cameras.

use crate::program::sextant;
use crate::status::first_status;
use sextant_proto::{FusionStatus, Keys, Observations, encode, limits};
use sextant_site_files::{write_object, write_rig};
use sextant_site_model::{ObjectModel, Rig};
use sextant_zenoh_bus::{Bus, BusOptions, DropRule, Qos, RawPublisher, Subscription};
use std::collections::BTreeMap;
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::{Child, Output};

/// A running fusion node, which is the site's router. Dropping it ends it.
pub struct FusedSite {
    fusion: Child,
    folder: tempfile::TempDir,
    /// The router's endpoint.
    pub connect: String,
    /// The test's own place on the network.
    pub bus: Bus,
    /// The site's keys.
    pub keys: Keys,
    publishers: BTreeMap<String, RawPublisher>,
}

impl FusedSite {
    /// Starts a fusion node with this rig, these objects and `more` lines in its file.
    ///
    /// # Panics
    /// When it does not come up.
    #[must_use]
    pub fn start(rig: &Rig, objects: &[ObjectModel], more: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        write_rig(&folder.path().join("rig.toml"), rig).expect("the folder can be written");
        let names = objects.iter().map(|object| format!("{}.toml", object.id()));
        let names: Vec<String> = names.collect();
        for (object, name) in objects.iter().zip(&names) {
            write_object(&folder.path().join(name), object).expect("the folder can be written");
        }
        let connect = format!("tcp/127.0.0.1:{}", free_port());
        let text = format!(
            "site = \"lab\"\nrig = \"rig.toml\"\nobjects = {names:?}\n{more}\n[network]\n\
             mode = \"router\"\nlisten = [\"{connect}\"]\n"
        );
        std::fs::write(folder.path().join("fusion.toml"), text).expect("the folder can be written");
        Self::run(folder, connect)
    }

    fn run(folder: tempfile::TempDir, connect: String) -> Self {
        let mut command = sextant();
        command
            .args(["fusion", "--config"])
            .arg(folder.path().join("fusion.toml"));
        let fusion = command.spawn().expect("sextant starts");
        let bus = Bus::open(&BusOptions::client_of(&connect)).expect("the router answers");
        let site = Self {
            fusion,
            folder,
            connect,
            bus,
            keys: Keys::new("lab").expect("an id"),
            publishers: BTreeMap::new(),
        };
        site.await_status(|_| true);
        site
    }

    /// Ends the node and starts it again from the same files.
    ///
    /// # Panics
    /// When it does not come up.
    #[must_use]
    pub fn restarted(mut self) -> Self {
        self.end();
        let folder = std::mem::replace(&mut self.folder, tempfile::tempdir().expect("a folder"));
        Self::run(folder, self.connect.clone())
    }

    /// A file beside the node's own.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs a command against this site.
    ///
    /// # Panics
    /// When there is no such program.
    #[must_use]
    pub fn run_command(&self, arguments: &[&str]) -> Output {
        let mut command = sextant();
        command
            .args(arguments)
            .args(["--site", "lab", "--connect", &self.connect]);
        command.output().expect("sextant runs")
    }

    /// Publishes an image's observations, as its camera would.
    ///
    /// # Panics
    /// When the network is gone.
    pub fn publish(&mut self, message: &Observations) {
        let key = self.keys.observations(&message.camera);
        let bus = &self.bus;
        // As configuration: a test's burst shall wait for room and lose nothing.
        let open = || bus.raw_publisher(&key, Qos::Config).expect("a publisher");
        let publisher = self.publishers.entry(key.clone()).or_insert_with(open);
        publisher
            .put(&encode(message).expect("a message"))
            .expect("the network takes it");
    }

    /// Everything under a key from now on.
    ///
    /// # Panics
    /// When the network is gone.
    #[must_use]
    pub fn listen(&self, key: &str) -> Subscription {
        self.bus
            .subscribe(key, 65_536, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES)
            .expect("a subscription")
    }

    /// The first status that is as wanted.
    ///
    /// # Panics
    /// When there is none in time; says what the last one was.
    pub fn await_status(&self, wanted: impl Fn(&FusionStatus) -> bool) -> FusionStatus {
        let statuses = self.listen(&self.keys.all_fusion_statuses());
        first_status(&statuses, wanted)
            .unwrap_or_else(|last| panic!("no such status; the last one: {last:?}"))
    }

    fn end(&mut self) {
        crate::send(self.fusion.id(), libc::SIGTERM);
        let _ = self.fusion.wait();
    }
}

impl Drop for FusedSite {
    fn drop(&mut self) {
        if matches!(self.fusion.try_wait(), Ok(None)) {
            self.end();
        }
    }
}

/// A port that nobody listens on now.
pub fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    listener.local_addr().expect("an address").port()
}
