//! Which of the detector's two ways is taken: each image by itself, or as one of a sequence.

use sextant_apriltag::{Detection, Detector, Image, OptionsError, Tracker};

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
    pub(super) fn detect(&mut self, image: &Image<'_>) -> &[Detection] {
        match self {
            Self::EachImage(detector) => detector.detect(image),
            Self::Tracking(tracker) => tracker.detect(image),
        }
    }
}
