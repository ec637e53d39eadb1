//! Mistakes mended in the models that the files give.

use sextant_mistakes::Mistake;
use sextant_site_model::{ObjectTag, PoseSigma, Rig};

use crate::site::indexed_site::IndexedSite;
use crate::site::{FileCamera, ModelledSite, TagPlacement};

/// Standard deviation of a focal length that was found beside poses, as a share of it.
const FOCAL_SIGMA: f64 = 0.02;

impl ModelledSite {
    /// Takes the values over that are right if a mistake was made, as if the files had them, with a standard deviation
    /// for what was found by the images.
    pub fn mend(&mut self, mistake: &Mistake, indexed: &IndexedSite) {
        match *mistake {
            Mistake::CameraMoved {
                camera,
                world_from_camera,
                sigma,
            } => self.mend_camera(camera, |file| {
                file.world_from_camera = world_from_camera;
                file.sigma = at_least(sigma, PoseSigma::OF_CAMERA);
            }),
            Mistake::CameraTurned { camera, .. } => {
                let there = mistake.amended(&indexed.site).cameras[camera].clone();
                self.mend_camera(camera, |file| {
                    if let Some(there) = &there {
                        file.world_from_camera = there.world_from_camera;
                    }
                    file.sigma = at_least(file.sigma, PoseSigma::OF_CAMERA);
                });
            }
            Mistake::LensChanged { camera, .. } => {
                let there = mistake.amended(&indexed.site).cameras[camera].clone();
                self.mend_camera(camera, |file| {
                    if let Some(there) = &there {
                        file.lens = there.lens;
                    }
                    let focal_px = FOCAL_SIGMA * file.lens.intrinsics().fx;
                    file.lens_sigma.focal_px = file.lens_sigma.focal_px.max(focal_px);
                });
            }
            Mistake::CamerasExchanged { a, b } => {
                let file = self.cameras[a].file.take();
                self.cameras[a].file = std::mem::replace(&mut self.cameras[b].file, file);
                self.mend_camera(a, |_| {});
                self.mend_camera(b, |_| {});
            }
            Mistake::BodyScaled { body, ratio } => {
                let object = indexed.object(body);
                self.rescale(object, ratio);
                let places = self.places.values_mut();
                places
                    .filter(|place| place.object == object)
                    .for_each(|place| place.change(|tag| scale_place(tag, ratio)));
            }
            Mistake::SizesScaled { body, ratio } => self.rescale(indexed.object(body), ratio),
            _ => self.mend_tag(mistake, indexed),
        }
        self.is_exact = self.has_exact_models();
    }

    /// Takes a camera as its file has it.
    pub fn restore_camera(&mut self, camera: usize, rig: &Rig) {
        let file = Self::new(rig, &[]).ok().and_then(|site| {
            let (index, _) = site.camera(&self.cameras[camera].id)?;
            site.cameras[index].file.clone()
        });
        if file.is_some() {
            self.cameras[camera].file = file;
            self.mend_camera(camera, |_| {});
        }
    }

    fn mend_camera(&mut self, camera: usize, change: impl Fn(&mut FileCamera)) {
        let camera = &mut self.cameras[camera];
        camera.file.as_mut().map(change);
        camera.posed = camera.file.as_ref().map(FileCamera::uncorrected);
    }

    fn mend_tag(&mut self, mistake: &Mistake, indexed: &IndexedSite) {
        let amended = mistake.amended(&indexed.site);
        let pairs = indexed.site.tags.iter().zip(&amended.tags);
        for (tag, (before, after)) in indexed.tags.iter().zip(pairs) {
            let Some(place) = self.places.get_mut(tag) else {
                continue;
            };
            if before.body_from_tag != after.body_from_tag {
                place.change(|tag| tag.object_from_tag = Some(after.body_from_tag));
                place.sigma = Some(place.prior).filter(PoseSigma::is_some);
            }
            if before.size_m != after.size_m {
                let ratio = after.size_m / before.size_m;
                place.change(|tag| tag.size_m *= ratio);
                place.size_prior = place.size_prior.max(sextant_site_model::MISPRINT_SIGMA);
            }
        }
    }
}

impl TagPlacement {
    /// Changes the tag as its file has it, and as it is worked with.
    fn change(&mut self, change: impl Fn(&mut ObjectTag)) {
        change(&mut self.file);
        change(&mut self.tag);
    }
}

fn scale_place(tag: &mut ObjectTag, ratio: f64) {
    if let Some(place) = &mut tag.object_from_tag {
        place.translation.vector *= ratio;
    }
}

fn at_least(sigma: PoseSigma, least: PoseSigma) -> PoseSigma {
    PoseSigma {
        position_m: sigma.position_m.max(least.position_m),
        orientation_rad: sigma.orientation_rad.max(least.orientation_rad),
    }
}
