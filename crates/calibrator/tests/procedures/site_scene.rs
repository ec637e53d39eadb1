//! Sites of which nothing but sizes is known: two objects carried about before four cameras with different lenses, with
//! imperfect corners.

use crate::scene::{Random, looking, object, tag};
use nalgebra::{Isometry3, Matrix2, Point2, Translation3, UnitQuaternion, Vector2, Vector3};
use sextant_calibrator::SitePlan;
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
use sextant_site_model::{Camera, CameraId, ImageObservation, ObjectModel, Rig, TagCorners};
use sextant_tag_families::Family;
use std::f64::consts::PI;

pub const SIZE_M: f64 = 0.05;
const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 480.0;

/// What is simulated.
#[derive(Clone, Copy)]
pub struct SiteKind {
    pub seconds: f64,
    pub rate_hz: f64,
    /// Whether each camera runs by itself; otherwise all are triggered together.
    pub is_free_running: bool,
    /// Standard deviation of the clocks, s.
    pub clock_s: f64,
    /// Time from the first to the last row, s.
    pub readout_s: f64,
    pub noise_px: f64,
    /// Share of the tags with a wrong corner.
    pub wrong: f64,
    /// Static tags in the room.
    pub n_still: u32,
}

impl SiteKind {
    pub const TRIGGERED: Self = Self {
        seconds: 60.0,
        rate_hz: 30.0,
        is_free_running: false,
        clock_s: 0.0,
        readout_s: 0.0,
        noise_px: 0.1,
        wrong: 0.005,
        n_still: 0,
    };
    pub const FREE: Self = Self {
        is_free_running: true,
        clock_s: 0.015,
        ..Self::TRIGGERED
    };
}

/// A simulated recording with its truth.
pub struct SimulatedSite {
    pub rig: Rig,
    /// Seconds to be added to each camera's stamps.
    pub clock_offsets_s: Vec<f64>,
    /// Of all cameras.
    pub line_delay_s: f64,
    pub objects: Vec<ObjectModel>,
    pub images: Vec<ImageObservation>,
}

impl SimulatedSite {
    pub fn plan(&self) -> SitePlan {
        let cameras = self.rig.cameras().iter();
        SitePlan {
            cameras: cameras.map(|c| (c.id.clone(), c.resolution)).collect(),
            families: vec![Family::Tag36h11],
            size_m: SIZE_M,
            sizes: Vec::new(),
            world: None,
            distances: Vec::new(),
        }
    }
}

/// A hand: slow waves of position and rotation vector.
struct Hand([[(f64, f64, f64); 3]; 6], Vector3<f64>);

impl Hand {
    fn new(random: &mut Random, middle: [f64; 3], speed: f64) -> Self {
        let mut waves = [[(0.0, 0.0, 0.0); 3]; 6];
        for (axis, waves) in waves.iter_mut().enumerate() {
            for (k, wave) in waves.iter_mut().enumerate() {
                let reach = [0.3, 0.3, 0.2, 1.0, 1.0, 1.0][axis] * [1.0, 0.5, 0.25][k];
                let rate = (0.1 + 0.25 * random.uniform()) * [1.0, 1.6, 2.4][k] * speed;
                *wave = (
                    reach * (0.7 + 0.6 * random.uniform()),
                    2.0 * PI * rate,
                    2.0 * PI * random.uniform(),
                );
            }
        }
        Self(waves, Vector3::from(middle))
    }

    fn at(&self, seconds: f64) -> Pose {
        let sum = |axis: usize| -> f64 {
            let waves = self.0[axis].iter();
            waves
                .map(|(a, w, phase)| a * (w * seconds + phase).sin())
                .sum()
        };
        let position = Vector3::new(sum(0), sum(1), sum(2)) + self.1;
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(sum(3), sum(4), sum(5)));
        Isometry3::from_parts(Translation3::from(position), turn)
    }
}

fn cameras(random: &mut Random) -> Vec<Camera> {
    let camera = |at: usize| {
        let angle = 2.0 * PI * at as f64 / 4.0 + 0.4 + 0.2 * random.uniform();
        let field = (50.0 + 40.0 * random.uniform()).to_radians();
        let focal = WIDTH / 2.0 / (field / 2.0).tan();
        // So far that everything is in the picture.
        let radius = 0.6 * focal / 330.0 * (0.9 + 0.2 * random.uniform());
        let from = [
            radius * angle.cos(),
            radius * angle.sin(),
            (0.4 + 0.3 * random.uniform()) * radius,
        ];
        let numbers = Intrinsics {
            fx: focal,
            fy: focal * (1.0 + 0.002 * random.normal()),
            cx: 319.5 + 6.0 * random.normal(),
            cy: 239.5 + 6.0 * random.normal(),
        };
        let strength = focal / 600.0;
        let distortion = [
            (-0.15 + 0.08 * random.normal()) * strength.min(1.0),
            0.03 * random.normal() * strength.min(1.0),
            3e-4 * random.normal(),
            3e-4 * random.normal(),
            0.0,
        ];
        Camera::new(
            CameraId::new(["a", "b", "c", "d"][at]).unwrap(),
            [WIDTH as u32, HEIGHT as u32],
            Lens::brown_conrady(numbers, distortion).unwrap(),
            Some(looking(from, [0.0, 0.0, 0.0])),
        )
    };
    (0..4).map(camera).collect()
}

/// A cube of 7 cm with six tags, glued by hand, and a body of seven tags.
fn objects(random: &mut Random) -> Vec<ObjectModel> {
    let mut shaken = |pose: Pose| {
        let mut normal = |sigma: f64| Vector3::from_fn(|_, _| sigma * random.normal());
        pose * Isometry3::new(normal(0.001), normal(0.02))
    };
    let turns = [
        [0.0, 0.0, 0.0],
        [0.0, PI / 2.0, 0.0],
        [0.0, PI, 0.0],
        [0.0, -PI / 2.0, 0.0],
        [PI / 2.0, 0.0, 0.0],
        [-PI / 2.0, 0.0, 0.0],
    ];
    let cube = turns.iter().enumerate().map(|(at, turn)| {
        let face = Isometry3::new(Vector3::zeros(), Vector3::from(*turn));
        let pose = face * Isometry3::translation(0.0, 0.0, 0.035);
        (at as u32, SIZE_M, shaken(pose))
    });
    let cube = object("object-0", cube.collect::<Vec<_>>().into_iter());
    let body = (0..7).map(|at| {
        let pose = if at == 6 {
            Isometry3::translation(0.0, 0.0, 0.05)
        } else {
            let around = Isometry3::new(Vector3::zeros(), Vector3::z() * f64::from(at) * PI / 3.0);
            let lean = Isometry3::new(Vector3::zeros(), Vector3::y() * 1.25);
            around * lean * Isometry3::translation(0.0, 0.0, 0.06)
        };
        (10 + at, SIZE_M, shaken(pose))
    });
    let body = object("object-10", body.collect::<Vec<_>>().into_iter());
    vec![cube, body]
}

/// The recording of a kind of site.
pub fn site(kind: SiteKind, seed: u64) -> SimulatedSite {
    let mut random = Random::new(seed);
    let cameras = cameras(&mut random);
    let objects = objects(&mut random);
    let hands = [
        Hand::new(&mut random, [0.05, 0.06, 0.02], 1.0),
        Hand::new(&mut random, [-0.06, -0.05, -0.02], 1.3),
    ];
    let still: Vec<(u32, Pose)> = (0..kind.n_still)
        .map(|at| {
            let place = Vector3::new(0.18 * f64::from(at) - 0.18, 0.12 * random.normal(), -0.2);
            (
                30 + at,
                Isometry3::new(place, Vector3::z() * random.normal()),
            )
        })
        .collect();
    let mut images = Vec::new();
    let mut clock_offsets_s = Vec::new();
    for (at, camera) in cameras.iter().enumerate() {
        let rate = kind.rate_hz
            * if kind.is_free_running {
                1.0 + 0.06 * (random.uniform() - 0.5)
            } else {
                1.0
            };
        let phase = if kind.is_free_running {
            random.uniform() / rate
        } else {
            0.0
        };
        let ahead = if at == 0 {
            0.0
        } else {
            kind.clock_s * random.normal()
        };
        clock_offsets_s.push(ahead);
        for n in 0..(kind.seconds * rate) as u32 {
            let seconds = phase + f64::from(n) / rate;
            let mut tags = Vec::new();
            for (object, hand) in objects.iter().zip(&hands) {
                for own in object.tags() {
                    let pose = own.object_from_tag.unwrap();
                    let place = |t: f64| hand.at(t) * pose;
                    tags.extend(seen(camera, own.tag.id, &place, seconds, kind, &mut random));
                }
            }
            for (id, pose) in &still {
                tags.extend(seen(camera, *id, &|_| *pose, seconds, kind, &mut random));
            }
            images.push(ImageObservation {
                camera: camera.id.clone(),
                capture_ns: 1_000_000_000 + ((seconds + ahead) * 1e9).round() as u64,
                clock_error_ns: ImageObservation::CLOCK_ERROR_UNKNOWN,
                exposure_ns: 0,
                resolution: None,
                tags,
            });
        }
    }
    images.sort_by_key(|image| (image.capture_ns, image.camera.clone()));
    SimulatedSite {
        rig: Rig::new(cameras).unwrap(),
        clock_offsets_s,
        line_delay_s: kind.readout_s / HEIGHT,
        objects,
        images,
    }
}

/// A tag in an image, row by row at its own time; `None` where it is not seen.
fn seen(
    camera: &Camera,
    id: u32,
    world_from_tag: &dyn Fn(f64) -> Pose,
    seconds: f64,
    kind: SiteKind,
    random: &mut Random,
) -> Option<TagCorners> {
    let camera_from_world = camera.world_from_camera.unwrap().inverse();
    let camera_from_tag = camera_from_world * world_from_tag(seconds);
    let centre = camera_from_tag.translation.vector;
    let normal = camera_from_tag.rotation * Vector3::z();
    if -normal.dot(&centre.normalize()) < 0.26 || centre.z < 0.1 {
        return None;
    }
    let mut corners = [Point2::origin(); 4];
    for (corner, in_tag) in corners.iter_mut().zip(tag_corners_in_tag(SIZE_M)) {
        let mut pixel = camera.lens.project(&(camera_from_tag * in_tag))?;
        for _ in 0..if kind.readout_s > 0.0 { 4 } else { 0 } {
            let late = kind.readout_s * ((pixel.y + 0.5) / HEIGHT - 0.5);
            let pose = camera_from_world * world_from_tag(seconds + late);
            pixel = camera.lens.project(&(pose * in_tag))?;
        }
        *corner = pixel;
    }
    let edges = (0..4).map(|k| (corners[k] - corners[(k + 1) % 4]).norm());
    let inside =
        |c: &Point2<f64>| (0.0..=WIDTH - 1.0).contains(&c.x) && (0.0..=HEIGHT - 1.0).contains(&c.y);
    if edges.fold(f64::INFINITY, f64::min) < 12.0 || !corners.iter().all(inside) {
        return None;
    }
    let noise_px = kind.noise_px * (0.5 + random.uniform());
    for corner in &mut corners {
        *corner += Vector2::new(random.normal(), random.normal()) * noise_px;
    }
    if random.uniform() < kind.wrong {
        let at = (random.uniform() * 3.99) as usize;
        corners[at] += Vector2::new(random.normal(), random.normal()) * 5.0;
    }
    Some(TagCorners {
        tag: tag(id),
        corners,
        corner_covariance: [Matrix2::zeros(); 4],
        corner_cross_covariance: [Matrix2::zeros(); 6],
    })
}
