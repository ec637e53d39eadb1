//! Grey pixels to tags, poses, light and sharpness.

use nalgebra::Point2;
use sextant_apriltag::{Detection, Detector, Image, ImageError, Options, OptionsError, Tracker};
use sextant_geometry::Lens;
use sextant_geometry::planar_pose::{PlanarPose, tag_poses};

/// Rows between two that are examined for light and sharpness.
const ROW_STEP: usize = 8;
/// Pixels of a row within which contrast is measured.
const WINDOW: usize = 8;
/// Least contrast of an edge, grey levels.
const MIN_CONTRAST: u8 = 32;

/// The detector, and the tags of the last image.
#[derive(Debug)]
pub struct Vision {
    finder: Finder,
    tags: Vec<Detection>,
    light: Light,
}

#[derive(Debug)]
enum Finder {
    EachImage(Box<Detector>),
    Tracking(Box<Tracker>),
}

/// Light and sharpness of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Light {
    /// Mean grey level, 0 to 255.
    pub brightness: f32,
    /// Mean share of an edge's contrast between two neighbouring pixels: 1 for perfect steps, below 0.3 where the image
    /// is out of focus or smeared by motion, 0 without any edge.
    pub sharpness: f32,
}

/// How images are searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// All of every image.
    Whole,
    /// Where tags were and, in turn, elsewhere.
    Tracking,
}

impl Vision {
    /// A detector with these options.
    ///
    /// # Errors
    /// Options out of range.
    pub fn new(options: Options, search: Search) -> Result<Self, OptionsError> {
        let finder = match search {
            Search::Whole => Finder::EachImage(Box::new(Detector::new(options)?)),
            Search::Tracking => Finder::Tracking(Box::new(Tracker::new(options)?)),
        };
        Ok(Self {
            finder,
            tags: Vec::new(),
            light: Light::default(),
        })
    }

    /// Finds the tags of an image of `stride` bytes a row.
    ///
    /// # Errors
    /// An image of a wrong size.
    pub fn detect(
        &mut self,
        pixels: &[u8],
        [width, height]: [usize; 2],
        stride: usize,
    ) -> Result<&[Detection], ImageError> {
        self.tags.clear();
        let image = Image::new(pixels, width, height, stride)?;
        let tags = match &mut self.finder {
            Finder::EachImage(detector) => detector.detect(&image),
            Finder::Tracking(tracker) => tracker.detect(&image),
        };
        self.tags.extend_from_slice(tags);
        self.light = Light::measure(&image);
        Ok(&self.tags)
    }

    /// The tags of the last image.
    #[must_use]
    pub fn tags(&self) -> &[Detection] {
        &self.tags
    }

    /// Light and sharpness of the last image.
    #[must_use]
    pub fn light(&self) -> Light {
        self.light
    }

    /// Poses of a tag of the last image, `camera_from_tag`, the better first; `size_m` is the edge of its black square.
    #[must_use]
    pub fn poses(&self, tag: usize, lens: &Lens, size_m: f64) -> Vec<PlanarPose> {
        let Some(tag) = self.tags.get(tag) else {
            return Vec::new();
        };
        let corners = tag
            .corners
            .map(|[x, y]| Point2::new(f64::from(x), f64::from(y)));
        tag_poses(lens, &corners, size_m)
    }
}

impl Light {
    fn measure(image: &Image<'_>) -> Self {
        let rows = (0..image.height()).step_by(ROW_STEP).map(|y| image.row(y));
        let (mut sum, mut n_pixels) = (0_u64, 0_u64);
        let (mut steepness, mut n_edges) = (0.0, 0_u32);
        for row in rows {
            sum += row.iter().map(|pixel| u64::from(*pixel)).sum::<u64>();
            n_pixels += row.len() as u64;
            for share in row.as_chunks::<WINDOW>().0.iter().filter_map(steepest) {
                steepness += share;
                n_edges += 1;
            }
        }
        Self {
            brightness: sum as f32 / n_pixels.max(1) as f32,
            sharpness: steepness / n_edges.max(1) as f32,
        }
    }
}

/// The greatest difference of two neighbours as a share of the contrast, where there is enough of it.
fn steepest(pixels: &[u8; WINDOW]) -> Option<f32> {
    let (darkest, brightest) = (pixels.iter().min()?, pixels.iter().max()?);
    let contrast = brightest - darkest;
    let steps = pixels.array_windows().map(|[a, b]| a.abs_diff(*b));
    (contrast >= MIN_CONTRAST).then_some(f32::from(steps.max()?) / f32::from(contrast))
}

/// Grey of pixels of four bytes, red, green, blue and one that is ignored, as ITU-R BT.601 weighs them; kept in the
/// first quarter. Returns the number of whole pixels.
pub fn grey_of_rgba(bytes: &mut [u8]) -> usize {
    let n_pixels = bytes.len() / 4;
    for i in 0..n_pixels {
        let [red, green, blue] = [0, 1, 2].map(|channel| u32::from(bytes[4 * i + channel]));
        bytes[i] = ((77 * red + 150 * green + 29 * blue + 128) >> 8) as u8;
    }
    n_pixels
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(row: impl Fn(usize) -> u8) -> Light {
        let pixels: Vec<u8> = (0..64 * 64).map(|i| row(i % 64)).collect();
        Light::measure(&Image::new(&pixels, 64, 64, 64).unwrap())
    }

    #[test]
    fn steps_are_sharp_ramps_are_not_and_a_wall_has_no_edge() {
        let step = light(|x| if x % 8 < 4 { 0 } else { 200 });
        assert_eq!((step.brightness, step.sharpness), (100.0, 1.0));
        let ramp = light(|x| (x % 8 * 20) as u8);
        assert!(ramp.sharpness < 0.2, "{ramp:?}");
        assert_eq!(light(|_| 7).sharpness, 0.0);
    }

    #[test]
    fn grey_takes_the_place_of_colours() {
        let mut bytes = [255, 255, 255, 0, 0, 0, 0, 9, 255, 0, 0, 1, 5];
        assert_eq!(grey_of_rgba(&mut bytes), 3);
        assert_eq!(bytes[..3], [255, 0, 77]);
    }
}
