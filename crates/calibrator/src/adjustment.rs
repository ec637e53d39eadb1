//! Adjusting images by their views: the bundle is built, solved, and solved again without the tags that do not fit.

use crate::bundle::{
    Bundle, BundleCamera, BundleError, BundleImage, BundleOptions, BundleSolution, BundleTag,
    Instant, Motion, solve,
};
use crate::intake::ImageView;
use crate::resection::edge_px;
use nalgebra::Vector6;
use sextant_geometry::Pose;

/// An image with the instant at which it was taken and the tags of it that are used.
#[derive(Clone, Debug)]
pub(crate) struct UsedImage {
    /// Index into the views.
    pub view: usize,
    /// Index into the cameras.
    pub camera: usize,
    /// Index into the instants.
    pub instant: usize,
    /// Capture time by the camera's clock less the instant's, seconds.
    pub seconds_after_instant: f64,
    /// Indices into the view's tags.
    pub tags: Vec<usize>,
}

/// A tag of an image that was left out because it does not fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Misfit {
    /// Index into the views.
    pub view: usize,
    /// Index into the view's tags.
    pub seen: usize,
    /// How far it is from where it should be, as a part of its edge in the image.
    pub off: f64,
}

impl Misfit {
    /// Whether it is somewhere else, not only seen badly.
    pub(crate) fn is_elsewhere(&self) -> bool {
        self.off > ELSEWHERE
    }
}

/// A tag further off than this part of its edge is elsewhere.
const ELSEWHERE: f64 = 0.15;

/// Everything an adjustment needs.
#[derive(Clone, Debug)]
pub(crate) struct Adjustment {
    pub cameras: Vec<BundleCamera>,
    pub tags: Vec<BundleTag>,
    pub instants: Vec<Instant>,
    pub images: Vec<UsedImage>,
    pub motion: Option<Motion>,
}

/// What came of it.
pub(crate) struct Adjusted {
    pub solution: BundleSolution,
    /// The images that were used, in the order of the bundle's.
    pub images: Vec<UsedImage>,
    pub misfits: Vec<Misfit>,
}

/// A tag whose squared error (eight degrees of freedom) exceeds this many times the variance of all is wrong: five sigma.
const GATE: f64 = 45.0;
/// Rounds of leaving out and solving again.
const ROUNDS: usize = 4;

impl Instant {
    /// At rest.
    pub(crate) fn at(seconds: f64, world_from_object: Pose) -> Self {
        Self {
            seconds,
            world_from_object,
            twist: Vector6::zeros(),
        }
    }
}

impl Adjustment {
    /// Solves, leaves out what does not fit, and solves again until all fits.
    pub(crate) fn solve(
        mut self,
        views: &[ImageView],
        options: &BundleOptions,
    ) -> Result<Adjusted, BundleError> {
        let mut misfits = Vec::new();
        let mut round = 0;
        loop {
            round += 1;
            self.drop_empty();
            let solution = solve(self.bundle(views), options)?;
            let wrong = wrong_tags(&solution, &self.images, views);
            if wrong.is_empty() || round == ROUNDS {
                return Ok(Adjusted {
                    solution,
                    images: self.images,
                    misfits,
                });
            }
            for misfit in &wrong {
                let images = self.images.iter_mut();
                for image in images.filter(|image| image.view == misfit.view) {
                    image.tags.retain(|&seen| seen != misfit.seen);
                }
            }
            misfits.extend(wrong);
            self.cameras = solution.bundle.cameras;
            self.tags = solution.bundle.tags;
            self.instants = solution.bundle.instants;
        }
    }

    /// Solves with everything in.
    pub(crate) fn solve_once(
        mut self,
        views: &[ImageView],
        options: &BundleOptions,
    ) -> Result<Adjusted, BundleError> {
        self.drop_empty();
        let solution = solve(self.bundle(views), options)?;
        Ok(Adjusted {
            solution,
            images: self.images,
            misfits: Vec::new(),
        })
    }

    /// Images without a tag and instants without an image go.
    fn drop_empty(&mut self) {
        self.images.retain(|image| !image.tags.is_empty());
        self.images.sort_by_key(|image| (image.instant, image.view));
        let mut kept = Vec::new();
        for image in &mut self.images {
            if kept.last() != Some(&image.instant) {
                kept.push(image.instant);
            }
            image.instant = kept.len() - 1;
        }
        self.instants = kept.iter().map(|&at| self.instants[at].clone()).collect();
    }

    pub(crate) fn bundle(&self, views: &[ImageView]) -> Bundle {
        let images = self.images.iter().map(|image| {
            let view = &views[image.view];
            BundleImage {
                camera: image.camera,
                instant: image.instant,
                seconds_after_instant: image.seconds_after_instant,
                tags: image.tags.iter().map(|&at| view.tags[at].seen()).collect(),
            }
        });
        Bundle {
            cameras: self.cameras.clone(),
            tags: self.tags.clone(),
            instants: self.instants.clone(),
            images: images.collect(),
            motion: self.motion,
            anchors: Vec::new(),
        }
    }
}

fn wrong_tags(solution: &BundleSolution, images: &[UsedImage], views: &[ImageView]) -> Vec<Misfit> {
    let gate = GATE * solution.variance_factor;
    let wrong = solution.bundle.residuals().filter(|r| r.chi_square > gate);
    let misfits = wrong.map(|residual| {
        let image = &images[residual.image];
        let seen = image.tags[residual.seen];
        let corners = &views[image.view].tags[seen].corners.corners;
        Misfit {
            view: image.view,
            seen,
            off: residual.rms_px() / edge_px(corners).max(1.0),
        }
    });
    misfits.collect()
}
