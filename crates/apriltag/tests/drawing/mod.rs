//! Draws tags as a pinhole camera sees them. Shares no code with the detector: rays are cut with the tag's plane, and
//! each pixel is the mean of many rays.

#![allow(dead_code, clippy::unwrap_used)]

use nalgebra::Point2;
use sextant_apriltag::{Detection, Detector, Family, Image, Options};
use sextant_geometry::Lens;
use sextant_tag_families::{Board, module_is_white};

/// Rays along either side of a pixel.
const RAYS: usize = 16;

/// Cells along either side of a pixel in which rays are gathered, so that blur comes before the pixel's own area.
const CELLS: usize = 4;

/// A tag before the camera: x right, y down, z forward; `turn_deg` about x, y and then z of the camera.
#[derive(Clone, Debug)]
pub struct Tag {
    pub id: u32,
    pub family: Family,
    pub size_m: f64,
    pub position_m: [f64; 3],
    pub turn_deg: [f64; 3],
    /// Grey of black and white.
    pub greys: [f64; 2],
    /// Modules (column, row of the printed tag) drawn in the wrong colour.
    pub wrong: Vec<(usize, usize)>,
    /// Paper around the printed tag, in modules.
    pub margin: f64,
    /// What the tag's board has beside it, as a share of its edge: of a ChArUco board's square the marker's edge, of an
    /// AprilGrid's tag the edge of the squares at its corners.
    pub share: f64,
    /// White between the squares of a ChArUco board on either side of an edge, as a share of it.
    pub gap: f64,
    /// Whether black squares touch the tag's corners, as they do on an AprilGrid.
    pub touched: bool,
}

/// What the detector finds in a square picture with these families.
pub fn detect(pixels: &[u8], size: usize, families: &[Family]) -> Vec<Detection> {
    let image = Image::new(pixels, size, size, size).unwrap();
    let options = Options {
        families: families.to_vec(),
        ..Options::default()
    };
    Detector::new(options).unwrap().detect(&image).to_vec()
}

impl Tag {
    /// A tag so many pixels wide in the middle of the picture, tilted by up to so many degrees and turned at random.
    pub fn turned(
        family: Family,
        id: u32,
        edge_px: f64,
        tilt_deg: f64,
        random: &mut Random,
    ) -> Self {
        Self {
            family,
            position_m: [0.0, 0.0, 0.04 * 600.0 / edge_px],
            turn_deg: [
                random.between(-tilt_deg, tilt_deg),
                random.between(-tilt_deg, tilt_deg),
                random.between(0.0, 360.0),
            ],
            ..Self::new(id)
        }
    }

    pub fn new(id: u32) -> Self {
        Self {
            id,
            family: Family::Tag36h11,
            size_m: 0.04,
            position_m: [0.0, 0.0, 0.5],
            turn_deg: [0.0; 3],
            greys: [30.0, 220.0],
            wrong: Vec::new(),
            margin: 1.0,
            share: 0.3,
            gap: 0.0,
            touched: false,
        }
    }

    fn axes(&self) -> [[f64; 3]; 3] {
        let [a, b, c] = self.turn_deg.map(f64::to_radians);
        let about_x =
            |[x, y, z]: [f64; 3]| [x, y * a.cos() - z * a.sin(), y * a.sin() + z * a.cos()];
        let about_y =
            |[x, y, z]: [f64; 3]| [x * b.cos() + z * b.sin(), y, z * b.cos() - x * b.sin()];
        let about_z =
            |[x, y, z]: [f64; 3]| [x * c.cos() - y * c.sin(), x * c.sin() + y * c.cos(), z];
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|axis| about_z(about_y(about_x(axis))))
    }

    /// True corners: top left, top right, bottom right, bottom left.
    pub fn corners(&self, camera: &Camera) -> [[f64; 2]; 4] {
        let [right, down, _] = self.axes();
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(u, v)| {
            let [x, y, z] =
                [0, 1, 2].map(|i| self.position_m[i] + self.size_m * (u * right[i] + v * down[i]));
            camera.pixel([x / z, y / z])
        })
    }

    /// The tag's grey where a ray meets it.
    fn grey(&self, axes: &[[f64; 3]; 3], ray: [f64; 3]) -> Option<f64> {
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let depth = dot(self.position_m, axes[2]) / dot(ray, axes[2]);
        let point = [0, 1, 2].map(|i| ray[i] * depth - self.position_m[i]);
        let data = self.family.data();
        let (border, total) = (f64::from(data.border_width), f64::from(data.total_width));
        let place = [axes[0], axes[1]].map(|axis| dot(point, axis) / self.size_m);
        let of_marker = if data.board == Some(Board::Charuco) {
            self.share
        } else {
            1.0
        };
        let [x, y] = place.map(|place| place / of_marker * border + total / 2.0);
        let paper = -self.margin..total + self.margin;
        if depth <= 0.0 || !paper.contains(&x) || !paper.contains(&y) {
            return None;
        }
        if self.is_black_beside(place) {
            return Some(self.greys[0]);
        }
        let on_tag = (0.0..total).contains(&x) && (0.0..total).contains(&y);
        let module = (x.max(0.0) as usize, y.max(0.0) as usize);
        let white = !on_tag
            || module_is_white(self.family, self.id, module.0, module.1)
                != self.wrong.contains(&module);
        Some(self.greys[usize::from(white)])
    }
}

impl Tag {
    /// Whether the tag's board is black at a place beside it, in edges of the tag from its middle.
    fn is_black_beside(&self, place: [f64; 2]) -> bool {
        let beyond = place.map(|place| place.abs() - 0.5);
        match self.family.data().board {
            Some(Board::Aprilgrid) => beyond
                .iter()
                .all(|beyond| (0.0..self.share).contains(beyond)),
            Some(Board::Charuco) => {
                let square = place.map(|place| (place + 0.5).floor() as i32);
                let is_beside = square.iter().all(|at| (-1..=1).contains(at));
                let is_inside = place.iter().all(|place| {
                    let within = (place + 0.5).rem_euclid(1.0);
                    (self.gap..=1.0 - self.gap).contains(&within)
                });
                is_beside && is_inside && (square[0] + square[1]) % 2 != 0
            }
            Some(Board::Chessboard) | None => {
                self.touched
                    && beyond
                        .iter()
                        .all(|beyond| (0.0..self.share).contains(beyond))
            }
        }
    }
}

/// A camera, a pinhole unless it has a lens; pixel (0, 0) is the centre of the top left one.
#[derive(Clone, Debug)]
pub struct Camera {
    pub width: usize,
    pub height: usize,
    pub focal: f64,
    pub centre: [f64; 2],
    pub lens: Option<Lens>,
}

impl Camera {
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            focal: 600.0,
            centre: [width as f64 / 2.0 - 0.37, height as f64 / 2.0 + 0.21],
            lens: None,
        }
    }

    fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match &self.lens {
            Some(lens) => lens.distort(&Point2::new(x, y)).unwrap().into(),
            None => [
                self.centre[0] + self.focal * x,
                self.centre[1] + self.focal * y,
            ],
        }
    }

    fn ray(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let [x, y] = match &self.lens {
            Some(lens) => lens.undistort(&Point2::new(x, y)).unwrap().into(),
            None => [
                (x - self.centre[0]) / self.focal,
                (y - self.centre[1]) / self.focal,
            ],
        };
        [x, y, 1.0]
    }
}

/// What the camera sees, `CELLS` times finer than its pixels and not rounded.
#[derive(Clone, Debug)]
pub struct Picture {
    width: usize,
    height: usize,
    greys: Vec<f64>,
}

impl Picture {
    /// The tags before a plain background; the first tag that a ray meets is seen.
    pub fn draw(camera: &Camera, tags: &[Tag], background: f64) -> Self {
        let axes: Vec<_> = tags.iter().map(Tag::axes).collect();
        let boxes: Vec<_> = tags.iter().map(|tag| bounding_box(tag, camera)).collect();
        let (width, height) = (camera.width * CELLS, camera.height * CELLS);
        let mut greys = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let [x, y] = [x, y].map(|cell| (cell as f64 + 0.5) / CELLS as f64 - 0.5);
                let near = |b: &[f64; 4]| x > b[0] && x < b[1] && y > b[2] && y < b[3];
                let candidates: Vec<usize> = (0..tags.len()).filter(|&i| near(&boxes[i])).collect();
                greys.push(cell(camera, tags, &axes, &candidates, background, [x, y]));
            }
        }
        Self {
            width,
            height,
            greys,
        }
    }

    /// Under a light that grows along x and y by these parts a pixel, and is 1 at the middle.
    pub fn lit(mut self, slope: [f64; 2]) -> Self {
        for (i, grey) in self.greys.iter_mut().enumerate() {
            let away = |at: usize, n: usize| (at as f64 - n as f64 / 2.0) / CELLS as f64;
            let (x, y) = (
                away(i % self.width, self.width),
                away(i / self.width, self.height),
            );
            *grey *= 1.0 + slope[0] * x + slope[1] * y;
        }
        self
    }

    /// Blurs with a Gaussian.
    pub fn blurred(&self, sigma_px: f64) -> Self {
        let sigma = sigma_px * CELLS as f64;
        let radius = (4.0 * sigma).ceil() as isize;
        let kernel: Vec<f64> = (-radius..=radius)
            .map(|i| (-0.5 * (i as f64 / sigma).powi(2)).exp())
            .collect();
        let sum: f64 = kernel.iter().sum();
        let pass = |greys: &[f64], dx: isize, dy: isize| -> Vec<f64> {
            let at = |x: isize, y: isize| {
                let (x, y) = (
                    x.clamp(0, self.width as isize - 1),
                    y.clamp(0, self.height as isize - 1),
                );
                greys[y as usize * self.width + x as usize]
            };
            let blurred = |x: isize, y: isize| {
                let taps = kernel.iter().zip(-radius..);
                taps.map(|(k, i)| k * at(x + i * dx, y + i * dy))
                    .sum::<f64>()
                    / sum
            };
            (0..self.height as isize)
                .flat_map(|y| (0..self.width as isize).map(move |x| (x, y)))
                .map(|(x, y)| blurred(x, y))
                .collect()
        };
        Self {
            greys: pass(&pass(&self.greys, 1, 0), 0, 1),
            ..*self
        }
    }

    /// As the camera gives it: cells averaged to pixels, with normal noise, rounded to 8 bits.
    pub fn pixels(&self, noise_sigma: f64, seed: u64) -> Vec<u8> {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let mut pixels = Vec::with_capacity(self.greys.len() / (CELLS * CELLS));
        for y in (0..self.height).step_by(CELLS) {
            for x in (0..self.width).step_by(CELLS) {
                let cells =
                    (0..CELLS).flat_map(|i| &self.greys[(y + i) * self.width + x..][..CELLS]);
                let grey = cells.sum::<f64>() / (CELLS * CELLS) as f64;
                pixels.push(
                    (grey + noise_sigma * random.normal())
                        .round()
                        .clamp(0.0, 255.0) as u8,
                );
            }
        }
        pixels
    }
}

/// Mean of the rays of a cell. They are staggered from row to row, so that edges along rows and columns are sampled
/// finely too.
fn cell(
    camera: &Camera,
    tags: &[Tag],
    axes: &[[[f64; 3]; 3]],
    candidates: &[usize],
    background: f64,
    [x, y]: [f64; 2],
) -> f64 {
    const SIDE: usize = RAYS / CELLS;
    if candidates.is_empty() {
        return background;
    }
    let mut sum = 0.0;
    for (i, j) in (0..SIDE * SIDE).map(|k| (k % SIDE, k / SIDE)) {
        let aside = |k: usize, across: usize| {
            ((k as f64 + (across as f64 + 0.5) / SIDE as f64) / SIDE as f64 - 0.5) / CELLS as f64
        };
        let (px, py) = (x + aside(i, j), y + aside(j, i));
        let ray = camera.ray([px, py]);
        sum += candidates
            .iter()
            .find_map(|&k| tags[k].grey(&axes[k], ray))
            .unwrap_or(background);
    }
    sum / (SIDE * SIDE) as f64
}

/// Left, right, top and bottom of all that belongs to a tag, generously.
fn bounding_box(tag: &Tag, camera: &Camera) -> [f64; 4] {
    let corners = tag.corners(camera);
    let centre = [0, 1].map(|i| corners.iter().map(|c| c[i]).sum::<f64>() / 4.0);
    let reach = corners
        .iter()
        .map(|c| (c[0] - centre[0]).hypot(c[1] - centre[1]))
        .fold(0.0, f64::max);
    let reach = reach * (1.7 + tag.margin / 3.0) + 2.0;
    [
        centre[0] - reach,
        centre[0] + reach,
        centre[1] - reach,
        centre[1] + reach,
    ]
}

/// xorshift64*.
pub struct Random(pub u64);

impl Random {
    pub fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}
