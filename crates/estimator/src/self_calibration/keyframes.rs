//! Keyframes: a bounded set of instants that show each object in many poses.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Const, Dyn, Matrix6, OMatrix, SMatrix, Vector6};
use sextant_geometry::{Pose, se3, so3};

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

/// One rigid body, an object or a link of it, at one instant in all images of it, or over a stretch of time so short
/// that its motion has a uniform acceleration.
#[derive(Debug, Clone)]
pub(crate) struct Keyframe {
    /// Index of the object, and of its link; 0 where it is rigid.
    pub object: usize,
    pub link: usize,
    /// Capture time, ns.
    pub time_ns: u64,
    /// `world_from_object`, or from the link, as adjusted last.
    pub pose: Pose,
    /// As the trackers have it.
    pub before: Pose,
    /// Whether it has been adjusted; its pose is the trackers' up to then.
    pub is_adjusted: bool,
    /// How it moves; `None` where all images are of one instant.
    pub path: Option<Path>,
    pub views: Vec<KeyframeView>,
}

/// Motion of a body about an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Path {
    /// Velocity and angular velocity at the instant, m/s and rad/s in world axes.
    pub twist: Vector6<f64>,
    /// Their rates of change, m/s² and rad/s².
    pub acceleration: Vector6<f64>,
}

/// How a step of a keyframe's unknowns, its pose and its path, moves the body in a view.
pub(crate) type Lever = OMatrix<f64, Const<6>, Dyn>;

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
    /// Standard deviation of the camera's clock offset where it is estimated, s; 0 where the clock is taken to be
    /// right.
    pub clock_sigma_s: f64,
    /// Twist of the body, m/s and rad/s in world axes.
    pub twist: Vector6<f64>,
    /// From the keyframe's time until the image, s, by the corrected timestamps, and by how much the camera's clock is
    /// ahead of the reference as it is adjusted; without meaning where the keyframe has no path.
    pub after_s: f64,
    pub clock_s: f64,
    /// Motion of the body from the keyframe's time until the image, or what its path leaves of it; `None` where both
    /// are taken at once.
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
#[derive(Debug, Clone, Default)]
pub(crate) struct Keyframes(Vec<Keyframe>);

/// Standard deviations of a predicted motion, m and rad, up to which it ties images to one another: errors of a vague
/// prediction would pass for errors of the cameras.
const MAX_MOTION_SIGMA: (f64, f64) = (0.0005, 0.01);

impl RelativeMotion {
    /// Whether the motion is predicted too vaguely to tie images.
    pub fn is_vague(&self) -> bool {
        let variance = |first: usize| self.covariance.fixed_view::<3, 3>(first, first).trace();
        variance(0) > MAX_MOTION_SIGMA.0.powi(2) || variance(3) > MAX_MOTION_SIGMA.1.powi(2)
    }
}

impl Path {
    /// Motion from the instant until `dt` seconds later, in world axes.
    pub fn step(&self, dt: f64) -> Vector6<f64> {
        self.twist * dt + self.acceleration * (0.5 * dt * dt)
    }
}

impl KeyframeView {
    /// Where the object is in this view.
    pub fn pose(&self, keyframe: &Keyframe) -> Pose {
        match (&self.motion, &keyframe.path) {
            (Some(motion), _) if motion.step != Vector6::zeros() => {
                se3::perturb(&keyframe.pose, &motion.step)
            }
            (_, Some(path)) => {
                se3::perturb(&keyframe.pose, &path.step(self.after_s - self.clock_s))
            }
            _ => keyframe.pose,
        }
    }

    /// Twist of the body in this view, m/s and rad/s in world axes.
    pub fn twist(&self, keyframe: &Keyframe) -> Vector6<f64> {
        keyframe.path.map_or(self.twist, |path| {
            path.twist + path.acceleration * (self.after_s - self.clock_s)
        })
    }

    /// How a step of the keyframe's unknowns moves the object in this view.
    pub fn lever(&self, keyframe: &Keyframe) -> Lever {
        let mut lever = Lever::identity(keyframe.n_unknowns());
        let Some(path) = &keyframe.path else {
            return lever;
        };
        let dt = self.after_s - self.clock_s;
        let turn = path.step(dt).fixed_rows::<3>(3).into_owned();
        let turned = so3::exp(&turn).to_rotation_matrix();
        lever
            .fixed_view_mut::<3, 3>(3, 3)
            .copy_from(turned.matrix());
        let mut by_path = SMatrix::<f64, 6, 6>::identity();
        by_path
            .fixed_view_mut::<3, 3>(3, 3)
            .copy_from(&so3::left_jacobian(&turn));
        lever.fixed_columns_mut::<6>(6).copy_from(&(by_path * dt));
        let by_acceleration = by_path * (0.5 * dt * dt);
        lever.fixed_columns_mut::<6>(12).copy_from(&by_acceleration);
        lever
    }
}

impl Keyframe {
    /// Index of the object and the link that the views show.
    pub fn body(&self) -> Body {
        (self.object, self.link)
    }

    /// What tells it from others: its body and its time.
    pub fn key(&self) -> (Body, u64) {
        (self.body(), self.time_ns)
    }

    /// Number of unknowns of its own: the pose, and the path where it moves.
    pub fn n_unknowns(&self) -> usize {
        if self.path.is_some() { 18 } else { 6 }
    }

    /// A step of its unknowns.
    pub fn advance(&mut self, step: &[f64]) {
        let six = |first: usize| Vector6::from_column_slice(&step[first..first + 6]);
        self.pose = se3::perturb(&self.pose, &six(0));
        if let Some(path) = &mut self.path {
            path.twist += six(6);
            path.acceleration += six(12);
        }
    }

    /// Its views, image by image.
    pub fn images(&self) -> impl Iterator<Item = &[KeyframeView]> {
        let is_same = |a: &KeyframeView, b: &KeyframeView| {
            (a.camera_index, a.after_s) == (b.camera_index, b.after_s)
        };
        self.views.chunk_by(is_same)
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

    /// Leaves the images of some cameras out where the body moves; what no two other cameras show then goes.
    pub fn forget_clocks(&mut self, is_affected: impl Fn(usize) -> bool) {
        self.0.retain_mut(|keyframe| {
            let n_views = keyframe.views.len();
            if keyframe.path.is_some() {
                keyframe
                    .views
                    .retain(|view| !is_affected(view.camera_index));
            }
            keyframe.views.len() == n_views || keyframe.cameras().len() > 1
        });
    }

    /// How many there are of an object.
    pub fn count(&self, object: usize) -> usize {
        self.0.iter().filter(|one| one.object == object).count()
    }

    pub fn newest_adjusted(&self, object: usize) -> Option<&Keyframe> {
        let mut newest_first = self.0.iter().rev();
        newest_first.find(|one| one.object == object && one.is_adjusted)
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

    /// Takes over poses and models of the same keyframes as they were adjusted.
    pub fn take_adjusted(&mut self, adjusted: &Self) {
        let adjusted: BTreeMap<_, _> = adjusted.iter().map(|one| (one.key(), one)).collect();
        for own in &mut self.0 {
            let same = adjusted.get(&own.key());
            if let Some(same) = same.filter(|same| same.views.len() == own.views.len()) {
                let before = own.before;
                *own = (*same).clone();
                own.before = before;
            }
        }
    }

    /// The trackers have moved along with what was adjusted. So do the keyframes that were not, whose poses are the
    /// trackers'.
    pub fn move_along(&mut self) {
        let objects: BTreeSet<usize> = self.0.iter().map(|one| one.object).collect();
        let motion = |object: usize| {
            let newest = self.newest_adjusted(object)?;
            Some((object, newest.pose * newest.before.inverse()))
        };
        let motions: BTreeMap<usize, Pose> = objects.into_iter().filter_map(motion).collect();
        for own in &mut self.0 {
            if let Some(motion) = motions.get(&own.object).filter(|_| !own.is_adjusted) {
                own.pose = motion * own.pose;
            }
            own.before = own.pose;
        }
    }

    /// Keeps a keyframe that shows the object in a new pose, or to another camera or by another tag than a near one.
    /// Where there are too many, the oldest goes.
    pub fn offer(&mut self, new: Keyframe) -> bool {
        let is_same = |one: &Keyframe| one.key() == new.key();
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
