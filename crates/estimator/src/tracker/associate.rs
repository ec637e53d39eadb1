//! Stage 2: the views of an instant with what the track knows of their cameras: noise of the corners, clock, and the
//! link of the object that they show best.

use crate::FusionOptions;
use crate::measurement::corners::{TagView, ViewNoise, WeightedView};
use crate::site::{ModelledSite, ObjectImage};
use crate::tracker::predict::Prediction;
use crate::tracker::track::Track;

/// The views of the images, weighted. What the images show of clocks goes into the predicted track, and its states are
/// anchored at the link that is seen best.
pub(crate) fn associate<'a>(
    prediction: &mut Prediction<'_>,
    images: &[&'a ObjectImage],
    site: &'a ModelledSite,
    options: &FusionOptions,
) -> Vec<WeightedView<'a>> {
    if prediction.track.timing.is_changed_by(images) {
        prediction.track.to_mut().timing.observe(images);
    }
    let views = weighted_views(&prediction.track, images, site, options);
    let chain_links = || {
        views
            .iter()
            .filter_map(|weighted| weighted.view.chain_link.as_ref())
    };
    let states = std::mem::take(&mut prediction.states).into_iter();
    let anchored = states.map(|state| state.reanchored_to_best(chain_links().map(|at| at.link)));
    prediction.states = anchored.collect();
    views
}

/// The views of images by what a track knows of their cameras.
pub(crate) fn weighted_views<'a>(
    track: &Track,
    images: &[&'a ObjectImage],
    site: &'a ModelledSite,
    options: &FusionOptions,
) -> Vec<WeightedView<'a>> {
    let mut views = Vec::with_capacity(images.iter().map(|image| image.views.len()).sum());
    let usual = track.noise.usual();
    for image in images {
        let camera_index = image.camera_index;
        let camera = site.cameras().get(camera_index);
        let Some(camera) = camera.and_then(|camera| camera.posed.as_ref()) else {
            continue;
        };
        let clock = track.timing.clock(image, options);
        let weighted = |view: &'a TagView| {
            let noise = ViewNoise {
                factor: track.noise.factor(camera_index, view.noise_source, &usual),
                distortion_share: track.noise.distortion_share(camera_index),
            };
            WeightedView::new(camera_index, camera, view, noise, clock)
        };
        views.extend(image.views.iter().map(weighted));
    }
    views
}
