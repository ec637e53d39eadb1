//! Compression: replaces an image by its JPEG of a given quality.

use crate::scenario::SceneCamera;
use jpeg_encoder::{ColorType, Encoder};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Encodes and decodes images.
pub(super) struct Jpeg {
    quality: u8,
    resolution: [u16; 2],
    packed: Vec<u8>,
}

impl Jpeg {
    pub fn for_camera(camera: &SceneCamera) -> Option<Self> {
        Some(Self {
            quality: camera.jpeg_quality?,
            // A valid scenario has at most 4096 x 3072 pixels.
            resolution: camera.resolution.map(|n| n as u16),
            packed: Vec::new(),
        })
    }

    /// Replaces an image by its decoded JPEG; an image that cannot be encoded stays unchanged.
    pub fn apply(&mut self, image: &mut [u8]) {
        self.packed.clear();
        let [width, height] = self.resolution;
        let encoder = Encoder::new(&mut self.packed, self.quality);
        if encoder
            .encode(image, width, height, ColorType::Luma)
            .is_err()
        {
            return;
        }
        let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::Luma);
        let mut decoder = JpegDecoder::new_with_options(ZCursor::new(&self.packed), options);
        if let Ok(pixels) = decoder.decode()
            && pixels.len() == image.len()
        {
            image.copy_from_slice(&pixels);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Renderer, Scenario};

    #[test]
    fn a_jpeg_is_near_its_image_and_nearer_at_a_higher_quality() {
        let mut scenario = Scenario::demo(1, 2, 1);
        let mut image = vec![0; 640 * 480];
        let mut render = |quality| {
            scenario.cameras[0].jpeg_quality = quality;
            let mut renderer = Renderer::new(&scenario, 0).unwrap();
            renderer.render(5, &mut image).unwrap();
            image.clone()
        };
        let plain = render(None);
        let mut rms = |quality| {
            let packed = render(Some(quality));
            let squares = packed.iter().zip(&plain);
            let sum: f64 = squares
                .map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2))
                .sum();
            f64::sqrt(sum / plain.len() as f64)
        };
        let (good, poor) = (rms(95), rms(30));
        assert!((0.1..2.0).contains(&good), "{good}");
        assert!((2.0..8.0).contains(&poor) && poor > 1.5 * good, "{poor}");
    }
}
