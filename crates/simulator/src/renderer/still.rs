//! The static picture behind the objects, and the light that objects receive: drawn once per camera, by rays.

use super::room::Room;
use crate::optics::Optics;
use crate::scenario::{Light, Scenario, SceneCamera};
use nalgebra::{Point2, Point3, Vector2, Vector3};

/// Grey level of a perfectly reflecting surface at light of strength 1.
const FULL: f64 = 255.0;
/// Samples in x and y of a pixel that is not smooth.
const SAMPLES: usize = 4;
/// Largest difference from its neighbours of a smooth pixel, grey levels.
const SMOOTH: f32 = 3.0;
/// Height above the table at which the lamp's pool of light on objects is computed, m.
const POOL_HEIGHT_M: f64 = 0.1;

/// Draws what is constant from image to image.
pub(super) struct StaticRenderer<'a> {
    camera: &'a SceneCamera,
    light: &'a Light,
    towards_lamp: Vector3<f64>,
    room: Room,
    /// Normalised point (x/z, y/z) seen at each pixel; NaN outside the field of view.
    normalised: Vec<[f32; 2]>,
}

impl<'a> StaticRenderer<'a> {
    pub fn new(scenario: &'a Scenario, camera: &'a SceneCamera) -> Self {
        let optics = Optics::from_camera(camera);
        let normalised = |pixel: Point2<f64>| match optics.undistort(&pixel) {
            Some(point) => [point.x as f32, point.y as f32],
            None => [f32::NAN; 2],
        };
        Self {
            camera,
            light: &scenario.light,
            towards_lamp: Vector3::from(scenario.light.towards_lamp).normalize(),
            room: Room::new(scenario),
            normalised: pixels(camera).map(normalised).collect(),
        }
    }

    /// Grey level of an object at light of strength 1, for each pixel.
    pub fn field(&self) -> Vec<f32> {
        let level = |(i, pixel): (usize, Point2<f64>)| {
            let (origin, direction) = self.ray(self.at(i));
            let way = if direction.z < -1e-3 {
                (POOL_HEIGHT_M - origin.z) / direction.z
            } else {
                1e3
            };
            let pool = self.pool(&(origin + direction * way.clamp(0.0, 1e3)));
            (FULL * pool * self.sensitivity(&pixel)) as f32
        };
        let levels = pixels(self.camera).enumerate().map(level);
        levels.map(black_where_nothing_is_seen).collect()
    }

    /// The background in grey levels: one sample per pixel, and more where neighbours differ.
    pub fn draw(&self) -> Vec<f32> {
        let sampled = |(i, pixel)| self.sample(i, &pixel, 1);
        let coarse: Vec<f32> = pixels(self.camera).enumerate().map(sampled).collect();
        let width = self.width();
        let smooth = |i: usize| {
            let neighbours = [
                i.saturating_sub(1),
                i + 1,
                i.saturating_sub(width),
                i + width,
            ];
            let differs = |&n: &usize| {
                coarse
                    .get(n)
                    .is_some_and(|level| (level - coarse[i]).abs() > SMOOTH)
            };
            !neighbours.iter().any(differs)
        };
        let refined = |(i, pixel)| {
            if smooth(i) {
                coarse[i]
            } else {
                self.sample(i, &pixel, SAMPLES)
            }
        };
        pixels(self.camera).enumerate().map(refined).collect()
    }

    fn width(&self) -> usize {
        self.camera.resolution[0] as usize
    }

    /// Mean level of n x n samples of a pixel; black outside the field of view.
    fn sample(&self, i: usize, pixel: &Point2<f64>, n: usize) -> f32 {
        let at = self.at(i);
        let (along, down) = (self.step(i, 1), self.step(i, self.width()));
        let levels = offsets(n).map(|[x, y]| self.level(at + along * x + down * y));
        let mean = levels.sum::<f64>() / (n * n) as f64;
        black_where_nothing_is_seen((mean * self.sensitivity(pixel)) as f32)
    }

    fn at(&self, i: usize) -> Point2<f64> {
        Point2::from(self.normalised[i].map(f64::from))
    }

    /// Change of the normalised point from a pixel to the one `stride` further on.
    fn step(&self, i: usize, stride: usize) -> Vector2<f64> {
        let last = self.normalised.len() - 1;
        let (before, after) = (i.saturating_sub(stride), (i + stride).min(last));
        let column = |i: usize| i % self.width();
        // At the ends of a row, the previous and next pixels belong to other rows.
        let before = if stride == 1 && column(i) == 0 {
            i
        } else {
            before
        };
        let after = if stride == 1 && column(after) == 0 {
            i
        } else {
            after
        };
        let pixels = ((after - before) / stride).max(1);
        let step = (self.at(after) - self.at(before)) / pixels as f64;
        if step.x.is_finite() {
            step
        } else {
            Vector2::zeros()
        }
    }

    fn level(&self, normalised: Point2<f64>) -> f64 {
        let room = match &self.room {
            Room::Plain { level } => return *level / self.camera.gain,
            Room::Furnished(room) => room,
        };
        let (origin, direction) = self.ray(normalised);
        let hit = room.cast(&origin, &direction);
        let facing = hit.normal.dot(&self.towards_lamp).max(0.0);
        let light = self.light.ambient + self.light.lamp * facing;
        FULL * hit.albedo * light * self.pool(&hit.point)
    }

    /// Origin and direction in the world frame; NaN outside the field of view.
    fn ray(&self, normalised: Point2<f64>) -> (Point3<f64>, Vector3<f64>) {
        let pose = &self.camera.world_from_camera;
        let direction = pose.rotation * Vector3::new(normalised.x, normalised.y, 1.0);
        (Point3::from(pose.translation.vector), direction.normalize())
    }

    /// The lamp's pool of light about the world's z axis: 1 in the middle, 3/4 at its radius, at least a half
    /// everywhere.
    fn pool(&self, point: &Point3<f64>) -> f64 {
        let share =
            point.coords.xy().norm_squared() / (self.light.pool_radius * self.light.pool_radius);
        0.5 + 0.5 / (1.0 + share)
    }

    /// Gain and vignetting at a pixel.
    fn sensitivity(&self, pixel: &Point2<f64>) -> f64 {
        let [width, height] = self.camera.resolution.map(f64::from);
        let half = Vector2::new(width - 1.0, height - 1.0) / 2.0;
        let share = (pixel.coords - half).norm_squared() / half.norm_squared();
        self.camera.gain * (1.0 - self.camera.vignetting * share)
    }
}

/// All pixels of an image, row by row.
fn pixels(camera: &SceneCamera) -> impl Iterator<Item = Point2<f64>> + use<> {
    let [width, height] = camera.resolution;
    (0..height).flat_map(move |y| (0..width).map(move |x| Point2::new(f64::from(x), f64::from(y))))
}

/// Centres of n x n parts of a pixel, relative to its centre.
fn offsets(n: usize) -> impl Iterator<Item = [f64; 2]> {
    let offset = move |i: usize| (i as f64 + 0.5) / n as f64 - 0.5;
    (0..n * n).map(move |i| [offset(i % n), offset(i / n)])
}

fn black_where_nothing_is_seen(level: f32) -> f32 {
    if level.is_finite() { level } else { 0.0 }
}
