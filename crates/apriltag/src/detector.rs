//! The pipeline.

use crate::{Detection, Image, Observer, Options, OptionsError, Report};

/// Finds tags, image after image; keeps its memory between images.
#[derive(Debug)]
pub struct Detector {
    detections: Vec<Detection>,
    report: Report,
}

impl Detector {
    /// Checks the options and prepares the families' tables.
    pub fn new(options: Options) -> Result<Self, OptionsError> {
        options.check()?;
        Ok(Self {
            detections: Vec::new(),
            report: Report::default(),
        })
    }

    /// The tags in an image, sorted by family, id and centre.
    pub fn detect(&mut self, image: &Image<'_>) -> &[Detection] {
        self.detect_observed(image, &mut ())
    }

    /// Like [`Self::detect`], telling an observer what happens.
    pub fn detect_observed(
        &mut self,
        image: &Image<'_>,
        observer: &mut impl Observer,
    ) -> &[Detection] {
        let _ = (image, observer);
        self.report = Report::default();
        &self.detections
    }

    /// What happened to the last image.
    pub fn report(&self) -> &Report {
        &self.report
    }
}
