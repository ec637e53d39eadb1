//! Small scenes: cameras in a ring around a cube that moves smoothly, corners projected exactly with Gaussian noise.

use nalgebra::{Matrix2, Point2, Point3, Rotation3, UnitQuaternion, Vector2, Vector3, Vector6};
use sextant_estimator::{Fusion, FusionOptions, Input, Output};
use sextant_geometry::lens::Intrinsics;
use sextant_geometry::{Lens, Pose, se3, tag_corners_in_tag};
use sextant_site_model::{
    Camera, CameraId, ImageObservation, ObjectId, ObjectModel, ObjectTag, PoseSigma, Prior, Rig,
    TagCorners, TagId,
};
use sextant_site_report::ObjectEstimate;
use sextant_tag_families::Family;

/// Start of all scenes, in ns since the epoch.
pub const START_NS: u64 = 1_700_000_000_000_000_000;
/// Distance of the images of one camera, in ns.
pub const PERIOD_NS: u64 = 33_333_333;

/// Seeded random numbers (splitmix64, Box-Muller).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0..1.
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn gauss(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

pub fn camera_id(index: usize) -> CameraId {
    CameraId::new(&format!("cam{index}")).unwrap()
}

pub fn cube_id() -> ObjectId {
    ObjectId::new("cube").unwrap()
}

pub fn tag_id(id: u32) -> TagId {
    TagId {
        family: Family::Tag36h11,
        id,
    }
}

/// World from a camera at a place, looking at the world's origin, its x level.
pub fn looking_from(place: Vector3<f64>) -> Pose {
    let forward = -place.normalize();
    let right = forward.cross(&Vector3::z()).normalize();
    let down = forward.cross(&right);
    let rotation = Rotation3::from_basis_unchecked(&[right, down, forward]);
    Pose::from_parts(
        place.into(),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}

/// Cameras in a ring of 1 m radius, 0.7 m above the object.
pub fn rig(cameras: usize) -> Rig {
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    };
    let camera = |index: usize| {
        let angle = std::f64::consts::TAU * index as f64 / cameras.max(4) as f64;
        Camera::new(
            camera_id(index),
            [640, 480],
            Lens::pinhole(intrinsics).unwrap(),
            Some(looking_from(Vector3::new(angle.cos(), angle.sin(), 0.7))),
        )
    };
    Rig::new((0..cameras).map(camera).collect())
        .unwrap()
        .exact()
}

/// The camera as a file has it that gives no priors.
pub fn unstated(camera: &Camera) -> Camera {
    Camera::new(
        camera.id.clone(),
        camera.resolution,
        camera.lens,
        camera.world_from_camera,
    )
}

/// The rig with all cameras changed.
pub fn with_cameras(rig: &Rig, change: impl FnMut(&mut Camera)) -> Rig {
    let mut cameras = rig.cameras().to_vec();
    cameras.iter_mut().for_each(change);
    Rig::new(cameras).unwrap()
}

/// The object with this prior of the poses of all tags.
pub fn with_pose_priors(object: &ObjectModel, sigma: PoseSigma) -> ObjectModel {
    let pose_prior = Prior::Sigma(sigma);
    let tags = object.tags().iter().cloned();
    tags.fold(object.clone(), |object, tag| {
        object.with_tag(ObjectTag { pose_prior, ..tag })
    })
}

/// A cube of 6 cm edge with a tag of 4 cm on each side.
pub fn cube() -> ObjectModel {
    let turns = [
        (0.0, 0.0),
        (0.5, 0.0),
        (1.0, 0.0),
        (-0.5, 0.0),
        (0.0, 0.5),
        (0.0, -0.5),
    ];
    let tag = |(id, (about_x, about_y)): (usize, (f64, f64))| {
        let turn = UnitQuaternion::from_euler_angles(
            about_x * std::f64::consts::PI,
            about_y * std::f64::consts::PI,
            0.0,
        );
        let place = turn * Vector3::new(0.0, 0.0, 0.03);
        ObjectTag::new(
            tag_id(id as u32),
            0.04,
            Some(Pose::from_parts(place.into(), turn)),
        )
    };
    ObjectModel::new(cube_id(), turns.into_iter().enumerate().map(tag).collect())
        .unwrap()
        .exact()
}

/// A card with one tag, its face along z of the object.
pub fn card() -> ObjectModel {
    let tag = ObjectTag::new(tag_id(0), 0.04, Some(Pose::identity()));
    ObjectModel::new(cube_id(), vec![tag]).unwrap().exact()
}

/// World from the moving cube, `seconds` after the start: up to 0.4 m/s and 2 rad/s.
pub fn path(seconds: f64) -> Pose {
    let place = Vector3::new(
        (1.7 * seconds).sin() * 0.12,
        (1.3 * seconds).cos() * 0.12,
        (2.1 * seconds).sin() * 0.08,
    );
    let turn = Vector3::new(
        0.9 * (1.1 * seconds).sin(),
        0.7 * (0.8 * seconds).cos(),
        1.2 * seconds,
    );
    Pose::from_parts(place.into(), UnitQuaternion::from_scaled_axis(turn))
}

pub fn path_at(time_ns: u64) -> Pose {
    path((time_ns as i128 - START_NS as i128) as f64 * 1e-9)
}

/// What a camera sees of an object at a pose.
pub struct Eye<'a> {
    pub rig: &'a Rig,
    pub object: &'a ObjectModel,
    pub sigma_px: f64,
}

impl Eye<'_> {
    /// The image of a camera; `time_ns` is the stamp, `pose` the object's at the true time.
    pub fn image(
        &self,
        camera: usize,
        time_ns: u64,
        pose: &Pose,
        random: &mut Random,
    ) -> ImageObservation {
        let at = |_: f64| *pose;
        self.image_over_time(camera, time_ns, &at, random)
    }

    /// The same by the camera's shutter: `pose` is the object's by seconds after the capture time. A corner is taken
    /// when its row is.
    pub fn image_over_time(
        &self,
        camera: usize,
        time_ns: u64,
        pose: &dyn Fn(f64) -> Pose,
        random: &mut Random,
    ) -> ImageObservation {
        let camera = &self.rig.cameras()[camera];
        let tags = self
            .object
            .tags()
            .iter()
            .filter_map(|tag| self.tag(camera, tag, pose, random));
        ImageObservation {
            camera: camera.id.clone(),
            capture_ns: time_ns,
            clock_error_ns: 0,
            exposure_ns: 0,
            resolution: None,
            tags: tags.collect(),
        }
    }

    fn tag(
        &self,
        camera: &Camera,
        tag: &ObjectTag,
        pose: &dyn Fn(f64) -> Pose,
        random: &mut Random,
    ) -> Option<TagCorners> {
        let (camera_from_world, object_from_tag) =
            (camera.world_from_camera?.inverse(), tag.object_from_tag?);
        let line_delay_s = camera.line_delay_s.unwrap_or(0.0);
        let middle_row = 0.5 * f64::from(camera.resolution[1] - 1);
        let camera_from_tag = camera_from_world * pose(0.0) * object_from_tag;
        let towards = camera_from_tag.translation.vector.normalize();
        let outwards = camera_from_tag.rotation * Vector3::z();
        if -outwards.dot(&towards) < 0.2 {
            return None;
        }
        let corners = tag_corners_in_tag(tag.size_m).map(|corner: Point3<f64>| {
            let mut after_s = 0.0;
            // The row says when, and when says the row: a few rounds settle it.
            for _ in 0..5 {
                let camera_from_tag = camera_from_world * pose(after_s) * object_from_tag;
                let row = camera.lens.project(&(camera_from_tag * corner))?.y;
                after_s = (row - middle_row) * line_delay_s;
            }
            let camera_from_tag = camera_from_world * pose(after_s) * object_from_tag;
            camera.lens.project(&(camera_from_tag * corner))
        });
        let [Some(a), Some(b), Some(c), Some(d)] = corners else {
            return None;
        };
        let noisy = |corner: Point2<f64>, random: &mut Random| {
            corner + Vector2::new(random.gauss(), random.gauss()) * self.sigma_px
        };
        let corners = [a, b, c, d].map(|corner| noisy(corner, random));
        let inside = |corner: &Point2<f64>| {
            (0.0..640.0).contains(&corner.x) && (0.0..480.0).contains(&corner.y)
        };
        let covariance = Matrix2::identity() * self.sigma_px.powi(2);
        corners.iter().all(inside).then_some(TagCorners {
            tag: tag.tag,
            corners,
            corner_covariance: [covariance; 4],
            corner_cross_covariance: [Matrix2::zeros(); 6],
        })
    }
}

/// Options for scenes whose noise is exactly the reported one.
pub fn exact_options() -> FusionOptions {
    FusionOptions {
        corner_floor_px: 0.0,
        noise_memory: 1e6,
        ..FusionOptions::default()
    }
}

pub fn fusion(rig: &Rig, object: &ObjectModel, options: FusionOptions) -> Fusion {
    Fusion::new(rig.clone(), vec![object.clone()], options).unwrap()
}

/// Takes an image in 10 ms after its capture; the poses that come out.
pub fn feed(fusion: &mut Fusion, image: ImageObservation) -> Vec<ObjectEstimate> {
    fusion.handle(image.capture_ns + 10_000_000, Input::Image(image));
    poses(fusion)
}

pub fn poses(fusion: &mut Fusion) -> Vec<ObjectEstimate> {
    let pose = |output: Output| match output {
        Output::Pose(estimate) => Some(estimate),
        _ => None,
    };
    std::iter::from_fn(|| fusion.poll_output())
        .filter_map(pose)
        .collect()
}

/// Estimate minus truth, as FRAMES.md has it.
pub fn error(estimate: &ObjectEstimate, truth: &Pose) -> Vector6<f64> {
    se3::difference(&estimate.world_from_object, truth)
}

pub fn position_error(estimate: &ObjectEstimate, truth: &Pose) -> f64 {
    error(estimate, truth).fixed_rows::<3>(0).norm()
}

pub fn attitude_error(estimate: &ObjectEstimate, truth: &Pose) -> f64 {
    error(estimate, truth).fixed_rows::<3>(3).norm()
}

/// Images of all cameras over some seconds, each camera at its own phase, in the order of capture.
pub fn run(
    rig: &Rig,
    object: &ObjectModel,
    sigma_px: f64,
    seconds: f64,
    random: &mut Random,
) -> Vec<ImageObservation> {
    let cameras = rig.cameras().len() as u64;
    let eye = Eye {
        rig,
        object,
        sigma_px,
    };
    run_in_phase(
        &eye,
        seconds,
        |camera| camera as u64 * PERIOD_NS / cameras,
        random,
    )
}

/// The same with each camera at the phase given in ns.
pub fn run_in_phase(
    eye: &Eye<'_>,
    seconds: f64,
    phase_ns: impl Fn(usize) -> u64,
    random: &mut Random,
) -> Vec<ImageObservation> {
    let mut images = Vec::new();
    for round in 0..(seconds * 1e9 / PERIOD_NS as f64) as u64 {
        for camera in 0..eye.rig.cameras().len() {
            let time_ns = START_NS + round * PERIOD_NS + phase_ns(camera);
            images.push(eye.image(camera, time_ns, &path_at(time_ns), random));
        }
    }
    images
}
