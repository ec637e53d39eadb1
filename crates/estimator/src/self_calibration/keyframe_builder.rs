//! Keyframes from the images of an instant: one for each rigid body, an object or a link of it.

use std::collections::BTreeMap;

use nalgebra::{Matrix6, Vector6};

use crate::FusionOptions;
use crate::measurement::corners::TagView;
use crate::measurement::view_equations::NoiseSource;
use crate::self_calibration::keyframes::{Keyframe, KeyframeView, Path, RelativeMotion};
use crate::site::{ModelledSite, ObjectImage};
use crate::time::seconds;
use crate::tracker::track::{MotionEstimate, Track};
use sextant_site_model::TagId;

/// Longest time between images that make one keyframe, ns: less than a period of most cameras.
pub(crate) const TOGETHER_NS: u64 = 25_000_000;

/// Standard deviation of the change of acceleration within a stretch of time, m/s³ and rad/s³: of what is carried by
/// hand.
const JERK: [f64; 2] = [20.0, 100.0];
/// The images of an object at an instant, the newest ones of other cameras among them, and the track that follows it.
pub(crate) struct KeyframeBuilder<'a> {
    pub object: usize,
    pub track: &'a Track,
    /// The first gives the keyframes their time.
    pub images: &'a [&'a ObjectImage],
    pub site: &'a ModelledSite,
    pub options: &'a FusionOptions,
}

impl KeyframeBuilder<'_> {
    /// For self-calibration: images are tied where the motion between them is predicted well, clocks included.
    pub fn for_calibration(&self) -> Vec<Keyframe> {
        let motion = |estimate: &MotionEstimate<'_>, image: &ObjectImage, view: &TagView| {
            let first = self.images[0];
            if first.capture_ns == image.capture_ns {
                return Some(None);
            }
            let (step, covariance) =
                estimate.step(view, seconds(first.capture_ns, image.capture_ns));
            let variance = [first, image].map(|one| one.clock.sigma_s(self.options).powi(2));
            let covariance = covariance + by_clock(&estimate.twist(view), variance.iter().sum());
            let motion = RelativeMotion { step, covariance };
            (!motion.is_vague()).then_some(Some(motion))
        };
        let mut keyframes = self.keyframes(motion, |_, _| true);
        let views = keyframes
            .iter_mut()
            .flat_map(|keyframe| &mut keyframe.views);
        // Self-calibration estimates the noise itself.
        views.for_each(|one| one.noise_factor = 1.0);
        keyframes
    }

    /// For diagnosis, where clock offsets are parameters: images are tied at their times by the estimated clocks.
    /// Leaves out the views that `is_usable` does not take.
    pub fn for_diagnosis(&self, is_usable: impl Fn(usize, TagId) -> bool) -> Vec<Keyframe> {
        let motion = |estimate: &MotionEstimate<'_>, image: &ObjectImage, view: &TagView| {
            let first = self.images[0];
            let dt = seconds(first.capture_ns, image.capture_ns);
            let dt = dt + self.clock_s(estimate, first) - self.clock_s(estimate, image);
            if dt == 0.0 {
                return Some(None);
            }
            let (step, covariance) = estimate.step(view, dt);
            Some(Some(RelativeMotion { step, covariance }))
        };
        self.keyframes(motion, is_usable)
    }

    /// For self-calibration where no two cameras expose at once: the images of a stretch of time, whose first instant
    /// is that of the track. The motion within it is sought with the pose.
    pub fn of_stretch(&self) -> Vec<Keyframe> {
        let motion = |estimate: &MotionEstimate<'_>, image: &ObjectImage, _: &TagView| {
            let after_s = self.after_s(image) - self.clock_s(estimate, image);
            let jerk = (after_s.powi(3) / 6.0).powi(2);
            let left = Vector6::from_fn(|axis, _| jerk * JERK[axis / 3].powi(2));
            Some(Some(RelativeMotion {
                step: Vector6::zeros(),
                covariance: Matrix6::from_diagonal(&left),
            }))
        };
        let mut keyframes = self.keyframes(motion, |_, _| true);
        for keyframe in &mut keyframes {
            let twist = keyframe.views[0].twist;
            keyframe.path = Some(Path {
                twist,
                acceleration: Vector6::zeros(),
            });
            for one in &mut keyframe.views {
                one.noise_factor = 1.0;
            }
        }
        keyframes.retain(|keyframe| keyframe.cameras().len() > 1);
        keyframes
    }

    /// From the track's time until an image, s.
    fn after_s(&self, image: &ObjectImage) -> f64 {
        seconds(self.track.time_ns, image.capture_ns)
    }

    /// How far the clock of an image is ahead, s, as it is estimated.
    fn clock_s(&self, estimate: &MotionEstimate<'_>, image: &ObjectImage) -> f64 {
        let offset = estimate.clock_offset(image.camera_index);
        offset.map_or(0.0, |offset| offset.offset_s)
    }

    fn keyframes(
        &self,
        motion: impl Fn(&MotionEstimate<'_>, &ObjectImage, &TagView) -> Option<Option<RelativeMotion>>,
        is_usable: impl Fn(usize, TagId) -> bool,
    ) -> Vec<Keyframe> {
        let Some(estimate) = self.track.motion_estimate() else {
            return Vec::new();
        };
        let mut bodies: BTreeMap<usize, Keyframe> = BTreeMap::new();
        let views = self.images.iter();
        let views = views.flat_map(|image| image.views.iter().map(move |view| (image, view)));
        for (image, view) in views.filter(|(image, view)| is_usable(image.camera_index, view.tag)) {
            let motion = motion(&estimate, image, view);
            let whitened = self.site.for_calibration(view, self.options);
            let Some((motion, whitened)) = motion.zip(whitened) else {
                continue;
            };
            let chain_link = view.chain_link.as_ref();
            let link = chain_link.map_or(0, |chain_link| chain_link.link);
            let keyframe = bodies.entry(link).or_insert_with(|| {
                let pose = estimate.pose(view);
                Keyframe {
                    object: self.object,
                    link,
                    time_ns: self.track.time_ns,
                    pose,
                    before: pose,
                    is_adjusted: false,
                    path: None,
                    views: Vec::new(),
                }
            });
            keyframe.views.push(KeyframeView {
                camera_index: image.camera_index,
                view: whitened,
                distortion_share: estimate.distortion_share(image.camera_index),
                noise_factor: noise_factor(&estimate, image.camera_index, view),
                clock_sigma_s: estimate
                    .clock_offset(image.camera_index)
                    .map_or(0.0, |_| image.clock.sigma_s(self.options)),
                twist: estimate.twist(view),
                after_s: self.after_s(image),
                clock_s: 0.0,
                motion,
            });
        }
        // One view says nothing that its pose does not take up.
        let bodies = bodies.into_values();
        bodies.filter(|body| body.views.len() > 1).collect()
    }
}

/// Factor on the variance of corners. A reported noise is not increased: what exceeds it may be a fault.
fn noise_factor(estimate: &MotionEstimate<'_>, camera_index: usize, view: &TagView) -> f64 {
    let factor = estimate.noise_factor(camera_index, view);
    match view.noise_source {
        NoiseSource::Detector => factor.min(1.0),
        NoiseSource::Nobody => factor,
    }
}

/// Covariance of a step by a clock offset of a variance, s².
fn by_clock(twist: &Vector6<f64>, variance: f64) -> Matrix6<f64> {
    twist * twist.transpose() * variance
}
