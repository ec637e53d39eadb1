//! From the images of a session to a constellation: consensus, spanning tree, adjustment, frame.

use super::gauge::{Gauge, aligned, centroid};
use super::places::Groups;
use super::progress::joining_hint;
use super::report::{size_ratios, wrong_size};
use super::{LearnError, LearnSession, Learned};
use crate::adjustment::{Adjusted, Adjustment};
use crate::bundle::{
    BundleCamera, BundleOptions, BundleSolution, BundleTag, Freedom, KeptParameter,
};
use crate::constellation::joined_tags;
use crate::graph::PoseGraph;
use crate::intake::{ImageView, take_in};
use crate::resection::Placed;
use crate::verdict::listed;
use nalgebra::DMatrix;
use sextant_estimator::{ObjectModel, ObjectTag, PoseSigma};
use sextant_geometry::Pose;
use sextant_geometry::least_squares::Kernel;

/// Rounds of finding the object in every image and adjusting all: the first works from the spanning tree's guess.
const ROUNDS: usize = 2;
/// A tag that fits in fewer of the images that show it is in no consistent place.
const LEAST_FITTING: f64 = 0.4;

/// What solving found, before it is put into words.
pub(super) struct Solved {
    pub views: Vec<ImageView>,
    pub adjusted: Adjusted,
    /// With the sizes sought too; where there is more than one tag.
    pub with_sizes: Option<BundleSolution>,
    /// Over the tags of the session that were sought, six each, in the frame of the result.
    pub covariance: DMatrix<f64>,
    /// `object_from_tag` in the frame of the result.
    pub poses: Vec<Pose>,
    /// Whether each tag was sought.
    pub sought: Vec<bool>,
}

impl LearnSession {
    /// Places the tags.
    ///
    /// # Errors
    /// When the images cannot place every tag, with the reason and a remedy.
    pub fn solve(&self) -> Result<Learned, LearnError> {
        let views = self.views();
        self.check_seen(&views)?;
        let groups = Groups::of(&self.rig, &views);
        let fixed = self.known();
        let mut placed = self.first_guess(&groups, &views, &fixed)?;
        let mut last = None;
        for _ in 0..ROUNDS {
            let adjusted = self.adjust(&groups, &views, &placed, Sizes::Stated)?;
            for (place, tag) in placed.iter_mut().zip(&adjusted.solution.bundle.tags) {
                *place = Some((tag.object_from_tag, tag.size_m));
            }
            last = Some(adjusted);
        }
        let adjusted = last.ok_or(LearnError::NoTag)?;
        let with_sizes = self.adjust(&groups, &views, &placed, Sizes::Sought).ok();
        self.check_fit(&views, &adjusted, with_sizes.as_ref().map(|a| &a.solution))?;
        let solved = self.framed(views, adjusted, with_sizes.map(|a| a.solution));
        Ok(Learned {
            object: self.object(&solved)?,
            report: self.report(&solved),
        })
    }

    fn views(&self) -> Vec<ImageView> {
        let views = self.images.iter().filter_map(|image| {
            let index = self.camera_of(image)?;
            let camera = &self.rig.cameras()[index];
            let (view, _) = take_in((index, camera), &self.wanted, image);
            (!view.tags.is_empty()).then_some(view)
        });
        views.collect()
    }

    fn check_seen(&self, views: &[ImageView]) -> Result<(), LearnError> {
        if views.is_empty() {
            return Err(LearnError::NothingSeen {
                images: self.images.len(),
                seen: self.what_is_seen(),
            });
        }
        let seen = |at: usize| views.iter().any(|v| v.tags.iter().any(|t| t.tag == at));
        let never: Vec<_> = (0..self.wanted.len())
            .filter(|&at| !seen(at))
            .map(|at| self.wanted[at].tag)
            .collect();
        if never.is_empty() {
            return Ok(());
        }
        Err(LearnError::NeverSeen {
            tags: listed(never),
        })
    }

    fn what_is_seen(&self) -> String {
        if self.coverage.outside() > 0 {
            return ": its corners lie outside of the picture that the rig states; give the resolution of these images"
                .to_owned();
        }
        let foreign = self.coverage.foreign();
        if foreign.is_empty() {
            return ": no tag at all; check light, focus and distance".to_owned();
        }
        format!(", only {}", listed(foreign.iter().take(8)))
    }

    /// Places of the known object's tags that stay.
    fn known(&self) -> Vec<Option<Pose>> {
        let relearned = |tag| self.plan.tags.iter().any(|(t, _)| *t == tag);
        let place = |tag| {
            let object = self.plan.from.as_ref()?;
            object.tags().iter().find(|t| t.tag == tag)?.object_from_tag
        };
        let wanted = self.wanted.iter();
        wanted
            .map(|w| place(w.tag).filter(|_| !relearned(w.tag)))
            .collect()
    }

    /// The spanning tree's places, in the frame of the known tags where there are some.
    fn first_guess(
        &self,
        groups: &Groups,
        views: &[ImageView],
        fixed: &[Option<Pose>],
    ) -> Result<Vec<Placed>, LearnError> {
        let joints = joined_tags(&groups.seen(&self.rig, views), &self.wanted);
        let strongest = |at: &usize, other: &usize| {
            joints
                .strength(*at)
                .total_cmp(&joints.strength(*other))
                .then(other.cmp(at))
        };
        let fixed_ones = (0..fixed.len()).filter(|&at| fixed[at].is_some());
        let root = fixed_ones.max_by(strongest);
        let root = root.or_else(|| (0..fixed.len()).max_by(strongest));
        let root = root.ok_or(LearnError::NoTag)?;
        let object_from_root = fixed[root].unwrap_or_default();
        let guesses = joints.placed(root);
        let placed: Vec<Placed> = (0..fixed.len())
            .map(|at| {
                let place = fixed[at].or_else(|| guesses[at].map(|guess| object_from_root * guess));
                place.map(|pose| (pose, self.wanted[at].size_m))
            })
            .collect();
        if placed.iter().any(Option::is_none) {
            return Err(self.not_connected(&joints));
        }
        Ok(placed)
    }

    fn not_connected(&self, joints: &PoseGraph) -> LearnError {
        let of = joints.islands();
        let mut numbers = of.clone();
        numbers.sort_unstable();
        numbers.dedup();
        let groups = numbers.iter().map(|number| {
            let members = (0..of.len()).filter(|&at| of[at] == *number);
            listed(members.map(|at| self.wanted[at].tag))
        });
        let groups: Vec<String> = groups.collect();
        let mut tags = self.progress().tags;
        for (tag, group) in tags.iter_mut().zip(&of) {
            tag.group = *group;
        }
        LearnError::NotConnected {
            groups: groups.join(" | "),
            hint: joining_hint(&tags).unwrap_or_default(),
        }
    }

    fn adjust(
        &self,
        groups: &Groups,
        views: &[ImageView],
        placed: &[Placed],
        sizes: Sizes,
    ) -> Result<Adjusted, LearnError> {
        let (instants, images) = groups.instants(&self.rig, views, placed);
        let cameras = self.rig.cameras().iter().zip(&groups.group_from_camera);
        let cameras = cameras.map(|(camera, pose)| BundleCamera {
            pose: Freedom::Fixed,
            ..BundleCamera::with_known_lens(camera.lens, *pose)
        });
        let fixed = self.fixed_tags(placed, views);
        let tags = placed.iter().zip(&fixed).map(|(placed, fixed)| {
            let (object_from_tag, size_m) = placed.unwrap_or_default();
            let sought = if *fixed {
                Freedom::Fixed
            } else {
                Freedom::Free
            };
            BundleTag {
                object_from_tag,
                size_m,
                pose: sought,
                size: if sizes == Sizes::Sought {
                    sought
                } else {
                    Freedom::Fixed
                },
            }
        });
        let adjustment = Adjustment {
            cameras: cameras.collect(),
            tags: tags.collect(),
            instants,
            images,
            motion: None,
        };
        if sizes == Sizes::Sought {
            // Wrong sizes make a tag an outlier everywhere: it must be heard, not left out.
            let options = BundleOptions {
                kernel: Kernel::Huber { width: 3.0 },
                ..BundleOptions::default()
            };
            return Ok(adjustment.solve_once(views, &options)?);
        }
        Ok(adjustment.solve(views, &BundleOptions::default())?)
    }

    /// Those of the known object or, without one, the tag that is the frame.
    fn fixed_tags(&self, placed: &[Placed], views: &[ImageView]) -> Vec<bool> {
        let known = self.known();
        if known.iter().any(Option::is_some) {
            return known.iter().map(Option::is_some).collect();
        }
        let frame = match self.plan.gauge {
            Gauge::Tag(tag) => self.wanted.iter().position(|w| w.tag == tag),
            Gauge::Centroid => None,
        };
        let count = |at: usize| {
            views
                .iter()
                .filter(|v| v.tags.iter().any(|t| t.tag == at))
                .count()
        };
        let most = || (0..placed.len()).max_by_key(|&at| (count(at), std::cmp::Reverse(at)));
        let frame = frame.or_else(most);
        (0..placed.len()).map(|at| Some(at) == frame).collect()
    }

    fn check_fit(
        &self,
        views: &[ImageView],
        adjusted: &Adjusted,
        with_sizes: Option<&BundleSolution>,
    ) -> Result<(), LearnError> {
        let counts = fitting(self.wanted.len(), views, adjusted);
        let lost: Vec<usize> = (0..counts.len())
            .filter(|&at| (counts[at].fits as f64) < LEAST_FITTING * counts[at].seen as f64)
            .collect();
        if lost.is_empty() {
            return Ok(());
        }
        let sizes = size_ratios(&self.wanted, with_sizes);
        let wrong_size = lost
            .iter()
            .find_map(|&at| Some((at, wrong_size(sizes[at])?)));
        let moved = lost.iter().any(|&at| self.known()[at].is_some());
        let (tags, cause) = match wrong_size {
            Some((at, wrong)) => (self.wanted[at].tag.to_string(), format!("it is {wrong}")),
            None if moved => (
                self.names(&lost),
                "not where the given object has them, so they have moved: name them with --tags to learn them anew".to_owned(),
            ),
            None => (
                self.names(&lost),
                "the images put them in different places; is a tag loose, bent, or there twice?".to_owned(),
            ),
        };
        Err(LearnError::Inconsistent { tags, cause })
    }

    fn names(&self, tags: &[usize]) -> String {
        listed(tags.iter().map(|&at| self.wanted[at].tag))
    }

    /// Moves everything into the frame of the result.
    fn framed(
        &self,
        views: Vec<ImageView>,
        adjusted: Adjusted,
        with_sizes: Option<BundleSolution>,
    ) -> Solved {
        let tags = &adjusted.solution.bundle.tags;
        let sought: Vec<bool> = self.known().iter().map(Option::is_none).collect();
        let mut poses: Vec<Pose> = tags.iter().map(|tag| tag.object_from_tag).collect();
        let mut covariance = whole_covariance(&adjusted.solution);
        if sought.iter().all(|sought| *sought) {
            let frame = match self.plan.gauge {
                Gauge::Tag(tag) => {
                    let at = self.wanted.iter().position(|w| w.tag == tag);
                    at.map_or_else(Pose::identity, |at| poses[at])
                }
                Gauge::Centroid => {
                    covariance = aligned(&covariance, &poses);
                    Pose::translation(centroid(&poses).x, centroid(&poses).y, centroid(&poses).z)
                }
            };
            poses = poses.iter().map(|pose| frame.inverse() * pose).collect();
        }
        Solved {
            views,
            adjusted,
            with_sizes,
            covariance,
            poses,
            sought,
        }
    }

    fn object(&self, solved: &Solved) -> Result<ObjectModel, LearnError> {
        let learned = self
            .wanted
            .iter()
            .zip(&solved.poses)
            .map(|(w, pose)| ObjectTag {
                tag: w.tag,
                size_m: w.size_m,
                object_from_tag: Some(*pose),
            });
        let object = ObjectModel::new(self.plan.object.clone(), learned.collect())?;
        let sought = (0..self.wanted.len()).filter(|at| solved.sought[*at]);
        let stated = sought.map(|at| (self.wanted[at].tag, sigma(&solved.covariance, at)));
        let object = object.with_tag_sigmas(stated)?;
        Ok(match &self.plan.from {
            Some(from) => object.holding_on_to(from),
            None => object,
        })
    }
}

/// How well the place of a tag is known: the root of the mean of its axes.
fn sigma(covariance: &DMatrix<f64>, tag: usize) -> PoseSigma {
    let of_axes = |first: usize| {
        let variance = (first..first + 3)
            .map(|row| covariance[(row, row)].max(0.0))
            .sum::<f64>();
        (variance / 3.0).sqrt().clamp(0.0, 1.0)
    };
    PoseSigma {
        position_m: of_axes(6 * tag),
        orientation_rad: of_axes(6 * tag + 3),
    }
}

/// What is done with the tags' sizes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sizes {
    Stated,
    Sought,
}

/// Six rows for every tag, zero for those that were fixed.
fn whole_covariance(solution: &BundleSolution) -> DMatrix<f64> {
    let n = solution.bundle.tags.len();
    let parameters = solution.covariance.parameters();
    let row = |parameter: &KeptParameter| match *parameter {
        KeptParameter::TagPosition { tag, axis } => Some(6 * tag + axis),
        KeptParameter::TagRotation { tag, axis } => Some(6 * tag + 3 + axis),
        _ => None,
    };
    let mut whole = DMatrix::zeros(6 * n, 6 * n);
    let matrix = solution.covariance.matrix();
    for (i, of) in parameters.iter().enumerate() {
        for (j, by) in parameters.iter().enumerate() {
            if let (Some(i_whole), Some(j_whole)) = (row(of), row(by)) {
                whole[(i_whole, j_whole)] = matrix[(i, j)];
            }
        }
    }
    whole
}

/// Images of one tag.
#[derive(Clone, Copy, Default)]
pub(super) struct Counts {
    pub seen: usize,
    pub fits: usize,
    /// Somewhere else on the object.
    pub elsewhere: usize,
}

/// The images of every tag.
pub(super) fn fitting(n: usize, views: &[ImageView], adjusted: &Adjusted) -> Vec<Counts> {
    let mut counts = vec![Counts::default(); n];
    for tag in views.iter().flat_map(|view| &view.tags) {
        counts[tag.tag].seen += 1;
    }
    let fits = adjusted.solution.bundle.images.iter();
    for seen in fits.flat_map(|image| &image.tags) {
        counts[seen.tag].fits += 1;
    }
    let mut blurred = vec![0; n];
    for misfit in adjusted.misfits.iter().filter(|m| !m.is_elsewhere()) {
        blurred[views[misfit.view].tags[misfit.seen].tag] += 1;
    }
    for (count, blurred) in counts.iter_mut().zip(blurred) {
        count.elsewhere = count.seen.saturating_sub(count.fits + blurred);
    }
    counts
}
