//! The sensor: brightness variation, electronic and photon noise, and quantisation to eight bits.
//!
//! Flicker of the camera changes whole images; flicker of the light acts over the exposure of each row, and auto
//! exposure compensates for it with a lag. From the frame on, all arithmetic is in integers, 64ths of a grey level, so
//! that the bytes are equal on all platforms. Noise comes from a table of normal numbers: each block of a row adds two
//! runs of it that begin at random positions.

use crate::random::{Random, key_of_name};
use crate::scenario::{Flicker, Scenario, SceneCamera};
use std::f64::consts::TAU;

/// Steps of the frame in a grey level.
pub(super) const STEPS: f64 = (1 << STEP_BITS) as f64;
const STEP_BITS: u32 = 6;
/// Pixels that share a run of the noise table.
const BLOCK: usize = 64;
/// Positions in the table at which a run may begin; a power of two.
const PLACES: usize = 1 << 14;
/// Fractional bits of brightness and noise scale.
const BRIGHTNESS_BITS: u32 = 12;
/// Grey levels for which the noise is tabulated.
const LEVELS: usize = 512;

/// Largest noise, grey levels, for which sums fit into 32 bits.
const LOUDEST: f64 = 80.0;

/// Auto exposure compensates for light down to this share of the usual.
const DARKEST: f64 = 0.05;

/// Converts light to bytes.
pub(super) struct Sensor {
    camera: SceneCamera,
    light_flicker: Flicker,
    keys: [u64; 2],
    /// Noise at level 255.
    noise: Vec<i16>,
    /// Noise at each level relative to that.
    noise_scale: Vec<i32>,
}

impl Sensor {
    /// The sensor of a scenario's camera, possibly with another exposure and noise.
    pub fn new(scenario: &Scenario, camera: &SceneCamera) -> Self {
        let keys = [scenario.seed, key_of_name(&camera.id)];
        let mut random = Random::from_keys(&[keys[0], keys[1], key_of_name("noise table")]);
        // The sum of two runs, hence the root.
        let at_white = camera.noise.hypot(camera.shot_noise).min(LOUDEST);
        let sigma = at_white * STEPS / std::f64::consts::SQRT_2;
        let noise = || (random.normal() * sigma).round() as i16;
        Self {
            camera: camera.clone(),
            light_flicker: scenario.light.flicker,
            noise_scale: noise_scale(camera),
            keys,
            noise: std::iter::repeat_with(noise).take(PLACES + BLOCK).collect(),
        }
    }

    /// The image of the frame at this time.
    pub fn expose(&self, frame: &[i16], true_capture_ns: u64, image: &mut [u8]) {
        let width = self.camera.resolution[0] as usize;
        let mut random = Random::from_keys(&[self.keys[0], self.keys[1], true_capture_ns]);
        let rows = frame.chunks_exact(width).zip(image.chunks_exact_mut(width));
        for (y, (frame, image)) in rows.enumerate() {
            let brightness = self.brightness(true_capture_ns, y);
            for (light, pixels) in frame.chunks(BLOCK).zip(image.chunks_mut(BLOCK)) {
                let bits = random.bits();
                let noise = [self.run(bits), self.run(bits >> 32)];
                self.expose_block(light, brightness, noise, pixels);
            }
        }
    }

    fn run(&self, bits: u64) -> &[i16] {
        let start = bits as usize % PLACES;
        &self.noise[start..start + BLOCK]
    }

    fn brightness(&self, true_capture_ns: u64, row: usize) -> i32 {
        let mut factor = 1.0 + swing(&self.camera.flicker, true_capture_ns);
        if self.light_flicker.amplitude != 0.0 {
            factor *= self.light(true_capture_ns, row as f64);
            if let Some(auto) = self.camera.auto_exposure {
                let lag_ns = (auto.lag_s * 1e9).round() as u64;
                let middle = 0.5 * f64::from(self.camera.resolution[1] - 1);
                let metered = self.light(true_capture_ns.saturating_sub(lag_ns), middle);
                factor /= metered.max(DARKEST);
            }
        }
        (f64::from(1 << BRIGHTNESS_BITS) * factor).round() as i32
    }

    /// Mean light over the exposure of a row, relative to its usual strength.
    fn light(&self, true_capture_ns: u64, row: f64) -> f64 {
        let after_ns = (self.camera.row_after_s(row) * 1e9).round() as i64;
        let half_angle =
            0.5 * TAU * self.light_flicker.rate_hz * self.camera.exposure_ns as f64 * 1e-9;
        let share = if half_angle > 0.0 {
            libm::sin(half_angle) / half_angle
        } else {
            1.0
        };
        let row_ns = true_capture_ns.saturating_add_signed(after_ns);
        1.0 + share * swing(&self.light_flicker, row_ns)
    }

    fn expose_block(&self, light: &[i16], brightness: i32, noise: [&[i16]; 2], pixels: &mut [u8]) {
        let half = 1 << (STEP_BITS - 1);
        let noise = noise[0].iter().zip(noise[1]);
        for ((pixel, &light), (&a, &b)) in pixels.iter_mut().zip(light).zip(noise) {
            let level = (i32::from(light) * brightness) >> BRIGHTNESS_BITS;
            let scale = self.noise_scale[((level >> STEP_BITS) as usize).min(LEVELS - 1)];
            let noise = ((i32::from(a) + i32::from(b)) * scale) >> BRIGHTNESS_BITS;
            let level = (level + noise + half) >> STEP_BITS;
            *pixel = level.clamp(0, 255) as u8;
        }
    }
}

/// Change of a brightness of 1 by a flicker at a time.
fn swing(flicker: &Flicker, true_ns: u64) -> f64 {
    if flicker.amplitude == 0.0 || flicker.rate_hz == 0.0 {
        return 0.0;
    }
    let period_ns = ((1e9 / flicker.rate_hz).round() as u64).max(1);
    let angle = (true_ns % period_ns) as f64 / period_ns as f64 * TAU;
    flicker.amplitude * libm::sin(angle)
}

/// Noise at each level relative to that at level 255: photon noise grows with the root of the light.
fn noise_scale(camera: &SceneCamera) -> Vec<i32> {
    let one = f64::from(1 << BRIGHTNESS_BITS);
    let at_white = camera.noise.hypot(camera.shot_noise);
    let scale = |level: usize| {
        if camera.shot_noise == 0.0 {
            return one as i32;
        }
        let photons = camera.shot_noise * f64::sqrt(level as f64 / 255.0);
        (one * camera.noise.hypot(photons) / at_white).round() as i32
    };
    (0..LEVELS).map(scale).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    fn exposed(change: impl FnOnce(&mut SceneCamera), level: f64, true_ns: u64) -> Vec<u8> {
        exposed_in(Flicker::default(), change, level, true_ns)
    }

    fn exposed_in(
        light_flicker: Flicker,
        change: impl FnOnce(&mut SceneCamera),
        level: f64,
        true_ns: u64,
    ) -> Vec<u8> {
        let mut scenario = Scenario::demo(1, 1, 5);
        scenario.light.flicker = light_flicker;
        let mut camera = scenario.cameras[0].clone();
        camera.flicker = Flicker::default();
        change(&mut camera);
        let n_pixels = (camera.resolution[0] * camera.resolution[1]) as usize;
        let frame = vec![(level * STEPS).round() as i16; n_pixels];
        let mut image = vec![0; n_pixels];
        Sensor::new(&scenario, &camera).expose(&frame, true_ns, &mut image);
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
        // Rounding to whole levels adds a variance of a twelfth.
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

    #[test]
    fn lamps_on_mains_leave_bands_where_the_shutter_rolls() {
        let flicker = Flicker {
            amplitude: 0.3,
            rate_hz: 100.0,
        };
        let rows = |line_delay_s: f64, exposure_ns: u64| {
            let change = |camera: &mut SceneCamera| {
                camera.noise = 0.0;
                (camera.line_delay_s, camera.exposure_ns) = (line_delay_s, exposure_ns);
            };
            let image = exposed_in(flicker, change, 100.0, 1_000_000_000);
            image.chunks(640).map(|row| row[0]).collect::<Vec<_>>()
        };
        let spread = |rows: &[u8]| rows.iter().max().unwrap() - rows.iter().min().unwrap();
        assert_eq!(spread(&rows(0.0, 1_000_000)), 0);
        let bands = rows(3e-5, 1_000_000);
        assert!((55..=60).contains(&spread(&bands)), "{}", spread(&bands));
        // A period of 10 ms is 333 rows.
        assert!(
            bands[..147]
                .iter()
                .zip(&bands[333..])
                .all(|(a, b)| a.abs_diff(*b) <= 1)
        );
        assert!(
            spread(&rows(3e-5, 10_000_000)) <= 1,
            "a whole period is even"
        );
    }

    #[test]
    fn auto_exposure_makes_up_for_the_light_of_a_lag_ago() {
        let flicker = Flicker {
            amplitude: 0.5,
            rate_hz: 1.0,
        };
        let level = |lag_s: f64, true_ns: u64| {
            let change = |camera: &mut SceneCamera| {
                camera.noise = 0.0;
                camera.auto_exposure = Some(crate::AutoExposure {
                    target: 100.0,
                    max_exposure_ns: 4_000_000,
                    max_gain: 4.0,
                    lag_s,
                });
            };
            exposed_in(flicker, change, 100.0, true_ns)[0]
        };
        assert_eq!(
            [level(0.0, 250_000_000), level(0.0, 750_000_000)],
            [100, 100]
        );
        assert_eq!(
            [level(0.5, 1_250_000_000), level(0.5, 1_750_000_000)],
            [255, 33]
        );
    }

    #[test]
    fn noise_of_photons_grows_with_the_root_of_the_light() {
        let sigma = |level| {
            let image = exposed(
                |camera| (camera.noise, camera.shot_noise) = (0.0, 8.0),
                level,
                7,
            );
            let n = image.len() as f64;
            let squares = image.iter().map(|&v| (f64::from(v) - level).powi(2));
            f64::sqrt(squares.sum::<f64>() / n - 1.0 / 12.0)
        };
        assert!((sigma(200.0) - 8.0 * f64::sqrt(200.0 / 255.0)).abs() < 0.1);
        assert!((sigma(50.0) - 8.0 * f64::sqrt(50.0 / 255.0)).abs() < 0.1);
    }
}
