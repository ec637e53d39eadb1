//! Corrections of the models by self-calibration: a step from the file for each, with the standard deviation that is
//! left.

use std::collections::BTreeMap;

use nalgebra::{Matrix6, Vector3, Vector6};
use sextant_geometry::{Lens, Pose, se3};

use sextant_site_model::{LensSigma, MOST_LENS_SIGMA_PX, ObjectTag, PoseSigma, TagId};

/// Errors of the site's files as estimated.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Corrections {
    /// By camera index.
    pub cameras: BTreeMap<usize, CameraCorrection>,
    pub tags: BTreeMap<TagId, TagCorrection>,
    /// By object index.
    pub frames: BTreeMap<usize, ObjectFrame>,
    /// Of the print of each object, by its index; it is in the corrections of its tags.
    pub scales: BTreeMap<usize, ScaleCorrection>,
    /// Factors on the priors of what no keyframe shows yet: camera poses, lenses, tag poses.
    pub unseen: [f64; 3],
    /// Factor on all sigmas: errors that are correlated do less than independent ones with the same variances.
    pub independence: f64,
}

/// Correction of one camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CameraCorrection {
    /// From the file's `world_from_camera`, (dt, dr) as FRAMES.md has them, m and rad.
    pub step: Vector6<f64>,
    /// Added to fx and fy, px.
    pub focal_px: f64,
    /// Added to the first coefficient of the distortion.
    pub distortion: f64,
    /// Standard deviation that is left, relative to the other cameras.
    pub sigma: PoseSigma,
    pub lens_sigma: LensSigma,
}

/// Correction of one tag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TagCorrection {
    /// From the file's `object_from_tag`, in axes of the object about the tag's centre, m and rad.
    pub step: Vector6<f64>,
    /// Logarithm of the size over the file's.
    pub log_size: f64,
    /// Standard deviation that is left, relative to the object's other tags.
    pub sigma: PoseSigma,
}

/// Correction of the common scale of an object's tags.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ScaleCorrection {
    /// Logarithm of their places and sizes over the file's.
    pub log_factor: f64,
    /// Standard deviation that is left.
    pub sigma: f64,
}

impl ScaleCorrection {
    /// Whether the print is clearly not as large as its file says.
    pub(crate) fn is_clear(&self) -> bool {
        self.log_factor.abs() > LEAST_LOG_SCALE.max(CLEAR * self.sigma)
    }
}

/// Least logarithm of a scale that is worth a message, three times what prints usually are off by; and standard
/// deviations of it.
const LEAST_LOG_SCALE: f64 = 0.015;
const CLEAR: f64 = 3.0;

/// Uncertainty of the frame of an object, and of the common scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ObjectFrame {
    /// Covariance of the object's frame by its tags' poses in the file, in axes of the object about its origin.
    pub covariance: Matrix6<f64>,
    /// Variance of the common scale of the site, by which distances from `centre` in the world are uncertain.
    pub scale_variance: f64,
    pub centre: Vector3<f64>,
}

/// Steps smaller than such a share of a default sigma are no correction: the share at which a class has no errors, and
/// rounding.
const NEGLIGIBLE: f64 = 2e-3;
/// Share of a default sigma that no figure in a file is better than: a site warms up, is cleaned and is touched.
const LEAST_SIGMA: f64 = 0.05;

impl Corrections {
    /// The corrections that are not negligible, with standard deviations as a file gives them.
    pub(crate) fn for_files<'a>(&self, file_lens: impl Fn(usize) -> Option<&'a Lens>) -> Self {
        let own = |sigma: PoseSigma, least: PoseSigma| {
            let (own, least) = (
                sigma.times(self.independence.recip()),
                least.times(LEAST_SIGMA),
            );
            PoseSigma {
                position_m: own.position_m.clamp(least.position_m, 1.0),
                orientation_rad: own.orientation_rad.clamp(least.orientation_rad, 1.0),
            }
        };
        let camera = |(camera, one): (&usize, &CameraCorrection)| {
            let usual = LensSigma::usual(file_lens(*camera)?, true);
            let bends = one.focal_px.abs() > usual.focal_px * NEGLIGIBLE || one.distortion != 0.0;
            let (focal_px, distortion) = if bends {
                (one.focal_px, one.distortion)
            } else {
                (0.0, 0.0)
            };
            let left = one.lens_sigma.times(self.independence.recip());
            let known = CameraCorrection {
                step: one.step,
                focal_px,
                distortion,
                sigma: own(one.sigma, PoseSigma::OF_CAMERA),
                lens_sigma: LensSigma {
                    focal_px: left
                        .focal_px
                        .max(usual.focal_px * LEAST_SIGMA)
                        .min(MOST_LENS_SIGMA_PX),
                    distortion_px: left
                        .distortion_px
                        .max(usual.distortion_px * LEAST_SIGMA)
                        .min(MOST_LENS_SIGMA_PX),
                },
            };
            let is_some = known.has_lens() || is_step(&one.step, PoseSigma::OF_CAMERA);
            is_some.then_some((*camera, known))
        };
        let tag = |(tag, one): (&TagId, &TagCorrection)| {
            let is_some =
                one.log_size.abs() > NEGLIGIBLE_SIZE || is_step(&one.step, PoseSigma::OF_TAG);
            let known = TagCorrection {
                sigma: own(one.sigma, PoseSigma::OF_TAG),
                ..*one
            };
            is_some.then_some((*tag, known))
        };
        Self {
            cameras: self.cameras.iter().filter_map(camera).collect(),
            tags: self.tags.iter().filter_map(tag).collect(),
            frames: self.frames.clone(),
            ..Self::default()
        }
    }

    /// The errors as uncertainty of the files' values, which stay.
    pub(crate) fn considered(mut self) -> Self {
        for one in self.cameras.values_mut() {
            one.sigma = with_step(one.sigma, &one.step);
            one.lens_sigma.focal_px = one.lens_sigma.focal_px.hypot(one.focal_px);
            one.step = Vector6::zeros();
            (one.focal_px, one.distortion) = (0.0, 0.0);
        }
        for one in self.tags.values_mut() {
            one.sigma = with_step(one.sigma, &one.step);
            one.step = Vector6::zeros();
            one.log_size = 0.0;
        }
        self.scales.clear();
        self
    }
}

fn with_step(sigma: PoseSigma, step: &Vector6<f64>) -> PoseSigma {
    let an_axis = |first: usize| (step.fixed_rows::<3>(first).norm_squared() / 3.0).sqrt();
    PoseSigma {
        position_m: sigma.position_m.hypot(an_axis(0)),
        orientation_rad: sigma.orientation_rad.hypot(an_axis(3)),
    }
}

/// Factor by which a sigma must change to matter.
const OTHER_SIGMA: f64 = 1.4;

impl Corrections {
    /// Whether other corrections differ only within their uncertainty: no step by more than its standard deviation, and
    /// no standard deviation by much.
    pub(crate) fn is_close(&self, other: &Self) -> bool {
        let cameras = self.cameras.iter().all(|(camera, one)| {
            let other = other.cameras.get(camera);
            other.map_or(one.is_nothing(), |other| {
                is_within_sigma(&one.step, &one.sigma, &other.step, &other.sigma)
                    && (one.focal_px - other.focal_px).abs() <= one.lens_sigma.focal_px
            })
        });
        let tags = self.tags.iter().all(|(tag, one)| {
            let other = other.tags.get(tag);
            other.map_or(one.is_nothing(), |other| {
                is_within_sigma(&one.step, &one.sigma, &other.step, &other.sigma)
                    && (one.log_size - other.log_size).abs() <= CLOSE_SIZE
            })
        });
        cameras && tags
    }
}

/// Share of a size that does not matter, and that is nothing.
const CLOSE_SIZE: f64 = 0.0005;
const NEGLIGIBLE_SIZE: f64 = 1e-5;

fn is_step(step: &Vector6<f64>, usual: PoseSigma) -> bool {
    let far = |first: usize, usual: f64| step.fixed_rows::<3>(first).norm() > NEGLIGIBLE * usual;
    far(0, usual.position_m) || far(3, usual.orientation_rad)
}

/// Whether a step and its deviations differ from those before only within the deviations.
fn is_within_sigma(
    step: &Vector6<f64>,
    sigma: &PoseSigma,
    step_before: &Vector6<f64>,
    before: &PoseSigma,
) -> bool {
    let apart = step - step_before;
    let near = |first: usize, sigma: f64| apart.fixed_rows::<3>(first).amax() <= sigma;
    let alike = |one: f64, other: f64| one <= other * OTHER_SIGMA && other <= one * OTHER_SIGMA;
    near(0, sigma.position_m)
        && near(3, sigma.orientation_rad)
        && alike(sigma.position_m, before.position_m)
        && alike(sigma.orientation_rad, before.orientation_rad)
}

impl TagCorrection {
    /// The file's values are exact.
    pub const NONE: Self = Self {
        step: Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        log_size: 0.0,
        sigma: PoseSigma::NONE,
    };

    fn is_nothing(&self) -> bool {
        self.step == Vector6::zeros() && self.log_size == 0.0 && !self.sigma.is_some()
    }
}

impl CameraCorrection {
    /// The file's values are exact.
    pub const NONE: Self = Self {
        step: Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        focal_px: 0.0,
        distortion: 0.0,
        sigma: PoseSigma::NONE,
        lens_sigma: LensSigma::NONE,
    };

    /// Whether the lens is corrected.
    pub fn has_lens(&self) -> bool {
        self.focal_px != 0.0 || self.distortion != 0.0
    }

    fn is_nothing(&self) -> bool {
        self.step == Vector6::zeros() && !self.sigma.is_some() && !self.lens_sigma.is_some()
    }

    /// The file's values stand.
    pub fn none(sigma: PoseSigma, lens_sigma: LensSigma) -> Self {
        Self {
            step: Vector6::zeros(),
            focal_px: 0.0,
            distortion: 0.0,
            sigma,
            lens_sigma,
        }
    }

    pub fn pose(&self, world_from_camera: &Pose) -> Pose {
        se3::perturb(world_from_camera, &self.step)
    }

    /// The file's lens with the correction; the file's where that would be no lens.
    pub fn lens(&self, lens: &Lens) -> Lens {
        if self.focal_px == 0.0 && self.distortion == 0.0 {
            // To make a lens is slow: its valid field is searched for.
            return *lens;
        }
        let mut numbers = lens.parameters();
        let n_intrinsics = 4;
        numbers[0] += self.focal_px;
        numbers[1] += self.focal_px;
        if let Some(first) = numbers.get_mut(n_intrinsics) {
            *first += self.distortion;
        }
        Lens::from_parameters(lens.model(), &numbers).unwrap_or(*lens)
    }
}

impl TagCorrection {
    pub fn tag(&self, tag: &ObjectTag) -> ObjectTag {
        let place = tag.object_from_tag.as_ref();
        ObjectTag {
            size_m: tag.size_m * self.log_size.exp(),
            object_from_tag: place.map(|pose| se3::perturb(pose, &self.step)),
            ..tag.clone()
        }
    }
}

impl ObjectFrame {
    /// Whether anything is uncertain.
    pub fn is_some(&self) -> bool {
        self.scale_variance > 0.0 || self.covariance.diagonal().amax() > 0.0
    }

    /// Standard deviations of the frame: root mean squares of the axes.
    pub fn sigma(&self) -> PoseSigma {
        let of_axes = |first: usize| {
            let variances = self.covariance.diagonal();
            (variances.fixed_rows::<3>(first).sum() / 3.0).sqrt()
        };
        PoseSigma {
            position_m: of_axes(0),
            orientation_rad: of_axes(3),
        }
    }

    /// What it adds to the covariance of the object's pose in the world.
    pub fn covariance_of(&self, world_from_object: &Pose) -> Matrix6<f64> {
        let turn = world_from_object.rotation.to_rotation_matrix();
        let mut turns = Matrix6::zeros();
        for at in [0, 3] {
            turns
                .fixed_view_mut::<3, 3>(at, at)
                .copy_from(turn.matrix());
        }
        let mut covariance = turns * self.covariance * turns.transpose();
        let arm = world_from_object.translation.vector - self.centre;
        let mut of_position = covariance.fixed_view_mut::<3, 3>(0, 0);
        of_position += arm * arm.transpose() * self.scale_variance;
        covariance
    }
}
