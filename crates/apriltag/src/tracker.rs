//! Detection in image sequences: searches only parts of each image.
//!
//! Input: consecutive images of one camera at a regular rate. Output: the tags decoded in the current image, as
//! [`crate::Detector`] reports them. Each image is searched where known tags are predicted ([`track`]) and in one
//! further part, so that ten images cover the whole area ([`scan`]).

mod scan;
mod track;

use crate::area::Area;
use crate::{Detection, Detector, Image, Observer, Options, OptionsError, Report};
use scan::Scan;
use sextant_geometry::Lens;
use track::{MOST_MISSED, Track};

/// Most tags that are tracked; with more, the whole of each image is searched.
const MAX_TRACKS: usize = 128;

/// Detects tags in the images of a sequence; reuses its memory between images.
#[derive(Debug)]
pub struct Tracker {
    detector: Detector,
    tracks: Vec<Track>,
    scan: Scan,
    /// Parts of the image to search; the first is the scan's.
    areas: Vec<Area>,
    /// Width and height of the last image.
    size: (usize, usize),
    report: TrackingReport,
}

/// What was searched in the last image, and the results.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackingReport {
    /// Parts of the image that were searched.
    pub areas: u32,
    /// Their area as a share of the image; 1 when the whole image was searched.
    pub share: f32,
    /// Tags decoded near their predicted positions.
    pub followed: u32,
    /// Tags decoded elsewhere.
    pub discovered: u32,
    /// Tags that were decoded in one of the last three images, but not in this one.
    pub awaited: u32,
}

impl Tracker {
    /// Checks the options and prepares the detector.
    pub fn new(options: Options) -> Result<Self, OptionsError> {
        Ok(Self {
            detector: Detector::new(options)?,
            tracks: Vec::with_capacity(MAX_TRACKS),
            scan: Scan::default(),
            areas: Vec::with_capacity(MAX_TRACKS + 1),
            size: (0, 0),
            report: TrackingReport::default(),
        })
    }

    /// Sets the lens of the detector, as [`Detector::set_lens`] does.
    pub fn set_lens(&mut self, lens: Option<Lens>) {
        self.detector.set_lens(lens);
    }

    /// The tags decoded in this image, sorted by family, id and centre; never predicted ones.
    ///
    /// An image of another size than the last begins a new sequence.
    pub fn detect(&mut self, image: &Image<'_>) -> &[Detection] {
        self.detect_observed(image, &mut ())
    }

    /// Like [`Self::detect`], with an observer of the stages.
    pub fn detect_observed(
        &mut self,
        image: &Image<'_>,
        observer: &mut impl Observer,
    ) -> &[Detection] {
        self.choose_areas(image);
        let found = self.detector.detect_within(image, &self.areas, observer);
        for track in &mut self.tracks {
            track.images_ago += 1;
        }
        let mut followed = 0;
        for detection in found {
            followed += u32::from(take_up(&mut self.tracks, detection));
        }
        self.tracks.retain(|track| track.images_ago <= MOST_MISSED);
        let n_pixels: usize = self.areas.iter().map(Area::n_pixels).sum();
        self.report = TrackingReport {
            areas: self.areas.len() as u32,
            share: n_pixels as f32 / Area::whole(image).n_pixels() as f32,
            followed,
            discovered: found.len() as u32 - followed,
            awaited: (self.tracks.iter().filter(|track| track.images_ago > 0)).count() as u32,
        };
        found
    }

    /// The next part of the scan and the predicted positions; the whole image where that is not much more.
    fn choose_areas(&mut self, image: &Image<'_>) {
        let (whole, size) = (Area::whole(image), (image.width(), image.height()));
        self.areas.clear();
        if self.size != size {
            self.size = size;
            self.tracks.clear();
            self.scan = Scan::default();
            self.areas.push(whole);
            return;
        }
        self.areas.push(self.scan.next(image));
        let regions = self.tracks.iter().filter_map(|track| track.region(image));
        self.areas.extend(regions);
        let n_pixels: usize = self.areas.iter().map(Area::n_pixels).sum();
        if self.tracks.len() == MAX_TRACKS || 2 * n_pixels >= whole.n_pixels() {
            self.areas.clear();
            self.areas.push(whole);
        }
    }

    /// What was searched in the last image.
    pub fn tracking_report(&self) -> &TrackingReport {
        &self.report
    }

    /// Diagnostics of everything searched in the last image.
    pub fn report(&self) -> &Report {
        self.detector.report()
    }
}

/// Updates the track of a tag or starts one. Returns whether the tag was known.
fn take_up(tracks: &mut Vec<Track>, detection: &Detection) -> bool {
    let candidates = tracks
        .iter_mut()
        .filter_map(|track| Some((track.distance(detection)?, track)));
    let nearest = candidates.min_by(|(a, _), (b, _)| a.total_cmp(b));
    if let Some((_, track)) = nearest {
        track.follow(detection);
        return true;
    }
    if tracks.len() < MAX_TRACKS {
        tracks.push(Track::begin(detection));
    }
    false
}
