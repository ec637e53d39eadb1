//! Tracking: one object through time, by the images of all cameras.
//!
//! [`Track::advanced`] takes a track over one instant. Its stages, in order:
//!
//! 1. [`track`]: the views are weighed by what is known of the cameras' noise ([`noise_scales`], [`distortion_share`])
//!    and clocks ([`clock_knowledge`]).
//! 2. [`branching`]: each [`hypothesis`] is predicted and branches: updated, hit in the meantime, or with all views
//!    rejected.
//! 3. [`gating`]: views that contradict the others are left out; [`curvature`] widens covariances where the cost is
//!    flat.
//! 4. [`planar_ambiguity`] and [`joint_search`] propose other minima; [`birth`] proposes attitudes where nothing is
//!    known.
//! 5. [`branching`] weighs the hypotheses and drops the hopeless; [`camera_consistency`] remembers which cameras
//!    contradict.
//!
//! [`timeline`] keeps the tracks of the fixed lag, [`report`] and [`link_marginals`] make estimates from a track, and
//! [`finalised_views`] the residuals that fault diagnosis works with.

pub(crate) mod birth;
pub(crate) mod branching;
pub(crate) mod camera_consistency;
pub(crate) mod clock_knowledge;
pub(crate) mod curvature;
pub(crate) mod distortion_share;
pub(crate) mod finalised_views;
pub(crate) mod gating;
pub(crate) mod hypothesis;
pub(crate) mod joint_search;
pub(crate) mod link_marginals;
pub(crate) mod noise_scales;
pub(crate) mod planar_ambiguity;
pub(crate) mod report;
pub(crate) mod timeline;
pub(crate) mod track;
pub(crate) mod view_outcome;

use crate::FusionOptions;
use crate::site::{ModelledSite, ObjectImage};
use crate::tracker::track::Track;

impl Track {
    /// The track after the images of the instant `time_ns`, which is not before this one's.
    pub(crate) fn advanced(
        &self,
        time_ns: u64,
        images: &[&ObjectImage],
        site: &ModelledSite,
        options: &FusionOptions,
    ) -> Self {
        if !self.timing.is_changed_by(images) {
            return self.stepped(time_ns, images, site, options);
        }
        let mut informed = self.clone();
        informed.timing.observe(images);
        informed.stepped(time_ns, images, site, options)
    }
}
