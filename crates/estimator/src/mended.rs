//! The models of the files with the mistakes in them mended.

use sextant_geometry::se3;
use sextant_mistakes::Mistake;
use sextant_site_model::{
    Camera, CameraId, LensSigma, MISPRINT_SIGMA, ObjectModel, ObjectTag, PoseSigma, Prior, Rig,
    TagId,
};
use sextant_site_report::Fault;

use crate::site::ModelledSite;
use crate::site::indexed_site::IndexedSite;

/// Standard deviation of a focal length that was found beside poses, as a share of it.
const FOCAL_SIGMA: f64 = 0.02;
/// Standard deviation of the scale of a body by what several cameras see of it, as a share of it. By the places of its
/// tags, which are off themselves, it is [`MISPRINT_SIGMA`].
const BODY_SCALE_SIGMA: f64 = 0.01;
/// Standard deviations within which a camera is where it was.
const BACK: f64 = 3.0;

/// Rig and objects as the files have them, and as they are if some mistakes were made.
#[derive(Debug)]
pub(crate) struct MendedModels {
    file_rig: Rig,
    file_objects: Vec<ObjectModel>,
    rig: Rig,
    objects: Vec<ObjectModel>,
    /// The mistakes that are mended.
    faults: Vec<Fault>,
}

impl MendedModels {
    /// Models without a mistake.
    pub fn new(rig: Rig, objects: Vec<ObjectModel>) -> Self {
        Self {
            rig: rig.clone(),
            objects: objects.clone(),
            file_rig: rig,
            file_objects: objects,
            faults: Vec::new(),
        }
    }

    /// As the files have them.
    pub fn files(&self) -> (&Rig, &[ObjectModel]) {
        (&self.file_rig, &self.file_objects)
    }

    /// With the mistakes mended.
    pub fn in_force(&self) -> (&Rig, &[ObjectModel]) {
        (&self.rig, &self.objects)
    }

    /// Whether anything is mended.
    pub fn is_mended(&self) -> bool {
        self.rig != self.file_rig || self.objects != self.file_objects
    }

    /// The mistakes that are mended.
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    /// Takes the values over that are right if a mistake was made, with a standard deviation for what was found by the
    /// images.
    pub fn mend(&mut self, mistake: &Mistake, indexed: &IndexedSite, site: &ModelledSite) {
        let fault = fault(mistake, indexed, site);
        if let Some(fault) = &fault {
            self.faults.retain(|other| !is_about_the_same(other, fault));
        }
        if let Some(camera) = self.camera_that_is_back(mistake, site) {
            self.rig = self.rig.clone().with_camera(camera);
            return;
        }
        match *mistake {
            Mistake::CamerasExchanged { a, b } => {
                self.exchange([a, b].map(|index| site.camera_id(index)));
            }
            Mistake::CameraMoved { camera, .. }
            | Mistake::CameraTurned { camera, .. }
            | Mistake::LensChanged { camera, .. } => {
                self.mend_camera(mistake, camera, indexed, site);
            }
            _ => self.mend_tags(mistake, indexed),
        }
        self.faults.extend(fault);
    }

    /// The camera of the file if it had been moved, and is where the file has it again.
    fn camera_that_is_back(&self, mistake: &Mistake, site: &ModelledSite) -> Option<Camera> {
        let Mistake::CameraMoved {
            camera,
            world_from_camera,
            sigma,
        } = mistake
        else {
            return None;
        };
        let file = self.file_rig.camera(&site.camera_id(*camera)?)?;
        let was_moved = self.rig.camera(&file.id)?.world_from_camera != file.world_from_camera;
        let step = se3::difference(world_from_camera, &file.world_from_camera?);
        let is_back = step.fixed_rows::<3>(0).norm() <= BACK * sigma.position_m
            && step.fixed_rows::<3>(3).norm() <= BACK * sigma.orientation_rad;
        (was_moved && is_back).then(|| file.clone())
    }

    fn mend_camera(
        &mut self,
        mistake: &Mistake,
        index: usize,
        indexed: &IndexedSite,
        site: &ModelledSite,
    ) {
        let amended = mistake.amended(&indexed.site);
        let own = site.camera_id(index).and_then(|id| self.rig.camera(&id));
        let Some((camera, there)) = own.zip(amended.cameras[index].as_ref()) else {
            return;
        };
        let mut camera = camera.clone();
        match mistake {
            Mistake::LensChanged { .. } => {
                let sigma = camera
                    .lens_prior
                    .sigma_or(LensSigma::usual(&there.lens, true));
                let focal_px = FOCAL_SIGMA * there.lens.intrinsics().fx;
                camera.lens = there.lens;
                camera.lens_prior = Prior::Sigma(LensSigma {
                    focal_px: sigma.focal_px.max(focal_px),
                    ..sigma
                });
            }
            Mistake::CameraMoved { sigma, .. } => {
                camera.world_from_camera = Some(there.world_from_camera);
                camera.pose_prior = Prior::Sigma(at_least(*sigma, PoseSigma::OF_CAMERA));
            }
            _ => {
                let sigma = camera.pose_prior.sigma_or(PoseSigma::OF_CAMERA);
                camera.world_from_camera = Some(there.world_from_camera);
                camera.pose_prior = Prior::Sigma(at_least(sigma, PoseSigma::OF_CAMERA));
            }
        }
        self.rig = self.rig.clone().with_camera(camera);
    }

    /// Each of two cameras is all that the other's entry says but its name.
    fn exchange(&mut self, ids: [Option<CameraId>; 2]) {
        let [Some(a), Some(b)] = ids.map(|id| id.and_then(|id| self.rig.camera(&id)).cloned())
        else {
            return;
        };
        let (id_of_a, id_of_b) = (a.id.clone(), b.id.clone());
        let rig = self.rig.clone().with_camera(Camera { id: id_of_a, ..b });
        self.rig = rig.with_camera(Camera { id: id_of_b, ..a });
    }

    fn mend_tags(&mut self, mistake: &Mistake, indexed: &IndexedSite) {
        let amended = mistake.amended(&indexed.site);
        for index in mistake.tags(&indexed.site) {
            let (before, after) = (&indexed.site.tags[index], &amended.tags[index]);
            self.change_tag(indexed.tags[index], |tag| {
                if before.body_from_tag != after.body_from_tag {
                    tag.object_from_tag = Some(after.body_from_tag);
                }
                tag.size_m *= after.size_m / before.size_m;
            });
        }
        match *mistake {
            Mistake::BodyScaled { body, .. } => {
                self.widen_scale(indexed.object(body), BODY_SCALE_SIGMA);
            }
            Mistake::SizesScaled { body, .. } => {
                self.widen_scale(indexed.object(body), MISPRINT_SIGMA);
            }
            _ => {}
        }
    }

    fn change_tag(&mut self, id: TagId, change: impl FnOnce(&mut ObjectTag)) {
        for object in &mut self.objects {
            let own = object.tags().iter().find(|tag| tag.tag == id);
            if let Some(mut tag) = own.cloned() {
                change(&mut tag);
                *object = object.clone().with_tag(tag);
                return;
            }
        }
    }

    fn widen_scale(&mut self, object: usize, least: f64) {
        if let Some(object) = self.objects.get_mut(object) {
            let sigma = object.scale_sigma_or_usual().max(least);
            if let Ok(widened) = object.clone().with_scale_sigma(Some(sigma)) {
                *object = widened;
            }
        }
    }

    /// Size of all tags of an object over that in its file, where it was printed at another scale.
    pub fn print_scale(&self, object: usize) -> Option<f64> {
        let (file, mended) = (self.file_objects.get(object)?, self.objects.get(object)?);
        let pairs = file.tags().iter().zip(mended.tags());
        let mut ratios = pairs.map(|(file, mended)| mended.size_m / file.size_m);
        let first = ratios.next()?;
        let is_same = |ratio: f64| (ratio / first - 1.0).abs() < ROUNDING;
        (!is_one(first) && ratios.all(is_same)).then_some(first)
    }
}

/// Difference of two ratios that is due to rounding.
const ROUNDING: f64 = 1e-9;

fn is_one(ratio: f64) -> bool {
    (ratio - 1.0).abs() < ROUNDING
}

fn at_least(sigma: PoseSigma, least: PoseSigma) -> PoseSigma {
    PoseSigma {
        position_m: sigma.position_m.max(least.position_m).min(1.0),
        orientation_rad: sigma.orientation_rad.max(least.orientation_rad).min(1.0),
    }
}

/// What is reported of a mistake; `None` where something else reports it.
fn fault(mistake: &Mistake, indexed: &IndexedSite, site: &ModelledSite) -> Option<Fault> {
    let camera = |index: usize| site.camera_id(index);
    let degrees = |quarters: u8| u16::from(quarters) * 90;
    let tags = mistake.tags(&indexed.site).into_iter();
    let tags: Vec<TagId> = tags.map(|tag| indexed.tags[tag]).collect();
    let first = tags.first().copied();
    let of_first = first.and_then(|tag| Some((site.object_of(&tag)?.clone(), tag)));
    Some(match *mistake {
        Mistake::CameraMoved { camera: index, .. } => Fault::CameraMoved {
            camera: camera(index)?,
        },
        Mistake::CameraTurned {
            camera: index,
            quarters,
        } => Fault::CameraTurned {
            camera: camera(index)?,
            degrees: degrees(quarters),
        },
        Mistake::CamerasExchanged { a, b } => Fault::CamerasExchanged {
            a: camera(a)?,
            b: camera(b)?,
        },
        Mistake::LensChanged {
            camera: index,
            ratio,
        } => Fault::LensChanged {
            camera: camera(index)?,
            ratio,
        },
        Mistake::TagTurned { quarters, .. } => {
            let (object, tag) = of_first?;
            Fault::TagTurned {
                object,
                tag,
                degrees: degrees(quarters),
            }
        }
        Mistake::TagsExchanged { .. } => {
            let (object, a) = of_first?;
            Fault::TagsExchanged {
                object,
                a,
                b: *tags.get(1)?,
            }
        }
        Mistake::TagResized { ratio, .. } => {
            let (object, tag) = of_first?;
            Fault::TagSize { object, tag, ratio }
        }
        // The models know the scales of objects; clocks and loose tags are not mended.
        Mistake::BodyScaled { .. }
        | Mistake::SizesScaled { .. }
        | Mistake::ClockOff { .. }
        | Mistake::TagMoved { .. } => return None,
    })
}

/// Whether two faults are of one camera or the same, so that the later one replaces the other.
fn is_about_the_same(one: &Fault, other: &Fault) -> bool {
    let camera = |fault: &Fault| match fault {
        Fault::CameraMoved { camera }
        | Fault::CameraTurned { camera, .. }
        | Fault::LensChanged { camera, .. } => Some(camera.clone()),
        _ => None,
    };
    one == other || camera(one).is_some_and(|id| camera(other) == Some(id))
}
