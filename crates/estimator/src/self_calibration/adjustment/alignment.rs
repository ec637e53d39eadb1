//! Keyframes by themselves: the pose that explains the views of one best, and the noise of each camera by what its
//! images leave alone.

use std::collections::BTreeMap;

use nalgebra::DVector;
use sextant_geometry::Pose;

use super::{Adjustment, COORDINATES, cameras_in_force, own_priors};
use crate::measurement::corners::{CalibratedCamera, ViewNoise, WeightedView, unseen_cost};
use crate::measurement::planar_poses::{area, branches};
use crate::measurement::view_equations::NoiseSource;
use crate::self_calibration::keyframes::{Keyframe, KeyframeView, Keyframes, Path};
use crate::self_calibration::normal_equations::{Weighting, normal};
use crate::self_calibration::parameters::{CLOCK, Source};
use crate::self_calibration::view_rows::{OF_POSE, square};
use crate::site::ModelledSite;

/// Steps by which a keyframe's pose is brought to its views, and tags of which it may begin.
const ALIGNING_STEPS: usize = 6;
const MOST_STARTS: usize = 2;
/// Step, m and rad, after which a pose is aligned.
const ALIGNED: f64 = 1e-7;
/// Robust squares for each coordinate up to which no other start is tried.
const EXPLAINED: f64 = 2.0;

/// Degrees of freedom as which a detector's own noise counts, and the default noise where none is given.
const FAITH: [f64; 2] = [30.0, 4.0];
/// Bounds of the factor on the variance of corners.
const BOUNDS: (f64, f64) = (1e-3, 1e4);

impl Adjustment {
    /// Brings a keyframe's pose to where it explains its views best by the models in force, whichever of the tracker's
    /// pose and those of single tags that is nearest to.
    pub fn align(&self, keyframe: &mut Keyframe, site: &ModelledSite) {
        let cameras = cameras_in_force(keyframe, site);
        for one in &mut keyframe.views {
            if let Some(place) = site.placement(&one.view.tag) {
                one.view.set_model(&place.tag);
            }
        }
        self.set_clocks(keyframe);
        let mut best: Option<(f64, Pose, Option<Path>)> = None;
        for start in starts(keyframe, &cameras) {
            let mut trial = keyframe.clone();
            trial.pose = start;
            self.minimise(&mut trial, &cameras);
            let cost = self.cost(&trial, &cameras);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, trial.pose, trial.path));
            }
            if cost <= EXPLAINED * COORDINATES * keyframe.views.len() as f64 {
                break;
            }
        }
        if let Some((_, pose, path)) = best {
            (keyframe.pose, keyframe.path) = (pose, path);
        }
    }

    /// The square of each view's residuals at the pose that explains the keyframe best, px^2; `None` of views that
    /// cannot be explained.
    pub fn squares_px(
        &self,
        mut keyframe: Keyframe,
        cameras: &BTreeMap<usize, CalibratedCamera>,
    ) -> Vec<Option<f64>> {
        self.set_clocks(&mut keyframe);
        self.minimise(&mut keyframe, cameras);
        let square = |one: &KeyframeView| {
            let (weighted, moving) = self.weighted(&keyframe, one, cameras)?;
            weighted.square_px(&moving)
        };
        keyframe.views.iter().map(square).collect()
    }

    /// Brings the pose to the minimum next to it.
    pub(super) fn minimise(
        &self,
        keyframe: &mut Keyframe,
        cameras: &BTreeMap<usize, CalibratedCamera>,
    ) {
        for _ in 0..ALIGNING_STEPS {
            let Some(step) = self.alignment_step(keyframe, cameras) else {
                break;
            };
            keyframe.advance(step.as_slice());
            if step.amax() < ALIGNED {
                break;
            }
        }
    }

    /// Gauss-Newton step of the keyframe's own unknowns.
    fn alignment_step(
        &self,
        keyframe: &Keyframe,
        cameras: &BTreeMap<usize, CalibratedCamera>,
    ) -> Option<DVector<f64>> {
        let (mut information, mut gradient) = own_priors(keyframe, &self.accelerations);
        for one in &keyframe.views {
            let Some(rows) = self.pose_rows(keyframe, one, cameras) else {
                continue;
            };
            let products = normal(&rows, one, Weighting::PLAIN);
            let lever = one.lever(keyframe);
            information += lever.tr_mul(&(products.fixed_view::<OF_POSE, OF_POSE>(0, 0) * &lever));
            gradient += lever.tr_mul(&products.fixed_view::<OF_POSE, 1>(0, OF_POSE));
        }
        let step = -information.cholesky()?.solve(&gradient);
        step.iter().all(|x| x.is_finite()).then_some(step)
    }

    /// Twice the robust cost of a keyframe.
    fn cost(&self, keyframe: &Keyframe, cameras: &BTreeMap<usize, CalibratedCamera>) -> f64 {
        let cost = |one: &KeyframeView| {
            let rows = self.pose_rows(keyframe, one, cameras);
            rows.map_or_else(unseen_cost, |rows| {
                one.view.noise_source.chi2(square(&rows))
            })
        };
        keyframe.views.iter().map(cost).sum()
    }

    /// Sets the clocks of a keyframe's views to what is known of them.
    pub(super) fn set_clocks(&self, keyframe: &mut Keyframe) {
        for one in &mut keyframe.views {
            let errors = self.errors.get(&Source::Camera(one.camera_index));
            one.clock_s = errors.map_or(0.0, |errors| errors[CLOCK]);
        }
    }

    /// Learns the noise of each camera from what its images leave by themselves, whatever is wrong with the other
    /// cameras.
    pub(super) fn learn_noise(
        &mut self,
        keyframes: &Keyframes,
        cameras: &BTreeMap<usize, CalibratedCamera>,
    ) {
        let mut sums: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        for keyframe in keyframes.iter() {
            for views in keyframe.images() {
                let camera = views[0].camera_index;
                let mut alone = Keyframe {
                    pose: views[0].pose(keyframe),
                    path: None,
                    views: views.to_vec(),
                    ..keyframe.clone()
                };
                alone.views.iter_mut().for_each(|one| one.motion = None);
                self.minimise(&mut alone, cameras);
                let faith = FAITH[usize::from(views[0].view.noise_source == NoiseSource::Nobody)];
                let (sum, freedom) = sums.entry(camera).or_insert((faith, faith));
                for one in views {
                    let Some(rows) = self.pose_rows(&alone, one, cameras) else {
                        continue;
                    };
                    let square = square(&rows);
                    *sum += one.view.noise_source.weight(square) * square * self.factor(one);
                    *freedom += COORDINATES - 6.0 / views.len() as f64;
                }
            }
        }
        for (camera, (sum, freedom)) in sums {
            self.noise
                .insert(camera, (sum / freedom).clamp(BOUNDS.0, BOUNDS.1));
        }
    }
}

/// Where a keyframe's pose may be: as it was tracked, and by each branch of its largest tags.
fn starts(keyframe: &Keyframe, cameras: &BTreeMap<usize, CalibratedCamera>) -> Vec<Pose> {
    let views = keyframe.views.iter();
    let weighted_views = views.filter_map(|one| {
        let camera = cameras.get(&one.camera_index)?;
        let noise = ViewNoise {
            factor: 1.0,
            distortion_share: one.distortion_share,
        };
        let weighted = WeightedView::new(one.camera_index, camera, &one.view, noise, None);
        Some(weighted)
    });
    let mut weighted_views: Vec<WeightedView<'_>> = weighted_views.collect();
    weighted_views.sort_by(|a, b| area(b).total_cmp(&area(a)));
    let branches = weighted_views.iter().take(MOST_STARTS).flat_map(branches);
    std::iter::once(keyframe.pose).chain(branches).collect()
}
