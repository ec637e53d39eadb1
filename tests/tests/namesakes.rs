//! Two fusion nodes of one name would publish the same poses beside each other: the second is refused.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_process::host::host_name;
use system_tests::{FusedSite, Scene, sextant};

#[test]
fn a_second_fusion_node_of_one_name_is_refused_and_one_of_another_name_is_not() {
    let scene = Scene::new(2, &["box"]);
    let site = FusedSite::start(&scene.rig, &scene.objects, "");
    let file = site.path("second.toml");
    let write = |node: &str| {
        let text = format!(
            "site = \"lab\"\nnode = \"{node}\"\nrig = \"rig.toml\"\n[network]\nconnect = [\"{}\"]\nmode = \"client\"\n",
            site.connect
        );
        std::fs::write(&file, text).expect("the folder can be written");
    };
    let second = || {
        let mut command = sextant();
        command.args(["fusion", "--config"]).arg(&file);
        command
    };
    write("fusion");
    let refused = second().output().expect("sextant runs");
    assert_eq!(refused.status.code(), Some(4));
    let words = String::from_utf8_lossy(&refused.stderr);
    let expected = format!("fusion fusion runs on host {} already", host_name());
    assert!(words.contains(&expected), "{words}");

    write("spare");
    let mut spare = second().spawn().expect("sextant runs");
    site.await_status(|status| status.node.as_str() == "spare");
    spare.kill().expect("it runs");
    spare.wait().expect("it ends");
}
