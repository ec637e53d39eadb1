//! A layout for viewers: the room in 3D, the picture of each camera with its tags, the diagnostics.

use super::{DIAGNOSTICS, annotations};
use crate::compressed_image as image;
use serde_json::{Map, Value, json};
use sextant_site_model::{CameraId, ObjectId};

/// Most pictures of a layout; the others are chosen in the picture's settings.
const MOST_PICTURES: usize = 4;
const ROOM: &str = "3D!room";
const NODES: &str = "DiagnosticSummary!nodes";

/// The layout of a site, to be imported into Foxglove or Lichtblick.
#[must_use]
pub fn layout(cameras: &[CameraId], objects: &[ObjectId]) -> Value {
    let pictures = &cameras[..cameras.len().min(MOST_PICTURES)];
    let mut panels: Map<String, Value> = pictures
        .iter()
        .map(|camera| (picture_panel(camera), picture(camera)))
        .collect();
    panels.insert(ROOM.to_owned(), room(objects));
    panels.insert(
        NODES.to_owned(),
        json!({ "topicToRender": DIAGNOSTICS, "sortByLevel": true }),
    );
    let beside = pictures.iter().map(picture_panel);
    let beside = beside.chain([NODES.to_owned()]).map(Value::from);
    json!({
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": { "speed": 1 },
        "layout": {
            "direction": "row",
            "first": ROOM,
            "second": column(beside.collect()),
            "splitPercentage": 65,
        },
    })
}

fn picture_panel(camera: &CameraId) -> String {
    format!("Image!{camera}")
}

/// Panels one below the other, of equal heights.
fn column(panels: Vec<Value>) -> Value {
    let mut panels = panels.into_iter().rev();
    let last = panels.next().unwrap_or_default();
    let stacked = panels.fold((last, 1), |(below, n_below), panel| {
        let column = json!({
            "direction": "column",
            "first": panel,
            "second": below,
            "splitPercentage": 100.0 / f64::from(n_below + 1),
        });
        (column, n_below + 1)
    });
    stacked.0
}

fn room(objects: &[ObjectId]) -> Value {
    let shown = objects
        .iter()
        .flat_map(|object| ["tags", "ellipsoid"].map(|what| format!("/object/{object}/{what}")));
    let topics: Map<String, Value> = shown
        .map(|topic| (topic, json!({ "visible": true })))
        .collect();
    json!({
        "followTf": "world",
        "cameraState": {
            "perspective": true, "distance": 4.0, "phi": 60.0, "thetaOffset": 45.0,
            "targetOffset": [0.0, 0.0, 0.0], "target": [0.0, 0.0, 0.0], "targetOrientation": [0.0, 0.0, 0.0, 1.0],
            "fovy": 45.0, "near": 0.01, "far": 500.0,
        },
        "layers": { "grid": {
            "layerId": "foxglove.Grid", "instanceId": "grid", "visible": true, "size": 4.0, "divisions": 8,
        } },
        "topics": topics,
        "transforms": {},
    })
}

fn picture(camera: &CameraId) -> Value {
    json!({
        "imageMode": {
            "imageTopic": image::preview_topic(camera),
            "calibrationTopic": super::calibration_topic(camera),
            "annotations": { annotations::topic(camera): { "visible": true } },
            "synchronize": true,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panels(tree: &Value) -> Vec<String> {
        match tree {
            Value::String(panel) => vec![panel.clone()],
            _ => [&tree["first"], &tree["second"]]
                .into_iter()
                .flat_map(panels)
                .collect(),
        }
    }

    #[test]
    fn each_panel_has_a_place_and_each_place_a_panel() {
        let cameras: Vec<CameraId> = ["a", "b", "c", "d", "e"]
            .map(|name| CameraId::new(name).unwrap())
            .into();
        let objects = [ObjectId::new("cube").unwrap()];
        for n_cameras in 0..=cameras.len() {
            let layout = layout(&cameras[..n_cameras], &objects);
            let configured = layout["configById"].as_object().unwrap();
            let mut placed = panels(&layout["layout"]);
            placed.sort();
            assert_eq!(placed, configured.keys().cloned().collect::<Vec<_>>());
            assert_eq!(placed.len(), n_cameras.min(MOST_PICTURES) + 2);
        }
    }
}
