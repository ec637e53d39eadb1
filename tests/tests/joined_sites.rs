//! Two gateways between a site and those who read it from elsewhere, by the file that is shipped: poses pass, of one
//! object at a bounded rate; observations and changes do not. Where `ZENOHD` names zenoh's own router, it takes the
//! place of the second gateway.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_process::now_ns;
use sextant_proto::{ObjectPose, RigConfig, encode, limits};
use sextant_zenoh_bus::{Bus, BusOptions, DropRule, Qos, Subscription};
use std::collections::BTreeMap;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use system_tests::{
    CameraFeed, Cameras, House, PATIENCE, Scene, free_port, sextant, workspace_root,
};

/// The cube's rate in the file, and how long it is measured.
const MOST_HZ: f64 = 10.0;
const MEASURED: Duration = Duration::from_secs(4);
const QUERY_TIMEOUT: Duration = Duration::from_secs(2);

/// The shipped file with these endpoints.
fn gateway(connect: &str, listen: &str) -> String {
    let file = workspace_root().join("deploy/gateway/gateway.toml");
    let text = std::fs::read_to_string(file).expect("the file");
    let ours = text
        .replace("tcp/router.hall-a:7447", connect)
        .replace("tcp/0.0.0.0:7448", listen)
        .replace("v1/hall-a/object/cube", "v1/lab/object/cube");
    for words in [connect, listen, "v1/lab/object/cube"] {
        assert!(ours.contains(words), "{words}: {ours}");
    }
    ours
}

fn listen(bus: &Bus, key: &str) -> Subscription {
    let longest = limits::MAX_PAYLOAD_BYTES;
    let listened = bus.subscribe(key, 4096, DropRule::Oldest, longest);
    listened.expect("a subscription")
}

fn open(endpoint: &str) -> Bus {
    let deadline = Instant::now() + PATIENCE;
    loop {
        match Bus::open(&BusOptions::client_of(endpoint)) {
            Ok(bus) => return bus,
            Err(cause) => assert!(Instant::now() < deadline, "{endpoint}: {cause}"),
        }
    }
}

/// Zenoh's own router with the configuration that `sextant router --zenohd` prints. Dropping it ends it.
struct Zenohd(Child);

impl Zenohd {
    fn start(program: &std::ffi::OsStr, house: &House, text: &str) -> Self {
        let (file, printed) = (house.path("", "far.toml"), house.path("", "far.json5"));
        std::fs::write(&file, text).expect("a file");
        let mut print = sextant();
        print.args(["router", "--zenohd", "--config"]).arg(&file);
        let output = print.output().expect("sextant runs");
        assert!(output.status.success(), "{output:?}");
        std::fs::write(&printed, output.stdout).expect("a file");
        let mut zenohd = Command::new(program);
        zenohd.arg("--config").arg(&printed).stdout(Stdio::null());
        Self(zenohd.spawn().expect("zenohd starts"))
    }
}

impl Drop for Zenohd {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_gateway_lets_poses_pass_and_keeps_the_rest_at_home() {
    let scene = Scene::new(4, &["box", "cube"]);
    let mut house = House::new(&scene);
    let home = house.router("router", &[]);
    let [near, far] = [(); 2].map(|()| format!("tcp/127.0.0.1:{}", free_port()));
    house.node("gateway", "router", &gateway(&home, &near));
    let text = gateway(&near, &far);
    let _zenohd = match std::env::var_os("ZENOHD") {
        Some(program) => Some(Zenohd::start(&program, &house, &text)),
        None => {
            house.node("far", "router", &text);
            None
        }
    };
    house.fusion("main", &[&home]);
    let _cameras = CameraFeed::start(
        &house,
        Cameras {
            cameras: &[0, 1, 2, 3],
            routers: &[&home],
            start_ns: now_ns(),
            rate_hz: 30,
        },
    );
    let (inside, outside) = (open(&home), open(&far));
    let poses = listen(&outside, &house.keys.all_poses());
    let statuses = listen(&outside, &house.keys.all_fusion_statuses());
    let [seen_inside, seen_outside] =
        [&inside, &outside].map(|bus| listen(bus, &house.keys.all_observations()));
    let changes = listen(&inside, &house.keys.config_rig());
    let first = poses.recv_timeout(PATIENCE);
    assert!(first.is_some(), "poses pass both gateways");

    while poses.try_recv().is_some() {}
    let begun = Instant::now();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    while begun.elapsed() < MEASURED {
        if let Some(item) = poses.recv_timeout(Duration::from_millis(100)) {
            let pose: ObjectPose = item.decode().expect("a pose");
            *counts.entry(pose.object.to_string()).or_default() += 1;
        }
    }
    let seconds = begun.elapsed().as_secs_f64();
    assert_eq!(counts.len(), 2, "both objects: {counts:?}");
    let rate_hz = |object: &str| counts[object] as f64 / seconds;
    let cube_hz = rate_hz("cube");
    let is_bounded = (0.2 * MOST_HZ..1.2 * MOST_HZ).contains(&cube_hz);
    assert!(is_bounded, "{cube_hz} poses/s of the cube");
    assert!(rate_hz("box") > 2.0 * MOST_HZ, "that of the box is not");
    let status = statuses.recv_timeout(PATIENCE);
    assert!(status.is_some(), "statuses pass");
    let rig = house.keys.config_rig();
    let models = outside.latest(&rig, limits::MAX_PAYLOAD_BYTES, QUERY_TIMEOUT);
    let models = models.expect("an answer");
    let known: RigConfig = models.first().expect("the rig").decode().expect("a rig");
    assert_eq!(known.cameras.len(), 4);
    assert!(
        seen_inside.try_recv().is_some(),
        "cameras are heard at home"
    );
    assert!(seen_outside.try_recv().is_none(), "and nowhere else");

    let publisher = outside.raw_publisher(&rig, Qos::Config);
    let mut changed = known;
    changed.cameras.pop();
    let payload = encode(&changed).expect("a message");
    publisher.expect("a publisher").put(&payload).expect("sent");
    // What was put before a query of the same link has arrived by its answer.
    let after = outside.latest(&rig, limits::MAX_PAYLOAD_BYTES, QUERY_TIMEOUT);
    let after: RigConfig = after.expect("an answer")[0].decode().expect("a rig");
    assert_eq!(after.cameras.len(), 4, "other sites cannot change the rig");
    while let Some(item) = changes.try_recv() {
        let heard: RigConfig = item.decode().expect("a rig");
        assert_eq!(heard.cameras.len(), 4, "a change from elsewhere came in");
    }
}
