//! Closed-form starts: what each mistake's values would be, from the views that others explain.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix6, Vector3};
use sextant_geometry::{Pose, so3, tag_corners_in_tag};
use sextant_site_model::PoseSigma;

use crate::explained::{Branches, Explained, body_term, poses_by, poses_by_camera};
use crate::mistake::{Mistake, zoomed};
use crate::pose_fit::{self, Term, best_of};
use crate::site::{Instant, NominalSite, SiteCamera, View};

/// Most cameras and tags that are suspected at a time: those in whose images most contradicts.
const MOST_SUSPECTS: usize = 8;
/// Golden section of an interval of logarithms: steps that reach a thousandth.
const SECTIONS: usize = 12;
/// Range of the logarithm of a focal length or of a size over the file's.
const LOG_RANGE: f64 = 1.2;
/// Range of the logarithm of a scale about the median of what pairs of cameras say.
const NEAR_LOG_SCALE: f64 = 0.03;
/// Range of a clock's offset, s, over which images move uniformly, and least one that displaces anything.
const CLOCK_RANGE_S: f64 = 0.12;
const LEAST_CLOCK_S: f64 = 0.004;
/// Starts on a range.
const GRID: usize = 24;
/// A scale nearer to one than this is an error of the file, which is adjusted.
const LEAST_LOG_SCALE: f64 = 0.015;
/// The same of a focal length: a smaller ratio is an error of the lens, not another zoom.
const LEAST_LOG_ZOOM: f64 = 0.1;

/// The site with its views, and what they show with the models as they are.
pub(crate) struct Starts<'a> {
    pub site: &'a NominalSite,
    pub instants: &'a [Instant],
    pub branches: &'a Branches,
    pub explained: &'a Explained,
}

/// The site as it is if a mistake was made, and what the views show then.
pub(crate) struct Tried {
    pub site: NominalSite,
    pub branches: Branches,
    pub explained: Explained,
}

/// A view of a body whose pose is known.
struct PlacedView<'a> {
    view: &'a View,
    world_from_body: Pose,
    /// `camera_from_tag` by its corners.
    branches: &'a [Pose],
}

/// Cameras, tags and bodies that something may be wrong with.
pub(crate) struct Suspects {
    cameras: Vec<usize>,
    tags: Vec<usize>,
    bodies: BTreeSet<usize>,
}

impl Starts<'_> {
    /// The sources of the instants that contradict, or of all where none does.
    pub fn suspects(&self) -> Suspects {
        let contradicting = || self.explained.contradicting(self.instants);
        let mut suspected: BTreeSet<usize> = contradicting().map(|(instant, _)| instant).collect();
        if suspected.is_empty() {
            suspected = (0..self.instants.len()).collect();
        }
        let views = || {
            let instants = suspected.iter().map(|at| &self.instants[*at]);
            instants.flat_map(|instant| &instant.views)
        };
        let bodies = suspected.iter().map(|at| self.instants[*at].body);
        Suspects {
            cameras: self.most_suspect(views().map(|view| view.camera), |view| view.camera),
            tags: self.most_suspect(views().map(|view| view.tag), |view| view.tag),
            bodies: bodies.collect(),
        }
    }

    /// All mistakes of some sources.
    pub fn all(&self, suspects: &Suspects) -> Vec<Mistake> {
        let mut all = Vec::new();
        for camera in &suspects.cameras {
            all.extend(self.of_camera(*camera));
        }
        let cameras = pairs(&suspects.cameras);
        all.extend(cameras.map(|(a, b)| Mistake::CamerasExchanged { a, b }));
        for tag in &suspects.tags {
            all.extend(self.of_tag(*tag));
        }
        let same_body =
            |(a, b): &(usize, usize)| self.site.tags[*a].body == self.site.tags[*b].body;
        let exchanged = pairs(&suspects.tags).filter(same_body);
        all.extend(exchanged.map(|(a, b)| Mistake::TagsExchanged { a, b }));
        for body in &suspects.bodies {
            all.extend(self.body_scaled(*body));
            all.extend(self.sizes_scaled(*body));
        }
        all
    }

    /// Those of some sources whose views contradict most often, in order.
    fn most_suspect(
        &self,
        sources: impl Iterator<Item = usize>,
        source: impl Fn(&View) -> usize,
    ) -> Vec<usize> {
        let mut counts: BTreeMap<usize, usize> = sources.map(|source| (source, 0)).collect();
        for (_, view) in self.explained.contradicting(self.instants) {
            *counts.entry(source(view)).or_default() += 1;
        }
        let mut sorted: Vec<(usize, usize)> = counts.into_iter().collect();
        sorted.sort_by_key(|(source, count)| (std::cmp::Reverse(*count), *source));
        sorted.truncate(MOST_SUSPECTS);
        let mut suspects: Vec<usize> = sorted.into_iter().map(|(source, _)| source).collect();
        suspects.sort_unstable();
        suspects
    }

    /// A camera elsewhere, turned, or with another lens.
    fn of_camera(&self, camera: usize) -> Vec<Mistake> {
        let turned = (1..=3).map(|quarters| Mistake::CameraTurned { camera, quarters });
        let mut all: Vec<Mistake> = turned.collect();
        let Some(model) = &self.site.cameras[camera] else {
            return all;
        };
        let others = |view: &View| view.camera != camera;
        let poses = poses_by(self.site, self.instants, self.branches, others);
        let terms = self.camera_terms(camera, model, &poses);
        let starts = self.camera_starts(camera, &poses);
        if let Some((camera_from_world, _)) = best_of(&terms, starts.into_iter()) {
            all.push(Mistake::CameraMoved {
                camera,
                world_from_camera: camera_from_world.inverse(),
                sigma: camera_sigma(&terms, &camera_from_world),
            });
        }
        all.extend(self.lens_changed(camera, model, &poses));
        all.extend(self.clock_off(camera, model, &poses));
        all
    }

    /// A clock that is off: all corners of the camera are where they will be or have been.
    fn clock_off(
        &self,
        camera: usize,
        model: &SiteCamera,
        poses: &[Option<Pose>],
    ) -> Option<Mistake> {
        let camera_from_world = model.world_from_camera.inverse();
        let cost = |offset_s: f64| {
            let model = SiteCamera {
                clock_s: model.clock_s + offset_s,
                ..model.clone()
            };
            pose_fit::cost(
                &self.camera_terms(camera, &model, poses),
                &camera_from_world,
            )
        };
        let offset_s = least(cost, CLOCK_RANGE_S);
        (offset_s.abs() > LEAST_CLOCK_S).then_some(Mistake::ClockOff { camera, offset_s })
    }

    /// All views of bodies whose poses are known, `world_from_body`, each with the poses that its corners allow.
    fn placed_views<'p>(
        &'p self,
        poses: &'p [Option<Pose>],
    ) -> impl Iterator<Item = PlacedView<'p>> {
        let instants = self.instants.iter().zip(poses).enumerate();
        let placed = instants.filter_map(|(at, (instant, pose))| Some((at, instant, (*pose)?)));
        placed.flat_map(move |(at, instant, world_from_body)| {
            let views = instant.views.iter().enumerate();
            views.map(move |(index, view)| PlacedView {
                view,
                world_from_body,
                branches: self.branches.by_corners(at, index),
            })
        })
    }

    /// The views of a camera as terms of the pose `camera_from_world`.
    fn camera_terms<'c>(
        &self,
        camera: usize,
        model: &'c SiteCamera,
        poses: &[Option<Pose>],
    ) -> Vec<Term<'c>> {
        let own = self
            .placed_views(poses)
            .filter(|placed| placed.view.camera == camera);
        let term = |placed: PlacedView<'_>| {
            let tag = &self.site.tags[placed.view.tag];
            let world_from_tag = placed.world_from_body * tag.body_from_tag;
            Term {
                outer: Pose::identity(),
                points: tag_corners_in_tag(tag.size_m).map(|corner| world_from_tag * corner),
                ..body_term(model, tag, placed.view)
            }
        };
        own.map(term).collect()
    }

    /// `camera_from_world` by each branch of each view of a camera.
    fn camera_starts(&self, camera: usize, poses: &[Option<Pose>]) -> Vec<Pose> {
        let own = self
            .placed_views(poses)
            .filter(|placed| placed.view.camera == camera);
        let starts = own.flat_map(|placed| {
            let body_from_tag = self.site.tags[placed.view.tag].body_from_tag;
            let tag_from_world = (placed.world_from_body * body_from_tag).inverse();
            let branches = placed.branches.iter();
            branches.map(move |branch| branch * tag_from_world)
        });
        starts.collect()
    }

    /// Another focal length, the camera where its file has it.
    fn lens_changed(
        &self,
        camera: usize,
        model: &SiteCamera,
        poses: &[Option<Pose>],
    ) -> Option<Mistake> {
        let camera_from_world = model.world_from_camera.inverse();
        let cost = |log_ratio: f64| {
            let model = SiteCamera {
                lens: zoomed(&model.lens, log_ratio.exp()),
                ..model.clone()
            };
            pose_fit::cost(
                &self.camera_terms(camera, &model, poses),
                &camera_from_world,
            )
        };
        let log_ratio = least(cost, LOG_RANGE);
        (log_ratio.abs() > LEAST_LOG_ZOOM).then(|| Mistake::LensChanged {
            camera,
            ratio: log_ratio.exp(),
        })
    }

    /// A tag turned, of another size, or elsewhere on its body.
    fn of_tag(&self, tag: usize) -> Vec<Mistake> {
        let turned = (1..=3).map(|quarters| Mistake::TagTurned { tag, quarters });
        let mut all: Vec<Mistake> = turned.collect();
        let others = |view: &View| view.tag != tag;
        let poses = poses_by(self.site, self.instants, self.branches, others);
        let size_m = self.site.tags[tag].size_m;
        let terms = self.tag_terms(tag, size_m, &poses);
        let starts = self.tag_starts(tag, &poses);
        if let Some((body_from_tag, _)) = best_of(&terms, starts.into_iter()) {
            all.push(Mistake::TagMoved { tag, body_from_tag });
        }
        let place = self.site.tags[tag].body_from_tag;
        let cost = |log_ratio: f64| {
            let terms = self.tag_terms(tag, size_m * log_ratio.exp(), &poses);
            pose_fit::cost(&terms, &place)
        };
        let log_ratio = least(cost, LOG_RANGE);
        if log_ratio.abs() > LEAST_LOG_SCALE {
            all.push(Mistake::TagResized {
                tag,
                ratio: log_ratio.exp(),
            });
        }
        all
    }

    /// The views of a tag as terms of the pose `body_from_tag`.
    fn tag_terms(&self, tag: usize, size_m: f64, poses: &[Option<Pose>]) -> Vec<Term<'_>> {
        let own = self
            .placed_views(poses)
            .filter(|placed| placed.view.tag == tag);
        let term = |placed: PlacedView<'_>| {
            let camera = self.site.cameras[placed.view.camera].as_ref()?;
            let term = body_term(camera, &self.site.tags[tag], placed.view);
            Some(Term {
                outer: term.outer * placed.world_from_body,
                points: tag_corners_in_tag(size_m),
                ..term
            })
        };
        own.filter_map(term).collect()
    }

    /// `body_from_tag` by each branch of each view of a tag.
    fn tag_starts(&self, tag: usize, poses: &[Option<Pose>]) -> Vec<Pose> {
        let own = self
            .placed_views(poses)
            .filter(|placed| placed.view.tag == tag);
        let own = own.filter_map(|placed| {
            let camera = self.site.cameras[placed.view.camera].as_ref()?;
            let body_from_camera = placed.world_from_body.inverse() * camera.world_from_camera;
            Some((body_from_camera, placed.branches))
        });
        let starts = own.flat_map(|(body_from_camera, branches)| {
            let branches = branches.iter();
            branches.map(move |branch| body_from_camera * branch)
        });
        starts.collect()
    }

    /// A body at another scale: with the right one the places by any two cameras meet. Each camera by itself sees the
    /// body in its direction, at a distance that is proportional to the scale.
    fn body_scaled(&self, body: usize) -> Option<Mistake> {
        let mut ratios = Vec::new();
        for (at, instant) in self.instants.iter().enumerate() {
            if instant.body != body {
                continue;
            }
            let rays: Vec<(Vector3<f64>, Vector3<f64>)> = self.rays(at, instant);
            for (index, (from, way)) in rays.iter().enumerate() {
                for (other_from, other_way) in &rays[index + 1..] {
                    let apart = way - other_way;
                    let ratio = -(from - other_from).dot(&apart) / apart.norm_squared();
                    ratios.push(ratio);
                }
            }
        }
        let start = median(ratios)?.ln();
        let scaled = |log_ratio: f64| Mistake::BodyScaled {
            body,
            ratio: log_ratio.exp(),
        };
        let (low, high) = (start - NEAR_LOG_SCALE, start + NEAR_LOG_SCALE);
        let log_ratio = golden_section(
            |log_ratio| self.tried(&scaled(log_ratio)).explained.total(),
            low,
            high,
        );
        (log_ratio.abs() > LEAST_LOG_SCALE).then(|| scaled(log_ratio))
    }

    /// What the views show if a mistake was made.
    pub fn tried(&self, mistake: &Mistake) -> Tried {
        let site = mistake.amended(self.site);
        let is_concerned = |view: &View| mistake.concerns(&site, view);
        let branches = if mistake.changes_branches() {
            self.branches.renewed(&site, self.instants, is_concerned)
        } else {
            self.branches.clone()
        };
        let explained = self
            .explained
            .renewed(&site, self.instants, &branches, is_concerned);
        Tried {
            site,
            branches,
            explained,
        }
    }

    /// Of each camera of an instant: its centre, and from there to the body as it sees it by itself; world axes, m.
    fn rays(&self, at: usize, instant: &Instant) -> Vec<(Vector3<f64>, Vector3<f64>)> {
        let poses = poses_by_camera(self.site, instant, self.branches.of_instant(at));
        let ray = |(camera, pose): (usize, Pose)| {
            let model = self.site.cameras[camera].as_ref()?;
            let centre = model.world_from_camera.translation.vector;
            Some((centre, pose.translation.vector - centre))
        };
        poses.into_iter().filter_map(ray).collect()
    }

    /// Tags of another size at their places: distances of tags in one image by the file over those seen with its sizes.
    fn sizes_scaled(&self, body: usize) -> Option<Mistake> {
        let mut ratios = Vec::new();
        for (at, instant) in self.instants.iter().enumerate() {
            let views = instant.views.iter().enumerate();
            let centres = views
                .filter(|_| instant.body == body)
                .filter_map(|(index, view)| {
                    let seen = self
                        .branches
                        .by_corners(at, index)
                        .first()?
                        .translation
                        .vector;
                    let on_body = self.site.tags[view.tag].body_from_tag.translation.vector;
                    Some((view.camera, seen, on_body))
                });
            let centres: Vec<_> = centres.collect();
            for (index, (camera, seen, on_body)) in centres.iter().enumerate() {
                for (other, other_seen, other_on_body) in &centres[index + 1..] {
                    if camera == other {
                        ratios.push((on_body - other_on_body).norm() / (seen - other_seen).norm());
                    }
                }
            }
        }
        let ratio = median(ratios)?;
        (ratio.ln().abs() > LEAST_LOG_SCALE).then_some(Mistake::SizesScaled { body, ratio })
    }
}

/// Standard deviation of where a camera is, by the covariance of `camera_from_world`: its centre is -R' t.
fn camera_sigma(terms: &[Term<'_>], camera_from_world: &Pose) -> PoseSigma {
    let turn = camera_from_world.rotation.to_rotation_matrix();
    let mut by_step = Matrix6::identity();
    let world_axes = -turn.matrix().transpose();
    by_step.fixed_view_mut::<3, 3>(0, 0).copy_from(&world_axes);
    let by_turn = world_axes * so3::hat(&camera_from_world.translation.vector);
    by_step.fixed_view_mut::<3, 3>(0, 3).copy_from(&by_turn);
    let covariance = pose_fit::covariance(terms, camera_from_world);
    sigma(covariance.map(|covariance| by_step * covariance * by_step.transpose()))
}

/// Standard deviations of an axis on average; those of a pose that is not known without a covariance.
fn sigma(covariance: Option<Matrix6<f64>>) -> PoseSigma {
    let Some(covariance) = covariance else {
        return UNKNOWN;
    };
    let of_axes = |first: usize| {
        let variance = covariance.fixed_view::<3, 3>(first, first).trace() / 3.0;
        variance.max(0.0).sqrt()
    };
    PoseSigma {
        position_m: of_axes(0).min(UNKNOWN.position_m),
        orientation_rad: of_axes(3).min(UNKNOWN.orientation_rad),
    }
}

/// Standard deviation of a pose of which hardly anything is known.
const UNKNOWN: PoseSigma = PoseSigma {
    position_m: 0.3,
    orientation_rad: 0.3,
};

fn pairs(all: &[usize]) -> impl Iterator<Item = (usize, usize)> {
    let firsts = all.iter().enumerate();
    firsts.flat_map(|(index, a)| all[index + 1..].iter().map(move |b| (*a, *b)))
}

/// The median of the numbers above zero; `None` where there are too few to tell.
fn median(numbers: Vec<f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = numbers
        .into_iter()
        .filter(|number| number.is_finite() && *number > 0.0)
        .collect();
    sorted.sort_by(f64::total_cmp);
    (sorted.len() >= FEWEST).then(|| sorted[sorted.len() / 2])
}

/// Fewer ratios tell nothing.
const FEWEST: usize = 5;

/// Where a function is least within a range about zero: the best of a grid, and a golden section about it.
fn least(cost: impl Fn(f64) -> f64, range: f64) -> f64 {
    let width = 2.0 * range / GRID as f64;
    let grid = (0..=GRID).map(|at| at as f64 * width - range);
    let best = grid
        .map(|log| (cost(log), log))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, middle)) = best else {
        return 0.0;
    };
    golden_section(cost, middle - width, middle + width)
}

/// Where a function of one minimum is least between two bounds (J. Kiefer, 1953).
fn golden_section(cost: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let shrink = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..SECTIONS {
        let inner = [high - shrink * (high - low), low + shrink * (high - low)];
        if cost(inner[0]) < cost(inner[1]) {
            high = inner[1];
        } else {
            low = inner[0];
        }
    }
    0.5 * (low + high)
}
