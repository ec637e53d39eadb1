//! Errors of poses against a reference: position, attitude, and whether the covariance is as large as they are.

use crate::alignment::PosePairs;
use crate::error::{Consistency, PoseError, Spread};
use crate::reference::{References, Trajectory};
use serde::Serialize;
use sextant_geometry::Pose;
use sextant_site_model::ObjectId;
use sextant_site_report::ObjectEstimate;
use std::collections::BTreeMap;

/// Which motion is allowed between the worlds of estimate and reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Alignment {
    /// None: both have the same world frame.
    None,
    /// The rigid motion of the whole world that fits the poses of all objects best.
    Rigid,
}

/// The error of one pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedError {
    /// Capture time, ns.
    pub t_ns: u64,
    /// Distance of the origins, m, and its published standard deviation (all axes together).
    pub position_m: [f64; 2],
    /// Angle between the attitudes, rad, and its published standard deviation.
    pub attitude_rad: [f64; 2],
    /// Normalised estimation error squared, six degrees of freedom; none where the covariance is singular.
    pub nees: Option<f64>,
}

/// The errors of one object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectComparison {
    /// The object.
    pub object: ObjectId,
    /// Poses with a reference, of all.
    pub compared: usize,
    /// Poses without a reference at their time.
    pub without_reference: usize,
    /// Distance of the origins, mm.
    pub position_mm: Spread,
    /// Angle between the attitudes, degrees.
    pub attitude_deg: Spread,
    /// Mean NEES: 6 where covariances are right, more where they are too small.
    pub nees: f64,
    /// Share of poses within the 95 % region of their covariance.
    pub within_95: f64,
    /// Every error, in order of time.
    #[serde(skip)]
    pub errors: Vec<TimedError>,
}

/// Compares poses with references; objects without any are left out.
pub fn compare(
    poses: &[ObjectEstimate],
    references: &References,
    alignment: Alignment,
) -> Vec<ObjectComparison> {
    let mut by_object: BTreeMap<&ObjectId, Vec<&ObjectEstimate>> = BTreeMap::new();
    for pose in poses {
        by_object.entry(&pose.object).or_default().push(pose);
    }
    let estimated_from_true = match alignment {
        Alignment::None => Pose::identity(),
        Alignment::Rigid => best_motion(poses, references),
    };
    let objects = by_object.into_iter().filter_map(|(object, poses)| {
        let reference = references.get(object)?;
        ObjectComparison::for_object(&poses, reference, &estimated_from_true)
    });
    objects.collect()
}

fn best_motion(poses: &[ObjectEstimate], references: &References) -> Pose {
    let mut pairs = PosePairs::default();
    for pose in poses {
        let reference = references.get(&pose.object);
        if let Some(truth) = reference.and_then(|reference| reference.at(pose.capture_ns)) {
            // All at one time, so that none is forgotten.
            pairs.add(0, &pose.world_from_object, &[0.0; 36], &truth);
        }
    }
    PosePairs::alignment(std::iter::once(&pairs)).unwrap_or_else(Pose::identity)
}

impl ObjectComparison {
    fn for_object(
        poses: &[&ObjectEstimate],
        reference: &Trajectory,
        estimated_from_true: &Pose,
    ) -> Option<Self> {
        let errors = poses.iter().filter_map(|pose| {
            let truth = estimated_from_true * reference.at(pose.capture_ns)?;
            Some(TimedError::from_estimate(pose, &truth))
        });
        let errors: Vec<TimedError> = errors.collect();
        let mut consistency = Consistency::default();
        let nees = errors.iter().filter_map(|error| error.nees);
        nees.for_each(|nees| consistency.add(nees));
        Some(Self {
            object: poses.first()?.object.clone(),
            compared: errors.len(),
            without_reference: poses.len() - errors.len(),
            position_mm: Spread::from_values(errors.iter().map(|error| error.position_m[0] * 1e3))?,
            attitude_deg: Spread::from_values(
                errors
                    .iter()
                    .map(|error| error.attitude_rad[0].to_degrees()),
            )?,
            nees: consistency.mean_nees(),
            within_95: consistency.within_95(),
            errors,
        })
    }
}

impl TimedError {
    fn from_estimate(estimate: &ObjectEstimate, truth: &Pose) -> Self {
        let error = PoseError::between(&estimate.world_from_object, truth);
        let covariance = &estimate.covariance;
        let sigma = |first: usize| {
            (first..first + 3)
                .map(|k| covariance[(k, k)])
                .sum::<f64>()
                .sqrt()
        };
        Self {
            t_ns: estimate.capture_ns,
            position_m: [error.position_m(), sigma(0)],
            attitude_rad: [error.attitude_rad(), sigma(3)],
            nees: error.nees(covariance),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference;
    use nalgebra::{Matrix6, Vector3};
    use sextant_geometry::so3;
    use sextant_site_report::State;

    fn estimate(t_ns: u64, world_from_object: Pose) -> ObjectEstimate {
        ObjectEstimate {
            object: ObjectId::new("cube").unwrap(),
            capture_ns: t_ns,
            world_from_object,
            covariance: Matrix6::from_diagonal_element(1e-6),
            twist: Default::default(),
            state: State::Tracking,
            cameras: 1,
            tags: 1,
            rms_px: 0.0,
            articulated: None,
        }
    }

    fn truth(t_ns: u64) -> Pose {
        let s = t_ns as f64 * 1e-9;
        Pose::new(Vector3::new(s, s * s, 0.3), Vector3::new(0.1, s, -0.2))
    }

    fn references() -> (tempfile::TempDir, References) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("cube.tum");
        let lines = (0..20)
            .map(|k| sextant_recordings::tum_line(k * 50_000_000, &truth(k * 50_000_000)) + "\n");
        std::fs::write(&file, lines.collect::<String>()).unwrap();
        let objects = [ObjectId::new("cube").unwrap()].into();
        let references = reference::read(&[file], &objects).unwrap();
        (folder, references)
    }

    #[test]
    fn an_error_of_one_sigma_an_axis_has_a_nees_of_six() {
        let (_folder, references) = references();
        let off = Pose::new(Vector3::repeat(1e-3), Vector3::zeros());
        let poses: Vec<_> = (0..20)
            .map(|k| {
                let true_pose = truth(k * 50_000_000);
                let mut pose = true_pose;
                pose.translation.vector += off.translation.vector;
                pose.rotation = so3::exp(&Vector3::repeat(1e-3)) * true_pose.rotation;
                estimate(k * 50_000_000, pose)
            })
            .collect();
        let [one] = &compare(&poses, &references, Alignment::None)[..] else {
            panic!("one object");
        };
        assert_eq!((one.compared, one.without_reference), (20, 0));
        assert!((one.nees - 6.0).abs() < 1e-3, "{}", one.nees);
        assert!((one.position_mm.rms - 3_f64.sqrt()).abs() < 1e-3);
        assert_eq!(one.within_95, 1.0);
    }

    #[test]
    fn another_world_frame_is_aligned_away_where_that_is_wanted() {
        let (_folder, references) = references();
        let motion = Pose::new(Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.3, 0.2, -0.4));
        let poses = (0..20).map(|k| estimate(k * 50_000_000, motion * truth(k * 50_000_000)));
        let poses: Vec<_> = poses.collect();
        let rms = |alignment| compare(&poses, &references, alignment)[0].position_mm.rms;
        assert!(rms(Alignment::None) > 1000.0);
        assert!(rms(Alignment::Rigid) < 1e-3, "{}", rms(Alignment::Rigid));
    }
}
