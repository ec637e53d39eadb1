//! What is published about an object at an instant.

use nalgebra::Matrix6;
use sextant_geometry::se3;

use super::hypothesis::Hypothesis;
use super::{Track, restlessness, seconds};
use crate::filter::corners::Sight;
use crate::filter::kinematics::symmetric;
use crate::{FusionOptions, ObjectEstimate, ObjectId, State};

/// What the images of an instant contributed.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Sighting {
    /// Cameras that took part.
    pub cameras: u32,
    /// Views that took part.
    pub tags: u32,
    /// Root mean square of the residuals in pixels.
    pub rms_px: f64,
    /// Camera index of each view that was refused.
    pub refused: Vec<usize>,
}

impl Sighting {
    pub fn of(best: &Hypothesis, sights: &[Sight<'_>]) -> Self {
        let pairs = || sights.iter().zip(&best.taken);
        let mut cameras: Vec<usize> = pairs()
            .filter(|(_, taken)| taken.part)
            .map(|(sight, _)| sight.camera_index)
            .collect();
        cameras.dedup();
        let tags = best.taken.iter().filter(|taken| taken.part).count() as u32;
        let square: f64 = best
            .taken
            .iter()
            .filter(|taken| taken.part)
            .map(|taken| taken.square_px)
            .sum();
        let rms_px = if tags > 0 {
            (square / (8.0 * f64::from(tags))).sqrt()
        } else {
            0.0
        };
        let refused = pairs()
            .filter(|(_, taken)| !taken.part)
            .map(|(sight, _)| sight.camera_index)
            .collect();
        Self {
            cameras: cameras.len() as u32,
            tags,
            rms_px,
            refused,
        }
    }
}

impl Track {
    /// The estimate for `time_ns`, at or after this track's instant; `None` where nothing is known.
    pub fn estimate(
        &self,
        object: &ObjectId,
        time_ns: u64,
        options: &FusionOptions,
    ) -> Option<ObjectEstimate> {
        let best = self.hypotheses.first()?;
        let dt = seconds(self.time_ns, time_ns);
        let now = best.state.predicted(dt, restlessness(options));
        let here = time_ns == self.time_ns;
        let covariance = self.covariance(dt, &now.covariance.fixed_view::<6, 6>(0, 0).into_owned());
        let sighting = if here {
            self.sighting.clone()
        } else {
            Sighting::default()
        };
        Some(ObjectEstimate {
            object: object.clone(),
            capture_ns: time_ns,
            world_from_object: now.pose,
            covariance,
            twist: now.twist,
            state: self.state(&covariance, sighting.tags, options),
            cameras: sighting.cameras,
            tags: sighting.tags,
            rms_px: sighting.rms_px,
        })
    }

    /// Of all that is possible, about the likeliest: the second moments of the mixture.
    fn covariance(&self, _dt: f64, of_best: &Matrix6<f64>) -> Matrix6<f64> {
        let best = &self.hypotheses[0].state;
        let mut sum = *of_best;
        let mut weights = 1.0;
        for other in &self.hypotheses[1..] {
            let weight = other.evidence.exp();
            let off = se3::difference(&other.state.pose, &best.pose);
            let own = other.state.covariance.fixed_view::<6, 6>(0, 0);
            sum += (own + off * off.transpose()) * weight;
            weights += weight;
        }
        symmetric(&(sum / weights))
    }

    fn state(&self, covariance: &Matrix6<f64>, tags: u32, options: &FusionOptions) -> State {
        let rivals = self
            .hypotheses
            .get(1)
            .is_some_and(|other| other.evidence > -options.trusted_odds);
        let widest = |from: usize| {
            covariance
                .fixed_view::<3, 3>(from, from)
                .into_owned()
                .symmetric_eigenvalues()
                .max()
                .max(0.0)
                .sqrt()
        };
        if rivals || widest(0) > options.vague_position || widest(3) > options.vague_attitude {
            State::Initialising
        } else if tags == 0 {
            State::Coasting
        } else {
            State::Tracking
        }
    }
}
