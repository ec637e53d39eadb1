//! The models in force by index, as hypotheses about them need them.

use std::collections::BTreeMap;

use sextant_mistakes::{NominalSite, SiteCamera, SiteTag};
use sextant_site_model::{PoseSigma, TagId};

use crate::site::{ModelledSite, SiteCamera as ModelledCamera};

/// Factor on the standard deviations of the models: what exceeds such errors is a mistake.
const WIDER: f64 = 2.0;
/// Share of the usual errors of cameras and of files that no model is better than.
const LEAST_SIGMA: f64 = 0.2;
/// The same of tags in force: what is stuck on by hand may be learned too well.
const LEAST_TAG_SIGMA: f64 = 1.0;

/// A site with the tags that its indices stand for.
#[derive(Debug, Clone)]
pub(crate) struct IndexedSite {
    pub site: NominalSite,
    pub tags: Vec<TagId>,
    index: BTreeMap<TagId, usize>,
    /// Object index and link of each body.
    bodies: Vec<(usize, usize)>,
}

/// What a site's models are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exactness {
    /// As they are in force, with generous standard deviations.
    InForce,
    /// As the files have them, taken to be nearly exact.
    ExactFiles,
    /// As the files have them, with errors of the size that they state or that is usual.
    UsualFiles,
}

impl IndexedSite {
    pub fn new(models: &ModelledSite) -> Self {
        Self::with(models, Exactness::InForce)
    }

    pub fn with(models: &ModelledSite, exactness: Exactness) -> Self {
        let mut indexed = Self {
            site: NominalSite::default(),
            tags: Vec::new(),
            index: BTreeMap::new(),
            bodies: Vec::new(),
        };
        let cameras = models.cameras().iter();
        indexed.site.cameras = cameras
            .map(|camera| site_camera(camera, models, exactness))
            .collect();
        for (tag, place) in models.placements() {
            let (model, sigma, least) = match exactness {
                Exactness::InForce => {
                    let sigma = place.sigma.map(|sigma| sigma.times(WIDER));
                    (&place.tag, sigma, LEAST_TAG_SIGMA)
                }
                Exactness::ExactFiles => (&place.file, None, LEAST_SIGMA),
                Exactness::UsualFiles => (&place.file, Some(place.prior), LEAST_SIGMA),
            };
            let Some(body_from_tag) = model.object_from_tag else {
                continue;
            };
            let key = place.body();
            let known = indexed.bodies.iter().position(|body| *body == key);
            let body = known.unwrap_or_else(|| {
                indexed.bodies.push(key);
                indexed.bodies.len() - 1
            });
            indexed.index.insert(*tag, indexed.tags.len());
            indexed.tags.push(*tag);
            indexed.site.tags.push(SiteTag {
                body,
                body_from_tag,
                size_m: model.size_m,
                sigma: at_least(sigma, PoseSigma::OF_TAG.times(least)),
            });
        }
        indexed
    }

    /// Index of a tag that has a place.
    pub fn tag(&self, tag: &TagId) -> Option<usize> {
        self.index.get(tag).copied()
    }

    /// The body of a tag.
    pub fn body(&self, tag: usize) -> usize {
        self.site.tags[tag].body
    }

    /// The object of a body.
    pub fn object(&self, body: usize) -> usize {
        self.bodies[body].0
    }

    /// Whether a camera has a pose.
    pub fn has_camera(&self, camera: usize) -> bool {
        self.site.cameras.get(camera).is_some_and(Option::is_some)
    }
}

fn site_camera(
    camera: &ModelledCamera,
    models: &ModelledSite,
    exactness: Exactness,
) -> Option<SiteCamera> {
    let posed = camera.posed.as_ref()?;
    let file = camera.file()?;
    let (lens, world_from_camera, sigma) = match exactness {
        Exactness::InForce => {
            let sigma = posed.sigma.map(|sigma| sigma.times(WIDER));
            (posed.lens, posed.camera_from_world.inverse(), sigma)
        }
        Exactness::ExactFiles => (file.lens, file.world_from_camera, None),
        Exactness::UsualFiles => (file.lens, file.world_from_camera, Some(file.sigma)),
    };
    let sigma = match models.has_one_camera() {
        true => PoseSigma::NONE,
        false => at_least(sigma, PoseSigma::OF_CAMERA.times(LEAST_SIGMA)),
    };
    Some(SiteCamera {
        lens,
        world_from_camera,
        sigma,
        clock_s: 0.0,
    })
}

/// A standard deviation within which an error is no mistake.
fn at_least(sigma: Option<PoseSigma>, least: PoseSigma) -> PoseSigma {
    let sigma = sigma.unwrap_or(PoseSigma::NONE);
    PoseSigma {
        position_m: sigma.position_m.max(least.position_m),
        orientation_rad: sigma.orientation_rad.max(least.orientation_rad),
    }
}
