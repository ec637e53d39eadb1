//! What the cameras saw of each object lately, as the views of one instant.
//!
//! Cameras that expose at different times are brought to one time in the image: a corner moves on as it did between the
//! last two images. No pose and no model takes part in that, so that nothing that is wrong with them can mislead it.

use std::array::from_fn;
use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Vector2;
use sextant_mistakes::{Instant, View};
use sextant_site_model::TagId;

use crate::FusionOptions;
use crate::measurement::corners::TagView;
use crate::site::ObjectImage;
use crate::site::indexed_site::IndexedSite;
use crate::time::seconds;

/// Longest time between the two images by which corners are moved on, s: a hand turns back in less than a longer one.
const LONGEST_STEP_S: f64 = 0.27;
/// Most times that between them by which corners are moved on.
const MOST_STEPS: f64 = 1.5;
/// Share of their motion, and of how it changed last, by which corners that are moved on are uncertain: motion that
/// turns back is two of it off.
const UNCERTAIN_MOTION: f64 = 1.0;
const UNCERTAIN_CHANGE: f64 = 0.5;
/// Longest time between two images for what they show to jump, s: in a longer one an object may be moved.
const LONGEST_JUMP_S: f64 = 0.04;
/// Standard deviation of a clock that is not verified, s: larger offsets are searched for elsewhere.
const USUAL_CLOCK_S: f64 = 0.005;
/// A corner jumps that is off by more than so many px and such a share of its motion.
const JUMP_PX: f64 = 4.0;
const JUMP_SHARE: f64 = 1.0;
/// Time for which a jump tells which camera has been moved, ns.
const LATELY_NS: u64 = 700_000_000;
/// Most views of an instant: those of the largest tags.
const MOST_VIEWS: usize = 24;

/// The last three images of each object by each camera.
#[derive(Debug, Default)]
pub(crate) struct Evidence {
    /// By object and camera index, the newer first.
    images: BTreeMap<(usize, usize), [Option<Arc<ObjectImage>>; 3]>,
    /// By how much the clock of a camera is ahead where that is known, s, by its index: not subtracted from its stamps.
    ahead_s: BTreeMap<usize, f64>,
    /// When what a camera sees last jumped, by its index, ns.
    jumped_ns: BTreeMap<usize, u64>,
}

impl Evidence {
    /// Takes an image of an object in, by a clock that is ahead by `ahead_s` seconds.
    pub fn take(&mut self, object: usize, image: &Arc<ObjectImage>, ahead_s: f64) {
        self.ahead_s.insert(image.camera_index, ahead_s);
        let images = self.images.entry((object, image.camera_index)).or_default();
        let is_newer = |newest: &Arc<ObjectImage>| image.capture_ns > newest.capture_ns;
        let is_new = images[0].as_ref().is_none_or(is_newer);
        // No two pictures are equal: one that is stands still.
        let is_same = |newest: &Arc<ObjectImage>| has_same_corners(newest, image);
        if !is_new || images[0].as_ref().is_some_and(is_same) {
            return;
        }
        if let [Some(newest), Some(before), _] = &images
            && is_jump([before, newest, image])
        {
            self.jumped_ns.insert(image.camera_index, image.capture_ns);
        }
        images[2] = images[1].take();
        images[1] = images[0].replace(image.clone());
    }

    /// Whether what a camera sees has jumped lately.
    pub fn has_jumped(&self, camera: usize, time_ns: u64) -> bool {
        let jumped_ns = self.jumped_ns.get(&camera);
        jumped_ns.is_some_and(|jumped_ns| jumped_ns.abs_diff(time_ns) <= LATELY_NS)
    }

    /// Forgets all images and jumps: the times of new ones mean something else.
    pub fn clear(&mut self) {
        self.images.clear();
        self.jumped_ns.clear();
    }

    /// What the clock of a camera shows at a time of the reference clock, ns.
    fn stamp_ns(&self, time_ns: u64, camera: usize) -> u64 {
        let ahead_s = self.ahead_s.get(&camera).copied().unwrap_or(0.0);
        time_ns.saturating_add_signed((ahead_s * 1e9) as i64)
    }

    /// An object at the time of an image of it, body by body; those seen by two or more tags.
    pub fn instants(
        &self,
        object: usize,
        image: &ObjectImage,
        site: &IndexedSite,
        options: &FusionOptions,
    ) -> Vec<Instant> {
        let mut bodies: BTreeMap<usize, Vec<View>> = BTreeMap::new();
        let ahead_s = self.ahead_s.get(&image.camera_index).copied();
        let behind_ns = (-ahead_s.unwrap_or(0.0) * 1e9) as i64;
        let time_ns = image.capture_ns.saturating_add_signed(behind_ns);
        for ((_, camera), [newest, before, first]) in
            self.images.range((object, 0)..(object + 1, 0))
        {
            let Some(newest) = newest else {
                continue;
            };
            let time_ns = self.stamp_ns(time_ns, *camera);
            let earlier = [before.as_deref(), first.as_deref()];
            let extrapolation = Extrapolation::new(newest, earlier, time_ns, options);
            let (Some(extrapolation), true) = (extrapolation, site.has_camera(*camera)) else {
                continue;
            };
            for view in singles(&newest.views) {
                let tag = site.tag(&view.tag);
                let view = tag.and_then(|tag| extrapolation.view(view, [*camera, tag], options));
                if let Some(view) = view {
                    bodies.entry(site.body(view.tag)).or_default().push(view);
                }
            }
        }
        let bodies = bodies.into_iter().filter(|(_, views)| views.len() > 1);
        let instant = |(body, views)| Instant {
            body,
            views: largest(views),
        };
        bodies.map(instant).collect()
    }
}

fn has_same_corners(one: &ObjectImage, other: &ObjectImage) -> bool {
    let pairs = one.views.iter().zip(&other.views);
    let mut pairs = pairs.map(|(one, other)| one.corners_in_image == other.corners_in_image);
    one.views.len() == other.views.len() && pairs.all(|is_same| is_same)
}

/// Whether tags are not where they would be had they moved on as between the two images before.
fn is_jump(images: [&ObjectImage; 3]) -> bool {
    let [t0, t1, t2] = images.map(|image| image.capture_ns);
    let steps = seconds(t1, t2) / seconds(t0, t1);
    if seconds(t1, t2) > LONGEST_JUMP_S || !steps.is_finite() || steps > MOST_STEPS {
        return false;
    }
    let corner = |image: &ObjectImage, tag: TagId| {
        let mut own = image.views.iter().filter(|view| view.tag == tag);
        own.next().map(|view| view.corners_in_image[0].coords)
    };
    let jumped = images[2].views.iter().filter_map(|view| {
        let [a, b, c] = images.map(|image| corner(image, view.tag));
        let (a, b, c) = (a?, b?, c?);
        let expected = b + (b - a) * steps;
        Some((c - expected).norm() > JUMP_PX + JUMP_SHARE * (b - a).norm())
    });
    let jumped: Vec<bool> = jumped.collect();
    !jumped.is_empty() && jumped.iter().all(|jumped| *jumped)
}

/// The views of tags that an image has once.
fn singles(views: &[TagView]) -> impl Iterator<Item = &TagView> {
    let n_of = |tag: TagId| views.iter().filter(|view| view.tag == tag).count();
    views.iter().filter(move |view| n_of(view.tag) == 1)
}

fn largest(mut views: Vec<View>) -> Vec<View> {
    if views.len() > MOST_VIEWS {
        let size = |view: &View| (view.corners[2] - view.corners[0]).norm();
        views.sort_by(|a, b| size(b).total_cmp(&size(a)));
        views.truncate(MOST_VIEWS);
    }
    views
}

/// The views of a camera at a time after its newest image.
struct Extrapolation<'a> {
    /// The images before, the newer first.
    earlier: [Option<&'a ObjectImage>; 2],
    /// From the image before to the newest, s; zero without one.
    step_s: f64,
    /// Times that step from the newest image to the time.
    steps: f64,
    /// The same from the first image to the one before; zero without the first.
    first_steps: f64,
    /// Standard deviation of the camera's clock, s.
    clock_s: f64,
}

impl<'a> Extrapolation<'a> {
    /// `None` where the time is too far from the camera's images.
    fn new(
        newest: &ObjectImage,
        earlier: [Option<&'a ObjectImage>; 2],
        time_ns: u64,
        options: &FusionOptions,
    ) -> Option<Self> {
        let between = |one: Option<&ObjectImage>, other: Option<&ObjectImage>| match (one, other) {
            (Some(one), Some(other)) => seconds(one.capture_ns, other.capture_ns),
            _ => 0.0,
        };
        let [before, first] = earlier;
        let step_s = between(before, Some(newest));
        let after_s = seconds(newest.capture_ns, time_ns);
        let steps = if after_s != 0.0 {
            after_s / step_s
        } else {
            0.0
        };
        let is_near = after_s == 0.0 || step_s <= LONGEST_STEP_S && steps.abs() <= MOST_STEPS;
        (is_near && steps.is_finite()).then_some(Self {
            earlier,
            step_s,
            steps,
            first_steps: between(first, before) / step_s,
            clock_s: newest.clock.sigma_s(options).min(USUAL_CLOCK_S),
        })
    }

    /// A view of the camera as it is at the time; `None` where the motion is needed and unknown.
    fn view(
        &self,
        view: &TagView,
        [camera, tag]: [usize; 2],
        options: &FusionOptions,
    ) -> Option<View> {
        let variance = view.seen.own_covariance().trace() / 8.0;
        let own_px = match variance > 0.0 {
            true => variance.sqrt(),
            false => options.corner_sigma_px,
        };
        let of_tag = |image: &&'a ObjectImage| {
            let mut views = image.views.iter();
            views.find(|earlier| earlier.tag == view.tag)
        };
        let [earlier, first] = (self.earlier).map(|image| image.as_ref().and_then(of_tag));
        let Some(earlier) = earlier else {
            let is_at_rest = self.steps == 0.0 && self.clock_s == 0.0;
            return is_at_rest.then_some(View {
                camera,
                tag,
                corners: view.corners_in_image,
                velocities: [Vector2::zeros(); 4],
                sigma_px: own_px,
            });
        };
        let motion = motion_between(earlier, view);
        let motion_px = rms(&motion);
        let noise_px = own_px * (1.0 + self.steps).hypot(self.steps);
        let first = first.filter(|_| self.first_steps > 0.0);
        let change_px = first.map_or(0.0, |first| {
            let former = motion_between(first, earlier);
            rms(&from_fn(|k| motion[k] - former[k] / self.first_steps))
        });
        let uncertain_px = (motion_px * UNCERTAIN_MOTION).hypot(change_px * UNCERTAIN_CHANGE);
        let moved_px = uncertain_px * self.steps.abs();
        let clock_px = motion_px / self.step_s * self.clock_s;
        Some(View {
            camera,
            tag,
            corners: from_fn(|corner| view.corners_in_image[corner] + motion[corner] * self.steps),
            velocities: motion.map(|motion| motion / self.step_s),
            sigma_px: noise_px.hypot(moved_px).hypot(clock_px),
        })
    }
}

/// By how much the corners of a tag have moved, px.
fn motion_between(earlier: &TagView, later: &TagView) -> [Vector2<f64>; 4] {
    from_fn(|k| later.corners_in_image[k] - earlier.corners_in_image[k])
}

fn rms(vectors: &[Vector2<f64>; 4]) -> f64 {
    let squares = vectors.iter().map(Vector2::norm_squared);
    (squares.sum::<f64>() / 4.0).sqrt()
}
