//! A refined calibration of the site, as ordinary use has shown it.

use crate::HeldBack;
use crate::mended::MendedModels;
use crate::site::ModelledSite;
use crate::site::corrections::Corrections;
use sextant_site_model::{ObjectModel, ObjectTag, PoseSigma, Prior, Rig};

/// The models with the mistakes in them mended and the errors taken off that self-calibration has found. Corrected
/// poses and lenses have the sigmas that are left; everything else is as it was.
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
    pub(crate) fn new(
        models: &MendedModels,
        corrections: &Corrections,
        held_back: HeldBack,
        site: &ModelledSite,
    ) -> Self {
        let (file_rig, file_objects) = models.files();
        let (rig, objects) = models.in_force();
        let corrected = corrected_rig(rig, corrections, site);
        let changed = |(file, object): (&ObjectModel, &ObjectModel)| {
            let corrected = corrected_object(object, corrections, site);
            (corrected != *file).then(|| with_frame_of(corrected, corrections, site))
        };
        Self {
            rig: (corrected != *file_rig).then(|| with_scale_of(corrected, corrections)),
            objects: file_objects
                .iter()
                .zip(objects)
                .filter_map(changed)
                .collect(),
            held_back,
        }
    }
}

/// What the images do not show of the scale is no smaller for their number, and no part of the cameras' sigmas.
fn with_scale_of(rig: Rig, corrections: &Corrections) -> Rig {
    let of_frames = corrections.frames.values();
    let left = of_frames.fold(0.0_f64, |most, frame| most.max(frame.scale_variance));
    let stated = rig.scale_sigma().unwrap_or(0.0);
    let sigma = (stated.powi(2) + left).sqrt().min(1.0);
    rig.clone().with_scale_sigma(Some(sigma)).unwrap_or(rig)
}

/// As [`with_scale_of`], of the frame of an object in its tags.
fn with_frame_of(
    object: ObjectModel,
    corrections: &Corrections,
    site: &ModelledSite,
) -> ObjectModel {
    let index = site.objects().iter().position(|id| id == object.id());
    let Some(left) = index.and_then(|index| corrections.frames.get(&index)) else {
        return object;
    };
    let (left, stated) = (
        left.sigma(),
        object.frame_sigma().unwrap_or(PoseSigma::NONE),
    );
    let sigma = PoseSigma {
        position_m: left.position_m.hypot(stated.position_m).min(1.0),
        orientation_rad: left.orientation_rad.hypot(stated.orientation_rad).min(1.0),
    };
    object
        .clone()
        .with_frame_sigma(Some(sigma))
        .unwrap_or(object)
}

fn corrected_rig(rig: &Rig, corrections: &Corrections, site: &ModelledSite) -> Rig {
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

fn corrected_object(
    object: &ObjectModel,
    corrections: &Corrections,
    site: &ModelledSite,
) -> ObjectModel {
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
