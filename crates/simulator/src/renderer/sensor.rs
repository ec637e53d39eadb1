//! The sensor: brightness that swings, noise, and eight bits.
//!
//! Integers only from the frame on, in 64ths of a grey level, so that the bytes are the same everywhere. Noise comes from a
//! table of normal numbers: each block of a row adds two runs of it that begin at random places.

use crate::random::{Random, key_of_name};
use crate::scenario::{Flicker, SceneCamera};
use std::f64::consts::TAU;

/// Steps of the frame's numbers in a grey level.
pub(super) const STEPS: f64 = (1 << STEP_BITS) as f64;
const STEP_BITS: u32 = 6;
/// Pixels that share a run of the noise table.
const BLOCK: usize = 64;
/// Places in the table where a run may begin; a power of two.
const PLACES: usize = 1 << 14;
/// Fractional bits of the brightness.
const BRIGHTNESS_BITS: u32 = 12;

/// Makes bytes of light.
pub(super) struct Sensor {
    width: usize,
    flicker: Flicker,
    keys: [u64; 2],
    noise: Vec<i16>,
}

impl Sensor {
    pub fn new(seed: u64, camera: &SceneCamera) -> Self {
        let keys = [seed, key_of_name(&camera.id)];
        let mut random = Random::from_keys(&[keys[0], keys[1], key_of_name("noise table")]);
        // Two runs are added, hence the root.
        let sigma = camera.noise * STEPS / std::f64::consts::SQRT_2;
        let noise = || (random.normal() * sigma).round() as i16;
        Self {
            width: camera.resolution[0] as usize,
            flicker: camera.flicker,
            keys,
            noise: std::iter::repeat_with(noise).take(PLACES + BLOCK).collect(),
        }
    }

    /// The image that the frame gives at this time.
    pub fn expose(&self, frame: &[i16], true_capture_ns: u64, image: &mut [u8]) {
        let brightness = self.brightness(true_capture_ns);
        let mut random = Random::from_keys(&[self.keys[0], self.keys[1], true_capture_ns]);
        let rows = frame
            .chunks_exact(self.width)
            .zip(image.chunks_exact_mut(self.width));
        for (frame, image) in rows {
            for (light, pixels) in frame.chunks(BLOCK).zip(image.chunks_mut(BLOCK)) {
                let bits = random.bits();
                expose_block(
                    light,
                    brightness,
                    [self.run(bits), self.run(bits >> 32)],
                    pixels,
                );
            }
        }
    }

    fn run(&self, bits: u64) -> &[i16] {
        let start = bits as usize % PLACES;
        &self.noise[start..start + BLOCK]
    }

    fn brightness(&self, true_ns: u64) -> i32 {
        let one = f64::from(1 << BRIGHTNESS_BITS);
        if self.flicker.amplitude == 0.0 || self.flicker.rate_hz == 0.0 {
            return one as i32;
        }
        let period_ns = ((1e9 / self.flicker.rate_hz).round() as u64).max(1);
        let angle = (true_ns % period_ns) as f64 / period_ns as f64 * TAU;
        (one * (1.0 + self.flicker.amplitude * libm::sin(angle))).round() as i32
    }
}

fn expose_block(light: &[i16], brightness: i32, noise: [&[i16]; 2], pixels: &mut [u8]) {
    let half = 1 << (STEP_BITS - 1);
    let noise = noise[0].iter().zip(noise[1]);
    for ((pixel, &light), (&a, &b)) in pixels.iter_mut().zip(light).zip(noise) {
        let level = (i32::from(light) * brightness) >> BRIGHTNESS_BITS;
        let level = (level + i32::from(a) + i32::from(b) + half) >> STEP_BITS;
        *pixel = level.clamp(0, 255) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    fn exposed(change: impl FnOnce(&mut SceneCamera), level: f64, true_ns: u64) -> Vec<u8> {
        let mut camera = Scenario::demo(1, 1, 1).cameras.remove(0);
        camera.flicker = Flicker::default();
        change(&mut camera);
        let n_pixels = (camera.resolution[0] * camera.resolution[1]) as usize;
        let frame = vec![(level * STEPS).round() as i16; n_pixels];
        let mut image = vec![0; n_pixels];
        Sensor::new(5, &camera).expose(&frame, true_ns, &mut image);
        image
    }

    #[test]
    fn noise_has_the_stated_sigma_and_no_bias() {
        let image = exposed(|camera| camera.noise = 4.0, 100.0, 7);
        let n = image.len() as f64;
        let mean = image.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
        let variance = image
            .iter()
            .map(|&v| (f64::from(v) - mean).powi(2))
            .sum::<f64>()
            / n;
        assert!((mean - 100.0).abs() < 0.1, "mean {mean}");
        // Rounding to whole levels adds a twelfth.
        assert!(
            (variance - (16.0 + 1.0 / 12.0)).abs() < 0.5,
            "variance {variance}"
        );
    }

    #[test]
    fn noise_differs_from_image_to_image_and_from_row_to_row() {
        let (first, second) = (exposed(|_| (), 100.0, 1), exposed(|_| (), 100.0, 2));
        assert_ne!(first, second);
        assert_ne!(first[..640], first[640..1280]);
        assert_eq!(first, exposed(|_| (), 100.0, 1));
    }

    #[test]
    fn levels_are_rounded_and_stay_within_a_byte() {
        let still = |level| exposed(|camera| camera.noise = 0.0, level, 1)[0];
        assert_eq!(
            [still(99.4), still(99.6), still(300.0), still(0.0)],
            [99, 100, 255, 0]
        );
    }

    #[test]
    fn flicker_changes_the_brightness() {
        let flicker = |true_ns| {
            let change = |camera: &mut SceneCamera| {
                camera.noise = 0.0;
                camera.flicker = Flicker {
                    amplitude: 0.1,
                    rate_hz: 1.0,
                };
            };
            exposed(change, 100.0, true_ns)[0]
        };
        assert_eq!(
            [flicker(0), flicker(250_000_000), flicker(750_000_000)],
            [100, 110, 90]
        );
    }
}
