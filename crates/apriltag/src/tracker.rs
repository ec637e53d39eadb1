//! Tags from image to image, looking at parts of each image only.
//!
//! In: images one after the other, of one camera, at an even pace. Out: the tags that were decoded in the very image, as
//! [`crate::Detector`] reports them. Each image is searched where known tags should be ([`track`]) and in one further
//! part of it, so that in ten images all of it is looked at ([`scan`]).

mod scan;
mod track;

use crate::area::Area;
use crate::{Detection, Detector, Image, Observer, Options, OptionsError, Report};
use scan::Scan;
use sextant_geometry::Lens;
use track::{MOST_MISSED, Track};

/// Tags that are followed at the same time, at most; with more, all of each image is searched.
const MAX_TRACKS: usize = 128;

/// Finds tags in the images of a sequence; keeps its memory between images.
#[derive(Debug)]
pub struct Tracker {
    detector: Detector,
    tracks: Vec<Track>,
    scan: Scan,
    /// Parts of the image that are searched; the first is the scan's.
    areas: Vec<Area>,
    /// Width and height of the last image.
    size: (usize, usize),
    report: TrackingReport,
}

/// What was looked at in the last image, and what came of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackingReport {
    /// Parts of the image that were searched.
    pub areas: u32,
    /// Their pixels, as a share of the image's; 1 when all of it was searched.
    pub share: f32,
    /// Tags decoded about where the images before let expect them.
    pub followed: u32,
    /// Tags decoded elsewhere.
    pub discovered: u32,
    /// Tags not decoded, but in one of the last three images.
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

    /// As [`Detector::set_lens`].
    pub fn set_lens(&mut self, lens: Option<Lens>) {
        self.detector.set_lens(lens);
    }

    /// The tags that were decoded in this image, sorted by family, id and centre; nothing that is only expected.
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

    /// The next part of the scan and where the known tags should be; the whole image where that is not far more.
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

    /// What was looked at in the last image.
    pub fn tracking_report(&self) -> &TrackingReport {
        &self.report
    }

    /// What happened in all that was looked at in the last image.
    pub fn report(&self) -> &Report {
        self.detector.report()
    }
}

/// Follows the tag, or begins to. Says whether it was known.
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
