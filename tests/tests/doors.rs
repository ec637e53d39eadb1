//! Locked doors: what members of a site may do by their roles, and that nobody else may do anything. The router is a
//! real fusion node, the keys are those of `sextant keys`; who tries the doors is this test.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use rcgen::{BasicConstraints, CertificateParams, DnType, IsCa, Issuer, KeyPair, date_time_ymd};
use sextant_process::now_ns;
use sextant_proto::{
    CameraSettings, CameraStatus, ChangeOutcome, ConfigAnswer, FusionStatus, Keys, NodeId,
    NodeKind, Observations, encode, fingerprint, limits,
};
use sextant_simulator::Scenario;
use sextant_zenoh_bus::{
    Bus, BusOptions, DropRule, Presence, Profile, Qos, Security, why_no_router,
};
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};
use system_tests::{LockedSite, PATIENCE, sextant};

const PROFILES: [Profile; 2] = [Profile::Lab, Profile::Site];
const QUESTION: Duration = Duration::from_secs(1);

fn received(status: &FusionStatus, camera: &str) -> u64 {
    let mut cameras = status.cameras.iter();
    let found = cameras.find(|one| one.camera.as_str() == camera);
    found.map_or(0, |one| one.received)
}

/// Publishes on a key whatever it is.
fn put(bus: &Bus, key: &str, payload: &[u8]) {
    let publisher = bus.raw_publisher(key, Qos::Config).expect("a publisher");
    publisher.put(payload).expect("the network takes it");
}

fn publish(bus: &Bus, keys: &Keys, seen: &Observations) {
    put(
        bus,
        &keys.observations(&seen.camera),
        &encode(seen).expect("a message"),
    );
}

/// The latest of everything on an expression, as a reader is answered.
fn asked(bus: &Bus, key: &str) -> Vec<String> {
    let items = bus.latest(key, limits::MAX_PAYLOAD_BYTES, QUESTION);
    items
        .expect("a question")
        .into_iter()
        .map(|item| item.key)
        .collect()
}

#[test]
fn a_camera_publishes_below_its_own_key_only() {
    for profile in PROFILES {
        let mut site = LockedSite::start(profile);
        let (board, screen) = (site.open("cam0"), site.open("screen"));
        let own = site.scene.observe(0, 0.0, now_ns());
        let foreign = site.scene.observe(1, 0.0, now_ns());
        (0..5).for_each(|_| publish(&board, &site.keys, &foreign));
        put(&board, &site.keys.config_rig(), b"no rig");
        // What came before on the same link was decided on before.
        publish(&board, &site.keys, &own);
        let status = site.await_status(&screen, |status| received(status, "cam0") == 1);
        assert_eq!(received(&status, "cam1"), 0, "{profile:?}");
        // And its owner is not kept from it; the session stays open, since QUIC drops what is under way when a session
        // ends.
        let owner = site.open("cam1");
        publish(&owner, &site.keys, &foreign);
        site.await_status(&screen, |status| received(status, "cam1") == 1);
    }
}

/// Which of two wishes for another rig the fusion node answers: first that of a member, then that of the operator.
/// Neither is a rig, so that both are refused by the node if they reach it.
fn answered(site: &LockedSite, member: &str) -> Vec<u64> {
    let [first, second] = [b"no rig 1", b"no rig 2"];
    let (wisher, desk) = (site.open(member), site.open("desk"));
    let answers = desk
        .subscribe(
            &site.keys.all_config_answers(),
            64,
            DropRule::Oldest,
            limits::MAX_PAYLOAD_BYTES,
        )
        .expect("a subscription");
    put(&wisher, &site.keys.config_rig(), first);
    // Answered from behind what was put: it has passed the door, or has not.
    asked(&wisher, &site.keys.config_rig());
    let mut heard = Vec::new();
    let deadline = Instant::now() + PATIENCE;
    while heard.last() != Some(&fingerprint(second)) {
        assert!(Instant::now() < deadline, "no answer: {}", site.log());
        put(&desk, &site.keys.config_rig(), second);
        if let Some(item) = answers.recv_timeout(Duration::from_millis(200)) {
            let answer: ConfigAnswer = item.decode().expect("an answer");
            assert!(
                matches!(answer.outcome, ChangeOutcome::Refused(_)),
                "{answer:?}"
            );
            heard.push(answer.fingerprint);
        }
    }
    heard
}

#[test]
fn an_operator_changes_the_site_and_a_viewer_does_not() {
    let [first, second] = [fingerprint(b"no rig 1"), fingerprint(b"no rig 2")];
    for profile in PROFILES {
        let site = LockedSite::start(profile);
        for member in ["screen", "cam0"] {
            let heard = answered(&site, member);
            assert!(
                heard.iter().all(|one| *one == second),
                "{profile:?} {member}"
            );
        }
        assert_eq!(answered(&site, "desk")[0], first, "{profile:?}");
        let set = |member: &str| {
            let mut command = sextant();
            command
                .args(["config", "set", "rig"])
                .arg(site.path("rig.toml"))
                .args(["--site", "lab", "--connect", &site.connect, "--keys"])
                .arg(site.keys_of(member));
            command.output().expect("sextant runs")
        };
        assert!(set("desk").status.success(), "{:?}", set("desk"));
        let refused = set("screen");
        let words = String::from_utf8_lossy(&refused.stderr);
        assert!(words.contains("operator"), "{words}");
    }
}

#[test]
fn who_may_read_is_answered_and_who_may_not_is_not() {
    for profile in PROFILES {
        let site = LockedSite::start(profile);
        let everything = site.keys.everything();
        let screen = asked(&site.open("screen"), &everything);
        assert!(
            screen.iter().any(|key| key.ends_with("config/rig")),
            "{screen:?}"
        );
        assert!(
            screen.iter().any(|key| key.ends_with("/status")),
            "{screen:?}"
        );
        let board = site.open("cam0");
        let lens = asked(&board, &site.keys.config_rig());
        assert!(
            lens.iter().any(|key| key.ends_with("config/rig")),
            "{lens:?}"
        );
        let desk = site.open("desk");
        let [own, foreign] = ["cam0", "cam1"].map(|id| {
            let settings = CameraSettings {
                gain: Some(2.0),
                ..CameraSettings::none(id.parse().expect("an id"))
            };
            let key = site.keys.config_camera(&settings.camera);
            put(&desk, &key, &encode(&settings).expect("a message"));
            let deadline = Instant::now() + PATIENCE;
            while asked(&desk, &key).is_empty() {
                assert!(Instant::now() < deadline, "no settings: {}", site.log());
            }
            key
        });
        assert_eq!(asked(&board, &own), [own]);
        assert_eq!(asked(&board, &foreign), [""; 0], "{profile:?}");
        assert_eq!(asked(&board, &everything), [""; 0], "{profile:?}");
        assert_eq!(asked(&board, &site.keys.all_fusion_statuses()), [""; 0]);
    }
}

/// A real camera node: it holds its name, is alive for others, and its status reaches late joiners.
#[test]
fn a_camera_node_lives_under_its_role() {
    for profile in PROFILES {
        let site = LockedSite::start(profile);
        let mut scenario = Scenario::demo(1, 1, 1);
        scenario.cameras[0].id = "cam0".to_owned();
        let write = |name: &str, text: &str| fs::write(site.path(name), text).expect("a file");
        sextant_site_files::write_toml(&site.path("scenario.toml"), &scenario).expect("a file");
        write(
            "camera.toml",
            &format!(
                "site = \"lab\"\ncamera = \"cam0\"\n[source]\nkind = \"simulator\"\n\
                 scenario = \"scenario.toml\"\n[network]\nconnect = [\"{}\"]\n[security]\n\
                 profile = \"{}\"\nkeys = \"authority/cam0\"\n[shared_memory]\nroot = \"i\"\n",
                site.connect,
                profile.name()
            ),
        );
        let screen = site.open("screen");
        let watch = screen.watch_alive(&site.keys.all_alive()).expect("a watch");
        let mut command = sextant();
        command
            .args(["camera", "--config"])
            .arg(site.path("camera.toml"));
        let mut node = command.spawn().expect("sextant starts");
        let id = NodeId::new("cam0").expect("an id");
        let alive = Presence::Joined(site.keys.alive(NodeKind::Camera, &id));
        let deadline = Instant::now() + PATIENCE;
        while watch.recv_timeout(Duration::from_millis(200)) != Some(alive.clone()) {
            assert!(Instant::now() < deadline, "never alive: {}", site.log());
        }
        let statuses = || {
            let key = site.keys.all_camera_statuses();
            let items = screen.latest(&key, limits::MAX_PAYLOAD_BYTES, QUESTION);
            items.expect("a question")
        };
        let status: CameraStatus = loop {
            assert!(Instant::now() < deadline, "no status: {}", site.log());
            if let Some(item) = statuses().first() {
                break item.decode().expect("a status");
            }
        };
        assert_eq!(status.camera.as_str(), "cam0");
        system_tests::send(node.id(), libc::SIGTERM);
        node.wait().expect("it ends");
    }
}

/// A client's options with more of zenoh's own.
fn client_with(site: &LockedSite, overrides: &[(&str, String)]) -> BusOptions {
    let overrides = overrides.iter();
    BusOptions {
        overrides: overrides
            .map(|(key, value)| ((*key).to_owned(), value.clone()))
            .collect(),
        ..BusOptions::client_of(&site.connect)
    }
}

#[test]
fn a_board_without_a_certificate_gets_no_connection() {
    let site = LockedSite::start(Profile::Site);
    let authority = format!("{:?}", site.authority().join("authority.pem"));
    let trusting = [("transport/link/tls/root_ca_certificate", authority)];
    let open = Security::none(Profile::Open);
    assert!(site.refuses(
        &client_with(&site, &trusting),
        &open,
        "connection refused: peer sent no certificates"
    ));
}

#[test]
fn a_board_of_another_authority_gets_no_connection() {
    let site = LockedSite::start(Profile::Site);
    let elsewhere = site.path("elsewhere");
    assert!(
        system_tests::keys(&["init", "--site", "lab"], &elsewhere)
            .status
            .success()
    );
    let added = system_tests::keys(&["add", "cam0", "--role", "camera"], &elsewhere);
    assert!(added.status.success());
    // It trusts this site's router nevertheless.
    let foreign = elsewhere.join("cam0");
    fs::copy(
        site.authority().join("authority.pem"),
        foreign.join("authority.pem"),
    )
    .expect("a copy");
    let words = "connection refused: invalid peer certificate";
    assert!(site.refuses(&client_with(&site, &[]), &keys_in(&site, &foreign), words));
}

#[test]
fn a_board_with_an_expired_certificate_gets_no_connection() {
    let site = LockedSite::start(Profile::Site);
    let expired = site.keys_of("cam0");
    expire(&site.authority(), &expired);
    let words = "connection refused: invalid peer certificate: certificate expired";
    assert!(site.refuses(&client_with(&site, &[]), &keys_in(&site, &expired), words));
    let cam1 = site.open("cam1");
    assert!(!asked(&cam1, &site.keys.config_rig()).is_empty());
    // A refusal says why, also within a runtime of its own.
    let runtime = tokio::runtime::Builder::new_current_thread().build();
    let options = client_with(&site, &[]);
    let why = async { why_no_router(&options, &keys_in(&site, &expired)) };
    let why = runtime.expect("a runtime").block_on(why);
    assert!(why.is_some_and(|why| why.contains("certificate expired")));
}

fn keys_in(site: &LockedSite, folder: &Path) -> Security {
    Security::of_client(&site.connect, Some(folder), "lab").expect("keys")
}

/// Signs the member's key anew, in the authority's name but by other code, with a certificate of the past.
fn expire(authority: &Path, member: &Path) {
    let read = |path: &Path| fs::read_to_string(path).expect("a file");
    let mut own = CertificateParams::default();
    own.distinguished_name = rcgen::DistinguishedName::new();
    own.distinguished_name
        .push(DnType::CommonName, "authority of sextant site lab");
    own.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    let key = KeyPair::from_pem(&read(&authority.join("authority.key"))).expect("a key");
    let issuer = Issuer::new(own, key);
    let mut params = CertificateParams::default();
    params.distinguished_name = rcgen::DistinguishedName::new();
    params.distinguished_name.push(DnType::CommonName, "cam0.1");
    params.not_before = date_time_ymd(2018, 1, 1);
    params.not_after = date_time_ymd(2020, 1, 1);
    let key = KeyPair::from_pem(&read(&member.join("key.pem"))).expect("a key");
    let certificate = params.signed_by(&key, &issuer).expect("a certificate");
    fs::write(member.join("certificate.pem"), certificate.pem()).expect("a file");
}

#[test]
fn a_board_without_a_password_gets_no_connection() {
    let site = LockedSite::start(Profile::Lab);
    let words = "connection refused: no user name and password";
    assert!(site.refuses(
        &client_with(&site, &[]),
        &Security::none(Profile::Demo),
        words
    ));
}

#[test]
fn a_board_with_a_wrong_password_gets_no_connection() {
    let site = LockedSite::start(Profile::Lab);
    fs::write(site.keys_of("cam0").join("password"), "guessed").expect("a file");
    let guessed = keys_in(&site, &site.keys_of("cam0"));
    assert!(site.refuses(
        &client_with(&site, &[]),
        &guessed,
        "connection refused: wrong password"
    ));
}

#[test]
fn a_revoked_board_reads_and_writes_nothing_and_its_name_can_be_given_anew() {
    let mut site = LockedSite::start(Profile::Site);
    let former = site.path("former");
    copy_folder(&site.keys_of("cam0"), &former);
    site.change_members(&["revoke", "cam0"]);
    site.change_members(&["add", "cam0", "--role", "camera"]);
    site.restart();
    let revoked = site.open_with(&former);
    let seen = site.scene.observe(0, 0.0, now_ns());
    publish(&revoked, &site.keys, &seen);
    assert_eq!(asked(&revoked, &site.keys.config_rig()), [""; 0]);
    assert!(site.log().contains("no member"), "{}", site.log());
    // The question was answered from behind the image: whatever arrives now is the new board's.
    let screen = site.open("screen");
    // Stays open until the image has arrived.
    let anew = site.open("cam0");
    publish(&anew, &site.keys, &seen);
    let status = site.await_status(&screen, |status| received(status, "cam0") > 0);
    assert_eq!(received(&status, "cam0"), 1);
    drop(anew);
}

fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        fs::copy(entry.path(), to.join(entry.file_name())).expect("a copy");
    }
}

#[test]
fn keys_of_another_are_refused_before_anything_runs() {
    let site = LockedSite::start(Profile::Site);
    let text = format!(
        "site = \"lab\"\ncamera = \"cam1\"\n[source]\nkind = \"images\"\nfolder = \".\"\n\
         [network]\nconnect = [\"{}\"]\n[security]\nprofile = \"site\"\nkeys = \"authority/cam0\"\n",
        site.connect
    );
    fs::write(site.path("camera.toml"), text).expect("a file");
    let mut command = sextant();
    let refused = command
        .args(["camera", "--config"])
        .arg(site.path("camera.toml"))
        .output()
        .expect("sextant runs");
    assert_eq!(refused.status.code(), Some(3));
    let words = String::from_utf8_lossy(&refused.stderr);
    assert!(
        words.contains("these are the keys of camera cam0"),
        "{words}"
    );
}
