//! `--frame robot.toml`: poses in the frame of a robot's base instead of the world.

use nalgebra::{Matrix3, Matrix6, Vector3};
use sextant_geometry::{Pose, so3};
use sextant_process::{Exit, WithExit};
use sextant_site_files::{UncertainPose, read_robot};
use sextant_site_report::ObjectEstimate;
use std::path::Path;

/// The frame in which poses are given.
pub struct OutputFrame(Option<UncertainPose>);

impl OutputFrame {
    /// The base of the robot of a file; the world without one.
    ///
    /// # Errors
    /// [`Exit::Input`] for a file that cannot be used.
    pub fn read(file: Option<&Path>) -> anyhow::Result<Self> {
        let robot = file.map(read_robot).transpose().exit_with(Exit::Input)?;
        Ok(Self(robot.map(|robot| robot.base_from_world)))
    }

    /// A pose in this frame. Its covariance has that of the base as well.
    pub fn transform(&self, estimate: ObjectEstimate) -> ObjectEstimate {
        let Some(base) = &self.0 else { return estimate };
        let mut moved = estimate;
        moved.covariance = covariance(base, &moved.world_from_object, &moved.covariance);
        moved.world_from_object = base.pose * moved.world_from_object;
        moved.twist = blocks(base) * moved.twist;
        for link in moved.articulated.iter_mut().flat_map(|it| &mut it.links) {
            link.covariance = covariance(base, &link.world_from_link, &link.covariance);
            link.world_from_link = base.pose * link.world_from_link;
        }
        moved
    }
}

/// The base's rotation for translations and rotations.
fn blocks(base: &UncertainPose) -> Matrix6<f64> {
    let rotation: Matrix3<f64> = *base.pose.rotation.to_rotation_matrix().matrix();
    let mut blocks = Matrix6::zeros();
    blocks.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
    blocks.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
    blocks
}

/// With p' = exp(r) R p + t + d, an error (d, r) of the base moves the position by d - (R p) x r and turns the attitude
/// by r.
fn covariance(base: &UncertainPose, pose: &Pose, covariance: &Matrix6<f64>) -> Matrix6<f64> {
    let lever: Vector3<f64> = base.pose.rotation * pose.translation.vector;
    let mut by_base = Matrix6::identity();
    by_base
        .fixed_view_mut::<3, 3>(0, 3)
        .copy_from(&-so3::hat(&lever));
    let blocks = blocks(base);
    blocks * covariance * blocks.transpose() + by_base * base.covariance * by_base.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector6;
    use sextant_geometry::se3;
    use sextant_simulator::Random;
    use sextant_site_model::ObjectId;
    use sextant_site_report::State;

    #[test]
    fn the_covariance_is_that_of_displaced_bases_and_poses() {
        let base = UncertainPose {
            pose: Pose::new(Vector3::new(0.3, -0.2, 0.9), Vector3::new(0.4, -1.0, 2.0)),
            covariance: Matrix6::from_diagonal(&Vector6::new(1.0, 4.0, 2.0, 9.0, 1.0, 3.0)) * 1e-8,
        };
        let estimate = ObjectEstimate {
            object: ObjectId::new("cube").unwrap(),
            capture_ns: 1,
            world_from_object: Pose::new(Vector3::new(1.0, 2.0, -0.5), Vector3::new(0.1, 0.7, 0.2)),
            covariance: Matrix6::from_diagonal(&Vector6::new(2.0, 1.0, 1.0, 5.0, 2.0, 1.0)) * 1e-8,
            twist: Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 2.0),
            state: State::Tracking,
            cameras: 1,
            tags: 1,
            rms_px: 0.1,
            articulated: None,
        };
        let moved = OutputFrame(Some(base)).transform(estimate.clone());
        let mut random = Random::new(7);
        let mut sampled = Matrix6::zeros();
        const N: usize = 20_000;
        for _ in 0..N {
            let mut step = |covariance: &Matrix6<f64>| {
                Vector6::from_fn(|k, _| random.normal() * covariance[(k, k)].sqrt())
            };
            let base_step = step(&base.covariance);
            let pose_step = step(&estimate.covariance);
            let seen = se3::perturb(&base.pose, &base_step)
                * se3::perturb(&estimate.world_from_object, &pose_step);
            let off = se3::difference(&seen, &moved.world_from_object);
            sampled += off * off.transpose() / N as f64;
        }
        let scale = moved.covariance.diagonal().map(f64::sqrt);
        let off = (sampled - moved.covariance).component_div(&(scale * scale.transpose()));
        assert!(off.amax() < 0.05, "{off}");
        assert!((moved.twist.norm() - estimate.twist.norm()).abs() < 1e-12);
        assert_eq!(OutputFrame(None).transform(estimate.clone()), estimate);
    }
}
