//! Slow refinement of a calibrated site from its ordinary use: where a camera is, where a tag sits on its object.
//!
//! A [`Refinement`] takes the images that the site takes anyway. Of them it keeps a bounded set of *moments*, a tenth of a
//! second of one object each, no two alike, those that tell most about cameras and tags; every third one is held back. Asked
//! for a [`Finding`], it looks for the one camera or tag whose move explains the moments best, adjusts it with what the
//! calibration stated before as prior, and proposes it only if
//! - the move is many of its own deviations,
//! - the moments held back, which had no part in it, are foretold better by it: by a paired t test over moments
//!   ([`RefinementOptions::significance`]), and by a part that is worth it ([`RefinementOptions::least_gain`]),
//! - the move stays within bounds from where the calibration had put it: what is further off was bumped or came loose, and that
//!   is for a person to look at.
//!
//! One thing at a time: each change can be recorded, judged and taken back alone. Lenses and objects with links are left as they
//! are. Metres, radians, pixels, the frames of FRAMES.md; capture times are the only clock.

mod adjusting;
mod finding;
mod gathering;
mod held_back;
mod moment;
mod options;
mod reservoir;
mod site;

pub use finding::{Change, Finding, Part};
pub use held_back::HeldBack;
pub use options::RefinementOptions;

use gathering::Gathering;
use moment::Moment;
use reservoir::{Reservoir, Use};
use sextant_estimator::{ImageObservation, ObjectModel, Rig};
use site::Site;

/// Refines the models of a site.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// In force.
    site: Site,
    /// As calibrated: what the prior is about, and from where bounds count.
    calibrated: Site,
    options: RefinementOptions,
    gathering: Gathering,
    reservoir: Reservoir,
}

/// How much a refinement has to go by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gathered {
    /// Moments that changes are made from.
    pub used: usize,
    /// Moments that judge them.
    pub held_back: usize,
}

impl Refinement {
    /// Nothing seen yet.
    pub fn new(rig: &Rig, objects: &[ObjectModel], options: RefinementOptions) -> Self {
        let site = Site::new(rig, objects);
        Self {
            reservoir: Reservoir::new(&options),
            gathering: Gathering::default(),
            calibrated: site.clone(),
            site,
            options,
        }
    }

    /// Takes an image in, of a site in which nothing is known to be wrong.
    pub fn handle(&mut self, image: &ImageObservation) {
        self.gathering.take(&self.site, image);
        while let Some(gathered) = self.gathering.next_whole() {
            if let Some(moment) = Moment::of(&self.site, &gathered, &self.options) {
                self.reservoir.offer(&self.site, moment, &self.options);
            }
        }
    }

    /// What there is to go by.
    pub fn gathered(&self) -> Gathered {
        Gathered {
            used: self.reservoir.moments(Use::Used).count(),
            held_back: self.reservoir.moments(Use::HeldBack).count(),
        }
    }

    /// What the moments say; takes up to seconds. The same until a further moment is kept.
    pub fn find(&self) -> Finding {
        finding::find(self)
    }

    /// Whether a moment was kept since this was asked last.
    pub fn take_news(&mut self) -> bool {
        self.reservoir.take_news()
    }

    /// A proposed change is in force now. What was gathered stays, and so does what was calibrated.
    pub fn accept(&mut self, change: &Change) {
        self.site.take(change);
        self.reservoir.weigh_anew(&self.site);
    }

    /// Somebody else has changed the models: everything begins anew.
    pub fn take_models(&mut self, rig: &Rig, objects: &[ObjectModel]) {
        *self = Self::new(rig, objects, self.options);
    }
}
