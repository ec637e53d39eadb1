//! Objects whose tags have all been printed at another scale than their file says.
//!
//! In an image of several tags their sizes and their distances contradict each other then: with the sizes of the file
//! the object is too near, with its places too far. A common factor of all sizes is estimated beside the pose by each
//! image alone, so that neither cameras nor tracks matter. Self-calibration can't tell it from tags that are all off
//! their places; but that each is off by just as much as a printer's scale would have it is no accident.

use std::collections::VecDeque;

use nalgebra::{SMatrix, SVector, Vector3, Vector6};
use sextant_geometry::{Pose, se3};

use crate::measurement::corners::{CalibratedCamera, TagView, ViewNoise, WeightedView};
use crate::measurement::planar_poses::{branches, largest};
use crate::measurement::rolling_shutter::LinkMotion;
use crate::self_calibration::view_rows::{ALL, BY_SIZE};
use crate::site::{ModelledSite, ObjectImage};

/// Images that decide.
const IMAGES: usize = 12;
/// Nanoseconds between two images that are looked at, once so many have been.
const SPACING_NS: u64 = 500_000_000;
/// Least logarithm of a scale that is no error of places, and share of it by which most images may differ.
const LEAST: f64 = 0.077;
const SPREAD: f64 = 0.25;
/// Share of the squared residuals by the file's sizes that another scale may leave: tags off their places leave more.
const LEFT: f64 = 0.15;
/// Cosine of the angle between tags in about one plane.
const PARALLEL: f64 = 0.98;
/// Gauss-Newton steps, and the largest change of the logarithm by one.
const STEPS: usize = 8;
/// Largest step at the minimum, in m, rad and the logarithm of the scale.
const LAST_STEP: f64 = 1e-6;
const LEAST_INFORMATION: f64 = 1e-9;
const LARGEST_STEP: f64 = 0.3;

/// The scales of an object's tags by its last images.
#[derive(Debug, Default)]
pub(crate) struct PrintScale {
    /// Logarithms; zero of an image that another scale does not explain.
    samples: VecDeque<f64>,
    /// How many images have been looked at, and when the last one was taken.
    looked_at: usize,
    last_ns: u64,
}

impl PrintScale {
    /// Takes an image in; the size of the tags over that in force where images agree that it is another.
    pub fn take(&mut self, image: &ObjectImage, site: &ModelledSite) -> Option<f64> {
        let is_due =
            self.looked_at < IMAGES || image.capture_ns >= self.last_ns.saturating_add(SPACING_NS);
        let has_one_link = image
            .views
            .iter()
            .all(|view| view.chain_link.is_none() && view.after_s.is_none());
        if image.views.len() < 2 || !is_due || !has_one_link {
            return None;
        }
        self.looked_at = self.looked_at.saturating_add(1);
        self.last_ns = image.capture_ns;
        let camera = site.cameras().get(image.camera_index)?.posed.as_ref()?;
        // By the places in the file: self-calibration may have moved the tags to where they agree with their sizes.
        let as_in_file = |view: &TagView| {
            let mut view = view.clone();
            view.set_model(&site.placement(&view.tag)?.file);
            Some(view)
        };
        let views = image.views.iter().map(as_in_file);
        let views: Vec<TagView> = views.collect::<Option<_>>()?;
        if is_pair_in_a_plane(&views) {
            return None;
        }
        let log_scale = log_scale(&views, image.camera_index, camera)?;
        if self.samples.len() == IMAGES {
            self.samples.pop_front();
        }
        self.samples.push_back(log_scale);
        let ratio = self.agreed()?;
        *self = Self::default();
        Some(ratio)
    }

    fn agreed(&self) -> Option<f64> {
        let middle = median(self.samples.iter().copied());
        let spread = median(self.samples.iter().map(|scale| (scale - middle).abs()));
        let is_clear = middle.abs() > LEAST && spread < SPREAD * middle.abs();
        (self.samples.len() == IMAGES && is_clear).then(|| middle.exp())
    }
}

/// Whether one of two tags may as well be off its place along the line between them.
fn is_pair_in_a_plane(views: &[TagView]) -> bool {
    let normal = |view: &TagView| view.object_from_tag.rotation * Vector3::z();
    match views {
        [one, other] => normal(one).dot(&normal(other)) > PARALLEL,
        _ => false,
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// Logarithm of the common factor of all sizes that explains an image best; zero where none explains what the file's
/// sizes do not.
fn log_scale(views: &[TagView], camera_index: usize, camera: &CalibratedCamera) -> Option<f64> {
    let best = |start: f64, is_free: bool| {
        let starts = scaled(views, start);
        let weighted = weigh(&starts, camera_index, camera);
        let found = branches(largest(weighted.iter())?).into_iter();
        let fits = found.filter_map(|pose| fit(views, camera_index, camera, pose, start, is_free));
        fits.min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let start = apart(&weigh(views, camera_index, camera))?.ln();
    let (log_scale, cost) = best(start, true)?;
    let (_, as_in_file) = best(0.0, false).unwrap_or((0.0, f64::INFINITY));
    Some(if cost < LEFT * as_in_file {
        log_scale
    } else {
        0.0
    })
}

/// Distance of two tags by the file over that seen with its sizes: the median of all pairs.
fn apart(weighted: &[WeightedView<'_>]) -> Option<f64> {
    let centres = weighted.iter().filter_map(|one| {
        let world_from_tag = branches(one).first()? * one.view.object_from_tag;
        let in_file = one.view.object_from_tag.translation.vector;
        Some((world_from_tag.translation.vector, in_file))
    });
    let centres: Vec<_> = centres.collect();
    let pairs = centres.iter().enumerate().flat_map(|(index, one)| {
        let others = centres[index + 1..].iter();
        others.map(move |other| (one.1 - other.1).norm() / (one.0 - other.0).norm())
    });
    let ratios: Vec<f64> = pairs
        .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
        .collect();
    (!ratios.is_empty()).then(|| median(ratios.into_iter()))
}

/// The scale next to a start, or that of the start where it is not free, and the cost; `None` where the tags can't be
/// seen so.
fn fit(
    views: &[TagView],
    camera_index: usize,
    camera: &CalibratedCamera,
    mut pose: Pose,
    mut log_scale: f64,
    is_free: bool,
) -> Option<(f64, f64)> {
    let mut cost = f64::INFINITY;
    for _ in 0..STEPS {
        let scaled = scaled(views, log_scale);
        let mut information = SMatrix::<f64, 7, 7>::identity() * LEAST_INFORMATION;
        let mut gradient = SVector::<f64, 7>::zeros();
        cost = 0.0;
        for weighted in weigh(&scaled, camera_index, camera) {
            let link = LinkMotion { pose, twist: None };
            for row in weighted.all_rows(&link, &Vector6::zeros())? {
                let by_size = if is_free { row[BY_SIZE] } else { 0.0 };
                let slopes = [row[0], row[1], row[2], row[3], row[4], row[5], by_size];
                let slopes = SVector::from(slopes);
                information += slopes * slopes.transpose();
                gradient += slopes * row[ALL - 1];
                cost += row[ALL - 1].powi(2);
            }
        }
        let step = -information.cholesky()?.solve(&gradient);
        pose = se3::perturb(&pose, &step.fixed_rows::<6>(0).into_owned());
        log_scale += step[6].clamp(-LARGEST_STEP, LARGEST_STEP);
        if step.amax() < LAST_STEP {
            break;
        }
    }
    (cost.is_finite() && log_scale.is_finite()).then_some((log_scale, cost))
}

/// The views with all tags larger by the factor of this logarithm.
fn scaled(views: &[TagView], log_scale: f64) -> Vec<TagView> {
    let scaled = |view: &TagView| {
        let mut scaled = view.clone();
        scaled.set_size(view.size_m * log_scale.exp());
        scaled
    };
    views.iter().map(scaled).collect()
}

fn weigh<'a>(
    views: &'a [TagView],
    camera_index: usize,
    camera: &'a CalibratedCamera,
) -> Vec<WeightedView<'a>> {
    let weighted =
        |view: &'a TagView| WeightedView::new(camera_index, camera, view, ViewNoise::UNKNOWN, None);
    views.iter().map(weighted).collect()
}
