//! Which of the detector's two ways is taken: each image by itself, or as one of a sequence.

use sextant_apriltag::{Detection, Detector, Image, OptionsError, Tracker};
use sextant_geometry::Lens;

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

    /// The tags that were decoded in this very image, fitted through the lens if that is known.
    pub(super) fn detect(&mut self, image: &Image<'_>, lens: Option<Lens>) -> &[Detection] {
        match self {
            Self::EachImage(detector) => {
                detector.set_lens(lens);
                detector.detect(image)
            }
            Self::Tracking(tracker) => {
                tracker.set_lens(lens);
                tracker.detect(image)
            }
        }
    }
}
