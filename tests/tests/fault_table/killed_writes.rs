//! A fusion node that is killed before each of the calls by which it writes a change: after its next start the change
//! is in force whole or not at all, and nothing of what was before is lost.

use super::*;
use sextant_proto::{
    ConfigAnswer, Keys, ModelPayload, NodeId, ObjectConfig, Proposal, RigConfig, encode, limits,
};
use sextant_site_files::{former_of, read_object, read_rig, write_object, write_rig};
use sextant_site_model::{ObjectModel, Rig};
use sextant_zenoh_bus::{Bus, BusOptions, DropRule, Qos};
use std::ffi::OsString;
use std::path::Path;
use std::process::Child;
use system_tests::{KilledWrites, free_port, sextant};

/// Calls between two kills where the table is not run in full length.
const STRIDE: usize = 7;
/// No change takes so many calls.
const MOST_CALLS: usize = 400;

/// Rig and object, before and after the change.
struct Models {
    rig: Rig,
    object: ObjectModel,
}

/// The scene's, with cameras that are off and tags of another size.
fn models(off_m: f64, scale: f64) -> Models {
    let scene = scene().moved(off_m);
    let tags = scene.objects[0].tags().iter().cloned().map(|mut tag| {
        tag.size_m *= scale;
        tag
    });
    let object = ObjectModel::new(scene.objects[0].id().clone(), tags.collect());
    Models {
        rig: scene.rig,
        object: object.expect("an object"),
    }
}

struct Node {
    process: Child,
    bus: Bus,
}

impl Node {
    fn start(folder: &Path, endpoint: &str, environment: &[(OsString, OsString)]) -> Self {
        let mut command = sextant();
        command
            .args(["fusion", "--config"])
            .arg(folder.join("fusion.toml"));
        command.envs(environment.iter().cloned());
        let process = command.spawn().expect("sextant starts");
        let bus = Bus::open(&BusOptions::client_of(endpoint)).expect("the router answers");
        let node = Self { process, bus };
        let deadline = Instant::now() + Duration::from_secs(20);
        while node
            .latest::<FusionStatus>(&keys().all_fusion_statuses())
            .is_none()
        {
            assert!(Instant::now() < deadline, "no status");
        }
        node
    }

    fn latest<M: sextant_proto::Message>(&self, key: &str) -> Option<M> {
        let wait = Duration::from_millis(200);
        let items = self.bus.latest(key, limits::MAX_PAYLOAD_BYTES, wait);
        items.ok()?.iter().find_map(|item| item.decode().ok())
    }

    /// Whether the process was killed before it answered that a change is kept.
    fn is_killed_by(&mut self, change: &Proposal) -> bool {
        let keys = keys();
        let answers = format!(
            "{}fusion/*/answer",
            keys.everything().trim_end_matches("**")
        );
        let longest = limits::MAX_PAYLOAD_BYTES;
        let answers = self
            .bus
            .subscribe(&answers, 8, DropRule::Oldest, longest)
            .expect("a subscription");
        let publisher = self
            .bus
            .raw_publisher(&keys.config_models(), Qos::Config)
            .expect("a publisher");
        publisher
            .put(&encode(change).expect("a message"))
            .expect("the network takes it");
        let deadline = Instant::now() + Duration::from_secs(20);
        while Instant::now() < deadline {
            if self.process.try_wait().expect("a process").is_some() {
                return true;
            }
            let answer = answers.recv_timeout(Duration::from_millis(10));
            if answer.is_some_and(|item| item.decode::<ConfigAnswer>().is_ok()) {
                return false;
            }
        }
        panic!("neither killed nor answered")
    }

    fn end(mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn keys() -> Keys {
    Keys::new("lab").expect("an id")
}

/// The folder of a node with these models; the endpoint at which it listens.
fn folder_with(before: &Models, folder: &Path) -> String {
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    write_rig(&folder.join("rig.toml"), &before.rig).expect("a file");
    write_object(&folder.join("object.toml"), &before.object).expect("a file");
    let text = format!(
        "site = \"lab\"\nrig = \"rig.toml\"\nobjects = [\"object.toml\"]\nkeep_changes = true\n[network]\n\
         mode = \"router\"\nlisten = [\"{endpoint}\"]\n"
    );
    std::fs::write(folder.join("fusion.toml"), text).expect("a file");
    endpoint
}

/// Kills a node before the `nth` call and starts it again; whether the change took fewer calls.
fn is_over_before(nth: usize, writes: &KilledWrites) -> bool {
    let (before, after) = (models(0.0, 1.0), models(0.1, 1.1));
    let change = Proposal {
        rig: Some(ModelPayload::encode(&RigConfig::from(&after.rig)).expect("a message")),
        objects: vec![ModelPayload::encode(&ObjectConfig::from(&after.object)).expect("a message")],
        ..Proposal::none(NodeId::new("test").expect("an id"), 0)
    };
    let (folder, elsewhere) = (
        tempfile::tempdir().expect("a folder"),
        tempfile::tempdir().expect("a folder"),
    );
    let (folder, armed) = (folder.path(), elsewhere.path().join("armed"));
    let endpoint = folder_with(&before, folder);
    let mut node = Node::start(folder, &endpoint, &writes.environment(nth, folder, &armed));
    std::fs::write(&armed, "").expect("a file");
    let is_killed = node.is_killed_by(&change);
    node.end();

    let node = Node::start(folder, &endpoint, &[]);
    let rig = read_rig(&folder.join("rig.toml")).expect("a rig");
    let object = read_object(&folder.join("object.toml")).expect("an object");
    let is_new = [rig == after.rig, object == after.object];
    assert!(
        is_new[0] == is_new[1],
        "killed before call {nth}: {is_new:?}"
    );
    assert!(
        is_new[0] || (rig == before.rig && object == before.object),
        "{nth}"
    );
    assert!(
        is_killed || is_new[0],
        "what was answered to be kept is kept"
    );
    assert!(!folder.join("fusion.toml.change").exists(), "{nth}");
    if is_new[0] {
        let former = read_rig(&former_of(&folder.join("rig.toml"))).expect("the former rig");
        assert!(former == before.rig, "{nth}: the former rig is kept");
    }
    let in_force: Option<RigConfig> = node.latest(&keys().config_rig());
    assert_eq!(in_force, Some(RigConfig::from(&rig)), "{nth}");
    node.end();
    !is_killed
}

#[test]
fn a_node_killed_before_any_call_that_writes_has_the_whole_change_or_none() {
    let writes = KilledWrites::new();
    let stride = if is_full() { 1 } else { STRIDE };
    let calls = (1..MOST_CALLS).step_by(stride);
    let n_kills = calls
        .take_while(|nth| !is_over_before(*nth, &writes))
        .count();
    assert!(n_kills * stride > 20, "the library counts calls: {n_kills}");
    Figure {
        row: "kill -9 before each call that writes a change of rig and object",
        what: "mixed or lost after the restart",
        value: 0.0,
        unit: "changes",
        at_most: 0.0,
    }
    .keep();
}
