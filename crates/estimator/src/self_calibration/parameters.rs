//! Where each error of the site stands in the vector of all errors, with the sigma of its prior.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::DVector;

use crate::TagId;
use crate::self_calibration::keyframes::{Body, Keyframes};
use crate::site::Site;

/// Errors of a camera: six of the pose, focal length (px), first coefficient of the distortion.
pub(crate) const OF_CAMERA: usize = 8;
/// Errors of a tag: six of the pose, logarithm of the size.
pub(crate) const OF_TAG: usize = 7;
/// Sigma of an error that is exactly zero: small, but not so small that numbers end.
const EXACT: f64 = 1e-9;

/// Errors that come about alike, whose scale is estimated together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Class {
    CameraPose,
    Lens,
    TagPose,
    TagSize,
}

/// All classes, by their number.
pub(crate) const CLASSES: [Class; 4] = [
    Class::CameraPose,
    Class::Lens,
    Class::TagPose,
    Class::TagSize,
];

/// The errors of cameras and tags that some keyframe shows.
#[derive(Debug, Clone, Default)]
pub(crate) struct ParameterLayout {
    /// First place of each camera's errors.
    pub cameras: BTreeMap<usize, usize>,
    /// Body and first place of each tag's errors.
    pub tags: BTreeMap<TagId, (Body, usize)>,
    /// Sigma of each prior at scale one; [`EXACT`] where nothing is open.
    pub sigmas: DVector<f64>,
    pub classes: Vec<Class>,
}

impl ParameterLayout {
    pub fn of(keyframes: &Keyframes, site: &Site) -> Self {
        let mut layout = Self::default();
        let mut sigmas = Vec::new();
        let mut joined = BTreeSet::new();
        for keyframe in keyframes.iter() {
            for one in &keyframe.views {
                layout.cameras.entry(one.camera_index).or_default();
                let tag = (keyframe.body(), 0);
                layout.tags.entry(one.view.tag).or_insert(tag);
            }
            let cameras = keyframe.cameras();
            if cameras.len() > 1 {
                joined.extend(cameras);
            }
        }
        for (camera, first) in &mut layout.cameras {
            *first = sigmas.len();
            let (pose, lens) = site.camera_priors(*camera);
            let [position, orientation] = [pose.position_m, pose.orientation_rad];
            sigmas.extend([position; 3].iter().chain(&[orientation; 3]));
            // What one camera alone sees it explains as well by the shape of the object.
            let is_joined = joined.contains(camera);
            sigmas.extend(lens.map(|sigma| if is_joined { sigma } else { 0.0 }));
            layout.classes.extend([Class::CameraPose; 6]);
            layout.classes.extend([Class::Lens; 2]);
        }
        for (tag, (_, first)) in &mut layout.tags {
            *first = sigmas.len();
            let (pose, size) = site.tag_priors(tag);
            let [position, orientation] = [pose.position_m, pose.orientation_rad];
            sigmas.extend([position; 3].iter().chain(&[orientation; 3]));
            sigmas.push(size);
            layout.classes.extend([Class::TagPose; 6]);
            layout.classes.push(Class::TagSize);
        }
        layout.sigmas = DVector::from_vec(sigmas).map(|sigma: f64| sigma.max(EXACT));
        layout
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
