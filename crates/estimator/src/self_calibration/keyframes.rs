//! Keyframes: a bounded set of instants that show each object in many poses.

use std::collections::BTreeSet;

use nalgebra::{Matrix6, Vector6};
use sextant_geometry::{Pose, se3};

use crate::measurement::corners::TagView;
use sextant_site_model::TagId;

/// Most keyframes of an object.
const MOST_OF_AN_OBJECT: usize = 40;
/// Most keyframes of all objects.
const MOST: usize = 240;
/// Poses nearer than this, m and rad, show nothing new.
const NEAR: (f64, f64) = (0.03, 0.12);
/// The first keyframes of an object are taken whatever they show: they tell how exact the site's files are.
pub(crate) const FIRST: usize = 4;

/// One rigid body, an object or a link of it, at one instant in all images of it.
#[derive(Debug, Clone)]
pub(crate) struct Keyframe {
    /// Index of the object, and of its link; 0 where it is rigid.
    pub object: usize,
    pub link: usize,
    /// Capture time, ns.
    pub time_ns: u64,
    /// `world_from_object`, or from the link, as adjusted last.
    pub pose: Pose,
    /// As it was before the last adjustment.
    pub before: Pose,
    pub views: Vec<KeyframeView>,
}

/// One tag in one image.
#[derive(Debug, Clone)]
pub(crate) struct KeyframeView {
    pub camera_index: usize,
    /// Whitened by the detector's noise alone.
    pub view: TagView,
    /// Share of the distortion bias that the corners contain.
    pub distortion_share: f64,
    /// Factor on the variance of the camera's corners as tracking has estimated it.
    pub noise_factor: f64,
    /// Standard deviation of the camera's clock offset where it is estimated, s; 0 where the clock is taken to be right.
    pub clock_sigma_s: f64,
    /// Twist of the body, m/s and rad/s in world axes.
    pub twist: Vector6<f64>,
    /// Motion of the body from the keyframe's time until the image; `None` where both are taken at once.
    pub motion: Option<RelativeMotion>,
}

/// A step (dt, dr) of the object's pose in world axes, m and rad, with its covariance.
#[derive(Debug, Clone)]
pub(crate) struct RelativeMotion {
    pub step: Vector6<f64>,
    pub covariance: Matrix6<f64>,
}

/// Object and link: what is rigid.
pub(crate) type Body = (usize, usize);

/// The keyframes of all objects, oldest first.
#[derive(Debug, Default)]
pub(crate) struct Keyframes(Vec<Keyframe>);

/// Standard deviations of a predicted motion, m and rad, up to which it ties images to one another: errors of a vague prediction would pass
/// for errors of the cameras.
const MAX_MOTION_SIGMA: (f64, f64) = (0.0005, 0.01);

impl RelativeMotion {
    /// Whether the motion is predicted too vaguely to tie images.
    pub fn is_vague(&self) -> bool {
        let variance = |first: usize| self.covariance.fixed_view::<3, 3>(first, first).trace();
        variance(0) > MAX_MOTION_SIGMA.0.powi(2) || variance(3) > MAX_MOTION_SIGMA.1.powi(2)
    }
}

impl KeyframeView {
    /// Where the object is in this view if it is at a pose in the keyframe.
    pub fn pose(&self, keyframe: &Pose) -> Pose {
        match &self.motion {
            Some(motion) => se3::perturb(keyframe, &motion.step),
            None => *keyframe,
        }
    }
}

impl Keyframe {
    /// Object and link.
    pub fn body(&self) -> Body {
        (self.object, self.link)
    }

    /// The cameras that saw it.
    pub fn cameras(&self) -> BTreeSet<usize> {
        self.views.iter().map(|one| one.camera_index).collect()
    }

    fn pairs(&self) -> BTreeSet<(usize, TagId)> {
        let views = self.views.iter();
        views.map(|one| (one.camera_index, one.view.tag)).collect()
    }

    fn is_near(&self, other: &Self) -> bool {
        let apart = self.pose.inverse() * other.pose;
        apart.translation.vector.norm() < NEAR.0 && apart.rotation.angle() < NEAR.1
    }
}

impl Keyframes {
    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn as_slice(&self) -> &[Keyframe] {
        &self.0
    }

    pub fn iter(&self) -> impl Iterator<Item = &Keyframe> {
        self.0.iter()
    }

    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Keyframe> {
        self.0.iter_mut()
    }

    /// How many there are of an object.
    pub fn count(&self, object: usize) -> usize {
        self.0.iter().filter(|one| one.object == object).count()
    }

    pub fn newest(&self, object: usize) -> Option<&Keyframe> {
        self.0.iter().rev().find(|one| one.object == object)
    }

    fn own(&self, like: &Keyframe) -> impl Iterator<Item = &Keyframe> {
        self.0.iter().filter(|one| one.body() == like.body())
    }

    /// Whether a keyframe of the same body shows nothing new.
    pub fn show(&self, new: &Keyframe) -> bool {
        let pairs = new.pairs();
        let near = self.own(new).filter(|one| one.is_near(new));
        near.map(Keyframe::pairs).any(|near| pairs.is_subset(&near))
    }

    /// Whether an instant of a body is among them.
    pub fn has(&self, instant: &Keyframe) -> bool {
        self.own(instant).any(|one| one.time_ns == instant.time_ns)
    }

    /// Keeps a keyframe that shows the object in a new pose, or to another camera or by another tag than a near one. Where there are too
    /// many, the oldest goes.
    pub fn offer(&mut self, new: Keyframe) -> bool {
        let is_same = |one: &Keyframe| (one.body(), one.time_ns) == (new.body(), new.time_ns);
        if let Some(same) = self.0.iter_mut().find(|one| is_same(one)) {
            let is_more = new.views.len() > same.views.len();
            if is_more {
                *same = new;
            }
            return is_more;
        }
        let n_own = self.own(&new).count();
        if n_own >= FIRST && self.show(&new) {
            return false;
        }
        if n_own >= MOST_OF_AN_OBJECT || self.0.len() >= MOST {
            let full = n_own >= MOST_OF_AN_OBJECT;
            let goes = |one: &Keyframe| !full || one.body() == new.body();
            if let Some(oldest) = self.0.iter().position(goes) {
                self.0.remove(oldest);
            }
        }
        self.0.push(new);
        true
    }
}
