//! Moments as a bundle, and what moving one camera or tag makes of them.

use super::moment::Moment;
use super::site::{Place, Site};
use crate::bundle::{
    Bundle, BundleImage, BundleOptions, BundleSolution, Freedom, Instant, Motion, Reduction, solve,
};
use nalgebra::{Matrix6, Vector6};
use sextant_estimator::PoseSigma;
use sextant_geometry::least_squares::Kernel;
use sextant_geometry::{Pose, se3};

/// Convex, so that a camera that is off by many times the noise still pulls where it belongs. Tags that don't agree with their
/// own image never come this far.
pub(super) const KERNEL: Kernel = Kernel::Huber { width: 3.0 };
/// A person's hand, as in the calibration of rigs; moments are not tied to one another.
const MOTION: Motion = Motion {
    acceleration: 2.5,
    angular_acceleration: 8.0,
    longest_gap_s: 0.2,
};
/// From one moment to the next in the bundle's time, seconds.
const APART_S: f64 = 10.0;

/// A place moved.
pub(super) struct Moved {
    pub place: Place,
    pub pose: Pose,
    pub covariance: Matrix6<f64>,
}

/// Moments with everything known but where the object was.
pub(super) fn bundle_of<'a>(site: &Site, moments: impl IntoIterator<Item = &'a Moment>) -> Bundle {
    let mut bundle = Bundle {
        cameras: site.bundle_cameras(),
        tags: site.bundle_tags(),
        motion: Some(MOTION),
        ..Bundle::default()
    };
    for (number, moment) in moments.into_iter().enumerate() {
        let first = bundle.instants.len();
        let images = moment.images.iter().map(|image| BundleImage {
            instant: image.instant + first,
            ..image.clone()
        });
        bundle.images.extend(images);
        let instants = moment.instants.iter().map(|instant| Instant {
            seconds: instant.seconds + APART_S * number as f64,
            ..instant.clone()
        });
        bundle.instants.extend(instants);
    }
    bundle
}

pub(super) fn options() -> BundleOptions {
    BundleOptions {
        kernel: KERNEL,
        max_iterations: 60,
        ..BundleOptions::default()
    }
}

/// The moments by the models in force: only where the object was is sought. The corners' noise is what they show.
///
/// Clocks are taken as they are: the object's velocity within a moment is known so little that a clock would take up whatever
/// doesn't fit.
pub(super) struct Relaxed {
    solution: BundleSolution,
    /// Noise in units of what was stated.
    pub scale: f64,
}

impl Relaxed {
    pub(super) fn of<'a>(
        site: &Site,
        moments: impl IntoIterator<Item = &'a Moment>,
    ) -> Option<Self> {
        let mut solution = solve(bundle_of(site, moments), &options()).ok()?;
        let scale = solution.variance_factor.sqrt();
        weaken(&mut solution.bundle, scale);
        Some(Self { scale, solution })
    }

    /// How much each place's move alone would lower the sum of squares, to first order: chi-square of six degrees of freedom
    /// where nothing is to be moved (the score test; C. Rao, Linear statistical inference, 1973, 6e.3). Largest first.
    pub(super) fn gains(&self, calibrated: &Site) -> Vec<(Place, f64)> {
        let mut bundle = self.solution.bundle.clone();
        let places = calibrated.places();
        for &place in &places {
            free(&mut bundle, place);
            bundle.anchors.push(calibrated.anchor(place));
        }
        let Ok(reduction) = Reduction::of(&bundle, &KERNEL) else {
            return Vec::new();
        };
        let gains = places.iter().enumerate().filter_map(|(at, &place)| {
            let information = reduction.information.fixed_view::<6, 6>(6 * at, 6 * at);
            let gradient = reduction.gradient.fixed_rows::<6>(6 * at);
            let inverse = information.into_owned().cholesky()?;
            let gain = gradient.dot(&inverse.solve(&gradient));
            gain.is_finite().then_some((place, gain))
        });
        let mut gains: Vec<(Place, f64)> = gains.collect();
        gains.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        gains
    }

    /// The moments with one place sought, held by what was calibrated.
    pub(super) fn moved(&self, calibrated: &Site, place: Place) -> Option<Moved> {
        let mut bundle = self.solution.bundle.clone();
        free(&mut bundle, place);
        bundle.anchors.push(calibrated.anchor(place));
        let solution = solve(bundle, &options()).ok()?;
        if !solution.converged {
            return None;
        }
        let (pose, covariance) = match place {
            Place::Camera(at) => (
                solution.bundle.cameras[at].world_from_camera,
                solution.covariance.camera(at)?,
            ),
            Place::Tag(at) => (
                solution.bundle.tags[at].object_from_tag,
                solution.covariance.tag(at)?,
            ),
        };
        Some(Moved {
            place,
            pose,
            covariance,
        })
    }
}

impl Moved {
    /// The squared length of the move in its own deviations.
    pub(super) fn deviations(&self, from: &Pose) -> f64 {
        let step: Vector6<f64> = se3::difference(&self.pose, from);
        let factor = self.covariance.cholesky();
        factor.map_or(0.0, |factor| step.dot(&factor.solve(&step)))
    }

    /// One deviation an axis.
    pub(super) fn sigma(&self) -> PoseSigma {
        let mean = |from: usize| {
            let sum: f64 = (from..from + 3).map(|at| self.covariance[(at, at)]).sum();
            (sum / 3.0).max(0.0).sqrt()
        };
        PoseSigma {
            position_m: mean(0),
            orientation_rad: mean(3),
        }
    }
}

fn free(bundle: &mut Bundle, place: Place) {
    match place {
        Place::Camera(at) => bundle.cameras[at].pose = Freedom::Free,
        Place::Tag(at) => bundle.tags[at].pose = Freedom::Free,
    }
}

/// Corners as noisy as they are.
pub(super) fn weaken(bundle: &mut Bundle, scale: f64) {
    let images = bundle.images.iter_mut();
    for seen in images.flat_map(|image| &mut image.tags) {
        for whitening in &mut seen.whitening {
            *whitening /= scale;
        }
    }
}
