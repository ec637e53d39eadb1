//! The images of a scene by arrival.

use sextant_site_model::ImageObservation;

use crate::random::Random;
use crate::scene::{PERIOD_NS, START_NS, Scene, Shot};
use crate::view;

impl Scene {
    /// The images taken between two times, by arrival.
    pub fn shots(&self, from_s: f64, to_s: f64, random: &mut Random) -> Vec<Shot> {
        let mut shots = Vec::new();
        let period_s = PERIOD_NS as f64 * 1e-9;
        for (camera, clock) in self.clocks.iter().enumerate() {
            let first = ((from_s - clock.phase_s) / period_s).ceil().max(0.0) as u64;
            let times = (first..).map(|round| round as f64 * period_s + clock.phase_s);
            for taken_s in times.take_while(|taken_s| *taken_s < to_s) {
                self.take(camera, taken_s, &mut shots, random);
            }
        }
        shots.sort_by_key(|shot| shot.arrival_ns);
        shots
    }

    fn take(&self, camera: usize, taken_s: f64, shots: &mut Vec<Shot>, random: &mut Random) {
        let clock = self.clocks[camera];
        let tags = view::tags(self, camera, taken_s, random);
        let stamp_s = taken_s + clock.offset_s + clock.drift * taken_s;
        let image = ImageObservation {
            camera: self.truth.cameras()[camera].id.clone(),
            capture_ns: START_NS.wrapping_add_signed((stamp_s * 1e9).round() as i64),
            clock_error_ns: clock.stated_error_ns,
            exposure_ns: 0,
            resolution: None,
            tags,
        };
        if random.within(0.0, 1.0) < self.way.lost {
            return;
        }
        for _ in 0..1 + usize::from(random.within(0.0, 1.0) < self.way.twice) {
            let way_s = random.within(0.008, self.way.most_s);
            shots.push(Shot {
                arrival_ns: START_NS + ((taken_s + way_s) * 1e9) as u64,
                taken_s,
                image: image.clone(),
            });
        }
    }
}
