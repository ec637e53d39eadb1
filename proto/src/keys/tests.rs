//! Keys as written and read.

use super::*;

fn keys() -> Keys {
    Keys::new("demo").unwrap()
}

#[test]
fn keys_are_as_the_contract_says() {
    let (camera, object) = (
        CameraId::new("north").unwrap(),
        ObjectId::new("cube").unwrap(),
    );
    let (keys, node) = (keys(), NodeId::new("main").unwrap());
    let root = "sextant/v1/demo/";
    for (made, expected) in [
        (keys.observations(&camera), "camera/north/observations"),
        (keys.preview(&camera), "camera/north/preview"),
        (keys.detection_report(&camera), "camera/north/detection"),
        (keys.camera_status(&camera), "camera/north/status"),
        (keys.pose(&object), "object/cube/pose"),
        (keys.truth(&object), "object/cube/truth"),
        (keys.fusion_status(&node), "fusion/main/status"),
        (keys.clocks(&node), "fusion/main/clocks"),
        (keys.inputs(&node), "fusion/main/inputs"),
        (keys.heartbeat(&node), "fusion/main/heartbeat"),
        (keys.config_answer(&node), "fusion/main/answer"),
        (keys.proposal(&node), "fusion/main/proposal"),
        (keys.former(&node), "fusion/main/former"),
        (keys.former_rig(&node), "fusion/main/former/rig"),
        (
            keys.former_object(&node, &object),
            "fusion/main/former/object/cube",
        ),
        (keys.config_rig(), "config/rig"),
        (keys.config_object(&object), "config/object/cube"),
        (keys.links(&object), "object/cube/links"),
        (keys.alive(NodeKind::Fusion, &node), "alive/fusion/main"),
    ] {
        assert_eq!(made, format!("{root}{expected}"));
    }
}

#[test]
fn every_key_is_read_back() {
    let keys = keys();
    let camera = CameraId::new("north").unwrap();
    let object = ObjectId::new("cube").unwrap();
    let node = NodeId::new("main").unwrap();
    for (key, expected) in [
        (
            keys.observations(&camera),
            KeyRef::Observations(camera.clone()),
        ),
        (keys.preview(&camera), KeyRef::Preview(camera.clone())),
        (
            keys.detection_report(&camera),
            KeyRef::DetectionReport(camera.clone()),
        ),
        (
            keys.camera_status(&camera),
            KeyRef::CameraStatus(camera.clone()),
        ),
        (keys.pose(&object), KeyRef::Pose(object.clone())),
        (keys.truth(&object), KeyRef::Truth(object.clone())),
        (
            keys.fusion_status(&node),
            KeyRef::FusionStatus(node.clone()),
        ),
        (keys.clocks(&node), KeyRef::Clocks(node.clone())),
        (keys.inputs(&node), KeyRef::Inputs(node.clone())),
        (keys.heartbeat(&node), KeyRef::Heartbeat(node.clone())),
        (
            keys.config_answer(&node),
            KeyRef::ConfigAnswer(node.clone()),
        ),
        (keys.proposal(&node), KeyRef::Proposal(node.clone())),
        (keys.former(&node), KeyRef::Former(node.clone())),
        (keys.former_rig(&node), KeyRef::FormerRig(node.clone())),
        (
            keys.former_object(&node, &object),
            KeyRef::FormerObject(node.clone(), object.clone()),
        ),
        (keys.config_rig(), KeyRef::ConfigRig),
        (
            keys.config_object(&object),
            KeyRef::ConfigObject(object.clone()),
        ),
        (keys.config_models(), KeyRef::ConfigModels),
        (
            keys.config_camera(&camera),
            KeyRef::ConfigCamera(camera.clone()),
        ),
        (keys.links(&object), KeyRef::Links(object.clone())),
        (
            keys.alive(NodeKind::Viewer, &node),
            KeyRef::Alive(NodeKind::Viewer, node.clone()),
        ),
    ] {
        assert_eq!(keys.parse(&key), Some(expected));
    }
}

#[test]
fn foreign_keys_stand_for_nothing() {
    for key in [
        "",
        "sextant/v1/demo",
        "sextant/v1/demo2/config/rig",
        "sextant/v2/demo/config/rig",
        "sextant/v1/demo/camera/North/status",
        "sextant/v1/demo/camera/north/status/more",
        "sextant/v1/demo/camera/*/status",
        "sextant/v1/demo/alive/robot/x",
        "sextant/v1/demo/config/full/rig",
        "sextant/v1/demo/fusion/main/former/object/cube/more",
    ] {
        assert_eq!(keys().parse(key), None, "{key}");
    }
}
