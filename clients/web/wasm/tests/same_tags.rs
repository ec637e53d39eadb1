//! WebAssembly finds the tags that this processor finds, with corners within 0.001 px, and encodes the messages that
//! Rust decodes.

#![allow(clippy::unwrap_used, reason = "a test ends by panicking")]

use serde_json::{Value, json};
use sextant_apriltag::Options;
use sextant_geometry::{Intrinsics, Lens};
use sextant_proto::{CameraStatus, Observations, Preview, decode};
use sextant_simulator::{Renderer, Scenario};
use sextant_test_needs as needs;
use sextant_web::vision::{Search, Vision};
use std::fs;
use std::path::Path;
use std::process::Command;

const SIZES: [[u32; 2]; 2] = [[640, 480], [1920, 1080]];
const INSTANTS: u64 = 6;

/// A demo's camera with so many pixels.
fn scenario(seed: u64, size: [u32; 2]) -> Scenario {
    let mut scenario = Scenario::demo(1, 2, seed);
    let camera = &mut scenario.cameras[0];
    let [width, height] = size.map(f64::from);
    let scale = width / f64::from(camera.resolution[0]);
    let [cx, cy] = [(width - 1.0) / 2.0, (height - 1.0) / 2.0];
    let Intrinsics { fx, fy, .. } = camera.lens.intrinsics();
    let [fx, fy] = [fx * scale, fy * scale];
    camera.lens = Lens::pinhole(Intrinsics { fx, fy, cx, cy }).unwrap();
    camera.resolution = size;
    scenario
}

/// Writes rendered images into the folder; returns what is found in them here.
fn render(folder: &Path) -> Vec<Value> {
    let mut images = Vec::new();
    for (seed, size) in (1..=2).flat_map(|seed| SIZES.map(|size| (seed, size))) {
        let scenario = scenario(seed, size);
        let [width, height] = size.map(|n| n as usize);
        let mut renderer = Renderer::new(&scenario, 0).unwrap();
        let mut vision = Vision::new(Options::default(), Search::Whole).unwrap();
        for instant in 0..INSTANTS {
            let mut pixels = vec![0; width * height];
            renderer.render(instant * 700_000_000, &mut pixels).unwrap();
            let tags = vision.detect(&pixels, [width, height], width).unwrap();
            let tags = tags.iter().map(|tag| {
                json!({ "family": tag.family, "id": tag.id, "hamming": tag.hamming, "corners": tag.corners })
            });
            let tags: Vec<Value> = tags.collect();
            let file = format!("{seed}-{width}-{instant}.grey");
            fs::write(folder.join(&file), pixels).unwrap();
            images.push(json!({ "file": file, "width": width, "height": height, "tags": tags }));
        }
    }
    images
}

#[test]
fn web_assembly_finds_the_same_tags() {
    if needs::WEB.is_skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let images = render(folder.path());
    let n_tags = images
        .iter()
        .map(|image| image["tags"].as_array().unwrap().len());
    assert!(n_tags.sum::<usize>() > 60, "{images:?}");
    let file = folder.path().join("images.json");
    fs::write(file, Value::from(images).to_string()).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../test/same-tags.mjs");
    let node = Command::new("node").arg(script).arg(folder.path()).status();
    assert!(node.unwrap().success());
    let read = |name| fs::read(folder.path().join(name)).unwrap();
    let observations: Observations = decode(&read("observations.bin")).unwrap();
    assert_eq!(observations.camera.as_str(), "pocket");
    assert_eq!(observations.sequence, 7);
    assert_eq!(observations.capture_ns, 1_800_000_000_123_456_789);
    assert!(
        observations
            .tags
            .iter()
            .all(|tag| tag.corner_covariance[0][0] > 0.0)
    );
    assert!(!observations.tags.is_empty());
    let status: CameraStatus = decode(&read("status.bin")).unwrap();
    assert_eq!((status.host.as_str(), status.dropped), ("a phone", 3));
    let preview: Preview = decode(&read("preview.bin")).unwrap();
    assert_eq!(
        (preview.resolution, preview.jpeg),
        ([640, 480], vec![1, 2, 3])
    );
}
