//! Model of a colour sensor that delivers a grey image: Bayer mosaic, white balance, bilinear interpolation, luma.
//!
//! The scene is grey, so the mosaic only softens edges, adds a zipper pattern of two pixels, and coarsens the
//! quantisation of red and blue, which receive less light. Rows are R G R G ..., G B G B ...

use crate::scenario::{Mosaic, SceneCamera};

/// Response of red, green and blue pixels to grey light.
const RESPONSE: [f32; 3] = [0.55, 1.0, 0.65];
/// Weights of red, green and blue in the luma (ITU-R BT.601).
const LUMA: [f32; 3] = [0.299, 0.587, 0.114];
const GREEN: usize = 1;

/// Converts an ideal grey image into that of a colour camera.
pub(super) struct Demosaic {
    width: usize,
    balanced: Vec<f32>,
}

impl Demosaic {
    pub fn for_camera(camera: &SceneCamera) -> Option<Self> {
        let [width, height] = camera.resolution.map(|n| n as usize);
        (camera.mosaic == Mosaic::Bayer).then(|| Self {
            width,
            balanced: vec![0.0; width * height],
        })
    }

    pub fn apply(&mut self, image: &mut [u8]) {
        for (i, (balanced, level)) in self.balanced.iter_mut().zip(&*image).enumerate() {
            let response = RESPONSE[channel(i % self.width, i / self.width)];
            *balanced = (f32::from(*level) * response).round() / response;
        }
        let height = image.len() / self.width;
        for y in 0..height {
            for x in 0..self.width {
                let luma = (0..3).map(|c| LUMA[c] * self.interpolated(c, x, y, height));
                image[y * self.width + x] = (luma.sum::<f32>() + 0.5) as u8;
            }
        }
    }

    /// Mean of the nearest pixels of a channel: the pixel itself, or two or four neighbours.
    fn interpolated(&self, wanted: usize, x: usize, y: usize, height: usize) -> f32 {
        if channel(x, y) == wanted {
            return self.balanced[y * self.width + x];
        }
        let (mut sum, mut n) = (0.0, 0.0);
        for ny in y.saturating_sub(1)..(y + 2).min(height) {
            for nx in x.saturating_sub(1)..(x + 2).min(self.width) {
                let is_diagonal = nx != x && ny != y;
                if channel(nx, ny) == wanted && !(wanted == GREEN && is_diagonal) {
                    sum += self.balanced[ny * self.width + nx];
                    n += 1.0;
                }
            }
        }
        sum / n
    }
}

/// Channel of a pixel: 0 red, 1 green, 2 blue.
fn channel(x: usize, y: usize) -> usize {
    x % 2 + y % 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scenario;

    fn mosaic(image: &mut [u8]) {
        let mut camera = Scenario::demo(1, 1, 1).cameras.remove(0);
        (camera.resolution, camera.mosaic) = ([16, 16], Mosaic::Bayer);
        Demosaic::for_camera(&camera).unwrap().apply(image);
    }

    #[test]
    fn even_light_stays_and_edges_get_softer_with_a_zip() {
        let mut even = [120; 256];
        mosaic(&mut even);
        assert!(even.iter().all(|level| level.abs_diff(120) <= 1));
        let mut edge: Vec<u8> = (0..256)
            .map(|i| if i % 16 < 8 { 40 } else { 200 })
            .collect();
        mosaic(&mut edge);
        let row = |y: usize| [edge[y * 16 + 7], edge[y * 16 + 8]];
        assert!(row(6)[0] > 41 && row(6)[1] < 199, "{:?}", row(6));
        assert_ne!(row(6), row(7), "rows of red and rows of blue differ");
    }
}
