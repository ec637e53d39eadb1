//! A simulated board in a person's hands, on purpose with its own arithmetic and its own random numbers.

use nalgebra::{Matrix2, Point2, Point3, UnitQuaternion, Vector3};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_site_model::{
    CameraId, ImageObservation, ObjectId, ObjectModel, ObjectTag, TagCorners, TagId,
};
use sextant_tag_families::Family;

const SIZE: f64 = 0.028;
const PITCH: f64 = 0.038;

/// What is held, how, and what goes wrong.
pub(super) struct BoardWalk {
    lens: Lens,
    seed: u64,
    pub images: usize,
    /// Largest tilt about each axis, radians.
    pub tilt: f64,
    /// Least and largest distance from a lens of 600 pixels, metres.
    pub depth: [f64; 2],
    /// Part of the tags that lie anywhere.
    pub wrong: f64,
    /// Part of the tags that are not seen.
    pub missing: f64,
    /// How far the board's middle lies behind its rim, metres: it is bent to a cylinder.
    pub bend_m: f64,
    /// Standard deviation of the focal length from image to image, as a share of it: a lens that focuses.
    pub breathing: f64,
    /// A tag of this id is also somewhere else, where the detector sees it instead.
    pub second_of: Option<u32>,
}

pub(super) fn ordinary() -> Lens {
    let numbers = Intrinsics {
        fx: 603.0,
        fy: 605.0,
        cx: 325.0,
        cy: 236.0,
    };
    Lens::brown_conrady(numbers, [-0.28, 0.09, 0.0006, -0.0004, -0.01]).unwrap()
}

pub(super) fn fisheye() -> Lens {
    let numbers = Intrinsics {
        fx: 290.0,
        fy: 291.0,
        cx: 322.0,
        cy: 238.0,
    };
    Lens::kannala_brandt(numbers, [0.03, -0.01, 0.004, -0.001]).unwrap()
}

/// 5 x 6 tags; sizes and places enlarged as said.
pub(super) fn board(sizes: f64, places: f64) -> ObjectModel {
    let tags = (0..30_u32).map(|id| {
        let (column, row) = (f64::from(id % 5), f64::from(id / 5));
        ObjectTag::new(
            TagId {
                family: Family::Tag36h11,
                id,
            },
            SIZE * sizes,
            Some(Pose::translation(
                (column - 2.0) * PITCH * places,
                (2.5 - row) * PITCH * places,
                0.0,
            )),
        )
    });
    ObjectModel::new(ObjectId::new("board").unwrap(), tags.collect()).unwrap()
}

/// splitmix64.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn about_zero(&mut self, largest: f64) -> f64 {
        largest * (2.0 * self.unit() - 1.0)
    }

    fn normal(&mut self) -> f64 {
        let (u, v) = (1.0 - self.unit(), self.unit());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }
}

impl BoardWalk {
    pub(super) fn new(lens: Lens, seed: u64) -> Self {
        Self {
            lens,
            seed,
            images: 30,
            tilt: 0.75,
            depth: [0.28, 0.53],
            wrong: 0.0,
            missing: 0.0,
            bend_m: 0.0,
            breathing: 0.0,
            second_of: None,
        }
    }

    pub(super) fn images(&self) -> Vec<ImageObservation> {
        let mut random = Random(self.seed);
        (0..self.images)
            .map(|at| self.image(at, &mut random))
            .collect()
    }

    fn image(&self, at: usize, random: &mut Random) -> ImageObservation {
        let camera_from_board = self.pose(random);
        let lens = self.breathed(random);
        let tags = (0..30_u32).filter_map(|id| {
            let mut corners = self.corners(&lens, &camera_from_board, id, random)?;
            if random.unit() < self.missing {
                return None;
            }
            if random.unit() < self.wrong || self.second_of == Some(id) {
                let elsewhere =
                    Point2::new(40.0 + 500.0 * random.unit(), 40.0 + 360.0 * random.unit());
                let away = elsewhere - corners[0];
                corners = corners.map(|c| c + away);
                let inside =
                    |c: &Point2<f64>| (0.0..=639.0).contains(&c.x) && (0.0..=479.0).contains(&c.y);
                corners.iter().all(inside).then_some(())?;
            }
            Some(TagCorners {
                tag: TagId {
                    family: Family::Tag36h11,
                    id,
                },
                corners,
                corner_covariance: [Matrix2::zeros(); 4],
                corner_cross_covariance: [Matrix2::zeros(); 6],
            })
        });
        ImageObservation {
            camera: CameraId::new("north").unwrap(),
            capture_ns: at as u64 * 100_000_000,
            clock_error_ns: ImageObservation::CLOCK_ERROR_UNKNOWN,
            exposure_ns: 0,
            resolution: None,
            tags: tags.collect(),
        }
    }

    /// The lens in one image.
    fn breathed(&self, random: &mut Random) -> Lens {
        if self.breathing == 0.0 {
            return self.lens;
        }
        let mut parameters = self.lens.parameters();
        let factor = 1.0 + self.breathing * random.normal();
        parameters[0] *= factor;
        parameters[1] *= factor;
        self.lens.with_parameters(&parameters).unwrap()
    }

    /// Somewhere in the picture, facing the camera but for the tilt.
    fn pose(&self, random: &mut Random) -> Pose {
        let focal = self.lens.intrinsics().fx;
        let [nearest, furthest] = self.depth;
        let depth = (nearest + (furthest - nearest) * random.unit()) * focal / 600.0;
        let pixel = Point2::new(130.0 + 380.0 * random.unit(), 110.0 + 260.0 * random.unit());
        let ray = self.lens.unproject(&pixel).unwrap();
        let facing = UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::PI);
        let tilt = Vector3::new(
            random.about_zero(self.tilt),
            random.about_zero(self.tilt),
            random.about_zero(0.5),
        );
        // Parallel to the picture's plane without tilt.
        Pose::from_parts(
            (ray * (depth / ray.z)).into(),
            UnitQuaternion::from_scaled_axis(tilt) * facing,
        )
    }

    /// Noisy corners, where the whole tag is in the picture.
    fn corners(
        &self,
        lens: &Lens,
        camera_from_board: &Pose,
        id: u32,
        random: &mut Random,
    ) -> Option<[Point2<f64>; 4]> {
        let middle = [
            (f64::from(id % 5) - 2.0) * PITCH,
            (2.5 - f64::from(id / 5)) * PITCH,
        ];
        let half = SIZE / 2.0;
        let mut corners = [Point2::origin(); 4];
        for (corner, [x, y]) in
            corners
                .iter_mut()
                .zip([[-half, half], [half, half], [half, -half], [-half, -half]])
        {
            let on_board = Point3::new(middle[0] + x, middle[1] + y, 0.0);
            let from_rim = (on_board.y / (2.5 * PITCH + half)).powi(2) - 1.0;
            let on_board = on_board + Vector3::z() * (self.bend_m * from_rim);
            let pixel = lens.project(&(camera_from_board * on_board))?;
            let inside = (0.0..=639.0).contains(&pixel.x) && (0.0..=479.0).contains(&pixel.y);
            inside.then_some(())?;
            *corner = Point2::new(
                pixel.x + 0.1 * random.normal(),
                pixel.y + 0.1 * random.normal(),
            );
        }
        Some(corners)
    }
}
