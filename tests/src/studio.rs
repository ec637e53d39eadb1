//! A studio without hardware: printed things on paths before simulated cameras, rendered into a recording as a person
//! would have taken it.

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};
use sextant_geometry::{Lens, Pose};
use sextant_recordings::{GreyImage, write_grey_png};
use sextant_simulator::{
    Background, Light, Path, Renderer, Scenario, SceneCamera, SceneObject, SceneTag, Solid,
};
use sextant_site_model::ObjectModel;
use std::fs;

/// Time of a studio's first image; any will do.
const START_NS: u64 = 1_700_000_000_000_000_000;

/// What is before the cameras.
#[derive(Debug, Clone)]
pub struct Studio {
    cameras: Vec<SceneCamera>,
    objects: Vec<SceneObject>,
}

/// How many images each camera takes, and how many a second.
#[derive(Debug, Clone, Copy)]
pub struct Shots {
    /// Of each camera.
    pub images: u32,
    /// All cameras fire together.
    pub rate_hz: f64,
}

impl Studio {
    /// Cameras by name, with their lenses and places.
    #[must_use]
    pub fn with_cameras<'a>(cameras: impl IntoIterator<Item = (&'a str, Lens, Pose)>) -> Self {
        Self {
            cameras: cameras
                .into_iter()
                .map(|(id, lens, pose)| camera(id, lens, pose))
                .collect(),
            objects: Vec::new(),
        }
    }

    /// A printed sheet on a stiff plate: its tags' face is the plate's upper side.
    #[must_use]
    pub fn and_sheet(self, model: &ObjectModel, path: Path) -> Self {
        let reach = |axis: usize| {
            let tags = model.tags().iter();
            let far = tags.filter_map(|tag| {
                Some(tag.object_from_tag?.translation.vector[axis].abs() + 0.65 * tag.size_m)
            });
            2.0 * far.fold(0.01, f64::max)
        };
        let plate = Solid::Box {
            size: [reach(0), reach(1), 0.004],
            object_from_box: Isometry3::translation(0.0, 0.0, -0.002),
            albedo: 0.9,
        };
        self.and(model, plate, path)
    }

    /// A folded cube.
    #[must_use]
    pub fn and_cube(self, model: &ObjectModel, edge_m: f64, path: Path) -> Self {
        let cube = Solid::Box {
            size: [edge_m; 3],
            object_from_box: Isometry3::identity(),
            albedo: 0.9,
        };
        self.and(model, cube, path)
    }

    fn and(mut self, model: &ObjectModel, solid: Solid, path: Path) -> Self {
        let tags = model.tags().iter().map(|tag| {
            let place = tag.object_from_tag.expect("printed things are known");
            SceneTag::new(tag.tag.family, tag.tag.id, tag.size_m, place)
        });
        self.objects.push(SceneObject {
            id: model.id().to_string(),
            solids: vec![solid],
            tags: tags.collect(),
            path,
        });
        self
    }

    /// Writes DIR/CAMERA/data.csv and the pictures beside it.
    ///
    /// # Panics
    /// When the scene is none or the folder cannot be written.
    pub fn record(&self, folder: &std::path::Path, shots: Shots) {
        let scenario = Scenario {
            seed: 7,
            start_ns: START_NS,
            light: Light::default(),
            background: Background::default(),
            cameras: self.cameras.clone(),
            objects: self.objects.clone(),
        };
        for (index, camera) in self.cameras.iter().enumerate() {
            let pictures = folder.join(&camera.id).join("data");
            fs::create_dir_all(&pictures).expect("the folder can be written");
            let mut renderer = Renderer::new(&scenario, index).expect("a scene");
            let mut rows = String::from("#timestamp [ns],filename\n");
            for at in 0..shots.images {
                let time_ns = taken_ns(at, shots);
                let picture = picture(&mut renderer, time_ns);
                let name = format!("{time_ns}.png");
                write_grey_png(&pictures.join(&name), &picture).expect("a picture is written");
                rows.push_str(&format!("{time_ns},{name}\n"));
            }
            fs::write(folder.join(&camera.id).join("data.csv"), rows).expect("a table is written");
        }
    }
}

fn picture(renderer: &mut Renderer, time_ns: u64) -> GreyImage {
    let [width, height] = renderer.camera().resolution.map(|pixels| pixels as usize);
    let mut pixels = vec![0; width * height];
    renderer
        .render(time_ns, &mut pixels)
        .expect("a picture of the right size");
    GreyImage {
        width,
        height,
        pixels,
    }
}

fn taken_ns(at: u32, shots: Shots) -> u64 {
    START_NS + (f64::from(at) / shots.rate_hz * 1e9) as u64
}

fn camera(id: &str, lens: Lens, world_from_camera: Pose) -> SceneCamera {
    SceneCamera {
        exposure_ns: 2_000_000,
        vignetting: 0.1,
        blur_px: 0.6,
        ..SceneCamera::new(id, [640, 480], lens, world_from_camera)
    }
}

/// The pose of a camera at a place that looks at a point, the world's up being up in its picture.
#[must_use]
pub fn looking_at(from: [f64; 3], at: [f64; 3]) -> Pose {
    let from = Vector3::from(from);
    let forward = (Vector3::from(at) - from).normalize();
    let right = forward
        .cross(&Vector3::z())
        .try_normalize(1e-6)
        .unwrap_or_else(Vector3::x);
    let axes = Rotation3::from_basis_unchecked(&[right, forward.cross(&right), forward]);
    Isometry3::from_parts(
        Translation3::from(from),
        UnitQuaternion::from_rotation_matrix(&axes),
    )
}
