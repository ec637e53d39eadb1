//! Auto exposure: the exposure time and gain that a camera chooses for the light of its scene.
//!
//! The light is metered once, in the static picture; the sensor follows later changes with the camera's lag. Longer
//! exposures blur moving objects, gain amplifies noise.

use crate::scenario::{AutoExposure, SceneCamera};

/// Largest level that counts in the mean, since pixels saturate.
const WHITE: f32 = 255.0;

/// A camera with the exposure that it has chosen.
pub(super) struct Exposure {
    /// The camera, with the resulting exposure and noise.
    pub camera: SceneCamera,
    /// Factor on all light.
    brightness: f64,
}

impl Exposure {
    /// Without auto exposure the camera is unchanged; `still` is the static picture, grey levels.
    pub fn metered(camera: &SceneCamera, still: &[f32]) -> Self {
        let mut exposure = Self {
            camera: camera.clone(),
            brightness: 1.0,
        };
        if let Some(auto) = camera.auto_exposure {
            let sum: f64 = still.iter().map(|&level| f64::from(level.min(WHITE))).sum();
            exposure.aim(auto, sum / still.len().max(1) as f64);
        }
        exposure
    }

    fn aim(&mut self, auto: AutoExposure, mean: f64) {
        let wanted = auto.target / mean.max(1e-3);
        let now_ns = self.camera.exposure_ns.max(1) as f64;
        let longer = (wanted * now_ns).min(auto.max_exposure_ns as f64) / now_ns;
        let gain = (wanted / longer).clamp(1.0, auto.max_gain);
        self.camera.exposure_ns = (now_ns * longer).round() as u64;
        self.camera.noise *= gain;
        self.camera.shot_noise *= gain.sqrt();
        self.brightness = longer * gain;
    }

    /// Scales light by the exposure and gain in force.
    pub fn apply(&self, light: &mut [f32]) {
        if self.brightness != 1.0 {
            light
                .iter_mut()
                .for_each(|level| *level *= self.brightness as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scenario;

    #[test]
    fn exposure_grows_first_and_gain_with_the_noise_next() {
        let mut camera = Scenario::demo(1, 1, 1).cameras.remove(0);
        camera.noise = 2.0;
        camera.auto_exposure = Some(AutoExposure {
            target: 100.0,
            max_exposure_ns: 10_000_000,
            max_gain: 4.0,
            lag_s: 0.0,
        });
        let metered = |level: f32| {
            let exposure = Exposure::metered(&camera, &[level; 10]);
            let mut light = [level];
            exposure.apply(&mut light);
            (exposure.camera.exposure_ns, exposure.camera.noise, light[0])
        };
        assert_eq!(metered(200.0), (2_000_000, 2.0, 100.0));
        assert_eq!(metered(50.0), (8_000_000, 2.0, 100.0));
        assert_eq!(metered(20.0), (10_000_000, 4.0, 100.0));
        assert_eq!(metered(5.0), (10_000_000, 8.0, 50.0));
    }
}
