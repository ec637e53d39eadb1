//! Which of the detector's two ways is taken: each image by itself, or as one of a sequence.

use sextant_apriltag::{Detection, Detector, Image, Observer, OptionsError, Report, Tracker};

use crate::config::DetectionConfig;

pub(super) enum Finder {
    /// All of every image is searched.
    EachImage(Box<Detector>),
    /// Parts of every image are searched, where tags were and, in turn, elsewhere.
    Tracking(Box<Tracker>),
}

impl Finder {
    pub(super) fn new(config: &DetectionConfig) -> Result<Self, OptionsError> {
        let options = config.options();
        Ok(if config.tracking {
            Self::Tracking(Box::new(Tracker::new(options)?))
        } else {
            Self::EachImage(Box::new(Detector::new(options)?))
        })
    }

    /// The tags that were decoded in this very image.
    pub(super) fn detect(
        &mut self,
        image: &Image<'_>,
        observer: &mut impl Observer,
    ) -> &[Detection] {
        match self {
            Self::EachImage(detector) => detector.detect_observed(image, observer),
            Self::Tracking(tracker) => tracker.detect_observed(image, observer),
        }
    }

    /// What happened to the last image.
    pub(super) fn report(&self) -> &Report {
        match self {
            Self::EachImage(detector) => detector.report(),
            Self::Tracking(tracker) => tracker.report(),
        }
    }

    /// The share of the last image that was searched.
    pub(super) fn searched(&self) -> f32 {
        match self {
            Self::EachImage(_) => 1.0,
            Self::Tracking(tracker) => tracker.tracking_report().share,
        }
    }
}
