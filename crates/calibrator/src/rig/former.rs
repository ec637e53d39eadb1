//! Comparison of a solved rig with the former one as a whole: larger or smaller, its cameras' names exchanged, or all
//! cameras turned about the reference.
//!
//! Each explanation has a closed form: with the former camera `p(i)` at the place of the solved camera `i`, the
//! rotation is the mean of the cameras' rotations and of the directions between their places, the scale a ratio of
//! those (S. Umeyama, Least-squares estimation of transformation parameters between two point patterns, 1991, with
//! attitudes). Explanations are compared by their evidence, where the sigmas of the former rig have a common unknown
//! factor, so that places by tape and places by calibration are both judged.

use super::origin::Origin;
use nalgebra::{Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_site_model::{CameraId, ObjectModel, PoseSigma, Rig};

/// Least sigma of a former pose, m and rad: smaller moves are no news.
const LEAST_SIGMA: PoseSigma = PoseSigma {
    position_m: 0.002,
    orientation_rad: 0.002,
};
/// Worth of the sigmas as they are given, in residuals.
const SIGMA_FREEDOM: f64 = 4.0;
/// Logarithms of the prior odds against a common scale, and against the exchange of each camera's name.
const SCALE_ODDS: f64 = 5.0;
const NAME_ODDS: f64 = 3.0;
/// Logarithm of the evidence that decides, beside the odds.
const DECISIVE: f64 = 7.0;
/// Most cameras of which every order is tried; of more, all exchanges of two.
const MOST_ORDERED: usize = 5;
/// Mean square of what is left, in sigmas, up to which former and solved rig are of one shape.
const OF_ONE_SHAPE: f64 = 9.0;
/// Names are exchanged, too, where less than this share of the squares is left.
const CLEARLY_LESS: f64 = 0.04;
/// A scale counts from so many of its standard deviations, and a turn from so many and from this angle, rad.
const SIGNIFICANT: f64 = 4.0;
const LEAST_TURN_RAD: f64 = 0.01;
/// One of two scales is clearly better known where its sigma is smaller by this factor.
const BETTER_KNOWN: f64 = 3.0;

/// How the former rig differs from the solved one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FormerDifference {
    /// Of each camera the one that formerly had its place.
    pub order: Vec<usize>,
    pub scale: Option<ScaleDifference>,
    /// By how much the other cameras turned about the reference, rad.
    pub turn_rad: Option<f64>,
}

/// A common scale between the former rig and the solved one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ScaleDifference {
    /// Former lengths by the solved ones.
    pub ratio: f64,
    /// Standard deviation of its logarithm by the places of the cameras.
    pub sigma: f64,
    /// Whether the carried object is at fault, not the former rig.
    pub is_of_object: bool,
}

/// A former camera pose with its sigma, of which only the places of those that have one are compared.
struct Pair {
    camera: usize,
    former: Pose,
    solved: Pose,
    sigma: PoseSigma,
}

/// `former = scale rotation solved + shift`, and what it leaves.
struct Alignment {
    rotation: UnitQuaternion<f64>,
    scale: f64,
    /// Sum of the squared residuals, in sigmas.
    squares: f64,
    /// Standard deviation of the scale's logarithm where the sigmas are right.
    scale_sigma: f64,
}

impl FormerDifference {
    /// Of a rig and the solved poses of its cameras in any frame; `None` where fewer than two cameras had a pose.
    pub(super) fn between(rig: &Rig, solved: &[Pose], object: &ObjectModel) -> Option<Self> {
        let pairs: Vec<Pair> = pairs(rig, solved);
        if pairs.len() < 2 {
            return None;
        }
        let n = 6 * pairs.len();
        let identity: Vec<usize> = (0..pairs.len()).collect();
        let candidates = orders(pairs.len()).into_iter().flat_map(|order| {
            let exchanged = order.iter().zip(&identity).filter(|(a, b)| a != b).count();
            [false, true].map(|is_scaled| {
                let aligned = Alignment::new(&pairs, &order, is_scaled);
                let odds = NAME_ODDS * exchanged as f64 + if is_scaled { SCALE_ODDS } else { 0.0 };
                (
                    log_evidence(aligned.squares, n) - odds,
                    order.clone(),
                    is_scaled,
                    aligned,
                )
            })
        });
        let rigid = Alignment::new(&pairs, &identity, false);
        let best = candidates.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let is_decisive = best.0 > log_evidence(rigid.squares, n) + DECISIVE;
        let is_one_shape = |found: &Alignment| found.squares < OF_ONE_SHAPE * n as f64;
        let fits = is_one_shape(&best.3) || best.3.squares < CLEARLY_LESS * rigid.squares;
        let (order, is_scaled, found) = match is_decisive && fits {
            true => (best.1, best.2, best.3),
            false => (identity.clone(), false, rigid),
        };
        let factor = sigma_factor(&pairs, found.squares, n, rig);
        let scale =
            (is_scaled && is_one_shape(&found)).then(|| found.difference(rig, object, factor));
        let turn_rad = found.rotation.angle();
        let attitude = pairs
            .iter()
            .map(|pair| pair.sigma.orientation_rad)
            .sum::<f64>()
            / pairs.len() as f64;
        let is_turned = turn_rad > (SIGNIFICANT * factor * attitude).max(LEAST_TURN_RAD)
            && order == identity
            && is_one_shape(&found);
        Some(Self {
            order: full_order(&pairs, &order, solved.len()),
            scale: scale.flatten(),
            turn_rad: is_turned.then_some(turn_rad),
        })
    }

    /// Whether the former rig is as the solved one.
    pub(super) fn is_none(&self) -> bool {
        self.scale.is_none() && self.turn_rad.is_none() && self.exchanged().is_empty()
    }

    /// Cameras that are not where they were, with those whose place they have.
    pub(super) fn exchanged(&self) -> Vec<(usize, usize)> {
        let order = self.order.iter().copied().enumerate();
        order.filter(|(camera, former)| camera != former).collect()
    }

    /// Factor on all lengths of the solved rig, and the sigma of their common scale, where the object is at fault.
    pub(super) fn correction(&self) -> Option<ScaleDifference> {
        self.scale.filter(|scale| scale.is_of_object)
    }
}

impl Alignment {
    fn new(pairs: &[Pair], order: &[usize], is_scaled: bool) -> Self {
        let former = |at: usize| &pairs[order[at]].former;
        let weight = |at: usize| pairs[order[at]].sigma.position_m.powi(-2);
        let all = || 0..pairs.len();
        let weights: f64 = all().map(weight).sum();
        let mean = |of: &dyn Fn(usize) -> Vector3<f64>| {
            all().map(|at| of(at) * weight(at)).sum::<Vector3<f64>>() / weights
        };
        let (from, to) = (
            |at: usize| pairs[at].solved.translation.vector,
            |at: usize| former(at).translation.vector,
        );
        let (middle, former_middle) = (mean(&from), mean(&to));
        let arm = |at: usize| from(at) - middle;
        let former_arm = |at: usize| to(at) - former_middle;
        let turns = all().map(|at| {
            let turn = former(at).rotation * pairs[at].solved.rotation.inverse();
            let by_places = former_arm(at) * arm(at).transpose() * weight(at);
            by_places
                + turn.to_rotation_matrix().matrix()
                    * pairs[order[at]].sigma.orientation_rad.powi(-2)
        });
        let rotation = nearest_rotation(&turns.sum());
        let spread: f64 = all().map(|at| weight(at) * arm(at).norm_squared()).sum();
        let product: f64 = all()
            .map(|at| weight(at) * former_arm(at).dot(&(rotation * arm(at))))
            .sum();
        let scale = match is_scaled && product > 0.0 {
            true => product / spread,
            false => 1.0,
        };
        let squares = all().map(|at| {
            let off = former_arm(at) - rotation * arm(at) * scale;
            let turn = (rotation * pairs[at].solved.rotation).angle_to(&former(at).rotation);
            weight(at) * off.norm_squared()
                + (turn / pairs[order[at]].sigma.orientation_rad).powi(2)
        });
        Self {
            squares: squares.sum(),
            rotation,
            scale,
            scale_sigma: spread.sqrt().recip(),
        }
    }

    /// The scale, if it is more than the former rig's places and the scales of both rigs may differ by.
    fn difference(&self, rig: &Rig, object: &ObjectModel, factor: f64) -> Option<ScaleDifference> {
        let sigma = factor * self.scale_sigma;
        let of_object = object.scale_sigma_or_usual();
        let of_rig = rig.scale_sigma().unwrap_or(0.0).hypot(sigma);
        let is_clear = self.scale.ln().abs() > SIGNIFICANT * of_object.hypot(of_rig);
        is_clear.then_some(ScaleDifference {
            ratio: self.scale,
            sigma,
            is_of_object: rig
                .scale_sigma()
                .is_none_or(|sigma| BETTER_KNOWN * sigma < of_object),
        })
    }
}

fn pairs(rig: &Rig, solved: &[Pose]) -> Vec<Pair> {
    let cameras = rig.cameras().iter().zip(solved).enumerate();
    let pairs = cameras.filter_map(|(camera, (former, solved))| {
        let sigma = former.pose_prior.sigma_or(PoseSigma::OF_CAMERA);
        Some(Pair {
            camera,
            former: former.world_from_camera?,
            solved: *solved,
            sigma: PoseSigma {
                position_m: sigma.position_m.max(LEAST_SIGMA.position_m),
                orientation_rad: sigma.orientation_rad.max(LEAST_SIGMA.orientation_rad),
            },
        })
    });
    pairs.collect()
}

/// Logarithm of the evidence of `n` residuals whose sigmas have an unknown common factor (Student's distribution).
fn log_evidence(squares: f64, n: usize) -> f64 {
    -0.5 * (n as f64 + SIGMA_FREEDOM) * (1.0 + squares / SIGMA_FREEDOM).ln()
}

/// Estimate of the common factor of the sigmas; given ones do not shrink.
fn sigma_factor(pairs: &[Pair], squares: f64, n: usize, rig: &Rig) -> f64 {
    let freedom = n as f64 - 7.0 + SIGMA_FREEDOM;
    let factor = ((squares + SIGMA_FREEDOM) / freedom.max(SIGMA_FREEDOM)).sqrt();
    let is_given = |pair: &Pair| rig.cameras()[pair.camera].pose_prior.given().is_some();
    match pairs.iter().any(is_given) {
        true => factor.max(1.0),
        false => factor,
    }
}

/// Orders that are tried: all of few cameras, exchanges of two of many.
fn orders(n: usize) -> Vec<Vec<usize>> {
    let identity: Vec<usize> = (0..n).collect();
    let mut orders = vec![identity.clone()];
    if n <= MOST_ORDERED {
        for at in 1..n {
            let longer = orders.iter().flat_map(|order| {
                (0..=at).map(move |with| {
                    let mut order = order.clone();
                    order.swap(at, with);
                    order
                })
            });
            orders = longer.collect();
        }
        return orders;
    }
    for a in 0..n {
        for b in a + 1..n {
            let mut order = identity.clone();
            order.swap(a, b);
            orders.push(order);
        }
    }
    orders
}

/// The order over all cameras of the rig.
fn full_order(pairs: &[Pair], order: &[usize], n: usize) -> Vec<usize> {
    let mut full: Vec<usize> = (0..n).collect();
    for (pair, &former) in pairs.iter().zip(order) {
        full[pair.camera] = pairs[former].camera;
    }
    full
}

/// The rotation nearest to a sum of rotations and products of directions.
fn nearest_rotation(sum: &Matrix3<f64>) -> UnitQuaternion<f64> {
    let svd = sum.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return UnitQuaternion::identity();
    };
    let mirror = Vector3::new(1.0, 1.0, (u * v_t).determinant().signum());
    let nearest = u * Matrix3::from_diagonal(&mirror) * v_t;
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(nearest))
}

impl Origin {
    /// The camera that keeps its former pose, if one does.
    fn kept_camera(&self, rig: &Rig) -> Option<usize> {
        match self {
            Self::FirstCamera | Self::Camera(_) => Some(self.reference(rig)),
            Self::Levelled(frame, _) => frame.kept_camera(rig),
            Self::Tag(..) | Self::ThreeTags(..) => None,
        }
    }

    /// Poses of the cameras in the world by the explanation of the difference: lengths are the former ones where the
    /// object is at fault, and the camera that keeps its pose keeps that of the place where it is.
    pub(super) fn explained(
        &self,
        rig: &Rig,
        adjusted: &[Pose],
        world_from_adjusted: Pose,
        difference: Option<&FormerDifference>,
    ) -> Vec<Pose> {
        let kept = self.kept_camera(rig);
        let moved = kept.zip(difference).and_then(|(kept, difference)| {
            let place = rig.cameras()[difference.order[kept]].world_from_camera?;
            let is_there = difference.order[kept] == kept;
            (!is_there).then(|| place * adjusted[kept].inverse())
        });
        let world = world_from_adjusted * moved.unwrap_or_default();
        let ratio = difference
            .and_then(FormerDifference::correction)
            .map_or(1.0, |scale| scale.ratio);
        let fixed = kept.map_or_else(Point3::origin, |kept| {
            Point3::from((world * adjusted[kept]).translation.vector)
        });
        let scaled = |pose: &Pose| {
            let mut pose = world * pose;
            let from_fixed = pose.translation.vector - fixed.coords;
            pose.translation = Translation3::from(fixed.coords + from_fixed * ratio);
            pose
        };
        adjusted.iter().map(scaled).collect()
    }
}

/// Names of the cameras of each exchange: of two that have each other's place, or of more in a circle.
pub(super) fn circles(rig: &Rig, order: &[usize]) -> Vec<Vec<CameraId>> {
    let mut found: Vec<Vec<usize>> = Vec::new();
    for first in 0..order.len() {
        if order[first] == first || found.iter().flatten().any(|known| *known == first) {
            continue;
        }
        let next = |camera: &usize| Some(order[*camera]).filter(|next| *next != first);
        found.push(std::iter::successors(Some(first), next).collect());
    }
    let id = |camera: usize| rig.cameras()[camera].id.clone();
    let named = found
        .into_iter()
        .map(|circle| circle.into_iter().map(id).collect());
    named.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry3, Vector6};
    use sextant_geometry::{Intrinsics, Lens, se3};
    use sextant_site_model::{Camera, ObjectId, ObjectTag, TagId};

    fn object() -> ObjectModel {
        let tag = TagId {
            family: sextant_tag_families::Family::Tag36h11,
            id: 0,
        };
        let tag = ObjectTag::new(tag, 0.04, Some(Pose::identity()));
        ObjectModel::new(ObjectId::new("thing").unwrap(), vec![tag]).unwrap()
    }

    /// Cameras on a ring of 1.1 m that look at its middle.
    fn ring(n: usize) -> Vec<Pose> {
        let pose = |at: usize| {
            // Of three alike any two may have exchanged their names.
            let wobble = if n == 4 { 0.0 } else { 0.3 * (at as f64).sin() };
            let angle = 2.0 * std::f64::consts::PI * at as f64 / n as f64 + wobble;
            let eye = Vector3::new(1.1 * angle.cos(), 1.1 * angle.sin(), 0.6);
            let turn = UnitQuaternion::face_towards(&-eye, &Vector3::z());
            Isometry3::from_parts(eye.into(), turn)
        };
        (0..n).map(pose).collect()
    }

    /// A rig by hand and tape, 3 mm and .2 degrees off.
    fn former(poses: &[Pose]) -> Rig {
        let noise = |at: usize| {
            let wave = |k: usize| (1.7 * (6 * at + k) as f64 + 0.4).sin() * 1.4;
            Vector6::from_fn(|k, _| wave(k) * if k < 3 { 0.003 } else { 0.0035 })
        };
        let numbers = Intrinsics {
            fx: 600.0,
            fy: 600.0,
            cx: 319.5,
            cy: 239.5,
        };
        let cameras = poses.iter().enumerate().map(|(at, pose)| {
            let id = CameraId::new(&format!("cam{at}")).unwrap();
            let pose = se3::perturb(pose, &noise(at));
            Camera::new(id, [640, 480], Lens::pinhole(numbers).unwrap(), Some(pose))
        });
        Rig::new(cameras.collect()).unwrap()
    }

    fn scaled(poses: &[Pose], ratio: f64) -> Vec<Pose> {
        let scaled = poses.iter().map(|pose| {
            let mut pose = *pose;
            pose.translation.vector *= ratio;
            pose
        });
        scaled.collect()
    }

    fn found(rig: &Rig, solved: &[Pose]) -> FormerDifference {
        FormerDifference::between(rig, solved, &object()).unwrap()
    }

    #[test]
    fn a_rig_as_before_has_no_difference() {
        for n in 2..7 {
            assert!(found(&former(&ring(n)), &ring(n)).is_none(), "{n}");
        }
    }

    #[test]
    fn an_object_at_another_scale_is_at_fault_where_places_were_measured() {
        for ratio in [0.95, 0.97, 1.03] {
            let rig = former(&ring(4));
            let difference = found(&rig, &scaled(&ring(4), 1.0 / ratio));
            let scale = difference.correction().unwrap();
            assert!(
                (scale.ratio / ratio).ln().abs() < 3.0 * scale.sigma,
                "{scale:?}"
            );
            assert!(scale.sigma < 0.005 && difference.exchanged().is_empty());
            let rig = rig.with_scale_sigma(Some(0.005)).unwrap();
            let open = found(&rig, &scaled(&ring(4), 1.0 / ratio)).scale;
            assert!(
                ratio > 0.96 || open.is_some_and(|scale| !scale.is_of_object),
                "{open:?}"
            );
        }
        let near = found(&former(&ring(4)), &scaled(&ring(4), 0.995));
        assert_eq!(near.scale, None);
    }

    #[test]
    fn exchanged_names_are_found_and_the_world_stays() {
        for n in 3..7 {
            let truth = ring(n);
            let mut as_filed = truth.clone();
            as_filed.swap(0, 1);
            let rig = former(&as_filed);
            // The adjustment keeps the first camera where the file has it.
            let moved = as_filed[0] * truth[0].inverse();
            let solved: Vec<Pose> = truth.iter().map(|pose| moved * pose).collect();
            let difference = found(&rig, &solved);
            assert_eq!(difference.exchanged(), [(0, 1), (1, 0)], "{n}");
            let poses =
                Origin::FirstCamera.explained(&rig, &solved, Pose::identity(), Some(&difference));
            for (pose, truth) in poses.iter().zip(&truth) {
                assert!(se3::difference(pose, truth).norm() < 0.03);
            }
        }
    }

    #[test]
    fn a_reference_that_turned_is_named_and_cameras_that_moved_are_not() {
        let rig = former(&ring(4));
        let turn = Isometry3::rotation(Vector3::new(0.02, 0.03, -0.04));
        let solved: Vec<Pose> = ring(4).iter().map(|pose| turn * pose).collect();
        assert!(found(&rig, &solved).turn_rad.is_some());
        let mut solved = ring(4);
        for (at, pose) in solved.iter_mut().enumerate().skip(1) {
            let away = Vector3::new(0.2, -0.1 * at as f64, 0.15);
            *pose = Isometry3::new(away, Vector3::new(0.1, -0.05 * at as f64, 0.2)) * *pose;
        }
        assert!(found(&rig, &solved).is_none(), "{:?}", found(&rig, &solved));
        let mut solved = ring(4);
        solved[2] = Isometry3::new(Vector3::new(0.1, 0.0, 0.05), Vector3::zeros()) * solved[2];
        assert!(found(&rig, &solved).is_none(), "{:?}", found(&rig, &solved));
    }
}
