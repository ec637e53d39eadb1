//! Tracking: one object through time, by the images of all cameras.
//!
//! [`Track::advance`] takes a track over one instant, a file for each stage:
//!
//! 1. [`predict`]: the state of each [`hypothesis`] at the instant.
//! 2. [`associate`]: the views of the images, weighted by what the track knows of their cameras ([`noise_scales`],
//!    [`clock_knowledge`]).
//! 3. [`update`]: the posteriors of each predicted state; views that contradict the others are left out.
//! 4. [`branch`]: what else may have happened: a hit, wrong views, an object put elsewhere.
//! 5. [`prune`]: the likeliest remain, and the track learns from their views. If these contradict it, [`reacquire`]
//!    tries stages 3 to 5 once more, from nothing or with more noise.
//! 6. [`report`]: estimates from a track, whose hypotheses are a [`mixture`].
//!
//! [`timeline`] keeps the tracks of the fixed lag, and asks for the sixth stage when an estimate is wanted.

pub(crate) mod associate;
pub(crate) mod branch;
pub(crate) mod camera_consistency;
pub(crate) mod clock_knowledge;
pub(crate) mod hypothesis;
pub(crate) mod mixture;
pub(crate) mod noise_scales;
pub(crate) mod predict;
pub(crate) mod prune;
pub(crate) mod reacquire;
pub(crate) mod report;
pub(crate) mod timeline;
pub(crate) mod track;
pub(crate) mod update;

use crate::FusionOptions;
use crate::site::{ModelledSite, ObjectImage};
use crate::tracker::associate::associate;
use crate::tracker::branch::branch;
use crate::tracker::predict::predict;
use crate::tracker::prune::prune;
use crate::tracker::reacquire::reacquire;
use crate::tracker::track::Track;
use crate::tracker::update::update;

impl Track {
    /// The track after the images of the instant `time_ns`, which is not before this one's.
    pub(crate) fn advance(
        &self,
        time_ns: u64,
        images: &[&ObjectImage],
        site: &ModelledSite,
        options: &FusionOptions,
    ) -> Self {
        let mut prediction = predict(self, time_ns, options);
        let views = associate(&mut prediction, images, site, options);
        let updated = update(&prediction, &views, options);
        let branches = branch(&prediction, updated, &views, options);
        let next = prune(&prediction, branches, &views, options);
        reacquire(&prediction, next, &views, options)
    }
}
