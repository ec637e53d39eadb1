//! What stands still, and the frame in which the objects come before it.
//!
//! Grey levels here are linear light: 0 to 255 is what fits into the image. The backdrop is drawn once, sharp and blurred;
//! of each image only the regions where something moves are composed and blurred anew.

use super::canvas::Canvas;
use super::psf::Psf;
use super::regions::{Rectangle, Regions};
use super::room::Room;
use super::sensor::STEPS;
use crate::scenario::{Light, Scenario, SceneCamera};
use nalgebra::{Matrix2, Point2, Point3, Vector2, Vector3};

/// Grey level of a surface that sends back all light of strength 1.
const FULL: f64 = 255.0;
/// Samples in x and y of a pixel of the backdrop that isn't smooth.
const SAMPLES: usize = 4;
/// A pixel that differs this little from its neighbours is smooth, grey levels.
const SMOOTH: f32 = 2.0;
/// Height above the table for which the lamp's pool of light on the objects is drawn, m.
const POOL_HEIGHT_M: f64 = 0.1;
/// The frame's largest number, well within an i16: light beyond it is cut off.
const BRIGHTEST: f32 = 510.0;

/// The still part of a camera's images and the frame before it.
pub(super) struct Backdrop {
    width: usize,
    psf: Psf,
    /// Grey level of the objects' light of strength 1: gain, vignetting and the lamp's pool.
    field: Vec<f32>,
    sharp: Vec<f32>,
    blurred: Vec<i16>,
    frame: Vec<i16>,
    work: Work,
}

/// Room for one region while it is composed.
struct Work {
    composed: Vec<f32>,
    blurred_rows: Vec<f32>,
    colour: Vec<f32>,
    opacity: Vec<f32>,
}

impl Backdrop {
    pub fn new(scenario: &Scenario, camera: &SceneCamera) -> Self {
        let [width, height] = camera.resolution.map(|n| n as usize);
        let psf = Psf::gaussian(camera.blur_px);
        let padded = (width + 2 * psf.radius()) * (height + 2 * psf.radius());
        let scene = Still::new(scenario, camera);
        let mut backdrop = Self {
            width,
            field: scene.field(),
            sharp: scene.draw(),
            blurred: vec![0; width * height],
            frame: vec![0; width * height],
            work: Work {
                composed: vec![0.0; padded],
                blurred_rows: vec![0.0; padded],
                colour: vec![0.0; width],
                opacity: vec![0.0; width],
            },
            psf,
        };
        let whole = Rectangle::whole(camera.resolution);
        backdrop.copy_sharp(&whole, camera.resolution);
        backdrop.blur(&whole);
        backdrop.blurred.copy_from_slice(&backdrop.frame);
        backdrop
    }

    /// How far a change of the sharp image changes the blurred one, px.
    pub fn reach(&self) -> usize {
        self.psf.radius()
    }

    /// The image's light in 64ths of a grey level.
    pub fn frame(&self) -> &[i16] {
        &self.frame
    }

    /// Puts what was painted before the backdrop.
    pub fn compose(&mut self, canvas: &mut Canvas, regions: &Regions) {
        for region in regions.rectangles() {
            let changed = region.grown(self.reach(), regions.resolution());
            self.copy_sharp(&changed, regions.resolution());
            self.compose_region(canvas, region, &changed);
            self.blur(&changed);
        }
    }

    /// Takes the objects away again.
    pub fn restore(&mut self, regions: &Regions) {
        for region in regions.rectangles() {
            let changed = region.grown(self.reach(), regions.resolution());
            let [left, right] = changed.columns();
            let [top, bottom] = changed.rows();
            for y in top..bottom {
                let row = y * self.width + left..y * self.width + right;
                self.frame[row.clone()].copy_from_slice(&self.blurred[row]);
            }
        }
    }

    /// The sharp backdrop of a rectangle and the rim that its blur needs; beyond the image its border goes on.
    fn copy_sharp(&mut self, rectangle: &Rectangle, resolution: [u32; 2]) {
        let [left, right] = rectangle.columns();
        let [top, bottom] = rectangle.rows();
        let radius = self.psf.radius();
        let stride = right - left + 2 * radius;
        let (last_x, last_y) = (resolution[0] as usize - 1, resolution[1] as usize - 1);
        let rows = self.work.composed.chunks_exact_mut(stride).take(bottom - top + 2 * radius);
        for (i, row) in rows.enumerate() {
            let y = (top + i).saturating_sub(radius).min(last_y);
            let sharp = &self.sharp[y * self.width..(y + 1) * self.width];
            for (j, value) in row.iter_mut().enumerate() {
                *value = sharp[(left + j).saturating_sub(radius).min(last_x)];
            }
        }
    }

    /// Sharp objects before the sharp backdrop of `changed`.
    fn compose_region(&mut self, canvas: &mut Canvas, region: &Rectangle, changed: &Rectangle) {
        let radius = self.psf.radius();
        let stride = changed.columns()[1] - changed.columns()[0] + 2 * radius;
        let [left, right] = region.columns();
        let [top, bottom] = region.rows();
        let Work {
            composed, colour, opacity, ..
        } = &mut self.work;
        for y in top..bottom {
            canvas.take_row(y, region, colour, opacity);
            let field = &self.field[y * self.width + left..y * self.width + right];
            let start = (y + radius - changed.rows()[0]) * stride + left + radius - changed.columns()[0];
            let row = &mut composed[start..start + right - left];
            for (((value, field), colour), opacity) in row.iter_mut().zip(field).zip(&*colour).zip(&*opacity) {
                *value = *value * (1.0 - opacity) + colour * field;
            }
        }
    }

    /// Blurs what was composed into the frame.
    fn blur(&mut self, rectangle: &Rectangle) {
        let radius = self.psf.radius();
        let [left, right] = rectangle.columns();
        let [top, bottom] = rectangle.rows();
        let (n, stride) = (right - left, right - left + 2 * radius);
        let Work {
            composed, blurred_rows, colour, ..
        } = &mut self.work;
        let rows = composed.chunks_exact(stride).zip(blurred_rows.chunks_exact_mut(n));
        for (row, out) in rows.take(bottom - top + 2 * radius) {
            self.psf.blur_row(row, out);
        }
        for y in top..bottom {
            let out = &mut colour[..n];
            let row = |i: usize| &blurred_rows[(y - top + i) * n..(y - top + i + 1) * n];
            self.psf.blur_column(row, out);
            let frame = &mut self.frame[y * self.width + left..y * self.width + right];
            for (value, level) in frame.iter_mut().zip(&*out) {
                *value = (level.clamp(0.0, BRIGHTEST) * STEPS as f32 + 0.5) as i16;
            }
        }
    }
}

/// Draws the backdrop once.
struct Still<'a> {
    camera: &'a SceneCamera,
    light: &'a Light,
    room: Room,
}

impl<'a> Still<'a> {
    fn new(scenario: &'a Scenario, camera: &'a SceneCamera) -> Self {
        Self {
            camera,
            light: &scenario.light,
            room: Room::new(scenario),
        }
    }

    fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let [width, height] = self.camera.resolution;
        (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
    }

    /// What reaches the pixel of an object's light of strength 1.
    fn field(&self) -> Vec<f32> {
        let level = |(x, y)| {
            let pixel = Point2::new(f64::from(x), f64::from(y));
            let Ok(normalised) = self.camera.lens.undistort(&pixel) else {
                return 0.0;
            };
            let (origin, direction) = self.ray(&normalised);
            let way = if direction.z < -1e-3 { (POOL_HEIGHT_M - origin.z) / direction.z } else { 1e3 };
            let pool = pool_at(self.light, &(origin + direction * way.clamp(0.0, 1e3)));
            (FULL * pool * self.sensitivity(&pixel)) as f32
        };
        self.pixels().map(level).collect()
    }

    /// The backdrop: one sample a pixel, and more where neighbours differ.
    fn draw(&self) -> Vec<f32> {
        let coarse: Vec<f32> = self.pixels().map(|pixel| self.sample(pixel, 1)).collect();
        let width = self.camera.resolution[0] as usize;
        let smooth = |i: usize| {
            let neighbours = [i.saturating_sub(1), i + 1, i.saturating_sub(width), i + width];
            let differs = |&n: &usize| coarse.get(n).is_some_and(|level| (level - coarse[i]).abs() > SMOOTH);
            !neighbours.iter().any(differs)
        };
        let refined = self.pixels().enumerate().map(|(i, pixel)| {
            if smooth(i) { coarse[i] } else { self.sample(pixel, SAMPLES) }
        });
        refined.collect()
    }

    /// Mean level of n x n samples of a pixel; black where the lens shows nothing.
    fn sample(&self, (x, y): (u32, u32), n: usize) -> f32 {
        let pixel = Point2::new(f64::from(x), f64::from(y));
        let Ok((normalised, by_pixel)) = self.camera.lens.undistort_with_jacobian(&pixel) else {
            return 0.0;
        };
        let sum: f64 = offsets(n)
            .map(|offset| self.level(&normalised, &by_pixel, &offset))
            .sum();
        (sum / (n * n) as f64 * self.sensitivity(&pixel)) as f32
    }

    fn level(&self, normalised: &Point2<f64>, by_pixel: &Matrix2<f64>, offset: &Vector2<f64>) -> f64 {
        let (origin, direction) = self.ray(&(normalised + by_pixel * offset));
        match &self.room {
            Room::Plain { level } => *level / self.camera.gain,
            Room::Furnished(room) => {
                let seen = room.look(&origin, &direction);
                let towards_lamp = Vector3::from(self.light.towards_lamp).normalize();
                let facing = seen.normal.dot(&towards_lamp).max(0.0);
                let light = self.light.ambient + self.light.lamp * facing;
                FULL * seen.albedo * light * pool_at(self.light, &seen.point)
            }
        }
    }

    fn ray(&self, normalised: &Point2<f64>) -> (Point3<f64>, Vector3<f64>) {
        let pose = &self.camera.world_from_camera;
        let direction = pose.rotation * Vector3::new(normalised.x, normalised.y, 1.0);
        (Point3::from(pose.translation.vector), direction.normalize())
    }

    /// Gain and vignetting at a pixel.
    fn sensitivity(&self, pixel: &Point2<f64>) -> f64 {
        let [width, height] = self.camera.resolution.map(f64::from);
        let half = Vector2::new(width - 1.0, height - 1.0) / 2.0;
        let share = (pixel.coords - half).norm_squared() / half.norm_squared();
        self.camera.gain * (1.0 - self.camera.vignetting * share)
    }
}

fn offsets(n: usize) -> impl Iterator<Item = Vector2<f64>> {
    let offset = move |i: usize| (i as f64 + 0.5) / n as f64 - 0.5;
    (0..n * n).map(move |i| Vector2::new(offset(i % n), offset(i / n)))
}

/// The lamp's pool of light about the world's z axis: 1 in the middle, two thirds at its radius, never quite dark.
fn pool_at(light: &Light, point: &Point3<f64>) -> f64 {
    let share = point.coords.xy().norm_squared() / (light.pool_radius * light.pool_radius);
    0.3 + 0.7 / (1.0 + share)
}
