//! Rig and objects by index, with everything that follows from the models computed once, and data association.

pub(crate) mod corrections;
pub(crate) mod indexed_site;

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Matrix6, Vector3};
use sextant_geometry::{Lens, Pose, tag_corners_in_tag};
use thiserror::Error;

use crate::kinematics::chain::{ChainLink, KinematicChain};
use crate::measurement::corner_noise::{CornerNoise, Displacement, area_px2};
use crate::measurement::corners::{CalibratedCamera, TagView};
use crate::measurement::distortion_bias;
use crate::measurement::rolling_shutter::RollingShutter;
use crate::site::corrections::{CameraCorrection, Corrections, ObjectFrame};
use crate::{FusionOptions, OptionsError};
use sextant_site_model::{
    Camera, CameraId, ImageObservation, LensSigma, ObjectId, ObjectModel, ObjectTag, PoseSigma,
    Rig, SIZE_SIGMA, TagCorners, TagId,
};

/// Why objects can't be tracked together.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModelError {
    /// Two objects of one name.
    #[error("object {0} is there twice")]
    DuplicateObject(ObjectId),
    /// One tag on two objects.
    #[error(
        "tag {tag} is on object {first} and on object {second}: print another id for one of them"
    )]
    SharedTag {
        /// The tag.
        tag: TagId,
        /// The object that has it.
        first: ObjectId,
        /// The object that claims it too.
        second: ObjectId,
    },
    /// A tunable outside of its range.
    #[error("options: {0}")]
    Options(#[from] OptionsError),
}

/// A camera of the rig; `posed` is missing until it is calibrated.
#[derive(Debug, Clone)]
pub(crate) struct SiteCamera {
    pub id: CameraId,
    pub resolution: [u32; 2],
    /// As the file has it.
    file: Option<FileCamera>,
    /// As trackers use it: corrected by self-calibration.
    pub posed: Option<CalibratedCamera>,
}

/// Lens and pose of a camera with their priors.
#[derive(Debug, Clone)]
pub(crate) struct FileCamera {
    pub lens: Lens,
    pub world_from_camera: Pose,
    pub sigma: PoseSigma,
    pub lens_sigma: LensSigma,
    /// From the lens's centre to the farthest corner of the image, px.
    reach_px: f64,
    shutter: Option<RollingShutter>,
}

/// Where a tag belongs.
#[derive(Debug, Clone)]
pub(crate) struct TagPlacement {
    object: usize,
    /// As the file has it, with the priors of its pose and of the logarithm of its size.
    pub file: ObjectTag,
    pub prior: PoseSigma,
    pub size_prior: f64,
    /// As it is worked with: the file's with the errors that are known taken off, and how well its place is known.
    pub tag: ObjectTag,
    pub sigma: Option<PoseSigma>,
    chain_link: Option<ChainLink>,
}

/// The models in force.
#[derive(Debug, Clone, Default)]
pub(crate) struct ModelledSite {
    /// Estimates of a camera go by its index here, so that a camera keeps its index for good; those that the rig has no
    /// more are not calibrated and not in `camera_index`.
    cameras: Vec<SiteCamera>,
    camera_index: BTreeMap<CameraId, usize>,
    /// Index of the camera whose clock is the reference: the rig's first.
    reference: usize,
    objects: Vec<ObjectId>,
    places: BTreeMap<TagId, TagPlacement>,
    /// Uncertainty of the frame of each object, by object index.
    frames: BTreeMap<usize, ObjectFrame>,
    /// Variance of the common scale of the sizes of each object's tags: all are of one printer.
    scales: Vec<f64>,
    /// Sigmas of each object's frame as its file states them.
    frame_sigmas: Vec<PoseSigma>,
    /// Whether all models are given as exact.
    is_exact: bool,
    /// Variance of the common scale of the rig as its file states it.
    rig_scale_variance: f64,
    /// The scales of objects that self-calibration finds clearly different from one.
    learned_scales: BTreeMap<usize, f64>,
}

/// Prior of the clock of a camera, by its image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ClockPrior {
    /// Right within the tolerance.
    Right,
    /// The reference unless another clock is right; standard deviation, s.
    Reference(f64),
    /// Standard deviation, s.
    Within(f64),
    /// Nothing is reported of it.
    Unknown,
}

impl ClockPrior {
    /// Standard deviation of its error, s.
    pub fn sigma_s(self, options: &FusionOptions) -> f64 {
        match self {
            Self::Right => 0.0,
            Self::Reference(sigma_s) | Self::Within(sigma_s) => sigma_s,
            Self::Unknown => options.unknown_clock_s,
        }
    }
}

/// The views of one object in one image.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ObjectImage {
    pub camera_index: usize,
    pub capture_ns: u64,
    pub clock: ClockPrior,
    pub views: Vec<TagView>,
}

/// An image, sorted by objects.
#[derive(Debug, Default)]
pub(crate) struct AssociatedImage {
    pub objects: BTreeMap<usize, Arc<ObjectImage>>,
    pub unknown_tags: u64,
    pub damaged_tags: u64,
}

impl SiteCamera {
    /// Lens and pose as the rig's file has them.
    pub fn file(&self) -> Option<&FileCamera> {
        self.file.as_ref()
    }
}

impl TagPlacement {
    /// Index of the object and of the link that has the tag; 0 where the object is rigid.
    pub fn body(&self) -> (usize, usize) {
        let link = self.chain_link.as_ref().map(|chain_link| chain_link.link);
        (self.object, link.unwrap_or(0))
    }
}

impl ModelledSite {
    pub fn new(rig: &Rig, objects: &[ObjectModel]) -> Result<Self, ModelError> {
        let mut site = Self::default();
        site.set_rig(rig);
        site.set_objects(objects)?;
        Ok(site)
    }

    /// How many cameras it knows once a rig is in force.
    pub fn n_cameras_with(&self, rig: &Rig) -> usize {
        let is_new = |camera: &&Camera| !self.cameras.iter().any(|one| one.id == camera.id);
        self.cameras.len() + rig.cameras().iter().filter(is_new).count()
    }

    /// Takes the cameras over that stand still.
    pub fn set_rig(&mut self, rig: &Rig) {
        let still = || rig.cameras().iter().filter(|camera| camera.mount.is_none());
        // The world is where the cameras are: a camera by itself is off from nothing, and needs no place.
        let is_only = still().count() == 1;
        let place = |camera: &Camera| {
            camera
                .world_from_camera
                .or_else(|| is_only.then(Pose::identity))
        };
        let is_alone = still().filter_map(place).count() == 1;
        let file = |camera: &Camera| {
            let middle_row = 0.5 * f64::from(camera.resolution[1] - 1);
            Some(FileCamera {
                lens: camera.lens,
                world_from_camera: place(camera)?,
                sigma: if is_alone {
                    PoseSigma::NONE
                } else {
                    camera.pose_prior.sigma_or(PoseSigma::OF_CAMERA)
                },
                lens_sigma: camera
                    .lens_prior
                    .sigma_or(LensSigma::usual(&camera.lens, !is_alone)),
                reach_px: reach_px(camera),
                shutter: camera.line_delay_s.map(|line_delay_s| RollingShutter {
                    line_delay_s,
                    middle_row,
                }),
            })
        };
        let site_camera = |camera: &Camera| {
            let file = file(camera);
            SiteCamera {
                id: camera.id.clone(),
                resolution: camera.resolution,
                posed: file.as_ref().map(FileCamera::uncorrected),
                file,
            }
        };
        for camera in &mut self.cameras {
            (camera.file, camera.posed) = (None, None);
        }
        self.rig_scale_variance = rig.scale_sigma().unwrap_or(0.0).powi(2);
        self.frames.clear();
        self.camera_index.clear();
        for camera in still().map(site_camera) {
            let known = self.cameras.iter().position(|known| known.id == camera.id);
            let index = known.unwrap_or(self.cameras.len());
            self.camera_index.insert(camera.id.clone(), index);
            match known {
                Some(index) => self.cameras[index] = camera,
                None => self.cameras.push(camera),
            }
        }
        let first = still().next();
        self.reference = first.map_or(0, |camera| self.camera_index[&camera.id]);
        self.is_exact = self.has_exact_models();
    }

    /// Takes all objects over, or none of them.
    pub fn set_objects(&mut self, objects: &[ObjectModel]) -> Result<(), ModelError> {
        let mut places = BTreeMap::new();
        for (index, object) in objects.iter().enumerate() {
            if objects[..index]
                .iter()
                .any(|other| other.id() == object.id())
            {
                return Err(ModelError::DuplicateObject(object.id().clone()));
            }
            let chain = object.articulation().map(KinematicChain::new).map(Arc::new);
            let tags = placed_tags(object);
            let n_placed = tags.iter().filter(|tag| tag.object_from_tag.is_some());
            let usual = match n_placed.count() {
                1 => PoseSigma::NONE,
                _ => PoseSigma::OF_TAG,
            };
            for tag in &tags {
                let chain_link = |chain: &Arc<KinematicChain>| {
                    Some(ChainLink {
                        chain: chain.clone(),
                        link: object.link_of(tag)?,
                    })
                };
                let prior = tag.pose_prior.sigma_or(usual);
                let place = TagPlacement {
                    object: index,
                    file: tag.clone(),
                    prior,
                    size_prior: size_sigma(tag),
                    tag: tag.clone(),
                    sigma: Some(prior).filter(PoseSigma::is_some),
                    chain_link: chain.as_ref().and_then(chain_link),
                };
                if let Some(TagPlacement { object: first, .. }) = places.insert(tag.tag, place) {
                    let (first, second) = (objects[first].id().clone(), object.id().clone());
                    return Err(ModelError::SharedTag {
                        tag: tag.tag,
                        first,
                        second,
                    });
                }
            }
        }
        self.objects = objects.iter().map(|object| object.id().clone()).collect();
        self.places = places;
        let scale_variance = |object: &ObjectModel| object.scale_sigma_or_usual().powi(2);
        self.scales = objects.iter().map(scale_variance).collect();
        let frame_sigma = |object: &ObjectModel| object.frame_sigma().unwrap_or(PoseSigma::NONE);
        self.frame_sigmas = objects.iter().map(frame_sigma).collect();
        self.learned_scales.clear();
        self.frames.clear();
        self.is_exact = self.has_exact_models();
        Ok(())
    }

    /// Whether all models are given as exact.
    pub fn is_exact(&self) -> bool {
        self.is_exact
    }

    fn has_exact_models(&self) -> bool {
        let files = self
            .cameras
            .iter()
            .filter_map(|camera| camera.file.as_ref());
        let mut cameras = files.map(|file| file.sigma.is_some() || file.lens_sigma.is_some());
        let mut tags = self.places.values();
        let open = |place: &TagPlacement| place.prior.is_some() || place.size_prior > 0.0;
        !cameras.any(|open| open) && !tags.any(open)
    }

    /// Applies corrections to the models.
    pub fn correct(&mut self, corrections: &Corrections) {
        let [of_cameras, of_lenses, of_tags] = corrections.unseen;
        for (index, camera) in self.cameras.iter_mut().enumerate() {
            camera.posed = camera.file.as_ref().map(|file| {
                let unseen = || {
                    let lens_sigma = file.lens_sigma.times(of_lenses);
                    CameraCorrection::none(file.sigma.times(of_cameras), lens_sigma)
                };
                let known = corrections.cameras.get(&index).copied();
                file.corrected(&known.unwrap_or_else(unseen))
            });
        }
        for (tag, place) in &mut self.places {
            let known = corrections.tags.get(tag);
            place.tag = known.map_or_else(|| place.file.clone(), |one| one.tag(&place.file));
            let sigma = known.map_or_else(|| place.prior.times(of_tags), |one| one.sigma);
            place.sigma = Some(sigma).filter(PoseSigma::is_some);
        }
        self.frames.clone_from(&corrections.frames);
        let clear = corrections.scales.iter().filter(|(_, one)| one.is_clear());
        self.learned_scales = clear
            .map(|(object, one)| (*object, one.log_factor.exp()))
            .collect();
    }

    /// Lens and pose of a camera as the rig's file has them.
    pub fn file_camera(&self, index: usize) -> Option<&FileCamera> {
        self.cameras.get(index)?.file.as_ref()
    }

    /// A tag on its object.
    pub fn placement(&self, tag: &TagId) -> Option<&TagPlacement> {
        self.places.get(tag)
    }

    /// All tags on their objects.
    pub fn placements(&self) -> impl Iterator<Item = (&TagId, &TagPlacement)> {
        self.places.iter()
    }

    /// The object that has a tag.
    pub fn object_of(&self, tag: &TagId) -> Option<&ObjectId> {
        self.objects.get(self.places.get(tag)?.object)
    }

    /// Uncertainty of the frame of an object and of the common scale; `None` where nothing is uncertain. Of a single
    /// camera nothing but the sizes of tags gives the scale.
    pub fn frame(&self, object: usize) -> Option<ObjectFrame> {
        let centre = || {
            let centres = self.placed().map(|camera| camera.centre);
            centres.sum::<Vector3<f64>>() / self.placed().count().max(1) as f64
        };
        let is_alone = self.has_one_camera();
        let none = || ObjectFrame {
            covariance: Matrix6::zeros(),
            scale_variance: if is_alone { self.scales[object] } else { 0.0 },
            centre: centre(),
        };
        let mut frame = self.frames.get(&object).copied().unwrap_or_else(none);
        frame.covariance += Matrix6::from_diagonal(&self.frame_sigmas[object].variance());
        if !is_alone {
            frame.scale_variance += self.rig_scale_variance;
        }
        Some(frame).filter(ObjectFrame::is_some)
    }

    /// Size of the tags of an object over that of its model, where self-calibration finds it clearly different.
    pub fn learned_scale(&self, object: usize) -> Option<f64> {
        self.learned_scales.get(&object).copied()
    }

    /// Standard deviation of the lens in force of a camera, by its index.
    pub fn lens_sigma(&self, index: usize) -> LensSigma {
        let posed = self
            .cameras
            .get(index)
            .and_then(|camera| camera.posed.as_ref());
        let sigma = posed.and_then(|posed| posed.lens_sigma);
        sigma.unwrap_or(LensSigma::NONE)
    }

    /// Whether a single camera has a pose, so that nothing checks its lens and the sizes of tags.
    pub fn has_one_camera(&self) -> bool {
        self.placed().count() == 1
    }

    fn placed(&self) -> impl Iterator<Item = &CalibratedCamera> {
        self.cameras
            .iter()
            .filter_map(|camera| camera.posed.as_ref())
    }

    /// Prior variance of the logarithm of the common scale of an object's tags.
    pub fn scale_variance(&self, object: usize) -> f64 {
        self.scales[object]
    }

    /// The same views by the models in force.
    pub fn remodelled(&self, image: &ObjectImage, options: &FusionOptions) -> ObjectImage {
        let posed = self.cameras[image.camera_index].posed.as_ref();
        let again = |old: &TagView| {
            let place = self.places.get(&old.tag)?;
            view(place, &old.seen, posed?, options)
        };
        let views = image.views.iter();
        ObjectImage {
            views: views.filter_map(again).collect(),
            ..image.clone()
        }
    }

    /// A view whitened by the detector's noise alone.
    pub fn for_calibration(&self, old: &TagView, options: &FusionOptions) -> Option<TagView> {
        let noise = CornerNoise::from_corners(&old.seen, &Displacement::default(), options)?;
        Some(TagView {
            information: noise.information,
            whitening: noise.whitening,
            is_joint: noise.is_joint,
            ..old.clone()
        })
    }

    pub fn objects(&self) -> &[ObjectId] {
        &self.objects
    }

    /// Index of the camera whose clock is the reference where no other clock is verified.
    pub fn reference(&self) -> usize {
        self.reference
    }

    pub fn cameras(&self) -> &[SiteCamera] {
        &self.cameras
    }

    pub fn camera_id(&self, index: usize) -> Option<CameraId> {
        Some(self.cameras.get(index)?.id.clone())
    }

    pub fn camera(&self, id: &CameraId) -> Option<(usize, &SiteCamera)> {
        let index = *self.camera_index.get(id)?;
        Some((index, &self.cameras[index]))
    }

    /// Standard deviation of a camera's pose; `None` where it is exact or unknown.
    pub fn camera_sigma(&self, index: usize) -> Option<PoseSigma> {
        self.cameras.get(index)?.posed.as_ref()?.sigma
    }

    /// The views of an image by object. Counts tags that cannot be used.
    pub fn associate(
        &self,
        camera_index: usize,
        image: &ImageObservation,
        options: &FusionOptions,
    ) -> AssociatedImage {
        let mut associated = AssociatedImage::default();
        let mut views: BTreeMap<usize, Vec<TagView>> = BTreeMap::new();
        let camera = &self.cameras[camera_index];
        let Some(posed) = &camera.posed else {
            return associated;
        };
        for seen in &image.tags {
            let Some(place) = self.places.get(&seen.tag) else {
                associated.unknown_tags += 1;
                continue;
            };
            if !is_sound(seen, camera.resolution) {
                associated.damaged_tags += 1;
            } else if let Some(view) = view(place, seen, posed, options) {
                views.entry(place.object).or_default().push(view);
            }
        }
        let object_image = |views: Vec<TagView>| {
            Arc::new(ObjectImage {
                camera_index,
                capture_ns: image.capture_ns,
                clock: self.clock_prior(camera_index, image.clock_error_ns, options),
                views: ordered(views),
            })
        };
        associated.objects = views
            .into_iter()
            .map(|(object, views)| (object, object_image(views)))
            .collect();
        associated
    }

    /// The first camera of the rig is the reference; where it says itself that its clock may be off, unless another's
    /// is right.
    fn clock_prior(
        &self,
        camera_index: usize,
        error_ns: u64,
        options: &FusionOptions,
    ) -> ClockPrior {
        let sigma_s = error_ns as f64 * 1e-9;
        match error_ns {
            ImageObservation::CLOCK_ERROR_UNKNOWN if camera_index == self.reference => {
                ClockPrior::Right
            }
            ImageObservation::CLOCK_ERROR_UNKNOWN => ClockPrior::Unknown,
            _ if sigma_s <= options.right_clock_s => ClockPrior::Right,
            _ if camera_index == self.reference => ClockPrior::Reference(sigma_s),
            _ => ClockPrior::Within(sigma_s),
        }
    }
}

/// The tags of an object: an object is where its tags are, so that a single one without a place is its frame.
fn placed_tags(object: &ObjectModel) -> Vec<ObjectTag> {
    let is_only = object.tags().len() == 1;
    let placed = object.tags().iter().cloned().map(|tag| ObjectTag {
        object_from_tag: tag.object_from_tag.or_else(|| is_only.then(Pose::identity)),
        ..tag
    });
    placed.collect()
}

/// Prior standard deviation of the logarithm of the size of a tag.
fn size_sigma(tag: &ObjectTag) -> f64 {
    let given_m = tag.size_prior.given();
    given_m.map_or(SIZE_SIGMA, |sigma_m| sigma_m / tag.size_m)
}

impl FileCamera {
    fn uncorrected(&self) -> CalibratedCamera {
        self.corrected(&CameraCorrection::none(self.sigma, self.lens_sigma))
    }

    /// First coefficient of the distortion that moves the corners of the image by a pixel.
    pub fn distortion_per_px(&self) -> f64 {
        let focal = self.lens.intrinsics().fx;
        (focal * (self.reach_px / focal).powi(3)).recip()
    }

    /// The camera with errors taken off.
    pub fn corrected(&self, correction: &CameraCorrection) -> CalibratedCamera {
        let pose = correction.pose(&self.world_from_camera);
        let sigma = Some(correction.sigma).filter(PoseSigma::is_some);
        let mut posed = CalibratedCamera::new(correction.lens(&self.lens), &pose, sigma);
        posed.lens_sigma = Some(correction.lens_sigma).filter(LensSigma::is_some);
        posed.reach_px = self.reach_px;
        posed.shutter = self.shutter;
        posed
    }
}

/// The views in an order that does not depend on the detector's: by tag, then by position.
fn ordered(mut views: Vec<TagView>) -> Vec<TagView> {
    views.sort_by(|a, b| {
        let corner = |view: &TagView| view.corners_in_image[0];
        let by_position = corner(a)
            .x
            .total_cmp(&corner(b).x)
            .then(corner(a).y.total_cmp(&corner(b).y));
        a.tag.cmp(&b.tag).then(by_position)
    });
    views
}

/// Whether all corners are numbers, and lie in the image or not farther outside than it is large.
fn is_sound(seen: &TagCorners, [width, height]: [u32; 2]) -> bool {
    let within = |x: f64, size: u32| (-f64::from(size)..=2.0 * f64::from(size)).contains(&x);
    let covariance = seen.covariance();
    seen.corners
        .iter()
        .all(|corner| within(corner.x, width) && within(corner.y, height))
        && covariance.iter().all(|x| x.is_finite())
}

/// The view of a tag whose place on the object is known, if its corners enclose something.
fn view(
    place: &TagPlacement,
    seen: &TagCorners,
    camera: &CalibratedCamera,
    options: &FusionOptions,
) -> Option<TagView> {
    let tag = &place.tag;
    let object_from_tag = tag.object_from_tag?;
    let noise = CornerNoise::from_corners(seen, &displacement(camera, seen, place), options)?;
    Some(TagView {
        tag: tag.tag,
        chain_link: place.chain_link.clone(),
        size_m: tag.size_m,
        object_from_tag,
        corners_in_object: tag_corners_in_tag(tag.size_m).map(|corner| object_from_tag * corner),
        corners_in_image: seen.corners,
        seen: seen.clone(),
        distortion_bias: distortion_bias::distortion_bias(&camera.lens, tag.tag, &seen.corners),
        information: noise.information,
        whitening: noise.whitening,
        is_joint: noise.is_joint,
        noise_source: noise.source,
        tag_sigma: place.sigma,
        after_s: camera.shutter.map(|shutter| shutter.after_s(&seen.corners)),
    })
}

/// How errors of camera pose, lens and tag displace a view against others. What a camera or a tag by itself shows
/// contradicts nothing, and has no sigma.
fn displacement(
    camera: &CalibratedCamera,
    seen: &TagCorners,
    place: &TagPlacement,
) -> Displacement {
    let px_per_m = area_px2(&seen.corners).sqrt() / place.tag.size_m;
    let shifted = |sigma: PoseSigma| (sigma.position_m * px_per_m).powi(2);
    let by_lens = || {
        let sigma = camera.lens_sigma?;
        let displaced = camera.displaced_by_lens(&seen.corners[0]);
        let focal = displaced.column(0) * sigma.focal_px;
        let distortion = displaced.column(1) * sigma.distortion_px;
        Some(0.5 * (focal.norm_squared() + distortion.norm_squared()))
    };
    let by_camera = camera.sigma.map(|sigma| {
        let turned = sigma.orientation_rad * camera.lens.intrinsics().fx;
        shifted(sigma) + turned.powi(2) + by_lens().unwrap_or_default()
    });
    let by_tag = place.sigma.map(|sigma| Displacement {
        apart: 0.0,
        shift: shifted(sigma),
        turn: sigma.orientation_rad.powi(2),
        scale: place.size_prior.powi(2),
    });
    Displacement {
        apart: by_camera.unwrap_or_default(),
        ..by_tag.unwrap_or_default()
    }
}

/// Pixels from the lens's centre to the farthest corner of the image.
fn reach_px(camera: &Camera) -> f64 {
    let [width, height] = camera.resolution.map(|pixels| f64::from(pixels) - 1.0);
    let numbers = camera.lens.intrinsics();
    let farthest = |centre: f64, last: f64| centre.abs().max((last - centre).abs());
    farthest(numbers.cx, width).hypot(farthest(numbers.cy, height))
}
