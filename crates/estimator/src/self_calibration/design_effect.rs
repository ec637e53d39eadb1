//! Number of views that count as one. Errors of detector, lens and print are much the same in all views of a tag by a
//! camera, so that views say less than as many independent ones: by the design effect 1 + (m - 1) r of clusters of m
//! views whose errors correlate by r (L. Kish, Survey Sampling, 1965, sec. 5.4).

use std::collections::BTreeSet;

use crate::self_calibration::keyframes::Keyframes;

/// Factor on the variance of views.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DesignEffect(pub f64);

/// Before anything is known, and the degrees of freedom as which that counts.
const FIRST: f64 = 4.0;
const FAITH: f64 = 30.0;
/// Bound of the effect.
const MOST: f64 = 30.0;
/// Coordinates of a view, and of the pose of a keyframe.
const COORDINATES: f64 = 8.0;
const OF_POSE: f64 = 6.0;

impl Default for DesignEffect {
    fn default() -> Self {
        Self(FIRST)
    }
}

impl DesignEffect {
    /// Learns from the squares that the views leave, in units of each camera's noise as its images show it one by one
    /// and divided by the effect so far. What the views leave jointly beyond that is common to the views of a tag by a
    /// camera. `determined` is the number of the site's errors that the views determine.
    pub fn learn(&mut self, keyframes: &Keyframes, determined: f64, left: f64) {
        let views = || keyframes.iter().flat_map(|keyframe| &keyframe.views);
        let pairs = views().map(|one| (one.camera_index, one.view.tag));
        let n_pairs = pairs.collect::<BTreeSet<_>>().len();
        let n_views = views().count() as f64;
        let freedom = COORDINATES * n_views - OF_POSE * keyframes.len() as f64 - determined;
        let left = left * self.0 + FAITH * FIRST;
        let excess = (left / (freedom.max(0.0) + FAITH)).max(1.0);
        let in_cluster = n_views / n_pairs.max(1) as f64;
        let effect = excess * (1.0 + (in_cluster - 1.0) * (1.0 - excess.recip()));
        self.0 = effect.min(MOST);
    }
}
