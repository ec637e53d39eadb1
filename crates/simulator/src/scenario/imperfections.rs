//! Sites as people build them: errors of files, prints and glue drawn at random, and both sides of the difference.

use super::{CameraFileError, Displacement, Scenario};
use crate::random::{Random, key_of_name};
use sextant_geometry::LensError;

/// How wrong a site's files are: standard deviations, of each axis where there are several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Imperfections {
    /// Of cameras' places, m.
    pub camera_position: f64,
    /// Of their attitudes, rad.
    pub camera_rotation: f64,
    /// Of their focal lengths, relative.
    pub focal: f64,
    /// Of tags' places, m.
    pub tag_position: f64,
    /// Of their attitudes, rad.
    pub tag_rotation: f64,
    /// Of prints, relative; an object's tags come from one sheet.
    pub print_scale: f64,
}

impl Imperfections {
    /// A site set up with care and a tape measure: cameras 3 mm and 0.3 degrees, focal lengths 0.3 %, tags 0.4 mm and
    /// 0.4 degrees, prints 0.3 %.
    pub const TYPICAL: Self = Self {
        camera_position: 0.003,
        camera_rotation: 0.0052,
        focal: 0.003,
        tag_position: 0.0004,
        tag_rotation: 0.007,
        print_scale: 0.003,
    };
}

impl Scenario {
    /// The site with random errors from its seed. Images change by errors of prints and glue only.
    pub fn with_imperfections(mut self, errors: &Imperfections) -> Self {
        for camera in &mut self.cameras {
            let mut random = source(self.seed, &camera.id);
            camera.file_error = CameraFileError {
                position: vector(&mut random, errors.camera_position),
                rotation: vector(&mut random, errors.camera_rotation),
                focal: random.normal() * errors.focal,
            };
        }
        for object in &mut self.objects {
            let mut random = source(self.seed, &object.id);
            let print_scale = 1.0 + random.normal() * errors.print_scale;
            for tag in &mut object.tags {
                tag.print_scale = print_scale;
                tag.glue_error = Displacement {
                    position: vector(&mut random, errors.tag_position),
                    rotation: vector(&mut random, errors.tag_rotation),
                };
            }
        }
        self
    }

    /// As the site's files have it: cameras with the errors of the rig file, tags as they were meant to be.
    ///
    /// # Errors
    /// Where a lens with its error is none; a valid scenario has none such.
    pub fn as_written(&self) -> Result<Self, LensError> {
        let mut written = self.clone();
        for camera in &mut written.cameras {
            camera.lens = camera.file_error.lens(&camera.lens)?;
            camera.world_from_camera = camera.file_error.pose(&camera.world_from_camera);
            camera.file_error = CameraFileError::default();
        }
        for tag in written.objects.iter_mut().flat_map(|o| &mut o.tags) {
            (tag.print_scale, tag.glue_error) = (1.0, Displacement::default());
        }
        Ok(written)
    }

    /// As the site truly is: tags with the size and place that they have. Curl remains, which no object file can say.
    pub fn as_built(&self) -> Self {
        let mut built = self.clone();
        for camera in &mut built.cameras {
            camera.file_error = CameraFileError::default();
        }
        for tag in built.objects.iter_mut().flat_map(|o| &mut o.tags) {
            tag.size = tag.true_size();
            tag.object_from_tag = tag.true_object_from_tag();
            (tag.print_scale, tag.glue_error) = (1.0, Displacement::default());
        }
        built
    }
}

fn source(seed: u64, name: &str) -> Random {
    Random::from_keys(&[seed, key_of_name(name), key_of_name("imperfections")])
}

fn vector(random: &mut Random, sigma: f64) -> [f64; 3] {
    std::array::from_fn(|_| random.normal() * sigma)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_follow_from_the_seed_and_have_their_sizes() {
        let errors = Imperfections::TYPICAL;
        let make = |seed| Scenario::demo(16, 12, seed).with_imperfections(&errors);
        let scenario = make(5);
        assert_eq!(scenario, make(5));
        assert_eq!(scenario.validate(), Ok(()));
        let (written, built) = (scenario.as_written().unwrap(), scenario.as_built());
        let mut squares = 0.0;
        for (written, built) in written.cameras.iter().zip(&built.cameras) {
            let moved = written.world_from_camera.translation.vector
                - built.world_from_camera.translation.vector;
            squares += moved.norm_squared();
        }
        let sigma = f64::sqrt(squares / 48.0);
        assert!(
            (sigma / errors.camera_position - 1.0).abs() < 0.3,
            "{sigma}"
        );
        let tags = |scenario: &Scenario| -> Vec<_> {
            let tags = scenario.objects.iter().flat_map(|o| o.tags.clone());
            tags.collect()
        };
        let (written, built) = (tags(&written), tags(&built));
        let n = written.len() as f64;
        let pairs = || written.iter().zip(&built);
        let glue = pairs().map(|(w, b)| {
            (w.object_from_tag.translation.vector - b.object_from_tag.translation.vector)
                .norm_squared()
        });
        let sigma = f64::sqrt(glue.sum::<f64>() / (3.0 * n));
        assert!((sigma / errors.tag_position - 1.0).abs() < 0.2, "{sigma}");
        let print = pairs().map(|(w, b)| (b.size / w.size - 1.0).powi(2));
        let sigma = f64::sqrt(print.sum::<f64>() / n);
        assert!((sigma / errors.print_scale - 1.0).abs() < 0.6, "{sigma}");
    }
}
