//! Edits of a site as people make them, and those that are refused.

use super::*;
use crate::wizard::samples;
use sextant_proto::{KeyRef, MountConfig, NodeId, ObjectConfig, RigConfig, encode};
use sextant_site_model::{CameraId, ObjectId};

/// The samples' site, with a fusion node.
fn site() -> SiteMirror {
    let mut site = samples::mirror();
    let node = NodeId::new("main").unwrap();
    site.handle_joined(1, NodeKind::Fusion, &node).unwrap();
    site
}

fn request(text: &str) -> EditRequest {
    EditRequest::parse(text.as_bytes()).unwrap()
}

fn camera_request(site: &SiteMirror, more: &str) -> EditRequest {
    let camera = site.camera_config(&CameraId::new("b").unwrap()).unwrap();
    let version = version_of_camera(camera);
    request(&format!(
        r#"{{"do":"edit_camera","camera":"b","version":"{version}",{more}}}"#
    ))
}

fn object_version(site: &SiteMirror) -> String {
    version_of(site.configs().next().unwrap())
}

fn object_request(site: &SiteMirror, more: &str) -> EditRequest {
    let version = object_version(site);
    request(&format!(
        r#"{{"do":"edit_object","object":"cube","version":"{version}",{more}}}"#
    ))
}

fn refused(request: &EditRequest, site: &SiteMirror) -> (Option<&'static str>, String) {
    let refusal = change(request, site).unwrap_err();
    (refusal.field, refusal.cause)
}

#[test]
fn an_edited_camera_changes_nothing_else_of_the_rig() {
    let site = site();
    let edit = camera_request(
        &site,
        r#""id":"north","pose":{"position":[1,2,4],"orientation":[0,0,0,1]},"sigma":{"position_m":0.001,"orientation_rad":0.002}"#,
    );
    let Ok(Outgoing::Rig(after)) = change(&edit, &site) else {
        panic!("an edited camera is a change of the rig");
    };
    let before = site.rig().unwrap();
    assert_eq!(after.cameras[0], before.cameras[0]);
    let camera = &after.cameras[1];
    assert_eq!(camera.id.as_str(), "north");
    assert_eq!(camera.world_from_camera.unwrap().position, [1.0, 2.0, 4.0]);
    assert_eq!(camera.world_from_camera_sigma.unwrap().position_m, 0.001);
    assert_eq!(camera.lens, before.cameras[1].lens);
}

#[test]
fn a_wrong_value_of_a_camera_is_named_at_its_field() {
    let site = site();
    let pose = r#""pose":{"position":[1,2,4],"orientation":[0,0,0,1]}"#;
    let cases = [
        (format!(r#""id":"North",{pose},"sigma":null"#), "id"),
        (format!(r#""id":"a",{pose},"sigma":null"#), "id"),
        (
            r#""id":"b","pose":{"position":[1,2,4e9],"orientation":[0,0,0,1]},"sigma":null"#
                .to_owned(),
            "position",
        ),
        (
            r#""id":"b","pose":{"position":[1,2,4],"orientation":[0,0,0,2]},"sigma":null"#
                .to_owned(),
            "orientation",
        ),
        (
            format!(r#""id":"b",{pose},"sigma":{{"position_m":3.0,"orientation_rad":0.1}}"#),
            "sigma",
        ),
    ];
    for (more, field) in cases {
        let (at, cause) = refused(&camera_request(&site, &more), &site);
        assert_eq!(at, Some(field), "{more}: {cause}");
        assert!(cause.len() > 15, "{cause}");
    }
}

#[test]
fn an_edit_of_an_older_version_is_refused() {
    let mut site = site();
    let edit = camera_request(&site, r#""id":"b","pose":null,"sigma":null"#);
    assert!(change(&edit, &site).is_ok());
    let mut rig = site.rig().unwrap().clone();
    rig.cameras[1].line_delay_s = Some(1e-5);
    let payload = encode(&rig).unwrap();
    site.handle(2, &KeyRef::ConfigRig, None, Ok(&payload))
        .unwrap();
    let (field, cause) = refused(&edit, &site);
    assert_eq!(field, None);
    assert!(cause.contains("newer version of camera b"), "{cause}");
}

#[test]
fn a_change_of_another_camera_does_not_make_an_edit_old() {
    let mut site = site();
    let edit = camera_request(&site, r#""id":"b","pose":null,"sigma":null"#);
    let mut rig = site.rig().unwrap().clone();
    rig.cameras[0].line_delay_s = Some(1e-5);
    let payload = encode(&rig).unwrap();
    site.handle(2, &KeyRef::ConfigRig, None, Ok(&payload))
        .unwrap();
    let Ok(Outgoing::Rig(after)) = change(&edit, &site) else {
        panic!("the edit is of the version in force");
    };
    assert_eq!(after.cameras[0].line_delay_s, Some(1e-5));
}

#[test]
fn edited_tags_replace_all_tags() {
    let site = site();
    let edit = object_request(
        &site,
        r#""id":"cube","tags":[{"family":"tag36h11","id":9,"size_m":0.05,"pose":null}]"#,
    );
    let Ok(Outgoing::Object(after)) = change(&edit, &site) else {
        panic!("an edited object is a change of the object");
    };
    assert_eq!(after.tags.len(), 1);
    assert_eq!((after.tags[0].id, after.tags[0].size_m), (9, 0.05));
}

#[test]
fn a_wrong_tag_is_named() {
    let site = site();
    let tag = |more: &str| format!(r#"{{"family":"tag36h11","size_m":0.05,"pose":null,{more}}}"#);
    let nine = tag(r#""id":9"#);
    let cases = [
        (String::new(), "at least one tag"),
        (tag(r#""id":587"#), "0 to 586"),
        (format!("{nine},{nine}"), "there twice"),
        (nine.replace("0.05", "0.0"), "between 0.001 and 100"),
        (nine.replace("tag36h11", "qr"), "unknown tag family"),
        (
            nine.replace(
                r#""pose":null"#,
                r#""pose":{"position":[0,0,0],"orientation":[0,0,1,1]}"#,
            ),
            "the length 1.4142",
        ),
    ];
    for (tags, expected) in cases {
        let edit = object_request(&site, &format!(r#""id":"cube","tags":[{tags}]"#));
        let (field, cause) = refused(&edit, &site);
        assert_eq!(field, Some("tags"), "{cause}");
        assert!(cause.contains(expected), "{cause}");
    }
}

#[test]
fn another_name_is_one_change_that_cameras_on_the_object_follow() {
    let mut site = site();
    let mut rig = site.rig().unwrap().clone();
    rig.cameras[1].mount = rig.cameras[1]
        .world_from_camera
        .take()
        .map(|pose| MountConfig {
            carrier: ObjectId::new("cube").unwrap(),
            carrier_from_camera: pose,
        });
    let payload = encode(&rig).unwrap();
    site.handle(2, &KeyRef::ConfigRig, None, Ok(&payload))
        .unwrap();
    let tags = r#""tags":[{"family":"tag36h11","id":9,"size_m":0.05,"pose":null}]"#;
    let edit = object_request(&site, &format!(r#""id":"box",{tags}"#));
    let Ok(Outgoing::Models(models)) = change(&edit, &site) else {
        panic!("a name is changed in one step");
    };
    let rig: RigConfig = models.rig_config().unwrap().unwrap();
    assert_eq!(
        rig.cameras[1].mount.as_ref().unwrap().carrier.as_str(),
        "box"
    );
    let objects: Vec<ObjectConfig> = models.object_configs().unwrap();
    assert!(objects[0].is_removal() && objects[0].id.as_str() == "cube");
    assert_eq!(objects[1].id.as_str(), "box");
}

#[test]
fn an_object_is_added_under_a_free_name_only() {
    let site = site();
    let add = |id: &str| {
        request(&format!(
            r#"{{"do":"edit_object","object":null,"version":null,"id":"{id}","tags":[{{"family":"tag36h11","id":9,"size_m":0.05,"pose":null}}]}}"#
        ))
    };
    assert!(matches!(
        change(&add("ball"), &site),
        Ok(Outgoing::Object(_))
    ));
    assert_eq!(refused(&add("cube"), &site).0, Some("id"));
}

#[test]
fn removals_name_what_they_saw() {
    let site = site();
    let version = object_version(&site);
    let remove = |version: &str| {
        request(&format!(
            r#"{{"do":"remove_object","id":"cube","version":"{version}"}}"#
        ))
    };
    let removed = change(&remove(&version), &site);
    assert!(matches!(removed, Ok(Outgoing::Object(object)) if object.is_removal()));
    assert!(change(&remove("0"), &site).is_err());
    let camera = camera_request(&site, r#""id":"b","pose":null,"sigma":null"#);
    let EditRequest::EditCamera(edit) = camera else {
        panic!("it edits a camera");
    };
    let text = format!(
        r#"{{"do":"remove_camera","id":"b","version":"{}"}}"#,
        edit.version
    );
    let Ok(Outgoing::Rig(rig)) = change(&request(&text), &site) else {
        panic!("a removed camera is a change of the rig");
    };
    assert_eq!(rig.cameras.len(), 1);
}

#[test]
fn without_a_fusion_node_nothing_is_published() {
    let site = samples::mirror();
    let edit = camera_request(&site, r#""id":"b","pose":null,"sigma":null"#);
    let (_, cause) = refused(&edit, &site);
    assert!(cause.contains("no fusion node runs"), "{cause}");
}
