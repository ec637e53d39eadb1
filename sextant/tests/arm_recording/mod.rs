//! A recording of the simulator's arm: rig, object with links and joints, corners or pictures; and what is true of it.

#![allow(clippy::unwrap_used, reason = "a test that fails to unwrap has failed")]

use sextant_geometry::Pose;
use sextant_recordings::{GreyImage, write_grey_png};
use sextant_simulator::{Observer, Random, Renderer, Scenario, Visibility};
use sextant_site_files::{write_object, write_rig};
use sextant_site_model::{
    Articulation, Camera, CameraId, Joint, JointId, JointKind, LinkId, ObjectId, ObjectModel,
    ObjectTag, Rig, TagId,
};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// The links, in the order of the scenario's objects.
pub const LINKS: [&str; 3] = ["base", "upper", "fore"];
const START_NS: u64 = 1_000_000_000;

pub struct Arm {
    folder: TempDir,
    pub scenario: Scenario,
}

impl Arm {
    pub fn new(cameras: usize, seed: u64) -> Self {
        let arm = Self {
            folder: tempfile::tempdir().unwrap(),
            scenario: Scenario::arm(cameras, seed),
        };
        let camera = |camera: &sextant_simulator::SceneCamera| {
            Camera::new(
                CameraId::new(&camera.id).unwrap(),
                camera.resolution,
                camera.lens,
                Some(camera.world_from_camera),
            )
        };
        let rig = Rig::new(arm.scenario.cameras.iter().map(camera).collect()).unwrap();
        write_rig(&arm.path("rig.toml"), &rig).unwrap();
        write_object(&arm.path("arm.toml"), &model(&arm.scenario)).unwrap();
        arm
    }

    pub fn path(&self, below: &str) -> PathBuf {
        self.folder.path().join(below)
    }

    pub fn world_from_link(&self, link: usize, t_ns: u64) -> Pose {
        self.scenario.objects[link].world_from_object(t_ns)
    }

    pub fn joint_values(&self, t_ns: u64) -> Vec<f64> {
        self.scenario.objects[2].path.joint_values(t_ns)
    }

    /// The corners that each camera sees, with their noise; `shows` says which links do, by seconds after the start.
    pub fn write_corners(&self, images: u64, sigma_px: f64, shows: fn(usize, f64) -> bool) {
        let mut observer = Observer::new(&self.scenario, Visibility::default()).unwrap();
        let mut random = Random::from_keys(&[5]);
        for (camera, scene) in self.scenario.cameras.iter().enumerate() {
            let schedule = scene.schedule();
            let mut text = String::new();
            for n in 0..images {
                let t_ns = schedule.next_at_or_after(START_NS + n * schedule.period_ns());
                let seconds = (t_ns - START_NS) as f64 * 1e-9;
                let seen = observer.observe(camera, t_ns, sigma_px, &mut random);
                let tags = seen.iter().filter(|tag| shows(tag.object, seconds));
                let tags = tags.map(|tag| {
                    let corners = tag.corners.map(|corner| [corner.x, corner.y]);
                    serde_json::json!({"family": tag.family, "id": tag.id, "corners": corners, "sigma_px": sigma_px})
                });
                let tags: Vec<_> = tags.collect();
                let line = serde_json::json!({"t_ns": t_ns, "detections": tags});
                text += &format!("{line}\n");
            }
            fs::create_dir_all(self.path(&scene.id)).unwrap();
            fs::write(self.path(&scene.id).join("detections.jsonl"), text).unwrap();
        }
    }

    /// The pictures that each camera takes.
    pub fn write_pictures(&self, images: u64) {
        for camera in 0..self.scenario.cameras.len() {
            let mut renderer = Renderer::new(&self.scenario, camera).unwrap();
            let schedule = renderer.camera().schedule();
            let folder = self.path(&renderer.camera().id);
            let [width, height] = renderer.camera().resolution.map(|n| n as usize);
            let mut image = GreyImage {
                width,
                height,
                pixels: vec![0; width * height],
            };
            fs::create_dir_all(folder.join("data")).unwrap();
            let mut csv = "#timestamp [ns],filename\n".to_owned();
            for n in 0..images {
                let t_ns = schedule.next_at_or_after(START_NS + n * schedule.period_ns());
                renderer.render(t_ns, &mut image.pixels).unwrap();
                write_grey_png(&folder.join("data").join(format!("{t_ns}.png")), &image).unwrap();
                csv += &format!("{t_ns},{t_ns}.png\n");
            }
            fs::write(folder.join("data.csv"), csv).unwrap();
        }
    }

    /// The lines of `sextant replay`.
    pub fn replay(&self) -> Vec<serde_json::Value> {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sextant"));
        let run = command
            .arg("replay")
            .arg(self.folder.path())
            .arg("--rig")
            .arg(self.path("rig.toml"))
            .arg("--object")
            .arg(self.path("arm.toml"))
            .output()
            .unwrap();
        assert!(
            run.status.success(),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        let text = String::from_utf8(run.stdout).unwrap();
        text.lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    }

    #[allow(dead_code, reason = "for looking at it")]
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }
}

/// What a site would have in its object file.
fn model(scenario: &Scenario) -> ObjectModel {
    let link = |index: usize| LinkId::new(LINKS[index]).unwrap();
    let joints = scenario.objects[2].path.joints.iter().enumerate();
    let joints = joints.map(|(index, joint)| Joint {
        id: JointId::new(&joint.id).unwrap(),
        kind: JointKind::Revolute,
        parent: link(index),
        child: link(index + 1),
        axis: joint.axis.into(),
        parent_from_joint: joint.parent_from_joint,
        limits: Some(joint.limits),
        max_speed: None,
    });
    let tree = Articulation::new((0..3).map(link).collect(), joints.collect()).unwrap();
    let tags = scenario
        .objects
        .iter()
        .enumerate()
        .flat_map(|(index, object)| {
            object.tags.iter().map(move |tag| {
                let (family, id) = (tag.family, tag.id);
                let place = Some(tag.object_from_tag);
                ObjectTag {
                    link: Some(LinkId::new(LINKS[index]).unwrap()),
                    ..ObjectTag::new(TagId { family, id }, tag.size, place)
                }
            })
        });
    ObjectModel::articulated(ObjectId::new("arm").unwrap(), tree, tags.collect()).unwrap()
}
