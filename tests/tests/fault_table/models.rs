//! Rig and objects of a site on several fusion nodes: what one of them missed, and disks that are slow.

use super::*;
use sextant_geometry::{Intrinsics, Lens};
use sextant_proto::Notice;
use sextant_site_files::{read_rig, write_rig};
use sextant_site_model::Rig;
use sextant_site_report::Fault;
use std::process::Output;
use system_tests::SlowDisk;

/// How far off the former files are: all poses would be.
const OFF_M: f64 = 0.158;

/// A house whose files have the origin of the world at another place.
fn house_with_old_files(scene: &Scene) -> House {
    House::with_files(&scene.moved(OFF_M), scene)
}

/// `sextant config set rig` with the true rig, at this router.
fn set_true_rig(house: &House, router: &str) -> String {
    let file = house.path("main", "true.toml");
    write_rig(&file, &scene().rig).expect("a file");
    let file = file.display().to_string();
    said(
        house
            .command(router, &["config", "set", "rig", &file])
            .output(),
    )
}

fn said(output: std::io::Result<Output>) -> String {
    let output = output.expect("the command runs");
    let said = [&output.stdout[..], &output.stderr[..]].concat();
    String::from_utf8_lossy(&said).into_owned()
}

/// The files of a node hold the true rig.
fn await_true_files(house: &House, node: &str) {
    let deadline = Instant::now() + Duration::from_secs(20);
    let file = house.path(node, "rig.toml");
    while read_rig(&file).ok().as_ref() != Some(&scene().rig) {
        assert!(Instant::now() < deadline, "{node} has old files");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// A standby is cut off for 6 s, in which the rig is set. It is back, and the publisher is killed.
#[test]
fn a_standby_that_missed_a_change_does_not_publish_with_what_was_before() {
    let mut house = house_with_old_files(&scene());
    let router = house.router("router", &[]);
    let proxy = FaultProxy::start(&router);
    house.fusion("main", &[&router]);
    house.fusion("spare", &[&proxy.endpoint]);
    let feed = feed(&house, &ALL, &[&router], now_ns());
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 2);
    proxy.set(cut());
    std::thread::sleep(Duration::from_secs(3));
    let answer = set_true_rig(&house, &router);
    assert!(
        answer.contains("main: config/rig taken and kept"),
        "{answer}"
    );
    assert!(!answer.contains("spare"), "{answer}");
    let changed = Instant::now() + Duration::from_millis(50);
    std::thread::sleep(Duration::from_secs(3));
    proxy.set(Faults::default());
    await_true_files(&house, "spare");
    await_tracking(&house, &[&router], 2);
    let since = Instant::now();
    house.kill("main");
    std::thread::sleep(Duration::from_secs(2));
    let printed = said(house.command(&router, &["config", "get", "rig"]).output());
    let rig = sextant_site_files::parse_rig(std::path::Path::new("printed"), &printed);
    assert_eq!(rig.ok().as_ref(), Some(&scene().rig), "{printed}");
    let used = witness.used_since(changed);
    assert!(
        used.iter()
            .any(|sight| sight.at > since + Duration::from_secs(1))
    );
    assert_true(&house, &feed, &used);
    Figure {
        row: "a standby that missed a change of the rig",
        what: "publisher killed",
        value: longest_gap_ms(&witness.used_since(since), since),
        unit: "ms without a pose",
        at_most: 300.0,
    }
    .keep();
}

/// A spare with old files starts while the publisher stands still. They are put in force nowhere.
#[test]
fn a_spare_with_old_files_puts_them_in_force_nowhere() {
    let scene = scene();
    let mut house = House::new(&scene);
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    let feed = feed(&house, &ALL, &[&router], now_ns());
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 1);
    house.set_files(&scene.moved(OFF_M));
    house.signal("main", libc::SIGSTOP);
    let stopped = Instant::now();
    house.fusion("spare", &[&router]);
    std::thread::sleep(Duration::from_millis(1600).saturating_sub(stopped.elapsed()));
    house.signal("main", libc::SIGCONT);
    let continued = Instant::now();
    await_true_files(&house, "spare");
    await_tracking(&house, &[&router], 2);
    let since = Instant::now();
    house.kill("main");
    witness.await_pose(since + Duration::from_secs(1), |_| true);
    let all = witness.sights();
    assert_true(&house, &feed, &all);
    assert_epochs_increase(&all);
    Figure {
        row: "a spare with old files, publisher stopped for 1.6 s",
        what: "after it went on",
        value: longest_gap_ms(&witness.used_since(continued), continued),
        unit: "ms without a pose",
        at_most: 1000.0,
    }
    .keep();
}

/// The site falls into halves; in one of them the rig is set. Both have it when they hear each other again.
fn changed_in_one_half(is_it_publishers: bool) {
    let (site, _, publisher) = DividedSite::start(house_with_old_files(&scene()));
    let (house, [left, _]) = (&site.house, &site.routers);
    let witness = Witness::start(&house.keys, &[left]);
    let half = if is_it_publishers {
        publisher
    } else {
        1 - publisher
    };
    site.link.set(cut());
    std::thread::sleep(Duration::from_secs(2));
    let answer = set_true_rig(house, &site.routers[half]);
    assert!(answer.contains("taken and kept"), "{answer}");
    std::thread::sleep(Duration::from_secs(1));
    site.link.set(Faults::default());
    for node in HALVES {
        await_true_files(house, node);
    }
    let healed = Instant::now();
    house.await_statuses(&[left], one_publishes);
    witness.await_pose(healed + Duration::from_secs(1), |pose| {
        pose.state == State::Tracking
    });
    let used = witness.used_since(healed + Duration::from_millis(300));
    assert_true(house, &site.feeds[0], &used);
    assert_epochs_increase(&witness.sights());
}

#[test]
fn a_change_in_the_half_of_the_older_epoch_is_not_undone() {
    changed_in_one_half(true);
}

#[test]
fn a_change_in_the_half_of_the_newer_epoch_is_not_undone() {
    changed_in_one_half(false);
}

/// A standby stands still while the rig is set, and the publisher dies before the standby could fetch it. Nothing is
/// published as good, also by its next process, until a person decides.
#[test]
fn a_standby_that_stood_still_during_a_change_publishes_lost() {
    let mut house = house_with_old_files(&scene());
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    house.await_statuses(&[&router], |statuses| {
        let main = statuses.get("main");
        main.is_some_and(|status| status.epoch.is_some())
    });
    house.fusion("spare", &[&router]);
    let feed = feed(&house, &ALL, &[&router], now_ns());
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 2);
    house.signal("spare", libc::SIGSTOP);
    let answer = set_true_rig(&house, &router);
    assert!(answer.contains("taken and kept"), "{answer}");
    house.kill("main");
    let killed = Instant::now();
    house.signal("spare", libc::SIGCONT);
    let is_lost = |pose: &sextant_proto::ObjectPose| pose.state == State::Lost;
    for has_restarted in [false, true] {
        if has_restarted {
            house.kill("spare");
            house.restart("spare");
        }
        let since = Instant::now();
        witness.await_pose(since, is_lost);
        house.await_statuses(&[&router], |statuses| {
            let is_old = |notice: &Notice| matches!(notice, Notice::OldModels { .. });
            let spare = statuses.get("spare");
            spare.is_some_and(|status| status.notices.iter().any(is_old))
        });
        std::thread::sleep(lasting(5, 2));
    }
    // What was published before the change was of the former world.
    let used = witness.used_since(killed + Duration::from_millis(100));
    assert!(!used.is_empty() && used.iter().all(|sight| is_lost(&sight.pose)));
    let answer = set_true_rig(&house, &router);
    assert!(answer.contains("taken and kept"), "{answer}");
    let decided = Instant::now() + Duration::from_millis(500);
    witness.await_pose(decided, |pose| pose.state == State::Tracking);
    assert_true(&house, &feed, &witness.used_since(decided));
    Figure {
        row: "a standby that stood still during a change, publisher killed, standby restarted",
        what: "published as good",
        value: 0.0,
        unit: "poses by the former rig",
        at_most: 0.0,
    }
    .keep();
}

/// Both halves of a divided site change the rig, one of them more often. When they hear each other again, the change
/// that is set aside is reported, and brought back by the command that the notice names.
#[test]
fn a_change_that_is_set_aside_is_reported_and_brought_back() {
    let (site, ..) = DividedSite::start(house_with_old_files(&scene()));
    let (house, [left, right]) = (&site.house, &site.routers);
    site.link.set(cut());
    std::thread::sleep(Duration::from_secs(2));
    let answer = set_true_rig(house, left);
    assert!(answer.contains("taken and kept"), "{answer}");
    for off_m in [0.3, 0.31] {
        let file = house.path(HALVES[1], "moved.toml");
        write_rig(&file, &scene().moved(off_m).rig).expect("a file");
        let file = file.display().to_string();
        let answer = said(
            house
                .command(right, &["config", "set", "rig", &file])
                .output(),
        );
        assert!(answer.contains("taken and kept"), "{answer}");
    }
    site.link.set(Faults::default());
    let statuses = house.await_statuses(&[left], |statuses| {
        let is_reported = |notice: &Notice| matches!(notice, Notice::SetAside { .. });
        let main = statuses.get(HALVES[0]);
        main.is_some_and(|status| status.notices.iter().any(is_reported))
    });
    let words = statuses[HALVES[0]].notices.iter().map(ToString::to_string);
    let words = words.collect::<Vec<_>>().join("\n");
    assert!(words.contains("config revert --to main"), "{words}");
    assert!(words.contains("mm and 0.00 degrees away"), "{words}");
    let answer = said(
        house
            .command(left, &["config", "revert", "--to", HALVES[0]])
            .output(),
    );
    assert!(answer.contains("taken and kept"), "{answer}");
    for node in HALVES {
        await_true_files(house, node);
    }
    house.await_statuses(&[left], |statuses| {
        let is_reported = |notice: &Notice| matches!(notice, Notice::SetAside { .. });
        let mut all = statuses.values().flat_map(|status| &status.notices);
        !all.any(is_reported)
    });
    Figure {
        row: "changes in both halves of a divided site",
        what: "set aside and not reported",
        value: 0.0,
        unit: "changes",
        at_most: 0.0,
    }
    .keep();
}

/// A camera is set to twice the size that the rig has: as one that a person has changed, or whose driver chose another
/// mode.
#[test]
fn images_of_another_size_than_the_rigs_move_nothing() {
    let files = scene();
    let mut cameras = files.rig.cameras().to_vec();
    let pinhole = cameras[0].lens.intrinsics();
    let twice = |px: f64| 2.0 * px + 0.5;
    cameras[0].lens = Lens::pinhole(Intrinsics {
        fx: 2.0 * pinhole.fx,
        fy: 2.0 * pinhole.fy,
        cx: twice(pinhole.cx),
        cy: twice(pinhole.cy),
    })
    .expect("a lens");
    cameras[0].resolution = cameras[0].resolution.map(|side| 2 * side);
    let rig = Rig::new(cameras).expect("a rig");
    let seen = Scene::from_models(rig, files.objects.clone());
    let mut house = House::with_files(&files, &seen);
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    let feed = feed(&house, &ALL, &[&router], now_ns());
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 1);
    let first = &files.rig.cameras()[0].id;
    let is_named =
        |fault: &Fault| matches!(fault, Fault::ImageSize { camera, .. } if camera == first);
    await_main(&house, &router, |status| status.faults.iter().any(is_named));
    std::thread::sleep(lasting(30, 5));
    assert_true(&house, &feed, &witness.sights());
}

/// Each write to the disk takes seconds, and nothing waits for it.
#[test]
fn a_slow_disk_delays_no_pose() {
    let mut house = house_with_old_files(&scene());
    let router = house.router("router", &[]);
    let disk = SlowDisk::new();
    let wrapper = disk.wrapper();
    house.fusion_in(
        "main",
        &[&router],
        "",
        &wrapper.each_ref().map(String::as_str),
    );
    house.fusion("spare", &[&router]);
    let feed = feed(&house, &ALL, &[&router], now_ns());
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 2);
    let since = Instant::now();
    let answer = set_true_rig(&house, &router);
    assert!(
        since.elapsed() > Duration::from_millis(1400),
        "the disk is slow"
    );
    assert!(answer.contains("taken and kept"), "{answer}");
    let changed = Instant::now() + Duration::from_millis(50);
    await_true_files(&house, "spare");
    witness.await_pose(changed + Duration::from_secs(1), |_| true);
    let all = witness.used_since(since);
    Figure {
        row: "a disk that takes 0.7 s for each fsync",
        what: "the rig is set",
        value: longest_gap_ms(&all, since),
        unit: "ms without a pose",
        at_most: 150.0,
    }
    .keep();
    let epochs: BTreeSet<u64> = all.iter().map(|one| one.pose.epoch).collect();
    assert!(!is_full() || epochs.len() == 1, "{epochs:?}");
    assert_fresh(&all);
    assert_true(&house, &feed, &witness.used_since(changed));
}
