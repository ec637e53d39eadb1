//! A small recording of the simulator's, with rig and objects, in a folder of its own; and the program under test.

#![allow(
    dead_code,
    clippy::unwrap_used,
    reason = "each test file takes what it needs, and a test may panic"
)]

use sextant_recordings::{GreyImage, write_grey_png};
use sextant_simulator::{Renderer, Scenario, SceneCamera, SceneObject};
use sextant_site_files::{write_object, write_rig};
use sextant_site_model::{Camera, CameraId, ObjectId, ObjectModel, ObjectTag, Rig, TagId};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A folder with `rig.toml`, an object's file, and `<camera>/data.csv` with pictures.
pub struct Recording {
    folder: TempDir,
    pub scenario: Scenario,
    pub object: String,
}

impl Recording {
    /// Two cameras that watch one object, so many images each.
    pub fn new(images: u64) -> Self {
        Self::render_all(Scenario::demo(2, 1, 7), images)
    }

    /// The cameras of a scenario that watch its first object, so many images each.
    pub fn render_all(scenario: Scenario, images: u64) -> Self {
        let recording = Self::of_models(scenario);
        for camera in 0..recording.scenario.cameras.len() {
            recording.render(camera, images);
        }
        recording
    }

    /// The rig and the object alone.
    pub fn without_pictures() -> Self {
        Self::of_models(Scenario::demo(2, 1, 7))
    }

    fn of_models(scenario: Scenario) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let object = scenario.objects[0].id.clone();
        let cameras = scenario.cameras.iter().map(camera_of).collect();
        let rig = Rig::new(cameras).unwrap();
        write_rig(&folder.path().join("rig.toml"), &rig).unwrap();
        let model = object_of(&scenario.objects[0]);
        write_object(&folder.path().join("object.toml"), &model).unwrap();
        Self {
            folder,
            scenario,
            object,
        }
    }

    pub fn path(&self, below: &str) -> PathBuf {
        self.folder.path().join(below)
    }

    pub fn root(&self) -> &Path {
        self.folder.path()
    }

    pub fn camera(&self, camera: usize) -> &str {
        &self.scenario.cameras[camera].id
    }

    pub fn first_image(&self, camera: usize) -> PathBuf {
        let images = files_below(&self.path(self.camera(camera)).join("data"));
        images[0].clone()
    }

    fn render(&self, camera: usize, images: u64) {
        let mut renderer = Renderer::new(&self.scenario, camera).unwrap();
        let schedule = renderer.camera().schedule();
        let [width, height] = renderer.camera().resolution.map(|n| n as usize);
        let mut image = GreyImage {
            width,
            height,
            pixels: vec![0; width * height],
        };
        let folder = self.path(self.camera(camera));
        fs::create_dir_all(folder.join("data")).unwrap();
        let mut csv = "#timestamp [ns],filename,arrival [ns]\n".to_owned();
        for n in 0..images {
            let time_ns = schedule.next_at_or_after(1_000_000_000 + n * schedule.period_ns());
            renderer.render(time_ns, &mut image.pixels).unwrap();
            let name = format!("{time_ns}.png");
            write_grey_png(&folder.join("data").join(&name), &image).unwrap();
            let arrival_ns = time_ns + 8_000_000 + 100_000 * camera as u64;
            csv += &format!("{time_ns},{name},{arrival_ns}\n");
        }
        fs::write(folder.join("data.csv"), csv).unwrap();
    }

    /// `sextant replay` of a folder with this recording's rig and object.
    pub fn replay(&self, folder: &Path, more: &[&str]) -> Output {
        let mut command = sextant();
        command.arg("replay").arg(folder);
        command.arg("--rig").arg(self.path("rig.toml"));
        command.arg("--object").arg(self.path("object.toml"));
        command.args(more).output().unwrap()
    }
}

fn camera_of(camera: &SceneCamera) -> Camera {
    Camera::new(
        CameraId::new(&camera.id).unwrap(),
        camera.resolution,
        camera.lens,
        Some(camera.world_from_camera),
    )
}

fn object_of(object: &SceneObject) -> ObjectModel {
    let tags = object.tags.iter().map(|tag| {
        ObjectTag::new(
            TagId {
                family: tag.family,
                id: tag.id,
            },
            tag.size,
            Some(tag.object_from_tag),
        )
    });
    ObjectModel::new(ObjectId::new(&object.id).unwrap(), tags.collect()).unwrap()
}

/// The program under test.
pub fn sextant() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sextant"));
    command
        .env_remove("SEXTANT_CONNECT")
        .env_remove("SEXTANT_SITE");
    command
}

/// What it said, having succeeded.
pub fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{}", stderr(output));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// What it complained about.
pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Asserts the exit code and what the complaint says.
pub fn refused(output: &Output, code: i32, expected: &str) {
    let complaint = stderr(output);
    assert_eq!(output.status.code(), Some(code), "{complaint}");
    assert!(
        complaint.contains(expected),
        "{complaint}\nshould contain\n{expected}"
    );
    assert!(complaint.starts_with("error: "), "{complaint}");
}

/// Every file below a folder.
pub fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(files_below(&path));
        } else {
            files.push(path);
        }
    }
    files.sort();
    files
}
