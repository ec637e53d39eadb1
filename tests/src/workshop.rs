//! A simulated workshop: three cameras along a wall, a printed board held in front of them, and a cube that is turned.
//! It has corners without images, so that minutes of use take seconds.

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use sextant_calibrator::PrintedGrid;
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_proto::{ClockQuality, ClockSource, Observations, TagObservation, Timing};
use sextant_simulator::{
    Background, Harmonic, Light, Observer, Occlusion, Path, Random, Scenario, SceneCamera,
    SceneObject, SceneTag, Solid, Visibility, Wave,
};
use sextant_site_model::{Camera, CameraId, ObjectId, ObjectModel, ObjectTag, Rig, TagId};
use sextant_tag_families::Family;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Corner noise of good images, pixels.
const SIGMA_PX: f64 = 0.05;
/// Edge of the cube and of its tags, metres.
const EDGE_M: f64 = 0.06;
const TAG_M: f64 = 0.048;
/// The first tag of the cube.
pub const FIRST_OF_CUBE: u32 = 40;
const PERIOD_S: f64 = 60.0;

/// The board, as it was printed.
pub const BOARD: PrintedGrid = PrintedGrid {
    columns: 4,
    rows: 3,
    size_m: 0.04,
    family: Family::Tag36h11,
    first: 0,
};

/// The workshop, and an observer in it.
pub struct Workshop {
    scenario: Scenario,
    observer: Observer,
    random: Random,
}

impl Default for Workshop {
    /// # Panics
    /// If the scene is invalid.
    fn default() -> Self {
        let scenario = Scenario {
            seed: 1,
            start_ns: 0,
            light: Light::default(),
            background: Background::default(),
            cameras: vec![
                camera("left", -0.35),
                camera("middle", 0.0),
                camera("right", 0.35),
            ],
            objects: vec![board(), cube()],
        };
        let visibility = Visibility {
            occlusion: Occlusion::Ignored,
            ..Visibility::default()
        };
        Self {
            observer: Observer::new(&scenario, visibility).expect("a scene"),
            random: Random::from_keys(&[7]),
            scenario,
        }
    }
}

impl Workshop {
    /// The true rig.
    ///
    /// # Panics
    /// If it is invalid.
    #[must_use]
    pub fn rig(&self) -> Rig {
        let cameras = self.scenario.cameras.iter().map(|camera| {
            Camera::new(
                CameraId::new(&camera.id).expect("an id"),
                camera.resolution,
                camera.lens,
                Some(camera.world_from_camera),
            )
        });
        Rig::new(cameras.collect()).expect("a rig")
    }

    /// The true cube.
    ///
    /// # Panics
    /// If it is invalid.
    #[must_use]
    pub fn cube(&self) -> ObjectModel {
        let tags = self.scenario.objects[1].tags.iter().map(|tag| {
            ObjectTag::new(
                TagId {
                    family: tag.family,
                    id: tag.id,
                },
                tag.size,
                Some(tag.object_from_tag),
            )
        });
        ObjectModel::new(ObjectId::new("cube").expect("an id"), tags.collect()).expect("an object")
    }

    /// Observations of all cameras `seconds` after the start, with these times.
    ///
    /// # Panics
    /// When a camera has no name.
    pub fn observe(&mut self, seconds: f64, sequence: u64, capture_ns: u64) -> Vec<Observations> {
        let true_ns = (seconds * 1e9) as u64;
        let cameras = self.scenario.cameras.iter().enumerate();
        let images = cameras.map(|(at, camera)| {
            let seen = self
                .observer
                .observe(at, true_ns, SIGMA_PX, &mut self.random);
            Observations {
                camera: CameraId::new(&camera.id).expect("an id"),
                sequence,
                capture_ns,
                exposure_ns: 0,
                clock: ClockQuality {
                    source: ClockSource::Unknown,
                    error_ns: 0,
                },
                resolution: camera.resolution.map(|pixels| pixels as u16),
                timing: Timing::default(),
                tags: seen.iter().map(observation).collect(),
            }
        });
        images.collect()
    }
}

fn observation(seen: &sextant_simulator::ObservedTag) -> TagObservation {
    let variance = SIGMA_PX.powi(2) as f32;
    TagObservation {
        family: seen.family,
        id: seen.id,
        hamming: 0,
        margin: 60.0,
        corners: seen
            .corners
            .map(|corner| [corner.x as f32, corner.y as f32]),
        corner_covariance: [[variance, 0.0, variance]; 4],
        corner_cross_covariance: [[0.0; 4]; 6],
        poses: Vec::new(),
    }
}

/// A camera on the wall that looks at the centre of the workshop; each has another lens.
fn camera(name: &str, x: f64) -> SceneCamera {
    let place = Vector3::new(x, -0.62, 0.04 + 0.1 * x);
    let forward = -place.normalize();
    let right = forward.cross(&Vector3::z()).normalize();
    let axes = Matrix3::from_columns(&[right, forward.cross(&right), forward]);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let intrinsics = Intrinsics {
        fx: 610.0 + 20.0 * x,
        fy: 612.0 + 20.0 * x,
        cx: 322.5,
        cy: 236.0,
    };
    let lens = Lens::brown_conrady(intrinsics, [-0.11, 0.05, 3e-4, -2e-4, 0.0]).expect("a lens");
    let world_from_camera = Pose::from_parts(place.into(), turn);
    SceneCamera {
        exposure_ns: 2_000_000,
        vignetting: 0.1,
        noise: 1.5,
        ..SceneCamera::new(name, [640, 480], lens, world_from_camera)
    }
}

/// Swings of these orders and amplitudes about a mean.
fn wave(mean: f64, swings: &[(u32, f64)]) -> Wave {
    let harmonic = |&(order, amplitude): &(u32, f64)| Harmonic {
        order,
        amplitude,
        phase: f64::from(order) % TAU,
    };
    Wave {
        mean,
        harmonics: swings.iter().map(harmonic).collect(),
    }
}

/// The board: its face towards the wall, carried to every edge of the middle camera's picture and tilted every way.
fn board() -> SceneObject {
    let model = BOARD.object("board").expect("a board");
    let tags = model.tags().iter().map(|tag| {
        let place = tag.object_from_tag.expect("a place");
        SceneTag::new(tag.tag.family, tag.tag.id, tag.size_m, place)
    });
    SceneObject {
        id: "board".to_owned(),
        solids: vec![Solid::Box {
            size: [0.22, 0.17, 0.01],
            object_from_box: Isometry3::translation(0.0, 0.0, -0.005),
            albedo: 0.8,
        }],
        tags: tags.collect(),
        path: Path {
            period_s: PERIOD_S,
            turns: 0,
            position: [
                wave(0.0, &[(7, 0.24), (3, 0.04)]),
                wave(0.0, &[(5, 0.12)]),
                wave(0.0, &[(11, 0.17), (2, 0.03)]),
            ],
            yaw: wave(0.0, &[(13, 0.5)]),
            pitch: wave(0.0, &[(4, 0.2)]),
            roll: wave(FRAC_PI_2, &[(17, 0.5)]),
            joints: Vec::new(),
            events: Vec::new(),
        },
    }
}

/// The cube: turned over and over.
fn cube() -> SceneObject {
    let sides = [
        (0.0, 0.0),
        (FRAC_PI_2, 0.0),
        (PI, 0.0),
        (-FRAC_PI_2, 0.0),
        (0.0, FRAC_PI_2),
        (0.0, -FRAC_PI_2),
    ];
    let tag = |(id, (about_x, about_y)): (u32, (f64, f64))| {
        let turn = UnitQuaternion::from_euler_angles(about_x, about_y, 0.0);
        let place = turn * Vector3::new(0.0, 0.0, EDGE_M / 2.0);
        let object_from_tag = Pose::from_parts(place.into(), turn);
        SceneTag::new(Family::Tag36h11, id, TAG_M, object_from_tag)
    };
    SceneObject {
        id: "cube".to_owned(),
        solids: vec![Solid::Box {
            size: [EDGE_M; 3],
            object_from_box: Isometry3::identity(),
            albedo: 0.5,
        }],
        tags: (FIRST_OF_CUBE..).zip(sides).map(tag).collect(),
        path: Path {
            period_s: PERIOD_S,
            turns: 3,
            position: [
                wave(0.0, &[(3, 0.14)]),
                wave(-0.05, &[(5, 0.1)]),
                wave(0.0, &[(4, 0.1)]),
            ],
            yaw: wave(0.0, &[]),
            pitch: wave(0.0, &[(2, 1.2)]),
            roll: wave(0.0, &[(1, 3.0)]),
            joints: Vec::new(),
            events: Vec::new(),
        },
    }
}
