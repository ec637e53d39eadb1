//! Layout of the errors of the site in one vector, with the standard deviation of each prior.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use nalgebra::DVector;

use crate::self_calibration::keyframes::{Body, Keyframes};
use crate::site::ModelledSite;
use sextant_site_model::{PoseSigma, TagId};

/// Errors of a camera: six of the pose (m, rad), focal length (px), first coefficient of the distortion, clock offset
/// (s).
pub(crate) const OF_CAMERA: usize = 9;
/// First place of the lens among them, and that of the clock.
pub(crate) const LENS: usize = 6;
pub(crate) const CLOCK: usize = 8;
/// Errors of a tag: six of the pose (m, rad), logarithm of the size.
pub(crate) const OF_TAG: usize = 7;
/// Place of the size among them.
pub(crate) const SIZE: usize = 6;
/// Errors of the scale that the tags of a body share: its logarithm.
pub(crate) const OF_SCALE: usize = 1;
/// Standard deviation of an error that is exactly zero: small, but not so small that numbers end.
const EXACT: f64 = 1e-9;

/// A camera or a tag, whose errors are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Source {
    /// By its index.
    Camera(usize),
    Tag(TagId),
    /// What is common to all tags of a body: their print.
    Scale(Body),
}

/// Errors of one kind, whose scale is estimated together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Class {
    CameraPose,
    Lens,
    Clock,
    TagPose,
    TagSize,
    Scale,
}

/// All classes, by their number.
pub(crate) const CLASSES: [Class; 6] = [
    Class::CameraPose,
    Class::Lens,
    Class::Clock,
    Class::TagPose,
    Class::TagSize,
    Class::Scale,
];

/// The errors of cameras and tags that some keyframe shows.
#[derive(Debug, Clone, Default)]
pub(crate) struct ParameterLayout {
    /// First place of each camera's errors.
    pub cameras: BTreeMap<usize, usize>,
    /// Body and first place of each tag's errors.
    pub tags: BTreeMap<TagId, (Body, usize)>,
    /// Place of the scale of each body that has one, after those of its tags.
    pub scales: BTreeMap<Body, usize>,
    /// Places of each body's tags and of its scale, which follow those of the cameras.
    pub bodies: Vec<(Body, Range<usize>)>,
    /// Standard deviation of each prior at scale one; [`EXACT`] where nothing is open.
    pub sigmas: DVector<f64>,
    pub classes: Vec<Class>,
}

impl ParameterLayout {
    /// Places for the errors of these cameras and tags, and of the scales of these bodies, all of them exactly zero.
    pub fn new(
        cameras: &BTreeSet<usize>,
        tags: &BTreeMap<TagId, Body>,
        scaled: &BTreeSet<Body>,
    ) -> Self {
        let mut layout = Self::default();
        for camera in cameras {
            layout.cameras.insert(*camera, layout.classes.len());
            layout.classes.extend([Class::CameraPose; LENS]);
            layout.classes.extend([Class::Lens; CLOCK - LENS]);
            layout.classes.push(Class::Clock);
        }
        let mut by_body: Vec<(Body, TagId)> =
            tags.iter().map(|(tag, body)| (*body, *tag)).collect();
        by_body.sort_unstable();
        for of_body in by_body.chunk_by(|a, b| a.0 == b.0) {
            let (first, body) = (layout.classes.len(), of_body[0].0);
            for (body, tag) in of_body {
                layout.tags.insert(*tag, (*body, layout.classes.len()));
                layout.classes.extend([Class::TagPose; SIZE]);
                layout.classes.push(Class::TagSize);
            }
            if scaled.contains(&body) {
                layout.scales.insert(body, layout.classes.len());
                layout.classes.extend([Class::Scale; OF_SCALE]);
            }
            layout.bodies.push((body, first..layout.classes.len()));
        }
        layout.sigmas = DVector::from_element(layout.classes.len(), EXACT);
        layout
    }

    /// The errors that keyframes show, with the priors of the files.
    pub fn of_files(keyframes: &Keyframes, site: &ModelledSite) -> Self {
        let (mut cameras, mut joined) = (BTreeSet::new(), BTreeSet::<usize>::new());
        let mut tags = BTreeMap::new();
        let mut clocks: BTreeMap<usize, f64> = BTreeMap::new();
        for keyframe in keyframes.iter() {
            if keyframe.path.is_some() {
                for one in &keyframe.views {
                    let sigma_s = clocks.entry(one.camera_index).or_default();
                    *sigma_s = sigma_s.max(one.clock_sigma_s);
                }
            }
            let own = keyframe.cameras();
            if own.len() > 1 {
                joined.extend(&own);
            }
            cameras.extend(own);
            let views = keyframe.views.iter();
            tags.extend(views.map(|one| (one.view.tag, keyframe.body())));
        }
        let scaled = tags.iter().filter_map(|(tag, body)| {
            let place = site.placement(tag)?;
            (place.size_prior > 0.0).then_some(*body)
        });
        let mut layout = Self::new(&cameras, &tags, &scaled.collect());
        for (camera, first) in layout.cameras.clone() {
            let Some(file) = site.file_camera(camera) else {
                continue;
            };
            layout.set_pose(first, file.sigma);
            if let Some(sigma_s) = clocks.get(&camera) {
                layout.set(first + CLOCK, &[*sigma_s]);
            }
            // What one camera alone sees it explains as well by the shape of the object.
            if joined.contains(&camera) {
                let sigma = file.lens_sigma;
                let distortion = sigma.distortion_px * file.distortion_per_px();
                layout.set(first + LENS, &[sigma.focal_px, distortion]);
            }
        }
        for (tag, (_, first)) in layout.tags.clone() {
            if let Some(place) = site.placement(&tag) {
                layout.set_pose(first, place.prior);
                layout.set(first + SIZE, &[place.size_prior]);
            }
        }
        for (body, place) in layout.scales.clone() {
            layout.set(place, &[site.scale_variance(body.0).sqrt()]);
        }
        layout
    }

    /// The places of each source's errors.
    pub fn blocks(&self) -> impl Iterator<Item = (Source, Range<usize>)> + '_ {
        let cameras = self.cameras.iter();
        let cameras =
            cameras.map(|(camera, first)| (Source::Camera(*camera), *first..first + OF_CAMERA));
        let tags = self.tags.iter();
        let tags = tags.map(|(tag, (_, first))| (Source::Tag(*tag), *first..first + OF_TAG));
        let scales = self.scales.iter();
        let scales = scales.map(|(body, at)| (Source::Scale(*body), *at..*at + OF_SCALE));
        cameras.chain(tags).chain(scales)
    }

    /// Sets the standard deviations of a pose's prior, its first place given.
    pub fn set_pose(&mut self, first: usize, sigma: PoseSigma) {
        self.set(first, &[sigma.position_m; 3]);
        self.set(first + 3, &[sigma.orientation_rad; 3]);
    }

    /// Sets the standard deviations of priors from a place on.
    pub fn set(&mut self, first: usize, sigmas: &[f64]) {
        for (at, sigma) in (first..).zip(sigmas) {
            self.sigmas[at] = sigma.max(EXACT);
        }
    }

    /// Number of places of the cameras' errors, which are the first.
    pub fn n_of_cameras(&self) -> usize {
        OF_CAMERA * self.cameras.len()
    }

    pub fn len(&self) -> usize {
        self.classes.len()
    }

    /// Whether a place has an error at all.
    pub fn is_open(&self, place: usize) -> bool {
        self.sigmas[place] > EXACT
    }

    /// The places of a class that are open.
    pub fn places(&self, class: Class) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).filter(move |at| self.classes[*at] == class && self.is_open(*at))
    }

    /// Inverse variance of each prior with the scales of the classes.
    pub fn precision(&self, scales: &[f64; CLASSES.len()]) -> DVector<f64> {
        DVector::from_fn(self.len(), |at, _| {
            let scale = scales[self.classes[at] as usize];
            (scale * self.sigmas[at]).max(EXACT).powi(-2)
        })
    }
}
