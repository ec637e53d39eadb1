//! Robust adjustment of a session's images: builds the bundle, solves it, and solves it again without outliers.

use crate::image_store::ImageView;
use crate::priors::Priors;
use crate::resection::edge_px;
use sextant_adjustment::{
    Arm, BodyId, Bundle, BundleCamera, BundleError, BundleImage, BundleOptions, BundleSolution,
    BundleTag, Instant, Motion, covariance, solve,
};
use std::ops::Range;

/// An image with its instant and the tags that are used.
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
    /// As [`BundleImage::stamp_error_s`].
    pub stamp_error_s: f64,
    /// Indices into the view's tags.
    pub tags: Vec<usize>,
}

/// A tag that was excluded from an image as an outlier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Misfit {
    /// Index into the views.
    pub view: usize,
    /// Index into the view's tags.
    pub seen: usize,
    /// Distance from its predicted position, as a share of its edge in the image.
    pub off: f64,
}

impl Misfit {
    /// Whether it is at another place, not only poorly visible.
    pub(crate) fn is_elsewhere(&self) -> bool {
        self.off > ELSEWHERE
    }
}

/// A tag farther off than this share of its edge is at another place.
const ELSEWHERE: f64 = 0.15;

/// Input of an adjustment.
#[derive(Clone, Debug)]
pub(crate) struct Adjustment {
    pub cameras: Vec<BundleCamera>,
    pub tags: Vec<BundleTag>,
    pub instants: Vec<Instant>,
    pub images: Vec<UsedImage>,
    pub motion: Option<Motion>,
    pub priors: Priors,
    /// The robot that moves the object or the camera.
    pub arm: Option<Arm>,
    /// Corner noise of each camera as a multiple of the detector's; empty before the first solution.
    pub noise: Vec<f64>,
}

/// Result of an adjustment.
pub(crate) struct AdjustmentResult {
    pub solution: BundleSolution,
    /// The adjustment at the solution, without outliers; its images are in the order of the bundle.
    pub adjustment: Adjustment,
    pub misfits: Vec<Misfit>,
}

impl AdjustmentResult {
    /// The solution including the outliers.
    pub(crate) fn with_misfits(&self) -> Adjustment {
        let mut whole = self.adjustment.clone();
        for misfit in &self.misfits {
            let mut images = whole.images.iter_mut();
            if let Some(image) = images.find(|image| image.view == misfit.view) {
                image.tags.push(misfit.seen);
            }
        }
        whole
    }

    /// Images with at least one tag that fits.
    pub(crate) fn used(&self) -> impl Iterator<Item = &UsedImage> {
        let images = self.adjustment.images.iter();
        images.filter(|image| !image.tags.is_empty())
    }

    /// Corner noise over all cameras, as a multiple of the detector's.
    pub(crate) fn noise_ratio(&self) -> f64 {
        let mut squares = (0.0, 0.0);
        for image in &self.adjustment.images {
            let noise = self.adjustment.noise[image.camera];
            squares.0 += image.tags.len() as f64 * noise * noise;
            squares.1 += image.tags.len() as f64;
        }
        (squares.0 / f64::max(squares.1, 1.0)).sqrt()
    }
}

/// A tag whose chi-square (eight degrees of freedom) exceeds this is an outlier: seven sigma. The robust loss handles
/// smaller errors.
const GATE: f64 = 400.0;
/// Median of a sum of eight squared normal deviates.
const MEDIAN_OF_EIGHT: f64 = 7.344;
/// Least corner noise, as a multiple of the detector's.
const LEAST_NOISE: f64 = 0.05;
/// Most rounds of solving, and the change of noise and scales, as a logarithm, at which they end.
const ROUNDS: usize = 10;
const SETTLED: f64 = 0.05;
/// The first rounds estimate the noise only.
const FIRST: usize = 2;

/// Stretches of an excerpt.
const STRETCHES: usize = 10;
/// Least time between two instants, s; images closer together share one.
const LEAST_APART_S: f64 = 1e-3;

impl Adjustment {
    /// Solves repeatedly, each time with the noise, prior scales and outliers that the last solution shows.
    pub(crate) fn solve(
        mut self,
        views: &[ImageView],
        options: &BundleOptions,
    ) -> Result<AdjustmentResult, BundleError> {
        let mut misfits = Vec::new();
        self.drop_empty();
        self.measure_noise(&self.bundle(views), 0.0);
        let mut round = 0;
        loop {
            round += 1;
            let mut solution = solve(self.bundle(views), options)?;
            self.take(&solution.bundle);
            let mut change = self.measure_noise(&solution.bundle, self.parameters());
            let mut wrong = Vec::new();
            if round >= FIRST {
                change = change.max(self.priors.learn(&solution));
                if let Some(arm) = &mut self.arm {
                    change = change.max(arm.learn_sigma(&solution.arm));
                }
                wrong = wrong_tags(&solution, &self.images, views);
            }
            let settled = round > FIRST && wrong.is_empty() && change < SETTLED;
            if settled || round == ROUNDS {
                if let Some(priors) = self.priors.reported(&solution) {
                    let bundle = Bundle {
                        anchors: priors.anchors(),
                        ..solution.bundle.clone()
                    };
                    solution.covariance = covariance(bundle, options)?;
                }
                return Ok(AdjustmentResult {
                    solution,
                    adjustment: self,
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
        }
    }

    /// Takes what was sought from a solution of [`Self::bundle`].
    pub(crate) fn take(&mut self, solved: &Bundle) {
        self.cameras.clone_from(&solved.cameras);
        self.tags.clone_from(&solved.tags);
        self.instants.clone_from(&solved.instants);
        self.arm.clone_from(&solved.arm);
        for (image, solved) in self.images.iter_mut().zip(&solved.images) {
            image.stamp_error_s = solved.stamp_error_s;
        }
    }

    /// Puts an instant to the time of each image by the clocks as they are, where the motion is modelled; those of
    /// images that show what does not move stay.
    pub(crate) fn anchor_anew(&mut self) {
        let moving =
            |image: &UsedImage| matches!(self.instants[image.instant].body, BodyId::Moving(_));
        let (mut carried, mut images): (Vec<UsedImage>, Vec<UsedImage>) =
            self.images.drain(..).partition(moving);
        let n_still = images.last().map_or(0, |image| image.instant + 1);
        let at = |image: &UsedImage| {
            let offset_s = self.cameras[image.camera].clock_offset_s;
            self.instants[image.instant].after(image.seconds_after_instant - offset_s)
        };
        carried.sort_by(|a, b| {
            let (a, b) = (at(a), at(b));
            a.body.cmp(&b.body).then(a.seconds.total_cmp(&b.seconds))
        });
        let mut instants = self.instants[..n_still].to_vec();
        for mut image in carried {
            let instant = at(&image);
            let seconds = instant.seconds;
            let is_another = |last: &Instant| {
                last.body != instant.body || seconds > last.seconds + LEAST_APART_S
            };
            if instants.last().is_none_or(is_another) {
                instants.push(instant);
            }
            image.instant = instants.len() - 1;
            let offset_s = self.cameras[image.camera].clock_offset_s;
            image.seconds_after_instant = seconds - instants[image.instant].seconds + offset_s;
            images.push(image);
        }
        (self.instants, self.images) = (instants, images);
    }

    /// Stretches of instants from all over the recording, at most so many instants in all, the same number of each
    /// body, with their images. Within a single stretch the clock of a camera is hard to tell from its position.
    pub(crate) fn excerpt(&self, most: usize) -> Self {
        let runs = self.runs();
        let share = most / runs.iter().filter(|run| run.len() > 1).count().max(1);
        let length = (share / STRETCHES).max(1);
        let stretches = |run: Range<usize>| {
            let n = if run.len() <= share { 1 } else { STRETCHES };
            let length = if n == 1 { run.len() } else { length };
            let first = move |k: usize| run.start + k * (run.len() - length) / (n - 1).max(1);
            (0..n)
                .map(first)
                .flat_map(move |first| first..first + length)
        };
        let mut place = vec![None; self.instants.len()];
        let mut part = self.clone();
        part.instants.clear();
        for at in runs.into_iter().flat_map(stretches) {
            place[at] = Some(part.instants.len());
            part.instants.push(self.instants[at].clone());
        }
        part.images.retain(|image| place[image.instant].is_some());
        for image in &mut part.images {
            image.instant = place[image.instant].unwrap_or_default();
        }
        part
    }

    /// Instants of each body in turn.
    fn runs(&self) -> Vec<Range<usize>> {
        let mut end = 0;
        let runs = self.instants.chunk_by(|a, b| a.body == b.body).map(|run| {
            end += run.len();
            end - run.len()..end
        });
        runs.collect()
    }

    /// Number of free parameters.
    fn parameters(&self) -> f64 {
        (self.instants.len() * if self.motion.is_some() { 12 } else { 6 }) as f64
    }

    /// Updates the corner noise of each camera, as a multiple of the detector's, from its median tag; returns the
    /// largest change of its logarithm.
    pub(crate) fn measure_noise(&mut self, bundle: &Bundle, parameters: f64) -> f64 {
        self.noise.resize(self.cameras.len(), 1.0);
        let mut sums = vec![Vec::new(); self.cameras.len()];
        for residual in bundle.residuals() {
            let camera = bundle.images[residual.image].camera;
            sums[camera].push(residual.chi_square);
        }
        let rows = 8.0 * sums.iter().map(Vec::len).sum::<usize>() as f64;
        let free = ((rows - parameters) / rows.max(1.0)).max(0.2);
        let mut change = 0.0_f64;
        for (noise, sums) in self.noise.iter_mut().zip(&mut sums) {
            sums.sort_by(f64::total_cmp);
            let Some(median) = sums.get(sums.len() / 2) else {
                continue;
            };
            let factor = (median / (MEDIAN_OF_EIGHT * free)).sqrt();
            let next = (*noise * factor).max(LEAST_NOISE);
            change = change.max((next / *noise).ln().abs());
            *noise = next;
        }
        change
    }

    /// Some of the instants with their images.
    pub(crate) fn of_instants(&self, is_kept: impl Fn(usize) -> bool) -> Self {
        let mut part = self.clone();
        part.images.retain(|image| is_kept(image.instant));
        part.drop_empty();
        part
    }

    /// Removes images without a tag and instants without an image.
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
        if let Some(arm) = &mut self.arm {
            arm.hands = kept.iter().map(|&at| arm.hands[at]).collect();
        }
    }

    pub(crate) fn bundle(&self, views: &[ImageView]) -> Bundle {
        let seen = |view: &ImageView, at: usize| {
            let mut seen = view.tags[at].seen();
            let noise = self.noise.get(view.camera).copied().unwrap_or(1.0);
            seen.whitening.iter_mut().for_each(|w| *w /= noise);
            seen
        };
        let images = self.images.iter().map(|image| {
            let view = &views[image.view];
            BundleImage {
                camera: image.camera,
                instant: image.instant,
                seconds_after_instant: image.seconds_after_instant,
                stamp_error_s: image.stamp_error_s,
                tags: image.tags.iter().map(|&at| seen(view, at)).collect(),
            }
        });
        Bundle {
            cameras: self.cameras.clone(),
            tags: self.tags.clone(),
            scales: Vec::new(),
            instants: self.instants.clone(),
            images: images.collect(),
            motion: self.motion,
            anchors: self.priors.anchors(),
            arm: self.arm.clone(),
        }
    }
}

fn wrong_tags(solution: &BundleSolution, images: &[UsedImage], views: &[ImageView]) -> Vec<Misfit> {
    let gate = GATE;
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

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_geometry::Pose;

    fn of_bodies(n_instants: &[usize]) -> Adjustment {
        let bodies = n_instants.iter().enumerate();
        let instants = bodies.flat_map(|(body, n)| {
            (0..*n).map(move |at| {
                let id = BodyId::Moving(body);
                Instant::at_rest(id, 0.03 * at as f64, Pose::identity())
            })
        });
        Adjustment {
            cameras: Vec::new(),
            tags: Vec::new(),
            instants: instants.collect(),
            images: Vec::new(),
            motion: None,
            priors: Priors::default(),
            arm: None,
            noise: Vec::new(),
        }
    }

    #[test]
    fn an_excerpt_is_of_every_body_and_of_all_times_once() {
        for n in [3, 155, 156, 157, 400, 5000] {
            let whole = of_bodies(&[n, n / 2 + 1]);
            let part = whole.excerpt(311);
            let times = part.instants.iter().map(|at| (at.body, at.seconds));
            let times: Vec<(BodyId, f64)> = times.collect();
            assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{n}");
            assert!(
                times.len() <= 311 && times.len() >= 280.min((n + n / 2) * 9 / 10),
                "{n}"
            );
            assert_eq!(times.first(), Some(&(BodyId::Moving(0), 0.0)));
            let last = whole.instants.last().map(|at| (at.body, at.seconds));
            assert_eq!(times.last().copied(), last);
        }
    }
}
