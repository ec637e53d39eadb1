//! The static background of a camera's images, and the frame in which moving objects are drawn over it.
//!
//! Grey levels here are linear light; the image can represent 0 to 255. The background is drawn once, sharp and
//! blurred. For each image, only the regions in which something moves are composed and blurred again.

use super::canvas::Canvas;
use super::disk::Disk;
use super::psf::Psf;
use super::regions::{Rectangle, Regions};
use super::sensor::STEPS;
use crate::scenario::SceneCamera;

/// Largest value of the frame, well within an `i16`: brighter light is clipped.
const BRIGHTEST: f32 = 510.0;

/// The static part of a camera's images and the frame drawn over it.
pub(super) struct Backdrop {
    width: usize,
    psf: Psf,
    defocus: Disk,
    /// Grey level of objects at light of strength 1: gain, vignetting and the lamp's pool of light.
    field: Vec<f32>,
    sharp: Vec<f32>,
    blurred: Vec<i16>,
    frame: Vec<i16>,
    work: Work,
}

/// Buffer for one region while it is composed.
struct Work {
    composed: Vec<f32>,
    defocused: Vec<f32>,
    blurred_rows: Vec<f32>,
    colour: Vec<f32>,
    opacity: Vec<f32>,
}

impl Backdrop {
    /// From the light on objects and the static picture at each pixel, in grey levels.
    pub fn new(camera: &SceneCamera, field: Vec<f32>, sharp: Vec<f32>) -> Self {
        let [width, height] = camera.resolution.map(|n| n as usize);
        let psf = Psf::gaussian(camera.blur_px);
        let defocus = Disk::new(camera.defocus_px);
        let rim = 2 * (psf.radius() + defocus.radius());
        let padded = (width + rim) * (height + rim);
        let mut backdrop = Self {
            width,
            field,
            sharp,
            blurred: vec![0; width * height],
            frame: vec![0; width * height],
            work: Work {
                composed: vec![0.0; padded],
                defocused: vec![0.0; if defocus.radius() > 0 { padded } else { 0 }],
                blurred_rows: vec![0.0; padded],
                colour: vec![0.0; width],
                opacity: vec![0.0; width],
            },
            psf,
            defocus,
        };
        let whole = Rectangle::whole(camera.resolution);
        backdrop.copy_sharp(&whole, camera.resolution);
        backdrop.blur(&whole);
        backdrop.blurred.copy_from_slice(&backdrop.frame);
        backdrop
    }

    /// Distance at which a change of the sharp image still changes the blurred one, px.
    pub fn reach(&self) -> usize {
        self.psf.radius() + self.defocus.radius()
    }

    /// Light of the image, in 64ths of a grey level.
    pub fn frame(&self) -> &[i16] {
        &self.frame
    }

    /// Draws what was painted over the background.
    pub fn compose(&mut self, canvas: &mut Canvas, regions: &Regions) {
        for region in regions.rectangles() {
            let changed = region.grown(self.reach(), regions.resolution());
            self.copy_sharp(&changed, regions.resolution());
            self.compose_region(canvas, region, &changed);
            self.blur(&changed);
        }
    }

    /// Restores the background where objects were drawn.
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

    /// Sharp background of a rectangle and of the margin that its blur needs; beyond the image, the border pixels are
    /// repeated.
    fn copy_sharp(&mut self, rectangle: &Rectangle, resolution: [u32; 2]) {
        let [left, right] = rectangle.columns();
        let [top, bottom] = rectangle.rows();
        let radius = self.reach();
        let stride = right - left + 2 * radius;
        let (last_x, last_y) = (resolution[0] as usize - 1, resolution[1] as usize - 1);
        let rows = self
            .work
            .composed
            .chunks_exact_mut(stride)
            .take(bottom - top + 2 * radius);
        for (i, row) in rows.enumerate() {
            let y = (top + i).saturating_sub(radius).min(last_y);
            let sharp = &self.sharp[y * self.width..(y + 1) * self.width];
            for (j, value) in row.iter_mut().enumerate() {
                *value = sharp[(left + j).saturating_sub(radius).min(last_x)];
            }
        }
    }

    /// Draws the objects over the sharp background of `changed`.
    fn compose_region(&mut self, canvas: &mut Canvas, region: &Rectangle, changed: &Rectangle) {
        let radius = self.reach();
        let stride = changed.columns()[1] - changed.columns()[0] + 2 * radius;
        let [left, right] = region.columns();
        let [top, bottom] = region.rows();
        let Work {
            composed,
            colour,
            opacity,
            ..
        } = &mut self.work;
        for y in top..bottom {
            canvas.take_row(y, region, colour, opacity);
            let field = &self.field[y * self.width + left..y * self.width + right];
            let start =
                (y + radius - changed.rows()[0]) * stride + left + radius - changed.columns()[0];
            let row = &mut composed[start..start + right - left];
            for (((value, field), colour), opacity) in
                row.iter_mut().zip(field).zip(&*colour).zip(&*opacity)
            {
                *value = *value * (1.0 - opacity) + colour * field;
            }
        }
    }

    /// Blurs the composed region into the frame.
    fn blur(&mut self, rectangle: &Rectangle) {
        let radius = self.psf.radius();
        let [left, right] = rectangle.columns();
        let [top, bottom] = rectangle.rows();
        let (n, stride) = (right - left, right - left + 2 * radius);
        let Work {
            composed,
            defocused,
            blurred_rows,
            colour,
            ..
        } = &mut self.work;
        let spread = if self.defocus.radius() > 0 {
            let rim = 2 * (radius + self.defocus.radius());
            let used = (n + rim) * (bottom - top + rim);
            self.defocus.blur(&composed[..used], n + rim, defocused);
            defocused
        } else {
            composed
        };
        let rows = spread
            .chunks_exact(stride)
            .zip(blurred_rows.chunks_exact_mut(n));
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
