//! The page's editor in a real browser, on a site of two fusion nodes: an edit is in force on both and in the files of
//! both, a wrong one is refused with its cause, and the last one is taken back.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_site_files::{read_object, read_rig};
use sextant_test_needs as needs;
use std::net::TcpStream;
use std::time::{Duration, Instant};
use system_tests::{House, PATIENCE, Scene, free_port, run_page_checks};

const NODES: [&str; 2] = ["first", "second"];

#[test]
fn an_edit_reaches_both_fusion_nodes_and_their_files() {
    if needs::PAGE.is_skipped() {
        return;
    }
    let scene = Scene::new(2, &["box", "cube"]);
    let mut house = House::new(&scene);
    let router = house.router("router", &[]);
    for node in NODES {
        house.fusion(node, &[&router]);
    }
    let listen = format!("127.0.0.1:{}", free_port());
    let text = format!(
        "site = \"lab\"\nlisten = \"{listen}\"\n[network]\nmode = \"client\"\nconnect = [\"{router}\"]\n"
    );
    house.node("viewer", "viewer", &text);
    let begun = Instant::now();
    while TcpStream::connect(&listen).is_err() {
        assert!(begun.elapsed() < PATIENCE, "the page is not served");
        std::thread::sleep(Duration::from_millis(50));
    }

    let camera = &scene.rig.cameras()[0];
    let [boxed, cube] = &scene.objects[..] else {
        panic!("the scene has two objects");
    };
    let taken = boxed.tags()[0].tag.id.to_string();
    let url = format!("http://{listen}");
    run_page_checks(
        "edit.mjs",
        &[
            &url,
            "--camera",
            camera.id.as_str(),
            "--object",
            cube.id().as_str(),
            "--taken",
            &taken,
        ],
    );

    for node in NODES {
        let rig = read_rig(&house.path(node, "rig.toml")).expect("a rig");
        let before = camera.world_from_camera.expect("a pose").translation;
        let after = rig.cameras()[0]
            .world_from_camera
            .expect("a pose")
            .translation;
        let moved = after.vector - before.vector;
        assert!((moved.x - 0.05).abs() < 1e-5, "{node}: moved by {moved}");
        assert!(moved.y.abs() < 1e-9, "{node}: moved by {moved}");
        assert_eq!(rig.cameras()[0].lens, camera.lens);
        assert_eq!(rig.cameras()[1], scene.rig.cameras()[1]);
        let object = read_object(&house.path(node, "cube.toml")).expect("an object");
        assert_eq!(object.tags()[0].size_m, 0.055, "{node}");
        assert_eq!(object.tags().len(), cube.tags().len(), "{node}");
        assert_eq!(object.tags()[1..], cube.tags()[1..], "{node}");
    }
}
