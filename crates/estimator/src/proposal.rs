//! A refined calibration of the site, as ordinary use has shown it.

use crate::HeldBack;
use crate::site::Site;
use crate::site::corrections::Corrections;
use sextant_site_model::{ObjectModel, ObjectTag, Prior, Rig};

/// The models with the errors taken off that self-calibration has found in them. Corrected poses and lenses have the sigmas that are left;
/// everything else is as it was.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// The cameras; `None` where none changes.
    pub rig: Option<Rig>,
    /// The objects that change.
    pub objects: Vec<ObjectModel>,
    /// How much better images are explained that had no part in the estimate.
    pub held_back: HeldBack,
}

impl Proposal {
    pub(crate) fn of(
        (rig, objects): (&Rig, &[ObjectModel]),
        (corrections, held_back): (&Corrections, HeldBack),
        site: &Site,
    ) -> Self {
        let corrected = corrected_rig(rig, corrections, site);
        let changed = |object: &ObjectModel| {
            let corrected = corrected_object(object, corrections, site);
            (corrected != *object).then_some(corrected)
        };
        Self {
            rig: (corrected != *rig).then_some(corrected),
            objects: objects.iter().filter_map(changed).collect(),
            held_back,
        }
    }
}

fn corrected_rig(rig: &Rig, corrections: &Corrections, site: &Site) -> Rig {
    let mut corrected = rig.clone();
    for camera in rig.cameras() {
        let known = site.camera(&camera.id);
        let Some(one) = known.and_then(|(index, _)| corrections.cameras.get(&index)) else {
            continue;
        };
        let mut camera = camera.clone();
        camera.world_from_camera = camera.world_from_camera.map(|pose| one.pose(&pose));
        camera.lens = one.lens(&camera.lens);
        camera.pose_prior = Prior::Sigma(one.sigma);
        if one.has_lens() {
            camera.lens_prior = Prior::Sigma(one.lens_sigma);
        }
        corrected = corrected.with_camera(camera);
    }
    corrected
}

fn corrected_object(object: &ObjectModel, corrections: &Corrections, site: &Site) -> ObjectModel {
    let mut corrected = object.clone();
    for tag in object.tags() {
        if let Some(one) = corrections.tags.get(&tag.tag) {
            let file = site.placement(&tag.tag).map_or(tag, |place| &place.file);
            corrected = corrected.with_tag(ObjectTag {
                pose_prior: Prior::Sigma(one.sigma),
                ..one.tag(file)
            });
        }
    }
    corrected
}
