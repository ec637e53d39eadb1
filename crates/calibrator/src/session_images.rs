//! What learning and the calibration of a rig have in common: the images of a session, the views of its tags in them,
//! and counts of what else they show.

use crate::image_store::{ImageStore, ImageView, TagSpec, take_in};
use sextant_site_model::{ImageObservation, Rig, TagId};
use std::collections::BTreeMap;

/// Per cent of the tags outside the image from which the resolution in the rig is wrong.
const OUTSIDE_PERCENT: usize = 4;

/// Stored images of the cameras of a rig.
#[derive(Clone, Debug)]
pub(crate) struct SessionImages {
    pub rig: Rig,
    /// The tags that the session uses.
    pub wanted: Vec<TagSpec>,
    pub stored: ImageStore,
    foreign: BTreeMap<TagId, usize>,
    doubled: BTreeMap<TagId, usize>,
    /// By camera of the rig.
    outside: Vec<OutsideCount>,
}

#[derive(Clone, Copy, Debug, Default)]
struct OutsideCount {
    tags: usize,
    outside: usize,
}

/// A camera with too many tags outside the resolution in the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WrongResolution {
    pub camera: usize,
    /// Of its tags.
    pub percent: usize,
}

impl SessionImages {
    /// Without images; stores at most so many.
    pub(crate) fn new(rig: Rig, wanted: Vec<TagSpec>, most: usize) -> Self {
        Self {
            outside: vec![OutsideCount::default(); rig.cameras().len()],
            stored: ImageStore::at_most(most),
            foreign: BTreeMap::new(),
            doubled: BTreeMap::new(),
            rig,
            wanted,
        }
    }

    /// Stores an image; what it shows of the wanted tags, if anything, and `None` if the rig lacks its camera.
    pub(crate) fn push(&mut self, image: &ImageObservation) -> Option<ImageView> {
        let index = self.camera_index(image)?;
        let (view, ignored) = take_in(index, &self.rig.cameras()[index], &self.wanted, image);
        let count = &mut self.outside[index];
        count.tags += view.tags.len() + ignored.outside.len();
        count.outside += ignored.outside.len();
        for tag in ignored.foreign {
            *self.foreign.entry(tag).or_default() += 1;
        }
        for tag in ignored.doubled {
            *self.doubled.entry(tag).or_default() += 1;
        }
        self.stored.push(image);
        Some(view)
    }

    /// What the stored images show of the wanted tags.
    pub(crate) fn views(&self) -> Vec<ImageView> {
        let views = self.stored.iter().filter_map(|image| {
            let index = self.camera_index(image)?;
            let (view, _) = take_in(index, &self.rig.cameras()[index], &self.wanted, image);
            (!view.tags.is_empty()).then_some(view)
        });
        views.collect()
    }

    fn camera_index(&self, image: &ImageObservation) -> Option<usize> {
        let mut cameras = self.rig.cameras().iter();
        cameras.position(|camera| camera.id == image.camera && camera.fits(image))
    }

    /// Tags that the session does not use, the most frequent first.
    pub(crate) fn foreign(&self) -> Vec<TagId> {
        let mut foreign: Vec<_> = self.foreign.iter().collect();
        foreign.sort_by_key(|(tag, count)| (std::cmp::Reverse(**count), **tag));
        foreign.into_iter().map(|(tag, _)| *tag).collect()
    }

    /// Number of images that show each tag twice.
    pub(crate) fn doubled(&self) -> &BTreeMap<TagId, usize> {
        &self.doubled
    }

    /// The first camera whose resolution in the rig is another than that of its images.
    pub(crate) fn wrong_resolution(&self) -> Option<WrongResolution> {
        let counts = self.outside.iter().enumerate();
        let mut wrong =
            counts.filter(|(_, count)| count.outside * 100 > OUTSIDE_PERCENT * count.tags);
        wrong.next().map(|(camera, count)| WrongResolution {
            camera,
            percent: count.outside * 100 / count.tags,
        })
    }
}
