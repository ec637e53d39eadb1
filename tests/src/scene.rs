//! A site in virtual time without images: cameras in a ring around tagged cubes that move, corners projected exactly
//! and rounded as a detector's would be noisy. What is true may differ from what the site believes: that is a fault.

use nalgebra::{Point3, Rotation3, UnitQuaternion, Vector3};
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
use sextant_proto::{ClockQuality, ClockSource, Observations, TagObservation, Timing};
use sextant_simulator::Random;
use sextant_site_model::{Camera, CameraId, ObjectId, ObjectModel, ObjectTag, Rig, TagId};
use sextant_tag_families::Family;

/// Half a pixel of noise would drown a wrong tag; this is what good images give.
const SIGMA_PX: f64 = 0.05;
/// Edge of a cube, and of the tags on it, metres.
const EDGE_M: f64 = 0.06;
const TAG_M: f64 = 0.04;

/// What is true of a site.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The cameras as they stand.
    pub rig: Rig,
    /// The objects as they are.
    pub objects: Vec<ObjectModel>,
    /// Seconds that a camera's stamps lie after the truth, by camera.
    pub clock_offsets_s: Vec<f64>,
    random: Random,
}

impl Scene {
    /// `cameras` in a ring of 1 m, `names` on cubes between them.
    ///
    /// # Panics
    /// When a name is none.
    #[must_use]
    pub fn new(cameras: usize, names: &[&str]) -> Self {
        let cubes = names.iter().zip(0..).map(|(name, k)| cube(name, 6 * k));
        let rig = Rig::new((0..cameras).map(|k| camera(k, cameras)).collect());
        Self::from_models(rig.expect("a rig"), cubes.collect())
    }

    /// These cameras and objects, with true clocks.
    #[must_use]
    pub fn from_models(rig: Rig, objects: Vec<ObjectModel>) -> Self {
        Self {
            clock_offsets_s: vec![0.0; rig.cameras().len()],
            rig,
            objects,
            random: Random::new(1),
        }
    }

    /// The site as its files have it after somebody measured it by hand: cameras a centimetre and a third of a degree
    /// off.
    ///
    /// # Panics
    /// Never: the cameras have poses.
    #[must_use]
    pub fn measured_by_hand(&self) -> Self {
        let mut random = Random::new(7);
        let mut errors = |sigma: f64| Vector3::from_fn(|_, _| sigma * random.normal());
        let cameras = self.rig.cameras().iter().map(|camera| {
            let error = Pose::from_parts(
                errors(0.006).into(),
                UnitQuaternion::from_scaled_axis(errors(0.0035)),
            );
            let pose = camera.world_from_camera.map(|pose| pose * error);
            Camera::new(camera.id.clone(), camera.resolution, camera.lens, pose)
        });
        Self {
            rig: Rig::new(cameras.collect()).expect("a rig"),
            ..self.clone()
        }
    }

    /// The site as its files have it when the origin of the world lay this far away: nothing contradicts them.
    ///
    /// # Panics
    /// Never: the cameras have poses.
    #[must_use]
    pub fn moved(&self, by_m: f64) -> Self {
        let shift = Pose::translation(by_m, 0.0, 0.0);
        let cameras = self.rig.cameras().iter().map(|camera| {
            let pose = camera.world_from_camera.map(|pose| shift * pose);
            Camera::new(camera.id.clone(), camera.resolution, camera.lens, pose)
        });
        Self {
            rig: Rig::new(cameras.collect()).expect("a rig"),
            ..self.clone()
        }
    }

    /// What a camera sees at `time_ns`, as its node would publish it; the objects are where they are `seconds` after
    /// the start.
    pub fn observe(&mut self, camera: usize, seconds: f64, time_ns: u64) -> Observations {
        let objects = self.objects.clone();
        let placed = objects.iter().enumerate();
        let placed: Vec<(&ObjectModel, Pose)> = placed
            .map(|(k, object)| (object, place(k, seconds)))
            .collect();
        self.see(camera, &placed, time_ns)
    }

    /// The same of any objects anywhere.
    pub fn see(
        &mut self,
        camera: usize,
        objects: &[(&ObjectModel, Pose)],
        time_ns: u64,
    ) -> Observations {
        let seen = self.rig.cameras()[camera].clone();
        let mut tags = Vec::new();
        for (object, world_from_object) in objects {
            for tag in object.tags() {
                tags.extend(self.tag(&seen, world_from_object, tag));
            }
        }
        let offset_ns = (self.clock_offsets_s[camera] * 1e9) as i64;
        Observations {
            camera: seen.id.clone(),
            sequence: 1,
            capture_ns: time_ns.saturating_add_signed(offset_ns),
            exposure_ns: 0,
            clock: ClockQuality {
                source: ClockSource::Unknown,
                error_ns: 0,
            },
            resolution: seen.resolution.map(|pixels| pixels as u16),
            timing: Timing::default(),
            tags,
        }
    }

    /// A tag as a camera sees it: from its front, whole, not too aslant.
    fn tag(&mut self, camera: &Camera, world: &Pose, tag: &ObjectTag) -> Option<TagObservation> {
        let camera_from_tag = camera.world_from_camera?.inverse() * world * tag.object_from_tag?;
        let centre = camera_from_tag.translation.vector;
        let normal = camera_from_tag.rotation * Vector3::z();
        if normal.dot(&centre) > -0.4 * centre.norm() {
            return None;
        }
        let mut corners = [[0.0_f32; 2]; 4];
        for (corner, at) in corners.iter_mut().zip(tag_corners_in_tag(tag.size_m)) {
            let pixel = camera.lens.project(&(camera_from_tag * Point3::from(at)))?;
            let pixel = [pixel.x, pixel.y].map(|at| at + SIGMA_PX * self.random.normal());
            *corner = pixel.map(|pixels| pixels as f32);
        }
        let [width, height] = camera.resolution.map(|pixels| pixels as f32);
        let inside = |[x, y]: &[f32; 2]| (0.0..width).contains(x) && (0.0..height).contains(y);
        corners.iter().all(inside).then(|| TagObservation {
            family: tag.tag.family,
            id: tag.tag.id,
            hamming: 0,
            margin: 60.0,
            corners,
            corner_covariance: [[SIGMA_PX.powi(2) as f32, 0.0, SIGMA_PX.powi(2) as f32]; 4],
            corner_cross_covariance: [[0.0; 4]; 6],
            poses: Vec::new(),
        })
    }
}

/// Where the k-th cube is so many seconds after the start: it swings and turns, each in its own place and rhythm.
#[must_use]
pub fn place(k: usize, seconds: f64) -> Pose {
    let phase = k as f64;
    let around = std::f64::consts::TAU * phase / 5.0;
    let swing = |rhythm: f64| 0.08 * (rhythm * seconds + phase).sin();
    let at = Vector3::new(
        0.2 * around.cos() + swing(2.1),
        0.2 * around.sin() + swing(2.7),
        swing(1.7),
    );
    let turn = Vector3::new(
        0.6 * (1.3 * seconds).sin(),
        0.5 * (0.9 * seconds + phase).cos(),
        0.8 * seconds + phase,
    );
    Pose::from_parts(at.into(), UnitQuaternion::from_scaled_axis(turn))
}

/// World from a camera at a place, looking at the world's origin, its x level.
fn camera(k: usize, cameras: usize) -> Camera {
    let angle = std::f64::consts::TAU * k as f64 / cameras as f64;
    let place = Vector3::new(angle.cos(), angle.sin(), 0.7);
    let forward = -place.normalize();
    let right = forward.cross(&Vector3::z()).normalize();
    let rotation = Rotation3::from_basis_unchecked(&[right, forward.cross(&right), forward]);
    let turn = UnitQuaternion::from_rotation_matrix(&rotation);
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    };
    Camera::new(
        CameraId::new(&format!("cam{k}")).expect("an id"),
        [640, 480],
        Lens::pinhole(intrinsics).expect("a lens"),
        Some(Pose::from_parts(place.into(), turn)),
    )
}

/// A cube with a tag on each side, numbered from `first`.
fn cube(name: &str, first: u32) -> ObjectModel {
    let quarters: [(f64, f64); 6] = [
        (0.0, 0.0),
        (1.0, 0.0),
        (2.0, 0.0),
        (3.0, 0.0),
        (0.0, 1.0),
        (0.0, 3.0),
    ];
    let tag = |(id, (about_x, about_y)): (u32, (f64, f64))| {
        let quarter = std::f64::consts::FRAC_PI_2;
        let turn = UnitQuaternion::from_euler_angles(about_x * quarter, about_y * quarter, 0.0);
        let place = turn * Vector3::new(0.0, 0.0, EDGE_M / 2.0);
        ObjectTag::new(
            tag_of(id),
            TAG_M,
            Some(Pose::from_parts(place.into(), turn)),
        )
    };
    changed(name, (first..).zip(quarters).map(tag).collect())
}

/// The tag of that number.
#[must_use]
pub fn tag_of(id: u32) -> TagId {
    TagId {
        family: Family::Tag36h11,
        id,
    }
}

/// An object of these tags.
///
/// # Panics
/// When they make none.
#[must_use]
pub fn changed(name: &str, tags: Vec<ObjectTag>) -> ObjectModel {
    ObjectModel::new(ObjectId::new(name).expect("an id"), tags).expect("an object")
}
